//! Causes of a surface that encloses no volume, or none that a lattice resolves: it is flat or a needle, or a few vertices are far
//! from all others.

use super::{RawMesh, Surface, SurfaceError};
use crate::lattice::TurnedBox;
use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use std::f64::consts::FRAC_PI_2;

/// Smallest ratio of an outlier's distance from the middle to that of the other vertices.
const TIMES_MIN: f64 = 30.0;

/// Smallest vertex count at which outliers are searched for.
const VERTICES_MIN: usize = 8;

/// Largest number of outliers. More of them are a part of the mesh.
const OUTLIERS_MAX: usize = 8;

/// Largest ratio of the least to the largest extent of a flat mesh.
const FLAT: f64 = 1e-4;

/// Smallest volume of a closed surface that is not rounding, local.
const VOLUME_MIN: f64 = 1e-14;

/// Vertices that are far from all others.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Outliers {
    /// Vertex indices and positions in m, farthest first.
    vertices: Vec<(u64, [f64; 3])>,
    distance_m: f64,
    times: f64,
}

impl Outliers {
    /// Finds the outliers among the vertices that triangles of `raw` use.
    pub fn of(raw: &RawMesh) -> Option<Self> {
        let mut used: Vec<u32> = raw.triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        if used.len() < VERTICES_MIN {
            return None;
        }
        let point = |vertex: u32| raw.positions_m[vertex as usize];
        let middle =
            Point3::from(Vector3::from_fn(|axis, _| median(used.iter().map(|vertex| point(*vertex)[axis]).collect())));
        let mut far: Vec<(f64, u32)> = used.iter().map(|vertex| ((point(*vertex) - middle).norm(), *vertex)).collect();
        far.sort_by(|a, b| b.0.total_cmp(&a.0));
        // Fewer than half, so that the middle is among the others.
        let most = OUTLIERS_MAX.min((used.len() - 1) / 2);
        let is_gap = |count: &usize| far[count - 1].0 >= TIMES_MIN * far[*count].0;
        let count = (1..=most).rev().find(is_gap)?;
        let middle = box_center(far[count..].iter().map(|(_, vertex)| point(*vertex)));
        let reach =
            |own: &[(f64, u32)]| own.iter().map(|(_, vertex)| (point(*vertex) - middle).norm()).fold(0.0, f64::max);
        let [distance_m, others_m] = [reach(&far[..count]), reach(&far[count..])];
        let times = distance_m / others_m;
        let vertices = far[..count].iter().map(|(_, vertex)| (u64::from(*vertex), point(*vertex).coords.into()));
        times.is_finite().then(|| Self { vertices: vertices.collect(), distance_m, times })
    }
}

/// Center of the bounding box of `points`.
fn box_center(points: impl Iterator<Item = Point3<f64>>) -> Point3<f64> {
    let start = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    let (low, high) = points.fold(start, |(low, high), point| (low.inf(&point.coords), high.sup(&point.coords)));
    Point3::from(0.5 * (low + high))
}

/// Median of `values`, which must not be empty; the lower one of two.
fn median(mut values: Vec<f64>) -> f64 {
    let place = (values.len() - 1) / 2;
    *values.select_nth_unstable_by(place, f64::total_cmp).1
}

impl Surface {
    /// Cause of an empty inside: outlying vertices, a needle or a flat surface. `None` if none of them applies.
    ///
    /// `thickness_min` is the thickness that the finest lattice resolves, local.
    pub fn nothing_inside(&self, thickness_min: f64) -> Option<SurfaceError> {
        if let Some(Outliers { vertices, distance_m, times }) = self.outliers.clone() {
            return Some(SurfaceError::Outliers { vertices, distance_m, times });
        }
        let extents_m = extents(&self.points_m());
        let encloses = self.closed && self.signed_volume() > VOLUME_MIN;
        let thickness_min_m = thickness_min * self.frame.diagonal_m;
        if self.closed && extents_m[1] < thickness_min_m && extents_m[2] > 0.0 {
            return Some(SurfaceError::Needle { extents_m, thickness_min_m });
        }
        SurfaceError::flat(&self.points_m(), encloses)
    }

    /// Positions of all vertices, m.
    fn points_m(&self) -> Vec<Point3<f64>> {
        self.positions.iter().map(|point| self.frame.to_meters(point)).collect()
    }
}

