//! Fit of boundary nodes to ridges and creases, where edges between nodes on the surface deviate from it.
//!
//! Based on: C. L. Lawson, *Contributions to the theory of linear least maximum approximation* (1961), for the move
//! of one node that minimizes its largest error. Related: L. Kobbelt, M. Botsch, U. Schwanecke, H.-P. Seidel,
//! *Feature sensitive surface extraction* (SIGGRAPH 2001), which puts vertices where the tangent planes of samples
//! meet.
//!
//! Errors are distances from the level set of the stuffing, at the samples of [`Lattice::deviation`]. In every round,
//! the nodes that move share no tetrahedron. A node moves only if the largest error around it falls and its tetrahedra
//! keep the angles that stuffing guarantees. So no error exceeds the former largest error around it, and the order of
//! moves does not matter.

use super::adjacency::NodeStars;
use super::crossing_repair::put_back;
use super::grid::finite;
use super::level::{VOLUME_TOLERANCE, stuff};
use super::measure::DihedralRange;
use super::{Lattice, LatticeError, LatticeLevel, SignedDistance};
use crate::cancel_token::CancelToken;
use crate::surface::meet;
use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;
use std::collections::HashMap;

/// Largest error that is accepted, over the spacing. Smooth parts keep their nodes on the surface.
const FAR: f64 = 0.1;

/// Largest number of rounds. All shapes tried needed fewer.
const ROUNDS_MAX: usize = 256;

/// Bounds on dihedral angles after a move, degrees. A tetrahedron already outside them must not move farther out.
const DIHEDRAL_DEG: [f64; 2] = [14.0, 160.0];

/// Largest number of fits of a boundary. After each, moves that make it cross itself are undone and their nodes pinned.
const ATTEMPTS_MAX: usize = 5;

/// Largest number of level sets that are fitted to meet a volume.
const FITS_MAX: usize = 3;

/// Step sizes tried, as shares of the best step of the linear model.
const STEPS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];

/// Step sizes tried in all directions if no step of the linear model helps, over the spacing. Distances are far from
/// linear at ridges.
const SEARCHED: [f64; 4] = [0.2, 0.1, 0.05, 0.025];

/// Largest accepted ratio of the new to the old largest error of a move.
const GAIN: f64 = 0.97;

/// Distance between the points of a difference quotient, over the spacing.
const DIFFERENCE: f64 = 0.01;

/// Iterations of Lawson's algorithm.
const LAWSON: usize = 24;

/// Damping of directions without errors, as a share of the trace of the normal matrix.
const DAMPING: f64 = 1e-3;

/// Sample of the boundary: a node, or the middle of an edge or of a face.
#[derive(Clone, Copy)]
struct Sample {
    nodes: [u32; 3],
    count: usize,
}

impl Sample {
    fn nodes(&self) -> &[u32] {
        &self.nodes[..self.count]
    }

    /// Position of the sample. `moved` gives one node a different position.
    fn position(&self, nodes: &[Point3<f64>], moved: Option<(u32, Point3<f64>)>) -> Point3<f64> {
        let at =
            |node: u32| moved.filter(|(own, _)| *own == node).map_or(nodes[node as usize], |(_, place)| place).coords;
        Point3::from(self.nodes().iter().map(|&node| at(node)).sum::<Vector3<f64>>() / self.count as f64)
    }
}

/// As [`stuff`] to a volume (local, positive), with the boundary fitted to ridges and creases.
///
/// Selects the level set whose lattice has the volume after the fit.
///
/// # Errors
/// Those of [`stuff`].
pub(super) fn stuff_fitted(
    shape: &dyn SignedDistance,
    spacing: f64,
    volume: f64,
    token: &CancelToken,
) -> Result<LatticeLevel, LatticeError> {
    let (mut best, mut aim) = (None::<LatticeLevel>, volume);
    for fitted in 0..FITS_MAX {
        let mut level = stuff(shape, spacing, Some(aim), token)?;
        let reached = (level.volume() - aim).abs() <= VOLUME_TOLERANCE * aim;
        fit(&mut level, shape, token)?;
        let missing = volume - level.volume();
        aim += missing;
        if best.as_ref().is_none_or(|best| missing.abs() < (volume - best.volume()).abs()) {
            best = Some(level);
        }
        // A level set that missed its volume is fitted once more: a turned tube had 5 % too much after the first fit.
        if missing.abs() <= VOLUME_TOLERANCE * volume || (!reached && fitted > 0) || aim <= 0.0 {
            break;
        }
    }
    best.ok_or(LatticeError::NothingInside { spacing })
}

