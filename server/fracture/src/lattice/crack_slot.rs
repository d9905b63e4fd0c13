//! Slots along existing cracks: cuts of finite width that keep the two sides of a crack apart in a lattice.

use super::level::{LatticeLevel, stuff};
use super::levels::{LatticeLevels, Spacings, levels_by};
use super::{LatticeError, SignedDistance, TurnedBox};
use crate::cancel_token::CancelToken;
use nalgebra::Point3;

/// Half width of a slot over the spacing.
///
/// With it, no lattice edge crosses a crack. An edge that does has both ends at least half a width away from the crack,
/// so it is at least 1.7 spacings long. Stuffing makes no edge longer than 1.69: 1 for the longest grid edge, plus
/// 0.345 for the warp of each end.
///
/// Measured on 200 sheets in random places: some edges cross at 0.5 and, near the ends of cracks, at 0.65; none from
/// 0.7 on. Slots that are shortened at the end of a crack ensure this up to half a width from the end.
pub const SLOT_HALF: f64 = 0.85;

/// Depth of a point inside the slots of a half width; positive inside, at most the distance to their rim. All local.
pub type SlotDepth<'a> = dyn Fn(&Point3<f64>, f64) -> f64 + Sync + 'a;

/// Shape, offset outward by `offset`, without its slots.
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

    fn turned_box(&self) -> Option<TurnedBox> {
        self.shape.turned_box()
    }
}

/// As [`stuff`] to a volume, with slots of half width [`SLOT_HALF`] · `spacing` removed.
///
/// Away from the slots, the lattice equals that of the shape without cracks. `volume` (local, positive) is that of the
/// shape without slots.
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

/// As [`super::levels`], with slots on both levels, each sized for its own spacing.
///
/// The boundary is not fitted, because no edge may become longer.
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
