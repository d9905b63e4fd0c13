//! Principal moments of inertia, for formats that have no full tensor.
//!
//! Based on: the symmetric eigenvalue problem (Golub & Van Loan, *Matrix Computations*, 2013, chapter 8).

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};

/// Principal moments and axes of an inertia tensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipalInertia {
    /// Moments, kg·m², the largest first; none exceeds the sum of the others.
    pub moments_kg_m2: [f64; 3],
    /// Rotation from the principal axes to those of the tensor, a unit quaternion: w, x, y, z; w is not negative.
    pub quaternion: [f64; 4],
}

/// Diagonalizes a tensor (xx, yy, zz, xy, xz, yz; finite). Clamps moments that rounding put below zero or above the sum of the others.
pub fn principal(tensor: [f64; 6]) -> PrincipalInertia {
    let [xx, yy, zz, xy, xz, yz] = tensor;
    let eigen = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let [most, middle, least] = order.map(|k| eigen.eigenvalues[k].max(0.0));
    let [first, second] = [order[0], order[1]].map(|k| eigen.eigenvectors.column(k).into_owned());
    let axes = Matrix3::from_columns(&[first, second, first.cross(&second)]);
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    let sign = if turn.w < 0.0 { -1.0 } else { 1.0 };
    PrincipalInertia {
        moments_kg_m2: [most.min(middle + least), middle, least],
        quaternion: [turn.w, turn.i, turn.j, turn.k].map(|x| sign * x),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Quaternion, Vector3};

    /// Rebuilds the tensor from moments and axes, and compares.
    #[track_caller]
    fn check(tensor: [f64; 6]) {
        let PrincipalInertia { moments_kg_m2: moments, quaternion: [w, x, y, z] } = principal(tensor);
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).to_rotation_matrix();
        let back = turn.matrix() * Matrix3::from_diagonal(&Vector3::from(moments)) * turn.matrix().transpose();
        let back = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|entry| back[entry]);
        let scale = moments[0].max(f64::MIN_POSITIVE);
        let off = back.iter().zip(tensor).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off <= 1e-14 * scale, "{tensor:?} came back as {back:?}");
        assert!(moments[0] <= moments[1] + moments[2] && moments[0] >= moments[1] && moments[1] >= moments[2]);
        assert!(w >= 0.0);
    }

    #[test]
    fn principal_axes_reproduce_the_tensor() {
        check([3.0, 2.0, 4.0, 0.0, 0.0, 0.0]);
        check([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
        check([2.0, 2.0, 2.0, 0.5, -0.5, 0.25]);
        check([2e-9, 3e-9, 4e-9, 1e-9, -5e-10, 2e-10]);
        // A flat body: the largest moment is the sum of the others.
        check([1.0, 2.0, 3.0, 0.0, 0.0, 0.0]);
        check([0.0; 6]);
    }

    #[test]
    fn rounding_does_not_break_the_triangle() {
        let moments = principal([1.0, 2.0, 3.0 + 1e-15, 0.0, 0.0, 0.0]).moments_kg_m2;
        assert!(moments[0] <= moments[1] + moments[2]);
    }
}
