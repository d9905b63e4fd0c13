//! Mesh as read from a file: meters, y up, not repaired.

use super::{DIAGONAL_RANGE_M, SurfaceError, TriangleAttributes};
use crate::scene::brief;
use nalgebra::Point3;
use std::fmt;
use std::str::FromStr;

/// Length unit of a mesh file's coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LengthUnit {
    /// Meters, the default.
    #[default]
    M,
    /// Centimeters.
    Cm,
    /// Millimeters.
    Mm,
    /// Inches of 25.4 mm.
    In,
}

impl LengthUnit {
    /// All units, the default first.
    pub const ALL: [Self; 4] = [Self::M, Self::Cm, Self::Mm, Self::In];

    /// Meters per unit.
    pub fn meters(self) -> f64 {
        match self {
            Self::M => 1.0,
            Self::Cm => 0.01,
            Self::Mm => 0.001,
            Self::In => 0.0254,
        }
    }
}

impl fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::M => "m",
            Self::Cm => "cm",
            Self::Mm => "mm",
            Self::In => "in",
        })
    }
}

/// Error for a word that names no length unit.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown unit '{}': one of m, cm, mm, in", brief(.0))]
pub struct UnknownUnit(String);

impl FromStr for LengthUnit {
    type Err = UnknownUnit;

    fn from_str(word: &str) -> Result<Self, UnknownUnit> {
        match word {
            "m" => Ok(Self::M),
            "cm" => Ok(Self::Cm),
            "mm" => Ok(Self::Mm),
            "in" => Ok(Self::In),
            _ => Err(UnknownUnit(word.to_owned())),
        }
    }
}

/// Axis of a mesh file that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// +Y, the default.
    #[default]
    Y,
    /// +Z; (x, y, z) is rotated to (x, z, −y).
    Z,
}

impl fmt::Display for UpAxis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Y => "y",
            Self::Z => "z",
        })
    }
}

/// Error for a word that names no up axis.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown up axis '{}': one of y, z", brief(.0))]
pub struct UnknownUpAxis(String);

impl FromStr for UpAxis {
    type Err = UnknownUpAxis;

    fn from_str(word: &str) -> Result<Self, UnknownUpAxis> {
        match word {
            "y" => Ok(Self::Y),
            "z" => Ok(Self::Z),
            _ => Err(UnknownUpAxis(word.to_owned())),
        }
    }
}

/// Relative rounding error of a coordinate stored as f32.
pub const SINGLE: f64 = f32::EPSILON as f64 / 2.0;

/// Relative rounding error of a coordinate stored as f64 or as decimal text.
pub const DOUBLE: f64 = f64::EPSILON / 2.0;

/// Triangle mesh from a file or a generator.
#[derive(Clone, Debug, PartialEq)]
pub struct RawMesh {
    /// Vertex positions, meters, y up.
    pub positions_m: Vec<Point3<f64>>,
    /// Vertex indices of each triangle, intended to be counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Face of the file, counted from 0, that each triangle was cut from. Empty if every face is a triangle.
    pub faces: Vec<u32>,
    /// Relative rounding error of the stored coordinates: [`SINGLE`] or [`DOUBLE`].
    pub rounding: f64,
    /// Normals, texture coordinates, colors and materials of the triangles.
    pub attributes: TriangleAttributes,
}

impl RawMesh {
    /// Creates a mesh in double precision without attributes.
    pub fn new(positions_m: Vec<Point3<f64>>, triangles: Vec<[u32; 3]>) -> Self {
        Self { positions_m, triangles, faces: Vec::new(), rounding: DOUBLE, attributes: TriangleAttributes::default() }
    }

    /// Face of the file that `triangle` was cut from.
    pub fn face(&self, triangle: usize) -> u64 {
        self.faces.get(triangle).map_or(triangle as u64, |&face| u64::from(face))
    }

    /// Checks that the mesh is not empty, its coordinates are finite and in range, and every index refers to a vertex.
    ///
    /// # Errors
    /// [`SurfaceError`]: the first defect.
    pub fn check(&self) -> Result<(), SurfaceError> {
        self.check_expected("a mesh has vertices and faces")
    }

    /// As [`Self::check`]. The error for an empty mesh states what is `expected`.
    pub(super) fn check_expected(&self, expected: &'static str) -> Result<(), SurfaceError> {
        let missing = [("vertices", self.positions_m.is_empty()), ("faces", self.triangles.is_empty())];
        if let Some((missing, _)) = missing.into_iter().find(|(_, is_missing)| *is_missing) {
            return Err(SurfaceError::Empty { missing, expected });
        }
        if let Some(vertex) = self.positions_m.iter().position(|p| !p.coords.iter().all(|c| c.is_finite())) {
            return Err(SurfaceError::NonFiniteVertex { vertex: vertex as u64, line: None });
        }
        let limit_m = *DIAGONAL_RANGE_M.end();
        if let Some(vertex) = self.positions_m.iter().position(|p| p.coords.amax() > limit_m) {
            let at_m = self.positions_m[vertex].coords.into();
            return Err(SurfaceError::VertexOutOfRange { vertex: vertex as u64, at_m, limit_m });
        }
        let vertices = self.positions_m.len() as u64;
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|&&index| u64::from(index) >= vertices) {
                let face = self.face(triangle);
                return Err(SurfaceError::VertexOutOfBounds { face, index: i64::from(index), vertices });
            }
        }
        Ok(())
    }

    /// Converts file coordinates to meters and y up.
    pub(super) fn convert_to_meters(&mut self, unit: LengthUnit, up: UpAxis) {
        let meters = unit.meters();
        for point in &mut self.positions_m {
            let turned = match up {
                UpAxis::Y => *point,
                UpAxis::Z => Point3::new(point.x, point.z, -point.y),
            };
            *point = turned * meters;
        }
        if up == UpAxis::Z {
            self.attributes.normals.iter_mut().flatten().for_each(|[x, y, z]| [*x, *y, *z] = [*x, *z, -*y]);
        }
    }
}
