//! Exact signs of orientation and in-sphere determinants.
//!
//! A determinant in `f64` decides where its error bound allows; otherwise `robust` does, after: J. R. Shewchuk, *Adaptive
//! precision floating-point arithmetic and fast robust geometric predicates* (1997). The bounds are semi-static, as in:
//! O. Devillers, S. Pion, *Efficient exact geometric predicates for Delaunay triangulations* (2003).

use nalgebra::{Point3, Vector3};
use robust::Coord3D;

/// Bound on the error of the orientation determinant, relative to the product of the largest differences per axis.
///
/// 6 products with 8 rounding errors of 2^-53 each give 5.4e-15.
const ORIENTATION_ERROR: f64 = 1e-14;
/// Bound on the error of the in-sphere determinant, relative to that product times the largest squared difference.
///
/// 24 products of at most 3, with 17 rounding errors of 2^-53 each, give 1.4e-13.
const IN_SPHERE_ERROR: f64 = 2.5e-13;
/// Least bound for which products of differences do not underflow.
const BOUND_MIN: f64 = 1e-200;

/// Least and largest magnitude of a coordinate other than 0 for which `robust` is exact.
///
/// In-sphere products of five coordinates neither underflow, with 53 bits each, nor overflow: 2^-160 and 2^160.
const COORDINATE_RANGE: [f64; 2] = [6.9e-49, 1.4e48];

/// Returns true if the signs at a point are exact.
pub(super) fn is_exact(point: &Point3<f64>) -> bool {
    let [least, largest] = COORDINATE_RANGE;
    point.iter().all(|x| *x == 0.0 || (least..=largest).contains(&x.abs()))
}

/// Positive if the tetrahedron (a, b, c, d) has a positive volume, negative if negative, 0 if the points are coplanar.
#[inline]
pub(super) fn orientation(a: &Point3<f64>, b: &Point3<f64>, c: &Point3<f64>, d: &Point3<f64>) -> f64 {
    let (ad, bd, cd) = (a - d, b - d, c - d);
    let determinant =
        ad.x * (bd.z * cd.y - bd.y * cd.z) + ad.y * (bd.x * cd.z - bd.z * cd.x) + ad.z * (bd.y * cd.x - bd.x * cd.y);
    let largest = ad.abs().sup(&bd.abs()).sup(&cd.abs());
    let bound = ORIENTATION_ERROR * (largest.x * largest.y * largest.z);
    if bound > BOUND_MIN && determinant.abs() > bound {
        return determinant;
    }
    -robust::orient3d(coord(a), coord(b), coord(c), coord(d))
}

/// Positive if `point` is strictly inside the sphere through the corners of a positive tetrahedron, 0 on it.
#[inline]
pub(super) fn in_sphere(corners: [&Point3<f64>; 4], point: &Point3<f64>) -> f64 {
    let [a, b, c, d] = corners.map(|corner| corner - point);
    let minor = |u: &Vector3<f64>, v: &Vector3<f64>| u.x * v.y - v.x * u.y;
    let (ab, bc, cd, da) = (minor(&a, &b), minor(&b, &c), minor(&c, &d), minor(&d, &a));
    let (ac, bd) = (minor(&a, &c), minor(&b, &d));
    let abc = a.z * bc - b.z * ac + c.z * ab;
    let bcd = b.z * cd - c.z * bd + d.z * bc;
    let cda = c.z * da + d.z * ac + a.z * cd;
    let dab = d.z * ab + a.z * bd + b.z * da;
    let determinant =
        (c.norm_squared() * dab - d.norm_squared() * abc) + (a.norm_squared() * bcd - b.norm_squared() * cda);
    let largest = a.abs().sup(&b.abs()).sup(&c.abs().sup(&d.abs()));
    let bound = IN_SPHERE_ERROR * (largest.x * largest.y * largest.z) * largest.max().powi(2);
    if bound > BOUND_MIN && determinant.abs() > bound {
        return determinant;
    }
    let [a, b, c, d] = corners.map(coord);
    -robust::insphere(a, b, c, d, coord(point))
}

fn coord(point: &Point3<f64>) -> Coord3D<f64> {
    Coord3D { x: point.x, y: point.y, z: point.z }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(corner: [i32; 3]) -> Point3<f64> {
        Point3::from(corner.map(f64::from))
    }

    /// Determinant of integers, by expansion along the first column.
    fn determinant(rows: &[Vec<i128>]) -> i128 {
        if rows.len() == 1 {
            return rows[0][0];
        }
        let without = |k: usize| -> Vec<Vec<i128>> {
            (0..rows.len()).filter(|&row| row != k).map(|row| rows[row][1..].to_vec()).collect()
        };
        (0..rows.len()).map(|k| if k % 2 == 0 { 1 } else { -1 } * rows[k][0] * determinant(&without(k))).sum()
    }

    fn rows(corners: &[[i32; 3]], origin: [i32; 3], lifted: bool) -> Vec<Vec<i128>> {
        let row = |corner: &[i32; 3]| {
            let difference = [0, 1, 2].map(|k| i128::from(corner[k]) - i128::from(origin[k]));
            let lift = difference.iter().map(|x| x * x).sum();
            difference.into_iter().chain(lifted.then_some(lift)).collect()
        };
        corners.iter().map(row).collect()
    }

    fn corners() -> impl Strategy<Value = Vec<[i32; 3]>> {
        let small = prop::collection::vec(prop::array::uniform3(-3..4_i32), 5);
        let large = prop::collection::vec(prop::array::uniform3(-1_000_000..1_000_000_i32), 5);
        let far = small.clone().prop_map(|list| list.into_iter().map(|p| p.map(|x| x + 1_000_000)).collect());
        prop_oneof![small, large, far]
    }

    proptest! {
        #[test]
        fn signs_are_those_of_integers(list in corners()) {
            let p: Vec<Point3<f64>> = list.iter().copied().map(at).collect();
            let volume = determinant(&rows(&list[1..4], list[0], false));
            let sign = orientation(&p[0], &p[1], &p[2], &p[3]);
            prop_assert_eq!(volume.signum(), sign.partial_cmp(&0.0).map_or(9, |order| order as i128));
            if volume > 0 {
                let sphere = -determinant(&rows(&list[..4], list[4], true));
                let sign = in_sphere([&p[0], &p[1], &p[2], &p[3]], &p[4]);
                prop_assert_eq!(sphere.signum(), sign.partial_cmp(&0.0).map_or(9, |order| order as i128));
            }
        }
    }

    #[test]
    fn the_center_of_a_positive_tetrahedron_is_inside_its_sphere() {
        let [a, b, c, d] = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]].map(at);
        assert!(orientation(&a, &b, &c, &d) > 0.0);
        assert!(in_sphere([&a, &b, &c, &d], &at([1, 1, 1])) > 0.0);
        assert!(in_sphere([&a, &b, &c, &d], &at([4, 4, 4])) == 0.0);
        assert!(in_sphere([&a, &b, &c, &d], &at([5, 4, 4])) < 0.0);
    }
}
