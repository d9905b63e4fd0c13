//! Protected regions on skins: fragments of points inside, and cuts on the boundaries.

use crate::pipeline::prepared::region_boundary::RegionBoundary;
use crate::pipeline::workspace::body_meshes::BodyMeshes;
use crate::tessellation::BisectorSites;
use nalgebra::Point3;
use std::collections::BTreeSet;

/// Protected regions of one body, for its skin.
pub(super) struct SkinRegions<'a> {
    boundary: &'a RegionBoundary,
    /// Fragment of each node of the crack lattice.
    labels: &'a [u32],
    /// Fragments with nodes in each group of regions.
    enclosing: Vec<BTreeSet<u32>>,
}

impl<'a> SkinRegions<'a> {
    pub fn new(boundary: &'a RegionBoundary, pieces: &'a BodyMeshes) -> Self {
        let mut enclosing = vec![BTreeSet::new(); boundary.group_count()];
        for (node, &label) in (0..).zip(&pieces.labels) {
            if let Some(group) = boundary.group(node) {
                enclosing[group].insert(label);
            }
        }
        Self { boundary, labels: &pieces.labels, enclosing }
    }

    /// The fragment that encloses a point inside a region. `nodes`: corners of the point's tetrahedron.
    pub fn fragment(&self, point: &Point3<f64>, nodes: [u32; 4]) -> Option<u32> {
        let inside = nodes
            .into_iter()
            .find(|&node| self.boundary.group(node).is_some_and(|group| self.boundary.level(group, point) <= 0.0))?;
        Some(self.labels[inside as usize])
    }

    /// f_a − f_b of two fragments at a point. `natural`: without regions.
    pub fn rivalry(&self, point: &Point3<f64>, [a, b]: [u32; 2], natural: f64, sites: &BisectorSites<'_>) -> f64 {
        // The slope of f_a − f_b.
        let slope = 2.0 * sites.distance(a, b);
        let limited = |value: f64, (group, fragments): (usize, &BTreeSet<u32>)| {
            let level = || slope * self.boundary.level(group, point);
            match [a, b].map(|own| fragments.contains(&own)) {
                [true, false] => value.min(level()),
                [false, true] => value.max(-level()),
                _ => value,
            }
        };
        self.enclosing.iter().enumerate().fold(natural, limited)
    }
}
