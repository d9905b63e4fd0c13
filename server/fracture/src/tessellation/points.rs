//! Crack points: intersections of the cells' boundaries with edges, faces and interiors of tetrahedra.
//!
//! Based on: Schvartzman & Otaduy, *Fracture Animation Based on High-Dimensional Voronoi Diagrams* (I3D 2014); Bronson,
//! Levine & Whitaker, *Lattice cleaving* (IEEE TVCG 20, 2014) for one point per cut edge, face and tetrahedron. The
//! margin is ours ([`MARGIN`](super::MARGIN)).

use super::barycentric::{
    edge_margin, in_tet, on_edge, on_face, preference, simplex_margin, smallest_height, triangle_height,
};
use super::cut::{CutSimplices, GRAIN};
use super::index_selection::IndexSet;
use super::pattern::{ALL_CUT, FACE_MASKS, mask};
use super::{TessellationError, Topology};
use crate::lattice::Lattice;
use crate::lift::LiftedLattice;
use crate::memory::held;
use crate::simd::widest;
use nalgebra::{Point3, Vector3};
use pulp::NullaryFnOnce;
use rayon::prelude::*;

/// True for masks of five or six edges, where at least three labels meet. A table, because counting bits is slow on old
/// processors.
const MANY: [bool; 64] = {
    let mut many = [false; 64];
    let mut mask = 0;
    while mask < 64 {
        many[mask] = (mask as u8).count_ones() >= 5;
        mask += 1;
    }
    many
};

/// The diagram whose bisectors contain the crack points.
#[derive(Clone, Copy, Debug)]
pub struct BisectorSites<'a> {
    /// The lift of the lattice.
    pub lift: &'a LiftedLattice,
    /// Coordinates of the sites, `sites × dimension` of the lift, site by site.
    pub coordinates: &'a [f64],
    /// Site of each fragment label.
    pub of_fragment: &'a [u32],
    /// Site of each node if fragments have been merged, so that cracks keep the diagram's positions. `None`: that of
    /// its fragment.
    pub of_node: Option<&'a [u32]>,
}

impl BisectorSites<'_> {
    #[inline(always)]
    fn at(&self, site: u32) -> &[f64] {
        let first = site as usize * self.lift.dimension;
        &self.coordinates[first..first + self.lift.dimension]
    }

    /// The site of `node`, which has the fragment label `fragment`.
    #[inline(always)]
    fn of(&self, node: u32, fragment: u32) -> u32 {
        self.of_node.map_or_else(|| self.of_fragment[fragment as usize], |of_node| of_node[node as usize])
    }

    /// f_a − f_b at the weighted mean of `nodes`; negative if the point belongs to fragment a rather than b.
    pub fn rivalry(&self, nodes: [u32; 4], weights: [f64; 4], a: u32, b: u32) -> f64 {
        let at_nodes = self.preferences(nodes, [a, b].map(|fragment| self.of_fragment[fragment as usize]));
        at_nodes.iter().zip(weights).map(|(own, weight)| own * weight).sum()
    }

    /// Distance of the sites of two fragments.
    pub fn distance(&self, a: u32, b: u32) -> f64 {
        let [a, b] = [a, b].map(|fragment| self.at(self.of_fragment[fragment as usize]));
        a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    }

    /// f_a − f_b of two sites at each of `nodes`.
    #[inline(always)]
    pub fn preferences<const N: usize>(&self, nodes: [u32; N], [a, b]: [u32; 2]) -> [f64; N] {
        let (a, b) = (self.at(a), self.at(b));
        nodes.map(|node| preference(self.lift.at(node as usize), a, b))
    }
}

/// Existing crack points of earlier fractures, local, each with the index of its edge, face or tetrahedron in the
/// [`Topology`].
///
/// Their positions are not changed. A point is ignored if the current labels have no crack point on its simplex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FixedPoints {
    /// Points on edges.
    pub edges: Vec<(u32, Point3<f64>)>,
    /// Points on faces.
    pub faces: Vec<(u32, Point3<f64>)>,
    /// Points in tetrahedra.
    pub tets: Vec<(u32, Point3<f64>)>,
}

/// Edges per cut tetrahedron above which it is faster to go through the cut tetrahedra than through all edges.
const EDGES_PER_CUT_TET: usize = 4;

/// Crack points: one on each edge with two labels, face with three and tetrahedron with four.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CrackPoints {
    /// Labels for which the points were computed.
    pub(super) labels: Vec<u32>,
    /// Cut edges of each tetrahedron; see [`mask`].
    pub(super) masks: Vec<u8>,
    /// Tetrahedra with cut edges, ascending.
    pub(super) cut_tets: Vec<u32>,
    /// Labels of the ends of each cut edge.
    pub(super) sides: Vec<[u32; 2]>,
    pub(super) edges: CutSimplices,
    pub(super) faces: CutSimplices,
    pub(super) tets: CutSimplices,
    scratch: Scratch,
}

