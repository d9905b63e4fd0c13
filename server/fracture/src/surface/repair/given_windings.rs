//! Check whether the windings of the input are right as they are.

use super::super::tree::{BoundingBox, TriangleTree};
use super::super::winding::{WindingMoments, triangle_winding};
use super::orient::area_vector;
use nalgebra::Point3;
use rayon::prelude::*;

/// Triangles that are tried besides one of each patch.
const SAMPLES: usize = 256;

/// Distance of a point from its triangle, over the root of the triangle's area.
const DISTANCE: f64 = 1e-6;

/// Largest distance of a winding number from a whole one. Near holes it is larger.
const TOLERANCE: f64 = 0.1;

/// Smallest change of a triangle's winding number where it covers a point; on its edges the change is one half.
const JUMP_MIN: f64 = 0.25;

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
    let found: Option<Vec<[i32; 2]>> = samples.par_iter().map(|&triangle| sides.whole_windings(triangle)).collect();
    let found = found?;
    let is_in = |known: i32| found.iter().flatten().all(|&own| own == 0 || own == known);
    let is_empty = found.iter().flatten().all(|&own| own == 0);
    [(1, GivenWindings::Outward), (-1, GivenWindings::Inward)]
        .into_iter()
        .find(|(known, _)| !is_empty && is_in(*known))
        .map(|(_, windings)| windings)
}

/// Winding numbers on both sides of the triangles of a surface.
pub(super) struct Sides {
    corners: Vec<[Point3<f64>; 3]>,
    tree: TriangleTree,
    moments: WindingMoments,
}

impl Sides {
    pub fn new(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> Self {
        let corners: Vec<[Point3<f64>; 3]> =
            triangles.iter().map(|own| own.map(|vertex| positions[vertex as usize])).collect();
        let tree = TriangleTree::new(&corners);
        let moments = WindingMoments::new(&tree, false);
        Self { corners, tree, moments }
    }

    /// Winding numbers in front of a triangle and behind it; `None` if one is not a whole number, or the triangle has no area.
    pub fn whole_windings(&self, triangle: u32) -> Option<[i32; 2]> {
        let both = self.windings(triangle)?;
        let is_whole = |own: &f64| (own - own.round()).abs() <= TOLERANCE;
        both.iter().all(is_whole).then(|| both.map(|own| own.round() as i32))
    }

    /// Winding numbers in front of a triangle and behind it; `None` if it has no area.
    fn windings(&self, triangle: u32) -> Option<[f64; 2]> {
        Some(self.points(triangle)?.map(|point| self.moments.at(&self.tree, &[point])[0]))
    }

    /// Other triangles that cover the center of a triangle, facing the same way.
    pub fn layers(&self, triangle: u32) -> Vec<u32> {
        let mut layers = Vec::new();
        if let Some([front, behind]) = self.points(triangle) {
            self.tree.overlapping(&BoundingBox::of(&[front, behind]), 0, |place| {
                let own = &self.tree.triangles[place];
                let jump = triangle_winding(own, &behind) - triangle_winding(own, &front);
                if self.tree.order[place] != triangle && jump > JUMP_MIN {
                    layers.push(self.tree.order[place]);
                }
            });
        }
        layers
    }

    /// Points in front of the center of a triangle and behind it; `None` if it has no area.
    fn points(&self, triangle: u32) -> Option<[Point3<f64>; 2]> {
        let [a, b, c] = self.corners[triangle as usize];
        let center = Point3::from((a.coords + b.coords + c.coords) / 3.0);
        let area = (b - a).cross(&(c - a)) * 0.5;
        let offset = area.try_normalize(0.0)? * (DISTANCE * area.norm().sqrt());
        Some([center + offset, center - offset])
    }
}

/// Returns true if one of the triangles `tried` lies between a solid and another one that is inside out.
pub(super) fn separates_inverted(positions: &[Point3<f64>], triangles: &[[u32; 3]], tried: &[u32]) -> bool {
    let sides = Sides::new(positions, triangles);
    tried.par_iter().any(|&triangle| {
        sides.windings(triangle).is_some_and(|[front, behind]| front.min(behind) < -0.5 && front.max(behind) > 0.5)
    })
}