impl SurfaceError {
    /// The error for points that lie in a plane, or nearly so; `None` for others. `encloses`: whether the surface is closed.
    pub(super) fn flat(points_m: &[Point3<f64>], encloses: bool) -> Option<Self> {
        let extents_m = extents(points_m);
        (extents_m[2] <= FLAT * extents_m[0]).then_some(Self::Flat { extents_m, encloses })
    }
}

/// Number of directions tried across the longest axis: in a quarter turn, and again between the neighbors of the best.
const TURNS: u32 = 90;

/// Largest number of points that decide the directions, as many as measure 20 ms. The box holds all points.
const TRIED_MAX: usize = 10_000;

impl Surface {
    /// Direction across the surface if it is a sheet: the least side of its thinnest box is at most `thickness_m` long, and
    /// still the least one if it is `factor` times as long.
    pub(crate) fn axis_of_sheet(&self, factor: f64, thickness_m: f64) -> Option<Vector3<f64>> {
        let own = thinnest_box(&self.positions);
        let extent = own.extent();
        let [third, second, _] = sorted(&extent);
        let is_sheet = extent[third] * self.frame.diagonal_m <= thickness_m && factor * extent[third] < extent[second];
        is_sheet.then(|| own.turn.matrix().column(third).into_owned())
    }
}

/// Extents of the thinnest box around `points`, largest first.
fn extents(points: &[Point3<f64>]) -> [f64; 3] {
    let mut extents: [f64; 3] = thinnest_box(points).extent().into();
    extents.sort_by(|a, b| b.total_cmp(a));
    extents
}

/// Thinnest box around `points` with a side along the first or the last principal axis; of the two, the one with the smaller largest
/// face. Square plates have no first principal axis of their own, square bars no last one.
pub(super) fn thinnest_box(points: &[Point3<f64>]) -> TurnedBox {
    let mean = points.iter().map(|point| point.coords).sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let spread: Matrix3<f64> =
        points.iter().map(|point| (point.coords - mean) * (point.coords - mean).transpose()).sum();
    let eigen = spread.symmetric_eigen();
    let [third, second, first] = sorted(&eigen.eigenvalues).map(|axis| eigen.eigenvectors.column(axis).into_owned());
    let [one, other] =
        [[first, second, third], [third, first, second]].map(|axes| TurnedBox::around(box_along(axes, points), points));
    let face = |own: &TurnedBox| {
        let extent = own.extent();
        extent.product() / extent.min()
    };
    if face(&other) < face(&one) { other } else { one }
}

/// Directions of the thinnest box with a side along the first of three axes.
fn box_along([axis, one, other]: [Vector3<f64>; 3], points: &[Point3<f64>]) -> Rotation3<f64> {
    let step = points.len() / TRIED_MAX + 1;
    let directions = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        [cos * one + sin * other, cos * other - sin * one]
    };
    let along = |axis: &Vector3<f64>| {
        let along = points.iter().step_by(step).map(|point| axis.dot(&point.coords));
        let [low, high] = along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
        high - low
    };
    let thinnest = |from: f64, range: f64| {
        let angles = (0..=TURNS).map(|turn| from + range * f64::from(turn) / f64::from(TURNS));
        let thickness = |angle: f64| directions(angle).iter().map(along).fold(f64::INFINITY, f64::min);
        let least = angles.map(|angle| (thickness(angle), angle)).min_by(|one, other| one.0.total_cmp(&other.0));
        least.map_or(from, |(_, angle)| angle)
    };
    let step = FRAC_PI_2 / f64::from(TURNS);
    let [wide, _] = directions(thinnest(thinnest(0.0, FRAC_PI_2) - step, 2.0 * step));
    // Right-handed, whatever the signs of the axes are.
    Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[axis, wide, axis.cross(&wide)]))
}

