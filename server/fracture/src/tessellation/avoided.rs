//! Places on edges that crack points avoid, because another point of an almost flat tetrahedron lies there.
//!
//! Two opposite edges of such a tetrahedron can cross. Where both are cut, their crack points could have one position in
//! single precision, and the fragments would not be closed there. The same holds for the crack points of its faces and
//! its own.
//!
//! Two edges with a small angle between them are near each other at their common node, where crack points are kept a
//! small distance from it. If the angle is zero, they overlap, and a bisector meets both in one place. The points on one
//! of them are therefore shifted.

use super::barycentric::{EDGE_DISTANCE, scattered};
use super::topology::Topology;
use crate::lattice::Lattice;
use nalgebra::{Point3, Vector3};
use std::collections::BTreeMap;

/// Sine of an angle between edges below which their crack points are shifted.
const SINE_MIN: f64 = 0.1;

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

/// Edges that are too near to each other, with those of each.
type NearEdges = BTreeMap<u32, Vec<u32>>;

/// Shifts of edges that enclose small angles with others, ascending.
///
/// Edges that are near each other get different multiples of [`EDGE_DISTANCE`], the longer edges the larger ones.
pub(super) fn shifted(lattice: &Lattice, topology: &Topology) -> Vec<ShiftedEdge> {
    let near = near_edges(lattice, topology);
    let mut order: Vec<(f64, u32)> = near.keys().map(|&edge| (vector(lattice, topology, edge).norm(), edge)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut multiples: BTreeMap<u32, u32> = BTreeMap::new();
    for (_, edge) in order {
        let taken: Vec<u32> = near[&edge].iter().filter_map(|other| multiples.get(other)).copied().collect();
        let free = (0..).find(|multiple| !taken.contains(multiple)).unwrap_or(0);
        multiples.insert(edge, free);
    }
    let shift = |(edge, multiple)| ShiftedEdge { edge, distance: f64::from(multiple) * EDGE_DISTANCE };
    multiples.into_iter().filter(|(_, multiple)| *multiple > 0).map(shift).collect()
}

/// Edges of a face with a small angle between them, and long edges of needles that overlap on a short edge.
fn near_edges(lattice: &Lattice, topology: &Topology) -> NearEdges {
    let (mut near, mut over) = (NearEdges::new(), NearEdges::new());
    for edges in &topology.face_edges {
        let vectors = edges.map(|edge| vector(lattice, topology, edge));
        let cross = vectors[0].cross(&vectors[1]).norm();
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            // The cross product of any two edges has the same length, twice the area.
            let product = vectors[i].norm() * vectors[j].norm();
            let third = vectors[3 - i - j].norm_squared();
            let is_acute = third < vectors[i].norm_squared() + vectors[j].norm_squared();
            if is_acute && cross < SINE_MIN * product {
                put(&mut near, edges[i], edges[j]);
                let longest = if vectors[i].norm() > vectors[j].norm() { i } else { j };
                if cross < EDGE_DISTANCE * vectors[longest].norm() {
                    over.entry(edges[i + j - longest]).or_default().push(edges[longest]);
                }
            }
        }
    }
    for long in over.values() {
        for (k, &first) in long.iter().enumerate() {
            long[..k].iter().filter(|second| **second != first).for_each(|&second| put(&mut near, first, second));
        }
    }
    near
}

fn put(near: &mut NearEdges, first: u32, second: u32) {
    near.entry(first).or_default().push(second);
    near.entry(second).or_default().push(first);
}

fn vector(lattice: &Lattice, topology: &Topology, edge: u32) -> Vector3<f64> {
    let [from, to] = topology.edges[edge as usize].map(|node| lattice.nodes[node as usize]);
    to - from
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
    let mut points = topology.tet_faces[tet].map(|face| flat_point(lattice, topology.faces[face as usize])).to_vec();
    points.push(flat_point(lattice, lattice.tets[tet]));
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
        for point in &points {
            let t = (point - from).dot(&(to - from)) / (length * length);
            if (from + (to - from) * t - point).norm() < EDGE_DISTANCE {
                avoid(t, 2.0 * EDGE_DISTANCE);
            }
        }
    }
}

/// Crack point of an almost flat face or tetrahedron.
fn flat_point<const N: usize>(lattice: &Lattice, nodes: [u32; N]) -> Point3<f64> {
    let weighted =
        nodes.iter().zip(scattered(nodes)).map(|(&node, weight)| lattice.nodes[node as usize].coords * weight);
    Point3::from(weighted.sum::<Vector3<f64>>())
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
