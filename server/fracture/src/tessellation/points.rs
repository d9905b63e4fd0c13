//! Crack points: where the cells' borders meet the edges, faces and insides of tetrahedra.
//!
//! Based on: Schvartzman & Otaduy, *Fracture Animation Based on High-Dimensional Voronoi Diagrams* (I3D 2014);
//! Bronson, Levine & Whitaker, *Lattice cleaving* (IEEE TVCG 20, 2014) for one point per cut edge, face and
//! tetrahedron. The margin is ours ([`MARGIN`](super::MARGIN)).

use super::barycentric::{edge_margin, in_tet, on_edge, on_face, preference};
use super::pattern::{ALL_CUT, FACE_MASKS, mask};
use super::span::each_span;
use super::{TessellationError, Topology};
use crate::lattice::Lattice;
use crate::lift::Lift;
use crate::memory::held;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// No crack point here.
pub(super) const NONE: u32 = u32::MAX;

/// Fewer points than this are not worth another thread.
const GRAIN: usize = 256;

/// Whether a mask has five or six edges, so that three labels or more meet; counting is slow on old processors.
const MANY: [bool; 64] = {
    let mut many = [false; 64];
    let mut mask = 0;
    while mask < 64 {
        many[mask] = (mask as u8).count_ones() >= 5;
        mask += 1;
    }
    many
};

/// Simplices that one task looks through.
const PART: usize = 8192;

/// The diagram whose bisectors the crack points lie on.
#[derive(Clone, Copy, Debug)]
pub struct Sites<'a> {
    /// The lift of the lattice.
    pub lift: &'a Lift,
    /// Site coordinates, site-major, `sites × dimension` of the lift.
    pub coordinates: &'a [f64],
    /// Site of each fragment label.
    pub of_fragment: &'a [u32],
}

impl Sites<'_> {
    fn at(&self, fragment: u32) -> &[f64] {
        let first = self.of_fragment[fragment as usize] as usize * self.lift.dimension;
        &self.coordinates[first..first + self.lift.dimension]
    }

    /// f_a − f_b at the point that is the mean of `nodes` with these weights: negative where it belongs to fragment a rather than b.
    pub fn rivalry(&self, nodes: [u32; 4], weights: [f64; 4], a: u32, b: u32) -> f64 {
        let at_nodes = self.preferences(nodes, a, b);
        at_nodes.iter().zip(weights).map(|(own, weight)| own * weight).sum()
    }

    /// f_a − f_b at each of `nodes`.
    pub(super) fn preferences<const N: usize>(&self, nodes: [u32; N], a: u32, b: u32) -> [f64; N] {
        let (a, b) = (self.at(a), self.at(b));
        nodes.map(|node| preference(self.lift.at(node as usize), a, b))
    }
}

/// Points that are already there (cracks of earlier fractures), local, each with the index of its edge, face or
/// tetrahedron in the [`Topology`]. They are taken as they are; where the present labels have no crack point they are
/// not used.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FixedPoints {
    /// On edges.
    pub edges: Vec<(u32, Point3<f64>)>,
    /// On faces.
    pub faces: Vec<(u32, Point3<f64>)>,
    /// In tetrahedra.
    pub tets: Vec<(u32, Point3<f64>)>,
}

/// The edges with two labels, faces with three and tetrahedra with four, with one point each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Points {
    /// The labels that they are the points of.
    pub(super) labels: Vec<u32>,
    /// Which edges of each tetrahedron are cut, see [`mask`].
    pub(super) masks: Vec<u8>,
    pub(super) edges: Cut,
    pub(super) faces: Cut,
    pub(super) tets: Cut,
}

/// Which simplices of one dimension carry a point, and the points.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Cut {
    /// Simplices with a point, ascending.
    pub simplices: Vec<u32>,
    /// Index into `simplices` by simplex, or [`NONE`].
    pub slots: Vec<u32>,
    /// One point each, local.
    pub places: Vec<Point3<f64>>,
    /// Simplices with a point in each part of all.
    counts: Vec<usize>,
    /// Sums of those.
    firsts: Vec<usize>,
}

impl Cut {
    /// Forgets all points of a lattice with `count` simplices.
    fn clear(&mut self, count: usize) {
        self.slots.clear();
        self.slots.resize(count, NONE);
    }

    fn mark(&mut self, simplex: u32) {
        self.slots[simplex as usize] = 0;
    }

