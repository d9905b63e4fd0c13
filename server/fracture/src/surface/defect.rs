//! Defects of input meshes.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Kind of a defect; `snake_case` in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DefectKind {
    /// Boundary loops. The index is a face at one of them.
    Holes,
    /// Shells that faced inward. The index is a face of one.
    FlippedShell,
    /// Triangles wound against their neighbors. The index is the first such face.
    MixedWinding,
    /// Edges across which no orientation is consistent, as on a Möbius strip. The index is a face at one.
    NonOrientable,
    /// Pairs of triangles that intersect without sharing a vertex. The index is a face of the first pair.
    SelfIntersection,
    /// More than one shell (triangles connected through edges that exactly two share). The
    /// index is a face of the second.
    SeveralShells,
    /// Shells inside other shells, cavities included. The index is a face of one.
    NestedShells,
    /// Triangles with the same three corners as an earlier one. The index is the first such face.
    DuplicateTriangles,
    /// Vertices at exactly the position of an earlier one. The index is the first such vertex.
    DuplicateVertices,
    /// Triangles without area. The index is the first such face.
    DegenerateTriangles,
    /// Edges of three or more triangles. The index is a face at one.
    NonManifoldEdge,
    /// Vertices where several fans of triangles touch (bow ties). The index is a face at one.
    NonManifoldVertex,
    /// Vertices of no triangle. The index is the first such vertex.
    UnreferencedVertices,
    /// Sample points whose winding number is near neither 0 nor 1. The index is the face nearest to the first.
    AmbiguousInside,
    /// Vertex attributes (normals, texture coordinates or materials) that were dropped.
    ///
    /// The file lacks them for some triangles, or has values that are not finite. The index is the first such face.
    LostAttributes,
    /// Vertices so far from the origin that rounding is visible in the shape. The index is the first such vertex.
    LostPrecision,
    /// Surface samples where the lattice lost the wall behind them. The index is the face where the wall is thinnest.
    ThinWall,
    /// Surface samples where the lattice closed the gap in front of them. The index is the
    /// face where the gap is narrowest.
    NarrowGap,
    /// Parts joined by less than the lattice resolves, which became separate bodies. The index is a face of one.
    SeveredPart,
    /// Crack-lattice nodes far from the elastic lattice, on limbs thinner than its spacing. The index is a face there.
    CoarseElastic,
    /// Components that the lattice lost. The index is the first of them.
    DroppedComponent,
    /// Sheets of existing cracks that cut nothing: outside the object, or smaller than the lattice resolves.
    ///
    /// The index is a face of one, counted in the file of the cracks.
    IdleCrack,
}

impl fmt::Display for DefectKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

impl DefectKind {
    /// Noun for the counted items, singular and plural.
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
            Self::LostAttributes => ["attribute", "attributes"],
            Self::ThinWall | Self::NarrowGap => ["sample of the surface", "samples of the surface"],
            Self::SeveredPart => ["part", "parts"],
            Self::CoarseElastic => ["crack node", "crack nodes"],
            Self::DroppedComponent => ["component", "components"],
            Self::IdleCrack => ["sheet", "sheets"],
        }
    }

    /// Noun for the item that [`Defect::first_index`] counts.
    fn indexed(self) -> &'static str {
        match self {
            Self::DuplicateVertices | Self::UnreferencedVertices | Self::LostPrecision => "vertex",
            _ => "face",
        }
    }
}

/// One kind of defect: its count, the first place and the action taken.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Defect {
    /// Kind of defect.
    pub kind: DefectKind,
    /// Number of occurrences.
    pub count: u64,
    /// Face or vertex to inspect in the input file, counted from 0; [`DefectKind`] states which.
    pub first_index: u64,
    /// Action taken, as a short phrase.
    pub action: String,
}

impl Defect {
    /// Creates a defect.
    pub fn new(kind: DefectKind, count: u64, first_index: u64, action: impl Into<String>) -> Self {
        Self { kind, count, first_index, action: action.into() }
    }

    /// Count with its noun, as in "3 triangles".
    pub fn counted(&self) -> String {
        let [one, several] = self.kind.counted();
        format!("{} {}", self.count, if self.count == 1 { one } else { several })
    }

    /// Item to inspect in the input file, as in "face 17".
    pub fn first(&self) -> String {
        format!("{} {}", self.kind.indexed(), self.first_index)
    }

    /// Defect for components too thin or too small for the lattice spacing.
    pub fn dropped_component(count: u64, first_index: u64) -> Self {
        Self::new(DefectKind::DroppedComponent, count, first_index, "left out: smaller than the lattice spacing")
    }
}

/// Counter of occurrences of one defect, which keeps the lowest index.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DefectTally {
    count: u64,
    first: Option<u64>,
}

impl DefectTally {
    /// Counts one more occurrence and keeps the lowest index.
    pub fn note(&mut self, index: u64) {
        self.count += 1;
        self.first = Some(self.first.map_or(index, |first| first.min(index)));
    }

    /// Adds the counts of another tally.
    pub fn merge(&mut self, other: &Self) {
        if let Some(first) = other.first {
            self.note(first);
            self.count += other.count - 1;
        }
    }

    /// Number of occurrences.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Appends a defect of `kind` if any occurrence was counted.
    pub fn report(&self, kind: DefectKind, action: impl Into<String>, defects: &mut Vec<Defect>) {
        if let Some(first) = self.first {
            defects.push(Defect::new(kind, self.count, first, action));
        }
    }
}
