//! Boundaries of protected regions on one mesh: the nodes inside, and the crack points on the boundary.
//!
//! Cracks are flat between crack points, so a crack with its points on a convex boundary cuts into the region. Regions
//! are grown by as much as it can. Let l be the longest edge of the mesh, and let p = Σ w_i v_i be a convex combination
//! of points v_i in one tetrahedron; four are enough. For any q, Σ w_i |v_i − q|² = |p − q|² + Σ_{i<j} w_i w_j |v_i − v_j|²,
//! and the last sum is at most 3/8 l².
//!
//! - If all v_i are at least √(r² + 3/8 l²) from q, then p is at least r from q. So balls are grown to that radius.
//! - With q = p: some v_i is within √(3/8) l of p. So other regions are grown by that distance.
//!
//! Crack points outside a grown region thus form cracks outside the region, and the grown region contains a node. Where
//! the cell of the region's label continues outside, its natural boundary remains.
//!
//! The method is ours.

use crate::lattice::Lattice;
use crate::memory::held;
use crate::scene::Region;
use crate::surface::LocalFrame;
use crate::tessellation::{BisectorSites, EarlierCracks, FixedPoints, Topology, edge_margin, seam_among};
use nalgebra::Point3;

/// Largest Σ_{i<j} w_i w_j of four weights.
const WEIGHT_PRODUCTS_MAX: f64 = 0.375;

/// Distance from a boundary up to which nodes outside count as inside, over the longest edge; also the smallest share of
/// an edge between a crack point and its nodes.
///
/// Small enough to be invisible, large enough for distinct crack points in single precision.
const NODE_DISTANCE: f64 = 2e-3;

/// Number of parts of an edge of which the last one that crosses the boundary is searched.
const EDGE_PARTS: u32 = 8;

/// Bisection steps in that part.
const BISECTIONS: u32 = 40;

/// Number of refinements of the longest edge near a region.
const REFINEMENTS: usize = 3;

/// Marks a node outside all regions.
const NO_REGION: u32 = u32::MAX;

/// Protected regions that get one label, grown.
#[derive(Clone, Debug, PartialEq)]
struct GrownRegions {
    /// The regions, each with the distance by which it is grown, m.
    regions: Vec<(Region, f64)>,
    frame: LocalFrame,
    /// Longest edge near the regions, local.
    longest_edge: f64,
}

impl GrownRegions {
    fn new(regions: &[Region], mesh: &Lattice, topology: &Topology, frame: LocalFrame) -> Self {
        let nearest = |node: &Point3<f64>| {
            let point_m = frame.to_meters(node);
            regions.iter().map(|region| region.distance_m(&point_m)).fold(f64::INFINITY, f64::min) / frame.diagonal_m
        };
        let distances: Vec<f64> = mesh.nodes.iter().map(nearest).collect();
        let mut longest_edge = f64::INFINITY;
        for _ in 0..REFINEMENTS {
            let is_near = |edge: &&[u32; 2]| edge.iter().all(|&node| distances[node as usize] <= longest_edge);
            longest_edge = topology.edges.iter().filter(is_near).map(|edge| length(mesh, *edge)).fold(0.0, f64::max);
        }
        let grown = |region: &Region| (*region, growth_m(region, longest_edge * frame.diagonal_m));
        Self { regions: regions.iter().map(grown).collect(), frame, longest_edge }
    }

    /// Signed distance of a point from the boundary, local; negative inside.
    fn level(&self, point: &Point3<f64>) -> f64 {
        let point_m = self.frame.to_meters(point);
        let levels_m = self.regions.iter().map(|(region, growth_m)| region.signed_distance_m(&point_m) - growth_m);
        levels_m.fold(f64::INFINITY, f64::min) / self.frame.diagonal_m
    }

    /// Fraction of the way from a point inside to a point outside after which all is outside.
    fn exit(&self, [from, to]: [Point3<f64>; 2]) -> f64 {
        let is_inside = |share: f64| self.level(&(from + (to - from) * share)) <= 0.0;
        let part = 1.0 / f64::from(EDGE_PARTS);
        let last = (1..EDGE_PARTS).rev().map(|k| f64::from(k) * part).find(|share| is_inside(*share)).unwrap_or(0.0);
        let (mut inside, mut outside) = (last, last + part);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (inside + outside);
            *(if is_inside(middle) { &mut inside } else { &mut outside }) = middle;
        }
        outside
    }
}

