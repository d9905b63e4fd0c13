//! Closes the holes of a surface by films: the triangulations of least area of their rims.
//!
//! Based on: G. Barequet, M. Sharir, *Filling gaps in the boundary of a polyhedron* (1995): least area by dynamic
//! programming.

use super::slits::{close_slits, is_slit};
use super::surface_repair::{RepairKind, SurfaceRepair};
use crate::lattice::area_vector;
use crate::surface::{DefectKind, Surface};
use nalgebra::{Point3, Vector3};
use std::collections::{BTreeMap, HashMap};
use std::f64::consts::TAU;

/// Largest number of vertices of a rim. The work grows with its third power.
const RIM_MAX: usize = 512;

/// Largest area of a film, as a share of the surface's area: a box may lack a side.
const AREA_MAX: f64 = 0.25;

/// Angle at the end of a slit by which its sides may overlap.
const SLIT_ANGLE: f64 = 0.05;

/// A surface whose holes are closed by films, as far as these are small enough.
#[derive(Debug)]
pub struct FilledSurface {
    /// The surface, followed by the triangles of the films. These have the attributes of the triangle at the rim.
    pub surface: Surface,
    /// Repairs; empty if the surface has no hole that a film can close.
    pub repairs: Vec<SurfaceRepair>,
    /// Number of triangles before the films.
    pub(super) input_triangles: usize,
}

impl FilledSurface {
    /// The surface itself.
    pub fn unchanged(surface: Surface) -> Self {
        let input_triangles = surface.triangles.len();
        Self { surface, repairs: Vec::new(), input_triangles }
    }

    /// `surface` with films over its holes.
    pub fn new(surface: Surface) -> Self {
        let sides = Sides::new(&surface);
        let rims = sides.rims(&surface.positions);
        let mut filled = Self::unchanged(surface);
        filled.report_duplicates();
        if !rims.is_empty() {
            filled.fill(&rims, &sides);
        }
        filled
    }

    fn report_duplicates(&mut self) {
        let (surface, duplicates) = (&self.surface, &self.surface.duplicates);
        if !duplicates.places.is_empty() {
            let whole = surface.area(self.input_triangles) + duplicates.area;
            let repair = SurfaceRepair::new(RepairKind::DuplicateTriangles, &duplicates.places, &surface.frame);
            self.repairs.push(repair.of_area(duplicates.area, whole, &surface.frame));
        }
    }

    fn fill(&mut self, rims: &[Rim], sides: &Sides) {
        let surface = &mut self.surface;
        let total = surface.area(self.input_triangles);
        let (mut added, mut holes, mut slits) = (0.0, Vec::new(), Vec::new());
        for rim in rims {
            let Some(film) = film(&rim.vertices, &surface.positions, sides) else { continue };
            let corners = |own: &[u32; 3]| own.map(|vertex| surface.positions[vertex as usize]);
            let area: f64 = film.iter().map(|own| area_vector(&corners(own)).norm()).sum();
            if area > AREA_MAX * total {
                continue;
            }
            let place = surface.positions[rim.vertices[0] as usize];
            let is_slit = film.iter().all(|own| is_slit(&corners(own)));
            (if is_slit { &mut slits } else { &mut holes }).push(place);
            film.iter().for_each(|own| push(surface, *own, rim.triangle));
            added += area;
        }
        if holes.is_empty() && slits.is_empty() {
            return;
        }
        close_slits(surface, self.input_triangles);
        surface.closed = surface.is_balanced();
        let closed = (holes.len() + slits.len()) as u64;
        for defect in surface.defects.iter_mut().filter(|defect| defect.kind == DefectKind::Holes) {
            defect.action = match (slits.is_empty(), closed < defect.count) {
                (true, false) => "closed by films of least area",
                (false, false) => "closed by films of least area; slits by dividing the triangle beyond",
                _ => "closed by films where these are small, else where the winding number is one half",
            }
            .to_owned();
        }
        for (kind, area, places) in [(RepairKind::FilledHoles, added, holes), (RepairKind::DividedEdges, 0.0, slits)] {
            if !places.is_empty() {
                let repair = SurfaceRepair::new(kind, &places, &surface.frame);
                self.repairs.push(repair.of_area(area, total + added, &surface.frame));
            }
        }
    }
}

/// Adds a triangle with the attributes of triangle `like`, flat.
fn push(surface: &mut Surface, triangle: [u32; 3], like: usize) {
    let normal = area_vector(&triangle.map(|vertex| surface.positions[vertex as usize]));
    let normal = normal.try_normalize(0.0).unwrap_or_default().map(|x| x as f32);
    let attributes = &mut surface.attributes;
    if !attributes.normals.is_empty() {
        attributes.normals.push([normal.into(); 3]);
    }
    for set in [&mut attributes.uvs, &mut attributes.uvs2] {
        if let Some(&uvs) = set.get(like) {
            set.push([uvs[0]; 3]);
        }
    }
    if let Some(&colors) = attributes.colors.get(like) {
        attributes.colors.push([colors[0]; 3]);
    }
    if let Some(&material) = attributes.materials.get(like) {
        attributes.materials.push(material);
    }
    surface.faces.push(surface.faces[like]);
    surface.solids.push(surface.solids[like]);
    surface.triangles.push(triangle);
}

