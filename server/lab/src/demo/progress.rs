//! Progress of the demonstration on stderr: a bar on a terminal, else one line per step.

use indicatif::{ProgressBar, ProgressStyle};
use std::cell::RefCell;
use std::io::{IsTerminal, Write};
use std::time::Duration;

/// Number of steps of a run with a bake; a run that finds its database skips some.
const STEPS: u64 = 20;

/// Progress display.
pub(super) struct DemoProgress {
    /// Progress bar; `None` if stderr is not a terminal.
    terminal: Option<ProgressBar>,
    /// Name of the step that was shown last.
    shown: RefCell<String>,
}

impl DemoProgress {
    pub fn new() -> Self {
        Self { terminal: std::io::stderr().is_terminal().then(bar), shown: RefCell::default() }
    }

    /// Begins the next step, or continues the one of the same name.
    pub fn step(&self, what: &str) {
        if self.shown.replace(what.to_owned()) == what {
            return;
        }
        match &self.terminal {
            Some(bar) => {
                bar.inc(1);
                bar.set_message(what.to_owned());
            }
            // Without a reader of stderr the demonstration continues.
            None => {
                let _ = writeln!(std::io::stderr(), "shatterd: {what}");
            }
        }
    }

    pub fn finish(&self) {
        if let Some(bar) = &self.terminal {
            bar.finish_and_clear();
        }
    }
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::new(STEPS);
    if let Ok(style) = ProgressStyle::with_template("{bar:24} {msg} ({elapsed})") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}
