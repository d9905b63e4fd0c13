//! Statistics of a run: times of steps, masses, energies, results.

use super::Failure;
use super::film::Film;
use super::world::World;
use serde_json::{Value, json};
use shatter_client::FractureResult;
use shatter_lab::study::plot::{Axes, PlotLine, PlotMark, svg};
use std::collections::BTreeMap;
use std::time::Duration;

/// Times of a step.
#[derive(Clone, Copy, Default)]
pub struct Step {
    /// Time in the simulation, s.
    pub at_s: f64,
    pub whole: Duration,
    /// Time of Rapier and of reading its contacts.
    pub physics: Duration,
    /// Time of client calls: sending requests and polling tickets.
    pub client: Duration,
    /// Time of replacing bodies by fragments.
    pub swap: Duration,
    /// Voluntary context switches during client calls.
    pub waits: u64,
    /// Involuntary context switches during client calls.
    pub taken: u64,
}

/// Statistics of a run.
#[derive(Default)]
pub struct Tally {
    steps: Vec<Step>,
    mass_begun_kg: f64,
    mass_ended_kg: f64,
    /// Largest relative change of the mass at any step.
    mass_off: f64,
    energy_begun_j: f64,
    energy_max_j: f64,
    energy_ended_j: f64,
    energies_finite: bool,
    pub strikes: u64,
    whole: u64,
    /// Number of breaks by generation: 0 for objects.
    breaks: [u64; 4],
    fragments: u64,
    late_s: Vec<f64>,
    round_trips: Vec<Duration>,
    /// Largest overlap of new fragments with their siblings, and with anything else, m.
    siblings_m: f64,
    others_m: f64,
    /// Number of fragments with others inside of their hulls.
    hollow: u64,
    /// Number of pairs of a new fragment and a neighbor that overlap by more than 5 mm, and of all such pairs.
    deep: u64,
    pairs: u64,
    pub refused_count: BTreeMap<&'static str, u64>,
    /// Durations of the pauses of fracture, s.
    pub paused_s: Vec<f64>,
}

/// Overlap from which a pair is counted, m.
const DEEP_M: f64 = 5e-3;

impl Tally {
    pub fn begin(&mut self, world: &World<'_>) {
        (self.mass_begun_kg, self.energy_begun_j) = (world.mass_kg(), world.energy_j());
        self.energies_finite = true;
    }

    pub fn step(&mut self, step: Step, world: &World<'_>) {
        let (mass_kg, energy_j) = (world.mass_kg(), world.energy_j());
        self.mass_off = self.mass_off.max((mass_kg / self.mass_begun_kg - 1.0).abs());
        self.energy_max_j = self.energy_max_j.max(energy_j);
        self.energies_finite &= energy_j.is_finite();
        self.steps.push(step);
    }

    pub fn end(&mut self, world: &World<'_>) {
        (self.mass_ended_kg, self.energy_ended_j) = (world.mass_kg(), world.energy_j());
    }

    /// Records a result, `late_s` after the contact in the simulation.
    pub fn record_result(&mut self, late_s: f64, round_trip: Duration, generation: u32, result: &FractureResult) {
        if result.is_whole() {
            self.whole += 1;
            return;
        }
        self.breaks[generation.min(3) as usize] += 1;
        self.fragments += result.fragments().len() as u64;
        self.late_s.push(late_s);
        self.round_trips.push(round_trip);
    }

    /// Records a fragment.
    pub fn hollow(&mut self, hollow: bool) {
        self.hollow += u64::from(hollow);
    }

    /// Records a new fragment and a neighbor.
    pub fn new_piece(&mut self, depth_m: f64, sibling: bool) {
        let deepest = if sibling { &mut self.siblings_m } else { &mut self.others_m };
        *deepest = deepest.max(depth_m);
        self.deep += u64::from(depth_m > DEEP_M);
        self.pairs += 1;
    }

