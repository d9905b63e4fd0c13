//! Reduced elasticity: displacements as combinations of a few basis displacements, without a solve.
//!
//! Based on: L. Sirovich, *Turbulence and the dynamics of coherent structures* (Quarterly of Applied Mathematics 45,
//! 1987), method of snapshots, here in the energy inner product. The columns of B are the basis, with B'KB = 1. The
//! best displacement in their span is B(B'f), a Galerkin projection. Its energy ½|B'f|² never exceeds the true one.
//!
//! The missing energy is ½ r'K⁻¹r with the residual r = f − K u. Replacing K by its diagonal makes this cheap. The
//! result is about proportional to the true one over impacts of one body (a residual estimator: R. Verfürth, *A Review
//! of A Posteriori Error Estimation*, 1996). The fitted proportion is our own.

use super::enriched::CompletionTables;
use super::force_sums::ForceSums;
use super::residual::{self, ResidualForm};
use super::row_products::{self, ScaledRows};
use super::{DrivingEnergy, ElasticWorkspace, Elasticity, ElasticityError, NodalLoad, ReducedModes};
use crate::cancel_token::CancelToken;
use crate::lattice::Lattice;
use crate::memory::held;
use crate::simd::widest;
use nalgebra::Vector3;
use pulp::NullaryFnOnce;

/// K-orthonormal basis of displacements of one free body, the most energetic first.
#[derive(Clone, Debug, PartialEq)]
pub struct ReducedBasis {
    pub(super) rank: usize,
    /// Displacements: one row of `rank` entries per component of a node.
    basis: Vec<f32>,
    estimate: ErrorEstimate,
    residual: ResidualForm,
    /// B'f of the inertial forces of unit accelerations: linear x, y, z, angular x, y, z.
    inertial: [Vec<f64>; 6],
    /// Strains and residuals of quadratic displacements; `None`: the elements are linear.
    pub(super) quadratic: Option<QuadraticTables>,
    /// Masses and vibrations; `None`: not stored.
    mass: Option<ReducedMass>,
}

/// Masses of a basis, and the vibrations that follow from them.
#[derive(Clone, Debug, PartialEq)]
struct ReducedMass {
    /// B'MB of unit density, `rank × rank`.
    gram: Vec<f64>,
    modes: ReducedModes,
}

/// Data of a basis of quadratic displacements, whose own rows are their traces: the means that forces on nodes displace.
#[derive(Clone, Debug, PartialEq)]
pub struct QuadraticTables {
    /// Strains at the nodes: one row of `rank` entries per component xx, yy, zz, xy, yz, xz of a node.
    pub strains: ScaledRows,
    /// Trace of D⁻¹KB: one row of `rank` entries per component of a node.
    pub weighted: Vec<f32>,
    /// B'f of the inertial forces of six unit accelerations, then B'KD⁻¹f of them, `rank` entries each.
    pub inertial: Vec<f64>,
    /// Data that complete a displacement by a linear solve; `None`: not stored.
    pub completion: Option<CompletionTables>,
}

impl QuadraticTables {
    /// Number of vectors of [`Self::inertial`].
    pub const INERTIAL: usize = 12;

    fn bytes(&self) -> usize {
        let completion = self.completion.as_ref().map_or(0, CompletionTables::bytes);
        self.strains.bytes() + held(&self.weighted) + held(&self.inertial) + completion
    }
}

/// Model of the relative energy error: factor · ρ^power up to a bound, with the relative residual ρ of [`ReducedBasis::residual`].
///
/// It is fitted on impacts outside the snapshots of the basis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorEstimate {
    /// Factor, positive.
    pub factor: f64,
    /// Exponent, positive; 1 if missing energy and residual are proportional.
    pub power: f64,
    /// Largest error that it estimates, positive; infinite without a bound.
    pub error_max: f64,
}

/// Kernel that adds up rows of a basis times forces.
struct Gather<'a, F> {
    rank: usize,
    basis: &'a [f32],
    forces: F,
    coordinates: &'a mut [f64],
}

impl<F: Iterator<Item = (usize, Vector3<f64>)>> NullaryFnOnce for Gather<'_, F> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (node, force) in self.forces {
            let (x, others) = self.basis[3 * node * self.rank..][..3 * self.rank].split_at(self.rank);
            let (y, z) = others.split_at(self.rank);
            for (own, ((x, y), z)) in self.coordinates.iter_mut().zip(x.iter().zip(y).zip(z)) {
                *own += f64::from(*x) * force.x + f64::from(*y) * force.y + f64::from(*z) * force.z;
            }
        }
    }
}

/// Accepted range of the exponent. Values outside it come from too few pairs.
const POWER_RANGE: [f64; 2] = [0.5, 2.0];

