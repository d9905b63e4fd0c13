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
    let corners: Vec<[Point3<f64>; 3]> =
        triangles.iter().map(|own| own.map(|vertex| positions[vertex as usize])).collect();
    let tree = TriangleTree::new(&corners);
    let moments = WindingMoments::new(&tree, false);
    let area = |triangle: u32| area_vector(positions, &triangles[triangle as usize]);
    let largest = |own: &Vec<u32>| own.iter().copied().max_by(|&a, &b| area(a).norm().total_cmp(&area(b).norm()));
    let spread = (0..triangles.len() as u32).step_by(triangles.len().div_ceil(SAMPLES).max(1));
    let samples: Vec<u32> = patches.iter().filter_map(largest).chain(spread).collect();
    let numbers = |&triangle: &u32| {
        let [a, b, c] = corners[triangle as usize];
        let (center, area) = (Point3::from((a.coords + b.coords + c.coords) / 3.0), area(triangle));
        let offset = area.try_normalize(0.0)? * (DISTANCE * area.norm().sqrt());
        let both = [center + offset, center - offset].map(|point| moments.at(&tree, &[point])[0]);
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
