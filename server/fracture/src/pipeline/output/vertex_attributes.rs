//! Attributes of the fragments' outer faces, taken from the input, with the effect `attributes`.

use super::outer_attributes::OuterRunAttributes;
use crate::pipeline::workspace::body_meshes::BodyMeshes;
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
    /// Material of the input, or [`NO_MATERIAL`], for each triangle of the result; empty if the input has none.
    pub materials: Vec<u32>,
}

impl VertexAttributes {
    /// The attributes of fragments whose outer runs have `outer`, by body and fragment.
    pub(in crate::pipeline) fn of(bodies: &[BodyMeshes], outer: &[Vec<OuterRunAttributes>]) -> Self {
        let mut attributes = Self::default();
        let has_materials = outer.iter().flatten().any(|own| !own.materials.is_empty());
        for (pieces, outer) in bodies.iter().zip(outer) {
            for run in pieces.tessellation.runs() {
                let own = &outer[run.fragment as usize];
                if !run.crack {
                    attributes.vertices.extend_from_slice(&own.vertices);
                    attributes.materials.extend_from_slice(&own.materials);
                    continue;
                }
                attributes
                    .vertices
                    .resize(attributes.vertices.len() + run.vertices.len(), OuterVertexAttributes::default());
                if has_materials {
                    attributes.materials.resize(attributes.materials.len() + run.triangles.len(), NO_MATERIAL);
                }
            }
        }
        attributes
    }

    /// Size of the tables in bytes.
    pub(in crate::pipeline) fn bytes(&self) -> usize {
        size_of_val(self.vertices.as_slice()) + size_of_val(self.materials.as_slice())
    }
}
