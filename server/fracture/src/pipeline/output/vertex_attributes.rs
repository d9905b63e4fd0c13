//! Attributes of the fragments' outer faces, taken from the input, with the effect `attributes`.

use super::outer_attributes::OuterRunAttributes;
use crate::pipeline::workspace::body_meshes::BodyMeshes;
use crate::skin::{AttributeKinds, PointAttributes};
use crate::surface::NO_MATERIAL;

/// Attributes of a vertex of an outer face; zero on crack faces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OuterVertexAttributes {
    /// Unit normal.
    pub normal: [f32; 3],
    /// Texture coordinates of the input; zero if it has none.
    pub uv: [f32; 2],
}

/// Attributes of all fragments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexAttributes {
    /// Attributes, one per vertex of the result.
    pub vertices: Vec<OuterVertexAttributes>,
    /// Second texture coordinates of the input, one per vertex, zero on crack faces; empty if it has none.
    pub uvs2: Vec<[f32; 2]>,
    /// Red, green, blue and alpha of the input, one per vertex, white on crack faces; empty if it has none.
    pub colors: Vec<[u8; 4]>,
    /// Material of the input, or [`NO_MATERIAL`], for each triangle of the result; empty if the input has none.
    pub materials: Vec<u32>,
}

impl VertexAttributes {
    /// The attributes of fragments whose outer runs have `outer`, by body and fragment.
    pub(in crate::pipeline) fn of(bodies: &[BodyMeshes], outer: &[Vec<OuterRunAttributes>]) -> Self {
        let mut attributes = Self::default();
        let kinds = outer_kinds(outer);
        let has_materials = outer.iter().flatten().any(|own| !own.materials.is_empty());
        for (pieces, outer) in bodies.iter().zip(outer) {
            for run in pieces.tessellation.runs() {
                let own = &outer[run.fragment as usize];
                if !run.crack {
                    (0..own.vertices.len()).for_each(|vertex| attributes.push(&own.vertices.get(vertex), kinds));
                    attributes.materials.extend_from_slice(&own.materials);
                    continue;
                }
                run.vertices.clone().for_each(|_| attributes.push(&PointAttributes::default(), kinds));
                if has_materials {
                    attributes.materials.resize(attributes.materials.len() + run.triangles.len(), NO_MATERIAL);
                }
            }
        }
        attributes
    }

    fn push(&mut self, point: &PointAttributes, kinds: AttributeKinds) {
        self.vertices.push(OuterVertexAttributes { normal: point.normal, uv: point.uvs[0] });
        self.uvs2.extend(kinds.uvs[1].then_some(point.uvs[1]));
        self.colors.extend(kinds.colors.then(|| point.color_bytes()));
    }

    /// Size of the tables in bytes.
    pub(in crate::pipeline) fn bytes(&self) -> usize {
        let Self { vertices, uvs2, colors, materials } = self;
        let tables = size_of_val(vertices.as_slice()) + size_of_val(uvs2.as_slice());
        tables + size_of_val(colors.as_slice()) + size_of_val(materials.as_slice())
    }
}

/// Kinds of attributes of any of these runs: those of the input.
pub(super) fn outer_kinds(outer: &[Vec<OuterRunAttributes>]) -> AttributeKinds {
    outer.iter().flatten().map(|own| own.vertices.kinds()).fold(AttributeKinds::default(), AttributeKinds::or)
}
