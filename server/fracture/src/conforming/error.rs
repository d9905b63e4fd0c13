//! Errors of the conforming mesher.

use crate::cancel_token::Canceled;
use crate::surface::meeting_point;
use nalgebra::Point3;

/// Kind of a constraint of the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConstraintKind {
    /// Edge of a boundary triangle.
    Segment,
    /// Boundary triangle.
    Facet,
}

impl std::fmt::Display for ConstraintKind {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Self::Segment => "edge",
            Self::Facet => "triangle",
        })
    }
}

/// Error of the conforming mesher. Triangles and vertices are those of the input surface.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ConformingError {
    /// The work was canceled.
    #[error(transparent)]
    Canceled(#[from] Canceled),
    /// The spacing is not positive.
    #[error("spacing {spacing} is not positive")]
    InvalidSpacing {
        /// Requested spacing.
        spacing: f64,
    },
    /// A coordinate is outside the range of exact signs, or a triangle names a vertex that does not exist.
    #[error("point {point} does not exist, or has a coordinate that is neither 0 nor between 1e-48 and 1e48")]
    InvalidPoint {
        /// Index of the point: vertices of the surface first, then interior points.
        point: usize,
    },
    /// The mesh would have more points than [`super::ConformingOptions::points_max`].
    #[error("mesh needs at least {points} points, more than {points_max}; use a coarser preset or surface")]
    TooManyPoints {
        /// Number of points when the limit was exceeded.
        points: usize,
        /// Largest accepted number.
        points_max: usize,
    },
    /// The mesh would have too many tetrahedra for its points.
    #[error("mesh has more than {tets_max} tetrahedra; use a coarser surface")]
    TooManyTets {
        /// Largest accepted number.
        tets_max: usize,
    },
    /// The mesh takes more work than [`super::ConformingOptions::steps_max`].
    #[error(
        "mesh takes more than {steps_max} steps; use a coarser preset, or a surface with fewer needle-shaped triangles"
    )]
    TooManySteps {
        /// Largest accepted number.
        steps_max: u64,
    },
    /// A triangle has no area.
    #[error("triangle {triangle} has no area")]
    DegenerateTriangle {
        /// Index of the triangle.
        triangle: u32,
    },
    /// An edge does not have exactly two triangles that run through it in opposite directions.
    #[error("edge of the vertices {edge:?} does not have exactly two triangles of the same orientation")]
    OpenEdge {
        /// Vertices of the edge.
        edge: [u32; 2],
    },
    /// The triangles around a vertex form more than one fan.
    #[error("triangles around vertex {vertex} form more than one fan")]
    NonManifoldVertex {
        /// Index of the vertex.
        vertex: u32,
    },
    /// Two triangles have a common point that no shared vertex or edge explains.
    #[error("triangles {first} and {second} intersect")]
    SelfIntersection {
        /// Lower index.
        first: u32,
        /// Higher index.
        second: u32,
    },
    /// Two points have the same coordinates.
    #[error("two points have the same coordinates {at}")]
    DuplicatePoint {
        /// Coordinates of both.
        at: Point3<f64>,
    },
    /// A point lies on an edge or a triangle of the surface that it is no corner of.
    #[error("point {at} lies on an edge or triangle of the surface; move it inside, or thicken the surface there")]
    PointOnSurface {
        /// Coordinates of the point.
        at: Point3<f64>,
    },
    /// A shell faces the wrong way: the region behind it would be counted twice, or less than once.
    #[error("surface has the winding number {winding} near {at}; each region must be inside once or not at all")]
    WrongOrientation {
        /// Winding number of the region.
        winding: i32,
        /// Corner of the region.
        at: Point3<f64>,
    },
    /// A constraint is not part of the mesh after all repair rounds.
    #[error("{kind} at {at} could not be recovered in {rounds} rounds; {missing} constraints are missing")]
    Unrecovered {
        /// Kind of the first missing constraint.
        kind: ConstraintKind,
        /// Center of the first missing constraint.
        at: Point3<f64>,
        /// Repair rounds used.
        rounds: u32,
        /// Number of missing constraints.
        missing: usize,
    },
}

impl ConformingError {
    /// Coordinates of the defect on the surface; `None` for limits.
    pub fn location(&self, positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> Option<Point3<f64>> {
        let vertex = |vertex: u32| positions.get(vertex as usize).copied();
        let first = |triangle: u32| vertex(triangles.get(triangle as usize)?[0]);
        let corners = |triangle: u32| {
            let own = *triangles.get(triangle as usize)?;
            Some((own, [vertex(own[0])?, vertex(own[1])?, vertex(own[2])?]))
        };
        match self {
            Self::InvalidPoint { point } => positions.get(*point).copied(),
            Self::DegenerateTriangle { triangle } => first(*triangle),
            Self::OpenEdge { edge } => vertex(edge[0]),
            Self::NonManifoldVertex { vertex: own } => vertex(*own),
            Self::SelfIntersection { first, second } => meeting_point(corners(*first)?, corners(*second)?),
            Self::DuplicatePoint { at }
            | Self::PointOnSurface { at }
            | Self::WrongOrientation { at, .. }
            | Self::Unrecovered { at, .. } => Some(*at),
            _ => None,
        }
    }
}
