//! Inside test and signed distance of a surface.
//!
//! A point is inside where the winding number exceeds ½.
//!
//! Based on: A. Jacobson, L. Kavan, O. Sorkine-Hornung, *Robust inside-outside segmentation using generalized
//! winding numbers* (2013); G. Barill, N. Dickson, R. Schmidt, D. Levin, A. Jacobson, *Fast winding numbers
//! for soups and clouds* (2018).

use super::closest;
use super::shape::thinnest_box;
use super::tree::{BoundingBox, TriangleTree};
use super::winding::WindingMoments;
use super::{Defect, DefectKind, Surface};
use crate::lattice::{self, SignedDistance, TurnedBox};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use std::sync::OnceLock;

/// Largest difference of an ambiguous winding number from ½.
const AMBIGUOUS: f64 = 0.3;

/// Point location relative to a surface: winding number, distance and signed distance.
///
/// Queries take a few microseconds and may run on any thread.
#[derive(Clone, Debug)]
pub struct InsideTest {
    /// Hierarchy of the triangles.
    pub(super) tree: TriangleTree,
    winding: WindingMoments,
    /// Bounding box of the triangles.
    pub(super) bounds: BoundingBox,
    /// True if the winding number is an integer.
    pub(super) closed: bool,
    /// Volume by the divergence theorem, local.
    pub(super) signed_volume: f64,
    /// True if `signed_volume` is the enclosed volume, without further integration.
    pub(super) simple: bool,
    /// Face of the input file that each triangle came from.
    pub(super) faces: Vec<u64>,
    /// Thinnest box around the triangles, computed on first use.
    turned: OnceLock<TurnedBox>,
}

impl InsideTest {
    /// Builds the bounding-box hierarchy in O(n log n).
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
            turned: OnceLock::new(),
        }
    }

    /// Winding number of the surface around a local point.
    ///
    /// Exactly an integer if the surface is closed, else accurate to about 1e-3.
    pub fn winding(&self, point: &Point3<f64>) -> f64 {
        let [winding] = self.windings(&[*point]);
        winding
    }

    /// Winding numbers of several points. Cheaper than single queries if the points lie close together.
    pub(super) fn windings<const N: usize>(&self, points: &[Point3<f64>; N]) -> [f64; N] {
        let windings = self.winding.at(&self.tree, points);
        if self.closed { windings.map(f64::round) } else { windings }
    }

    /// Finest spacing (local) whose grid is small enough: over the box along the axes, or over the thinnest box.
    ///
    /// `grown`: what is added to the sides of both, local.
    pub(crate) fn finest_grid_spacing(&self, grown: f64) -> f64 {
        let finest = |extent: Vector3<f64>| lattice::finest_grid_spacing(&extent.add_scalar(grown));
        finest(self.bounds.diagonal()).min(finest(self.turned().extent()))
    }

    fn turned(&self) -> &TurnedBox {
        self.turned.get_or_init(|| thinnest_box(self.tree.triangles.as_flattened()))
    }

    /// Distance from a local point to the nearest triangle; local.
    pub fn distance(&self, point: &Point3<f64>) -> f64 {
        closest::nearest(&self.tree, point).0.sqrt()
    }

    /// Face of the input file nearest to a local point, counted from 0.
    pub fn nearest_face(&self, point: &Point3<f64>) -> u64 {
        self.faces.get(closest::nearest(&self.tree, point).1 as usize).copied().unwrap_or(0)
    }

    /// Signed distance from a local point to the surface; local, negative where the winding number w exceeds ½.
    ///
    /// For a closed surface its magnitude is [`Self::distance`]. For an open one it is distance · min(1, |1 − 2w|),
    /// which vanishes on the film w = ½ that closes a hole, so the sign never jumps. On the axis of a flat round hole
    /// it equals the distance to the hole's plane. It never exceeds the distance to the surface.
    pub fn signed_distance(&self, point: &Point3<f64>) -> f64 {
        self.distance(point) * (1.0 - 2.0 * self.winding(point)).clamp(-1.0, 1.0)
    }

    /// [`Self::signed_distance`] of many points, on all threads of the current pool.
    pub fn signed_distances(&self, points: &[Point3<f64>]) -> Vec<f64> {
        points.par_iter().with_min_len(64).map(|point| self.signed_distance(point)).collect()
    }

    /// Reports the sample points, if any, whose winding number lies in (0.2, 0.8).
    ///
    /// Holes of the surface leave it undecided whether these points are inside.
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

    fn has_exact_sign(&self) -> bool {
        self.closed
    }

    fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        (self.bounds.low, self.bounds.high)
    }

    fn turned_box(&self) -> Option<TurnedBox> {
        Some(*self.turned())
    }
}

#[cfg(test)]
#[path = "inside_tests.rs"]
mod tests;