/// Moves boundary nodes of all bodies to reduce the largest distance from their level set.
///
/// Nodes whose moves would make boundaries cross stay. All invariants of [`Lattice`] and all bounds of [`stuff`] except
/// that of the volume hold.
///
/// # Errors
/// Canceled; a distance that is not finite.
fn fit(level: &mut LatticeLevel, shape: &dyn SignedDistance, token: &CancelToken) -> Result<(), LatticeError> {
    let mut joined = Lattice::default();
    for body in &level.bodies {
        let first = joined.nodes.len() as u32;
        joined.nodes.extend(&body.nodes);
        joined.tets.extend(body.tets.iter().map(|tet| tet.map(|node| node + first)));
    }
    let stuffed = joined.nodes.clone();
    let mut pinned = vec![false; stuffed.len()];
    for _ in 0..ATTEMPTS_MAX {
        let mut fitter = Fitter::new(joined, shape, level.spacing, level.offset, pinned)?;
        fitter.run(token)?;
        (joined, pinned) = (fitter.lattice, fitter.pinned);
        let met = put_back(&mut joined, &stuffed);
        if met.is_empty() {
            break;
        }
        met.into_iter().for_each(|node| pinned[node as usize] = true);
    }
    let mut nodes = joined.nodes.into_iter();
    for body in &mut level.bodies {
        body.nodes.iter_mut().zip(&mut nodes).for_each(|(own, place)| *own = place);
    }
    Ok(())
}

struct Fitter<'a> {
    shape: &'a dyn SignedDistance,
    spacing: f64,
    offset: f64,
    lattice: Lattice,
    stars: NodeStars,
    samples: Vec<Sample>,
    /// Error of each sample: its signed distance from the level set.
    values: Vec<f64>,
    /// Samples of each node; empty for interior nodes.
    of_node: Vec<Vec<u32>>,
    /// Faces of the boundary.
    faces: Vec<[u32; 3]>,
    /// Faces of each node.
    faces_of: Vec<Vec<u32>>,
    /// Nodes without a useful move, until something around them moves.
    resting: Vec<bool>,
    /// Nodes that must not move.
    pinned: Vec<bool>,
}

/// New position of a node, and the errors of its samples there.
type Move = (Point3<f64>, Vec<f64>);

impl<'a> Fitter<'a> {
    fn new(
        lattice: Lattice,
        shape: &'a dyn SignedDistance,
        spacing: f64,
        offset: f64,
        pinned: Vec<bool>,
    ) -> Result<Self, LatticeError> {
        let faces: Vec<[u32; 3]> = lattice.boundary().iter().map(|face| face.nodes).collect();
        let samples = samples(&faces);
        let mut faces_of = vec![Vec::new(); lattice.nodes.len()];
        for (index, face) in faces.iter().enumerate() {
            face.iter().for_each(|&node| faces_of[node as usize].push(index as u32));
        }
        let mut of_node = vec![Vec::new(); lattice.nodes.len()];
        for (index, sample) in samples.iter().enumerate() {
            sample.nodes().iter().for_each(|&node| of_node[node as usize].push(index as u32));
        }
        let value = |sample: &Sample| Ok(finite(shape, &sample.position(&lattice.nodes, None))? - offset);
        let values: Vec<Result<f64, LatticeError>> = samples.par_iter().with_min_len(64).map(value).collect();
        let values = values.into_iter().collect::<Result<Vec<f64>, _>>()?;
        let (stars, resting) = (lattice.stars(), pinned.clone());
        Ok(Self { shape, spacing, offset, lattice, stars, samples, values, of_node, faces, faces_of, resting, pinned })
    }