/// Indices of three values, in ascending order of these.
fn sorted(values: &Vector3<f64>) -> [usize; 3] {
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cancel_token::CancelToken;
    use crate::surface::{InsideTest, shapes};
    use nalgebra::Rotation3;

    fn refused(raw: RawMesh) -> SurfaceError {
        let surface = Surface::repair(raw).unwrap();
        assert!(InsideTest::new(&surface).input_volume(&CancelToken::default()).is_err());
        surface.nothing_inside(THICKNESS_MIN).unwrap()
    }

    /// Thickness that the finest lattice resolves, local.
    const THICKNESS_MIN: f64 = 2.5e-3;

    #[test]
    fn a_thin_mesh_with_a_volume_is_called_what_it_is() {
        let cause = |sides: [f64; 3]| {
            Surface::repair(shapes::cuboid(sides)).unwrap().nothing_inside(THICKNESS_MIN).map(|error| error.to_string())
        };
        for sides in [[1000.0, 1.0, 1.0], [2.0, 2.0, 1e4], [1.0, 1e-5, 1e-5], [1.0, 1e-3, 1e-5]] {
            let message = cause(sides).unwrap();
            assert!(message.contains("needle, thin in two directions") && !message.contains("flat"), "{message}");
        }
        let needle = cause([1000.0, 1.0, 1.0]).unwrap();
        assert!(needle.contains("1.000e3 × 1.000e0 × 1.000e0 m, so it is 1000 times as long as thick"), "{needle}");
        assert!(needle.contains("make it 2.500e0 m thick or more"), "{needle}");
        // Square sections have no principal axes of their own.
        let mut turned = shapes::cuboid([30.0, 0.05, 0.05]);
        let rotation = Rotation3::from_euler_angles(0.8, 0.3, 1.1);
        turned.positions_m.iter_mut().for_each(|point| *point = rotation * *point);
        let turned = Surface::repair(turned).unwrap().nothing_inside(THICKNESS_MIN).unwrap().to_string();
        assert!(turned.contains("3.000e1 × 5.00") && turned.contains("so it is 600 times"), "{turned}");
        let message = Surface::repair(shapes::cuboid([1.0, 0.0, 2.0])).err().unwrap().to_string();
        assert!(
            message.contains("flat and encloses no volume: its extents are 2.000e0 × 1.000e0 × 0.000e0"),
            "{message}"
        );
        for angles in [[0.0, 0.0, 0.6], [0.8, 0.3, 1.1], [1.5, 0.1, 0.2]] {
            let mut turned = shapes::cuboid([1.0, 1.0, 6e-5]);
            let rotation = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
            turned.positions_m.iter_mut().for_each(|point| *point = rotation * *point);
            let turned = Surface::repair(turned).unwrap().nothing_inside(THICKNESS_MIN).unwrap().to_string();
            assert!(turned.contains("1.000e0 × 1.000e0 × 6.000e-5"), "{turned}");
        }
        // Its volume is lost in rounding, so it is as if it enclosed none.
        let far = [[0.0; 3], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 1e9]].map(Point3::from);
        let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let spike = refused(RawMesh::new(far.to_vec(), faces)).to_string();
        assert!(spike.contains("needle, thin in two directions") && !spike.contains("flat"), "{spike}");
        let plate = cause([1.0, 1.0, 1e-5]).unwrap();
        assert!(plate.contains("flat: its extents") && !plate.contains("encloses no volume"), "{plate}");
        assert_eq!(cause([1.0, 0.01, 0.01]), None);
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
            let SurfaceError::Flat { extents_m, encloses: false } = error else { panic!("{error}") };
            assert!(extents_m[0] >= 3.0 && extents_m[1] >= 2.0 && extents_m[2] < 1e-9, "{extents_m:?}");
        }
    }

    #[test]
    fn vertices_far_from_all_others_are_named() {
        let mut cube = shapes::cuboid([1.0; 3]);
        cube.positions_m[3] = Point3::new(-5e4, 5e4, 5e4);
        let Some(SurfaceError::Outliers { distance_m, times, .. }) =
            Surface::repair(cube).unwrap().nothing_inside(THICKNESS_MIN)
        else {
            panic!("no outlier")
        };
        assert!((times / 1e5 - 1.0).abs() < 1e-3 && (distance_m / 8.66e4 - 1.0).abs() < 1e-3, "{times} {distance_m}");
        for count in [1, 3, 8] {
            let mut mesh = shapes::arch();
            let first = mesh.positions_m.len() as u32;
            for far in first..first + count {
                mesh.positions_m.push(Point3::new(7e6, 1.0 + 1e6 * f64::from(far - first), -2.0));
                mesh.triangles.push([0, 1, far]);
            }
            let error = refused(mesh);
            let SurfaceError::Outliers { vertices, times, .. } = &error else { panic!("{error}") };
            let mut named: Vec<u64> = vertices.iter().map(|(vertex, _)| *vertex).collect();
            named.sort_unstable();
            assert!(named.into_iter().eq((first..first + count).map(u64::from)) && *times > 1e6, "{error}");
            assert!(error.to_string().contains(&format!("vertex {first} at (7000000, 1, -2)")), "{error}");
        }
    }
}