    /// Voluntary and involuntary context switches of this thread; zero if the system does not report them.
    pub fn switches(&self) -> [u64; 2] {
        let status = std::fs::read_to_string("/proc/thread-self/status").unwrap_or_default();
        ["voluntary_ctxt_switches:", "nonvoluntary_ctxt_switches:"].map(|name| {
            let line = status.lines().find_map(|line| line.strip_prefix(name));
            line.and_then(|count| count.trim().parse().ok()).unwrap_or_default()
        })
    }

    /// Plot of step times, with those of a run without fracture.
    pub fn plot(&self, without: &Self) -> Result<String, Failure> {
        let line = |name: &str, steps: &[Step], of: fn(&Step) -> Duration| PlotLine {
            name: name.into(),
            points: steps.iter().map(|step| (step.at_s, 1e3 * of(step).as_secs_f64())).collect(),
            mark: PlotMark::Dots,
        };
        let lines = [
            line("with fracture: the whole step", &self.steps, |step| step.whole),
            line("with fracture: calls of the client", &self.steps, |step| step.client),
            line("with fracture: fragments put in place", &self.steps, |step| step.swap),
            line("without fracture: the whole step", &without.steps, |step| step.whole),
        ];
        let (x, y) = ("time in the simulation, s".into(), "time of the step, ms".into());
        Ok(svg(&Axes { x, y, log_x: false, log_y: true }, &lines)?)
    }

    /// JSON summary of the run.
    pub fn summary(&self, without: &Self, film: &Film) -> Value {
        let mut late_ms: Vec<f64> = self.late_s.iter().map(|late_s| 1e3 * late_s).collect();
        late_ms.sort_by(f64::total_cmp);
        let middle = |values: &[f64]| values.get(values.len() / 2).copied();
        let round_trips: Vec<f64> = sorted_ms(self.round_trips.iter().copied());
        json!({
            "steps": self.steps.len(),
            "strikes": self.strikes,
            "breaks": self.breaks.iter().sum::<u64>(),
            "breaks_again": self.breaks[1..].iter().sum::<u64>(),
            "stayed_whole": self.whole,
            "fragments": self.fragments,
            "mass_before_kg": self.mass_begun_kg,
            "mass_after_kg": self.mass_ended_kg,
            "mass_off": self.mass_off,
            "energy_before_j": self.energy_begun_j,
            "energy_max_j": self.energy_max_j,
            "energy_after_j": self.energy_ended_j,
            "energies_finite": self.energies_finite,
            "birth_depth_siblings_max_mm": 1e3 * self.siblings_m,
            "birth_depth_others_max_mm": 1e3 * self.others_m,
            "fragments_hollow": self.hollow,
            "birth_pairs": self.pairs,
            "birth_pairs_deeper_than_5_mm": self.deep,
            "steps_that_waited": self.steps.iter().filter(|step| step.waits > 0).count(),
            "steps_preempted": self.steps.iter().filter(|step| step.taken > 0).count(),
            "longest_client_preempted": self.steps.iter().max_by_key(|step| step.client).map(|step| step.taken),
            "step_ms": times(&self.steps, |step| step.whole),
            "step_physics_ms": times(&self.steps, |step| step.physics),
            "step_client_ms": times(&self.steps, |step| step.client),
            "step_swap_ms": times(&self.steps, |step| step.swap),
            "step_without_fracture_ms": times(&without.steps, |step| step.whole),
            "result_ms_median": middle(&round_trips),
            "result_ms_max": round_trips.last(),
            "result_late_ms_median": middle(&late_ms),
            "paused_s": self.paused_s,
            "refusals": self.refused_count,
            "actors": film.actors.len(),
        })
    }
}

fn sorted_ms(times: impl Iterator<Item = Duration>) -> Vec<f64> {
    let mut times: Vec<f64> = times.map(|time| 1e3 * time.as_secs_f64()).collect();
    times.sort_by(f64::total_cmp);
    times
}

/// Median, 99th percentile and maximum, ms.
fn times(steps: &[Step], of: fn(&Step) -> Duration) -> Value {
    let times = sorted_ms(steps.iter().map(of));
    let at = |share: f64| times.get(((times.len() as f64 * share) as usize).min(times.len().saturating_sub(1)));
    json!({ "median": at(0.5), "p99": at(0.99), "max": times.last() })
}
