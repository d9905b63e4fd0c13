//! Judge of a mutant: bakes, strikes and checks it within a deadline.

use super::check::{FuzzFault, check};
use super::inside::clearly_has_inside;
use super::{MeshSize, Mutant, kinds};
use rayon::ThreadPoolBuilder;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeError, BakeRequest, bake};
use shatter_fracture::lift::LiftKind;
use shatter_fracture::pipeline::{self, DegreeRequest, FractureError, FractureRequest, PreparedObject, Workspace};
use shatter_fracture::scene::{Material, MaterialError};
use shatter_fracture::surface::RawMesh;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

/// Spacings over the diagonal on small meshes, coarse for speed.
const ELASTIC_SPACING: f64 = 0.1;
const CRACK_SPACING: f64 = 1.0 / 16.0;

/// Number of sites of the request.
const SITES: u32 = 8;

/// Outcome for a mutant.
#[derive(Clone, Debug, PartialEq)]
pub enum FuzzVerdict {
    /// Baked and broken; all checks passed.
    Checked {
        /// Hash of the fragments' meshes.
        geometry: u64,
        /// Volume inside the input surface, as the engine computed it, m³.
        volume_m3: f64,
        /// Why the fragments have the lattice's surface; `None` if they have the input's.
        reason: Option<String>,
    },
    /// Refused with an error.
    Refused {
        /// Kind of the error on the command line.
        kind: &'static str,
        /// Message of the error.
        message: String,
        /// Whether the error is justified: the defect may be refused, and the mesh does not clearly have an inside.
        justified: bool,
    },
    /// Failed.
    Failed(FuzzFault),
}

/// Judge of meshes, with fixed settings.
#[derive(Clone, Debug)]
pub struct Judge {
    pub(super) material: Material,
    pub(super) size: MeshSize,
    /// Time limit for a mesh.
    pub deadline: Duration,
    /// Number of worker threads, at least one.
    pub threads: usize,
}

impl Judge {
    /// Creates a judge with one thread, the material glass and a time limit.
    ///
    /// # Errors
    /// The program's own table of materials has no glass.
    pub fn new(size: MeshSize, deadline: Duration) -> Result<Self, MaterialError> {
        Ok(Self { material: Material::named("glass")?, size, deadline, threads: 1 })
    }

    /// Judges a mutant of `mesh`.
    pub fn mutant(&self, mesh: &RawMesh, mutant: &Mutant) -> FuzzVerdict {
        self.mesh(&mutant.defect.apply(mesh, mutant.seed), mutant.defect.must_accept(), mutant.seed)
    }

    /// Bakes and strikes `raw` and checks the result; `seed` chooses the contact.
    pub fn mesh(&self, raw: &RawMesh, must_accept: bool, seed: u64) -> FuzzVerdict {
        let (judge, mesh) = (self.clone(), raw.clone());
        let walk = move |token: &CancelToken| judge.walk(&mesh, seed, token);
        match timed(self.threads, self.deadline, walk) {
            Err(fault) | Ok(Err(FuzzStop::Failed(fault))) => FuzzVerdict::Failed(fault),
            Ok(Err(FuzzStop::Refused(kind, message))) => {
                FuzzVerdict::Refused { kind, message, justified: !must_accept && !clearly_has_inside(raw) }
            }
            Ok(Ok(checked)) => checked,
        }
    }

    fn walk(&self, raw: &RawMesh, seed: u64, token: &CancelToken) -> Result<FuzzVerdict, FuzzStop> {
        let prepared = bake(raw.clone(), &self.request(), token, &mut |_| ())?;
        let strike = request(&prepared, seed);
        let outcome =
            pipeline::strike(pipeline::RequestContext::new(&prepared, &strike, token, &()), &mut Workspace::default())?;
        let geometry = check(&prepared, &outcome)?;
        let report = prepared.report;
        Ok(FuzzVerdict::Checked { geometry, volume_m3: report.input_volume_m3, reason: report.surface.reason })
    }

    fn request(&self) -> BakeRequest {
        let is_small = self.size == MeshSize::Small;
        BakeRequest {
            elastic_spacing: is_small.then_some(ELASTIC_SPACING),
            crack_spacing: is_small.then_some(CRACK_SPACING),
            // Fitting κ would take most of the time, and does not matter when the number of sites is given.
            kappa: Some(2.0),
            ..BakeRequest::new("mutant", "glass", self.material.clone())
        }
    }
}

