//! The surface that is meshed: the input's, or what is left of it after repairs.

use crate::skin::{PointAttributes, surface_corners};
use crate::surface::Surface;
use nalgebra::Point3;
use std::collections::HashMap;

/// Coordinates below this are zero to the mesher, local: the signs of its predicates are exact for no smaller ones.
const COORDINATE_MIN: f64 = 1e-40;

/// Triangles whose corners have attributes of the input.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MeshedSurface {
    /// Vertices, local.
    pub positions: Vec<Point3<f64>>,
    /// Triangles, outward.
    pub triangles: Vec<[u32; 3]>,
    /// Attributes of each triangle; empty if they were not selected.
    pub corners: Vec<[PointAttributes; 3]>,
    /// Triangle of the input that contains each triangle.
    pub sources: Vec<u32>,
}

impl MeshedSurface {
    /// The input itself.
    pub fn new(surface: &Surface, has_attributes: bool) -> Self {
        let corners = if has_attributes { surface_corners(surface) } else { Vec::new() };
        Self {
            positions: surface.positions.iter().map(|at| at.map(flushed)).collect(),
            triangles: surface.triangles.clone(),
            corners: corners.iter().map(|own| own.map(|corner| corner.attributes)).collect(),
            sources: (0..surface.triangles.len() as u32).collect(),
        }
    }

    /// Area of the triangles whose source is to be counted.
    pub fn area(&self, is_counted: impl Fn(&u32) -> bool) -> f64 {
        let counted = self.triangles.iter().zip(&self.sources).filter(|(_, source)| is_counted(source));
        let area = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|vertex| self.positions[vertex as usize]);
            0.5 * (b - a).cross(&(c - a)).norm()
        };
        counted.map(|(corners, _)| area(corners)).sum()
    }

    /// True if triangles run through every edge equally often in both directions.
    pub fn is_balanced(&self) -> bool {
        let mut balance: HashMap<[u32; 2], i32> = HashMap::new();
        for [a, b] in self.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]) {
            *balance.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
        }
        balance.values().all(|sum| *sum == 0)
    }

    /// Drops triangles with a repeated vertex, and vertices of no triangle; keeps the order.
    #[must_use]
    pub fn compact(mut self) -> Self {
        let is_whole: Vec<bool> = self.triangles.iter().map(|&[a, b, c]| a != b && b != c && c != a).collect();
        fn keep<T>(list: &mut Vec<T>, is_whole: &[bool]) {
            let mut own = is_whole.iter();
            list.retain(|_| own.next().copied().unwrap_or(false));
        }
        keep(&mut self.triangles, &is_whole);
        keep(&mut self.corners, &is_whole);
        keep(&mut self.sources, &is_whole);
        let mut names = vec![u32::MAX; self.positions.len()];
        self.triangles.iter().flatten().for_each(|&vertex| names[vertex as usize] = 0);
        let mut kept = Vec::new();
        for (vertex, name) in names.iter_mut().enumerate().filter(|(_, name)| **name == 0) {
            *name = kept.len() as u32;
            kept.push(self.positions[vertex]);
        }
        self.positions = kept;
        self.triangles.iter_mut().flatten().for_each(|vertex| *vertex = names[*vertex as usize]);
        self
    }
}

/// `x`, or zero where that is much smaller than any length of the object.
fn flushed(x: f64) -> f64 {
    if x.abs() < COORDINATE_MIN { 0.0 } else { x }
}
