//! A toy engine without physics: databases are one word that names the behavior of the object.

use bytemuck::Zeroable;
use shatter_engine::object::{EngineResult, Loader, ServedObject};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::pipeline::{Stage, StageObserver, Workspace};
use shatter_proto::control::{ObjectRow, ObjectState};
use shatter_proto::layout::{SectionCounts, SectionsMut};
use shatter_proto::request::{Purpose, Request};
use shatter_proto::result::{FragmentWire, OUTER, RunWire, SummaryWire};
use shatter_proto::{Error, ErrorKind};
use std::ops::Range;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Behavior of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FakeObject {
    /// Breaks into `sites` tetrahedra (one by default).
    Tetra,
    /// Breaks like a tetrahedron, but with this many KiB of vertices that no triangle uses.
    Large(usize),
    /// Breaks like a tetrahedron, with this γ, and vertices that contain it; holds that many kilobytes.
    Tint(u32),
    /// Behaves like `Tint`, but its requests compute until the file beside it that ends in `.gate` is gone.
    Gate(u32),
    /// Computes until it is canceled, or for a minute.
    Slow,
    /// Breaks like a tetrahedron, after this many milliseconds of computing.
    Brief(u64),
    /// Breaks like a tetrahedron, after this many milliseconds for each site.
    Sites(u64),
    /// Panics.
    Panic,
}

const CORNERS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [u32; 12] = [1, 2, 3, 0, 3, 2, 0, 1, 3, 0, 2, 1];

/// Number of parts of a result whose addresses are recorded.
const PARTS: usize = 3;

static WRITTEN: Mutex<Vec<(String, Range<usize>)>> = Mutex::new(Vec::new());

/// Addresses of positions, indices and merge pairs of an object's fragments that were written in this process.
pub fn addresses(object: &str) -> Vec<Range<usize>> {
    let written = WRITTEN.lock().unwrap();
    written.iter().filter(|(name, _)| name == object).map(|(_, range)| range.clone()).collect()
}

/// Names of the objects with this ending, in the order in which their fragments were written in this process.
pub fn order(ending: &str) -> Vec<String> {
    let written = WRITTEN.lock().unwrap();
    let names = written.iter().map(|(name, _)| name).filter(|name| name.ends_with(ending));
    names.step_by(PARTS).cloned().collect()
}

/// Loads toy objects; loading takes until the file beside the database that ends in `.loading` is gone.
pub fn loader() -> Loader {
    Arc::new(|path, _| {
        let word = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
        let (begun, gate) = (Instant::now(), path.with_extension("loading"));
        while gate.exists() && begun.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(1));
        }
        let fake_object = match word.split_once(' ') {
            None if word == "tetra" => FakeObject::Tetra,
            None if word == "slow" => FakeObject::Slow,
            None if word == "panic" => FakeObject::Panic,
            None if word == "rotten" => panic!("the loader fell over it"),
            Some(("sites", ms)) => FakeObject::Sites(ms.parse().map_err(|_| "not a number")?),
            Some(("brief", ms)) => FakeObject::Brief(ms.parse().map_err(|_| "not a number")?),
            Some(("tint", tint)) => FakeObject::Tint(tint.parse().map_err(|_| "not a number")?),
            Some(("gate", tint)) => FakeObject::Gate(tint.parse().map_err(|_| "not a number")?),
            Some(("large", kib)) => FakeObject::Large(kib.parse().map_err(|_| "not a number")?),
            _ => return Err("checksum of tensor `toy` does not match".to_owned()),
        };
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        Ok(Arc::new(Named { fake_object, name, gate: path.with_extension("gate") }))
    })
}

struct Named {
    fake_object: FakeObject,
    name: String,
    gate: PathBuf,
}

impl Named {
    fn tint(&self) -> u32 {
        match self.fake_object {
            FakeObject::Tint(tint) | FakeObject::Gate(tint) => tint,
            _ => 2,
        }
    }
}

impl ServedObject for Named {
    fn row(&self) -> ObjectRow {
        let mut row = ObjectRow {
            state: ObjectState::Ready as u32,
            bodies: 1,
            degree_max: 512,
            diagonal_m: 1.0,
            ..ObjectRow::zeroed()
        };
        row.gamma_j_m2 = f64::from(self.tint());
        row.set_name(&self.name);
        row.set_material("toy");
        row
    }

    fn bytes(&self) -> usize {
        1000 * self.tint() as usize
    }

    fn result_bytes_max(&self) -> usize {
        1
    }

