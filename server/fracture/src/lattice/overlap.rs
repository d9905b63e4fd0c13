//! Intersection of two tetrahedra: volume and centroid.

use nalgebra::{Matrix3, Point3, Vector3};

/// Share of the clipped tetrahedron below which an overlap counts as rounding.
const NEGLIGIBLE: f64 = 1e-12;

type Tet = [Vector3<f64>; 4];

/// Positively oriented tetrahedron, prepared for intersection.
#[derive(Clone, Copy, Debug)]
pub(super) struct OverlapCell {
    corners: Tet,
    /// Gradients of the barycentric coordinates 1 to 3, as rows.
    inverse: Matrix3<f64>,
}

impl OverlapCell {
    /// Prepares a tetrahedron from its corners; its volume must be positive.
    pub(super) fn new(corners: &[Point3<f64>; 4]) -> Self {
        let corners = corners.map(|corner| corner.coords);
        let [a, b, c, d] = corners;
        let inverse = Matrix3::from_columns(&[b - a, c - a, d - a]).try_inverse();
        Self { corners, inverse: inverse.unwrap_or_else(Matrix3::zeros) }
    }

    /// Barycentric coordinates of `point`, inside or not.
    pub(super) fn barycentric(&self, point: &Vector3<f64>) -> [f64; 4] {
        let weights = self.inverse * (point - self.corners[0]);
        [1.0 - weights.sum(), weights.x, weights.y, weights.z]
    }

    /// Returns true if the plane of some face has all of `tet` on its outer side.
    fn excludes(&self, tet: &Tet) -> bool {
        let mut highest = [f64::NEG_INFINITY; 4];
        for corner in tet {
            let weights = self.barycentric(corner);
            (0..4).for_each(|k| highest[k] = highest[k].max(weights[k]));
        }
        highest.iter().any(|weight| *weight <= 0.0)
    }
}

/// Scratch memory for intersections.
#[derive(Clone, Debug, Default)]
pub(super) struct Overlap {
    parts: Vec<Tet>,
    clipped: Vec<Tet>,
}

impl Overlap {
    /// Volume and centroid of the intersection of two tetrahedra. `None` if it is empty or negligible.
    pub(super) fn of(&mut self, tet: &OverlapCell, other: &OverlapCell) -> Option<(f64, Vector3<f64>)> {
        if tet.excludes(&other.corners) || other.excludes(&tet.corners) {
            return None;
        }
        self.parts.clear();
        self.parts.push(tet.corners);
        for face in 0..4 {
            self.clipped.clear();
            for part in &self.parts {
                clip(part, part.map(|corner| other.barycentric(&corner)[face]), &mut self.clipped);
            }
            std::mem::swap(&mut self.parts, &mut self.clipped);
        }
        let (mut volume, mut moment) = (0.0, Vector3::zeros());
        for part in &self.parts {
            let own = volume_of(part);
            volume += own;
            moment += part.iter().sum::<Vector3<f64>>() * (own / 4.0);
        }
        (volume > NEGLIGIBLE * volume_of(&tet.corners)).then(|| (volume, moment / volume))
    }
}

fn volume_of([a, b, c, d]: &Tet) -> f64 {
    ((b - a).dot(&(c - a).cross(&(d - a))) / 6.0).abs()
}

/// Appends tetrahedra that fill the part of `tet` where a linear function is positive.
/// `values` holds it at the corners.
fn clip(tet: &Tet, values: [f64; 4], parts: &mut Vec<Tet>) {
    let mut order = [0, 1, 2, 3];
    order.sort_by(|&i, &j| values[j].total_cmp(&values[i]));
    let [a, b, c, d] = order.map(|k| tet[k]);
    let value = order.map(|k| values[k]);
    let cut = |i: usize, j: usize| {
        let t = value[i] / (value[i] - value[j]);
        tet[order[i]].lerp(&tet[order[j]], t)
    };
    match value.iter().filter(|value| **value > 0.0).count() {
        0 => {}
        1 => parts.push([a, cut(0, 1), cut(0, 2), cut(0, 3)]),
        2 => prism([a, cut(0, 2), cut(0, 3)], [b, cut(1, 2), cut(1, 3)], parts),
        3 => prism([a, b, c], [cut(0, 3), cut(1, 3), cut(2, 3)], parts),
        _ => parts.push([a, b, c, d]),
    }
}

/// Splits a convex prism into three tetrahedra. Its quadrilaterals are planar, so any diagonals are valid.
fn prism(top: [Vector3<f64>; 3], bottom: [Vector3<f64>; 3], parts: &mut Vec<Tet>) {
    parts.push([top[0], top[1], top[2], bottom[2]]);
    parts.push([top[0], top[1], bottom[1], bottom[2]]);
    parts.push([top[0], bottom[0], bottom[1], bottom[2]]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::block;
    use crate::random::RandomStream;
    use nalgebra::Isometry3;

    #[test]
    fn a_lattice_is_cut_up_by_another_without_gain_or_loss() {
        let whole = block([2, 2, 2], 0.3);
        let turned = block([5, 5, 5], 0.35).transformed(&Isometry3::rotation(Vector3::new(0.3, 0.5, -0.2)));
        let cells: Vec<OverlapCell> =
            (0..turned.tets.len()).map(|tet| OverlapCell::new(&turned.corners(tet))).collect();
        let mut overlap = Overlap::default();
        for tet in (0..whole.tets.len()).step_by(7) {
            let own = OverlapCell::new(&whole.corners(tet));
            let common: Vec<_> = cells.iter().filter_map(|cell| overlap.of(&own, cell)).collect();
            let volume: f64 = common.iter().map(|(volume, _)| volume).sum();
            let centroid = common.iter().map(|(volume, centroid)| centroid * *volume).sum::<Vector3<f64>>() / volume;
            assert!(common.len() > 1 && (volume / whole.tet_volume(tet) - 1.0).abs() < 1e-10);
            assert!((centroid - own.corners.iter().sum::<Vector3<f64>>() / 4.0).norm() < 1e-12);
        }
    }

    #[test]
    fn the_overlap_does_not_depend_on_the_order_and_lies_in_both() {
        let mut stream = RandomStream::new(3, 0);
        let mut random = move || {
            let point = [(); 4].map(|()| Point3::from([(); 3].map(|()| stream.uniform())));
            let [a, b, c, d] = point;
            if (b - a).dot(&(c - a).cross(&(d - a))) > 0.0 { [a, b, c, d] } else { [b, a, c, d] }
        };
        let (mut overlap, mut met) = (Overlap::default(), 0);
        for _ in 0..2000 {
            let (first, second) = (OverlapCell::new(&random()), OverlapCell::new(&random()));
            let (there, back) = (overlap.of(&first, &second), overlap.of(&second, &first));
            let (Some((volume, centroid)), Some((same, _))) = (there, back) else { continue };
            assert!((volume - same).abs() < 1e-12);
            for cell in [first, second] {
                assert!(cell.barycentric(&centroid).iter().all(|weight| *weight > -1e-6));
            }
            met += 1;
        }
        assert!(met > 500);
    }

    #[test]
    fn neighboring_and_distant_tetrahedra_do_not_overlap() {
        let lattice = block([1, 1, 1], 1.0);
        let cells: Vec<OverlapCell> =
            (0..lattice.tets.len()).map(|tet| OverlapCell::new(&lattice.corners(tet))).collect();
        let mut overlap = Overlap::default();
        for (i, first) in cells.iter().enumerate() {
            for (j, second) in cells.iter().enumerate() {
                assert_eq!(overlap.of(first, second).is_some(), i == j);
            }
        }
    }
}
