//! Triangulation of polygons.
//!
//! Based on: G. H. Meisters, *Polygons have ears* (1975). While more than three corners are left, it cuts off an ear: a
//! convex corner whose triangle contains no other corner. Newell's normal orients a spatial polygon. Convex polygons of many
//! corners are cut into halves instead: a fan of needles at one corner cannot be meshed exactly.

use super::common::within_limit;
use crate::surface::SurfaceError;
use nalgebra::{Point3, Vector3};

/// Largest number of corners for ear clipping, whose cost is cubic in the worst case. Larger polygons are cut as fans.
const EARS_MAX: usize = 512;

/// Smallest number of corners at which convex polygons are cut into halves.
const HALVED_MIN: usize = 6;

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
        HALVED_MIN.. if is_convex(corners, positions) => cut_halves(corners.len()),
        count if count > EARS_MAX => (2..count).map(|k| [0, k - 1, k]).collect(),
        _ => cut_ears(corners, positions),
    }
}

/// Triangles of a convex polygon: one at the middle corner of each run of corners, which divides the run into halves.
fn cut_halves(count: usize) -> Vec<[usize; 3]> {
    let mut runs = vec![[0, count - 1]];
    let mut triangles = Vec::with_capacity(count - 2);
    while let Some([from, to]) = runs.pop() {
        if to - from >= 2 {
            let middle = usize::midpoint(from, to);
            triangles.push([from, middle, to]);
            runs.extend([[middle, to], [from, middle]]);
        }
    }
    triangles
}

/// True if all corners turn to the left, seen against the normal, and go around once.
fn is_convex(corners: &[u32], positions: &[Point3<f64>]) -> bool {
    let normal = newell(corners, positions);
    let count = corners.len();
    let at = |place: usize| positions[corners[place % count] as usize];
    let turns_left = |k: usize| turn(&at(k), &at(k + 1), &at(k + 2), &normal) > 0.0;
    // Seen from the first corner, the others of a polygon that goes around once follow each other to the left.
    let is_single = |k: usize| turn(&at(0), &at(k), &at(k + 1), &normal) > 0.0;
    (0..count).all(turns_left) && (1..count - 1).all(is_single)
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
