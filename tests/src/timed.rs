//! Timed requests, for benches: with their results written out, in buffers that are used again.

use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::pipeline::{
    self, DegreeRequest, FractureError, FractureRequest, ImpactSampler, PreparedObject, Preset, Workspace,
};
use shatter_fracture::surface::{self, LengthUnit, RawMesh, UpAxis, shapes};
use std::time::Instant;

/// True if cargo only tests that a bench starts.
pub fn only_begin() -> bool {
    std::env::args().any(|argument| argument == "--test")
}

/// The mesh file that `SHATTER_BENCH_MESH` names, in meters; else a generated statue of about 100,000 triangles.
pub fn mesh() -> RawMesh {
    match std::env::var_os("SHATTER_BENCH_MESH") {
        Some(path) => surface::read(path.as_ref(), LengthUnit::M, UpAxis::Y).unwrap(),
        None => shapes::scanned_statue(),
    }
}

/// Milliseconds since `begun`.
pub fn since_ms(begun: Instant) -> f64 {
    begun.elapsed().as_secs_f64() * 1e3
}

/// Requests of the preset `game` with `sites` sites, which are not examples of the object.
pub fn impacts(prepared: &PreparedObject, count: usize, sites: u32) -> Vec<FractureRequest> {
    let sampler = ImpactSampler::new(prepared);
    let impact = |index: usize| FractureRequest {
        degree: DegreeRequest::Sites(sites),
        ..sampler.impact(!prepared.parameters.seed, index as u64).of_quality(Preset::Game)
    };
    (0..count).map(impact).collect()
}

/// One request, and its outcome.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timed {
    /// Time from the request to the last byte of the result, ms.
    pub time_ms: f64,
    /// Number of fragments.
    pub fragments: usize,
    /// Number of triangles of all fragments.
    pub triangles: usize,
    /// Volume of all fragments, m³.
    pub volume_m3: f64,
    /// True if the displacements were solved for, because the reduced ones had too large an error.
    pub solved: bool,
}

/// Buffers of requests and of their results.
#[derive(Default)]
pub struct Stopwatch {
    workspace: Workspace,
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    merges: Vec<[u32; 2]>,
}

impl Stopwatch {
    /// Runs a request, and writes the result out.
    ///
    /// # Errors
    /// Those of the request. An object that stays whole is a panic: benches ask for a number of sites.
    pub fn strike(&mut self, prepared: &PreparedObject, strike: &FractureRequest) -> Result<Timed, FractureError> {
        let begun = Instant::now();
        let outcome = pipeline::strike(
            pipeline::RequestContext::new(prepared, strike, &CancelToken::default(), &()),
            &mut self.workspace,
        )?;
        let pieces = outcome.meshes().unwrap();
        self.positions.resize(pieces.counts.vertices, [0.0; 3]);
        self.indices.resize(pieces.counts.indices, 0);
        self.merges.resize(pieces.counts.merges, [0; 2]);
        pieces.emit(&mut self.positions, &mut self.indices, &mut self.merges)?;
        Ok(Timed {
            time_ms: since_ms(begun),
            fragments: pieces.fragments.len(),
            triangles: self.indices.len() / 3,
            volume_m3: pieces.fragments.iter().map(|fragment| fragment.volume_m3).sum(),
            solved: outcome.threshold().reduced_error.is_none(),
        })
    }
}
