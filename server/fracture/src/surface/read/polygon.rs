//! Triangulation of polygons.
//!
//! Based on: G. H. Meisters, *Polygons have ears* (1975). While more than three corners are left, it cuts off an ear: a
//! convex corner whose triangle contains no other corner. Newell's normal orients a spatial polygon.

use super::common::within_limit;
use crate::surface::SurfaceError;
use nalgebra::{Point3, Vector3};

/// Largest number of corners for ear clipping, whose cost is cubic in the worst case. Larger polygons are cut as fans.
const EARS_MAX: usize = 512;

/// Faces of a file.
#[derive(Default)]
pub(super) struct FacePolygons {
    corners: Vec<u32>,
    ends: Vec<usize>,
}

impl FacePolygons {
    /// Appends a face. Corners are vertex indices from 0 and may refer to vertices defined later.
    pub fn push(&mut self, corners: impl IntoIterator<Item = u32>) {
        self.corners.extend(corners);
        self.ends.push(self.corners.len());
    }

    /// Number of faces.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Cuts all faces into triangles. Faces of fewer than three corners yield none.
    pub fn triangles(&self, positions: &[Point3<f64>]) -> Result<FaceTriangles, SurfaceError> {
        within_limit(self.corners.len())?;
        let mut cut = FaceTriangles::default();
        let mut start = 0;
        for (face, &end) in self.ends.iter().enumerate() {
            let (corners, first) = (&self.corners[start..end], start);
            start = end;
            if let Some(&index) = corners.iter().find(|&&index| index as usize >= positions.len()) {
                let vertices = positions.len() as u64;
                return Err(SurfaceError::VertexOutOfBounds { face: face as u64, index: i64::from(index), vertices });
            }
            for corner in self::cut(corners, positions) {
                cut.triangles.push(corner.map(|corner| corners[corner]));
                cut.places.push(corner.map(|corner| first + corner));
                cut.faces.push(face as u32);
            }
        }
        Ok(cut)
    }
}

/// Triangles that faces were cut into.
#[derive(Default)]
pub(super) struct FaceTriangles {
    /// Vertex indices.
    pub triangles: Vec<[u32; 3]>,
    /// Corner of the file that each triangle corner came from, counted over all faces.
    pub places: Vec<[usize; 3]>,
    /// Face that each triangle was cut from.
    pub faces: Vec<u32>,
}

/// Triangles of one face, as indices into `corners`.
fn cut(corners: &[u32], positions: &[Point3<f64>]) -> Vec<[usize; 3]> {
    match corners.len() {
        0..3 => Vec::new(),
        3 => vec![[0, 1, 2]],
        count if count > EARS_MAX => (2..count).map(|k| [0, k - 1, k]).collect(),
        _ => cut_ears(corners, positions),
    }
}

fn cut_ears(corners: &[u32], positions: &[Point3<f64>]) -> Vec<[usize; 3]> {
    let vertex = |place: usize| corners[place];
    let at = |place: usize| positions[vertex(place) as usize];
    let normal = newell(corners, positions);
    let mut left: Vec<usize> = (0..corners.len()).collect();
    let mut triangles = Vec::with_capacity(corners.len() - 2);
    while left.len() > 3 {
        let count = left.len();
        let around = |k: usize| [left[(k + count - 1) % count], left[k], left[(k + 1) % count]];
        let is_ear = |k: usize| {
            let [a, b, c] = around(k).map(at);
            let others = left.iter().filter(|&&other| !around(k).map(vertex).contains(&vertex(other)));
            turn(&a, &b, &c, &normal) > 0.0 && !others.into_iter().any(|&other| holds(&[a, b, c], &at(other), &normal))
        };
        // A self-intersecting polygon may have no ear left; then any corner is cut.
        let ear = (1..count).chain([0]).find(|&k| is_ear(k)).unwrap_or(1);
        triangles.push(around(ear));
        left.remove(ear);
    }
    triangles.push([left[0], left[1], left[2]]);
    triangles
}

/// Twice the area vector of a polygon.
fn newell(corners: &[u32], positions: &[Point3<f64>]) -> Vector3<f64> {
    let first = positions[corners[0] as usize];
    let offset = |k: usize| positions[corners[k % corners.len()] as usize] - first;
    (0..corners.len()).map(|k| offset(k).cross(&offset(k + 1))).sum()
}

/// Orientation of a, b, c seen against `normal`: positive for a left turn.
fn turn(a: &Point3<f64>, b: &Point3<f64>, c: &Point3<f64>, normal: &Vector3<f64>) -> f64 {
    (b - a).cross(&(c - b)).dot(normal)
}

fn holds([a, b, c]: &[Point3<f64>; 3], point: &Point3<f64>, normal: &Vector3<f64>) -> bool {
    [(a, b), (b, c), (c, a)].iter().all(|(from, to)| turn(from, to, point, normal) >= 0.0)
}
