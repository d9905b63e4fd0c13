//! Requests with a time or an error, through the daemon: how often these are kept, and at which cost compared with presets. Asserts only
//! what holds on every machine.

mod support;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use shatter_client::{Contact, EnergySource, Impact, Object, Quality};
use shatter_engine::wire;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::centroidal::{self, DiagramOptions, EnergyField};
use shatter_fracture::database::{BakeRequest, bake, save};
use shatter_fracture::pipeline::{
    self, BodyEnergy, DegreeRequest, DisplacementMethod, FractureRequest, ImpactSampler, PreparedObject,
    RequestContext, SurfaceKind, Workspace, strain_energy,
};
use shatter_fracture::scene::Materials;
use shatter_fracture::surface::shapes;
use std::collections::BTreeMap;
use support::{InProcess, TestDirectory, timeout};

/// Requests of each kind, unless `SHATTER_TIMES_STRIKES` sets another number.
const STRIKES: u64 = 1000;

/// Requests before those that count: the daemon learns the cost of the object from them.
const WARM: usize = 50;

/// Time limits, ms.
const TIMES_MS: [f64; 4] = [6.0, 8.0, 12.0, 16.7];

/// Error limits, relative.
const ERRORS: [f64; 4] = [0.2, 0.1, 0.05, 0.02];

/// Presets, from fast to accurate, on the lattices of the default one.
const PRESETS: [Quality; 3] = [Quality::Draft, Quality::Game, Quality::Film];

/// Relative excess of an energy of cells that counts as equal.
const SAME: f64 = 0.01;

/// Iterations after which a descent has converged.
const ENDED: u32 = 3000;

/// Share of requests that must keep a limit for a preset to keep it, percent.
const RELIABLE: f64 = 95.0;

/// Ways to send the same request: presets, no iterations, times, errors.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    Preset(Quality),
    Least,
    Time(f64),
    Error(f64),
}

/// Outcome of one request.
#[derive(Clone, Copy)]
struct Measurement {
    time_ms: f64,
    iterations: u32,
    rank: u32,
    solved: bool,
    reason: &'static str,
    /// Estimate of the daemon.
    cvd_gap: f64,
    /// Values of [`Truth`]: F, its excess over the end of the same descent, and the error of the elastic energy.
    energy: f64,
    true_gap: f64,
    true_energy_error: f64,
}

impl Way {
    fn all() -> Vec<Self> {
        let presets = PRESETS.into_iter().map(Self::Preset).chain([Self::Least]);
        presets.chain(TIMES_MS.into_iter().map(Self::Time)).chain(ERRORS.into_iter().map(Self::Error)).collect()
    }

    fn measurement(self, statue: &Object, impact: &Impact) -> Measurement {
        let impact = impact.clone();
        let impact = match self {
            Self::Preset(quality) => impact.quality(quality),
            Self::Least => impact.iterations(0),
            Self::Time(time_ms) => impact.time_ms(time_ms),
            Self::Error(error_max) => impact.error(error_max),
        };
        let result = statue.strike(&impact).unwrap().wait(timeout()).unwrap();
        assert!(result.fragments().all(|fragment| fragment.is_closed()));
        let summary = result.summary();
        Measurement {
            time_ms: summary.time.as_secs_f64() * 1e3,
            iterations: summary.iterations,
            rank: summary.rank,
            solved: summary.energy_source == EnergySource::Solve,
            reason: summary.stop_criterion.name(),
            cvd_gap: summary.cvd_gap,
            energy: f64::NAN,
            true_gap: f64::NAN,
            true_energy_error: f64::NAN,
        }
    }
}

impl Measurement {
    fn error(&self) -> f64 {
        self.true_gap.max(self.true_energy_error)
    }
}

/// Cells and energies of a request, computed without the daemon.
struct Truth<'a> {
    prepared: &'a PreparedObject,
    strike: &'a FractureRequest,
    /// With the whole basis, and with a solve.
    deformed: [BodyEnergy; 2],
    workspaces: (Workspace, centroidal::DiagramWorkspace),
}