/// Distance by which a region is grown on a mesh with edges up to `length_m`, m; see the [module](self).
fn growth_m(region: &Region, length_m: f64) -> f64 {
    let spread_m2 = WEIGHT_PRODUCTS_MAX * length_m * length_m;
    match region {
        Region::Ball { radius_m, .. } => (radius_m * radius_m + spread_m2).sqrt() - radius_m,
        Region::Cuboid { .. } => spread_m2.sqrt(),
    }
}

fn length(mesh: &Lattice, [a, b]: [u32; 2]) -> f64 {
    (mesh.nodes[b as usize] - mesh.nodes[a as usize]).norm()
}

/// An edge that crosses the boundary of a region.
#[derive(Clone, Copy, Debug, PartialEq)]
struct BoundaryEdge {
    edge: u32,
    /// Nodes, the first one in a region.
    nodes: [u32; 2],
    /// Position of the crack point, 0 at the first node and 1 at the second.
    share: f64,
    /// Smallest distance of a crack point from the nodes, over the edge's length.
    margin: f64,
}

/// Boundaries of protected regions on one mesh.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::pipeline) struct RegionBoundary {
    groups: Vec<GrownRegions>,
    /// Group of each node, or [`NO_REGION`].
    of_node: Vec<u32>,
    edges: Vec<BoundaryEdge>,
    /// Faces and tetrahedra with nodes in different groups.
    faces: Vec<u32>,
    tets: Vec<u32>,
}

impl RegionBoundary {
    /// The boundaries of groups of regions on a mesh. `join` gives nodes that must have the same label the same group.
    pub fn new(
        (mesh, topology): (&Lattice, &Topology),
        groups: &[Vec<Region>],
        frame: LocalFrame,
        join: impl FnOnce(&mut [u32]),
    ) -> Self {
        let groups: Vec<_> = groups.iter().map(|own| GrownRegions::new(own, mesh, topology, frame)).collect();
        let mut of_node: Vec<u32> = mesh.nodes.iter().map(|node| group(&groups, node)).collect();
        join(&mut of_node);
        let is_divided = |nodes: &[u32]| nodes.iter().any(|&node| of_node[node as usize] != of_node[nodes[0] as usize]);
        let edges = topology.edges.iter().enumerate().filter(|(_, nodes)| is_divided(&nodes[..]));
        let edges = edges.map(|(edge, nodes)| boundary_edge(mesh, &groups, &of_node, edge as u32, *nodes)).collect();
        let faces =
            (0..).zip(&topology.faces).filter(|(_, nodes)| is_divided(&nodes[..])).map(|(face, _)| face).collect();
        let tets = (0..).zip(&mesh.tets).filter(|(_, nodes)| is_divided(&nodes[..])).map(|(tet, _)| tet).collect();
        Self { groups, edges, faces, tets, of_node }
    }

    /// Number of groups of regions, each of which has one label.
    pub fn group_count(&self) -> usize {
        self.groups.len()
    }

    /// Signed distance of a local point from the boundary of a group, local; negative inside.
    pub fn level(&self, group: usize, point: &Point3<f64>) -> f64 {
        self.groups[group].level(point)
    }

    /// Group of a node.
    pub fn group(&self, node: u32) -> Option<usize> {
        Some(self.of_node[node as usize]).filter(|group| *group != NO_REGION).map(|group| group as usize)
    }

    /// Gives all nodes of a group one site, and returns the crack points on the boundaries.
    ///
    /// `of_group`: site of each group. `labels`: the site of each node, those of the diagram before. `sites` maps each
    /// label to itself.
    pub fn enclose(
        &self,
        (mesh, topology): (&Lattice, &Topology),
        sites: BisectorSites<'_>,
        of_group: &[u32],
        labels: &mut [u32],
    ) -> FixedPoints {
        let edges = self.edges.iter().map(|edge| (edge.edge, self.edge_point(edge, mesh, sites, of_group, labels)));
        let points = FixedPoints { edges: edges.collect(), ..FixedPoints::default() };
        for (label, &group) in labels.iter_mut().zip(&self.of_node).filter(|(_, group)| **group != NO_REGION) {
            *label = of_group[group as usize];
        }
        let old = EarlierCracks { labels: &self.of_node, points: &points };
        let simplices = (self.faces.iter().copied(), self.tets.iter().copied());
        seam_among(mesh, topology, simplices, old, labels, sites)
    }

