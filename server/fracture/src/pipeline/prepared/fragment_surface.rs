//! Surface of a fragment that is struck again.

use crate::elasticity::{FaceBoxes, FaceSearch, SurfaceFaces};
use crate::fragment::RigidProperties;
use crate::memory::held;
use nalgebra::Point3;

/// Outer faces and cracks of a fragment, as separate triangles.
#[derive(Clone, Debug)]
pub struct FragmentSurface {
    triangles: Vec<[Point3<f64>; 3]>,
    boxes: FaceBoxes,
}

impl FragmentSurface {
    /// The surface of these triangles, local, outward.
    pub fn new(triangles: Vec<[Point3<f64>; 3]>) -> Self {
        Self { boxes: FaceBoxes::new(triangles.len(), |face| triangles[face]), triangles }
    }

    /// The triangles, to be searched.
    pub fn search(&self) -> FaceSearch<'_> {
        FaceSearch { faces: self, boxes: &self.boxes }
    }

    /// Volume, center and inertia of what it encloses, local.
    pub fn rigid_properties(&self) -> RigidProperties {
        let corners = 3 * self.triangles.len() as u32;
        let triangles = (0..corners).step_by(3).map(|first| [first, first + 1, first + 2]);
        RigidProperties::of_surface(self.triangles.as_flattened(), triangles)
    }

    /// Bytes of memory that it holds.
    pub fn bytes(&self) -> usize {
        held(&self.triangles) + self.boxes.bytes()
    }
}

impl SurfaceFaces for FragmentSurface {
    fn count(&self) -> usize {
        self.triangles.len()
    }

    fn corners(&self, face: usize) -> [Point3<f64>; 3] {
        self.triangles[face]
    }
}
