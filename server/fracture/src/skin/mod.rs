//! The input's own triangles and how they look: what fragments wear, so that nothing pops when the object breaks.
//!
//! [`Skin`] is prepared once per object: the triangles, fine enough for the crack lattice, and where their corners lie in it.
//! [`clip`] cuts them by fragments. [`BoundaryAttributes`] carries their looks to the lattice's own boundary.

mod boundary_attributes;
mod clipped_surface;
mod normals;
mod refine;
mod walls;

#[cfg(test)]
mod tests;

pub use boundary_attributes::BoundaryAttributes;
pub use clipped_surface::{BlendedVertex, ClippedSurface, clip};

use crate::lattice::{Lattice, LatticePoint, Locator, area_vector};
use crate::memory::held;
use crate::surface::Surface;
use nalgebra::Point3;
use rayon::prelude::*;
use refine::RefinedCorner;
use std::collections::HashMap;

/// Longest edges of a skin, in spacings of the crack lattice: as far as the nodes of its boundary are from one another. With edges of one
/// spacing, a tip between them is worn by the neighbors, up to 3 spacings from what the fragment itself wears (3 of 48 strikes on a block;
/// with 0.7, 1.2 spacings in one).
const EDGE_SPACINGS: f64 = 0.7;

/// Where a point of the skin lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinPoint {
    /// In which body.
    pub body: u32,
    /// In its crack lattice; for a point outside, the nearest one of its boundary.
    pub place: LatticePoint,
}

/// A point and how it looks from one of its triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinCorner {
    /// Index into [`Skin::points`].
    pub point: u32,
    /// Of length one.
    pub normal: [f32; 3],
    /// Zero where the file has none.
    pub uv: [f32; 2],
}

/// The surface of the input as it looks, mended and outward-facing, local.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// Points, each once.
    pub points: Vec<Point3<f64>>,
    /// Where they lie.
    pub spots: Vec<SkinPoint>,
    /// Points as triangles see them.
    pub vertices: Vec<SkinCorner>,
    /// Indices into `vertices`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Material of each triangle; empty if the file has none.
    pub materials: Vec<u32>,
    /// True if the file has texture coordinates.
    pub textured: bool,
}

impl Skin {
    /// The skin of `surface` on crack lattices of that spacing. Triangles with edges longer than 0.7 of it are
    /// divided: a crack that bends within one could not be followed.
    pub fn of(surface: &Surface, lattices: &[&Lattice], spacing: f64) -> Self {
        let corners = corners(surface);
        let (points, corners, sources) = refine::refine(surface, corners, EDGE_SPACINGS * spacing);
        let looks = &surface.looks;
        let materials = match looks.materials.is_empty() {
            true => Vec::new(),
            false => sources.iter().map(|&triangle| looks.materials[triangle as usize]).collect(),
        };
        let (vertices, triangles) = shared(&corners);
        let spots = spots(&points, lattices);
        Self { points, spots, vertices, triangles, materials, textured: !looks.uvs.is_empty() }
    }

    /// The three corners of triangle `triangle`, local.
    pub fn corners(&self, triangle: usize) -> [Point3<f64>; 3] {
        self.triangles[triangle].map(|vertex| self.points[self.vertices[vertex as usize].point as usize])
    }

    /// What one fragment wears, as a skin of its own: its vertices are points each, those on borders where a neighbor within
    /// the fragment lies.
    pub fn part(&self, clipped: &ClippedSurface) -> Self {
        let mut part = Self { textured: self.textured, triangles: clipped.triangles.clone(), ..Self::default() };
        for (point, blend) in clipped.vertices.iter().enumerate() {
            let (place, normal, uv) = blend.of(self);
            part.points.push(place);
            part.spots.push(self.spots[self.vertices[blend.home as usize].point as usize]);
            part.vertices.push(SkinCorner { point: point as u32, normal, uv });
        }
        if !self.materials.is_empty() {
            part.materials = clipped.sources.iter().map(|&source| self.materials[source as usize]).collect();
        }
        part
    }

    /// Bytes that it holds.
    pub fn bytes(&self) -> usize {
        let Self { points, spots, vertices, triangles, materials, textured: _ } = self;
        held(points) + held(spots) + held(vertices) + held(triangles) + held(materials)
    }
}

