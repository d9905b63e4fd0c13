//! Surface of a fragment that is struck again.

use crate::elasticity::{FaceBoxes, FaceSearch, SurfaceFaces};
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
