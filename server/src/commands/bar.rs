//! The progress bar of baking.

use indicatif::{ProgressBar, ProgressStyle};
use shatter_fracture::database::Step;
use std::time::Duration;

/// A bar on stderr; silent where that is not a terminal.
pub struct Bar(ProgressBar);

impl Bar {
    /// At the beginning.
    pub fn new() -> Self {
        let bar = ProgressBar::new(7);
        if let Ok(style) = ProgressStyle::with_template("{bar:24} {pos}/{len} {msg} ({elapsed}, {eta} left)") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(100));
        Self(bar)
    }

    /// Shows that `step` begins, or how far the examples are.
    pub fn show(&self, step: Step) {
        self.0.set_message(describe(step));
        match step {
            Step::Examples { done, of } => {
                self.0.set_length(of);
                self.0.set_position(done);
            }
            _ => self.0.inc(1),
        }
    }

    /// Shows what is done now.
    pub fn say(&self, what: &'static str) {
        self.0.set_message(what);
    }

    /// Removes it.
    pub fn finish(&self) {
        self.0.finish_and_clear();
    }
}

impl Default for Bar {
    fn default() -> Self {
        Self::new()
    }
}

fn describe(step: Step) -> String {
    match step {
        Step::Surface => "surface: weld, orient, name defects".to_owned(),
        Step::Volume => "volume: winding numbers".to_owned(),
        Step::Lattices => "lattices".to_owned(),
        Step::Lift(body) => format!("lift of body {body}"),
        Step::Elasticity(body) => format!("elasticity of body {body}"),
        Step::Reduction => "reduced elasticity".to_owned(),
        Step::Calibration => "calibration of the degree".to_owned(),
        Step::Examples { .. } => "examples".to_owned(),
    }
}