/// Points and looks of all corners of the surface. Normals that the file does not have are those of the triangles around; those that
/// point inwards are turned.
fn corners(surface: &Surface) -> Vec<[RefinedCorner; 3]> {
    let looks = &surface.looks;
    let creased = if looks.normals.is_empty() { normals::creased(surface) } else { Vec::new() };
    let of = |triangle: usize| {
        let normals = if creased.is_empty() { outward(surface, triangle) } else { creased[triangle] };
        let uvs = looks.uvs.get(triangle).copied().unwrap_or([[0.0; 2]; 3]);
        let points = surface.triangles[triangle];
        [0, 1, 2].map(|k| RefinedCorner { point: points[k], normal: normals[k], uv: uvs[k] })
    };
    (0..surface.triangles.len()).map(of).collect()
}

/// The file's normals of a triangle, on its outer side: files whose triangles had to be turned mean the other one.
fn outward(surface: &Surface, triangle: usize) -> [[f32; 3]; 3] {
    let area = area_vector(&surface.corners(triangle));
    let own = surface.looks.normals[triangle];
    let along: f64 = own.iter().map(|normal| (0..3).map(|k| f64::from(normal[k]) * area[k]).sum::<f64>()).sum();
    if along < 0.0 { own.map(|normal| normal.map(|x| -x)) } else { own }
}

/// Corners that are alike in everything become one vertex.
fn shared(corners: &[[RefinedCorner; 3]]) -> (Vec<SkinCorner>, Vec<[u32; 3]>) {
    let mut vertices: Vec<SkinCorner> = Vec::new();
    let mut places: HashMap<(u32, [u32; 3], [u32; 2]), u32> = HashMap::new();
    let mut place = |corner: &RefinedCorner| {
        let RefinedCorner { point, normal, uv } = *corner;
        *places.entry((point, normal.map(f32::to_bits), uv.map(f32::to_bits))).or_insert_with(|| {
            vertices.push(SkinCorner { point, normal, uv });
            vertices.len() as u32 - 1
        })
    };
    let triangles = corners.iter().map(|own| own.each_ref().map(&mut place)).collect();
    (vertices, triangles)
}

/// Where the points lie: in the first body that holds them, or else on the nearest one's boundary.
fn spots(points: &[Point3<f64>], lattices: &[&Lattice]) -> Vec<SkinPoint> {
    let locators: Vec<Locator> = lattices.iter().map(|lattice| Locator::new(lattice)).collect();
    let boxes: Vec<[Point3<f64>; 2]> = lattices.iter().map(|lattice| bounds(lattice)).collect();
    let spot = |point: &Point3<f64>| {
        let holds = |body: &usize| apart(point, &boxes[*body]) == 0.0;
        let inside = (0..lattices.len())
            .filter(holds)
            .find_map(|body| Some(SkinPoint { body: body as u32, place: locators[body].containing(point, None)? }));
        inside.or_else(|| nearest(point, &locators, &boxes)).unwrap_or(NOWHERE)
    };
    points.par_iter().map(spot).collect()
}

/// Where everything lies in an object without lattices.
const NOWHERE: SkinPoint = SkinPoint { body: 0, place: LatticePoint { tet: 0, barycentric: [1.0, 0.0, 0.0, 0.0] } };

fn nearest(point: &Point3<f64>, locators: &[Locator], boxes: &[[Point3<f64>; 2]]) -> Option<SkinPoint> {
    let mut best: Option<(f64, usize)> = None;
    for (body, locator) in locators.iter().enumerate() {
        if best.is_none_or(|(least, _)| apart(point, &boxes[body]) < least) {
            let distance = locator.nearest(point).map_or(f64::INFINITY, |found| found.distance);
            if best.is_none_or(|(least, _)| distance < least) {
                best = Some((distance, body));
            }
        }
    }
    let (_, body) = best?;
    Some(SkinPoint { body: body as u32, place: locators[body].place(point, None)? })
}

fn bounds(lattice: &Lattice) -> [Point3<f64>; 2] {
    let first = lattice.nodes.first().copied().unwrap_or_else(Point3::origin);
    lattice.nodes.iter().fold([first; 2], |[low, high], node| [low.inf(node), high.sup(node)])
}

/// Distance of a point from a box.
fn apart(point: &Point3<f64>, [low, high]: &[Point3<f64>; 2]) -> f64 {
    let axis = |k: usize| (low[k] - point[k]).max(point[k] - high[k]).max(0.0);
    (axis(0).powi(2) + axis(1).powi(2) + axis(2).powi(2)).sqrt()
}