/// Scratch memory, without meaning between calls; all instances compare equal.
#[derive(Clone, Debug, Default)]
struct Scratch {
    chosen: IndexSet,
    /// Cut edges, then faces with three labels, 64 per word.
    marks: Vec<u64>,
}

impl PartialEq for Scratch {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl FixedPoints {
    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        held(&self.edges) + held(&self.faces) + held(&self.tets)
    }
}

impl CrackPoints {
    /// Computes the crack points of `labels` (one fragment label per node). Reuses the memory of earlier calls.
    ///
    /// With `sites`, points are on the bisectors. Points outside the simplex or too near its boundary are moved to the
    /// nearest point whose barycentric coordinates are all at least [`MARGIN`](super::MARGIN). Degenerate systems yield
    /// barycenters, as do all simplices without `sites`. `fixed` takes precedence over both.
    ///
    /// # Errors
    /// [`TessellationError`] for labels or sites that do not fit the lattice.
    pub fn find(
        &mut self,
        lattice: &Lattice,
        topology: &Topology,
        labels: &[u32],
        sites: Option<BisectorSites<'_>>,
        fixed: &FixedPoints,
    ) -> Result<(), TessellationError> {
        let fragments = topology.fragment_count(labels)?;
        sites.map_or(Ok(()), |sites| check(&sites, fragments, labels.len()))?;
        self.select(lattice, topology, labels);
        let finder = Finder { lattice, labels, sites };
        let cut = self.edges.simplices.par_iter().with_min_len(GRAIN);
        cut.map(|&edge| finder.labels_of(topology.edges[edge as usize])).collect_into_vec(&mut self.sides);
        let sides = &self.sides;
        self.edges.locate_in_chunks(&|first, simplices, out| {
            widest(EdgePoints { finder: &finder, topology, simplices, sides: &sides[first..], out });
        });
        self.faces.locate(|face| finder.face(topology.faces[face]));
        self.tets.locate(|tet| finder.tet(lattice.tets[tet]));
        topology.flat_quads.straighten(lattice, self);
        self.edges.fix(&fixed.edges).map_err(|edge| TessellationError::FixedEdge { edge })?;
        self.faces.fix(&fixed.faces).map_err(|face| TessellationError::FixedFace { face })?;
        self.tets.fix(&fixed.tets).map_err(|tet| TessellationError::FixedTet { tet })
    }

    /// All points, for a later tessellation that must keep them.
    pub fn to_fixed(&self) -> FixedPoints {
        FixedPoints { edges: self.edges.fixed(), faces: self.faces.fixed(), tets: self.tets.fixed() }
    }

    /// True if these are points of `labels` on the lattice of `topology`.
    pub(super) fn fit(&self, topology: &Topology, labels: &[u32]) -> bool {
        let lengths = [self.edges.slots.len(), self.faces.slots.len(), self.tets.slots.len()];
        lengths == [topology.edges.len(), topology.faces.len(), topology.tet_edges.len()] && self.labels == labels
    }

    /// Selects the cut simplices from the labels only.
    fn select(&mut self, lattice: &Lattice, topology: &Topology, labels: &[u32]) {
        self.labels.clear();
        self.labels.extend_from_slice(labels);
        self.masks.resize(lattice.tets.len(), 0);
        let tets = lattice.tets.par_iter().with_min_len(16 * GRAIN);
        let label = |node: u32| labels[node as usize];
        self.masks.par_iter_mut().zip(tets).for_each(|(own, nodes)| *own = mask(nodes.map(label)));
        let Scratch { chosen, marks } = &mut self.scratch;
        let masks = &self.masks;
        chosen.choose(masks.len(), &mut self.cut_tets, |tet| masks[tet] != 0);
        let cut_tets = || self.cut_tets.iter().map(|&tet| (tet as usize, masks[tet as usize]));
        let mark = |marks: &mut [u64], simplex: u32| marks[simplex as usize / 64] |= 1 << (simplex % 64);
        let edges = &topology.edges;
        if EDGES_PER_CUT_TET * self.cut_tets.len() < edges.len() {
            // Every edge belongs to a tetrahedron, so every cut edge belongs to a cut one.
            clear_marks(marks, edges.len());
            for (tet, mut left) in cut_tets() {
                while left != 0 {
                    mark(marks, topology.tet_edges[tet][left.trailing_zeros() as usize]);
                    left &= left - 1;
                }
            }
            self.edges.take_marked(edges.len(), marks);
        } else {
            self.edges.choose(edges.len(), chosen, |edge| label(edges[edge][0]) != label(edges[edge][1]));
        }
        clear_marks(marks, topology.faces.len());
        for (tet, mask) in cut_tets().filter(|(_, mask)| MANY[*mask as usize]) {
            let faces = topology.tet_faces[tet].iter().zip(FACE_MASKS);
            faces.filter(|(_, face)| mask & face == *face).for_each(|(&face, _)| mark(marks, face));
        }
        self.faces.take_marked(topology.faces.len(), marks);
        self.tets.choose_of(lattice.tets.len(), &self.cut_tets, |tet| masks[tet as usize] == ALL_CUT);
    }
}

