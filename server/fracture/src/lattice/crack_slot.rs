//! Slots: what is cut out of a shape along cracks that have no width, so that a lattice keeps their sides apart.

use super::level::{LatticeLevel, stuff};
use super::levels::{LatticeLevels, Spacings, levels_by};
use super::{LatticeError, SignedDistance};
use crate::cancel_token::CancelToken;
use nalgebra::Point3;

/// Half the width of a slot over the spacing.
///
/// No edge of the lattice then leads from one side of a crack to the other: its ends lie half a width from the crack at
/// least, so it would be 1.7 spacings long, and stuffing makes no edge longer than 1.69: the longest of the grid, 1, and
/// what both of its ends may be warped, 0.345 each. Measured on 200 sheets in random places: at 0.5 and, near the ends of
/// cracks, at 0.65 some edges lead across, from 0.7 on none. Slots that are cut short where a crack ends keep that up to half a
/// width from there.
pub const SLOT_HALF: f64 = 0.85;

/// How deep a point lies in the slots of a half width: positive within them, never more than the distance to their
/// rim; all local.
pub type SlotDepth<'a> = dyn Fn(&Point3<f64>, f64) -> f64 + Sync + 'a;

/// A shape, moved outward by `offset`, without its slots.
struct Slotted<'a> {
    shape: &'a dyn SignedDistance,
    depth: &'a SlotDepth<'a>,
    offset: f64,
    half: f64,
}

impl SignedDistance for Slotted<'_> {
    fn signed_distance(&self, point: &Point3<f64>) -> f64 {
        (self.shape.signed_distance(point) - self.offset).max((self.depth)(point, self.half))
    }

    fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        self.shape.bounds()
    }
}

/// As [`stuff`] to a volume, then without slots of [`SLOT_HALF`]: apart from them the lattice is the one without cracks.
/// `volume` (local, positive) is that of the shape without slots.
///
/// # Errors
/// Those of [`stuff`].
pub fn stuff_slotted(
    shape: &dyn SignedDistance,
    depth: &SlotDepth,
    spacing: f64,
    volume: f64,
    token: &CancelToken,
) -> Result<LatticeLevel, LatticeError> {
    let offset = stuff(shape, spacing, Some(volume), token)?.offset;
    stuff(&Slotted { shape, depth, offset, half: SLOT_HALF * spacing }, spacing, None, token)
}

/// As [`super::levels`], with slots on both levels, each as wide as its own spacing asks; nothing is fitted, since no edge may become
/// longer.
///
/// # Errors
/// Those of [`stuff`].
pub fn slotted_levels(
    shape: &dyn SignedDistance,
    depth: &SlotDepth,
    spacings: Spacings,
    volume: f64,
    token: &CancelToken,
) -> Result<LatticeLevels, LatticeError> {
    let stuffed = |spacing| stuff_slotted(shape, depth, spacing, volume, token);
    levels_by(stuffed(spacings.crack)?, &stuffed, spacings, token)
}

#[cfg(test)]
#[path = "crack_slot_tests.rs"]
mod tests;