    fn run(&mut self, token: &CancelToken) -> Result<(), LatticeError> {
        for _ in 0..ROUNDS_MAX {
            token.check()?;
            let chosen = self.chosen();
            if chosen.is_empty() {
                break;
            }
            let moves: Vec<Option<Move>> = chosen.par_iter().map(|&(node, worst)| self.best(node, worst)).collect();
            for (&(node, _), found) in chosen.iter().zip(moves) {
                match found {
                    Some(found) => self.take(node, found),
                    None => self.resting[node as usize] = true,
                }
            }
        }
        Ok(())
    }

    /// Nodes with larger errors than all nodes around them (the lowest one at a tie), and their
    /// errors. No two share a tetrahedron.
    fn chosen(&self) -> Vec<(u32, f64)> {
        let worst: HashMap<u32, f64> = (0..self.lattice.nodes.len() as u32)
            .filter(|&node| !self.resting[node as usize])
            .map(|node| (node, self.worst(node)))
            .filter(|(_, worst)| *worst > FAR * self.spacing)
            .collect();
        let leads = |node: u32, own: f64| {
            let around = self.stars.of(node).iter().flat_map(|&tet| self.lattice.tets[tet as usize]);
            around.filter(|&other| other != node).all(|other| match worst.get(&other) {
                Some(&other_worst) => own > other_worst || own == other_worst && node < other,
                None => true,
            })
        };
        let mut chosen: Vec<(u32, f64)> =
            worst.iter().filter(|(node, own)| leads(**node, **own)).map(|(node, own)| (*node, *own)).collect();
        chosen.sort_unstable_by_key(|(node, _)| *node);
        chosen
    }

    /// Largest error of a node's samples; 0 for interior nodes.
    fn worst(&self, node: u32) -> f64 {
        largest(self.of_node[node as usize].iter().map(|&sample| self.values[sample as usize]))
    }

    fn take(&mut self, node: u32, (place, values): Move) {
        self.lattice.nodes[node as usize] = place;
        for (&sample, value) in self.of_node[node as usize].iter().zip(values) {
            self.values[sample as usize] = value;
        }
        for &tet in self.stars.of(node) {
            for &other in &self.lattice.tets[tet as usize] {
                self.resting[other as usize] = self.pinned[other as usize];
            }
        }
    }

    /// Best move of a node, if any reduces its error: along the step of the linear model, or else in any direction.
    fn best(&self, node: u32, worst: f64) -> Option<Move> {
        let step = self.step(node);
        self.best_of(node, worst, STEPS.map(|share| step * share)).or_else(|| {
            let around = (0..27).map(|k| Vector3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1).map(f64::from));
            let around: Vec<Vector3<f64>> = around.filter_map(|way| way.try_normalize(0.0)).collect();
            let sizes = SEARCHED.into_iter().flat_map(|size| around.iter().map(move |way| way * (size * self.spacing)));
            self.best_of(node, worst, sizes)
        })
    }

    fn best_of(&self, node: u32, worst: f64, steps: impl IntoIterator<Item = Vector3<f64>>) -> Option<Move> {
        let from = self.lattice.nodes[node as usize];
        let error = |sample: &u32| self.values[*sample as usize].abs();
        let first = *self.of_node[node as usize].iter().max_by(|a, b| error(a).total_cmp(&error(b)))?;
        let mut best: Option<(f64, Move)> = None;
        for step in steps {
            let place = from + step;
            if !self.holds(node, place) {
                continue;
            }
            let limit = best.as_ref().map_or(GAIN * worst, |(least, _)| *least);
            // A distance that is not a number is no gain.
            let value = |sample: &u32| {
                let moved = self.samples[*sample as usize].position(&self.lattice.nodes, Some((node, place)));
                Some(self.shape.signed_distance(&moved) - self.offset).filter(|value| value.abs() < limit)
            };
            // Most places fail at the sample that is the worst now.
            let values: Option<Vec<f64>> =
                value(&first).and_then(|_| self.of_node[node as usize].iter().map(value).collect());
            if let Some(values) = values.filter(|_| !self.crosses(node, place)) {
                best = Some((largest(values.iter().copied()), (place, values)));
            }
        }
        best.map(|(_, found)| found)
    }

    /// Returns true if all tetrahedra of `node` keep their angle bounds with the node at `place`.
    fn holds(&self, node: u32, place: Point3<f64>) -> bool {
        self.stars.of(node).iter().all(|&tet| {
            let nodes = self.lattice.tets[tet as usize];
            let corners = nodes.map(|own| self.lattice.nodes[own as usize]);
            let moved = nodes.map(|own| if own == node { place } else { self.lattice.nodes[own as usize] });
            DihedralRange::of(&moved).is_some_and(|angles| angles.within(DIHEDRAL_DEG, DihedralRange::of(&corners)))
        })
    }

    /// Returns true if faces of `node`, moved to `place`, meet others nearby. Distant ones are checked after the fit.
    fn crosses(&self, node: u32, place: Point3<f64>) -> bool {
        let around = self.stars.of(node).iter().flat_map(|&tet| self.lattice.tets[tet as usize]);
        let mut near: Vec<u32> = around.flat_map(|other| &self.faces_of[other as usize]).copied().collect();
        near.sort_unstable();
        near.dedup();
        let at = |own: u32| if own == node { place } else { self.lattice.nodes[own as usize] };
        let whole = |face: u32| (self.faces[face as usize], self.faces[face as usize].map(at));
        let own = &self.faces_of[node as usize];
        own.iter().any(|&face| near.iter().any(|&other| meet(whole(face), whole(other))))
    }

    /// Step that minimizes the largest error of a node's samples under a linear model of the distance.
    fn step(&self, node: u32) -> Vector3<f64> {
        let rows: Vec<(Vector3<f64>, f64)> = self.of_node[node as usize]
            .iter()
            .map(|&sample| {
                let (own, value) = (&self.samples[sample as usize], self.values[sample as usize]);
                (self.gradient(&own.position(&self.lattice.nodes, None)) / own.count as f64, value)
            })
            .collect();
        minimax(&rows)
    }

    fn gradient(&self, place: &Point3<f64>) -> Vector3<f64> {
        let half = 0.5 * DIFFERENCE * self.spacing;
        let along = |axis: usize| {
            let offset = Vector3::ith(axis, half);
            (self.shape.signed_distance(&(place + offset)) - self.shape.signed_distance(&(place - offset)))
                / (2.0 * half)
        };
        Vector3::new(along(0), along(1), along(2))
    }
}

