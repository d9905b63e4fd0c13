//! What was wrong with a mesh, by name.

use serde::{Deserialize, Serialize};
use std::fmt;

/// The kinds of defects, `snake_case` in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DefectKind {
    /// Boundary loops; the index is a face at one of them.
    Holes,
    /// Shells that faced inward; the index is a face of one.
    FlippedShell,
    /// Triangles wound against their neighbors; the index is the first such face.
    MixedWinding,
    /// Edges across which no orientation is consistent, as on a Möbius strip; the index is a face at one.
    NonOrientable,
    /// Pairs of triangles that intersect without sharing a vertex; the index is a face of the first pair.
    SelfIntersection,
    /// More than one shell (triangles connected through edges that exactly two share); the index is a face of the second.
    SeveralShells,
    /// Shells inside other shells, cavities among them; the index is a face of one.
    NestedShells,
    /// Triangles with the same three corners as an earlier one; the index is the first such face.
    DuplicateTriangles,
    /// Vertices at exactly the position of an earlier one; the index is the first such vertex.
    DuplicateVertices,
    /// Triangles without area; the index is the first such face.
    DegenerateTriangles,
    /// Edges of three or more triangles; the index is a face at one.
    NonManifoldEdge,
    /// Vertices where several fans of triangles touch (a bow tie); the index is a face at one.
    NonManifoldVertex,
    /// Vertices of no triangle; the index is the first such vertex.
    UnreferencedVertices,
    /// Sample points whose winding number is near neither 0 nor 1; the index is the face nearest to the first.
    AmbiguousInside,
    /// Normals, texture coordinates or materials that the file has for some triangles, or not in finite numbers, and that are left
    /// out therefore; the index is the first face without.
    LostLooks,
    /// Vertices that lie so far from the origin that rounding shows in the shape; the index is the first such vertex.
    LostPrecision,
    /// Points of the surface whose wall the lattice lost; the index is the face where it is thinnest.
    ThinWall,
    /// Points of the surface before which the lattice closed a gap; the index is the face where it is narrowest.
    NarrowGap,
    /// Parts joined by less than the lattice resolves, which became bodies of their own; the index is a face of one.
    SeveredPart,
    /// Crack nodes far from the lattice that they are solved on: limbs thinner than its spacing; the index is a face there.
    CoarseElastic,
    /// Components that the lattice lost; the index is the first of them.
    DroppedComponent,
    /// Sheets of existing cracks that cut nothing: outside of the object, or smaller than the lattice resolves; the index is a face
    /// of one, in their own file.
    IdleCrack,
}

impl fmt::Display for DefectKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

impl DefectKind {
    /// What is counted, one of them and several.
    fn counted(self) -> [&'static str; 2] {
        match self {
            Self::Holes => ["hole", "holes"],
            Self::FlippedShell | Self::SeveralShells | Self::NestedShells => ["shell", "shells"],
            Self::MixedWinding | Self::DuplicateTriangles | Self::DegenerateTriangles => ["triangle", "triangles"],
            Self::NonOrientable | Self::NonManifoldEdge => ["edge", "edges"],
            Self::SelfIntersection => ["pair of triangles", "pairs of triangles"],
            Self::DuplicateVertices | Self::NonManifoldVertex | Self::UnreferencedVertices | Self::LostPrecision => {
                ["vertex", "vertices"]
            }
            Self::AmbiguousInside => ["sample point", "sample points"],
            Self::LostLooks => ["attribute", "attributes"],
            Self::ThinWall | Self::NarrowGap => ["sample of the surface", "samples of the surface"],
            Self::SeveredPart => ["part", "parts"],
            Self::CoarseElastic => ["crack node", "crack nodes"],
            Self::DroppedComponent => ["component", "components"],
            Self::IdleCrack => ["sheet", "sheets"],
        }
    }

    /// What [`Defect::first_index`] counts.
    fn indexed(self) -> &'static str {
        match self {
            Self::DuplicateVertices | Self::UnreferencedVertices | Self::LostPrecision => "vertex",
            _ => "face",
        }
    }
}

/// One kind of defect, how often, where first, and what was done about it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Defect {
    /// What.
    pub kind: DefectKind,
    /// How many.
    pub count: u64,
    /// Something to look at in the input file: a face or a vertex counted from 0, as [`DefectKind`] says.
    pub first_index: u64,
    /// What was done, a short phrase.
    pub action: String,
}

impl Defect {
    /// A defect of any kind.
    pub fn new(kind: DefectKind, count: u64, first_index: u64, action: impl Into<String>) -> Self {
        Self { kind, count, first_index, action: action.into() }
    }

    /// How many there are of what, as in "3 triangles".
    pub fn counted(&self) -> String {
        let [one, several] = self.kind.counted();
        format!("{} {}", self.count, if self.count == 1 { one } else { several })
    }

    /// What to look at in the input file, as in "face 17".
    pub fn first(&self) -> String {
        format!("{} {}", self.kind.indexed(), self.first_index)
    }

    /// What the lattice reports when components were too thin or too small for its spacing.
    pub fn dropped_component(count: u64, first_index: u64) -> Self {
        Self::new(DefectKind::DroppedComponent, count, first_index, "left out: smaller than the lattice spacing")
    }
}

/// Collects a list of places of one kind: their number and the first.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DefectTally {
    count: u64,
    first: Option<u64>,
}

impl DefectTally {
    /// Counts one more; the lowest index is kept.
    pub fn note(&mut self, index: u64) {
        self.count += 1;
        self.first = Some(self.first.map_or(index, |first| first.min(index)));
    }

    /// Counts what another tally counted, too.
    pub fn merge(&mut self, other: &Self) {
        if let Some(first) = other.first {
            self.note(first);
            self.count += other.count - 1;
        }
    }

    /// How many were noted.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Appends the defect, if there is any.
    pub fn report(&self, kind: DefectKind, action: impl Into<String>, defects: &mut Vec<Defect>) {
        if let Some(first) = self.first {
            defects.push(Defect::new(kind, self.count, first, action));
        }
    }
}