    /// The crack point of an edge: on the boundary of the region, or on that of its label's cell if that is farther.
    fn edge_point(
        &self,
        edge: &BoundaryEdge,
        mesh: &Lattice,
        sites: BisectorSites<'_>,
        of_group: &[u32],
        natural: &[u32],
    ) -> Point3<f64> {
        let [own, other] = edge.nodes.map(|node| natural[node as usize]);
        let mut share = edge.share;
        if own == of_group[self.of_node[edge.nodes[0] as usize] as usize] && self.group(edge.nodes[1]).is_none() {
            let [at_own, at_other] = sites.preferences(edge.nodes, [own, other]);
            if at_own < 0.0 && at_other > 0.0 {
                share = share.max(at_own / (at_own - at_other)).min(1.0 - edge.margin);
            }
        }
        let [from, to] = edge.nodes.map(|node| mesh.nodes[node as usize]);
        from + (to - from) * share
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let Self { groups, of_node, edges, faces, tets } = self;
        let groups = groups.iter().map(|group| held(&group.regions)).sum::<usize>() + held(groups);
        groups + held(of_node) + held(edges) + held(faces) + held(tets)
    }
}

/// The group with the deepest region at a node, or [`NO_REGION`].
fn group(groups: &[GrownRegions], node: &Point3<f64>) -> u32 {
    let levels = (0..).zip(groups).map(|(own, group)| (own, group.level(node), NODE_DISTANCE * group.longest_edge));
    let inside = levels.filter(|(_, level, distance)| level <= distance);
    inside.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(NO_REGION, |(own, ..)| own)
}

/// The edge between nodes of different groups; the middle between two regions.
fn boundary_edge(
    mesh: &Lattice,
    groups: &[GrownRegions],
    of_node: &[u32],
    edge: u32,
    [low, high]: [u32; 2],
) -> BoundaryEdge {
    let nodes = if of_node[low as usize] == NO_REGION { [high, low] } else { [low, high] };
    let [from, to] = nodes.map(|node| mesh.nodes[node as usize]);
    let group = |node: u32| groups.get(of_node[node as usize] as usize);
    let exit = group(nodes[0]).map_or(0.0, |own| own.exit([from, to]));
    let share = group(nodes[1]).map_or(exit, |other| 0.5 * (exit + 1.0 - other.exit([to, from])));
    let margin = edge_margin((to - from).norm()).max(NODE_DISTANCE);
    BoundaryEdge { edge, nodes, share: share.clamp(margin, 1.0 - margin), margin }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::RandomStream;

    #[test]
    fn no_tetrahedron_outside_a_grown_region_reaches_the_region() {
        let mut random = RandomStream::new(11, 0);
        let ball = |radius_m: f64| Region::Ball { center_m: Point3::origin(), radius_m };
        let cube = Region::Cuboid { min_m: Point3::from([-0.4; 3]), max_m: Point3::from([0.4; 3]) };
        for (region, reach) in [(ball(0.0), 1.0), (ball(0.3), 1.0), (ball(3.0), 3.5), (cube, 1.2)] {
            let (mut outside, mut least) = (0, f64::INFINITY);
            while outside < 2000 {
                let center = Point3::from([(); 3].map(|()| reach * (2.0 * random.uniform() - 1.0)));
                let corners = [(); 4].map(|()| center + Point3::from([(); 3].map(|()| random.uniform() - 0.5)).coords);
                let longest =
                    corners.iter().flat_map(|a| corners.iter().map(move |b| (a - b).norm())).fold(0.0, f64::max);
                let growth_m = growth_m(&region, longest);
                if corners.iter().all(|corner| region.signed_distance_m(corner) >= growth_m) {
                    outside += 1;
                    let weights = [(); 4].map(|()| random.uniform());
                    let sum: f64 = weights.iter().sum();
                    let point = corners.iter().zip(weights).map(|(corner, weight)| corner.coords * (weight / sum));
                    least = least.min(region.signed_distance_m(&Point3::from(point.sum::<nalgebra::Vector3<f64>>())));
                }
            }
            assert!(least >= 0.0, "{region}: {least}");
        }
    }

    #[test]
    fn an_edge_leaves_overlapping_regions_at_the_last_boundary() {
        let ball = |x: f64| (Region::Ball { center_m: Point3::new(x, 0.0, 0.0), radius_m: 1.0 }, 0.0);
        let frame = LocalFrame { center_m: Point3::origin(), diagonal_m: 1.0 };
        let regions = GrownRegions { regions: vec![ball(0.0), ball(2.5)], frame, longest_edge: 1.0 };
        let exit = |from: f64, to: f64| regions.exit([from, to].map(|x| Point3::new(x, 0.0, 0.0)));
        assert!((exit(0.0, 1.25) - 0.8).abs() < 1e-9 && (exit(0.0, 5.0) - 0.7).abs() < 1e-9);
        assert!(exit(1.0, 1.4) < 1e-9);
    }
}
