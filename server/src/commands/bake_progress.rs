//! Progress of a bake: a bar on a terminal, occasional lines in a log.

use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use shatter_fracture::database::{BakeSize, BakeStep};
use shatter_proto::text::counted;
use std::cell::RefCell;
use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

/// Interval between progress lines of the examples without a terminal.
const REPORT_INTERVAL: Duration = Duration::from_secs(30);

/// Number of stages of a bake without examples; see [`rank`].
const STAGES: u64 = 7;

/// Progress display on stderr.
pub struct BakeProgress {
    object: String,
    begun: Instant,
    state: RefCell<BakeCourse>,
    /// Progress bar; `None` if stderr is not a terminal.
    terminal: Option<ProgressBar>,
}

impl BakeProgress {
    /// Creates the display for a bake of `object` with that many examples.
    pub fn new(object: &str, examples: u64) -> Self {
        let terminal = std::io::stderr().is_terminal().then(terminal);
        let state = RefCell::new(BakeCourse::new(examples));
        Self { object: object.to_owned(), begun: Instant::now(), state, terminal }
    }

    /// Shows that `step` begins, or how many examples are done. Prints an estimate of the remaining cost as soon as it is known.
    pub fn show(&self, step: BakeStep) {
        if let BakeStep::Sized(size) = step {
            return self.note(&cost(&size, rayon::current_num_threads()));
        }
        if examples(step).is_some_and(|[_, of]| of == 0) {
            return;
        }
        self.report(rank(step), &describe(step), examples(step));
    }

    /// Shows the name of the last stage.
    pub fn show_step(&self, what: &str) {
        self.report(STAGES - 1, what, None);
    }

    /// Removes the progress bar.
    pub fn finish(&self) {
        if let Some(bar) = &self.terminal {
            bar.finish_and_clear();
        }
    }

    /// Prints a line that stays.
    fn note(&self, what: &str) {
        let line = format!("shatterd: {}: {what}", self.object);
        match &self.terminal {
            Some(bar) => bar.println(line),
            // Without a reader of stderr the bake continues.
            None => {
                let _ = writeln!(std::io::stderr(), "{line}");
            }
        }
    }

    fn report(&self, rank: u64, what: &str, examples: Option<[u64; 2]>) {
        let mut state = self.state.borrow_mut();
        let reported = state.report(rank, what, examples, self.begun.elapsed());
        if let Some(bar) = &self.terminal {
            bar.set_length(state.length());
            bar.set_position(state.position);
            bar.set_message(format!("{what}{}", reported.left));
        } else if reported.due {
            // Without a reader of stderr the bake continues.
            let _ = writeln!(std::io::stderr(), "shatterd: {}: {}", self.object, reported.line(what));
        }
    }
}

/// Estimate of the remaining time of a bake on that many threads, and of the memory of the object.
fn cost(size: &BakeSize, threads: usize) -> String {
    let BakeSize { elastic_nodes, crack_nodes, examples, exact_triangles, quadratic_nodes, .. } = size;
    let order = if *quadratic_nodes > 0 { " (quadratic elements)" } else { "" };
    let [least, most] = size.seconds(threads).map(|seconds| seconds.round().max(1.0) as u64);
    let seconds = if least == most { format!("{most} s") } else { format!("{least} to {most} s") };
    let examples = counted(*examples, "example");
    let hard =
        if *exact_triangles > 0 { ". An input surface that is hard to mesh takes up to a minute more" } else { "" };
    let megabytes = |bytes: u64| super::size::rounded(bytes as f64 / 1e6);
    let (peak, [least, most]) = (megabytes(size.peak_bytes()), size.held_bytes().map(megabytes));
    let held = if least == most { format!("about {most}") } else { format!("{least} to {most}") };
    format!(
        "{elastic_nodes} elastic{order} and {crack_nodes} crack nodes, {examples}: about {seconds} left on an idle machine, {peak} MB at most; a \
         daemon will hold {held} MB for it{hard}"
    )
}

