//! Existing cracks of an object: sheets without width, along which slots are cut into both lattices.

use super::bake_error::{BakeError, GONE_MAX};
use crate::cancel_token::CancelToken;
use crate::lattice::{self, LatticeError, LatticeLevels, SLOT_HALF, SignedDistance, Spacings};
use crate::pipeline::{BakeReport, ExistingCracks};
use crate::surface::{CrackSheets, Defect, DefectKind, InsideTest, Surface};
use nalgebra::Point3;

/// Shape into which slots are cut.
pub(super) struct UncrackedShape<'a> {
    /// Surface of the input.
    pub surface: &'a Surface,
    /// Inside test of that surface.
    pub inside: &'a InsideTest,
    /// Lattices without slots, and the volume (local) to which they were fitted.
    pub levels: &'a LatticeLevels,
    pub volume: f64,
    /// Requested spacings.
    pub spacings: Spacings,
}

impl UncrackedShape<'_> {
    /// The lattices with slots along `sheets`. Adds figures of the cracks to the report.
    ///
    /// # Errors
    /// [`BakeError::CracksMiss`], [`BakeError::CracksTooSmall`], [`BakeError::CracksTakeAll`], those of the lattices.
    pub(super) fn slotted(
        &self,
        sheets: &CrackSheets,
        report: &mut BakeReport,
        token: &CancelToken,
    ) -> Result<LatticeLevels, BakeError> {
        let spacing = self.levels.crack.spacing;
        let nodes: Vec<Point3<f64>> =
            self.levels.bodies.iter().flat_map(|body| body.crack.nodes.iter().copied()).collect();
        let idle = sheets.idle(self.inside, &nodes, SLOT_HALF * spacing);
        if idle.as_ref().is_some_and(|idle| idle.count == sheets.count()) {
            return Err(self.without_effect(sheets));
        }
        let depth = |point: &Point3<f64>, half: f64| sheets.slot_depth(self.inside, point, half);
        let slotted = lattice::slotted_levels(self.inside, &depth, self.spacings, self.volume, token);
        let (before, take_all) = (self.levels.crack.volume, |percent| BakeError::CracksTakeAll { percent, spacing });
        let slotted = slotted.map_err(|error| match error {
            LatticeError::NothingInside { .. } => take_all(100.0),
            error => error.into(),
        })?;
        let lost = before - slotted.crack.volume;
        if lost > GONE_MAX * before {
            return Err(take_all(100.0 * lost / before));
        }
        let frame = &self.surface.frame;
        report.cracks = Some(ExistingCracks {
            triangles: sheets.triangles().len() as u64,
            area_m2: sheets.area() * frame.diagonal_m.powi(2),
            width_m: 2.0 * SLOT_HALF * spacing * frame.diagonal_m,
            elastic_width_m: 2.0 * SLOT_HALF * elastic_spacing(&slotted) * frame.diagonal_m,
            // Only the lattice without slots is fitted to the boundary, so that its volume may be the smaller one.
            volume_m3: lost.max(0.0) * frame.diagonal_m.powi(3),
        });
        report.lattice_volume_m3 -= lost * frame.diagonal_m.powi(3);
        report.defects.extend(sheets.defects.iter().cloned());
        report.defects.extend(idle);
        report.defects.extend(self.splinters(&slotted));
        Ok(slotted)
    }

    /// The error for sheets of which none opens a slot.
    fn without_effect(&self, sheets: &CrackSheets) -> BakeError {
        let (frame, spacing) = (&self.surface.frame, self.levels.crack.spacing);
        let corners = || sheets.triangles().iter().flatten();
        let distance = corners().map(|corner| self.inside.signed_distance(corner)).fold(f64::INFINITY, f64::min);
        if distance <= 0.0 {
            let (width, size) = (2.0 * SLOT_HALF * spacing, sheets.area().sqrt());
            return BakeError::CracksTooSmall {
                spacing,
                width_m: width * frame.diagonal_m,
                size_m: size * frame.diagonal_m,
            };
        }
        let meters =
            |(low, high): (Point3<f64>, Point3<f64>)| [low, high].map(|corner| frame.to_meters(&corner).into());
        BakeError::CracksMiss {
            distance_m: distance * frame.diagonal_m,
            sheets_m: meters(sheets.bounds()),
            object_m: meters(self.inside.bounds()),
        }
    }

    /// Parts between slots and the surface, or other slots, that are too small for a body.
    fn splinters(&self, slotted: &LatticeLevels) -> Option<Defect> {
        let more = slotted.crack.dropped.len().checked_sub(self.levels.crack.dropped.len()).filter(|more| *more > 0)?;
        let first = self.inside.nearest_face(&slotted.crack.dropped.first()?.place);
        let action = "left out: splinters beside cracks, smaller than the lattice spacing";
        Some(Defect::new(DefectKind::DroppedComponent, more as u64, first, action))
    }
}

/// Spacing of the elastic lattice, local.
pub(super) fn elastic_spacing(levels: &LatticeLevels) -> f64 {
    levels.elastic.as_ref().map_or(levels.crack.spacing, |level| level.spacing)
}
