//! Triangle meshes with normals and colors.

use super::Color;
use nalgebra::{Point3, Vector3};

/// Attributes of a triangle's corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnCorner {
    /// Unit normal for shading.
    pub normal: Vector3<f32>,
    /// Color.
    pub color: Color,
}

/// Triangles with normals and colors per corner. [`DrawnMesh::append`] joins meshes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrawnMesh {
    /// Positions, +y up, in any unit.
    pub positions: Vec<Point3<f32>>,
    /// Three vertex numbers per triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Normals and colors, one triple per triangle.
    pub corners: Vec<[DrawnCorner; 3]>,
    /// Coordinates on a checkerboard of unit fields, which covers the colors, by triangle. Triangles beyond the end have none.
    pub checkers: Vec<Option<[[f32; 2]; 3]>>,
}

impl DrawnMesh {
    /// Colors `triangles`; `paint(triangle, vertex)` returns the color of a corner.
    ///
    /// Normals are smooth across edges that bend by less than `crease_deg`, and sharp elsewhere.
    pub fn paint(
        positions: Vec<Point3<f32>>,
        triangles: Vec<[u32; 3]>,
        crease_deg: f32,
        paint: impl Fn(usize, u32) -> Color,
    ) -> Self {
        let normals = creased(&positions, &triangles, crease_deg);
        let corners = triangles
            .iter()
            .zip(normals)
            .enumerate()
            .map(|(t, (triangle, normals))| {
                [0, 1, 2].map(|k| DrawnCorner { normal: normals[k], color: paint(t, triangle[k]) })
            })
            .collect();
        Self { positions, triangles, corners, checkers: Vec::new() }
    }

    /// Translates the mesh.
    pub fn moved(mut self, offset: Vector3<f32>) -> Self {
        self.positions.iter_mut().for_each(|position| *position += offset);
        self
    }

    /// Appends another mesh.
    pub fn append(&mut self, other: Self) {
        let first = self.positions.len() as u32;
        if !other.checkers.is_empty() {
            self.checkers.resize(self.triangles.len(), None);
            self.checkers.extend(other.checkers);
        }
        self.positions.extend(other.positions);
        self.triangles.extend(other.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + first)));
        self.corners.extend(other.corners);
    }

    /// Lowest and highest coordinate per axis; the origin for an empty mesh.
    pub fn bounds(&self) -> (Point3<f32>, Point3<f32>) {
        let Some(&first) = self.positions.first() else {
            return (Point3::origin(), Point3::origin());
        };
        self.positions.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)))
    }
}

/// Corner normals: area-weighted mean normal of the surrounding triangles that bend by less than `crease_deg` from the corner's own
/// triangle.
fn creased(positions: &[Point3<f32>], triangles: &[[u32; 3]], crease_deg: f32) -> Vec<[Vector3<f32>; 3]> {
    let areas: Vec<Vector3<f32>> = triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
            (b - a).cross(&(c - a))
        })
        .collect();
    let units: Vec<Vector3<f32>> =
        areas.iter().map(|area| area.try_normalize(0.0).unwrap_or_else(Vector3::y)).collect();
    let around = Around::new(positions.len(), triangles);
    let least = crease_deg.to_radians().cos();
    let corner = |own: usize, vertex: u32| {
        let alike = around.of(vertex).iter().filter(|&&other| units[own].dot(&units[other as usize]) >= least);
        let sum = alike.fold(Vector3::zeros(), |sum, &other| sum + areas[other as usize]);
        sum.try_normalize(0.0).unwrap_or(units[own])
    };
    triangles.iter().enumerate().map(|(own, triangle)| triangle.map(|vertex| corner(own, vertex))).collect()
}

/// Triangles around each vertex, in compressed rows.
struct Around {
    first: Vec<u32>,
    triangles: Vec<u32>,
}

impl Around {
    fn new(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let mut first = vec![0_u32; vertices + 1];
        for &vertex in triangles.as_flattened() {
            first[vertex as usize + 1] += 1;
        }
        for k in 0..vertices {
            first[k + 1] += first[k];
        }
        let mut next = first.clone();
        let mut list = vec![0; triangles.len() * 3];
        for (t, triangle) in triangles.iter().enumerate() {
            for &vertex in triangle {
                list[next[vertex as usize] as usize] = t as u32;
                next[vertex as usize] += 1;
            }
        }
        Self { first, triangles: list }
    }

    fn of(&self, vertex: u32) -> &[u32] {
        &self.triangles[self.first[vertex as usize] as usize..self.first[vertex as usize + 1] as usize]
    }
}
