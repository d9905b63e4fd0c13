//! Strikes with a time or an error, through the daemon: how often these are kept, and what that costs beside presets. Nothing is asserted
//! but what holds on every machine.

mod support;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use shatter_client::{Impact, Object, Quality, Shatter};
use shatter_fracture::centroidal::{self, Field, ITERATIONS_MAX, Options};
use shatter_fracture::database::{BakeRequest, bake, save};
use shatter_fracture::pipeline::{self, ElasticRequest, Prepared, Sampler, Strike, Workspace, strain_energy};
use shatter_fracture::scene::Materials;
use shatter_fracture::surface::shapes;
use shatter_fracture::token::Token;
use shatter_server::wire;
use std::collections::BTreeMap;
use support::{InProcess, TestPlace, patience};

/// Strikes of each kind, unless the environment says otherwise.
const STRIKES: u64 = 1000;

/// Strikes before any that count: what is expected of the object is learned from them.
const WARM: usize = 50;

/// Times, ms.
const TIMES_MS: [f64; 4] = [6.0, 8.0, 12.0, 16.7];

/// Errors.
const ERRORS: [f64; 4] = [0.2, 0.1, 0.05, 0.02];

/// Presets, from fast to accurate, on the lattices of the default one.
const PRESETS: [Quality; 3] = [Quality::Draft, Quality::Game, Quality::Film];

/// An energy of cells that is so little more is no worse, relative.
const SAME: f64 = 0.01;

/// Iterations after which a descent has ended.
const ENDED: u32 = 3000;

/// What is struck, and how.
struct Range {
    prepared: Prepared,
    statue: Object,
    impacts: Vec<(Impact, Strike)>,
    _service: (Shatter, InProcess),
}

/// What one strike came to.
#[derive(Clone, Copy)]
struct Shot {
    time_ms: f64,
    iterations: u32,
    rank: u32,
    solved: bool,
    /// Estimates.
    energy_error: f64,
    cvd_gap: f64,
    reason: &'static str,
}

/// What a strike's cells come to after so many iterations, computed beside the daemon.
struct Truth<'a> {
    prepared: &'a Prepared,
    strike: &'a Strike,
    /// By whether it is solved for, and iterations: F, and its estimated gap.
    known: BTreeMap<(bool, u32), [f64; 2]>,
    /// By rank, 0 for a solve: strain energy, J.
    energies_j: BTreeMap<u32, f64>,
    workspaces: (Workspace, centroidal::Workspace),
}

impl Range {
    fn new() -> Self {
        let here = TestPlace::new("times");
        let materials = Materials::parse(include_str!("../../config/materials.toml")).unwrap();
        let plaster = materials.get("plaster").unwrap().clone();
        let request = BakeRequest { examples: 40, ..BakeRequest::new("statue", "plaster", plaster) };
        let prepared = bake(shapes::statue(), &request, &Token::default(), &mut |_| ()).unwrap();
        save(&prepared, &here.databases().join("statue.shatter")).unwrap();
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let sampler = Sampler::new(&prepared);
        let strikes = std::env::var("SHATTER_TIMES_STRIKES").map_or(STRIKES, |count| count.parse().unwrap());
        let drawn = (0..strikes).map(|index| {
            let contact = sampler.impact(11, index).contacts[0];
            let sites = 10 + (random.next_u64() % 90) as u32;
            let impact = Impact::at(contact.point_m.into()).impulse(contact.impulse_ns.into()).seed(index);
            let degree = pipeline::DegreeRequest::Sites(sites);
            let strike = Strike { degree, seed: index, ..Strike::at(contact.point_m, contact.impulse_ns) };
            (impact.degree(shatter_client::Degree::Sites(sites)), strike)
        });
        let impacts = drawn.collect();
        let daemon = InProcess::start_with(here, "", wire::loader(None));
        let client = daemon.connect();
        let statue = client.object("statue", patience()).unwrap();
        Self { prepared, statue, impacts, _service: (client, daemon) }
    }

    /// Strikes with what `with` adds to each.
    fn shots(&self, with: impl Fn(Impact) -> Impact) -> Vec<Shot> {
        let shot = |(impact, _): &(Impact, Strike)| {
            let broken = self.statue.strike(&with(impact.clone())).unwrap().wait(patience()).unwrap();
            assert!(broken.fragments().all(|fragment| fragment.is_closed()));
            let summary = broken.summary();
            Shot {
                time_ms: summary.time_ns as f64 * 1e-6,
                iterations: summary.iterations,
                rank: summary.rank,
                solved: summary.elastic() == "solve",
                energy_error: summary.energy_error,
                cvd_gap: summary.cvd_gap,
                reason: summary.stop_reason(),
            }
        };
        self.impacts.iter().take(WARM).for_each(|impact| _ = shot(impact));
        self.impacts.iter().map(shot).collect()
    }

