//! Lower bound of the quadratic stiffness by a matrix on the nodes alone.
//!
//! Based on: R. J. Guyan, *Reduction of stiffness and mass matrices* (AIAA Journal 3, 1965), for the elimination of
//! unknowns by the minimum of the energy. The elimination by tetrahedron, the weights and the bound are ours.
//!
//! Let W be diagonal weights of the edges, sums of w_T over the tetrahedra T around an edge. For displacements u of
//! the nodes and c of the edges,
//!
//! (u, c)'K(u, c) − c'Wc = Σ_T (u_T, c_T)'K_T(u_T, c_T) − w_T c_T'c_T ≥ Σ_T u_T'S_Tu_T = u'Su,
//!
//! S_T = K_uu − K_uc (K_cc − w_T)⁻¹ K_cu, which is the minimum over the c_T of each tetrahedron by itself. All
//! K_cc − w_T must be positive definite. S has the pattern of the linear stiffness.
//!
//! Let V be a positive diagonal matrix on the nodes, and let S − V have six negative eigenvalues. K − diag(V, W) has as
//! many negative eigenvalues as its Schur complement on the nodes, which is at least S − V. These are at most six, and by the
//! argument of module `eigenvalue_bound`, forces f on nodes and g on edges in equilibrium store at most
//! ½ (f'V⁻¹f + g'W⁻¹g).
//!
//! w_T = η v r² / (5h⁴), with the volume v, the least height r and the root mean square h of the edges. ∫ b_e is v/5.
//! The least eigenvalue of K_cc was at least 2.2 w_T/η in 60,000 tetrahedra of any shape, for −0.5 ≤ ν ≤ 0.45.

use super::EdgeFunctions;
use crate::elasticity::blocks::{Elements, SIDE};
use crate::elasticity::element::{Element, Lame};
use crate::elasticity::{Elasticity, ElasticityError};
use crate::lattice::EDGES;
use crate::sparse::SymmetricMatrix;
use nalgebra::{Matrix3, SMatrix, Vector3};
use rayon::prelude::*;

/// Share η of the stiffness of the edges that bounds the energy of the forces on them.
///
/// A larger one makes S softer, and a smaller one makes the energy of the forces on edges larger. Median bound over energy with 0.2, 0.5
/// and 1: a cube of five cells 53, 41, 38; a bar of 12 × 2 × 2 cells 78, 79, 83; a plate of 20 × 20 × 1 cells 144, 147, 154.
const EDGE_SHARE: f64 = 0.5;

/// Matrix between the corners of a tetrahedron, three rows per corner.
type CornerMatrix = SMatrix<f64, 12, 12>;

/// Matrix between the edges of a tetrahedron, three rows per edge.
type EdgeMatrix = SMatrix<f64, 18, 18>;

/// Matrix from the corners (columns) to the edges (rows) of a tetrahedron.
type CouplingMatrix = SMatrix<f64, 18, 12>;

/// Stiffness of one quadratic tetrahedron, exact.
pub(in crate::elasticity) struct ElementStiffness {
    /// K_uu, between corners.
    pub(in crate::elasticity) corners: CornerMatrix,
    /// K_cu, from corners to edges.
    pub(in crate::elasticity) coupling: CouplingMatrix,
    /// K_cc, between edges.
    pub(in crate::elasticity) edges: EdgeMatrix,
}

impl ElementStiffness {
    /// Computes the stiffness of `element`.
    pub(in crate::elasticity) fn new(element: &Element, lame: Lame) -> Self {
        let (mut corners, mut coupling) = (CornerMatrix::zeros(), CouplingMatrix::zeros());
        let mut edges = EdgeMatrix::zeros();
        for j in 0..4 {
            for i in 0..4 {
                corners.fixed_view_mut::<3, 3>(3 * i, 3 * j).copy_from(&element.stiffness(i, j, lame));
            }
            for (e, [a, b]) in EDGES.into_iter().enumerate() {
                // ∫ 4 λ_a = V.
                let mean = element.gradients[a] + element.gradients[b];
                let products = mean * element.gradients[j].transpose() * element.volume;
                coupling.fixed_view_mut::<3, 3>(3 * e, 3 * j).copy_from(&block(&products, lame));
            }
        }
        for (e, own) in EDGES.into_iter().enumerate() {
            for (f, other) in EDGES.into_iter().enumerate() {
                let products = edge_products(element, own, other);
                edges.fixed_view_mut::<3, 3>(3 * e, 3 * f).copy_from(&block(&products, lame));
            }
        }
        Self { corners, coupling, edges }
    }

