//! Inside, outside, and how far.
//!
//! Based on: A. Jacobson, L. Kavan, O. Sorkine-Hornung, *Robust inside-outside segmentation using generalized winding
//! numbers* (2013); G. Barill, N. Dickson, R. Schmidt, D. Levin, A. Jacobson, *Fast winding numbers for soups and
//! clouds* (2018). A point is inside where the winding number exceeds ½.

use super::closest;
use super::tree::{BoundingBox, TriangleTree};
use super::winding::WindingMoments;
use super::{Defect, DefectKind, Surface};
use crate::lattice::SignedDistance;
use nalgebra::Point3;
use rayon::prelude::*;

/// A winding number this far from ½, or less, is ambiguous.
const AMBIGUOUS: f64 = 0.3;

/// Answers where a point lies relative to a surface. Queries take a few microseconds and may run on any thread.
#[derive(Clone, Debug)]
pub struct InsideTest {
    pub(super) tree: TriangleTree,
    winding: WindingMoments,
    pub(super) bounds: BoundingBox,
    pub(super) closed: bool,
    /// The volume by the divergence theorem, and whether nothing more is needed.
    pub(super) signed_volume: f64,
    pub(super) simple: bool,
    pub(super) faces: Vec<u64>,
}

impl InsideTest {
    /// Builds the hierarchy in O(n log n).
    pub fn new(surface: &Surface) -> Self {
        let triangles: Vec<_> = (0..surface.triangles.len()).map(|t| surface.corners(t)).collect();
        let tree = TriangleTree::new(&triangles);
        Self {
            winding: WindingMoments::new(&tree, surface.closed),
            bounds: BoundingBox::of(triangles.iter().flatten()),
            tree,
            closed: surface.closed,
            signed_volume: surface.signed_volume(),
            simple: surface.simple,
            faces: surface.faces.clone(),
        }
    }

    /// The winding number: how often the surface goes around a local point; exactly an integer if the surface is
    /// closed, else to about 1e-3.
    pub fn winding(&self, point: &Point3<f64>) -> f64 {
        let [winding] = self.windings(&[*point]);
        winding
    }

    /// [`Self::winding`] of several points, cheaper if they lie close together.
    pub(super) fn windings<const N: usize>(&self, points: &[Point3<f64>; N]) -> [f64; N] {
        let windings = self.winding.at(&self.tree, points);
        if self.closed { windings.map(f64::round) } else { windings }
    }

    /// Distance from a local point to the nearest triangle, local.
    pub fn distance(&self, point: &Point3<f64>) -> f64 {
        closest::nearest(&self.tree, point).0.sqrt()
    }

    /// The face of the input file that is nearest to a local point, counted from 0.
    pub fn nearest_face(&self, point: &Point3<f64>) -> u64 {
        self.faces.get(closest::nearest(&self.tree, point).1 as usize).copied().unwrap_or(0)
    }

    /// Distance to the surface, local, negative where the winding number w exceeds ½.
    ///
    /// For a closed surface the size is [`Self::distance`]. For an open one it is distance · min(1, |1 − 2w|), which
    /// vanishes on the film w = ½ that closes a hole, so that the sign never jumps; in front of a flat round hole,
    /// on its axis, this is exactly the distance to the hole's plane. It never exceeds the distance to the surface.
    pub fn signed_distance(&self, point: &Point3<f64>) -> f64 {
        self.distance(point) * (1.0 - 2.0 * self.winding(point)).clamp(-1.0, 1.0)
    }

    /// [`Self::signed_distance`] of many points, on all threads of the current pool.
    pub fn signed_distances(&self, points: &[Point3<f64>]) -> Vec<f64> {
        points.par_iter().with_min_len(64).map(|point| self.signed_distance(point)).collect()
    }

    /// Names the sample points, if any, whose winding number lies in (0.2, 0.8): those for which the holes of the
    /// surface leave open whether they are inside.
    pub fn ambiguous(&self, points: &[Point3<f64>]) -> Option<Defect> {
        let unsure = |point: &&Point3<f64>| (self.winding(point) - 0.5).abs() < AMBIGUOUS;
        let found: Vec<&Point3<f64>> = points.par_iter().with_min_len(64).filter(unsure).collect();
        let first = self.nearest_face(found.first()?);
        let action = "inside where the winding number exceeds one half";
        Some(Defect::new(DefectKind::AmbiguousInside, found.len() as u64, first, action))
    }
}

impl SignedDistance for InsideTest {
    fn signed_distance(&self, point: &Point3<f64>) -> f64 {
        Self::signed_distance(self, point)
    }

    fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        (self.bounds.low, self.bounds.high)
    }
}

#[cfg(test)]
#[path = "inside_tests.rs"]
mod tests;