    fn truths(&self) -> Vec<Truth<'_>> {
        self.impacts.iter().map(|(_, strike)| Truth::new(&self.prepared, strike)).collect()
    }
}

impl<'a> Truth<'a> {
    fn new(prepared: &'a Prepared, strike: &'a Strike) -> Self {
        let workspaces = Default::default();
        Self { prepared, strike, known: BTreeMap::new(), energies_j: BTreeMap::new(), workspaces }
    }

    /// With a displacement solved for, or from so much of the basis.
    fn deformed(&mut self, solved: bool, rank_max: Option<u32>) -> pipeline::BodyEnergy {
        let elastic = if solved { ElasticRequest::Solve } else { ElasticRequest::Reduced };
        let strike = Strike { elastic, rank_max, reduced_error_max: f64::INFINITY, ..self.strike.clone() };
        let impact = pipeline::Impact::new(self.prepared, &strike).unwrap();
        strain_energy(self.prepared, &impact, &mut self.workspaces.0, &Token::default(), &mut ()).unwrap().remove(0)
    }

    /// F after so many iterations, and how far it is estimated to be above its end.
    fn cells(&mut self, solved: bool, iterations: u32) -> [f64; 2] {
        if let Some(known) = self.known.get(&(solved, iterations)) {
            return *known;
        }
        let mut energy = self.deformed(solved, None);
        let body = &self.prepared.bodies[energy.body];
        let field = Field::new(body.interior.as_ref().unwrap(), &body.volumes, &mut energy.shares).unwrap();
        let pipeline::DegreeRequest::Sites(sites) = self.strike.degree else { unreachable!() };
        let options = Options {
            tolerance: 0.0,
            iterations_max: iterations as usize,
            ..Options::new(sites as usize, self.strike.seed)
        };
        let field = field.grouped(&body.clusters);
        let diagram = centroidal::diagram(&field, &options, &mut self.workspaces.1, &Token::default()).unwrap();
        let found = [diagram.energy, diagram.gap()];
        self.known.insert((solved, iterations), found);
        found
    }

    /// By how much the energy of the cells of `shot` is above the end of the same descent.
    fn gap(&mut self, shot: &Shot) -> f64 {
        self.cells(shot.solved, shot.iterations)[0] / self.cells(shot.solved, ENDED)[0] - 1.0
    }

    fn energy_j(&mut self, rank: u32) -> f64 {
        if let Some(known) = self.energies_j.get(&rank) {
            return *known;
        }
        let found = self.deformed(rank == 0, Some(rank.max(1))).energy_j;
        self.energies_j.insert(rank, found);
        found
    }

    /// Error of the elastic energy of `shot`, by a solve.
    fn energy_error(&mut self, shot: &Shot) -> f64 {
        if shot.solved { 0.0 } else { (self.energy_j(shot.rank) / self.energy_j(0) - 1.0).abs() }
    }

    /// The worse of both.
    fn error(&mut self, shot: &Shot) -> f64 {
        self.gap(shot).max(self.energy_error(shot))
    }
}

fn quantile(values: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted
        .get(((sorted.len() as f64 * share) as usize).min(sorted.len().saturating_sub(1)))
        .copied()
        .unwrap_or(f64::NAN)
}

/// Per cent of `all` for which it holds.
fn percent<T>(all: impl Iterator<Item = T>, holds: impl FnMut(&T) -> bool) -> f64 {
    let (mut count, mut holds) = (0, holds);
    let good = all.inspect(|_| count += 1).filter(|own| holds(own)).count();
    100.0 * good as f64 / count as f64
}

fn tell(name: &str, shots: &[Shot]) {
    let time = |share| quantile(shots.iter().map(|shot| shot.time_ms), share);
    println!("{name}: {:.2} ms, 95 % within {:.2} ms", time(0.5), time(0.95));
}

