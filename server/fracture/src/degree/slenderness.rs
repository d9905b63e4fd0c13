//! Thickness and cross-section of slender bodies.
//!
//! Cells larger than a plate's thickness tile a surface, and cells larger than a rod's
//! section tile a line. The formula for solids then overestimates the number of cells of equal energy.

use crate::centroidal::cube_root;
use crate::lattice::Lattice;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Measures of a body's shape for the closed form, in local units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slenderness {
    /// Thickness τ of the square plate with the same volume and surface area; V^(1/3) without such a plate.
    pub thickness: f64,
    /// Section A: volume over length, the latter that of the box with the same second moments.
    pub section: f64,
}

impl Slenderness {
    /// Measures a lattice: its volume, boundary and second moments.
    pub fn of(lattice: &Lattice) -> Self {
        let volume = lattice.volume();
        Self { thickness: thickness(volume, lattice.boundary_area()), section: volume / length(lattice, volume) }
    }
}

/// τ = V/A with A the area of the square plate: the root of 2A + 4V/√A = S with A ≥ V^(2/3).
fn thickness(volume: f64, surface: f64) -> f64 {
    let side = cube_root(volume);
    let cube = side * side;
    let excess = |area: f64| 2.0 * area + 4.0 * volume / area.sqrt() - surface;
    let (mut below, mut above) = (cube, cube.max(0.5 * surface));
    if excess(below) >= 0.0 {
        return side;
    }
    for _ in 0..60 {
        let middle = 0.5 * (below + above);
        *(if excess(middle) < 0.0 { &mut below } else { &mut above }) = middle;
    }
    volume / below
}

/// Length of the box with the body's second moments: √(12 λ) with the largest variance of position λ.
fn length(lattice: &Lattice, volume: f64) -> f64 {
    let (mut mean, mut square) = (Vector3::zeros(), Matrix3::zeros());
    for tet in 0..lattice.tets.len() {
        let corners = lattice.corners(tet).map(|corner| corner.coords);
        let (sum, share) = (corners.iter().sum::<Vector3<f64>>(), lattice.tet_volume(tet) / volume);
        mean += sum * (share / 4.0);
        let own: Matrix3<f64> = corners.iter().map(|corner| corner * corner.transpose()).sum();
        square += (own + sum * sum.transpose()) * (share / 20.0);
    }
    (12.0 * SymmetricEigen::new(square - mean * mean.transpose()).eigenvalues.max()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::block;

    fn check(cells: [usize; 3], spacing: f64) {
        let sides = cells.map(|count| count as f64 * spacing);
        let found = Slenderness::of(&block(cells, spacing));
        let [shortest, longest] = [f64::min, f64::max].map(|pick| sides.into_iter().reduce(pick).unwrap());
        let plate = sides.iter().filter(|side| **side == shortest).count() < 2 || shortest == longest;
        let thickness = if plate { shortest } else { shortest / 2.0 };
        assert!((found.thickness / thickness - 1.0).abs() < 0.15, "{found:?} {sides:?}");
        assert!((found.section * longest / sides.iter().product::<f64>() - 1.0).abs() < 1e-9, "{found:?} {sides:?}");
    }

    #[test]
    fn boxes_have_the_thickness_and_the_section_that_they_have() {
        check([4, 4, 4], 0.1);
        check([30, 30, 1], 0.03);
        check([20, 20, 2], 0.03);
        check([60, 1, 1], 0.01);
    }
}