    /// S_T with w_T = `weight`; `None` if K_cc − w_T is not positive definite.
    fn condensed(&self, weight: f64) -> Option<CornerMatrix> {
        let factor = (self.edges - EdgeMatrix::from_diagonal_element(weight)).cholesky()?;
        let mut solved = self.coupling;
        factor.l_dirty().solve_lower_triangular_mut(&mut solved).then(|| self.corners - solved.tr_mul(&solved))
    }
}

/// Stiffness block of two functions with ∫ ∇a ∇bᵀ = `products`.
fn block(products: &Matrix3<f64>, lame: Lame) -> Matrix3<f64> {
    products * lame.lambda + products.transpose() * lame.mu + Matrix3::from_diagonal_element(lame.mu * products.trace())
}

/// ∫ ∇b ∇b'ᵀ of the functions of two edges of `element`, by their ends.
fn edge_products(element: &Element, [i, j]: [usize; 2], [k, l]: [usize; 2]) -> Matrix3<f64> {
    let g = &element.gradients;
    // ∇b = 4 (λ_i ∇λ_j + λ_j ∇λ_i) and ∫ λ_i λ_k = V (1 + δ_ik) / 20.
    let part = |one: usize, other: usize, a: &Vector3<f64>, b: &Vector3<f64>| {
        a * b.transpose() * if one == other { 2.0 } else { 1.0 }
    };
    let sum = part(i, k, &g[j], &g[l]) + part(i, l, &g[j], &g[k]) + part(j, k, &g[i], &g[l]);
    (sum + part(j, l, &g[i], &g[k])) * (16.0 * element.volume / 20.0)
}

/// w_T of a tetrahedron, the same for its six edges.
fn weight(element: &Element) -> f64 {
    let steepest = element.gradients.iter().map(Vector3::norm_squared).fold(0.0, f64::max);
    // The edge from node 0 to node k is the k-th column of the inverse of the matrix of the other gradients.
    let rows = [1, 2, 3].map(|node| element.gradients[node].transpose());
    let Some(sides) = Matrix3::from_rows(&rows).try_inverse() else { return 0.0 };
    let place = |node: usize| if node == 0 { Vector3::zeros() } else { sides.column(node - 1).into_owned() };
    let square = EDGES.iter().map(|[i, j]| (place(*i) - place(*j)).norm_squared()).sum::<f64>() / EDGES.len() as f64;
    EDGE_SHARE * element.volume / (5.0 * square * square * steepest)
}

impl EdgeFunctions {
    /// 1/w of each edge; local.
    pub(in crate::elasticity) fn compliance(&self, elements: &Elements) -> Vec<f64> {
        let mut weights = vec![0.0; self.count()];
        for (tet, edges) in self.tets.iter().enumerate() {
            let own = weight(&element(elements, tet));
            edges.iter().for_each(|edge| weights[*edge as usize] += own);
        }
        weights.into_iter().map(f64::recip).collect()
    }
}

/// Tetrahedron number `tet`.
fn element(elements: &Elements, tet: usize) -> Element {
    elements.blocks[tet / SIDE].element(tet % SIDE)
}

impl Elasticity {
    /// Body of linear elements whose stiffness is S, not yet factored; `None` if a K_cc − w_T is not positive definite.
    ///
    /// # Errors
    /// [`ElasticityError::Stiffness`].
    pub(in crate::elasticity) fn condensed(&self, edges: &EdgeFunctions) -> Result<Option<Self>, ElasticityError> {
        let one = |tet: usize| {
            let own = element(&self.elements, tet);
            ElementStiffness::new(&own, self.lame).condensed(weight(&own))
        };
        let all: Option<Vec<CornerMatrix>> = (0..self.tets).into_par_iter().map(one).collect();
        let Some(all) = all else { return Ok(None) };
        let stiffness = SymmetricMatrix::assemble(self.size() / 3, &edges.corners, |tet, i, j| {
            all[tet].fixed_view::<3, 3>(3 * i, 3 * j).into_owned()
        })?;
        Ok(Some(self.with_stiffness(stiffness)))
    }
}
