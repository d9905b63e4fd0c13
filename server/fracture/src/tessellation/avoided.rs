//! Places on edges that crack points avoid, because another point of an almost flat tetrahedron lies there.
//!
//! Two opposite edges of such a tetrahedron can cross. Where both are cut, their crack points could have one position in
//! single precision, and the fragments would not be closed there. The same holds for the barycenters at which the crack
//! points of its faces and its own lie.

use super::barycentric::EDGE_DISTANCE;
use super::topology::Topology;
use crate::lattice::{EDGES, FACES, Lattice};
use nalgebra::{Point3, Vector3};

/// Largest half width of an interval, over the length of its edge.
const HALF_WIDTH_MAX: f64 = 0.1;

/// Edges that a tetrahedron's edge does not touch, by position in [`EDGES`].
const OPPOSITE: [usize; 6] = [5, 4, 3, 2, 1, 0];

/// A part of an edge without crack points, by the second barycentric coordinate on the edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AvoidedInterval {
    /// Edge of the topology.
    pub edge: u32,
    /// Lower end.
    pub from: f64,
    /// Upper end.
    pub to: f64,
}

impl AvoidedInterval {
    /// The end of the interval nearest to `t`, of those at least `margin` inside the edge. `None` if `t` is outside the
    /// interval, or there is no such end.
    pub fn end_near(&self, t: f64, margin: f64) -> Option<f64> {
        let is_inside = |end: &f64| (margin..=1.0 - margin).contains(end);
        let ends = [self.from, self.to].into_iter().filter(is_inside);
        ends.min_by(|a, b| (a - t).abs().total_cmp(&(b - t).abs())).filter(|_| t > self.from && t < self.to)
    }
}

/// Intervals to avoid because of the almost flat tetrahedra `flat`, ascending and disjoint.
pub(super) fn avoided(lattice: &Lattice, topology: &Topology, flat: &[usize]) -> Vec<AvoidedInterval> {
    let mut all = Vec::new();
    for &tet in flat {
        avoid_in_tet(lattice, topology, tet, &mut all);
    }
    all.sort_unstable_by(|a, b| (a.edge.cmp(&b.edge)).then(a.from.total_cmp(&b.from)));
    all.dedup_by(|next, kept| {
        let meets = next.edge == kept.edge && next.from <= kept.to;
        if meets {
            kept.to = kept.to.max(next.to);
        }
        meets
    });
    all
}

/// Adds the intervals of one tetrahedron.
fn avoid_in_tet(lattice: &Lattice, topology: &Topology, tet: usize, all: &mut Vec<AvoidedInterval>) {
    let corners = lattice.corners(tet);
    let mean =
        |of: &[usize]| Point3::from(of.iter().map(|&k| corners[k].coords).sum::<Vector3<f64>>() / of.len() as f64);
    let edges = topology.tet_edges[tet];
    let ends = edges.map(|edge| topology.edges[edge as usize].map(|node| lattice.nodes[node as usize]));
    for edge in 0..6 {
        let [from, to] = ends[edge];
        let length = (to - from).norm();
        let mut avoid = |t: f64, half_width: f64| {
            let half_width = (half_width / length).min(HALF_WIDTH_MAX);
            if t > -half_width && t < 1.0 + half_width {
                all.push(AvoidedInterval { edge: edges[edge], from: t - half_width, to: t + half_width });
            }
        };
        if let Some((t, sine)) = crossing(ends[edge], ends[OPPOSITE[edge]]) {
            avoid(t, EDGE_DISTANCE / sine);
        }
        let [i, j] = EDGES[edge];
        let apart = FACES.iter().filter(|face| !(face.contains(&i) && face.contains(&j)));
        for point in apart.map(|face| mean(face)).chain([mean(&[0, 1, 2, 3])]) {
            let t = (point - from).dot(&(to - from)) / (length * length);
            if (from + (to - from) * t - point).norm() < EDGE_DISTANCE {
                avoid(t, 2.0 * EDGE_DISTANCE);
            }
        }
    }
}

/// Coordinate on the first segment at which the second passes nearer than [`EDGE_DISTANCE`], and the sine of the angle
/// between them.
fn crossing([a, b]: [Point3<f64>; 2], [c, d]: [Point3<f64>; 2]) -> Option<(f64, f64)> {
    let (u, v) = (b - a, d - c);
    let normal = u.cross(&v);
    let area = normal.norm();
    let sine = area / (u.norm() * v.norm());
    let distance = ((c - a).dot(&normal) / area).abs();
    let [t, s] = [(c - a).cross(&v), (c - a).cross(&u)].map(|own| own.dot(&normal) / (area * area));
    let is_inside = |t: f64| (0.0..=1.0).contains(&t);
    (distance < EDGE_DISTANCE && is_inside(t) && is_inside(s)).then_some((t, sine))
}