/// The same for bodies whose basis may miss far more of an impact than of any impact of the fit: anchored bodies, and sheets.
///
/// With an exponent of 0.5, a strip held at both ends told 1 to 3 % for contacts beside an anchor that missed 17 to 63 %.
const POWER_RANGE_STEEP: [f64; 2] = [1.0, 2.0];

impl ReducedBasis {
    /// Builds the reduced basis from free displacements of `body` (one row of `rank` per component, `rank` ≥ 1).
    ///
    /// # Panics
    /// If the length of the basis is not `rank` times the size of the body.
    pub fn new(body: &Elasticity, rank: usize, basis: Vec<f32>) -> Self {
        assert_eq!(basis.len(), rank * body.size(), "the basis has one row per component");
        let gram = residual::gram(body, rank, &basis);
        Self::stored(body, rank, basis, gram, ErrorEstimate::RAW)
    }

    /// Restores a basis of `body` from its [`Self::basis`], [`Self::gram`] and [`Self::estimate`].
    ///
    /// # Panics
    /// If the length of the basis is not `rank` times the size of the body, or that of the gram matrix not `rank²`.
    pub fn stored(body: &Elasticity, rank: usize, basis: Vec<f32>, gram: Vec<f64>, estimate: ErrorEstimate) -> Self {
        assert_eq!(basis.len(), rank * body.size(), "the basis has one row per component");
        assert_eq!(gram.len(), rank * rank, "gram is rank × rank");
        let residual = ResidualForm::new(body, rank, &basis, gram);
        let (inertial, quadratic, mass) = (Default::default(), None, None);
        let mut reduced = Self { rank, basis, estimate, residual, inertial, quadratic, mass };
        reduced.inertial = std::array::from_fn(|axis| {
            let mut coordinates = vec![0.0; rank];
            let forces = (0..body.size() / 3).map(|node| (node, body.inertia.force(node, &residual::unit(axis))));
            reduced.gather(forces, &mut coordinates);
            coordinates
        });
        reduced
    }

    /// Restores a basis of quadratic displacements of `body` from its parts.
    ///
    /// # Panics
    /// If the length of a part does not fit the body and the rank.
    pub fn stored_quadratic(
        body: &Elasticity,
        basis: Vec<f32>,
        gram: Vec<f64>,
        tables: QuadraticTables,
        estimate: ErrorEstimate,
    ) -> Self {
        let rank = tables.inertial.len() / QuadraticTables::INERTIAL;
        assert_eq!(basis.len(), rank * body.size(), "the basis has one row per component");
        assert_eq!(tables.weighted.len(), rank * body.size(), "weighted has one row per component");
        assert_eq!(tables.strains.count(), 2 * body.size(), "strains has six rows per node");
        assert_eq!(gram.len(), rank * rank, "gram is rank × rank");
        let forces = tables.completion.as_ref().map_or(basis.len(), |completion| completion.forces.len());
        assert_eq!(forces, basis.len(), "forces has one row per component");
        let vector = |index: usize| tables.inertial[index * rank..][..rank].to_vec();
        let (inertial, weighted) = (std::array::from_fn(vector), std::array::from_fn(|axis| vector(6 + axis)));
        let residual = ResidualForm::quadratic(body, gram, weighted);
        Self { rank, basis, estimate, residual, inertial, quadratic: Some(tables), mass: None }
    }

    /// Returns the same basis with its masses B'MB of unit density, and none if they are not positive definite.
    ///
    /// # Panics
    /// If the length of `gram` is not `rank²`.
    #[must_use]
    pub fn with_mass(self, gram: Vec<f64>) -> Self {
        assert_eq!(gram.len(), self.rank * self.rank, "gram is rank × rank");
        let mass = ReducedModes::new(&gram, self.rank).map(|modes| ReducedMass { gram, modes });
        Self { mass, ..self }
    }

    /// B'MB of unit density, `rank × rank`; `None`: not stored.
    pub fn mass(&self) -> Option<&[f64]> {
        self.mass.as_ref().map(|mass| mass.gram.as_slice())
    }

    /// Vibrations in the span of the basis; `None`: its masses are not stored.
    pub fn modes(&self) -> Option<&ReducedModes> {
        self.mass.as_ref().map(|mass| &mass.modes)
    }

    /// Data of quadratic displacements; `None`: the elements are linear.
    pub fn quadratic(&self) -> Option<&QuadraticTables> {
        self.quadratic.as_ref()
    }

    /// B'KD⁻¹KB, `rank × rank`, with D the diagonal of K. The residual needs it in addition to the basis.
    pub fn gram(&self) -> &[f64] {
        self.residual.gram()
    }

    /// Number of displacements in the basis.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Displacements, one row of [`Self::rank`] entries per component of a node.
    pub fn basis(&self) -> &[f32] {
        &self.basis
    }

