//! Requests to the engine itself, for tests of its internals.

use nalgebra::{Point3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::centroidal::{self, Diagram, DiagramOptions, EnergyField};
use shatter_fracture::lift::LiftKind;
use shatter_fracture::pipeline::{
    self, BodyEnergy, ContactSet, FractureError, FractureOutcome, FractureRequest, PreparedObject, Workspace,
};

/// Runs all stages of a request.
pub fn outcome(prepared: &PreparedObject, strike: &FractureRequest) -> Result<FractureOutcome, FractureError> {
    pipeline::strike(
        pipeline::RequestContext::new(prepared, strike, &CancelToken::default(), &()),
        &mut Workspace::default(),
    )
}

/// Strain energy of the first struck body.
pub fn energy(prepared: &PreparedObject, strike: &FractureRequest) -> BodyEnergy {
    let impact = ContactSet::new(prepared, strike).unwrap();
    let mut workspace = Workspace::default();
    let mut all = pipeline::strain_energy(
        pipeline::RequestContext::new(prepared, strike, &CancelToken::default(), &()),
        &impact,
        &mut workspace,
    )
    .unwrap();
    all.remove(0)
}

/// A diagram of `sites` sites of the first body for the given energy shares.
pub fn diagram(prepared: &PreparedObject, lift: LiftKind, shares: &[f64], sites: usize, seed: u64) -> Diagram {
    let body = &prepared.bodies[0];
    let mut shares = shares.to_vec();
    let field = EnergyField::new(body.lift(lift).unwrap(), &body.volumes, &mut shares).unwrap();
    let mut workspace = centroidal::DiagramWorkspace::default();
    centroidal::diagram(&field, &DiagramOptions::new(sites, seed), &mut workspace, &CancelToken::default()).unwrap()
}

/// Radius around a surface point from which its normal is taken, local.
const PATCH: f64 = 0.025;

/// The point of the mesh file's box at the fractions `at` (0 ..= 1 along each axis), moved to the body's nearest boundary node; and the
/// mean inward normal around it.
pub fn surface_point(prepared: &PreparedObject, at: [f64; 3]) -> (Point3<f64>, Vector3<f64>) {
    let body = &prepared.bodies[0];
    let nodes = &body.crack.nodes;
    let low = nodes.iter().fold([f64::INFINITY; 3], |low, node| [0, 1, 2].map(|k| low[k].min(node[k])));
    let high = nodes.iter().fold([f64::NEG_INFINITY; 3], |high, node| [0, 1, 2].map(|k| high[k].max(node[k])));
    let target = Point3::from([0, 1, 2].map(|k| low[k] + at[k] * (high[k] - low[k])));
    let faces = body.topology.boundary.iter().map(|face| face.nodes.map(|node| nodes[node as usize]));
    let nearest = faces.clone().flatten().min_by(|a, b| (a - target).norm().total_cmp(&(b - target).norm())).unwrap();
    let around = faces.filter(|[a, ..]| (a - nearest).norm() < PATCH);
    let outward: Vector3<f64> = around.map(|[a, b, c]| (b - a).cross(&(c - a))).sum();
    (prepared.frame.to_meters(&nearest), -outward.normalize())
}
