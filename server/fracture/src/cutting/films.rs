//! Closes the holes of a surface by films: the triangulations of least area of their rims.
//!
//! Based on: G. Barequet, M. Sharir, *Filling gaps in the boundary of a polyhedron* (1995): least area by dynamic
//! programming.

use crate::lattice::area_vector;
use crate::surface::Surface;
use nalgebra::Point3;
use std::collections::HashMap;

/// Largest number of vertices of a rim. The work grows with its third power.
const RIM_MAX: usize = 512;

/// Largest area of a film, as a share of the surface's area: a box may lack a side.
const AREA_MAX: f64 = 0.25;

/// A surface whose holes are closed.
#[derive(Debug)]
pub(super) struct FilledSurface {
    /// The surface, followed by the triangles of the films. These have the attributes of the triangle at the rim.
    pub surface: Surface,
    /// Area of the films, local.
    pub area: f64,
    /// A vertex of each film, local.
    pub places: Vec<Point3<f64>>,
}

/// `surface` with films over its holes; `None` if it has no hole that a film can close.
pub(super) fn filled(surface: &Surface) -> Option<FilledSurface> {
    let sides = Sides::new(&surface.triangles);
    let rims = sides.rims();
    if rims.is_empty() {
        return None;
    }
    let total: f64 = (0..surface.triangles.len()).map(|own| area_vector(&surface.corners(own)).norm()).sum();
    let mut filled = FilledSurface { surface: surface.clone(), area: 0.0, places: Vec::new() };
    for rim in rims {
        let Some(film) = film(&rim.vertices, &surface.positions, &sides) else { continue };
        let corners = |own: &[u32; 3]| own.map(|vertex| surface.positions[vertex as usize]);
        let area: f64 = film.iter().map(|own| area_vector(&corners(own)).norm()).sum();
        if area > AREA_MAX * total {
            continue;
        }
        film.iter().for_each(|own| push(&mut filled.surface, *own, rim.triangle));
        filled.area += area;
        filled.places.push(surface.positions[rim.vertices[0] as usize]);
    }
    (!filled.places.is_empty()).then_some(filled)
}

/// Adds a triangle with the attributes of triangle `like`, flat.
fn push(surface: &mut Surface, triangle: [u32; 3], like: usize) {
    let normal = area_vector(&triangle.map(|vertex| surface.positions[vertex as usize]));
    let normal = normal.try_normalize(0.0).unwrap_or_default().map(|x| x as f32);
    let attributes = &mut surface.attributes;
    if !attributes.normals.is_empty() {
        attributes.normals.push([normal.into(); 3]);
    }
    if let Some(&uvs) = attributes.uvs.get(like) {
        attributes.uvs.push([uvs[0]; 3]);
    }
    if let Some(&material) = attributes.materials.get(like) {
        attributes.materials.push(material);
    }
    surface.faces.push(surface.faces[like]);
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
    corners: Vec<[u32; 3]>,
}

impl Sides {
    fn new(triangles: &[[u32; 3]]) -> Self {
        let sides = |(own, &[a, b, c]): (u32, &[u32; 3])| [[a, b], [b, c], [c, a]].map(|edge| (edge, own));
        Self { triangles: (0..).zip(triangles).flat_map(sides).collect(), corners: triangles.to_vec() }
    }

    fn is_open(&self, [a, b]: [u32; 2]) -> bool {
        !self.triangles.contains_key(&[b, a])
    }

    /// The open edge that follows `edge` around its end, through the triangles there.
    fn next(&self, [a, b]: [u32; 2]) -> Option<[u32; 2]> {
        let mut edge = [a, b];
        for _ in 0..self.corners.len() {
            let corners = self.corners[*self.triangles.get(&edge)? as usize];
            let own = corners.iter().position(|&corner| corner == b)?;
            let onward = [b, corners[(own + 1) % 3]];
            if self.is_open(onward) {
                return Some(onward);
            }
            edge = [onward[1], b];
        }
        None
    }

    /// All closed loops of open edges, by their lowest edge.
    fn rims(&self) -> Vec<Rim> {
        let mut open: Vec<[u32; 2]> = self.triangles.keys().copied().filter(|edge| self.is_open(*edge)).collect();
        open.sort_unstable();
        let mut is_done: HashMap<[u32; 2], bool> = open.iter().map(|edge| (*edge, false)).collect();
        let mut rims = Vec::new();
        for first in open {
            let mut vertices = Vec::new();
            let mut edge = Some(first);
            while let Some(own) = edge
                && is_done.insert(own, true) == Some(false)
            {
                vertices.push(own[0]);
                edge = self.next(own);
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
