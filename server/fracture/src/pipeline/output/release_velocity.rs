//! Release velocities: motion of the fragments by the released strain energy.
//!
//! Ours. A share η of each fragment's strain energy becomes kinetic energy, directed away from the center of the
//! energy. The common rigid motion is then removed, so that linear and angular momentum vanish. In the metric of the
//! masses this is a projection, which never adds kinetic energy. Anchored fragments are then set to zero. The world
//! takes up their momentum, so the total momentum of an anchored body's fragments does not vanish.

use crate::centroidal::EnergyField;
use crate::fragment::RigidProperties;
use crate::lattice::Lattice;
use crate::surface::LocalFrame;
use nalgebra::{Matrix3, Point3, Vector3};

/// Share η of the strain energy that becomes kinetic. The larger part goes into surfaces, sound and heat.
pub const RELEASE_SHARE: f64 = 0.1;

/// Velocity of one fragment, relative to the motion of the object.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReleaseVelocity {
    /// Velocity of the center of mass, m/s.
    pub linear_m_s: Vector3<f64>,
    /// Angular velocity, rad/s.
    pub angular_rad_s: Vector3<f64>,
}

/// A fragment as a rigid body in SI units, relative to a point near all fragments.
struct Rigid {
    mass: f64,
    place: Vector3<f64>,
    inertia: Matrix3<f64>,
}

/// Velocities of the fragments of one body. `labels` has one entry per node of `lattice`.
///
/// `energy_j`: strain energy of the body, J; 0 if it was not struck.
pub(in crate::pipeline) fn velocities(
    properties: &[RigidProperties],
    labels: &[u32],
    lattice: &Lattice,
    field: Option<&EnergyField>,
    energy_j: f64,
    density_kg_m3: f64,
    frame: &LocalFrame,
) -> Vec<ReleaseVelocity> {
    let still = vec![ReleaseVelocity::default(); properties.len()];
    let Some(field) = field.filter(|_| still.len() > 1) else { return still };
    let (shares, center) = shares(labels, still.len(), lattice, field);
    let meter = frame.diagonal_m;
    let rigid = |properties: &RigidProperties| Rigid {
        mass: properties.volume * meter.powi(3) * density_kg_m3,
        place: (properties.center - center) * meter,
        inertia: properties.inertia * (meter.powi(5) * density_kg_m3),
    };
    let bodies: Vec<Rigid> = properties.iter().map(rigid).collect();
    let away = |(body, share): (&Rigid, &f64)| {
        let speed = (2.0 * RELEASE_SHARE * share * energy_j / body.mass).sqrt();
        ReleaseVelocity {
            linear_m_s: body.place.try_normalize(0.0).unwrap_or_default() * speed,
            ..ReleaseVelocity::default()
        }
    };
    let mut velocities: Vec<ReleaseVelocity> = bodies.iter().zip(&shares).map(away).collect();
    // The second pass removes the rounding errors of the first.
    for _ in 0..2 {
        take_out_rigid_motion(&bodies, &mut velocities);
    }
    velocities
}

/// Share of the energy in each fragment, and the center of the energy, local.
fn shares(labels: &[u32], fragments: usize, lattice: &Lattice, field: &EnergyField) -> (Vec<f64>, Point3<f64>) {
    let (mut shares, mut center, mut total) = (vec![0.0; fragments], Vector3::zeros(), 0.0);
    for ((&label, node), mass) in labels.iter().zip(&lattice.nodes).zip(field.mass()) {
        shares[label as usize] += mass;
        center += node.coords * *mass;
        total += mass;
    }
    shares.iter_mut().for_each(|share| *share /= total);
    (shares, Point3::from(center / total))
}

fn take_out_rigid_motion(bodies: &[Rigid], velocities: &mut [ReleaseVelocity]) {
    let mass: f64 = bodies.iter().map(|body| body.mass).sum();
    let center = bodies.iter().map(|body| body.place * body.mass).sum::<Vector3<f64>>() / mass;
    let pairs = || bodies.iter().zip(velocities.iter());
    let linear = pairs().map(|(body, velocity)| velocity.linear_m_s * body.mass).sum::<Vector3<f64>>() / mass;
    let angular: Vector3<f64> = pairs()
        .map(|(body, own)| {
            (body.place - center).cross(&(own.linear_m_s * body.mass)) + body.inertia * own.angular_rad_s
        })
        .sum();
    let whole: Matrix3<f64> = bodies
        .iter()
        .map(|body| {
            let lever = body.place - center;
            let orbit = Matrix3::identity() * lever.norm_squared() - lever * lever.transpose();
            body.inertia + orbit * body.mass
        })
        .sum();
    let spin = whole.cholesky().map_or(Vector3::zeros(), |factor| factor.solve(&angular));
    for (body, velocity) in bodies.iter().zip(velocities) {
        velocity.linear_m_s -= linear + spin.cross(&(body.place - center));
        velocity.angular_rad_s -= spin;
    }
}