/// Closed loop of open edges.
struct Rim {
    /// Vertices, in the direction of the missing triangles.
    vertices: Vec<u32>,
    /// Triangle at its first edge.
    triangle: usize,
}

/// Triangles by their directed edges.
struct Sides {
    triangles: HashMap<[u32; 2], u32>,
    /// Sum of the area vectors of the triangles around each vertex.
    normals: HashMap<u32, Vector3<f64>>,
}

impl Sides {
    fn new(surface: &Surface) -> Self {
        let sides = |(own, &[a, b, c]): (u32, &[u32; 3])| [[a, b], [b, c], [c, a]].map(|edge| (edge, own));
        let mut normals: HashMap<u32, Vector3<f64>> = HashMap::new();
        for own in 0..surface.triangles.len() {
            let area = area_vector(&surface.corners(own));
            surface.triangles[own].iter().for_each(|&vertex| *normals.entry(vertex).or_default() += area);
        }
        Self { triangles: (0..).zip(&surface.triangles).flat_map(sides).collect(), normals }
    }

    fn is_open(&self, [a, b]: [u32; 2]) -> bool {
        !self.triangles.contains_key(&[b, a])
    }

    /// The open edge that follows `edge` around the hole. Several may begin at its end: the first in the sense in which one
    /// turns from the edge back over the hole follows.
    fn next(&self, [a, b]: [u32; 2], open: &BTreeMap<u32, Vec<u32>>, positions: &[Point3<f64>]) -> Option<[u32; 2]> {
        let onward = open.get(&b)?;
        if let [only] = onward[..] {
            return Some([b, only]);
        }
        let at = |vertex: u32| positions[vertex as usize];
        let normal = self.normals.get(&b)?.try_normalize(0.0)?;
        let back = at(a) - at(b);
        let angle = |&vertex: &u32| {
            let own = at(vertex) - at(b);
            let angle = normal.dot(&back.cross(&own)).atan2(back.dot(&own) - normal.dot(&back) * normal.dot(&own));
            // A slit has no width, or a negative one.
            if angle > -SLIT_ANGLE { angle } else { angle + TAU }
        };
        onward.iter().min_by(|one, other| angle(one).total_cmp(&angle(other))).map(|&vertex| [b, vertex])
    }

    /// All closed loops of open edges, by their lowest edge.
    fn rims(&self, positions: &[Point3<f64>]) -> Vec<Rim> {
        let mut open: Vec<[u32; 2]> = self.triangles.keys().copied().filter(|edge| self.is_open(*edge)).collect();
        open.sort_unstable();
        let mut onward: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        open.iter().for_each(|[from, to]| onward.entry(*from).or_default().push(*to));
        let mut is_done: HashMap<[u32; 2], bool> = open.iter().map(|edge| (*edge, false)).collect();
        let mut rims = Vec::new();
        for first in open {
            let mut vertices = Vec::new();
            let mut edge = Some(first);
            while let Some(own) = edge
                && is_done.insert(own, true) == Some(false)
            {
                vertices.push(own[0]);
                edge = self.next(own, &onward, positions);
            }
            if edge == Some(first) && vertices.len() > 2 {
                vertices.reverse();
                rims.push(Rim { vertices, triangle: self.triangles[&first] as usize });
            }
        }
        rims
    }
}

/// Triangulation of least area of a rim; `None` if every one repeats an edge of the surface, or the rim is too long.
fn film(rim: &[u32], positions: &[Point3<f64>], sides: &Sides) -> Option<Vec<[u32; 3]>> {
    let count = rim.len();
    if count > RIM_MAX {
        return None;
    }
    let is_free = |i: usize, j: usize| {
        let [a, b] = [rim[i], rim[j]];
        a != b && !sides.triangles.contains_key(&[a, b]) && !sides.triangles.contains_key(&[b, a])
    };
    let is_rim = |i: usize, j: usize| j == i + 1 || i == 0 && j + 1 == count;
    let at = |i: usize| positions[rim[i] as usize];
    // Least area of the polygon from vertex i to vertex j, and the vertex that splits it.
    let mut best = vec![(0.0_f64, 0_usize); count * count];
    for span in 2..count {
        for i in 0..count - span {
            let j = i + span;
            let mut least = (f64::INFINITY, 0);
            if is_rim(i, j) || is_free(i, j) {
                for k in i + 1..j {
                    let rest = best[i * count + k].0 + best[k * count + j].0;
                    if rest < least.0 {
                        let area = rest + area_vector(&[at(i), at(k), at(j)]).norm();
                        if area < least.0 {
                            least = (area, k);
                        }
                    }
                }
            }
            best[i * count + j] = least;
        }
    }
    if best[count - 1].0 == f64::INFINITY {
        return None;
    }
    let (mut film, mut pending) = (Vec::with_capacity(count - 2), vec![(0, count - 1)]);
    while let Some((i, j)) = pending.pop() {
        if j > i + 1 {
            let k = best[i * count + j].1;
            film.push([rim[i], rim[k], rim[j]]);
            pending.extend([(i, k), (k, j)]);
        }
    }
    Some(film)
}
