//! Progress display on stderr; none if stderr is not a terminal.

use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

/// Number of steps of a run with a bake; a run that finds its database skips some.
const STEPS: u64 = 20;

/// Progress bar with a message.
pub(super) struct DemoProgress(ProgressBar);

impl DemoProgress {
    pub fn new() -> Self {
        let bar = ProgressBar::new(STEPS);
        if let Ok(style) = ProgressStyle::with_template("{bar:24} {msg} ({elapsed})") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(100));
        Self(bar)
    }

    /// Begins the next step.
    pub fn step(&self, what: &str) {
        self.0.inc(1);
        self.0.set_message(what.to_owned());
    }

    pub fn finish(&self) {
        self.0.finish_and_clear();
    }
}