    /// Bytes of memory that it holds.
    pub fn bytes(&self) -> usize {
        let quadratic = self.quadratic.as_ref().map_or(0, QuadraticTables::bytes);
        let mass = self.mass.as_ref().map_or(0, |mass| held(&mass.gram) + mass.modes.bytes());
        let inertial = self.inertial.iter().map(held).sum::<usize>();
        held(&self.basis) + self.residual.bytes() + inertial + quadratic + mass
    }

    /// Model of the energy error.
    pub fn estimate(&self) -> ErrorEstimate {
        self.estimate
    }

    /// Model of the energy error of completed displacements; `None` without data for them.
    pub fn completed_estimate(&self) -> Option<ErrorEstimate> {
        Some(self.quadratic.as_ref()?.completion.as_ref()?.estimate)
    }

    /// Returns the same basis with the error model `estimate`.
    #[must_use]
    pub fn estimating(self, estimate: ErrorEstimate) -> Self {
        Self { estimate, ..self }
    }

    /// Returns the same basis with the error model `estimate` of completed displacements, if it has data for them.
    #[must_use]
    pub fn estimating_completed(mut self, estimate: ErrorEstimate) -> Self {
        if let Some(completion) = self.quadratic.as_mut().and_then(|tables| tables.completion.as_mut()) {
            completion.estimate = estimate;
        }
        self
    }

    /// Elastic energy of the displacement with these coordinates, ½|q|².
    pub fn energy(coordinates: &[f64]) -> f64 {
        0.5 * coordinates.iter().map(|q| q * q).sum::<f64>()
    }

    /// Projects `load`: writes B'f to `coordinates` and returns the elastic energy in the span of the basis, ½|B'f|².
    pub fn project(&self, load: &NodalLoad, coordinates: &mut Vec<f64>) -> f64 {
        coordinates.clear();
        coordinates.resize(self.rank, 0.0);
        self.gather(load.applied.iter().map(|(node, force)| (*node as usize, *force)), coordinates);
        let acceleration = load.acceleration.iter().flatten();
        for (inertial, acceleration) in self.inertial.iter().zip(acceleration) {
            coordinates.iter_mut().zip(inertial).for_each(|(own, inertial)| *own -= inertial * acceleration);
        }
        Self::energy(coordinates)
    }

    /// Number of displacements used for a limit of `most`: at least one, at most all.
    pub fn used(&self, most: Option<u32>) -> usize {
        most.map_or(self.rank, |most| (most as usize).clamp(1, self.rank))
    }

    /// Relative energy error if only the first `used` of `coordinates` are used.
    ///
    /// `whole` is the error with all of them. The basis is orthonormal, so the energy of the
    /// unused ones is missing in addition.
    pub fn truncated_error(coordinates: &[f64], used: usize, whole: f64) -> f64 {
        let square = |part: &[f64]| part.iter().map(|q| q * q).sum::<f64>();
        whole + (1.0 - whole) * square(&coordinates[used..]) / square(coordinates)
    }

    /// Displacement with these coordinates, resized to the size of the body; strains at its nodes if the elements are
    /// quadratic.
    ///
    /// Fewer coordinates than the rank stand for the first displacements.
    pub fn expand(&self, coordinates: &[f64], displacement: &mut Vec<f64>, workspace: &mut ElasticWorkspace) {
        let narrow = &mut workspace.narrow;
        match &self.quadratic {
            Some(tables) => tables.strains.products(coordinates, displacement, narrow),
            None => row_products::products((self.rank, &self.basis), coordinates, displacement, narrow),
        }
    }

    /// Adds the displacement with these coordinates to `expanded`, which is as [`Self::expand`] writes it.
    pub fn superpose(&self, coordinates: &[f64], expanded: &mut [f64], workspace: &mut ElasticWorkspace) {
        let mut own = std::mem::take(&mut workspace.image);
        self.expand(coordinates, &mut own, workspace);
        expanded.iter_mut().zip(&own).for_each(|(sum, own)| *sum += own);
        workspace.image = own;
    }

    /// As [`Self::superpose`], on a displacement of `body` that was solved for, with [`Elasticity::unknowns`] entries.
    pub fn superpose_on_solution(
        &self,
        body: &Elasticity,
        coordinates: &[f64],
        solution: &mut Vec<f64>,
        workspace: &mut ElasticWorkspace,
    ) {
        if let Some(edges) = &body.edges {
            *solution = edges.node_strains(&body.elements.blocks, solution);
        }
        self.superpose(coordinates, solution, workspace);
    }

    /// True if [`Self::expand`] and [`Self::complete`] yield strains at the nodes: the elements are quadratic.
    pub fn has_node_strains(&self) -> bool {
        self.quadratic.is_some()
    }

