//! Convex collision proxies of the fragments, computed with the effect `hulls`.
//!
//! The method is ours. The convex hull of a concave fragment also contains parts of its neighbors. Two such hulls
//! overlap, and a simulation pushes them apart in its first step. A proxy is therefore the hull of only a part of the
//! fragment, inside the mean planes of its cracks. Neighbors share these planes. Each plane moves outward until at most
//! a small share of the fragment is beyond it. That share decreases until the hull covers enough. The overlap is then
//! about the smallest possible with this coverage.
//!
//! Curved outer walls need more faces than a hull may have, so the hull cuts off parts between its vertices. Moving
//! the points of the outer surface outward by half the depth of these parts halves the depth.

use crate::cancel_token::{CancelToken, Canceled};
use crate::hull::{ClosedTriangles, ConvexHull, Plane, bounds, clipped, meet};
use crate::lattice::Lattice;
use crate::pipeline::workspace::body_meshes::BodyMeshes;
use crate::tessellation::{FragmentRange, LocalToMeters, RunRange, Tessellation};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Target share of the fragment's volume inside its hull.
pub const HULL_COVERAGE: f64 = 0.9;

/// Shares of a fragment that may lie beyond the plane of a crack, tried in order until the hull covers enough.
///
/// The last attempt uses no planes.
const SHARES: [f64; 5] = [0.03, 0.01, 0.003, 0.001, 0.0];

/// Smallest ratio of a crack's mean area vector to its area. Below, the crack folds too much for a plane.
const FOLDED: f64 = 0.5;

/// The hull of one fragment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HullRow {
    /// First vertex in [`FragmentHulls::positions`].
    pub vertex_first: u32,
    /// Number of vertices; 0 for a fragment too flat for a hull.
    pub vertex_count: u32,
    /// First index in [`FragmentHulls::indices`].
    pub index_first: u32,
    /// Number of indices, three per triangle.
    pub index_count: u32,
    /// Share of the fragment's volume inside the hull.
    pub coverage: f64,
    /// Largest depth of the surface of any other fragment below the hull's surface, m.
    ///
    /// Overestimated by at most a thousandth of the hull's diagonal, never underestimated.
    pub margin_m: f64,
}

/// The hulls of all fragments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FragmentHulls {
    /// Rows, one per fragment.
    pub rows: Vec<HullRow>,
    /// Vertices relative to the fragment's center of mass, m.
    pub positions: Vec<[f32; 3]>,
    /// Vertex indices relative to the hull's first vertex, counter-clockwise seen from outside.
    pub indices: Vec<u32>,
}

impl FragmentHulls {
    /// Size of the tables in bytes.
    pub(in crate::pipeline) fn bytes(&self) -> usize {
        size_of_val(self.rows.as_slice())
            + size_of_val(self.positions.as_slice())
            + size_of_val(self.indices.as_slice())
    }

    fn push(&mut self, own: &Fitted, place: impl Fn(&Point3<f64>) -> [f32; 3], meter: f64) {
        self.rows.push(HullRow {
            vertex_first: self.positions.len() as u32,
            vertex_count: own.hull.vertices.len() as u32,
            index_first: self.indices.len() as u32,
            index_count: 3 * own.hull.triangles.len() as u32,
            coverage: own.coverage,
            margin_m: own.depth * meter,
        });
        self.positions.extend(own.hull.vertices.iter().map(place));
        self.indices.extend_from_slice(own.hull.triangles.as_flattened());
    }
}

/// Input of one hull, local.
struct Part {
    shell: ClosedTriangles,
    /// Number of the first points, which lie on the outer surface.
    outer: usize,
    bounds: [Point3<f64>; 2],
    cracks: Vec<Crack>,
}

/// The mean plane of a crack, and the distances of the fragment's nodes beyond it, ascending.
struct Crack {
    plane: Plane,
    beyond: Vec<f64>,
    nodes: usize,
}

/// A hull with its measures.
struct Fitted {
    hull: ConvexHull,
    coverage: f64,
    depth: f64,
}

impl FragmentHulls {
    /// The hulls of all fragments of `bodies`, independent of the number of threads. `lattices` are those that the
    /// bodies were cut on.
    pub(in crate::pipeline) fn fit(
        bodies: &[BodyMeshes],
        lattices: &[&Lattice],
        transform: LocalToMeters,
        token: &CancelToken,
    ) -> Result<Self, Canceled> {
        let parts: Vec<Part> =
            bodies.iter().zip(lattices).flat_map(|(pieces, lattice)| parts(pieces, lattice)).collect();
        let fit = |own: usize| token.check().map(|()| fit(&parts, own));
        let fitted: Vec<Option<Fitted>> = (0..parts.len()).into_par_iter().map(fit).collect::<Result<_, _>>()?;
        let meter = transform.meters_per_unit;
        let mut hulls = Self::default();
        let centers = bodies.iter().flat_map(|pieces| &pieces.properties).map(|own| own.center);
        for (own, center) in fitted.iter().zip(centers) {
            let place = |vertex: &Point3<f64>| ((vertex - center) * meter).map(|x| x as f32).into();
            match own {
                Some(own) => hulls.push(own, place, meter),
                None => hulls.rows.push(HullRow {
                    vertex_first: hulls.positions.len() as u32,
                    index_first: hulls.indices.len() as u32,
                    ..HullRow::default()
                }),
            }
        }
        Ok(hulls)
    }
}

