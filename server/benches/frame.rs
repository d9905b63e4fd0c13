//! Time of a request through the real service, for each preset: `cargo bench --bench frame` bakes a generated statue of about
//! 100,000 triangles with examples; `SHATTER_BENCH_MESH` names another mesh file, `SHATTER_BENCH_FOLDER` a folder in which its databases
//! are kept from one run to the next (the sizes of the presets differ, so there is one for each), `SHATTER_BENCH_EXAMPLES` how many
//! impacts they learn from (200), `SHATTER_BENCH_PRESETS` which presets (draft,game,film), `SHATTER_BENCH_SURFACE` which surface the
//! fragments have (lattice).
//!
//! One client strikes, waits, and strikes elsewhere. The floor is what the results' own stages do not account for: the way there and
//! back, the admission, and the writing of a result without computation.

#[path = "../tests/support/mod.rs"]
mod support;

use shatter_client::{Client, Contact, EnergySource, ErrorKind, Impact, Object};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, bake, load, save};
use shatter_fracture::pipeline::{ImpactSampler, PreparedObject, Preset, SurfaceKind};
use shatter_fracture::scene::Materials;
use shatter_fracture::surface::{self, LengthUnit, RawMesh, UpAxis, shapes};
use shatter_proto::request::{self, DegreeRule};
use std::path::{Path, PathBuf};
use std::time::Duration;
use support::{Child, TestDirectory, shatterd, timeout};

const SITES: u32 = 50;
const STRIKES: usize = 200;
const WARM: usize = 20;

fn mesh() -> RawMesh {
    match std::env::var_os("SHATTER_BENCH_MESH") {
        Some(path) => surface::read(path.as_ref(), LengthUnit::M, UpAxis::Y).unwrap(),
        None => shapes::scanned_statue(),
    }
}

/// The database of `quality`, from an earlier run if there is one.
fn database(folder: &Path, quality: Preset) -> PreparedObject {
    let file = folder.join(format!("{}.shatter", quality.name()));
    if let Ok(prepared) = load(&file) {
        return prepared;
    }
    let materials = Materials::parse(shatter_fracture::scene::MATERIALS).unwrap();
    let examples = std::env::var("SHATTER_BENCH_EXAMPLES").ok().and_then(|text| text.parse().ok()).unwrap_or(200);
    let surface = std::env::var("SHATTER_BENCH_SURFACE").unwrap_or_else(|_| "lattice".to_owned());
    let surface = SurfaceKind::ALL.into_iter().find(|kind| kind.name() == surface).unwrap();
    let material = materials.get("ceramic").unwrap().clone();
    let request = BakeRequest { examples, quality, surface, ..BakeRequest::new(quality.name(), "ceramic", material) };
    save(&bake(mesh(), &request, &CancelToken::default(), &mut |_| {}).unwrap(), &file).unwrap();
    load(&file).unwrap()
}

/// Impacts that no example is, on the surface, inwards.
fn impacts(prepared: &PreparedObject, quality: Preset) -> Vec<Impact> {
    let sampler = ImpactSampler::new(prepared);
    let preset = request::Quality::by_name(quality.name()).unwrap();
    let impact = |index: usize| {
        let strike = sampler.impact(!prepared.parameters.seed, index as u64);
        let contact = &strike.contacts[0];
        let impact = Impact::new([Contact::new(contact.point_m.coords.into()).impulse(contact.impulse_ns.into())]);
        impact.degree(DegreeRule::Sites(SITES)).quality(preset).seed(index as u64)
    };
    (0..WARM + STRIKES).map(impact).collect()
}

/// Times of strikes one after the other, and what is known of each, ms.
#[derive(Default)]
struct Times {
    whole: Vec<f64>,
    stages: Vec<f64>,
    floor: Vec<f64>,
    triangles: Vec<f64>,
    solved: usize,
}

fn strikes(object: &Object, impacts: &[Impact]) -> Times {
    let mut times = Times::default();
    for (index, impact) in impacts.iter().enumerate() {
        let result = match object.strike(impact).unwrap().wait(timeout()) {
            Ok(result) => result,
            Err(error) if error.kind == ErrorKind::ContactTooFar => continue,
            Err(error) => panic!("{error}"),
        };
        if index < WARM {
            continue;
        }
        let whole = result.round_trip().as_secs_f64() * 1e3;
        let stages = result.stages().map(|cost| cost.time.as_secs_f64()).sum::<f64>() * 1e3;
        times.whole.push(whole);
        times.stages.push(stages);
        times.floor.push(whole - stages);
        let triangles = result.fragments().map(|fragment| fragment.indices().len() / 3).sum::<usize>();
        times.triangles.push(triangles as f64);
        times.solved += usize::from(result.summary().energy_source == EnergySource::Solve);
        std::thread::sleep(Duration::from_millis(2));
    }
    times
}

fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[((sorted.len() - 1) as f64 * share).round() as usize]
}

fn main() {
    // `cargo test` may run benches to see that they begin.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    let here = TestDirectory::new("frame");
    let folder = std::env::var_os("SHATTER_BENCH_FOLDER").map_or_else(|| here.databases(), PathBuf::from);
    let names = std::env::var("SHATTER_BENCH_PRESETS").unwrap_or_else(|_| "draft,game,film".to_owned());
    let presets: Vec<Preset> = names.split(',').map(|name| Preset::by_name(name).unwrap()).collect();
    let prepared: Vec<PreparedObject> = presets.iter().map(|quality| database(&folder, *quality)).collect();
    for quality in &presets {
        let name = format!("{}.shatter", quality.name());
        if folder != here.databases() {
            std::fs::copy(folder.join(&name), here.databases().join(&name)).unwrap();
        }
    }
    let daemon = Child::start(&mut shatterd(&here));
    let service = Client::connect_at(&here.place, timeout()).unwrap();
    println!("preset  elastic  crack nodes    p50     p99   stages   floor (ms)  solved  triangles");
    for (quality, prepared) in presets.into_iter().zip(&prepared) {
        let object = service.object(&prepared.name, timeout()).unwrap();
        let times = strikes(&object, &impacts(prepared, quality));
        println!(
            "{:8} {:6} {:11} {:8.2} {:7.2} {:7.2} {:8.3} {:12}/{} {:9.0}",
            quality.name(),
            prepared.elastic_nodes(),
            prepared.crack_nodes(),
            quantile(&times.whole, 0.5),
            quantile(&times.whole, 0.99),
            quantile(&times.stages, 0.5),
            quantile(&times.floor, 0.5),
            times.solved,
            times.whole.len(),
            quantile(&times.triangles, 0.5),
        );
    }
    assert_eq!(daemon.terminate().code(), Some(0));
}
