//! Checks of a result, and their errors.

use shatter_fracture::fragment::{OpenMesh, closed};
use shatter_fracture::pipeline::{FractureMeshes, FractureOutcome, PreparedObject};
use std::hash::{DefaultHasher, Hasher};

/// Relative tolerance of the sum of fragment volumes against the object's volume.
const VOLUME_TOLERANCE: f64 = 1e-6;

/// Failure of a mutant: the engine neither returned a valid result nor an error.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FuzzFault {
    /// The engine panicked.
    #[error("panicked: {0}")]
    Panicked(String),
    /// The engine did not end in time.
    #[error("took longer than {seconds} s")]
    Deadline {
        /// Time limit, s.
        seconds: f64,
    },
    /// The engine continued after cancellation.
    #[error("still running after {seconds} s, in spite of cancellation")]
    Stuck {
        /// Time waited, s.
        seconds: f64,
    },
    /// No worker threads could be created.
    #[error("threads: {0}")]
    Threads(String),
    /// Baking failed with an internal error.
    #[error("bake: {0}")]
    Bake(String),
    /// A valid request failed.
    #[error("strike: {0}")]
    Strike(String),
    /// A number is infinite or NaN.
    #[error("{0} is not finite")]
    NotFinite(&'static str),
    /// A fragment's mesh is not a closed surface.
    #[error("fragment {fragment}: {open}")]
    Open {
        /// Number of the fragment.
        fragment: u32,
        /// The defect.
        open: OpenMesh,
    },
    /// A fragment has no volume or mass.
    #[error("fragment {fragment}: volume {volume_m3} m³, mass {mass_kg} kg")]
    Empty {
        /// Number of the fragment.
        fragment: u32,
        /// Volume, m³.
        volume_m3: f64,
        /// Mass, kg.
        mass_kg: f64,
    },
    /// The fragments' volumes do not add up to the object's.
    #[error("the fragments have {fragments_m3} m³, the object {object_m3} m³")]
    VolumeSum {
        /// Sum over the fragments, m³.
        fragments_m3: f64,
        /// Volume of the object, m³.
        object_m3: f64,
    },
    /// Another number of threads gave another result.
    #[error("another result on another number of threads: {0}")]
    Differs(String),
}

/// Checks every number and every mesh of a result, and returns a hash of its geometry.
pub(super) fn check(prepared: &PreparedObject, outcome: &FractureOutcome) -> Result<u64, FuzzFault> {
    let report = &prepared.report;
    finite("kappa", &[prepared.kappa])?;
    finite("gamma", &[prepared.gamma_j_m2, outcome.threshold().gamma_j_m2])?;
    finite("the report", &[report.input_volume_m3, report.lattice_volume_m3, report.surface_deviation])?;
    finite("E_1/gamma", &[outcome.threshold().e1_over_gamma, outcome.threshold().impulse_factor])?;
    finite("the radius", &[outcome.threshold().radius_m, outcome.confidence()])?;
    let Some(pieces) = &outcome.meshes() else {
        return Err(FuzzFault::Strike("the object stayed whole, although a number of sites was requested".to_owned()));
    };
    rows(pieces, prepared.volume_m3())?;
    meshes(pieces)
}

fn finite(what: &'static str, numbers: &[f64]) -> Result<(), FuzzFault> {
    if numbers.iter().all(|number| number.is_finite()) { Ok(()) } else { Err(FuzzFault::NotFinite(what)) }
}

/// Checks masses, centers and inertias, and the sum of the volumes.
fn rows(pieces: &FractureMeshes, object_m3: f64) -> Result<(), FuzzFault> {
    for row in &pieces.fragments {
        finite("a center", &row.center_m)?;
        finite("an inertia", &row.inertia_kg_m2)?;
        finite("an energy", &[row.energy_j_m2])?;
        finite("a mass", &[row.volume_m3, row.mass_kg])?;
        if !(row.volume_m3 > 0.0 && row.mass_kg > 0.0) {
            return Err(FuzzFault::Empty { fragment: row.id, volume_m3: row.volume_m3, mass_kg: row.mass_kg });
        }
    }
    let fragments_m3: f64 = pieces.fragments.iter().map(|row| row.volume_m3).sum();
    if (fragments_m3 / object_m3 - 1.0).abs() <= VOLUME_TOLERANCE {
        Ok(())
    } else {
        Err(FuzzFault::VolumeSum { fragments_m3, object_m3 })
    }
}

/// Writes the meshes as the daemon does and checks each as a client does.
fn meshes(pieces: &FractureMeshes) -> Result<u64, FuzzFault> {
    let emitted = pieces.emitted().map_err(|error| FuzzFault::Strike(error.to_string()))?;
    for fragment in emitted.fragments() {
        let open = |open| FuzzFault::Open { fragment: fragment.row.id, open };
        closed(fragment.positions, fragment.indices).map_err(open)?;
    }
    let mut hasher = DefaultHasher::new();
    hasher.write(bytemuck::cast_slice(&emitted.positions));
    hasher.write(bytemuck::cast_slice(&emitted.indices));
    hasher.write(bytemuck::cast_slice(&emitted.merges));
    Ok(hasher.finish())
}
