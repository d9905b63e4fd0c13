//! Body-centered cubic grid around a shape, with the signed distance on its nodes.
//!
//! Based on: F. Labelle & J. R. Shewchuk, *Isosurface Stuffing: Fast Tetrahedral Meshes with Good Dihedral Angles*
//! (SIGGRAPH 2007), section 3, with one spacing everywhere.
//!
//! Nodes are the corners and the centers of cubes of side `spacing`. Twice a node's cube coordinates are integers: all
//! even for a corner, all odd for a center. Corners are numbered first, with x varying fastest.
//!
//! The cubes lie along the axes, or along a box of the shape in other directions ([`SignedDistance::turned_box`]) where the
//! grid along the axes would be too large: that over a turned plate has many times the nodes near it.

use super::{LatticeError, SignedDistance};
use crate::cancel_token::CancelToken;
use nalgebra::{Point3, Rotation3, Vector3};
use rayon::prelude::*;

/// Range of spacings that [`super::stuff`] accepts: lowest and highest; local.
pub const SPACING_RANGE: [f64; 2] = [0.002, 0.25];

/// Largest number of grid nodes over the bounding box of a shape (16 MB of distances). Checked before any allocation.
pub const GRID_NODES_MAX: usize = 2_000_000;

/// Cubes along the side of a block, the unit of sampling and skipping.
const BLOCK: usize = 4;

/// Cubes between the shape's box and the rim of the grid: half a spacing of offset, one spacing of edge, and rounding.
const PADDING: f64 = 1.75;

/// Corner offsets of the face between a cube and the next along +x, from the cube's center, in doubled coordinates.
const RING: [[i32; 3]; 4] = [[1, -1, -1], [1, 1, -1], [1, 1, 1], [1, -1, 1]];

/// Layout of the grid; see the head of this file.
pub(super) struct Grid {
    origin: Point3<f64>,
    /// Side of the cubes, local.
    pub(super) spacing: f64,
    cells: [usize; 3],
    /// Rotation of the cubes; `None`: they lie along the axes. The origin is in coordinates of the cubes.
    turn: Option<Rotation3<f64>>,
}

/// Number of cubes along each axis over a box of this extent.
fn counts(extent: &Vector3<f64>, spacing: f64) -> Vector3<f64> {
    extent.map(|e| (e / spacing + 2.0 * PADDING).ceil())
}

/// Number of grid nodes over a box of this extent.
pub(super) fn node_estimate(extent: &Vector3<f64>, spacing: f64) -> f64 {
    let counts = counts(extent, spacing);
    counts.map(|c| c + 1.0).product() + counts.product()
}

/// True if the grid over a box of this extent is small enough.
pub(super) fn is_allowed(extent: &Vector3<f64>, spacing: f64) -> bool {
    node_estimate(extent, spacing) <= GRID_NODES_MAX as f64
}

impl Grid {
    /// Smallest grid centered on the shape's box whose outermost nodes lie outside for any offset up to half a spacing.
    ///
    /// The box is the shape's turned one if only the grid over that one is small enough.
    pub(super) fn over(shape: &dyn SignedDistance, spacing: f64) -> Result<Self, LatticeError> {
        let [spacing_min, spacing_max] = SPACING_RANGE;
        if !(spacing_min..=spacing_max).contains(&spacing) {
            return Err(LatticeError::SpacingOutOfRange { level: "lattice", spacing, spacing_min, spacing_max });
        }
        let (mut low, high) = shape.bounds();
        let mut extent = high - low;
        if !(extent.iter().all(|e| e.is_finite() && *e >= 0.0) && low.iter().all(|c| c.is_finite())) {
            return Err(LatticeError::BoundsNotFinite);
        }
        let (estimate, mut turn) = (node_estimate(&extent, spacing), None);
        if !is_allowed(&extent, spacing) {
            let nodes_max = GRID_NODES_MAX;
            let turned = shape.turned_box().filter(|turned| is_allowed(&turned.extent(), spacing));
            let turned = turned.ok_or(LatticeError::GridTooLarge { nodes: estimate, nodes_max, spacing })?;
            (low, extent, turn) = (turned.low, turned.extent(), Some(turned.turn));
        }
        let counts = counts(&extent, spacing);
        let cells = [counts.x as usize, counts.y as usize, counts.z as usize];
        let origin = low + extent / 2.0 - counts * (spacing / 2.0);
        Ok(Self { origin, spacing, cells, turn })
    }

