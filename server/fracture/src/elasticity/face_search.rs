//! Search of the faces of a surface by boxes around consecutive ones, for contacts and rays.

use crate::memory::held;
use crate::triangle::closest_point;
use nalgebra::Point3;
use std::ops::Range;

/// Number of faces per box.
const GROUP: usize = 32;

/// Relative rounding error by which a box may seem too far.
const SLACK: f64 = 1e-9;

/// Bounding boxes of 32 consecutive faces each: low and high corner.
///
/// Lattices number their tetrahedra row by row, and meshes of the input surface along a curve, so consecutive faces are
/// near each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaceBoxes(Vec<[Point3<f64>; 2]>);

impl FaceBoxes {
    /// The boxes of `count` faces with these corners.
    pub fn new(count: usize, corners: impl Fn(usize) -> [Point3<f64>; 3]) -> Self {
        let empty = [f64::INFINITY, f64::NEG_INFINITY].map(|end| Point3::new(end, end, end));
        let around = |[low, high]: [Point3<f64>; 2], corner: Point3<f64>| [low.inf(&corner), high.sup(&corner)];
        let bounds = |first: usize| (first..count.min(first + GROUP)).flat_map(&corners).fold(empty, around);
        Self((0..count).step_by(GROUP).map(bounds).collect())
    }

    /// Bytes of memory that they hold.
    pub fn bytes(&self) -> usize {
        held(&self.0)
    }
}

/// Faces of a surface.
pub trait SurfaceFaces {
    /// Number of faces.
    fn count(&self) -> usize;

    /// Corner positions of face `face`, local, counter-clockwise seen from outside.
    fn corners(&self, face: usize) -> [Point3<f64>; 3];
}

/// Nearest boundary point to a given point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestBoundaryPoint {
    /// Face that contains it.
    pub face: usize,
    /// Position, local.
    pub place: Point3<f64>,
    /// Distance from the given point, local.
    pub distance: f64,
}

/// Faces of a surface with their boxes.
#[derive(Clone, Copy)]
pub struct FaceSearch<'a> {
    /// The faces.
    pub faces: &'a dyn SurfaceFaces,
    /// Boxes of the same faces.
    pub boxes: &'a FaceBoxes,
}

impl FaceSearch<'_> {
    /// Each box with the range of its faces.
    pub(super) fn groups(&self) -> impl Iterator<Item = (Range<usize>, &[Point3<f64>; 2])> {
        self.boxes.0.iter().enumerate().map(|(group, bounds)| (self.of_group(group), bounds))
    }

    fn of_group(&self, group: usize) -> Range<usize> {
        group * GROUP..(group * GROUP + GROUP).min(self.faces.count())
    }

    /// Nearest boundary point to `point`; the lowest face wins ties. `None` if there are no faces.
    pub fn nearest(&self, point: &Point3<f64>) -> Option<NearestBoundaryPoint> {
        let bounds = || self.boxes.0.iter().map(|bounds| distance_squared(point, bounds));
        let (likely, _) = bounds().enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let mut best = self.nearest_in(point, likely, None);
        for (group, bound) in bounds().enumerate() {
            // The comparison is false for NaN, so a box at an unknown distance is searched.
            let farther = best.is_some_and(|best| bound * (1.0 - SLACK) > best.distance * best.distance);
            if group != likely && !farther {
                best = self.nearest_in(point, group, best);
            }
        }
        best
    }

    /// Nearer of `best` and the nearest point on the faces of one box.
    fn nearest_in(
        &self,
        point: &Point3<f64>,
        group: usize,
        mut best: Option<NearestBoundaryPoint>,
    ) -> Option<NearestBoundaryPoint> {
        for face in self.of_group(group) {
            let place = closest_point(&self.faces.corners(face), point);
            // Overflow far outside yields NaN, which counts as infinitely far.
            let distance = (place - point).norm().min(f64::INFINITY);
            if best.is_none_or(|best| (distance, face) < (best.distance, best.face)) {
                best = Some(NearestBoundaryPoint { face, place, distance });
            }
        }
        best
    }
}

/// Squared distance from `point` to a box; 0 inside.
fn distance_squared(point: &Point3<f64>, [low, high]: &[Point3<f64>; 2]) -> f64 {
    let clamped = point.coords.sup(&low.coords).inf(&high.coords);
    (point.coords - clamped).norm_squared()
}
