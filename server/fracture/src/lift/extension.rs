//! Extension of boundary values to interior nodes by barycentric coordinates: harmonic or mean value.
//!
//! Based on: R. M. Rustamov, Y. Lipman & T. Funkhouser, *Interior distance using barycentric coordinates* (Computer
//! Graphics Forum 28, 2009): v*(p) = Σ_i h_i(p) v*(v_i). Harmonic: P. Joshi et al., *Harmonic coordinates for character
//! articulation* (ACM Transactions on Graphics 26, 2007), by linear tetrahedra, that is one Dirichlet solve for all
//! coordinates: K_ii·X_i = −K_ib·X_b. Mean value: see [`super::mean_value`].

use super::boundary::BoundarySurface;
use super::laplacian::Laplacian;
use super::{LiftError, mean_value};
use crate::cancel_token::CancelToken;
use crate::lattice::Lattice;
use crate::sparse::{Cholesky, SolveScratch, SymmetricMatrix};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Row number that marks a boundary node.
const ON_BOUNDARY: u32 = u32::MAX;

/// Barycentric coordinates that extend boundary values inside. Both kinds reproduce linear functions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Extension {
    /// Harmonic coordinates, by one sparse factor.
    ///
    /// They are non-negative except for the effect of obtuse dihedral angles of the lattice.
    #[default]
    Harmonic,
    /// Mean value coordinates, in closed form.
    ///
    /// They can be negative in concave bodies. Their cost is proportional to nodes × triangles.
    MeanValue,
}

impl Extension {
    /// Extends `values` to all nodes of the lattice whose boundary is `surface`.
    ///
    /// `values` is node-major, `surface nodes × dimension`, in any unit. The result is node-major, `nodes × dimension`;
    /// the values on the boundary are unchanged.
    ///
    /// # Panics
    /// If `values` has another length.
    ///
    /// # Errors
    /// Those of [`carry_harmonic`] or [`carry_mean_value`].
    pub fn carry(
        self,
        lattice: &Lattice,
        surface: &BoundarySurface,
        values: &[f64],
        dimension: usize,
        token: &CancelToken,
    ) -> Result<Vec<f64>, LiftError> {
        match self {
            Self::Harmonic => carry_harmonic(lattice, surface, values, dimension, token),
            Self::MeanValue => carry_mean_value(lattice, surface, values, dimension, token),
        }
    }
}

/// As [`Extension::carry`], by harmonic coordinates. Polls the token before it factors and before it solves.
///
/// # Panics
/// If `values` is not of length `surface nodes × dimension`.
///
/// # Errors
/// As the constructor of the Laplacian: [`LiftError::TooFewNodes`], [`LiftError::DegenerateTet`], [`LiftError::Disconnected`],
/// [`LiftError::Sparse`]; [`LiftError::NotFinite`]; [`LiftError::Canceled`].
pub fn carry_harmonic(
    lattice: &Lattice,
    surface: &BoundarySurface,
    values: &[f64],
    dimension: usize,
    token: &CancelToken,
) -> Result<Vec<f64>, LiftError> {
    let mut carried = scattered(lattice, surface, values, dimension);
    let inside = inside(lattice, surface);
    let stiffness = Laplacian::new(lattice)?.stiffness;
    let count = inside.iter().filter(|&&row| row != ON_BOUNDARY).count();
    if count == 0 {
        return finite(carried);
    }
    token.check()?;
    let factor = Cholesky::factor(&dirichlet(&stiffness, &inside, count)?)?;
    token.check()?;
    let mut solution = pull(&stiffness, &inside, count, &carried, dimension);
    factor.solve_in_place(&mut solution, dimension, &mut SolveScratch::default());
    for (node, &row) in inside.iter().enumerate().filter(|(_, row)| **row != ON_BOUNDARY) {
        for axis in 0..dimension {
            carried[node * dimension + axis] = solution[axis * count + row as usize];
        }
    }
    finite(carried)
}

/// As [`Extension::carry`], by mean value coordinates. Polls the token at every node.
///
/// # Panics
/// If `values` is not of length `surface nodes × dimension`.
///
/// # Errors
/// [`LiftError::NotFinite`] (a surface without a triangle, or values that are not finite); [`LiftError::Canceled`].
pub fn carry_mean_value(
    lattice: &Lattice,
    surface: &BoundarySurface,
    values: &[f64],
    dimension: usize,
    token: &CancelToken,
) -> Result<Vec<f64>, LiftError> {
    let mut carried = scattered(lattice, surface, values, dimension);
    let inside = inside(lattice, surface);
    carried.par_chunks_exact_mut(dimension.max(1)).enumerate().try_for_each_init(
        || mean_value::MeanValueWeights::new(surface),
        |weights, (node, value)| {
            token.check()?;
            if inside[node] != ON_BOUNDARY {
                weights.find(&lattice.nodes[node]);
                weights.blend(values, value);
            }
            Ok::<(), LiftError>(())
        },
    )?;
    finite(carried)
}

/// Boundary values at their nodes, zero elsewhere.
fn scattered(lattice: &Lattice, surface: &BoundarySurface, values: &[f64], dimension: usize) -> Vec<f64> {
    assert_eq!(values.len(), surface.nodes.len() * dimension, "values has surface nodes × dimension entries");
    let mut carried = vec![0.0; lattice.nodes.len() * dimension];
    for (&node, value) in surface.nodes.iter().zip(values.chunks_exact(dimension.max(1))) {
        carried[node as usize * dimension..][..dimension].copy_from_slice(value);
    }
    carried
}

/// Row of each interior node; [`ON_BOUNDARY`] for the others.
fn inside(lattice: &Lattice, surface: &BoundarySurface) -> Vec<u32> {
    let mut rows = vec![0; lattice.nodes.len()];
    surface.nodes.iter().for_each(|&node| rows[node as usize] = ON_BOUNDARY);
    rows.iter_mut().filter(|row| **row == 0).zip(0..).for_each(|(row, number)| *row = number);
    rows
}

/// Interior block K_ii of the stiffness.
fn dirichlet(stiffness: &SymmetricMatrix, inside: &[u32], count: usize) -> Result<SymmetricMatrix, LiftError> {
    let mut entries = Vec::new();
    for (node, &row) in inside.iter().enumerate().filter(|(_, row)| **row != ON_BOUNDARY) {
        let (columns, blocks) = stiffness.row(node);
        for (&column, block) in columns.iter().zip(blocks) {
            let column = inside[column as usize];
            if column != ON_BOUNDARY && column <= row {
                entries.push((row, column, block.x));
            }
        }
    }
    Ok(SymmetricMatrix::from_triplets(count, &entries)?)
}

/// Right-hand side −K_ib·X_b, column-major `count × dimension`. `carried` is node-major and zero inside.
fn pull(stiffness: &SymmetricMatrix, inside: &[u32], count: usize, carried: &[f64], dimension: usize) -> Vec<f64> {
    let mut pull = vec![0.0; count * dimension];
    for (node, &row) in inside.iter().enumerate().filter(|(_, row)| **row != ON_BOUNDARY) {
        let (columns, blocks) = stiffness.row(node);
        for (&column, block) in columns.iter().zip(blocks) {
            let value = &carried[column as usize * dimension..][..dimension];
            for (axis, value) in value.iter().enumerate() {
                pull[axis * count + row as usize] -= block.x * value;
            }
        }
    }
    pull
}

fn finite(carried: Vec<f64>) -> Result<Vec<f64>, LiftError> {
    if carried.iter().all(|value| value.is_finite()) { Ok(carried) } else { Err(LiftError::NotFinite) }
}