    fn corner_count(&self) -> usize {
        self.cells.iter().map(|c| c + 1).product()
    }

    /// Number of grid nodes: corners and centers.
    pub(super) fn node_count(&self) -> usize {
        self.corner_count() + self.cells.iter().product::<usize>()
    }

    /// Twice the cube coordinates of `node`.
    pub(super) fn twice(&self, node: u32) -> [i32; 3] {
        let (corners, node) = (self.corner_count(), node as usize);
        let (index, sides, odd) =
            if node < corners { (node, self.cells.map(|c| c + 1), 0) } else { (node - corners, self.cells, 1) };
        let place = [index % sides[0], index / sides[0] % sides[1], index / (sides[0] * sides[1])];
        place.map(|c| (2 * c + odd) as i32)
    }

    /// Node at twice its cube coordinates, which are all even or all odd. `None` outside the grid.
    pub(super) fn node(&self, twice: [i32; 3]) -> Option<u32> {
        if (0..3).any(|k| twice[k] < 0 || twice[k] > 2 * self.cells[k] as i32) {
            return None;
        }
        let odd = twice[0] & 1 == 1;
        let [x, y, z] = twice.map(|t| (t / 2) as usize);
        let [nx, ny, _] = if odd { self.cells } else { self.cells.map(|c| c + 1) };
        Some((x + nx * (y + ny * z) + if odd { self.corner_count() } else { 0 }) as u32)
    }

    fn place_at(&self, twice: [i32; 3]) -> Point3<f64> {
        let place = self.origin + Vector3::from(twice.map(f64::from)) * (self.spacing / 2.0);
        self.turn.map_or(place, |turn| turn * place)
    }

    /// Position of `node`, local.
    pub(super) fn position(&self, node: u32) -> Point3<f64> {
        self.place_at(self.twice(node))
    }