fn terminal() -> ProgressBar {
    let bar = ProgressBar::new(STAGES);
    if let Ok(style) = ProgressStyle::with_template("{bar:24} {pos}/{len} {msg} ({elapsed})") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

/// Progress counter: counts examples if there are any, else stages. Takes the time as an argument.
struct BakeCourse {
    examples: u64,
    position: u64,
    /// Time at which the examples began, and how many were done before.
    paced: Option<(Duration, u64)>,
    /// Text and time of the last line.
    reported: Option<(String, Duration)>,
}

/// Progress line, beside the name of the stage.
struct ProgressReport {
    count: String,
    left: String,
    /// Whether the line belongs in a log.
    due: bool,
}

impl ProgressReport {
    fn line(&self, what: &str) -> String {
        format!("{what}{}{}", self.count, self.left)
    }
}

impl BakeCourse {
    fn new(examples: u64) -> Self {
        Self { examples, position: 0, paced: None, reported: None }
    }

    fn length(&self) -> u64 {
        if self.examples > 0 { self.examples } else { STAGES }
    }

    /// Advances to stage `rank`, called `what`; `examples` holds how many examples are done, and of how many.
    fn report(&mut self, rank: u64, what: &str, examples: Option<[u64; 2]>, now: Duration) -> ProgressReport {
        let position = match examples {
            Some([done, _]) if self.examples > 0 => done,
            _ if self.examples == 0 => rank,
            _ if rank > EXAMPLES => self.examples,
            _ => 0,
        };
        // Each body has its own stages; the count does not fall when the next body begins.
        self.position = self.position.max(position.min(self.length()));
        let count = examples.map_or_else(String::new, |[done, of]| format!(" {done}/{of}"));
        let left = examples.and_then(|[done, of]| self.left(done, of, now));
        let left = left.map_or_else(String::new, |left| format!(", about {} left", HumanDuration(left)));
        let ended = examples.is_some_and(|[done, of]| done == of);
        let fresh =
            |(reported, when): &(String, Duration)| reported == what && now.saturating_sub(*when) < REPORT_INTERVAL;
        let due = ended || !self.reported.as_ref().is_some_and(fresh);
        if due {
            self.reported = Some((what.to_owned(), now));
        }
        ProgressReport { count, left, due }
    }

    /// Remaining time of the examples, at the pace of those that this run has done.
    fn left(&mut self, done: u64, of: u64, now: Duration) -> Option<Duration> {
        let (begun, first) = *self.paced.get_or_insert((now, done));
        let here = done.checked_sub(first).filter(|here| *here > 0 && done < of)?;
        Some(now.saturating_sub(begun).mul_f64((of - done) as f64 / here as f64))
    }
}

/// Rank of the examples among the stages.
const EXAMPLES: u64 = 5;

fn rank(step: BakeStep) -> u64 {
    match step {
        BakeStep::Surface => 0,
        BakeStep::Volume => 1,
        BakeStep::Lattices | BakeStep::Sized(_) => 2,
        BakeStep::Elasticity(_) => 3,
        BakeStep::Lift(_) | BakeStep::ExactSurface { .. } => 4,
        BakeStep::Examples { .. } => EXAMPLES,
        BakeStep::Reduction | BakeStep::Calibration => STAGES - 1,
    }
}

fn examples(step: BakeStep) -> Option<[u64; 2]> {
    match step {
        BakeStep::Examples { done, of } => Some([done, of]),
        _ => None,
    }
}

fn describe(step: BakeStep) -> String {
    match step {
        BakeStep::Surface => "surface: weld, orient, name defects".to_owned(),
        BakeStep::Volume => "volume: winding numbers".to_owned(),
        BakeStep::Lattices | BakeStep::Sized(_) => "lattices".to_owned(),
        BakeStep::Lift(body) => format!("lift of body {body}"),
        BakeStep::Elasticity(body) => format!("elasticity of body {body}"),
        BakeStep::ExactSurface { round: 0 } => "mesh of the input surface".to_owned(),
        BakeStep::ExactSurface { round } => format!("mesh of the input surface, repair round {round}"),
        BakeStep::Reduction => "reduced elasticity".to_owned(),
        BakeStep::Calibration => "calibration of the degree".to_owned(),
        BakeStep::Examples { .. } => "examples".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reported(state: &mut BakeCourse, step: BakeStep, seconds: u64) -> ProgressReport {
        state.report(rank(step), &describe(step), examples(step), Duration::from_secs(seconds))
    }

    #[test]
    fn the_count_never_falls_and_never_exceeds_its_length() {
        for of in [0, 300] {
            let mut state = BakeCourse::new(of);
            let begin = [BakeStep::Surface, BakeStep::Volume, BakeStep::Lattices];
            let bodies = (0..3).map(BakeStep::Elasticity).chain((0..3).map(BakeStep::Lift));
            let examples = (0..=of).step_by(50).map(|done| BakeStep::Examples { done, of });
            let mut before = 0;
            for step in
                begin.into_iter().chain(bodies).chain(examples).chain([BakeStep::Reduction, BakeStep::Calibration])
            {
                reported(&mut state, step, 0);
                assert!((before..=state.length()).contains(&state.position), "{step:?}: {}", state.position);
                before = state.position;
            }
            state.report(STAGES - 1, "write", None, Duration::ZERO);
            assert!(state.position <= state.length());
            assert_eq!(state.length(), if of == 0 { STAGES } else { of });
        }
    }

    #[test]
    fn estimates_are_printed_before_the_bake() {
        let (factor_bytes, skin_triangles) = (27_200_000, 130_196);
        let size = BakeSize {
            elastic_nodes: 4_645,
            crack_nodes: 9_576,
            examples: 100,
            factor_bytes,
            double_precision_bytes: 0,
            factor_operations: 3_000_000_000,
            edge_bytes: 0,
            quadratic_nodes: 0,
            stretch: 1,
            is_reduced: true,
            skin_triangles,
            exact_triangles: 0,
        };
        let reported = cost(&size, 2);
        assert!(
            reported
                .starts_with("4645 elastic and 9576 crack nodes, 100 examples: about 18 to 35 s left on an idle machine, 259 MB at most;"),
            "{reported}"
        );
        assert!(reported.ends_with("a daemon will hold about 57 MB for it"), "{reported}");
        let one = cost(&BakeSize { examples: 1, ..size }, 2);
        assert!(one.starts_with("4645 elastic and 9576 crack nodes, 1 example: about "), "{one}");
        assert!(
            cost(&BakeSize { examples: 0, ..size }, 1).contains("about 2 s"),
            "{}",
            cost(&BakeSize { examples: 0, ..size }, 1)
        );
    }

    #[test]
    fn a_log_gets_a_line_at_each_stage_and_every_half_minute() {
        let mut state = BakeCourse::new(300);
        assert!(reported(&mut state, BakeStep::Lift(0), 0).due && reported(&mut state, BakeStep::Lift(1), 1).due);
        let mut lines = Vec::new();
        for second in 0..=60 {
            let reported = reported(&mut state, BakeStep::Examples { done: 100 + second, of: 300 }, 10 + second);
            lines.extend(reported.due.then(|| reported.line("examples")));
        }
        assert_eq!(
            lines,
            ["examples 100/300", "examples 130/300, about 3 minutes left", "examples 160/300, about 2 minutes left"]
        );
        let end = reported(&mut state, BakeStep::Examples { done: 300, of: 300 }, 71);
        assert!(end.due && end.line("examples") == "examples 300/300");
        assert!(reported(&mut state, BakeStep::Reduction, 71).due);
    }
}
