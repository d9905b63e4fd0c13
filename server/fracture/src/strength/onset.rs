//! The criterion: strength and energy, at one place of one body.
//!
//! With the largest averaged stress σ̄, the strain energy U, the toughness G_c and the smallest section A_min through the
//! place, a body breaks only if
//!
//! ```text
//! σ̄ ≥ σ_t   and   U ≥ G_c A_min.
//! ```
//!
//! Stresses are linear in the loads and energies quadratic, so the factor on all loads at which it just breaks is
//! max(σ_t/σ̄, √(G_c A_min/U)).

use crate::degree::Slenderness;
use serde::{Deserialize, Serialize};

/// Rule that decides whether an object breaks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Criterion {
    /// That of the paper: the first moment of the energy exceeds γ.
    #[default]
    Paper,
    /// Strength and energy.
    Strength,
}

impl Criterion {
    /// All criteria.
    pub const ALL: [Self; 2] = [Self::Paper, Self::Strength];

    /// Its name on command lines and in scenes.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Strength => "strength",
        }
    }
}

/// Onset at one place of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Onset {
    /// σ̄/σ_t.
    pub stress_over_strength: f64,
    /// U/(G_c A_min); 0 if no section leaves a piece that is large enough on both sides.
    pub energy_over_section: f64,
    /// A_min, m²; 0 without a section.
    pub section_m2: f64,
}

impl Onset {
    /// Factor on all loads at which the body just breaks here; infinite if it never does.
    pub fn load_factor(&self) -> f64 {
        let inverse = |value: f64| if value > 0.0 { 1.0 / value } else { f64::INFINITY };
        inverse(self.stress_over_strength).max(inverse(self.energy_over_section).sqrt())
    }

    /// True if both conditions hold.
    pub fn breaks(&self) -> bool {
        self.stress_over_strength >= 1.0 && self.energy_over_section >= 1.0
    }
}

/// Number of dimensions in which cells of a body of this shape and `volume` lie beside each other: 1 in rods, 2 in plates.
pub fn cell_dimension(shape: &Slenderness, volume: f64) -> u32 {
    /// Length over width, or width over thickness, above which a body is slender.
    const SLENDER: f64 = 4.0;
    let length = volume / shape.section;
    let side = (volume / shape.thickness).sqrt();
    match () {
        () if length > SLENDER * shape.section.sqrt() => 1,
        () if side > SLENDER * shape.thickness => 2,
        () => 3,
    }
}

/// Largest number of cells whose cracks have at most `ratio` times the area of the cracks of `known` cells, if the area
/// follows n^(1/D) − 1 with the dimension D of [`cell_dimension`]; at least 1.
pub fn affordable_count(known: u32, ratio: f64, dimension: u32) -> u32 {
    let (power, cells) = (f64::from(dimension), f64::from(known));
    let side = 1.0 + ratio.max(0.0) * (cells.powf(1.0 / power) - 1.0);
    // A count that is whole but for rounding counts as whole.
    (side.powf(power) * (1.0 + 1e-12)).floor().clamp(1.0, f64::from(u32::MAX)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::block;

    #[test]
    fn both_conditions_are_necessary() {
        let onset = |stress_over_strength, energy_over_section| Onset {
            stress_over_strength,
            energy_over_section,
            section_m2: 1.0,
        };
        assert!(onset(1.0, 1.0).breaks() && !onset(0.99, 9.0).breaks() && !onset(9.0, 0.99).breaks());
        assert_eq!(onset(0.5, 100.0).load_factor(), 2.0);
        assert_eq!(onset(2.0, 0.25).load_factor(), 2.0);
        assert_eq!(onset(2.0, 0.0).load_factor(), f64::INFINITY);
        assert_eq!(onset(-1.0, 1.0).load_factor(), f64::INFINITY);
    }

    #[test]
    fn rods_plates_and_blocks_have_their_dimension() {
        let dimension = |cells: [usize; 3]| {
            let lattice = block(cells, 0.05);
            cell_dimension(&Slenderness::of(&lattice), lattice.volume())
        };
        assert_eq!([dimension([20, 2, 2]), dimension([14, 14, 1]), dimension([6, 6, 5])], [1, 2, 3]);
    }

    #[test]
    fn affordable_counts_follow_the_area_of_their_cracks() {
        // A rod of n pieces has n − 1 cracks; 64 cubes of a cube have 9/3 times the cracks of 8.
        assert_eq!(affordable_count(2, 5.0, 1), 6);
        assert_eq!(affordable_count(8, 3.0, 3), 64);
        assert_eq!(affordable_count(64, 1.0 / 3.0, 3), 8);
        assert_eq!([affordable_count(2, 0.9, 3), affordable_count(2, 1.0, 3)], [1, 2]);
    }
}