    /// Neighbors of `node`, up to 14, each with whether its edge is long (corner to corner, or center to center).
    pub(super) fn neighbors(&self, node: u32) -> impl Iterator<Item = (u32, bool)> + '_ {
        const STEPS: [[i32; 3]; 14] = [
            [-2, 0, 0],
            [2, 0, 0],
            [0, -2, 0],
            [0, 2, 0],
            [0, 0, -2],
            [0, 0, 2],
            [-1, -1, -1],
            [1, -1, -1],
            [-1, 1, -1],
            [1, 1, -1],
            [-1, -1, 1],
            [1, -1, 1],
            [-1, 1, 1],
            [1, 1, 1],
        ];
        let from = self.twice(node);
        STEPS.into_iter().enumerate().filter_map(move |(index, step)| {
            let to = [from[0] + step[0], from[1] + step[1], from[2] + step[2]];
            self.node(to).map(|node| (node, index < 6))
        })
    }

    /// Calls `visit` with every grid tetrahedron, positively oriented: center, next center, two corners between them.
    pub(super) fn for_each_tet(&self, mut visit: impl FnMut([u32; 4])) {
        for center in self.corner_count()..self.node_count() {
            let from = self.twice(center as u32);
            for axis in 0..3 {
                let shifted = |step: [i32; 3]| {
                    let mut to = from;
                    (0..3).for_each(|k| to[(axis + k) % 3] += step[k]);
                    self.node(to)
                };
                let Some(next) = shifted([2, 0, 0]) else { continue };
                let ring = RING.map(&shifted);
                for k in 0..4 {
                    if let (Some(a), Some(b)) = (ring[k], ring[(k + 1) % 4]) {
                        visit([center as u32, next, a, b]);
                    }
                }
            }
        }
    }

    /// Signed distance on every node, length [`Self::node_count`].
    ///
    /// Blocks of cubes farther from the surface than their own radius are filled with a bound of the same sign. Holes
    /// in a surface let the sign jump, so a block is skipped only if the signs of its corners agree too. Where it cannot jump
    /// ([`SignedDistance::has_exact_sign`]), single nodes far from the surface take such a bound from a sampled node near them.
    pub(super) fn sample(&self, shape: &dyn SignedDistance, token: &CancelToken) -> Result<Vec<f64>, LatticeError> {
        let blocks = self.cells.map(|c| c / BLOCK + 1);
        let sampled: Vec<Result<Vec<f64>, LatticeError>> = (0..blocks.iter().product::<usize>())
            .into_par_iter()
            .map(|block| self.sample_block(shape, self.block_start(block, blocks), token))
            .collect();
        let mut values = vec![0.0; self.node_count()];
        for (block, sampled) in sampled.into_iter().enumerate() {
            let mut sampled = sampled?.into_iter();
            self.for_each_in_block(self.block_start(block, blocks), |node, _| {
                if let Some(value) = sampled.next() {
                    values[node as usize] = value;
                }
            });
        }
        Ok(values)
    }

    fn block_start(&self, block: usize, blocks: [usize; 3]) -> [usize; 3] {
        [block % blocks[0], block / blocks[0] % blocks[1], block / (blocks[0] * blocks[1])].map(|b| b * BLOCK)
    }

    fn for_each_in_block(&self, start: [usize; 3], mut visit: impl FnMut(u32, [i32; 3])) {
        let range = |k: usize| start[k]..(start[k] + BLOCK).min(self.cells[k] + 1);
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    let twice = [x, y, z].map(|c| 2 * c as i32);
                    for twice in [twice, twice.map(|t| t + 1)] {
                        if let Some(node) = self.node(twice) {
                            visit(node, twice);
                        }
                    }
                }
            }
        }
    }

    fn sample_block(
        &self,
        shape: &dyn SignedDistance,
        start: [usize; 3],
        token: &CancelToken,
    ) -> Result<Vec<f64>, LatticeError> {
        token.check()?;
        let bound = self.block_bound(shape, start)?;
        let (mut values, mut broken) = (Vec::with_capacity(2 * BLOCK.pow(3)), None);
        let mut sampled: Vec<(Point3<f64>, f64)> = Vec::new();
        self.for_each_in_block(start, |_, twice| {
            let value = bound.unwrap_or_else(|| {
                let place = self.place_at(twice);
                if let Some(bound) = self.bound_near(&sampled, &place) {
                    return bound;
                }
                let value = shape.signed_distance(&place);
                if !value.is_finite() && broken.is_none() {
                    broken = Some(place);
                }
                if shape.has_exact_sign() && value.abs() > self.far() {
                    sampled.push((place, value));
                }
                value
            });
            values.push(value);
        });
        broken.map_or(Ok(values), |place| Err(LatticeError::DistanceNotFinite { place }))
    }

    /// Smallest distance from the surface at which a bound may replace a distance: an offset of half a spacing, and the
    /// length of an edge.
    fn far(&self) -> f64 {
        1.5 * self.spacing
    }

    /// Bound of the right sign for `place` by the distances at sampled places of the same block. `None` if none is large enough.
    fn bound_near(&self, sampled: &[(Point3<f64>, f64)], place: &Point3<f64>) -> Option<f64> {
        sampled.iter().rev().find_map(|(other, value)| {
            let bound = value.abs() - (other - place).norm();
            (bound > self.far()).then_some(bound.copysign(*value))
        })
    }

    /// Bound of the right sign for a whole block far from the surface. `None` if the block must be sampled.
    fn block_bound(&self, shape: &dyn SignedDistance, start: [usize; 3]) -> Result<Option<f64>, LatticeError> {
        let low = start.map(|s| 2 * s as i32);
        let center = self.place_at(low.map(|t| t + BLOCK as i32));
        let middle = finite(shape, &center)?;
        let radius = BLOCK as f64 * self.spacing * 3f64.sqrt() / 2.0;
        if middle.abs() <= radius + self.far() {
            return Ok(None);
        }
        let corners = if shape.has_exact_sign() { 0 } else { 8 };
        for corner in 0..corners {
            let twice = [0, 1, 2].map(|k| low[k] + if corner >> k & 1 == 1 { 2 * BLOCK as i32 } else { 0 });
            if finite(shape, &self.place_at(twice))?.signum() != middle.signum() {
                return Ok(None);
            }
        }
        Ok(Some((middle.abs() - radius).copysign(middle)))
    }
}

/// Signed distance at `place`, or an error if it is not finite.
pub(super) fn finite(shape: &dyn SignedDistance, place: &Point3<f64>) -> Result<f64, LatticeError> {
    let value = shape.signed_distance(place);
    if value.is_finite() { Ok(value) } else { Err(LatticeError::DistanceNotFinite { place: *place }) }
}

#[cfg(test)]
#[path = "grid_tests.rs"]
mod tests;