    /// Numbers the marked simplices: counts by parts, adds up, writes by parts.
    fn number(&mut self) {
        let marked = |slots: &[u32]| slots.iter().filter(|slot| **slot != NONE).count();
        let counts = self.slots.par_chunks(PART).map(marked);
        counts.collect_into_vec(&mut self.counts);
        self.firsts.clear();
        self.firsts.push(0);
        self.firsts.extend(self.counts.iter().scan(0, |sum, count| {
            *sum += count;
            Some(*sum)
        }));
        let Self { simplices, slots, firsts, .. } = self;
        simplices.resize(firsts[firsts.len() - 1], 0);
        each_span(firsts, simplices, &|part, own| {
            let Some(last) = own.len().checked_sub(1) else { return };
            let (first, mut next) = (part * PART, 0);
            for (offset, slot) in slots[first..slots.len().min(first + PART)].iter().enumerate() {
                // Always written, kept if it counts: the branch would be a guess.
                own[next.min(last)] = (first + offset) as u32;
                next += usize::from(*slot != NONE);
                if next > last {
                    break;
                }
            }
        });
        // What was read back: a part is in order.
        slots.par_chunks_mut(PART).zip(firsts.par_windows(2)).enumerate().for_each(|(part, (slots, range))| {
            for (place, simplex) in simplices[range[0]..range[1]].iter().enumerate() {
                slots[*simplex as usize - part * PART] = (range[0] + place) as u32;
            }
        });
    }

    fn locate(&mut self, place: impl Fn(usize) -> Point3<f64> + Sync) {
        self.places.clear();
        self.places.resize(self.simplices.len(), Point3::origin());
        let simplices = self.simplices.par_iter().with_min_len(GRAIN);
        self.places.par_iter_mut().zip(simplices).for_each(|(point, &simplex)| *point = place(simplex as usize));
    }

    /// Puts the fixed points in their places; on refusal, the index that does not fit.
    fn fix(&mut self, fixed: &[(u32, Point3<f64>)]) -> Result<(), u32> {
        for &(simplex, place) in fixed {
            let slot = *self.slots.get(simplex as usize).ok_or(simplex)?;
            if !place.coords.iter().all(|x| x.is_finite()) {
                return Err(simplex);
            }
            if slot != NONE {
                self.places[slot as usize] = place;
            }
        }
        Ok(())
    }

    fn fixed(&self) -> Vec<(u32, Point3<f64>)> {
        self.simplices.iter().copied().zip(self.places.iter().copied()).collect()
    }
}

impl FixedPoints {
    /// Bytes that they hold.
    pub fn bytes(&self) -> usize {
        held(&self.edges) + held(&self.faces) + held(&self.tets)
    }
}

impl Points {
    /// Finds the crack points of `labels` (one fragment label per node), reusing what an earlier call allocated.
    ///
    /// With `sites`, points lie on the bisectors, moved to the nearest point whose barycentric coordinates are all at
    /// least [`MARGIN`](super::MARGIN) where the bisectors meet nearer to the simplex's boundary or outside;
    /// degenerate systems, and all without `sites`, give barycentres. `fixed` wins over both.
    pub fn find(
        &mut self,
        lattice: &Lattice,
        topology: &Topology,
        labels: &[u32],
        sites: Option<Sites<'_>>,
        fixed: &FixedPoints,
    ) -> Result<(), TessellationError> {
        let fragments = super::fragment_count(topology, labels)?;
        sites.map_or(Ok(()), |sites| check(&sites, fragments))?;
        self.select(lattice, topology, labels);
        let finder = Finder { lattice, labels, sites };
        self.edges.locate(|edge| finder.edge(topology.edges[edge]));
        self.faces.locate(|face| finder.face(topology.faces[face]));
        self.tets.locate(|tet| finder.tet(lattice.tets[tet]));
        self.edges.fix(&fixed.edges).map_err(|edge| TessellationError::FixedEdge { edge })?;
        self.faces.fix(&fixed.faces).map_err(|face| TessellationError::FixedFace { face })?;
        self.tets.fix(&fixed.tets).map_err(|tet| TessellationError::FixedTet { tet })
    }

    /// All points, for a later tessellation that must keep them.
    pub fn to_fixed(&self) -> FixedPoints {
        FixedPoints { edges: self.edges.fixed(), faces: self.faces.fixed(), tets: self.tets.fixed() }
    }

