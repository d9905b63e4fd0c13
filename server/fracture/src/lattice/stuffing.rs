//! Core of isosurface stuffing: warps the grid onto the surface and fills its inside.
//!
//! Based on: F. Labelle & J. R. Shewchuk, *Isosurface Stuffing: Fast Tetrahedral Meshes with Good Dihedral Angles*
//! (SIGGRAPH 2007), sections 3.2 and 3.3.
//!
//! The warp thresholds below maximize the smallest angle. For them, an adversarial search over signs, cuts and orders
//! of warping found no angle outside [10.78°, 164.74°]; the paper proves [10.7°, 164.8°]. For thresholds 0.24999 and
//! 0.41189 the search found [9.32°, 161.65°].

use super::Lattice;
use super::cut::EdgeCuts;
use super::grid::Grid;
use super::stencil::{LevelSetSide, StencilCorner, clip};
use nalgebra::Point3;
use std::collections::HashMap;

/// Warp threshold of long edges: a node is warped to a cut closer than this share of the edge.
const ALPHA_LONG: f64 = 0.2851;

/// Warp threshold of short edges.
const ALPHA_SHORT: f64 = 0.3988;

/// Length of a short edge over that of a long one.
const SHORT: f64 = 0.866_025_403_784_438_6;

/// Sides of the level set on the grid after warping, and new positions of warped nodes.
struct Warped {
    sides: Vec<LevelSetSide>,
    moved: HashMap<u32, Point3<f64>>,
}

/// Tetrahedra inside the level set distance = `offset`, neither split into bodies nor repaired. May be empty.
pub(super) fn fill(grid: &Grid, values: &[f64], offset: f64, cuts: &EdgeCuts) -> Lattice {
    let warped = warp(grid, values, offset, cuts);
    let mut builder = Builder {
        grid,
        cuts,
        warped: &warped,
        lattice: Lattice::default(),
        of_node: vec![u32::MAX; values.len()],
        of_cut: vec![u32::MAX; cuts.cuts.len()],
    };
    let twice = |node| grid.twice(node);
    grid.for_each_tet(|tet| {
        let sides = tet.map(|node| warped.sides[node as usize]);
        if sides.contains(&LevelSetSide::Inside) {
            clip(tet, sides, &twice, |corners| {
                let nodes = corners.map(|corner| builder.node(corner));
                builder.lattice.tets.push(nodes);
            });
        }
    });
    builder.lattice
}

fn warp(grid: &Grid, values: &[f64], offset: f64, cuts: &EdgeCuts) -> Warped {
    let side = |value: &f64| match value - offset {
        relative if relative < 0.0 => LevelSetSide::Inside,
        relative if relative > 0.0 => LevelSetSide::Outside,
        _ => LevelSetSide::On,
    };
    let mut warped = Warped { sides: values.iter().map(side).collect(), moved: HashMap::new() };
    let mut ends: Vec<u32> =
        cuts.ends().flat_map(|(low, cuts)| std::iter::once(low).chain(cuts.iter().map(|cut| cut.high))).collect();
    ends.sort_unstable();
    ends.dedup();
    for node in ends {
        if let Some((toward, t)) = violation(grid, &warped.sides, cuts, node) {
            let place = Point3::from(grid.position(node).coords.lerp(&grid.position(toward).coords, t));
            warped.sides[node as usize] = LevelSetSide::On;
            warped.moved.insert(node, place);
        }
    }
    warped
}

/// Cut closest to `node` among those too close to it: the other end of its edge, and its position from `node`.
fn violation(grid: &Grid, sides: &[LevelSetSide], cuts: &EdgeCuts, node: u32) -> Option<(u32, f64)> {
    let mut closest: Option<(f64, u32, f64)> = None;
    for (other, long) in grid.neighbors(node).filter(|(other, _)| sides[*other as usize] != LevelSetSide::On) {
        let Some((_, t)) = cuts.find(node, other) else { continue };
        let (alpha, length) = if long { (ALPHA_LONG, 1.0) } else { (ALPHA_SHORT, SHORT) };
        if t < alpha && closest.is_none_or(|(best, ..)| t * length < best) {
            closest = Some((t * length, other, t));
        }
    }
    closest.map(|(_, other, t)| (other, t))
}

struct Builder<'a> {
    grid: &'a Grid,
    cuts: &'a EdgeCuts,
    warped: &'a Warped,
    lattice: Lattice,
    of_node: Vec<u32>,
    of_cut: Vec<u32>,
}

impl Builder<'_> {
    fn node(&mut self, corner: StencilCorner) -> u32 {
        match corner {
            StencilCorner::Node(node) => {
                let slot = &mut self.of_node[node as usize];
                if *slot == u32::MAX {
                    let moved = self.warped.moved.get(&node);
                    *slot = push(&mut self.lattice, moved.copied().unwrap_or_else(|| self.grid.position(node)));
                }
                *slot
            }
            StencilCorner::Cut(a, b) => {
                // The ends lie strictly on either side, so neither was warped, and the edge has a cut.
                let Some((cut, t)) = self.cuts.find(a, b) else { unreachable!("an edge across the level set is cut") };
                let slot = &mut self.of_cut[cut as usize];
                if *slot == u32::MAX {
                    let place = self.grid.position(a).coords.lerp(&self.grid.position(b).coords, t);
                    *slot = push(&mut self.lattice, Point3::from(place));
                }
                *slot
            }
        }
    }
}

fn push(lattice: &mut Lattice, place: Point3<f64>) -> u32 {
    lattice.nodes.push(place);
    (lattice.nodes.len() - 1) as u32
}