impl<'a> Truth<'a> {
    fn new(prepared: &'a PreparedObject, strike: &'a FractureRequest) -> Self {
        let mut workspaces: (Workspace, centroidal::DiagramWorkspace) = Default::default();
        let deformed = [DisplacementMethod::Reduced, DisplacementMethod::Solve]
            .map(|elastic| deformed(prepared, strike, elastic, None, &mut workspaces.0));
        Self { prepared, strike, deformed, workspaces }
    }

    /// F after `iterations`, and the estimate of its excess over the end of the descent.
    fn cells(&mut self, solved: bool, iterations: u32) -> [f64; 2] {
        let energy = &self.deformed[usize::from(solved)];
        // A field raises the shares to its floor; raising them twice would give higher ones.
        let mut shares = energy.shares.clone();
        let body = &self.prepared.bodies[energy.body];
        let field = EnergyField::new(body.interior.as_ref().unwrap(), &body.volumes, &mut shares).unwrap();
        let DegreeRequest::Sites(sites) = self.strike.degree else { unreachable!() };
        let options = DiagramOptions::new(sites as usize, self.strike.seed);
        let options = DiagramOptions { tolerance: 0.0, iterations_max: iterations as usize, ..options };
        let field = field.grouped(&body.clusters);
        let diagram = centroidal::diagram(&field, &options, &mut self.workspaces.1, &CancelToken::default()).unwrap();
        [diagram.energy, diagram.gap()]
    }

    /// Adds the true values to `measurements` of one impact.
    fn judge(&mut self, measurements: &mut [Measurement]) {
        let mut known: BTreeMap<(bool, u32), [f64; 2]> = BTreeMap::new();
        let mut reduced: BTreeMap<u32, BodyEnergy> = BTreeMap::new();
        for measurement in measurements {
            let mut cells = |iterations| {
                *known
                    .entry((measurement.solved, iterations))
                    .or_insert_with(|| self.cells(measurement.solved, iterations))
            };
            let ([energy, gap], [end, _]) = (cells(measurement.iterations), cells(ENDED));
            let own = reduced.entry(measurement.rank).or_insert_with(|| {
                let rank_max = Some(measurement.rank.max(1));
                deformed(self.prepared, self.strike, DisplacementMethod::Reduced, rank_max, &mut self.workspaces.0)
            });
            (measurement.energy, measurement.true_gap) = (energy, energy / end - 1.0);
            let [whole, solved] = &self.deformed;
            measurement.true_energy_error =
                if measurement.solved { 0.0 } else { (own.energy_j / solved.energy_j - 1.0).abs() };
            // The daemon reports the values that are computed here. Displacements that add nothing to the energy may change the last bits
            // of shares.
            if measurement.solved || own.shares == whole.shares {
                assert_eq!(
                    gap, measurement.cvd_gap,
                    "rank {}, {} iterations, solved {}",
                    measurement.rank, measurement.iterations, measurement.solved
                );
            }
        }
    }
}

fn deformed(
    prepared: &PreparedObject,
    strike: &FractureRequest,
    elastic: DisplacementMethod,
    rank_max: Option<u32>,
    workspace: &mut Workspace,
) -> BodyEnergy {
    let strike = FractureRequest { elastic, rank_max, reduced_error_max: f64::INFINITY, ..strike.clone() };
    let impact = pipeline::ContactSet::new(prepared, &strike).unwrap();
    strain_energy(RequestContext::new(prepared, &strike, &CancelToken::default(), &()), &impact, workspace)
        .unwrap()
        .remove(0)
}

fn quantile(values: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    let place = (sorted.len() as f64 * share) as usize;
    sorted.get(place.min(sorted.len().saturating_sub(1))).copied().unwrap_or(f64::NAN)
}

/// Percentage of `all` for which `holds` is true.
fn percent<T>(all: impl IntoIterator<Item = T>, mut holds: impl FnMut(&T) -> bool) -> f64 {
    let all: Vec<T> = all.into_iter().collect();
    100.0 * all.iter().filter(|own| holds(own)).count() as f64 / all.len() as f64
}

/// All requests, by way.
struct Measurements(Vec<(Way, Vec<Measurement>)>);

