//! Inertia relief: d'Alembert forces of the rigid acceleration that a load causes in a free body.
//!
//! The acceleration a(x) = a₀ + α × (x − c) is linear in x, so its consistent forces ∫ φ_i a(x) dx
//! need only two integrals per node, m_i = ∫ φ_i and s_i = ∫ φ_i (x − c): f_i = m_i a₀ + α × s_i. They
//! are exact for linear tetrahedra.

use crate::lattice::Lattice;
use crate::memory::held;
use nalgebra::{Matrix3, Vector3};

/// Mass distribution of one body of unit density.
#[derive(Clone, Debug)]
pub struct Inertia {
    volume: f64,
    /// Node positions relative to the center of mass, x_i − c.
    arms: Vec<Vector3<f64>>,
    /// Nodal masses m_i; their sum is the volume.
    masses: Vec<f64>,
    /// Nodal first moments s_i; their sum is 0.
    moments: Vec<Vector3<f64>>,
    /// Inverse of the inertia tensor about c.
    compliance: Matrix3<f64>,
}

impl Inertia {
    /// Computes the mass distribution. `None` if the body has no volume.
    pub fn new(lattice: &Lattice) -> Option<Self> {
        let masses = lattice.node_volumes();
        let volume: f64 = masses.iter().sum();
        let center = masses.iter().zip(&lattice.nodes).map(|(m, x)| x.coords * *m).sum::<Vector3<f64>>() / volume;
        let arms: Vec<_> = lattice.nodes.iter().map(|x| x.coords - center).collect();
        let mut moments = vec![Vector3::zeros(); arms.len()];
        for (tet, nodes) in lattice.tets.iter().enumerate() {
            // ∫ φ_i φ_j = V (1 + δ_ij) / 20.
            let sum: Vector3<f64> = nodes.iter().map(|&node| arms[node as usize]).sum();
            let share = lattice.tet_volume(tet) / 20.0;
            for &node in nodes {
                moments[node as usize] += (sum + arms[node as usize]) * share;
            }
        }
        let tensor: Matrix3<f64> =
            arms.iter().zip(&moments).map(|(r, s)| Matrix3::from_diagonal_element(r.dot(s)) - s * r.transpose()).sum();
        let compliance = (tensor + tensor.transpose()).scale(0.5).cholesky()?.inverse();
        Some(Self { volume, arms, masses, moments, compliance })
    }

    /// Net force, and net torque about the center of mass, of `forces` (three components per node).
    pub fn net(&self, forces: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
        let (mut force, mut torque) = (Vector3::zeros(), Vector3::zeros());
        for (arm, own) in self.arms.iter().zip(forces.chunks_exact(3)) {
            let own = Vector3::from_column_slice(own);
            force += own;
            torque += arm.cross(&own);
        }
        (force, torque)
    }

    /// Bytes of memory that it holds.
    pub fn bytes(&self) -> usize {
        held(&self.arms) + held(&self.masses) + held(&self.moments)
    }

    /// Subtracts the inertial forces that `forces` cause, so that net force and torque vanish.
    pub fn relieve(&self, forces: &mut [f64]) {
        self.balance(&self.acceleration(self.net(forces)), forces);
    }

    /// Rigid acceleration, linear and angular, that the `applied` forces cause.
    pub fn acceleration_of(&self, applied: &[(u32, Vector3<f64>)]) -> [Vector3<f64>; 2] {
        let add = |(force, torque): (Vector3<f64>, Vector3<f64>), (node, own): &(u32, Vector3<f64>)| {
            (force + own, torque + self.arms[*node as usize].cross(own))
        };
        self.acceleration(applied.iter().fold((Vector3::zeros(), Vector3::zeros()), add))
    }

    /// Subtracts the inertial forces of `acceleration`, the acceleration that `forces` cause.
    ///
    /// A second pass removes the rounding error of the first. That error is all that remains of a load that equals a
    /// rigid acceleration.
    pub fn balance(&self, acceleration: &[Vector3<f64>; 2], forces: &mut [f64]) {
        let rest = self.acceleration(self.subtract(forces, acceleration));
        self.subtract(forces, &rest);
    }

    /// Subtracts the inertial forces of `acceleration`, which `forces` need not cause.
    pub fn subtract_from(&self, forces: &mut [f64], acceleration: &[Vector3<f64>; 2]) {
        self.subtract(forces, acceleration);
    }

    /// Rigid acceleration, linear and angular, under a net force and torque.
    pub fn acceleration(&self, (force, torque): (Vector3<f64>, Vector3<f64>)) -> [Vector3<f64>; 2] {
        [force / self.volume, self.compliance * torque]
    }

    /// Product in mass of the rigid motions of two displacements with this `work` of the inertial forces of unit accelerations.
    pub fn rigid_product(&self, work: &[f64; 6], other: &[f64; 6]) -> f64 {
        let [linear, angular] = [0, 3].map(|first| Vector3::from_column_slice(&work[first..first + 3]));
        let motion = self.acceleration((linear, angular));
        let [linear, angular] = [0, 3].map(|first| Vector3::from_column_slice(&other[first..first + 3]));
        motion[0].dot(&linear) + motion[1].dot(&angular)
    }

    /// Subtracts the inertial forces of an acceleration, and returns net force and torque of the rest.
    ///
    /// Inlined, so that callers that ignore the sums do not compute them.
    #[inline(always)]
    fn subtract(&self, forces: &mut [f64], acceleration: &[Vector3<f64>; 2]) -> (Vector3<f64>, Vector3<f64>) {
        let (mut force, mut torque) = (Vector3::zeros(), Vector3::zeros());
        for (node, (own, arm)) in forces.chunks_exact_mut(3).zip(&self.arms).enumerate() {
            let left = Vector3::from_column_slice(own) - self.force(node, acceleration);
            own.copy_from_slice(left.as_slice());
            force += left;
            torque += arm.cross(&left);
        }
        (force, torque)
    }

    /// Mass m_i of node `node`.
    pub fn mass(&self, node: usize) -> f64 {
        self.masses[node]
    }

    /// Position of node `node` relative to the center of mass.
    pub fn arm(&self, node: usize) -> Vector3<f64> {
        self.arms[node]
    }

    /// Inertial force on node `node` under an acceleration, linear and angular.
    pub fn force(&self, node: usize, [linear, angular]: &[Vector3<f64>; 2]) -> Vector3<f64> {
        linear * self.masses[node] + angular.cross(&self.moments[node])
    }
}
