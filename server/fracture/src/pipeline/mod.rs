//! The path of a request from an impact to fragments, in the order of the method.

mod aim;
mod contact;
mod error;
mod output;
mod prepared;
mod request;
mod restrike;
mod result;
mod stages;
mod training;
mod walk;
mod workspace;

pub use aim::{AimRay, SurfaceHit, aim, aim_again};
pub use contact::{ImpactContact, ImpactPartner, PartnerError};
pub use error::{CONTACTS_MAX, FractureError, NODES_MIN, RAY_ORIGIN_MAX_M, SOLVED_NODES_MAX, TETS_MIN};
pub use output::emitted_effects::*;
pub use output::emitted_meshes::{EmittedMeshes, FragmentMesh};
pub use output::hulls::{FragmentHulls, HULL_COVERAGE, HullRow};
pub use output::ledger::EnergyLedger;
pub use output::meshes::FractureMeshes;
pub use output::release_velocity::{RELEASE_SHARE, ReleaseVelocity};
pub use output::retained::RetainedFragments;
pub use output::rows::{BondRow, BulkCounts, FragmentRow, OUTER, RunRow, WORLD};
pub use output::skins::{FragmentSkins, SkinRow, SkinVertexRow};
pub use output::slivers::SLIVER_CUBES;
pub use output::vertex_attributes::{OuterVertexAttributes, VertexAttributes};
pub use prepared::anchored::{AnchorError, AnchorNodes, AnchoredBasis, AnchoredBody, AnchoredObject};
pub use prepared::energy_bound::EnergyUpperBound;
pub use prepared::example::{DegreeCurvePoint, TrainingExample};
pub use prepared::intact_body::IntactBody;
pub use prepared::learned::{LearnedErrors, LearnedModel};
pub use prepared::memory::MemoryRows;
pub use prepared::object::{ElasticModel, PreparedBody, PreparedObject};
pub use prepared::parameters::{
    BakeParameters, BakeReport, CELLS_LINEAR_MIN, CELLS_MAX, DisplacementMethod, ElasticReport, ElementChoice,
    ExistingCracks, MissingLift, RANK_MAX, SurfaceKind, SurfaceReport,
};
pub use prepared::preset::{LatticeSettings, Preset};
pub use prepared::reduction::{CompletionErrors, ReductionErrors};
pub use prepared::warped_body::{WarpError, WarpedBody};
pub use request::budget::{DEGRADED_ERROR_MAX, DEGRADED_RANK_MAX, TimeBudget};
pub use request::context::RequestContext;
pub use request::cost::{CostSample, RequestCost};
pub use request::fracture_request::{DegreeRequest, FractureRequest, SEED_DEFAULT};
pub use request::observer::{EffectSpan, StageObserver, StageSpan};
pub use request::solver_settings::{GAME_ERROR_MAX, GAME_TOLERANCE, REDUCED_ERROR_MAX, SolverSettings};
pub use request::stage::Stage;
pub use restrike::strike_again;
pub use result::{Fracture, FractureOutcome, ImpactorReport, ThresholdReport};
pub use stages::cells::{BodyCells, DegreeSource};
pub use stages::contact_set::ContactSet;
pub use stages::energy::{BodyEnergy, strain_energy};
pub use stages::indentation::IndentationEnergy;
pub use stages::onset::{OnsetReport, StressPeak};
pub use stages::termination::{StopReason, Termination};
pub use stages::threshold::ThresholdResult;
pub use training::anchored::{AnchoredBasisError, reduce_anchored};
pub use training::calibrate::calibrate;
pub use training::compare::{LiftComparison, LiftComparisonError, LiftRow};
pub(crate) use training::discretization::{REFINED_NODES_MAX, estimate_discretization, raise_orders};
pub use training::examples::examples;
pub(crate) use training::learn::samples;
pub use training::learn::{learn, sampled};
pub(crate) use training::reduce::BASIS_BYTES_MAX_QUADRATIC;
pub use training::reduce::reduce;
pub use training::sample::ImpactSampler;
pub use walk::strike;
pub use workspace::Workspace;

/// Largest number of sites of one request.
pub const DEGREE_MAX: u32 = 512;