/// Runs `work` on a separate pool, so that neither its time nor a panic affects other work. Cancels it at the deadline; if it reaches no
/// checkpoint for as long again, it is abandoned while it runs.
fn timed<T: Send + 'static>(
    threads: usize,
    deadline: Duration,
    work: impl FnOnce(&CancelToken) -> T + Send + 'static,
) -> Result<T, FuzzFault> {
    let pool = ThreadPoolBuilder::new().num_threads(threads.max(1)).build();
    let pool = pool.map_err(|error| FuzzFault::Threads(error.to_string()))?;
    let (token, begun) = (CancelToken::default(), Instant::now());
    let (sender, receiver) = channel();
    let watched = token.clone();
    pool.spawn(move || {
        let ended = catch_unwind(AssertUnwindSafe(|| work(&watched)));
        // Abandoned work has no receiver.
        let _ = sender.send(ended);
    });
    let ended = receiver.recv_timeout(deadline).or_else(|_| {
        token.cancel();
        receiver.recv_timeout(deadline)
    });
    match ended {
        Err(_) => Err(FuzzFault::Stuck { seconds: begun.elapsed().as_secs_f64() }),
        Ok(Err(panic)) => Err(FuzzFault::Panicked(words(&*panic))),
        Ok(Ok(_)) if begun.elapsed() > deadline => Err(FuzzFault::Deadline { seconds: deadline.as_secs_f64() }),
        Ok(Ok(value)) => Ok(value),
    }
}

/// Reason for ending before the result is checked.
enum FuzzStop {
    Refused(&'static str, String),
    Failed(FuzzFault),
}

impl From<BakeError> for FuzzStop {
    fn from(error: BakeError) -> Self {
        match kinds::rejection(error) {
            Ok((kind, message)) => Self::Refused(kind, message),
            Err(message) => Self::Failed(FuzzFault::Bake(message)),
        }
    }
}

impl From<FractureError> for FuzzStop {
    fn from(error: FractureError) -> Self {
        Self::Failed(FuzzFault::Strike(error.to_string()))
    }
}

impl From<FuzzFault> for FuzzStop {
    fn from(fault: FuzzFault) -> Self {
        Self::Failed(fault)
    }
}

/// Impact of 1 N·s into a face of the largest body, chosen by `seed`.
fn request(prepared: &PreparedObject, seed: u64) -> FractureRequest {
    let body = &prepared.bodies[0];
    let faces = &body.topology.boundary;
    let face = &faces[(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) % faces.len() as u64) as usize];
    let [a, b, c] = face.nodes.map(|node| body.crack.nodes[node as usize]);
    let middle = (a.coords + b.coords + c.coords) / 3.0;
    let point_m = prepared.frame.to_meters(&middle.into());
    FractureRequest {
        degree: DegreeRequest::Sites(SITES),
        lift: if seed % 4 == 3 { LiftKind::Euclidean } else { LiftKind::Interior },
        seed,
        ..FractureRequest::at(point_m, -(b - a).cross(&(c - a)).normalize())
    }
}

/// Message of a panic.
fn words(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "without a message".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHORT: Duration = Duration::from_millis(50);

    fn check(
        work: impl FnOnce(&CancelToken) -> u32 + Send + 'static,
        ends: impl FnOnce(Result<u32, FuzzFault>) -> bool,
    ) {
        assert!(ends(timed(1, SHORT, work)));
    }

    #[test]
    fn work_in_time_is_returned() {
        assert_eq!(timed(2, Duration::from_secs(60), |_| rayon::current_num_threads()), Ok(2));
    }

    #[test]
    fn a_panic_is_reported_with_its_message() {
        let panicked = timed(1, Duration::from_secs(60), |_| -> u32 { panic!("index {}", 7) });
        assert_eq!(panicked, Err(FuzzFault::Panicked("index 7".to_owned())));
    }

    #[test]
    fn late_work_is_canceled_and_has_failed() {
        let until_canceled = |token: &CancelToken| {
            while token.check().is_ok() {
                std::thread::yield_now();
            }
            1
        };
        check(until_canceled, |ended| matches!(ended, Err(FuzzFault::Deadline { .. })));
    }

    #[test]
    fn work_that_ignores_cancellation_is_abandoned() {
        let (end, wait) = channel::<()>();
        check(move |_| u32::from(wait.recv().is_ok()), |ended| matches!(ended, Err(FuzzFault::Stuck { .. })));
        drop(end);
    }
}