/// Times: how many are kept, and whether the cells are as good as those of the best preset that takes no longer.
fn times(range: &Range, presets: &[Vec<Shot>], truths: &mut [Truth<'_>]) {
    let least = range.shots(|impact| impact.iterations(0));
    tell("no iterations", &least);
    for time_ms in TIMES_MS {
        let shots = range.shots(|impact| impact.time_ms(time_ms));
        let kept = percent(shots.iter(), |shot| shot.time_ms <= time_ms);
        let possible = percent(least.iter(), |shot| shot.time_ms <= time_ms);
        let within = quantile(shots.iter().map(|shot| shot.time_ms), 0.95);
        let mean = shots.iter().map(|shot| f64::from(shot.iterations)).sum::<f64>() / shots.len() as f64;
        let gap = 100.0 * quantile(shots.iter().map(|shot| shot.cvd_gap), 0.5);
        let mut ends: BTreeMap<&str, u32> = BTreeMap::new();
        shots.iter().for_each(|shot| *ends.entry(shot.reason).or_default() += 1);
        println!(
            "{time_ms} ms: kept by {kept:.1} % (95 % within {within:.2} ms; by {possible:.1} % of the strikes without iterations), \
             {mean:.1} iterations, gap {gap:.2} % (estimated, median), {ends:?}"
        );
        let (mut beside, mut good) = (0, [0; 2]);
        for (index, shot) in shots.iter().enumerate() {
            let fits = presets.iter().take(2).rev().map(|shots| shots[index]).find(|preset| preset.time_ms <= time_ms);
            let Some(preset) = fits else { continue };
            let truth = &mut truths[index];
            let energy = [shot, &preset].map(|shot| truth.cells(shot.solved, shot.iterations)[0]);
            beside += 1;
            good[0] += u32::from(energy[0] <= (1.0 + SAME) * energy[1]);
            good[1] += u32::from(shot.energy_error <= preset.energy_error + SAME);
        }
        let [cells, elastic] = good.map(|count| 100.0 * f64::from(count) / f64::from(beside));
        println!(
            "    a preset fits {beside} of {}: cells no worse than its in {cells:.1} %, elastic energy (estimated) in {elastic:.1} %",
            shots.len()
        );
    }
}

/// Errors: how many are met, and how long that takes beside the fastest preset that meets them.
fn errors(range: &Range, presets: &[Vec<Shot>], truths: &mut [Truth<'_>]) {
    for error_max in ERRORS {
        let shots = range.shots(|impact| impact.error(error_max));
        let both: Vec<[f64; 2]> =
            shots.iter().zip(&mut *truths).map(|(shot, truth)| [truth.gap(shot), truth.energy_error(shot)]).collect();
        let met = |shares: &dyn Fn(&[f64; 2]) -> f64| percent(both.iter(), |error| shares(error) <= error_max);
        let [all, gap, energy] = [met(&|both| both[0].max(both[1])), met(&|both| both[0]), met(&|both| both[1])];
        let solved = percent(shots.iter(), |shot| shot.solved);
        let mean = shots.iter().map(|shot| f64::from(shot.iterations)).sum::<f64>() / shots.len() as f64;
        tell(
            &format!(
                "error {error_max}: met by {all:.1} % (cells {gap:.1} %, elastic energy {energy:.1} %), {mean:.1} iterations, {solved:.1} % solved for"
            ),
            &shots,
        );
        let mut ratios = Vec::new();
        for (index, shot) in shots.iter().enumerate() {
            let fast =
                presets.iter().map(|shots| shots[index]).filter(|preset| truths[index].error(preset) <= error_max);
            ratios.extend(fast.map(|preset| preset.time_ms).reduce(f64::min).map(|fast_ms| shot.time_ms / fast_ms));
        }
        let twice = percent(ratios.iter(), |ratio| **ratio <= 2.0);
        let [p50, p95] = [0.5, 0.95].map(|share| quantile(ratios.iter().copied(), share));
        println!(
            "    beside the fastest preset that meets it, of {} strikes: {p50:.2} times as long (median), 95 % within {p95:.2}; {twice:.1} % within twice",
            ratios.len()
        );
        for (quality, preset) in PRESETS.iter().zip(presets) {
            let good = preset.iter().zip(&mut *truths).map(|(shot, truth)| truth.error(shot) <= error_max);
            let share = percent(good, |met| *met);
            let ratio = quantile(shots.iter().map(|shot| shot.time_ms), 0.5)
                / quantile(preset.iter().map(|shot| shot.time_ms), 0.5);
            println!("    {} meets it in {share:.1} %; {ratio:.2} times its median", quality.name());
        }
    }
}

#[test]
#[ignore = "three minutes; says how well times and errors are kept"]
fn times_and_errors_that_are_asked_for() {
    let range = Range::new();
    let mut truths = range.truths();
    let load = || println!("load {}", std::fs::read_to_string("/proc/loadavg").unwrap_or_default().trim());
    load();
    let presets = PRESETS.map(|quality| range.shots(|impact| impact.quality(quality)));
    for (quality, shots) in PRESETS.iter().zip(&presets) {
        tell(quality.name(), shots);
    }
    // What the daemon tells is what is computed here.
    for (shot, truth) in presets[1].iter().zip(&mut truths).take(WARM) {
        assert_eq!(truth.cells(shot.solved, shot.iterations)[1], shot.cvd_gap);
        assert!((shot.iterations as usize) < ITERATIONS_MAX);
    }
    times(&range, &presets, &mut truths);
    errors(&range, &presets, &mut truths);
    load();
}
