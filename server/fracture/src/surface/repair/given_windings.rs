//! Check whether the windings of the input are right as they are.

use super::super::tree::TriangleTree;
use super::super::winding::WindingMoments;
use super::orient::area_vector;
use nalgebra::Point3;
use rayon::prelude::*;

/// Triangles that are tried besides one of each patch.
const SAMPLES: usize = 256;

/// Distance of a point from its triangle, over the root of the triangle's area.
const DISTANCE: f64 = 1e-6;

/// Largest distance of a winding number from a whole one. Near holes it is larger.
const TOLERANCE: f64 = 0.1;

/// Windings that need no repair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum GivenWindings {
    /// Winding numbers are 0 and 1.
    Outward,
    /// Winding numbers are 0 and -1.
    Inward,
}

/// The windings of a surface, if the winding numbers on both sides of its triangles are those of a solid; else `None`.
///
/// The largest triangle of each patch and some others are tried.
pub(super) fn given_windings(
    positions: &[Point3<f64>],
    triangles: &[[u32; 3]],
    patches: &[Vec<u32>],
) -> Option<GivenWindings> {
    let sides = Sides::new(positions, triangles);
    let area = |triangle: u32| area_vector(positions, &triangles[triangle as usize]);
    let largest = |own: &Vec<u32>| own.iter().copied().max_by(|&a, &b| area(a).norm().total_cmp(&area(b).norm()));
    let spread = (0..triangles.len() as u32).step_by(triangles.len().div_ceil(SAMPLES).max(1));
    let samples: Vec<u32> = patches.iter().filter_map(largest).chain(spread).collect();
    let numbers = |&triangle: &u32| {
        let both = sides.windings(triangle)?;
        let whole = both.map(f64::round);
        both.iter().zip(whole).all(|(own, whole)| (own - whole).abs() <= TOLERANCE).then_some(whole)
    };
    let found: Option<Vec<[f64; 2]>> = samples.par_iter().map(numbers).collect();
    let found = found?;
    let is_in = |known: f64| found.iter().flatten().all(|&own| own == 0.0 || own == known);
    let is_empty = found.iter().flatten().all(|&own| own == 0.0);
    [(1.0, GivenWindings::Outward), (-1.0, GivenWindings::Inward)]
        .into_iter()
        .find(|(known, _)| !is_empty && is_in(*known))
        .map(|(_, windings)| windings)
}

/// Winding numbers on both sides of the triangles of a surface.
struct Sides {
    corners: Vec<[Point3<f64>; 3]>,
    tree: TriangleTree,
    moments: WindingMoments,
}

impl Sides {
    fn new(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> Self {
        let corners: Vec<[Point3<f64>; 3]> =
            triangles.iter().map(|own| own.map(|vertex| positions[vertex as usize])).collect();
        let tree = TriangleTree::new(&corners);
        let moments = WindingMoments::new(&tree, false);
        Self { corners, tree, moments }
    }

    /// Winding numbers in front of a triangle and behind it; `None` if it has no area.
    fn windings(&self, triangle: u32) -> Option<[f64; 2]> {
        let [a, b, c] = self.corners[triangle as usize];
        let center = Point3::from((a.coords + b.coords + c.coords) / 3.0);
        let area = (b - a).cross(&(c - a)) * 0.5;
        let offset = area.try_normalize(0.0)? * (DISTANCE * area.norm().sqrt());
        Some([center + offset, center - offset].map(|point| self.moments.at(&self.tree, &[point])[0]))
    }
}

/// Returns true if one of the triangles `tried` lies between a solid and another one that is inside out.
pub(super) fn separates_inverted(positions: &[Point3<f64>], triangles: &[[u32; 3]], tried: &[u32]) -> bool {
    let sides = Sides::new(positions, triangles);
    tried.par_iter().any(|&triangle| {
        sides.windings(triangle).is_some_and(|[front, behind]| front.min(behind) < -0.5 && front.max(behind) > 0.5)
    })
}
