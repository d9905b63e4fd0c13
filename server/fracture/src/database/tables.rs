//! Which tables of an object are wanted: the others are neither looked at nor held.

use serde::{Deserialize, Serialize};

/// The tables that an object can do without.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tables {
    /// Elasticity: coarser lattice, its operator to the crack lattice, reduced basis, bound.
    pub elastic: bool,
    /// The lift with interior distances.
    pub interior: bool,
    /// The lift with diffusion distances on the surface.
    pub surface_diffusion: bool,
    /// Examples, and what was learned from them.
    pub examples: bool,
    /// How the input looks on the crack lattices' boundaries.
    pub attributes: bool,
    /// The input's own triangles.
    pub skin: bool,
}

impl Default for Tables {
    fn default() -> Self {
        Self::ALL
    }
}

impl Tables {
    /// All of them.
    pub const ALL: Self =
        Self { elastic: true, interior: true, surface_diffusion: true, examples: true, attributes: true, skin: true };

    /// None of them.
    pub const NONE: Self = Self {
        elastic: false,
        interior: false,
        surface_diffusion: false,
        examples: false,
        attributes: false,
        skin: false,
    };

    /// These and those.
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

    /// True if the tensor of this name is wanted.
    pub(super) fn want(self, tensor: &str) -> bool {
        let (owner, part) = tensor.split_once('.').unwrap_or((tensor, ""));
        match owner {
            "examples" | "network" => self.examples,
            "skin" => self.skin,
            _ if owner.starts_with("reduced") => self.elastic,
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
            ("skin.triangles", Tables { skin: true, ..none }),
            ("examples.heads", Tables { examples: true, ..none }),
            ("network.mean", Tables { examples: true, ..none }),
        ];
        for (tensor, table) in tensors {
            assert!(table.want(tensor) && Tables::ALL.want(tensor) && !none.want(tensor), "{tensor}");
        }
        assert!(none.want("body0.crack.tets"));
    }
}