/// Minimizer x of the largest |value + gradient·x|, damped toward 0 where it is not unique.
fn minimax(rows: &[(Vector3<f64>, f64)]) -> Vector3<f64> {
    let (mut weights, mut step) = (vec![1.0 / rows.len() as f64; rows.len()], Vector3::zeros());
    for _ in 0..LAWSON {
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for ((gradient, value), weight) in rows.iter().zip(&weights) {
            normal += gradient * gradient.transpose() * *weight;
            right -= gradient * (value * weight);
        }
        normal += Matrix3::identity() * (DAMPING * normal.trace());
        let Some(found) = normal.cholesky().map(|factor| factor.solve(&right)) else { return step };
        step = found;
        let mut sum = 0.0;
        for ((gradient, value), weight) in rows.iter().zip(&mut weights) {
            *weight *= (value + gradient.dot(&step)).abs();
            sum += *weight;
        }
        if sum <= 0.0 {
            break;
        }
        weights.iter_mut().for_each(|weight| *weight /= sum);
    }
    step
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    // A distance that is not a number is treated as an infinite error.
    values.map(f64::abs).fold(0.0, |most, value| if value.is_finite() { most.max(value) } else { f64::INFINITY })
}

/// Boundary nodes, edge midpoints and face centroids, each once.
fn samples(boundary: &[[u32; 3]]) -> Vec<Sample> {
    let mut samples = Vec::new();
    let mut rim: Vec<u32> = boundary.iter().flatten().copied().collect();
    rim.sort_unstable();
    rim.dedup();
    samples.extend(rim.into_iter().map(|node| Sample { nodes: [node; 3], count: 1 }));
    for &[a, b, c] in boundary {
        // On a closed boundary every edge runs from its lower to its higher node in exactly one of its two faces.
        let edges = [[a, b], [b, c], [c, a]].into_iter().filter(|[from, to]| from < to);
        samples.extend(edges.map(|[from, to]| Sample { nodes: [from, to, to], count: 2 }));
        samples.push(Sample { nodes: [a, b, c], count: 3 });
    }
    samples
}

#[cfg(test)]
#[path = "boundary_fit_tests.rs"]
mod tests;
