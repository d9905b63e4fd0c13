//! Where a run is, on stderr; nothing where that is not a terminal.

use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

/// Steps of a whole run with a bake; a run that finds its database jumps.
const STEPS: u64 = 20;

/// A bar with a message.
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

    /// The next step begins.
    pub fn step(&self, what: &str) {
        self.0.inc(1);
        self.0.set_message(what.to_owned());
    }

    pub fn finish(&self) {
        self.0.finish_and_clear();
    }
}
