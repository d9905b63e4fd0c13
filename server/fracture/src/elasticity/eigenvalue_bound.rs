//! Lower bound of a free body's stiffness, and an upper bound of the energy that a load stores, without a solve.
//!
//! Based on: J. J. Sylvester's law of inertia, for counting eigenvalues (B. N. Parlett, *The Symmetric Eigenvalue
//! Problem*, 1980, section 3.3). The bound of the energy and its weights are our own.
//!
//! Let W be a positive diagonal matrix and K φ_k = λ_k W φ_k with φ_j'Wφ_k = δ_jk. λ_1 = … = λ_6 = 0 belong to the
//! rigid motions. All others are positive, because the body is not a mechanism: faces connect its tetrahedra. K − σW
//! is congruent to diag(λ_k − σ), so it has as many negative pivots as there are λ_k below σ. If σ > 0 and that number
//! is 6, then λ_k ≥ σ for k > 6.
//!
//! Rounding adds an error E: the factored matrix is K − σW + E. The eigenvalues of K + E differ from those of K by at
//! most ‖W^(−½)EW^(−½)‖ (Weyl). [`Signature`] bounds this norm, which is subtracted from the bound.
//!
//! A load in equilibrium does no work on rigid motions: φ_k'f = 0 for k ≤ 6. With c_k = φ_k'f and f = Σ c_k Wφ_k
//! follows
//!
//! U = ½ f'K⁺f = ½ Σ_{k>6} c_k²/λ_k ≤ ½ Σ_{k>6} c_k²/σ = ½ f'W⁻¹f/σ.
//!
//! Any W is valid, and its choice decides how tight the bound is. Contacts load the surface. With lumped masses
//! alone, a boundary node has the mass of half a spacing of depth. The energy bound would then grow as the lattice is
//! refined. W therefore has an additional layer on the boundary, of depth [`LAYER`] · volume / area.
//!
//! For quadratic elements, K is replaced by a smaller matrix on the nodes, and U has a second part from the forces on edges
//! (module `quadratic::condensation`). Tearing the elements apart at their edges makes that matrix softer: the bound was 4 to 7
//! times that of linear elements on the same lattices. The weights of the edges do not depend on σ.

use super::{ElasticWorkspace, Elasticity, ElasticityError, Support};
use crate::cancel_token::CancelToken;
use crate::memory::held;
use crate::random::RandomStream;
use crate::sparse::{Signature, SymmetricMatrix};
use nalgebra::{Matrix6, SMatrix, Vector3, Vector6};

/// Depth of the boundary layer that is added to the masses, in volume over area.
///
/// On cubes, plates and bars, the ratio of bound to energy is smallest for 0.5 to 2.
const LAYER: f64 = 1.0;

/// Largest number of sweeps of inverse iteration for the estimate.
const SWEEPS_MAX: usize = 40;

/// Relative decrease of the estimate below which the iteration stops.
const SETTLED: f64 = 2e-3;

/// Shares of the estimate that are tried as the bound, the best first.
const SHARES: [f64; 4] = [0.95, 0.8, 0.5, 0.2];

/// Number of smooth motions.
const SMOOTH: usize = 9;

/// Products of smooth motions.
type SmoothMatrix = SMatrix<f64, SMOOTH, SMOOTH>;

/// Least eigenvalue of the products of independent motions of unit length.
const DEPENDENT: f64 = 1e-6;

/// Number of rigid motions of a body.
const RIGID: usize = 6;

/// Lower bound of the stiffness of a free body against loads in equilibrium.
#[derive(Clone, Debug, PartialEq)]
pub struct EigenvalueLowerBound {
    /// Lower bound of the smallest positive λ with K φ = λ W φ, of the condensed K if the elements are quadratic; local.
    value: f64,
    /// 1/w of each node.
    compliance: Vec<f64>,
    /// 1/w of each edge of quadratic elements.
    edge_compliance: Vec<f64>,
}

impl EigenvalueLowerBound {
    /// Computes the bound of `body`. `None` for an anchored body, and if no bound was found.
    ///
    /// Takes several solves and a factorization; with quadratic elements, an elimination per tetrahedron and another
    /// factorization in addition.
    ///
    /// # Errors
    /// Those of [`Elasticity::factor`] and [`Elasticity::solve`], [`ElasticityError::Canceled`].
    pub fn of(body: &Elasticity, token: &CancelToken) -> Result<Option<Self>, ElasticityError> {
        if matches!(body.support(), Support::Anchored(_)) {
            return Ok(None);
        }
        let value = match &body.edges {
            None => proven(body, token)?,
            Some(edges) => {
                let Some(condensed) = body.condensed(edges)? else { return Ok(None) };
                proven(&condensed, token)?
            }
        };
        Ok(value.map(|value| Self::stored(body, value)))
    }

