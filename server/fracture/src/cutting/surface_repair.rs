//! Repairs that a surface needs before it can be meshed, for the report.

use crate::surface::LocalFrame;
use nalgebra::Point3;
use serde::{Deserialize, Serialize};

/// Largest number of places that a repair lists.
pub(crate) const LISTED_MAX: usize = 5;

/// Kind of a repair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RepairKind {
    /// Triangles with the corners of others were left out: one of each stays, or none where they are walls inside the solid.
    DuplicateTriangles,
    /// Holes were closed by films. The area is that of the films on the surface, without what lies inside other parts.
    FilledHoles,
    /// Edges with a vertex of other triangles on them (T-junctions) were divided there.
    DividedEdges,
    /// Parts that intersect or contain one another were united. Triangles that cross a later one are counted.
    UnitedParts,
    /// Triangles inside the solid were left out.
    HiddenTriangles,
    /// Vertices in which parts touch were divided.
    DividedVertices,
    /// Edges too short for single precision were collapsed.
    CollapsedEdges,
}

/// A repair of the surface that fragments end on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SurfaceRepair {
    /// Kind of the repair.
    pub kind: RepairKind,
    /// Number of places.
    pub count: u64,
    /// Area of films that were added, or of triangles, or parts of crossing ones, that were left out, m²; 0 for other repairs.
    pub area_m2: f64,
    /// This area over that of the surface with it.
    #[serde(default)]
    pub area_share: f64,
    /// The first places that differ, m.
    pub places_m: Vec<Point3<f64>>,
}

impl SurfaceRepair {
    /// A repair at these local places, without area.
    pub(super) fn new(kind: RepairKind, places: &[Point3<f64>], frame: &LocalFrame) -> Self {
        let mut different = places.to_vec();
        different.dedup();
        let places_m = different.iter().take(LISTED_MAX).map(|place| frame.to_meters(place)).collect();
        Self { kind, count: places.len() as u64, area_m2: 0.0, area_share: 0.0, places_m }
    }

    /// The repair with the area that it adds to a surface or leaves out of it; `whole` is that of the surface with it. Local.
    pub(super) fn of_area(self, area: f64, whole: f64, frame: &LocalFrame) -> Self {
        let area_share = if area > 0.0 { (area / whole).min(1.0) } else { 0.0 };
        Self { area_m2: area * frame.diagonal_m * frame.diagonal_m, area_share, ..self }
    }
}