impl Measurements {
    fn of(&self, way: Way) -> &[Measurement] {
        &self.0.iter().find(|(own, _)| *own == way).unwrap().1
    }

    /// Results of the presets, from accurate to fast.
    fn presets(&self) -> impl Iterator<Item = (Quality, &[Measurement])> {
        PRESETS.into_iter().rev().map(|quality| (quality, self.of(Way::Preset(quality))))
    }

    fn median_ms(&self, way: Way) -> f64 {
        quantile(self.of(way).iter().map(|measurement| measurement.time_ms), 0.5)
    }

    /// Prints time and settings of this way.
    fn tell(&self, way: Way) {
        let measurements = self.of(way);
        let [p50, p95] =
            [0.5, 0.95].map(|share| quantile(measurements.iter().map(|measurement| measurement.time_ms), share));
        let iterations = measurements.iter().map(|measurement| f64::from(measurement.iterations)).sum::<f64>()
            / measurements.len() as f64;
        let solved = percent(measurements, |measurement| measurement.solved);
        let error = |of: fn(&Measurement) -> f64| 100.0 * quantile(measurements.iter().map(of), 0.5);
        let [gap, energy] =
            [error(|measurement| measurement.true_gap), error(|measurement| measurement.true_energy_error)];
        let mut ends: BTreeMap<&str, u32> = BTreeMap::new();
        measurements.iter().for_each(|measurement| *ends.entry(measurement.reason).or_default() += 1);
        println!(
            "{way:?}: {p50:.2} ms, 95 % within {p95:.2} ms; {iterations:.1} iterations, {solved:.1} % solved for; cells {gap:.2} % \
             above their end, elastic energy {energy:.2} % off (medians); {ends:?}"
        );
    }

    /// Prints how many requests keep a time, and whether they are as good as the best preset that keeps it.
    fn time(&self, time_ms: f64) {
        let measurements = self.of(Way::Time(time_ms));
        let kept = |measurements: &[Measurement]| percent(measurements, |measurement| measurement.time_ms <= time_ms);
        println!("  kept by {:.1} % (without iterations: by {:.1} %)", kept(measurements), kept(self.of(Way::Least)));
        let report = |name: &str, pairs: &[(&Measurement, &Measurement)]| {
            let cells = percent(pairs, |(own, preset)| own.energy <= (1.0 + SAME) * preset.energy);
            let elastic = percent(pairs, |(own, preset)| own.true_energy_error <= preset.true_energy_error + SAME);
            println!("  {name}: cells no worse in {cells:.1} %, elastic energy in {elastic:.1} % of {}", pairs.len());
        };
        if let Some((quality, preset)) = self.presets().find(|(_, preset)| kept(preset) >= RELIABLE) {
            report(
                &format!("beside {}, which keeps it", quality.name()),
                &measurements.iter().zip(preset).collect::<Vec<_>>(),
            );
        }
        let fitting = |index: usize| self.presets().map(|(_, own)| &own[index]).find(|own| own.time_ms <= time_ms);
        let pairs: Vec<(&Measurement, &Measurement)> =
            measurements.iter().enumerate().filter_map(|(index, own)| Some((own, fitting(index)?))).collect();
        report("beside the best preset that kept it, strike by strike", &pairs);
    }

