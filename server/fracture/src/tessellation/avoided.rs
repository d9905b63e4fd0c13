//! Places on edges that crack points avoid, because another point of an almost flat tetrahedron lies there.
//!
//! Two opposite edges of such a tetrahedron can cross. Where both are cut, their crack points could have one position in
//! single precision, and the fragments would not be closed there. The same holds for the barycenters at which the crack
//! points of its faces and its own lie. The edges of a face that is a needle overlap, so that a bisector meets two of
//! them in one place: there, the points on the long edges are shifted.

use super::barycentric::EDGE_DISTANCE;
use super::topology::Topology;
use crate::lattice::{FACES, Lattice};
use nalgebra::{Point3, Vector3};
use std::collections::BTreeMap;

/// Largest half width of an interval, over the length of its edge.
const HALF_WIDTH_MAX: f64 = 0.1;

/// The edge opposite to each, by position in [`EDGES`](crate::lattice::EDGES).
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

/// A distance by which the crack point of an edge is moved toward the edge's middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ShiftedEdge {
    /// Edge of the topology.
    pub edge: u32,
    /// Distance, local.
    pub distance: f64,
}

/// Shifts of the long edges of the faces in `flat_faces` that are needles, ascending.
///
/// Edges that overlap get different multiples of [`EDGE_DISTANCE`], which makes their points differ in single precision.
pub(super) fn shifted(lattice: &Lattice, topology: &Topology, flat_faces: &[u32]) -> Vec<ShiftedEdge> {
    let needles: Vec<[u32; 3]> = flat_faces.iter().filter_map(|&face| needle(lattice, topology, face)).collect();
    let mut over: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &[long, first, second] in &needles {
        [first, second].into_iter().for_each(|short| over.entry(short).or_default().push(long));
    }
    let mut parts: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    needles.iter().for_each(|&[long, first, second]| parts.entry(long).or_default().extend([first, second]));
    let mut order: Vec<u32> = parts.keys().copied().collect();
    order.sort_by(|a, b| length(lattice, topology, *a).total_cmp(&length(lattice, topology, *b)));
    let mut multiples: BTreeMap<u32, u32> = BTreeMap::new();
    for edge in order {
        let own = &parts[&edge];
        let beside = own.iter().chain([&edge]).filter_map(|part| over.get(part)).flatten();
        let taken: Vec<u32> = own.iter().chain(beside).filter_map(|other| multiples.get(other)).copied().collect();
        let free = (1..).find(|multiple| !taken.contains(multiple)).unwrap_or(1);
        multiples.insert(edge, free);
    }
    multiples
        .into_iter()
        .map(|(edge, multiple)| ShiftedEdge { edge, distance: f64::from(multiple) * EDGE_DISTANCE })
        .collect()
}

/// The edges of a face whose smallest height is below [`EDGE_DISTANCE`], the longest first; `None` for other faces.
fn needle(lattice: &Lattice, topology: &Topology, face: u32) -> Option<[u32; 3]> {
    let mut edges = topology.face_edges[face as usize];
    edges.sort_by(|a, b| length(lattice, topology, *b).total_cmp(&length(lattice, topology, *a)));
    let [a, b, c] = topology.faces[face as usize].map(|node| lattice.nodes[node as usize]);
    let height = (b - a).cross(&(c - a)).norm() / length(lattice, topology, edges[0]);
    (height < EDGE_DISTANCE).then_some(edges)
}

fn length(lattice: &Lattice, topology: &Topology, edge: u32) -> f64 {
    let [from, to] = topology.edges[edge as usize].map(|node| lattice.nodes[node as usize]);
    (to - from).norm()
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
        for point in FACES.iter().map(|face| mean(face)).chain([mean(&[0, 1, 2, 3])]) {
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
