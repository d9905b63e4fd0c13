//! Cases: loads that are too small, too concentrated, too far, or balanced.

use super::super::trial::{TrialFault, at, baked, coarse, sites, sound, struck};
use nalgebra::{Point3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::elasticity::{ContactLoad, DrivingEnergy, ElasticWorkspace, Elasticity, NodalLoad, Support};
use shatter_fracture::lattice::block;
use shatter_fracture::pipeline::{
    ContactSet, FractureRequest, PreparedObject, RequestContext, Workspace as Strikes, strain_energy,
};
use shatter_fracture::surface::shapes;

fn arch() -> Result<PreparedObject, TrialFault> {
    baked(shapes::arch(), &coarse()?)
}

/// Result of a plain request after `change`; must be sound.
fn after(change: impl FnOnce(&mut FractureRequest)) -> Result<f64, TrialFault> {
    let prepared = arch()?;
    let mut strike = at(&prepared, [0.4, 1.0, 0.1]);
    change(&mut strike);
    sound(&prepared, &struck(&prepared, &strike)?)
}

pub fn zero_impulse() -> Result<f64, TrialFault> {
    after(|strike| strike.contacts[0].impulse_ns = Vector3::zeros())
}

pub fn not_a_number() -> Result<f64, TrialFault> {
    after(|strike| strike.contacts[0].impulse_ns.y = f64::NAN)
}

pub fn infinite_point() -> Result<f64, TrialFault> {
    after(|strike| strike.contacts[0].point_m.x = f64::INFINITY)
}

pub fn tiny_duration() -> Result<f64, TrialFault> {
    after(|strike| strike.contacts[0].duration_s = Some(1e-310))
}

pub fn outside() -> Result<f64, TrialFault> {
    after(|strike| strike.contacts[0].point_m.y += 10.0)
}

pub fn tangential() -> Result<f64, TrialFault> {
    after(|strike| {
        let inward = strike.contacts[0].impulse_ns;
        strike.contacts[0].impulse_ns = inward.cross(&Vector3::new(0.3, 0.2, 0.9));
    })
}

pub fn tiny_impulse() -> Result<f64, TrialFault> {
    after(|strike| strike.contacts[0].impulse_ns *= 1e-150)
}

pub fn immense_impulse() -> Result<f64, TrialFault> {
    after(|strike| strike.contacts[0].impulse_ns *= 1e140)
}

pub fn two_opposed() -> Result<f64, TrialFault> {
    let prepared = baked(shapes::cuboid([1.0; 3]), &coarse()?)?;
    let half = Point3::new(0.5, 0.0, 0.0);
    let mut strike = sites(FractureRequest::at(half, -Vector3::x()).seeded(1), 12);
    strike.contacts.extend(FractureRequest::at(Point3::from(-half.coords), Vector3::x()).contacts);
    sound(&prepared, &struck(&prepared, &strike)?)
}

pub fn two_that_cancel() -> Result<f64, TrialFault> {
    after(|strike| {
        let mut back = strike.contacts[0];
        back.impulse_ns = -back.impulse_ns;
        strike.contacts.push(back);
    })
}

pub fn at_a_corner() -> Result<f64, TrialFault> {
    let prepared = baked(shapes::cuboid([1.0; 3]), &coarse()?)?;
    let corner = Point3::new(0.5, 0.5, 0.5);
    let mut strike = sites(FractureRequest::at(corner, -Vector3::repeat(1.0)).seeded(1), 12);
    strike.contacts[0].radius_m = Some(1e-9);
    sound(&prepared, &struck(&prepared, &strike)?)
}

/// Strain energy under a contact of vanishing radius on a cube with this elastic spacing, J.
fn point_load(spacing: f64) -> Result<f64, TrialFault> {
    let mut request = coarse()?;
    (request.elastic_spacing, request.crack_spacing) = (Some(spacing), Some(spacing.min(0.0625)));
    let prepared = baked(shapes::sphere(0.5, 5), &request)?;
    let mut strike = FractureRequest::at(Point3::new(0.5, 0.0, 0.0), -Vector3::x()).seeded(1);
    strike.contacts[0].radius_m = Some(1e-12);
    let impact = ContactSet::new(&prepared, &strike)?;
    let energies = strain_energy(
        RequestContext::new(&prepared, &strike, &CancelToken::default(), &()),
        &impact,
        &mut Strikes::default(),
    )?;
    Ok(energies.iter().map(|energy| energy.energy_j * energy.radius_m).sum())
}

/// Ratio of energy times contact radius between the two finest lattices; constant for a point load (energy ~ F²/(E r)).
pub fn point_load_under_refinement() -> Result<f64, TrialFault> {
    Ok(point_load(0.05)? / point_load(0.1)?)
}

/// Displacement under a load on anchored nodes, over that under the same load elsewhere.
pub fn on_an_anchor() -> Result<f64, TrialFault> {
    let lattice = block([4, 4, 4], 0.25);
    let low = (0..lattice.nodes.len() as u32).filter(|&node| lattice.nodes[node as usize].z < -0.49).collect();
    let body = Elasticity::supported(&lattice, 0.25, Support::Anchored(low), &CancelToken::default())?;
    let energy = |point: [f64; 3]| -> Result<f64, TrialFault> {
        let (mut load, mut displacement, mut energies) = (NodalLoad::default(), Vec::new(), Vec::new());
        let (mut workspace, token) = (ElasticWorkspace::default(), CancelToken::default());
        let contact = ContactLoad { point: Point3::from(point), impulse: Vector3::new(0.0, 0.0, -1.0), radius: 0.01 };
        body.load(&[contact], &mut load, &mut workspace)?;
        body.solve(&load.forces, &mut displacement, &mut workspace, &token)?;
        body.tet_energy(&lattice, &displacement, DrivingEnergy::Total, &mut energies, &token)?;
        Ok(energies.iter().sum())
    };
    Ok(energy([0.0, 0.0, -0.5])? / energy([0.0, 0.0, 0.5])?)
}
