//! Selection of an object's tables. Unselected ones are neither read nor loaded.

use serde::{Deserialize, Serialize};

/// Optional tables of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tables {
    /// Elasticity: coarser lattice, transfer to the crack lattice, reduced basis, bound of E_1.
    pub elastic: bool,
    /// Lift of interior distances.
    pub interior: bool,
    /// Lift of surface diffusion distances.
    pub surface_diffusion: bool,
    /// Examples, and the model learned from them.
    pub examples: bool,
    /// Attributes of the input on the crack lattices' boundaries.
    pub attributes: bool,
    /// Triangles of the input.
    pub skin: bool,
}

impl Default for Tables {
    fn default() -> Self {
        Self::ALL
    }
}

impl Tables {
    /// All tables.
    pub const ALL: Self =
        Self { elastic: true, interior: true, surface_diffusion: true, examples: true, attributes: true, skin: true };

    /// No tables.
    pub const NONE: Self = Self {
        elastic: false,
        interior: false,
        surface_diffusion: false,
        examples: false,
        attributes: false,
        skin: false,
    };

    /// Union of both selections.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            elastic: self.elastic || other.elastic,
            interior: self.interior || other.interior,
            surface_diffusion: self.surface_diffusion || other.surface_diffusion,
            examples: self.examples || other.examples,
            attributes: self.attributes || other.attributes,
            skin: self.skin || other.skin,
        }
    }

    /// True if the tensor of this name belongs to a selected table or to no table.
    pub(super) fn want(self, tensor: &str) -> bool {
        let (owner, part) = tensor.split_once('.').unwrap_or((tensor, ""));
        match owner {
            "examples" | "network" => self.examples,
            "skin" => self.skin,
            _ if owner.starts_with("reduced") => self.elastic,
            _ if part.starts_with("cutting.outer.") => self.attributes || self.skin,
            _ => match part.split('.').next() {
                Some("elastic" | "transfer") => self.elastic,
                Some("outer") => self.attributes,
                Some("interior") => self.interior,
                Some("surface_diffusion") => self.surface_diffusion,
                _ => true,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tensors_belong_to_tables() {
        let none = Tables::NONE;
        let tensors = [
            ("body0.elastic.nodes", Tables { elastic: true, ..none }),
            ("body0.elastic.bound", Tables { elastic: true, ..none }),
            ("body12.transfer.shares", Tables { elastic: true, ..none }),
            ("reduced0.basis", Tables { elastic: true, ..none }),
            ("body3.interior", Tables { interior: true, ..none }),
            ("body3.surface_diffusion", Tables { surface_diffusion: true, ..none }),
            ("body3.outer.uvs", Tables { attributes: true, ..none }),
            ("body0.cutting.outer.uvs", Tables { attributes: true, ..none }),
            ("body0.cutting.outer.uvs", Tables { skin: true, ..none }),
            ("skin.triangles", Tables { skin: true, ..none }),
            ("examples.heads", Tables { examples: true, ..none }),
            ("network.mean", Tables { examples: true, ..none }),
        ];
        for (tensor, table) in tensors {
            assert!(table.want(tensor) && Tables::ALL.want(tensor) && !none.want(tensor), "{tensor}");
        }
        assert!(none.want("body0.crack.tets") && none.want("body0.cutting.tets"));
    }
}
