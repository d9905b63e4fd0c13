//! Polygons into triangles.
//!
//! Based on: G. H. Meisters, *Polygons have ears* (1975): while more than three corners are left, a convex corner whose
//! triangle holds no other corner is cut off. Newell's normal tells which way a spatial polygon is seen.

use super::{SurfaceError, within_limit};
use nalgebra::{Point3, Vector3};

/// Polygons of more corners are cut as fans: searching ears can take the cube of their number.
const EARS_MAX: usize = 512;

/// Faces of a file, one after the other.
#[derive(Default)]
pub(super) struct Polygons {
    corners: Vec<u32>,
    ends: Vec<usize>,
}

impl Polygons {
    /// Appends a face; corners are vertices counted from 0, and may be defined later.
    pub fn push(&mut self, corners: impl IntoIterator<Item = u32>) {
        self.corners.extend(corners);
        self.ends.push(self.corners.len());
    }

    /// How many faces there are.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// The triangles, and for each the face it was cut from; faces of fewer than three corners give none.
    pub fn triangles(&self, positions: &[Point3<f64>]) -> Result<(Vec<[u32; 3]>, Vec<u32>), SurfaceError> {
        within_limit(self.corners.len())?;
        let (mut triangles, mut faces) = (Vec::with_capacity(self.len()), Vec::with_capacity(self.len()));
        let mut start = 0;
        for (face, &end) in self.ends.iter().enumerate() {
            let corners = &self.corners[start..end];
            start = end;
            if let Some(&index) = corners.iter().find(|&&index| index as usize >= positions.len()) {
                let vertices = positions.len() as u64;
                return Err(SurfaceError::VertexOutOfBounds { face: face as u64, index: i64::from(index), vertices });
            }
            cut(corners, positions, &mut triangles);
            faces.resize(triangles.len(), face as u32);
        }
        Ok((triangles, faces))
    }
}

fn cut(corners: &[u32], positions: &[Point3<f64>], triangles: &mut Vec<[u32; 3]>) {
    match *corners {
        [a, b, c] => triangles.push([a, b, c]),
        [first, _, _, _, ..] if corners.len() > EARS_MAX => {
            triangles.extend(corners[1..].windows(2).map(|pair| [first, pair[0], pair[1]]));
        }
        [_, _, _, _, ..] => cut_ears(corners, positions, triangles),
        _ => {}
    }
}

fn cut_ears(corners: &[u32], positions: &[Point3<f64>], triangles: &mut Vec<[u32; 3]>) {
    let at = |vertex: u32| positions[vertex as usize];
    let normal = newell(corners, positions);
    let mut left = corners.to_vec();
    while left.len() > 3 {
        let count = left.len();
        let around = |k: usize| [left[(k + count - 1) % count], left[k], left[(k + 1) % count]];
        let is_ear = |k: usize| {
            let [a, b, c] = around(k).map(at);
            let others = left.iter().filter(|vertex| !around(k).contains(vertex));
            turn(&a, &b, &c, &normal) > 0.0 && !others.into_iter().any(|&other| holds(&[a, b, c], &at(other), &normal))
        };
        // A polygon that crosses itself may have no ear left: then any corner is cut.
        let ear = (1..count).chain([0]).find(|&k| is_ear(k)).unwrap_or(1);
        triangles.push(around(ear));
        left.remove(ear);
    }
    triangles.push([left[0], left[1], left[2]]);
}

/// Twice the area vector of a polygon.
fn newell(corners: &[u32], positions: &[Point3<f64>]) -> Vector3<f64> {
    let first = positions[corners[0] as usize];
    let offset = |k: usize| positions[corners[k % corners.len()] as usize] - first;
    (0..corners.len()).map(|k| offset(k).cross(&offset(k + 1))).sum()
}

/// Positive if a, b, c turn left as seen against `normal`.
fn turn(a: &Point3<f64>, b: &Point3<f64>, c: &Point3<f64>, normal: &Vector3<f64>) -> f64 {
    (b - a).cross(&(c - b)).dot(normal)
}

fn holds([a, b, c]: &[Point3<f64>; 3], point: &Point3<f64>, normal: &Vector3<f64>) -> bool {
    [(a, b), (b, c), (c, a)].iter().all(|(from, to)| turn(from, to, point, normal) >= 0.0)
}