    /// Computes ∫ W over each tetrahedron from the result of [`Self::expand`], or of [`Self::complete`], and its `energy`:
    /// ½|q|² of the expanded coordinates, or that of the completed displacement.
    ///
    /// # Errors
    /// Those of [`Elasticity::tet_energy`].
    pub fn tet_energy(
        &self,
        (body, lattice): (&Elasticity, &Lattice),
        (expanded, energy): (&[f64], f64),
        driving: DrivingEnergy,
        (energies, workspace): (&mut Vec<f64>, &mut ElasticWorkspace),
        token: &CancelToken,
    ) -> Result<(), ElasticityError> {
        match &body.edges {
            Some(edges) if self.has_node_strains() => {
                body.strain_energy(edges, expanded, (driving, energy), (energies, workspace), token)
            }
            _ => body.tet_energy(lattice, expanded, driving, energies, token),
        }
    }

    /// Relative residual ρ = ½ r'D⁻¹r over ½|q|² of the displacement with coordinates `q` under `load`.
    ///
    /// r = f − K u, and D is the diagonal of K. NaN if there is no energy.
    ///
    /// # Panics
    /// If `body`, the load or the coordinates are another body's.
    pub fn residual(&self, body: &Elasticity, load: &NodalLoad, q: &[f64], workspace: &mut ElasticWorkspace) -> f64 {
        let missed = match (&self.quadratic, &body.edges) {
            (Some(tables), Some(edges)) => {
                let applied = load.applied.iter().map(|(node, force)| (*node as usize, *force));
                let gather = |coordinates: &mut [f64]| {
                    self.gather_rows(&tables.weighted, applied.clone(), coordinates);
                };
                self.residual.quadratic_energy((body, edges), load, q, gather, workspace)
            }
            _ => {
                let gather = |forces: &ForceSums, gathered: &mut [f64]| self.gather(forces.iter(), gathered);
                self.residual.energy(body, load, q, gather, workspace)
            }
        };
        missed / (0.5 * q.iter().map(|q| q * q).sum::<f64>())
    }

    /// Adds B'f of the forces on some nodes.
    fn gather(&self, forces: impl Iterator<Item = (usize, Vector3<f64>)>, coordinates: &mut [f64]) {
        self.gather_rows(&self.basis, forces, coordinates);
    }

    /// Adds the products of the `basis`, with one row of the rank per component, with forces on some nodes.
    pub(super) fn gather_rows(
        &self,
        basis: &[f32],
        forces: impl Iterator<Item = (usize, Vector3<f64>)>,
        coordinates: &mut [f64],
    ) {
        widest(Gather { rank: self.rank, basis, forces, coordinates });
    }
}

impl ErrorEstimate {
    /// Smallest number of pairs for a fit.
    pub const PAIRS_MIN: usize = 8;

    /// Identity model: the error equals the residual.
    pub const RAW: Self = Self { factor: 1.0, power: 1.0, error_max: f64::INFINITY };

    /// Relative energy error of a displacement with this relative residual.
    pub fn error(&self, residual: f64) -> f64 {
        let error = self.factor * residual.powf(self.power);
        // An error that is not a number stays one.
        if error > self.error_max { self.error_max } else { error }
    }

    /// Fits the model to pairs of residual and relative error, by least squares of their logarithms.
    ///
    /// Pairs that are not positive are skipped. Returns [`Self::RAW`] if too few pairs remain or all are alike.
    pub fn fit(pairs: &[(f64, f64)]) -> Self {
        Self::fit_within(pairs, POWER_RANGE)
    }

    /// As [`Self::fit`], with an exponent of at least 1: for a basis that may miss far more of an impact than of any of the fit.
    pub fn fit_steep(pairs: &[(f64, f64)]) -> Self {
        Self::fit_within(pairs, POWER_RANGE_STEEP)
    }

    fn fit_within(pairs: &[(f64, f64)], [least, most]: [f64; 2]) -> Self {
        let known = pairs.iter().filter(|(residual, error)| *residual > 0.0 && *error > 0.0);
        let logarithms: Vec<[f64; 2]> = known.map(|(residual, error)| [residual.ln(), error.ln()]).collect();
        let count = logarithms.len() as f64;
        let mean = |axis: usize| logarithms.iter().map(|pair| pair[axis]).sum::<f64>() / count;
        let [x, y] = [mean(0), mean(1)];
        let covariance: f64 = logarithms.iter().map(|pair| (pair[0] - x) * (pair[1] - y)).sum();
        let variance: f64 = logarithms.iter().map(|pair| (pair[0] - x).powi(2)).sum();
        if logarithms.len() < Self::PAIRS_MIN || variance <= f64::EPSILON * count {
            return Self::RAW;
        }
        let power = (covariance / variance).clamp(least, most);
        Self { factor: (y - power * x).exp(), power, ..Self::RAW }
    }
}
