//! Skin of an object: the input's triangles with their attributes. Fragments display it, so that breaking is not
//! visible by itself.
//!
//! [`Skin`] is prepared once per object: triangles refined to the crack lattice, and positions of their corners in it.
//! [`clip`] divides them among fragments. [`BoundaryAttributes`] transfers their attributes to the lattice's own
//! boundary.

mod boundary_attributes;
mod clipped_surface;
mod normals;
mod point_attributes;
mod refine;
mod walls;

#[cfg(test)]
mod tests;

pub use boundary_attributes::BoundaryAttributes;
pub use clipped_surface::{BlendedVertex, ClippedSurface, clip};
pub(crate) use point_attributes::blended;
pub use point_attributes::{AttributeKinds, PointAttributeLists, PointAttributes};

use crate::lattice::{Lattice, LatticePoint, Locator, area_vector};
use crate::memory::held;
use crate::surface::Surface;
use nalgebra::Point3;
use rayon::prelude::*;
pub(crate) use refine::{RefinedCorner, TRIANGLES_MAX};
use std::collections::HashMap;

/// Longest edge of a skin, in spacings of the crack lattice; about the distance of its boundary nodes.
///
/// Chosen on 48 requests on a block. With edges of one spacing, a fragment's tip between skin points goes to the
/// neighbors, in 3 requests and up to 3 spacings from the fragment's own skin. With 0.7, this happens in 1 request, up
/// to 1.2 spacings away.
pub(crate) const EDGE_SPACINGS: f64 = 0.7;

/// Position of a skin point in the crack lattices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinPoint {
    /// Index of the body.
    pub body: u32,
    /// Position in its crack lattice; for a point outside, the nearest point of the boundary.
    pub place: LatticePoint,
}

/// Surface of the input with its attributes, repaired and facing outward, local.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// Points, without duplicates.
    pub points: Vec<Point3<f64>>,
    /// Position of each point in the crack lattices.
    pub spots: Vec<SkinPoint>,
    /// Index into `points` of each vertex: a point with its attributes in some of its triangles.
    pub vertices: Vec<u32>,
    /// Attributes of the vertices.
    pub attributes: PointAttributeLists,
    /// Indices into `vertices`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Material of each triangle; empty if the file has none.
    pub materials: Vec<u32>,
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
        let spots = spots(&points, lattices);
        let mut skin = Self { points, spots, materials, ..Self::default() };
        skin.share(&corners, AttributeKinds::of(attributes));
        skin
    }

    /// The three corners of triangle `triangle`, local.
    pub fn corners(&self, triangle: usize) -> [Point3<f64>; 3] {
        self.triangles[triangle].map(|vertex| self.points[self.vertices[vertex as usize] as usize])
    }

    /// The part of one fragment as a separate skin.
    ///
    /// Each of its vertices is a point. Points on the boundary take the lattice position of a neighboring point of the
    /// same fragment.
    pub fn part(&self, clipped: &ClippedSurface) -> Self {
        let mut part = Self { triangles: clipped.triangles.clone(), ..Self::default() };
        let kinds = self.attributes.kinds();
        for (point, blend) in clipped.vertices.iter().enumerate() {
            let (place, attributes) = blend.of(self);
            part.points.push(place);
            part.spots.push(self.spots[self.vertices[blend.own_vertex as usize] as usize]);
            part.vertices.push(point as u32);
            part.attributes.push(&attributes, kinds);
        }
        if !self.materials.is_empty() {
            part.materials = clipped.sources.iter().map(|&source| self.materials[source as usize]).collect();
        }
        part
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let Self { points, spots, vertices, attributes, triangles, materials } = self;
        held(points) + held(spots) + held(vertices) + attributes.bytes() + held(triangles) + held(materials)
    }

    /// Merges corners with equal points and attributes into one vertex.
    fn share(&mut self, corners: &[[RefinedCorner; 3]], kinds: AttributeKinds) {
        let mut places: HashMap<(u32, [u32; 8]), u32> = HashMap::new();
        for own in corners {
            let place = |RefinedCorner { point, attributes }: RefinedCorner| {
                *places.entry((point, attributes.bits())).or_insert_with(|| {
                    self.vertices.push(point);
                    self.attributes.push(&attributes, kinds);
                    self.vertices.len() as u32 - 1
                })
            };
            self.triangles.push(own.map(place));
        }
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
        let uvs = [&attributes.uvs, &attributes.uvs2].map(|set| set.get(triangle).copied().unwrap_or_default());
        let colors = attributes.colors.get(triangle);
        let points = surface.triangles[triangle];
        [0, 1, 2].map(|k| {
            let plain = PointAttributes::plain(normals[k]);
            let color = colors.map_or(plain.color, |colors| colors[k]);
            RefinedCorner {
                point: points[k],
                attributes: PointAttributes { uvs: uvs.map(|set| set[k]), color, ..plain },
            }
        })
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