/// Removes all marks, for `count` simplices.
fn clear_marks(marks: &mut Vec<u64>, count: usize) {
    marks.clear();
    marks.resize(count.div_ceil(64), 0);
}

/// [`CrackPoints::find`] into new memory.
///
/// # Errors
/// Those of [`CrackPoints::find`].
pub fn crack_points(
    lattice: &Lattice,
    topology: &Topology,
    labels: &[u32],
    sites: Option<BisectorSites<'_>>,
    fixed: &FixedPoints,
) -> Result<CrackPoints, TessellationError> {
    let mut points = CrackPoints::default();
    points.find(lattice, topology, labels, sites, fixed)?;
    Ok(points)
}

fn check(sites: &BisectorSites<'_>, fragments: usize, nodes: usize) -> Result<(), TessellationError> {
    let count = sites.coordinates.len() / sites.lift.dimension;
    if let Some(of_node) = sites.of_node {
        let node = (0..nodes).find(|node| of_node.get(*node).is_none_or(|&site| site as usize >= count));
        node.map_or(Ok(()), |node| Err(TessellationError::NodeSite { node }))?;
    }
    let known = |fragment: &usize| sites.of_fragment.get(*fragment).is_some_and(|&site| (site as usize) < count);
    match (0..fragments).find(|fragment| !known(fragment)) {
        Some(fragment) => Err(TessellationError::Site { fragment }),
        None => Ok(()),
    }
}

struct Finder<'a> {
    lattice: &'a Lattice,
    labels: &'a [u32],
    sites: Option<BisectorSites<'a>>,
}

/// Computation of the points on some cut edges.
struct EdgePoints<'a> {
    finder: &'a Finder<'a>,
    topology: &'a Topology,
    simplices: &'a [u32],
    sides: &'a [[u32; 2]],
    out: &'a mut [Point3<f64>],
}

impl NullaryFnOnce for EdgePoints<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for ((edge, sides), out) in self.simplices.iter().zip(self.sides).zip(self.out) {
            *out = self.finder.edge(self.topology.edges[*edge as usize], *sides);
        }
    }
}

impl Finder<'_> {
    #[inline(always)]
    fn edge(&self, nodes: [u32; 2], sides: [u32; 2]) -> Point3<f64> {
        let [from, to] = nodes.map(|node| self.lattice.nodes[node as usize]);
        let margin = edge_margin((to - from).norm());
        let solve = |sites: BisectorSites<'_>| {
            let of_ends = [sites.of(nodes[0], sides[0]), sites.of(nodes[1], sides[1])];
            on_edge(sites.preferences(nodes, of_ends), margin)
        };
        let weights = self.sites.map_or([0.5; 2], solve);
        self.combine(nodes, weights)
    }

    fn face(&self, nodes: [u32; 3]) -> Point3<f64> {
        let margin = simplex_margin(triangle_height(nodes.map(|node| self.lattice.nodes[node as usize])));
        let solve = |sites: BisectorSites<'_>| {
            let [a, b, c] = self.sites_of(&sites, nodes);
            on_face([b, c].map(|other| sites.preferences(nodes, [a, other])), margin)
        };
        let weights = self.sites.map_or([1.0 / 3.0; 3], solve);
        self.combine(nodes, weights)
    }

    fn tet(&self, nodes: [u32; 4]) -> Point3<f64> {
        let height = smallest_height(&nodes.map(|node| self.lattice.nodes[node as usize]));
        let solve = |sites: BisectorSites<'_>| {
            let [a, b, c, d] = self.sites_of(&sites, nodes);
            in_tet([b, c, d].map(|other| sites.preferences(nodes, [a, other])), simplex_margin(height))
        };
        let weights = self.sites.map_or([0.25; 4], solve);
        self.combine(nodes, weights)
    }

    fn labels_of<const N: usize>(&self, nodes: [u32; N]) -> [u32; N] {
        nodes.map(|node| self.labels[node as usize])
    }

    fn sites_of<const N: usize>(&self, sites: &BisectorSites<'_>, nodes: [u32; N]) -> [u32; N] {
        nodes.map(|node| sites.of(node, self.labels[node as usize]))
    }

    /// The point with barycentric coordinates `weights`, computed from the first node so that it stays in its simplex.
    #[inline(always)]
    fn combine<const N: usize>(&self, nodes: [u32; N], weights: [f64; N]) -> Point3<f64> {
        let base = self.lattice.nodes[nodes[0] as usize];
        let offset: Vector3<f64> = (1..N).map(|k| (self.lattice.nodes[nodes[k] as usize] - base) * weights[k]).sum();
        base + offset
    }
}
