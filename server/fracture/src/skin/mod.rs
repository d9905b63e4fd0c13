//! Skin of an object: the input's triangles with their attributes. Fragments display it, so that breaking is not
//! visible by itself.
//!
//! [`Skin`] is prepared once per object: triangles refined to the crack lattice, and positions of their corners in it.
//! [`clip`] divides them among fragments. [`BoundaryAttributes`] transfers their attributes to the lattice's own
//! boundary.

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
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
pub(crate) use refine::RefinedCorner;
use std::collections::HashMap;

/// Longest edge of a skin, in spacings of the crack lattice; about the distance of its boundary nodes.
///
/// Chosen on 48 requests on a block. With edges of one spacing, a fragment's tip between skin points goes to the
/// neighbors, in 3 requests and up to 3 spacings from the fragment's own skin. With 0.7, this happens in 1 request, up
/// to 1.2 spacings away.
const EDGE_SPACINGS: f64 = 0.7;

/// Position of a skin point in the crack lattices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinPoint {
    /// Index of the body.
    pub body: u32,
    /// Position in its crack lattice; for a point outside, the nearest point of the boundary.
    pub place: LatticePoint,
}

/// A point with its attributes in some of its triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinCorner {
    /// Index into [`Skin::points`].
    pub point: u32,
    /// Unit normal.
    pub normal: [f32; 3],
    /// Texture coordinates; zero if the file has none.
    pub uv: [f32; 2],
}

/// Surface of the input with its attributes, repaired and facing outward, local.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// Points, without duplicates.
    pub points: Vec<Point3<f64>>,
    /// Position of each point in the crack lattices.
    pub spots: Vec<SkinPoint>,
    /// Points with attributes.
    pub vertices: Vec<SkinCorner>,
    /// Indices into `vertices`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Material of each triangle; empty if the file has none.
    pub materials: Vec<u32>,
    /// True if the file has texture coordinates.
    pub textured: bool,
}

impl Skin {
    /// The skin of `surface` on crack lattices of the given spacing, local.
    ///
    /// Triangles with edges longer than 0.7 spacings are divided, so that the skin can follow a crack that bends within
    /// one.
    pub fn of(surface: &Surface, lattices: &[&Lattice], spacing: f64) -> Self {
        let corners = surface_corners(surface);
        let (points, corners, sources) = refine::refine(surface, corners, EDGE_SPACINGS * spacing);
        let attributes = &surface.attributes;
        let materials = match attributes.materials.is_empty() {
            true => Vec::new(),
            false => sources.iter().map(|&triangle| attributes.materials[triangle as usize]).collect(),
        };
        let (vertices, triangles) = shared(&corners);
        let spots = spots(&points, lattices);
        Self { points, spots, vertices, triangles, materials, textured: !attributes.uvs.is_empty() }
    }

    /// The three corners of triangle `triangle`, local.
    pub fn corners(&self, triangle: usize) -> [Point3<f64>; 3] {
        self.triangles[triangle].map(|vertex| self.points[self.vertices[vertex as usize].point as usize])
    }

    /// The part of one fragment as a separate skin.
    ///
    /// Each of its vertices is a point. Points on the boundary take the lattice position of a neighboring point of the
    /// same fragment.
    pub fn part(&self, clipped: &ClippedSurface) -> Self {
        let mut part = Self { textured: self.textured, triangles: clipped.triangles.clone(), ..Self::default() };
        for (point, blend) in clipped.vertices.iter().enumerate() {
            let (place, normal, uv) = blend.of(self);
            part.points.push(place);
            part.spots.push(self.spots[self.vertices[blend.own_vertex as usize].point as usize]);
            part.vertices.push(SkinCorner { point: point as u32, normal, uv });
        }
        if !self.materials.is_empty() {
            part.materials = clipped.sources.iter().map(|&source| self.materials[source as usize]).collect();
        }
        part
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let Self { points, spots, vertices, triangles, materials, textured: _ } = self;
        held(points) + held(spots) + held(vertices) + held(triangles) + held(materials)
    }
}

/// Points and attributes of all corners of the surface.
///
/// Missing normals are computed from the surrounding triangles. Normals that point inward are reversed.
pub(crate) fn surface_corners(surface: &Surface) -> Vec<[RefinedCorner; 3]> {
    let attributes = &surface.attributes;
    let creased = if attributes.normals.is_empty() { normals::creased(surface) } else { Vec::new() };
    let of = |triangle: usize| {
        let normals = if creased.is_empty() { outward(surface, triangle) } else { creased[triangle] };
        let uvs = attributes.uvs.get(triangle).copied().unwrap_or([[0.0; 2]; 3]);
        let points = surface.triangles[triangle];
        [0, 1, 2].map(|k| RefinedCorner { point: points[k], normal: normals[k], uv: uvs[k] })
    };
    (0..surface.triangles.len()).map(of).collect()
}

/// The file's normals of a triangle on its outer side. Normals of triangles that the repair reversed are reversed, too.
fn outward(surface: &Surface, triangle: usize) -> [[f32; 3]; 3] {
    let area = area_vector(&surface.corners(triangle));
    let own = surface.attributes.normals[triangle];
    let along: f64 = own.iter().map(|normal| (0..3).map(|k| f64::from(normal[k]) * area[k]).sum::<f64>()).sum();
    if along < 0.0 { own.map(|normal| normal.map(|x| -x)) } else { own }
}

/// Weighted mean of normals, made unit again, and of texture coordinates. Opposite normals yield the first.
pub(crate) fn blended<const N: usize>(
    attributes: [([f32; 3], [f32; 2]); N],
    weights: [f64; N],
) -> ([f32; 3], [f32; 2]) {
    let sum = |of: &dyn Fn(usize) -> f32| -> f64 { (0..N).map(|k| f64::from(of(k)) * weights[k]).sum() };
    let normal = Vector3::from([0, 1, 2].map(|axis| sum(&|k| attributes[k].0[axis])));
    let normal = normal.try_normalize(0.0).map_or(attributes[0].0, |normal| normal.map(|x| x as f32).into());
    (normal, [0, 1].map(|axis| sum(&|k| attributes[k].1[axis]) as f32))
}

/// Merges corners with equal points and attributes into one vertex.
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

/// Positions of the points: in the first body that contains them, else on the nearest body's boundary.
fn spots(points: &[Point3<f64>], lattices: &[&Lattice]) -> Vec<SkinPoint> {
    let locators: Vec<Locator> = lattices.iter().map(|lattice| Locator::new(lattice)).collect();
    let boxes: Vec<[Point3<f64>; 2]> = lattices.iter().map(|lattice| bounds(lattice)).collect();
    let spot = |point: &Point3<f64>| {
        let holds = |body: &usize| apart(point, &boxes[*body]) == 0.0;
        let inside = (0..lattices.len())
            .filter(holds)
            .find_map(|body| Some(SkinPoint { body: body as u32, place: locators[body].containing(point, None)? }));
        inside.or_else(|| nearest(point, &locators, &boxes)).unwrap_or(UNLOCATED_POINT)
    };
    points.par_iter().map(spot).collect()
}

/// Position in an object without lattices.
const UNLOCATED_POINT: SkinPoint =
    SkinPoint { body: 0, place: LatticePoint { tet: 0, barycentric: [1.0, 0.0, 0.0, 0.0] } };

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
    Some(SkinPoint { body: body as u32, place: locators[body].locate(point, None)? })
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