    /// Restores the bound of `body` from its [`Self::value`].
    pub fn stored(body: &Elasticity, value: f64) -> Self {
        let compliance = weights(body).into_iter().map(f64::recip).collect();
        let edge_compliance = body.edges.as_ref().map_or_else(Vec::new, |edges| edges.compliance(&body.elements));
        Self { value, compliance, edge_compliance }
    }

    /// Upper limit of any valid bound of `body`.
    ///
    /// It is the least Rayleigh quotient of all sums of nine smooth motions without rigid part (Rayleigh and Ritz), and so at least the
    /// smallest positive λ, also of quadratic elements: the motions are theirs, too. Takes one product with the stiffness per motion.
    pub fn most(body: &Elasticity) -> f64 {
        let weights = weights(body);
        let rigid = rigid(body, &weights);
        let motion = |k: usize| {
            let mut motion = vec![0.0; body.size()];
            for (node, own) in motion.chunks_exact_mut(3).enumerate() {
                own.copy_from_slice(smooth(k / 3, k % 3, body.inertia.arm(node)).as_slice());
            }
            remove_rigid_motion(body, &weights, &rigid, &mut motion);
            let square: f64 = motion.chunks_exact(3).zip(&weights).map(|(own, weight)| weight * dot(own, own)).sum();
            motion.iter_mut().for_each(|u| *u /= square.sqrt());
            motion
        };
        let motions: [Vec<f64>; SMOOTH] = std::array::from_fn(motion);
        let mut forces = vec![0.0; body.size()];
        let (mut stored, mut square) = (SmoothMatrix::zeros(), SmoothMatrix::zeros());
        for (a, one) in motions.iter().enumerate() {
            body.stiffness.multiply(one, &mut forces);
            for (b, other) in motions.iter().enumerate() {
                stored[(a, b)] = dot(&forces, other);
                let products = one.chunks_exact(3).zip(other.chunks_exact(3)).zip(&weights);
                square[(a, b)] = products.map(|((one, other), weight)| weight * dot(one, other)).sum();
            }
        }
        least_quotient(&stored, &square)
    }

    /// Value of the bound; local.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// Upper bound of the energy that `forces` store, ½ f'W⁻¹f/σ, and ½ g'W⁻¹g of the forces on edges; local.
    ///
    /// `forces` (length [`Elasticity::unknowns`]) must be in equilibrium. Takes one pass.
    pub fn energy(&self, forces: &[f64]) -> f64 {
        let (nodes, edges) = forces.split_at(3 * self.compliance.len());
        0.5 * (work(&self.compliance, nodes) / self.value + work(&self.edge_compliance, edges))
    }

    /// Bytes of memory that it holds.
    pub fn bytes(&self) -> usize {
        held(&self.compliance) + held(&self.edge_compliance)
    }
}

/// Lower bound of the smallest positive λ of the stiffness on the nodes; `None` if none was found.
fn proven(body: &Elasticity, token: &CancelToken) -> Result<Option<f64>, ElasticityError> {
    let weights = weights(body);
    let estimate = softest(body, &weights, token)?;
    let rows: Vec<f64> = weights.iter().flat_map(|&weight| [weight; 3]).collect();
    for share in SHARES {
        token.check()?;
        let shift = share * estimate;
        let mut shifted = SymmetricMatrix::clone(&body.stiffness);
        shifted.add_diagonal(&rows.iter().map(|weight| -shift * weight).collect::<Vec<_>>());
        if let Some(Signature { negative: RIGID, rounding }) = body.symbolic.signature(&shifted, &rows)
            && rounding < 0.5 * shift
        {
            return Ok(Some(shift - rounding));
        }
    }
    Ok(None)
}

/// W by node: lumped masses, and a layer on the boundary.
fn weights(body: &Elasticity) -> Vec<f64> {
    let mut weights: Vec<f64> = (0..body.size() / 3).map(|node| body.inertia.mass(node)).collect();
    let (volume, area) = (weights.iter().sum::<f64>(), body.boundary.areas.iter().sum::<f64>());
    for (&node, own) in body.boundary.nodes.iter().zip(&body.boundary.areas) {
        weights[node as usize] += LAYER * volume / area * own;
    }
    weights
}