    /// Whether these are points of `labels` on the lattice of `topology`.
    pub(super) fn fit(&self, topology: &Topology, labels: &[u32]) -> bool {
        let lengths = [self.edges.slots.len(), self.faces.slots.len(), self.tets.slots.len()];
        lengths == [topology.edges.len(), topology.faces.len(), topology.tet_edges.len()] && self.labels == labels
    }

    /// Finds what is cut, from the labels alone.
    fn select(&mut self, lattice: &Lattice, topology: &Topology, labels: &[u32]) {
        self.labels.clear();
        self.labels.extend_from_slice(labels);
        self.masks.resize(lattice.tets.len(), 0);
        let tets = lattice.tets.par_iter().with_min_len(16 * GRAIN);
        let label = |node: u32| labels[node as usize];
        self.masks.par_iter_mut().zip(tets).for_each(|(own, nodes)| *own = mask(nodes.map(label)));
        self.edges.slots.resize(topology.edges.len(), NONE);
        let edges = topology.edges.par_iter().with_min_len(PART);
        let cut = |&[a, b]: &[u32; 2]| if label(a) == label(b) { NONE } else { 0 };
        self.edges.slots.par_iter_mut().zip(edges).for_each(|(slot, edge)| *slot = cut(edge));
        self.faces.clear(topology.faces.len());
        self.tets.clear(lattice.tets.len());
        for (tet, &mask) in self.masks.iter().enumerate().filter(|(_, mask)| MANY[**mask as usize]) {
            let faces = topology.tet_faces[tet].iter().zip(FACE_MASKS);
            faces.filter(|(_, face)| mask & face == *face).for_each(|(&face, _)| self.faces.mark(face));
            if mask == ALL_CUT {
                self.tets.mark(tet as u32);
            }
        }
        self.edges.number();
        self.faces.number();
        self.tets.number();
    }
}

/// [`Points::find`] into fresh memory.
pub fn crack_points(
    lattice: &Lattice,
    topology: &Topology,
    labels: &[u32],
    sites: Option<Sites<'_>>,
    fixed: &FixedPoints,
) -> Result<Points, TessellationError> {
    let mut points = Points::default();
    points.find(lattice, topology, labels, sites, fixed)?;
    Ok(points)
}

fn check(sites: &Sites<'_>, fragments: usize) -> Result<(), TessellationError> {
    let count = sites.coordinates.len() / sites.lift.dimension;
    let known = |fragment: &usize| sites.of_fragment.get(*fragment).is_some_and(|&site| (site as usize) < count);
    match (0..fragments).find(|fragment| !known(fragment)) {
        Some(fragment) => Err(TessellationError::Site { fragment }),
        None => Ok(()),
    }
}

struct Finder<'a> {
    lattice: &'a Lattice,
    labels: &'a [u32],
    sites: Option<Sites<'a>>,
}

impl Finder<'_> {
    fn edge(&self, nodes: [u32; 2]) -> Point3<f64> {
        let [a, b] = self.labels_of(nodes);
        let [from, to] = nodes.map(|node| self.lattice.nodes[node as usize]);
        let margin = edge_margin((to - from).norm());
        let weights = self.sites.map_or([0.5; 2], |sites| on_edge(sites.preferences(nodes, a, b), margin));
        self.combine(nodes, weights)
    }

    fn face(&self, nodes: [u32; 3]) -> Point3<f64> {
        let [a, b, c] = self.labels_of(nodes);
        let solve = |sites: Sites<'_>| on_face([b, c].map(|other| sites.preferences(nodes, a, other)));
        self.combine(nodes, self.sites.map_or([1.0 / 3.0; 3], solve))
    }

    fn tet(&self, nodes: [u32; 4]) -> Point3<f64> {
        let [a, b, c, d] = self.labels_of(nodes);
        let solve = |sites: Sites<'_>| in_tet([b, c, d].map(|other| sites.preferences(nodes, a, other)));
        self.combine(nodes, self.sites.map_or([0.25; 4], solve))
    }

    fn labels_of<const N: usize>(&self, nodes: [u32; N]) -> [u32; N] {
        nodes.map(|node| self.labels[node as usize])
    }

    /// The point with barycentric coordinates `weights`, from the first node on, so that it stays in its simplex.
    fn combine<const N: usize>(&self, nodes: [u32; N], weights: [f64; N]) -> Point3<f64> {
        let base = self.lattice.nodes[nodes[0] as usize];
        let offset: Vector3<f64> = (1..N).map(|k| (self.lattice.nodes[nodes[k] as usize] - base) * weights[k]).sum();
        base + offset
    }
}