    fn strike(
        &self,
        strike: &Request,
        _: &mut Workspace,
        token: &CancelToken,
        observer: &dyn StageObserver,
    ) -> Result<Box<dyn EngineResult>, Error> {
        observer.stage(Stage::Load).produced_bytes(7);
        let sites = match (strike.purpose, strike.degree) {
            (Purpose::Threshold, _) => 0,
            (_, shatter_proto::request::DegreeRule::Sites(sites)) => sites as usize,
            _ => 1,
        };
        match self.fake_object {
            FakeObject::Panic => panic!("the toy is broken"),
            FakeObject::Slow => wait(token, || true)?,
            FakeObject::Gate(_) => wait(token, || self.gate.exists())?,
            FakeObject::Brief(ms) => last(token, ms)?,
            FakeObject::Sites(ms) => last(token, ms * sites as u64)?,
            _ => {}
        }
        let idle = if let FakeObject::Large(kib) = self.fake_object { kib * 1024 / size_of::<[f32; 3]>() } else { 0 };
        Ok(Box::new(Tetrahedra { name: self.name.clone(), sites, idle, seed: strike.seed, tint: self.tint() }))
    }
}

/// Computes for `ms` milliseconds.
fn last(token: &CancelToken, ms: u64) -> Result<(), Error> {
    let begun = Instant::now();
    wait(token, || begun.elapsed() < Duration::from_millis(ms))
}

/// Computes while `must` holds, but no longer than a minute.
fn wait(token: &CancelToken, must: impl Fn() -> bool) -> Result<(), Error> {
    let begun = Instant::now();
    while must() && begun.elapsed() < Duration::from_secs(60) {
        token.check().map_err(|error| Error::new(ErrorKind::Canceled, "client", error.to_string()))?;
        std::thread::sleep(Duration::from_millis(1));
    }
    Ok(())
}

struct Tetrahedra {
    name: String,
    sites: usize,
    idle: usize,
    seed: u64,
    tint: u32,
}

impl EngineResult for Tetrahedra {
    fn counts(&self) -> SectionCounts {
        let n = self.sites;
        let vertices = 4 * n + self.idle;
        SectionCounts { fragments: n, runs: n, merges: n, vertices, indices: 12 * n, ..SectionCounts::default() }
    }

    fn write(&self, sections: &mut SectionsMut<'_>, _: &dyn StageObserver) -> Result<(), Error> {
        let range = |start: usize, bytes: usize| (self.name.clone(), start..start + bytes);
        let parts: [_; PARTS] = [
            range(sections.positions.as_ptr() as usize, size_of_val(sections.positions)),
            range(sections.indices.as_ptr() as usize, size_of_val(sections.indices)),
            range(sections.merges.as_ptr() as usize, size_of_val(sections.merges)),
        ];
        WRITTEN.lock().unwrap().extend(parts);
        let mut summary = SummaryWire { seed: self.seed, sites: self.sites as u32, ..SummaryWire::zeroed() };
        (summary.gamma_j_m2, summary.e1_over_gamma, summary.threshold_impulse_factor) =
            (f64::from(self.tint), 4.0, 0.5);
        summary.fracture_degree = self.sites.max(1) as u32;
        summary.set_object(&self.name);
        *sections.summary = summary;
        sections.positions.fill([self.seed as f32; 3]);
        let corners = CORNERS.map(|corner| corner.map(|x| 0.5 * self.tint as f32 * x));
        for i in 0..self.sites {
            sections.positions[4 * i..][..4].copy_from_slice(&corners);
            sections.indices[12 * i..][..12].copy_from_slice(&FACES);
            sections.merges[i] = [0, 0];
            sections.fragments[i] = fragment(i as u32);
            sections.runs[i] = RunWire { neighbor: OUTER, material: 0, ..run(i as u32) };
        }
        Ok(())
    }
}

fn fragment(i: u32) -> FragmentWire {
    FragmentWire {
        id: i,
        vertex_first: 4 * i,
        vertex_count: 4,
        index_first: 12 * i,
        index_count: 12,
        run_first: i,
        run_count: 1,
        merge_first: i,
        merge_count: 1,
        volume_m3: 1.0 / 6.0,
        mass_kg: 2.0,
        ..FragmentWire::zeroed()
    }
}

fn run(i: u32) -> RunWire {
    RunWire {
        fragment: i,
        vertex_first: 4 * i,
        vertex_count: 4,
        index_first: 12 * i,
        index_count: 12,
        ..RunWire::zeroed()
    }
}
