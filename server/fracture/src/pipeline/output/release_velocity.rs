//! Release: the strain energy that is set free sets the fragments in motion.
//!
//! Ours: a share η of each fragment's strain energy becomes its kinetic energy, away from where the energy was; then the rigid motion
//! of all together is taken out, so that neither linear nor angular momentum comes from nothing. In the metric of the masses
//! that is a projection: it never adds kinetic energy. Fragments that the world holds stand still after that: it takes up what they
//! would have had, so the momentum of an anchored body's fragments does not vanish.

use crate::centroidal::EnergyField;
use crate::fragment::RigidProperties;
use crate::lattice::Lattice;
use crate::surface::LocalFrame;
use nalgebra::{Matrix3, Point3, Vector3};

/// η: most of the energy makes surfaces, sound and heat.
pub const RELEASE_SHARE: f64 = 0.1;

/// Of one fragment, on top of how the object moved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReleaseVelocity {
    /// Of the center of mass, m/s.
    pub linear_m_s: Vector3<f64>,
    /// rad/s.
    pub angular_rad_s: Vector3<f64>,
}

/// A fragment as a rigid body, SI, about a point near all of them.
struct Rigid {
    mass: f64,
    place: Vector3<f64>,
    inertia: Matrix3<f64>,
}

/// Velocities of the fragments of one body, of which `labels` has one per node of `lattice`. `energy_j`: its strain energy; zero
/// where it was not struck.
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
    // The second pass takes out the rounding of the first.
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
