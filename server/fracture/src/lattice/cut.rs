//! Cut points: intersections of the surface with grid edges.
//!
//! Based on: the cut points of Labelle & Shewchuk (2007), section 3.1. They are found on the signed distance itself,
//! not on its linear interpolant, by regula falsi with bisection. A jump of the sign counts as a root.

use super::grid::{Grid, finite};
use super::{LatticeError, SignedDistance};
use crate::cancel_token::CancelToken;
use nalgebra::Point3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Distance, over the spacing, at which the search stops. One more interpolation makes the
/// cut exact to about its square.
const CLOSE: f64 = 0.01;

/// Largest number of samples per edge and offset. The bracket is then narrower than a thousandth of the edge.
const STEPS_MAX: usize = 12;

/// Narrowest bracket, as a share of the edge.
const NARROW: f64 = 1e-3;

/// Secant steps before bisection.
const SECANTS: usize = 4;

/// Intersection of the surface with a grid edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeCut {
    /// Higher-numbered end of the edge.
    pub(super) high: u32,
    /// Position along the edge from the lower-numbered end, 0 … 1.
    pub(super) t: f64,
}

/// All cuts of one level set, ordered by the (lower, higher) ends of their edges.
pub(super) struct EdgeCuts {
    /// Index of the first cut whose lower end is each grid node; length nodes + 1.
    first: Vec<u32>,
    /// Cuts of the level set.
    pub(super) cuts: Vec<EdgeCut>,
}

impl EdgeCuts {
    /// Cut on the edge between `a` and `b`: its index, and its position from `a`, 0 … 1.
    pub(super) fn find(&self, a: u32, b: u32) -> Option<(u32, f64)> {
        let (low, high) = (a.min(b), a.max(b));
        let (start, end) = (self.first[low as usize], self.first[low as usize + 1]);
        let index = (start..end).find(|&cut| self.cuts[cut as usize].high == high)?;
        let t = self.cuts[index as usize].t;
        Some((index, if a == low { t } else { 1.0 - t }))
    }

    /// Lower-numbered ends that have cuts, each with its cuts.
    pub(super) fn ends(&self) -> impl Iterator<Item = (u32, &[EdgeCut])> {
        self.first.windows(2).enumerate().filter(|(_, range)| range[0] < range[1]).map(|(low, range)| {
            let cuts = &self.cuts[range[0] as usize..range[1] as usize];
            (low as u32, cuts)
        })
    }
}

/// Signed distances sampled along an edge, ordered by position: (position from the lower end, signed distance).
type Samples = Vec<(f64, f64)>;

/// Finder of cuts for one level set after another. It keeps earlier samples.
pub(super) struct Cutter<'a> {
    shape: &'a dyn SignedDistance,
    grid: &'a Grid,
    values: &'a [f64],
    samples: HashMap<[u32; 2], Samples>,
}

impl<'a> Cutter<'a> {
    /// Creates a finder. `values` are the signed distances on the nodes of `grid`.
    pub(super) fn new(shape: &'a dyn SignedDistance, grid: &'a Grid, values: &'a [f64]) -> Self {
        Self { shape, grid, values, samples: HashMap::new() }
    }

    /// Cuts of the level set distance = `offset`.
    pub(super) fn cut(&mut self, offset: f64, token: &CancelToken) -> Result<EdgeCuts, LatticeError> {
        let (first, edges) = self.crossing(offset, token)?;
        let mut work: Vec<([u32; 2], Samples)> = edges
            .into_iter()
            .map(|edge| {
                let ends = || vec![(0.0, self.values[edge[0] as usize]), (1.0, self.values[edge[1] as usize])];
                (edge, self.samples.remove(&edge).unwrap_or_else(ends))
            })
            .collect();
        let roots: Vec<Result<f64, LatticeError>> = work
            .par_iter_mut()
            .enumerate()
            .map(|(index, (edge, samples))| {
                if index % 4096 == 0 {
                    token.check()?;
                }
                self.root(*edge, samples, offset)
            })
            .collect();
        let mut cuts = Vec::with_capacity(work.len());
        for ((edge, samples), root) in work.into_iter().zip(roots) {
            cuts.push(EdgeCut { high: edge[1], t: root? });
            self.samples.insert(edge, samples);
        }
        Ok(EdgeCuts { first, cuts })
    }

    /// Edges with one end strictly on either side, ordered; and for each node the index of the first edge of which it
    /// is the lower end.
    fn crossing(&self, offset: f64, token: &CancelToken) -> Result<(Vec<u32>, Vec<[u32; 2]>), LatticeError> {
        let (mut first, mut edges) = (Vec::with_capacity(self.values.len() + 1), Vec::new());
        for node in 0..self.values.len() as u32 {
            if node % 4096 == 0 {
                token.check()?;
            }
            let start = edges.len();
            first.push(start as u32);
            let own = self.values[node as usize] - offset;
            // No node is skipped for its distance from the surface, because the sign may
            // jump where the surface has holes.
            for (other, _) in self.grid.neighbors(node).filter(|(other, _)| *other > node) {
                if own * (self.values[other as usize] - offset) < 0.0 {
                    edges.push([node, other]);
                }
            }
            edges[start..].sort_unstable();
        }
        first.push(edges.len() as u32);
        Ok((first, edges))
    }

    fn root(&self, edge: [u32; 2], samples: &mut Samples, offset: f64) -> Result<f64, LatticeError> {
        let [low, high] = edge.map(|node| self.grid.position(node));
        for step in 0..STEPS_MAX {
            let (at, (t0, f0), (t1, f1)) = bracket(samples, offset);
            let secant = t0 + (t1 - t0) * (f0 / (f0 - f1));
            if t1 - t0 < NARROW || f0.abs().min(f1.abs()) < CLOSE * self.grid.spacing && t1 - t0 < 1.0 {
                return Ok(secant);
            }
            let t = if step < SECANTS { secant.clamp(t0 + NARROW / 4.0, t1 - NARROW / 4.0) } else { 0.5 * (t0 + t1) };
            let place = Point3::from(low.coords.lerp(&high.coords, t));
            samples.insert(at, (t, finite(self.shape, &place)?));
        }
        let (_, (t0, _), (t1, _)) = bracket(samples, offset);
        Ok(0.5 * (t0 + t1))
    }
}

/// First pair of adjacent samples on either side of `offset`: the index of the second, and
/// both samples less the offset.
fn bracket(samples: &Samples, offset: f64) -> (usize, (f64, f64), (f64, f64)) {
    let side = samples[0].1 - offset;
    let at = samples.iter().position(|s| (s.1 - offset) * side <= 0.0).unwrap_or(samples.len() - 1).max(1);
    let relative = |(t, value): (f64, f64)| (t, value - offset);
    (at, relative(samples[at - 1]), relative(samples[at]))
}
