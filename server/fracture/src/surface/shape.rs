//! Why a surface encloses nothing: it is flat, or a vertex is far from all others.

use super::{RawMesh, Surface, SurfaceError};
use nalgebra::{Matrix3, Point3, Vector3};

/// Share of the vertices among which an outlier is none.
const NEARLY_ALL: f64 = 0.9;

/// An outlier is so many times as far from the middle as nearly all vertices.
const TIMES_MIN: f64 = 30.0;

/// Fewer vertices have no outlier.
const VERTICES_MIN: usize = 8;

/// A mesh whose least extent is this small, over its largest, is flat.
const FLAT: f64 = 1e-4;

/// The vertex that is farthest from all others, if it is far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Outlier {
    vertex: u64,
    at_m: Point3<f64>,
    distance_m: f64,
    times: f64,
}

impl Outlier {
    /// That of the vertices that triangles of `raw` use.
    pub fn of(raw: &RawMesh) -> Option<Self> {
        let mut used: Vec<u32> = raw.triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        if used.len() < VERTICES_MIN {
            return None;
        }
        let point = |vertex: u32| raw.positions_m[vertex as usize];
        let middle = Point3::from(Vector3::from_fn(|axis, _| {
            median(used.iter().map(|vertex| point(*vertex)[axis]).collect(), 0.5)
        }));
        let distance = |vertex: u32| (point(vertex) - middle).norm();
        let usual = median(used.iter().map(|vertex| distance(*vertex)).collect(), NEARLY_ALL);
        let vertex = used.iter().copied().max_by(|a, b| distance(*a).total_cmp(&distance(*b)))?;
        let (distance_m, times) = (distance(vertex), distance(vertex) / usual);
        let found = Self { vertex: u64::from(vertex), at_m: point(vertex), distance_m, times };
        (times.is_finite() && times >= TIMES_MIN).then_some(found)
    }
}

/// The value below which `share` of them are; there is at least one.
fn median(mut values: Vec<f64>, share: f64) -> f64 {
    let place = (share * (values.len() - 1) as f64) as usize;
    *values.select_nth_unstable_by(place, f64::total_cmp).1
}

impl Surface {
    /// Why nothing is inside: one vertex is far from all others, or the surface is flat, if either is so.
    pub fn nothing_inside(&self) -> Option<SurfaceError> {
        if let Some(Outlier { vertex, at_m, distance_m, times }) = self.outlier {
            return Some(SurfaceError::Outlier { vertex, at_m: at_m.coords.into(), distance_m, times });
        }
        let extents_m = self.extents().map(|extent| extent * self.frame.diagonal_m);
        (extents_m[2] <= FLAT * extents_m[0]).then_some(SurfaceError::Flat { extents_m })
    }

    /// Extents along the principal axes, the largest first, local.
    fn extents(&self) -> [f64; 3] {
        let count = self.positions.len().max(1) as f64;
        let mean = self.positions.iter().map(|point| point.coords).sum::<Vector3<f64>>() / count;
        let spread = self.positions.iter().map(|point| point.coords - mean);
        let spread: Matrix3<f64> = spread.map(|offset| offset * offset.transpose()).sum();
        let axes = spread.symmetric_eigen().eigenvectors;
        let mut extents = [0, 1, 2].map(|axis| {
            let along = self.positions.iter().map(|point| axes.column(axis).dot(&point.coords));
            let [low, high] =
                along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
            (high - low).max(0.0)
        });
        extents.sort_by(|a, b| b.total_cmp(a));
        extents
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cancel_token::CancelToken;
    use crate::surface::{InsideTest, shapes};

    fn refused(raw: RawMesh) -> SurfaceError {
        let surface = Surface::repair(raw).unwrap();
        assert!(InsideTest::new(&surface).input_volume(&CancelToken::default()).is_err());
        surface.nothing_inside().unwrap()
    }

    #[test]
    fn a_flat_mesh_is_called_flat_whichever_way_it_lies() {
        let sheet = |tilt: f64| {
            let points = (0..4).flat_map(|x| (0..3).map(move |y| [f64::from(x), f64::from(y)]));
            let points = points.map(|[x, y]| Point3::new(x, tilt * x + y, tilt * y)).collect();
            let cell = |x: u32, y: u32| {
                [[3 * x + y, 3 * x + y + 3, 3 * x + y + 1], [3 * x + y + 1, 3 * x + y + 3, 3 * x + y + 4]]
            };
            RawMesh::new(points, (0..3).flat_map(|x| (0..2).flat_map(move |y| cell(x, y))).collect())
        };
        for tilt in [0.0, 0.7] {
            let error = refused(sheet(tilt));
            let SurfaceError::Flat { extents_m } = error else { panic!("{error}") };
            assert!(extents_m[0] >= 3.0 && extents_m[1] >= 2.0 && extents_m[2] < 1e-9, "{extents_m:?}");
        }
    }

    #[test]
    fn a_vertex_far_from_all_others_is_named() {
        let mut mesh = shapes::arch();
        let first = mesh.positions_m.len() as u32;
        mesh.positions_m.push(Point3::new(7e6, 1.0, -2.0));
        mesh.triangles.push([0, 1, first]);
        let error = refused(mesh);
        let SurfaceError::Outlier { vertex, at_m, times, .. } = error else { panic!("{error}") };
        assert!(vertex == u64::from(first) && at_m == [7e6, 1.0, -2.0] && times > 1e6, "{error}");
        assert!(error.to_string().contains("(7000000, 1, -2)"), "{error}");
    }
}