/// The inputs of one body's hulls, by fragment.
fn parts(pieces: &BodyMeshes, lattice: &Lattice) -> Vec<Part> {
    let fragments = pieces.tessellation.fragments();
    let mut nodes = vec![Vec::new(); fragments.len()];
    for (&label, node) in pieces.labels.iter().zip(&lattice.nodes) {
        // Fragments that are not part of the result come last.
        if let Some(own) = nodes.get_mut(label as usize) {
            own.push(*node);
        }
    }
    fragments.par_iter().zip(&nodes).map(|(fragment, nodes)| part(&pieces.tessellation, fragment, nodes)).collect()
}

fn part(tessellation: &Tessellation, fragment: &FragmentRange, nodes: &[Point3<f64>]) -> Part {
    let runs = &tessellation.runs()[fragment.runs.clone()];
    let mut shell = ClosedTriangles::default();
    for run in runs {
        let first = shell.points.len() as u32;
        shell.points.extend_from_slice(tessellation.run_vertices(run));
        shell.triangles.extend(tessellation.run_triangles(run).map(|triangle| triangle.map(|point| first + point)));
    }
    let cracks = runs.iter().filter(|run| run.neighbor.is_some()).filter_map(|run| {
        let plane = mean_plane(tessellation, run)?;
        let mut beyond: Vec<f64> = nodes.iter().map(|node| plane.beyond(node)).filter(|beyond| *beyond > 0.0).collect();
        beyond.sort_unstable_by(f64::total_cmp);
        Some(Crack { plane, beyond, nodes: nodes.len() })
    });
    let cracks = cracks.collect();
    let outer = runs.first().filter(|run| run.neighbor.is_none()).map_or(0, |run| run.vertices.len());
    Part { bounds: bounds(&shell.points), shell, outer, cracks }
}

/// The plane through a crack's centroid orthogonal to its mean area vector, out of the run's fragment.
///
/// Equal from both sides. `None` if the crack folds.
fn mean_plane(tessellation: &Tessellation, run: &RunRange) -> Option<Plane> {
    let points = tessellation.run_vertices(run);
    let (mut area, mut mean, mut moment) = (0.0, Vector3::zeros(), Vector3::zeros());
    for triangle in tessellation.run_triangles(run) {
        let [a, b, c] = triangle.map(|point| points[point as usize]);
        let vector = (b - a).cross(&(c - a));
        let own = vector.norm();
        (area, mean) = (area + own, mean + vector);
        moment += (a.coords + b.coords + c.coords) * (own / 3.0);
    }
    let flat = mean.norm() > FOLDED * area;
    flat.then(|| Plane::at(&Point3::from(moment / area), mean)).flatten()
}

impl Crack {
    /// The plane, moved outward until at most this share of the fragment is beyond it.
    fn moved(&self, share: f64) -> Plane {
        let left_out = (share * self.nodes as f64) as usize;
        let last = self.beyond.len().checked_sub(left_out + 1);
        let offset = last.map_or(0.0, |last| self.beyond[last]);
        Plane { offset: self.plane.offset + offset, ..self.plane }
    }
}

/// The hull of part `own`; `None` if the part is flat.
fn fit(parts: &[Part], own: usize) -> Option<Fitted> {
    let mut best = parts[own].fit()?;
    let reach = bounds(&best.hull.vertices);
    let others = parts.iter().enumerate().filter(|(other, part)| *other != own && meet(&part.bounds, &reach));
    best.depth = best.hull.depth(others.map(|(_, part)| &part.shell));
    Some(best)
}

impl Part {
    /// The first hull that covers enough, else the one that covers most; its depth is measured later.
    fn fit(&self) -> Option<Fitted> {
        let mut best = self.tried(&self.shell, Some(SHARES[0]));
        if best.as_ref().is_some_and(Fitted::is_enough) {
            return best;
        }
        let cut_off = best.as_ref().map_or(0.0, |best| best.hull.left_out);
        let outset = self.shell.outset(self.outer, 0.5 * cut_off);
        let shares = SHARES.into_iter().filter(|_| !self.cracks.is_empty()).map(Some).chain([None]);
        for next in shares.filter_map(|share| self.tried(&outset, share)) {
            if best.as_ref().is_none_or(|best| next.coverage > best.coverage) {
                best = Some(next);
            }
            if best.as_ref().is_some_and(Fitted::is_enough) {
                break;
            }
        }
        best
    }

    /// The hull of the part of `shell` inside the planes of the cracks. `share` as in [`SHARES`]; `None`: no planes.
    fn tried(&self, shell: &ClosedTriangles, share: Option<f64>) -> Option<Fitted> {
        let planes = |share| self.cracks.iter().map(|crack| crack.moved(share)).collect();
        let planes: Vec<Plane> = share.map_or(Vec::new(), planes);
        let hull = ConvexHull::of(&clipped(shell, &planes))?;
        let coverage = hull.coverage(&self.shell);
        Some(Fitted { hull, coverage, depth: 0.0 })
    }
}

impl Fitted {
    fn is_enough(&self) -> bool {
        self.coverage >= HULL_COVERAGE
    }
}
