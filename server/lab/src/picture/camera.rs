//! Camera of a picture.

use nalgebra::{Point3, Vector3};

/// Projection of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Parallel projection.
    Orthographic,
    /// Perspective with this vertical angle of view.
    Perspective {
        /// Degrees, between 0 and 180.
        fov_deg: f32,
    },
}

/// Camera fitted to a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position of the eye.
    pub eye: Point3<f32>,
    /// Unit vector to the right of the picture.
    pub right: Vector3<f32>,
    /// Unit vector to the top of the picture.
    pub up: Vector3<f32>,
    /// Unit vector towards the eye.
    pub back: Vector3<f32>,
    /// Half the height of the picture: at distance 1 (perspective), or at any distance (orthographic).
    half_height: f32,
    perspective: bool,
}

/// Point on the picture plane: x to the right and y up; the picture's height spans −1 to 1.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Projected {
    pub x: f32,
    pub y: f32,
    /// Nearness: grows towards the eye and is linear on the picture; also the weight of perspective-correct interpolation.
    pub near: f32,
}

/// Share of the picture that the scene may fill.
const FILL: f32 = 0.90;

impl Camera {
    /// Fits a camera in direction `from` of the scene that shows all of `points` as large as the aspect `width / height` allows.
    ///
    /// Up is +y; without points it looks at the unit box.
    pub fn fit(points: &[Point3<f32>], from: Vector3<f32>, projection: Projection, aspect: f32) -> Self {
        let back = from.try_normalize(1e-12).unwrap_or_else(Vector3::z);
        let vertical = if back.y.abs() > 0.999 { Vector3::z() } else { Vector3::y() };
        let right = vertical.cross(&back).normalize();
        let up = back.cross(&right);
        let seen = |p: &Point3<f32>| Vector3::new(right.dot(&p.coords), up.dot(&p.coords), back.dot(&p.coords));
        let corners: Vec<Vector3<f32>> = if points.is_empty() {
            vec![Vector3::repeat(-0.5), Vector3::repeat(0.5)]
        } else {
            points.iter().map(seen).collect()
        };
        let (place, half_height, perspective) = match projection {
            Projection::Orthographic => {
                let (place, half_height) = orthographic(&corners, aspect);
                (place, half_height, false)
            }
            Projection::Perspective { fov_deg } => {
                let tangent = (0.5 * fov_deg.to_radians()).tan();
                (perspective(&corners, tangent * FILL, aspect), tangent, true)
            }
        };
        let eye = Point3::from(right * place.x + up * place.y + back * place.z);
        Self { eye, right, up, back, half_height, perspective }
    }

    pub(super) fn project(&self, point: &Point3<f32>) -> Projected {
        let offset = point - self.eye;
        let depth = -offset.dot(&self.back);
        let (scale, near) = if self.perspective {
            (1.0 / (depth * self.half_height), 1.0 / depth)
        } else {
            (1.0 / self.half_height, -depth)
        };
        Projected { x: offset.dot(&self.right) * scale, y: offset.dot(&self.up) * scale, near }
    }

    /// Origin and unit direction of the ray through a point of the picture plane.
    pub(super) fn ray(&self, x: f32, y: f32) -> (Point3<f32>, Vector3<f32>) {
        let aside = (self.right * x + self.up * y) * self.half_height;
        if self.perspective { (self.eye, (aside - self.back).normalize()) } else { (self.eye + aside, -self.back) }
    }

    /// Whether interpolation on the picture needs weights by nearness.
    pub(super) fn is_perspective(&self) -> bool {
        self.perspective
    }
}

fn largest(values: impl Iterator<Item = f32>) -> f32 {
    values.fold(f32::NEG_INFINITY, f32::max)
}

/// Nearest eye whose pyramid with half-angle tangents (tangent·aspect, tangent) contains all corners. Each face of the pyramid touches
/// the scene in one direction, and each opposite pair of faces fixes one coordinate.
fn perspective(corners: &[Vector3<f32>], tangent: f32, aspect: f32) -> Vector3<f32> {
    let wide = tangent * aspect;
    let reach = |axis: usize, sign: f32, slope: f32| largest(corners.iter().map(|c| sign * c[axis] + slope * c.z));
    let (east, west) = (reach(0, 1.0, wide), reach(0, -1.0, wide));
    let (north, south) = (reach(1, 1.0, tangent), reach(1, -1.0, tangent));
    let distance = ((east + west) / (2.0 * wide)).max((north + south) / (2.0 * tangent));
    Vector3::new((east - west) / 2.0, (north - south) / 2.0, distance)
}

fn orthographic(corners: &[Vector3<f32>], aspect: f32) -> (Vector3<f32>, f32) {
    let high = |axis: usize| largest(corners.iter().map(|c| c[axis]));
    let low = |axis: usize| -largest(corners.iter().map(|c| -c[axis]));
    let half = |axis: usize| (high(axis) - low(axis)) / 2.0;
    let half_height = half(1).max(half(0) / aspect).max(f32::MIN_POSITIVE) / FILL;
    let middle = |axis: usize| (high(axis) + low(axis)) / 2.0;
    (Vector3::new(middle(0), middle(1), high(2) + half_height), half_height)
}