    /// Prints how many requests keep an error, and their time beside that of the fastest preset that keeps it.
    fn error(&self, error_max: f64) {
        let way = Way::Error(error_max);
        let met = |measurements: &[Measurement]| percent(measurements, |measurement| measurement.error() <= error_max);
        let cells = percent(self.of(way), |measurement| measurement.true_gap <= error_max);
        let elastic = percent(self.of(way), |measurement| measurement.true_energy_error <= error_max);
        println!("  met by {:.1} % (cells {cells:.1} %, elastic energy {elastic:.1} %)", met(self.of(way)));
        let reliable = self.presets().filter(|(_, preset)| met(preset) >= RELIABLE).map(|(quality, _)| quality);
        if let Some(quality) =
            reliable.min_by(|a, b| self.median_ms(Way::Preset(*a)).total_cmp(&self.median_ms(Way::Preset(*b))))
        {
            let ratio = self.median_ms(way) / self.median_ms(Way::Preset(quality));
            println!("  {ratio:.2} times as long as {}, the fastest that meets it", quality.name());
        }
        let ratio = |(index, own): (usize, &Measurement)| {
            let good = self.presets().map(|(_, preset)| preset[index]).filter(|preset| preset.error() <= error_max);
            good.map(|preset| preset.time_ms).reduce(f64::min).map(|fast_ms| own.time_ms / fast_ms)
        };
        let ratios: Vec<f64> = self.of(way).iter().enumerate().filter_map(ratio).collect();
        let twice = percent(&ratios, |ratio| **ratio <= 2.0);
        let [p50, p95] = [0.5, 0.95].map(|share| quantile(ratios.iter().copied(), share));
        println!(
            "  beside the fastest preset that met it, strike by strike: {p50:.2} times as long (median), 95 % within {p95:.2}, \
             {twice:.1} % within twice, of {}",
            ratios.len()
        );
    }
}

/// The object and the impacts.
fn prepare(here: &TestDirectory) -> (PreparedObject, Vec<(Impact, FractureRequest)>) {
    let materials = Materials::parse(shatter_fracture::scene::MATERIALS).unwrap();
    let plaster = materials.get("plaster").unwrap().clone();
    let request =
        BakeRequest { examples: 40, surface: SurfaceKind::Lattice, ..BakeRequest::new("statue", "plaster", plaster) };
    let prepared = bake(shapes::statue(), &request, &CancelToken::default(), &mut |_| ()).unwrap();
    save(&prepared, &here.databases().join("statue.shatter")).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let sampler = ImpactSampler::new(&prepared);
    let strikes = std::env::var("SHATTER_TIMES_STRIKES").map_or(STRIKES, |count| count.parse().unwrap());
    let draw = |index| {
        let contact = sampler.impact(11, index).contacts[0];
        let sites = 10 + (random.next_u64() % 90) as u32;
        let impact = Impact::new([Contact::new(contact.point_m.into()).impulse(contact.impulse_ns.into())]).seed(index);
        let strike = FractureRequest::at(contact.point_m, contact.impulse_ns).seeded(1);
        let strike = FractureRequest { degree: DegreeRequest::Sites(sites), seed: index, ..strike };
        (impact.degree(shatter_client::DegreeRule::Sites(sites)), strike)
    };
    let drawn = (0..strikes).map(draw).collect();
    (prepared, drawn)
}

#[test]
#[ignore = "minutes; says how well times and errors are kept"]
fn requested_times_and_errors_are_met() {
    let load = || println!("load {}", std::fs::read_to_string("/proc/loadavg").unwrap_or_default().trim());
    let here = TestDirectory::new("times");
    let (prepared, impacts) = prepare(&here);
    let daemon = InProcess::start_with(here, "", wire::loader(None));
    let statue = daemon.connect().object("statue", timeout()).unwrap();
    load();
    let ways = Way::all();
    impacts.iter().take(WARM).for_each(|(impact, _)| _ = Way::Preset(Quality::Game).measurement(&statue, impact));
    // In turn, so that other load of the machine is the same for all.
    let shoot =
        |(impact, _): &(Impact, FractureRequest)| ways.iter().map(|way| way.measurement(&statue, impact)).collect();
    let mut measurements: Vec<Vec<Measurement>> = impacts.iter().map(shoot).collect();
    load();
    for ((_, strike), measurements) in impacts.iter().zip(&mut measurements) {
        Truth::new(&prepared, strike).judge(measurements);
    }
    let by_way = |way: usize| measurements.iter().map(|own| own[way]).collect();
    let measurements = Measurements(ways.iter().enumerate().map(|(place, way)| (*way, by_way(place))).collect());
    for way in ways {
        measurements.tell(way);
        match way {
            Way::Time(time_ms) => measurements.time(time_ms),
            Way::Error(error_max) => measurements.error(error_max),
            Way::Preset(_) | Way::Least => {}
        }
    }
}
