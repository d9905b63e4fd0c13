//! Convex proxies of the fragments for collisions, if they are asked for.
//!
//! Ours. The convex hull of a fragment holds all of it, and whatever of its neighbors lies in its hollows; two such hulls overlap
//! and fly apart at the first step of a simulation. So a hull is made around what is left of the fragment within the mean planes
//! of its cracks, which both neighbors share. A plane moves outwards until no more than a small share of the fragment lies beyond
//! it, and all of them further until the hull holds enough: of the margins that can be had with that much, this is about the least.
//! Curved walls need more faces than there are: what the hull then cuts off between its corners is halved by corners that stand out of
//! the outer surface as far.

use crate::cancel_token::{CancelToken, Cancelled};
use crate::hull::{ClosedTriangles, ConvexHull, Plane, bounds, clipped, meet};
use crate::lattice::Lattice;
use crate::pipeline::workspace::body_meshes::BodyMeshes;
use crate::tessellation::{FragmentRange, RunRange, Tessellation, Transform};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// What a hull holds of its fragment's volume where that can be had.
pub const HULL_COVERAGE: f64 = 0.9;

/// Shares of a fragment that may lie beyond the plane of one crack, one after the other until the hull holds enough; at last the
/// planes are left out.
const SHARES: [f64; 5] = [0.03, 0.01, 0.003, 0.001, 0.0];

/// A crack whose mean area vector is shorter than this, over its area, folds too much to be told by a plane.
const FOLDED: f64 = 0.5;

/// The hull of one fragment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HullRow {
    /// First vertex in [`FragmentHulls::positions`].
    pub vertex_first: u32,
    /// Number of vertices; zero for a fragment too flat for a hull.
    pub vertex_count: u32,
    /// First index in [`FragmentHulls::indices`].
    pub index_first: u32,
    /// Number of indices, three per triangle.
    pub index_count: u32,
    /// Volume of the part of the fragment inside the hull over that of the fragment.
    pub coverage: f64,
    /// The deepest that the surface of any other fragment lies below the hull's surface, m; at most a thousandth of the hull's
    /// diagonal too large, never too small.
    pub margin_m: f64,
}

/// The hulls of all fragments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FragmentHulls {
    /// One per fragment.
    pub rows: Vec<HullRow>,
    /// Relative to the fragment's center of mass, m.
    pub positions: Vec<[f32; 3]>,
    /// Relative to the hull's first vertex, counter-clockwise seen from outside.
    pub indices: Vec<u32>,
}

impl FragmentHulls {
    /// Bytes of the tables.
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

/// What a hull is made of, local.
struct Part {
    shell: ClosedTriangles,
    /// The first points, on the outside.
    outer: usize,
    bounds: [Point3<f64>; 2],
    cracks: Vec<Crack>,
}

/// The mean plane of a crack, and how far the fragment's nodes lie beyond it: ascending, those alone that do.
struct Crack {
    plane: Plane,
    beyond: Vec<f64>,
    nodes: usize,
}

/// A hull, and what has become of it.
struct Fitted {
    hull: ConvexHull,
    coverage: f64,
    depth: f64,
}

impl FragmentHulls {
    /// The hulls of all fragments of `bodies`, the same for any number of threads. `lattices`: those that the bodies were cut on.
    pub(in crate::pipeline) fn fit(
        bodies: &[BodyMeshes],
        lattices: &[&Lattice],
        transform: Transform,
        token: &CancelToken,
    ) -> Result<Self, Cancelled> {
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

/// The parts of one body, by fragment.
fn parts(pieces: &BodyMeshes, lattice: &Lattice) -> Vec<Part> {
    let fragments = pieces.tessellation.fragments();
    let mut nodes = vec![Vec::new(); fragments.len()];
    for (&label, node) in pieces.labels.iter().zip(&lattice.nodes) {
        // Fragments that are not answered come last.
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

/// The plane through a crack's centroid across its mean area vector, out of the run's fragment: the same from both sides. `None`
/// where the crack folds.
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
    /// Its plane, outwards until at most this share of the fragment lies beyond it.
    fn moved(&self, share: f64) -> Plane {
        let left_out = (share * self.nodes as f64) as usize;
        let last = self.beyond.len().checked_sub(left_out + 1);
        let offset = last.map_or(0.0, |last| self.beyond[last]);
        Plane { offset: self.plane.offset + offset, ..self.plane }
    }
}

/// The hull of part `own`. `None` where the part is flat.
fn fit(parts: &[Part], own: usize) -> Option<Fitted> {
    let mut best = parts[own].fit()?;
    let reach = bounds(&best.hull.vertices);
    let others = parts.iter().enumerate().filter(|(other, part)| *other != own && meet(&part.bounds, &reach));
    best.depth = best.hull.depth(others.map(|(_, part)| &part.shell));
    Some(best)
}

impl Part {
    /// The first hull that holds enough, else the one that holds most; its depth is still to be measured.
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

    /// The hull of what is left of `shell` within the planes of the cracks; `None`: without them.
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
