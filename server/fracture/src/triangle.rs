//! Closest point of a triangle to a given point.
//!
//! Based on: C. Ericson, *Real-Time Collision Detection* (2005), section 5.1.5.

use nalgebra::Point3;

/// Feature of a triangle that contains the closest point, and the position on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ClosestFeature {
    /// A corner.
    Corner(usize),
    /// Point between two corners: `t` in [0, 1] from `from` to `to`.
    Edge { from: usize, to: usize, t: f64 },
    /// Interior point, with unnormalized weights of the three corners.
    Face([f64; 3]),
}

impl ClosestFeature {
    /// Feature of triangle (a, b, c) closest to `point`, found by the Voronoi regions of the features.
    ///
    /// A triangle without area yields one of its corners or edges.
    #[inline]
    pub fn of([a, b, c]: &[Point3<f64>; 3], point: &Point3<f64>) -> Self {
        let (ab, ac, ap) = (b - a, c - a, point - a);
        let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
        if d1 <= 0.0 && d2 <= 0.0 {
            return Self::Corner(0);
        }
        let bp = point - b;
        let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
        if d3 >= 0.0 && d4 <= d3 {
            return Self::Corner(1);
        }
        let vc = d1 * d4 - d3 * d2;
        if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            return Self::Edge { from: 0, to: 1, t: d1 / (d1 - d3) };
        }
        let cp = point - c;
        let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
        if d6 >= 0.0 && d5 <= d6 {
            return Self::Corner(2);
        }
        let vb = d5 * d2 - d1 * d6;
        if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            return Self::Edge { from: 0, to: 2, t: d2 / (d2 - d6) };
        }
        let va = d3 * d6 - d5 * d4;
        if va <= 0.0 && d4 >= d3 && d5 >= d6 {
            return Self::Edge { from: 1, to: 2, t: (d4 - d3) / ((d4 - d3) + (d5 - d6)) };
        }
        Self::Face([va, vb, vc])
    }

    /// Barycentric coordinates of the closest point; they sum to 1.
    #[inline]
    pub fn barycentric(self) -> [f64; 3] {
        let mut weights = [0.0; 3];
        match self {
            Self::Corner(corner) => weights[corner] = 1.0,
            Self::Edge { from, to, t } => {
                weights[from] = 1.0 - t;
                weights[to] = t;
            }
            Self::Face([va, vb, vc]) => {
                let sum = va + vb + vc;
                weights = [va / sum, vb / sum, vc / sum];
            }
        }
        weights
    }
}

/// Point of `triangle` closest to `point`.
#[inline]
pub(crate) fn closest_point(triangle: &[Point3<f64>; 3], point: &Point3<f64>) -> Point3<f64> {
    match ClosestFeature::of(triangle, point) {
        ClosestFeature::Corner(corner) => triangle[corner],
        ClosestFeature::Edge { from, to, t } => triangle[from] + (triangle[to] - triangle[from]) * t,
        ClosestFeature::Face([va, vb, vc]) => {
            let ([a, b, c], sum) = (triangle, va + vb + vc);
            a + (b - a) * (vb / sum) + (c - a) * (vc / sum)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Point3<f64>> {
        prop::array::uniform3(-1.0..1.0_f64).prop_map(Point3::from)
    }

    proptest! {
        #[test]
        fn no_point_of_a_triangle_is_closer_than_the_closest(p in point(), corners in prop::array::uniform3(point())) {
            let [a, b, c] = corners;
            let closest = closest_point(&corners, &p);
            let [u, v, w] = ClosestFeature::of(&corners, &p).barycentric();
            let weighted = Point3::from(a.coords * u + b.coords * v + c.coords * w);
            prop_assert!((weighted - closest).norm() <= 1e-9);
            let distance = (closest - p).norm();
            let mut sampled = f64::INFINITY;
            for i in 0..=40 {
                for j in 0..=40 - i {
                    let place = a + (b - a) * (f64::from(i) / 40.0) + (c - a) * (f64::from(j) / 40.0);
                    sampled = sampled.min((place - p).norm());
                }
            }
            prop_assert!(distance <= sampled + 1e-9 && sampled <= distance + 0.1);
        }
    }
}
