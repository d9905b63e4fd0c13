//! Twenty defects that the fuzzer applies to meshes.

mod numbers;
mod shells;
#[cfg(test)]
mod tests;
mod triangles;

use super::draw::ChoiceStream;
use serde::Serialize;
use shatter_fracture::surface::RawMesh;
use std::fmt;
use std::str::FromStr;

/// Defect of a mesh; printed in `snake_case`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FuzzDefect {
    /// Coordinates that are not numbers.
    Nan,
    /// Infinite coordinates.
    Infinity,
    /// Coordinates of 1e30, a few or all.
    HugeCoordinate,
    /// Coordinates below the smallest normal number, a few or all.
    Denormal,
    /// Triangles whose vertex indices are out of range.
    IndexOutOfRange,
    /// Up to half of all triangles removed at random.
    DroppedTriangles,
    /// Triangles duplicated, with the same vertices or with copies of them.
    DuplicatedTriangles,
    /// Single triangles reversed.
    FlippedTriangles,
    /// One to four holes of at most a few percent of the area.
    SmallHoles,
    /// Parts pushed through others, swapped vertices, or a second copy askew.
    SelfIntersection,
    /// Flattened along one direction, completely or nearly.
    ZeroThickness,
    /// Every triangle reversed.
    InsideOut,
    /// A second copy, beside the first or overlapping it.
    TwoShells,
    /// A ball inside: a cavity or a solid.
    NestedShell,
    /// A vertex on an edge on one side only.
    TJunction,
    /// All vertices in one plane.
    Coplanar,
    /// A single triangle.
    SingleTriangle,
    /// A thousand to 1e18 diagonals from the origin.
    HugeOffset,
    /// A thousandth to 1e-80 of its size.
    TinyScale,
    /// A connected part reversed.
    MixedWinding,
}

/// Unknown name of a defect.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown defect '{0}'")]
pub struct UnknownDefect(String);

impl FuzzDefect {
    /// All defects.
    pub const ALL: [Self; 20] = [
        Self::Nan,
        Self::Infinity,
        Self::HugeCoordinate,
        Self::Denormal,
        Self::IndexOutOfRange,
        Self::DroppedTriangles,
        Self::DuplicatedTriangles,
        Self::FlippedTriangles,
        Self::SmallHoles,
        Self::SelfIntersection,
        Self::ZeroThickness,
        Self::InsideOut,
        Self::TwoShells,
        Self::NestedShell,
        Self::TJunction,
        Self::Coplanar,
        Self::SingleTriangle,
        Self::HugeOffset,
        Self::TinyScale,
        Self::MixedWinding,
    ];

    /// Whether the damaged mesh always keeps a clear inside, so that an error is never justified.
    pub fn must_accept(self) -> bool {
        matches!(
            self,
            Self::DuplicatedTriangles
                | Self::FlippedTriangles
                | Self::SmallHoles
                | Self::InsideOut
                | Self::TwoShells
                | Self::NestedShell
                | Self::TJunction
                | Self::MixedWinding
        )
    }

    /// Damages a mesh, which must be intact and have at least a few dozen triangles; strength, place and number follow from `seed`.
    pub fn apply(self, mesh: &RawMesh, seed: u64) -> RawMesh {
        let (mut damaged, mut draw) = (mesh.clone(), ChoiceStream::new(seed, self as u64));
        let (mesh, draw) = (&mut damaged, &mut draw);
        match self {
            Self::Nan => numbers::nan(mesh, draw),
            Self::Infinity => numbers::infinity(mesh, draw),
            Self::HugeCoordinate => numbers::huge(mesh, draw),
            Self::Denormal => numbers::denormal(mesh, draw),
            Self::IndexOutOfRange => numbers::index_out_of_range(mesh, draw),
            Self::DroppedTriangles => triangles::dropped(mesh, draw),
            Self::DuplicatedTriangles => triangles::duplicated(mesh, draw),
            Self::FlippedTriangles => triangles::flipped(mesh, draw),
            Self::SmallHoles => triangles::small_holes(mesh, draw),
            Self::SelfIntersection => shells::self_intersection(mesh, draw),
            Self::ZeroThickness => shells::zero_thickness(mesh, draw),
            Self::InsideOut => triangles::inside_out(mesh),
            Self::TwoShells => shells::two_shells(mesh, draw),
            Self::NestedShell => shells::nested_shell(mesh, draw),
            Self::TJunction => triangles::t_junction(mesh, draw),
            Self::Coplanar => shells::coplanar(mesh, draw),
            Self::SingleTriangle => triangles::single(mesh, draw),
            Self::HugeOffset => numbers::huge_offset(mesh, draw),
            Self::TinyScale => numbers::tiny_scale(mesh, draw),
            Self::MixedWinding => triangles::mixed_winding(mesh, draw),
        }
        damaged
    }
}

impl fmt::Display for FuzzDefect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

impl FromStr for FuzzDefect {
    type Err = UnknownDefect;

    fn from_str(word: &str) -> Result<Self, UnknownDefect> {
        let named = |defect: &Self| defect.to_string() == word;
        Self::ALL.into_iter().find(named).ok_or_else(|| UnknownDefect(word.to_owned()))
    }
}
