//! Geodesic distance along the boundary from one of its points, up to a limit.
//!
//! Based on: R. Kimmel & J. A. Sethian, *Computing geodesic paths on manifolds* (PNAS 95, 1998): Dijkstra's front with
//! an update across triangles. The update unfolds the source into the triangle's plane (M. Novotni & R. Klein,
//! *Computing geodesic distances on triangular meshes*, WSCG 2002). With right and obtuse angles, the front may reach a
//! node before both corners that its distance comes from, so distances are corrected as long as they improve. Exact
//! within a plane; never longer than along edges.

use super::{BoundaryNodes, NearestBoundaryPoint};
use nalgebra::Point3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Relative improvement, over the limit, below which a shorter path counts as rounding.
const IMPROVEMENT_MIN: f64 = 1e-13;

/// Front and the nodes that it reached; reused between contacts.
#[derive(Clone, Debug, Default)]
pub struct LoadFront {
    /// Distance of each boundary node; infinite if not reached.
    distances: Vec<f64>,
    /// Nodes with a finite distance.
    seen: Vec<u32>,
    /// Nodes within the limit and their distances, ordered by node.
    reached: Vec<(u32, f64)>,
    /// Queue by distance. The bits of non-negative floats have the order of the floats.
    heap: BinaryHeap<Reverse<(u64, u32)>>,
}

impl LoadFront {
    /// Boundary nodes within `limit` of `source` along the boundary, with their distances, ordered by node.
    pub fn run(&mut self, boundary: &BoundaryNodes, source: &NearestBoundaryPoint, limit: f64) -> &[(u32, f64)] {
        self.reset(boundary.nodes.len());
        let slack = IMPROVEMENT_MIN * limit;
        for node in boundary.faces[source.face] {
            self.offer(node, (boundary.positions[node as usize] - source.place).norm(), slack);
        }
        while let Some(Reverse((bits, node))) = self.heap.pop() {
            let distance = f64::from_bits(bits);
            if distance > limit {
                break;
            }
            if distance == self.distances[node as usize] {
                self.pass(boundary, node, slack);
            }
        }
        let within = self.seen.iter().map(|&node| (node, self.distances[node as usize]));
        self.reached.extend(within.filter(|&(_, distance)| distance <= limit));
        self.reached.sort_unstable_by_key(|&(node, _)| node);
        &self.reached
    }

    fn reset(&mut self, nodes: usize) {
        for node in self.seen.drain(..) {
            self.distances[node as usize] = f64::INFINITY;
        }
        self.distances.resize(nodes, f64::INFINITY);
        self.reached.clear();
        self.heap.clear();
    }

    fn offer(&mut self, node: u32, distance: f64, slack: f64) {
        let known = &mut self.distances[node as usize];
        if distance < *known - slack {
            if known.is_infinite() {
                self.seen.push(node);
            }
            *known = distance;
            self.heap.push(Reverse((distance.to_bits(), node)));
        }
    }

    /// Offers distances to the neighbors of `node`, along edges and across the triangles around it.
    fn pass(&mut self, boundary: &BoundaryNodes, node: u32, slack: f64) {
        let (place, distance) = (boundary.positions[node as usize], self.distances[node as usize]);
        for &face in boundary.around(node) {
            let [a, b, c] = boundary.faces[face as usize];
            let [first, second] = if a == node { [b, c] } else { [a, if b == node { c } else { b }] };
            for [base, target] in [[first, second], [second, first]] {
                let [base_place, target_place] = [base, target].map(|other| boundary.positions[other as usize]);
                self.offer(target, distance + (target_place - place).norm(), slack);
                let known = [distance, self.distances[base as usize]];
                if known[1].is_finite()
                    && let Some(across) = unfold([place, base_place], known, target_place)
                {
                    self.offer(target, across, slack);
                }
            }
        }
    }
}

/// Distance of `target` from a source at distances `known` from the ends of `base`.
///
/// The source is unfolded into the plane of the triangle, on the other side of the base. `None` if the straight path
/// does not cross the base.
fn unfold(base: [Point3<f64>; 2], known: [f64; 2], target: Point3<f64>) -> Option<f64> {
    let edge = base[1] - base[0];
    let length = edge.norm();
    let out = target - base[0];
    let x = out.dot(&edge) / length;
    let y = (out.norm_squared() - x * x).max(0.0).sqrt();
    let source_x = (known[0] * known[0] - known[1] * known[1] + length * length) / (2.0 * length);
    let source_y = (known[0] * known[0] - source_x * source_x).max(0.0).sqrt();
    let crossing = source_x + (x - source_x) * source_y / (source_y + y);
    // Lengths are local, so their squares neither overflow nor underflow.
    let way = (x - source_x) * (x - source_x) + (y + source_y) * (y + source_y);
    (crossing >= 0.0 && crossing <= length).then(|| way.sqrt())
}