/// Estimate, from above, of the smallest positive λ with K φ = λ W φ, by inverse iteration.
fn softest(body: &Elasticity, weights: &[f64], token: &CancelToken) -> Result<f64, ElasticityError> {
    let mut stream = RandomStream::new(0, 1);
    let mut motion: Vec<f64> = (0..body.size()).map(|_| stream.uniform() - 0.5).collect();
    let weigh = |motion: &[f64]| -> Vec<f64> {
        motion.chunks_exact(3).zip(weights).flat_map(|(own, weight)| [0, 1, 2].map(|k| own[k] * weight)).collect()
    };
    let (mut displacement, mut workspace, mut softest) = (Vec::new(), ElasticWorkspace::default(), f64::INFINITY);
    let rigid = rigid(body, weights);
    for _ in 0..SWEEPS_MAX {
        remove_rigid_motion(body, weights, &rigid, &mut motion);
        let forces = weigh(&motion);
        body.solve(&forces, &mut displacement, &mut workspace, token)?;
        remove_rigid_motion(body, weights, &rigid, &mut displacement);
        let square = dot(&displacement, &weigh(&displacement));
        let (before, length) = (softest, square.sqrt());
        softest = dot(&forces, &displacement) / square;
        if softest > (1.0 - SETTLED) * before {
            break;
        }
        motion.clear();
        motion.extend(displacement.iter().map(|u| u / length));
    }
    Ok(softest)
}

/// f'W⁻¹f of forces, three per entry of `compliance`.
fn work(compliance: &[f64], forces: &[f64]) -> f64 {
    let own = |(compliance, own): (&f64, &[f64])| own.iter().map(|f| f * f).sum::<f64>() * compliance;
    compliance.iter().zip(forces.chunks_exact(3)).map(own).sum()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The least quotient x'Ax / x'Bx; where motions are nearly dependent, that of the single motions. Motions of zero length are ignored.
fn least_quotient(stored: &SmoothMatrix, square: &SmoothMatrix) -> f64 {
    // The quotient of a motion of zero length is NaN, which `min` ignores.
    let single = (0..SMOOTH).map(|k| stored[(k, k)] / square[(k, k)]).fold(f64::INFINITY, f64::min);
    let independent = |square: &SmoothMatrix| square.symmetric_eigenvalues().min() > DEPENDENT;
    let factor = square.iter().all(|x| x.is_finite()).then(|| square.cholesky().filter(|_| independent(square)));
    let quotients = factor.flatten().and_then(|factor| {
        let inverse = factor.l().try_inverse()?;
        Some((inverse * stored * inverse.transpose()).symmetric_eigenvalues())
    });
    quotients.map(|all| all.min()).filter(|least| *least > 0.0).map_or(single, |least| least.min(single))
}

/// (R'WR)⁻¹ with R the rigid motions about the center of mass: linear x, y, z, angular x, y, z. Zero if it is singular.
fn rigid(body: &Elasticity, weights: &[f64]) -> Matrix6<f64> {
    let mut gram = Matrix6::zeros();
    for (node, weight) in weights.iter().enumerate() {
        let motions = motions(body.inertia.arm(node));
        gram += Matrix6::from_fn(|a, b| weight * motions[a].dot(&motions[b]));
    }
    gram.try_inverse().unwrap_or_else(Matrix6::zeros)
}

/// Smooth displacement at `arm`: a stretch along one axis, or a bend of axis `by` toward axis `along`.
fn smooth(along: usize, by: usize, arm: Vector3<f64>) -> Vector3<f64> {
    let mut motion = Vector3::zeros();
    if along == by {
        motion[along] = arm[along];
    } else {
        motion[along] = 0.5 * arm[by] * arm[by];
        motion[by] = -arm[along] * arm[by];
    }
    motion
}

/// Displacements of a node at `arm` under the six rigid motions.
fn motions(arm: Vector3<f64>) -> [Vector3<f64>; RIGID] {
    let axis = |k: usize| Vector3::ith(k, 1.0);
    std::array::from_fn(|k| if k < 3 { axis(k) } else { axis(k - 3).cross(&arm) })
}

/// Removes the rigid part of `motion` in the inner product of the weights.
///
/// W times the result is then in equilibrium.
fn remove_rigid_motion(body: &Elasticity, weights: &[f64], rigid: &Matrix6<f64>, motion: &mut [f64]) {
    for _ in 0..2 {
        let mut net = Vector6::zeros();
        for (node, (own, weight)) in motion.chunks_exact(3).zip(weights).enumerate() {
            let own = Vector3::from_column_slice(own) * *weight;
            motions(body.inertia.arm(node)).iter().enumerate().for_each(|(k, motion)| net[k] += motion.dot(&own));
        }
        let part = rigid * net;
        for (node, own) in motion.chunks_exact_mut(3).enumerate() {
            let moved: Vector3<f64> = motions(body.inertia.arm(node)).iter().zip(&part).map(|(r, c)| r * *c).sum();
            own.iter_mut().zip(&moved).for_each(|(own, moved)| *own -= moved);
        }
    }
}
