//! One lattice level: from a signed distance to bodies that are valid for solving and cutting.

use super::cut::Cutter;
use super::grid::Grid;
use super::manifold_repair::repair_manifold;
use super::stuffing::fill;
use super::{Lattice, LatticeError, SignedDistance};
use crate::cancel_token::CancelToken;
use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

/// Smallest share of the lattice's volume that a component must have to be kept. The largest is kept in any case.
pub const BODY_SHARE_MIN: f64 = 1e-3;

/// Smallest number of tetrahedra that a component must have to be kept. The largest is kept in any case.
pub const BODY_TETS_MIN: usize = 12;

/// Largest deviation of the lattice's volume from the requested one, as a share of it.
pub const VOLUME_TOLERANCE: f64 = 1e-3;

/// Largest number of offsets tried to meet a volume.
const OFFSETS_MAX: usize = 8;

/// Component that was left out of a level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DroppedComponent {
    /// Volume, local.
    pub volume: f64,
    /// Number of tetrahedra.
    pub tets: usize,
    /// Center of volume, local.
    pub place: Point3<f64>,
}

/// Bodies of a shape at one spacing.
#[derive(Clone, Debug)]
pub struct LatticeLevel {
    /// Bodies, by decreasing volume. Each satisfies the invariants of [`Lattice`].
    pub bodies: Vec<Lattice>,
    /// Dropped components ([`BODY_SHARE_MIN`], [`BODY_TETS_MIN`]), by decreasing volume.
    pub dropped: Vec<DroppedComponent>,
    /// Number of places where the boundary was not a 2-manifold before repair.
    pub pinches_mended: usize,
    /// Volume of the tetrahedra that the repair dropped, local.
    pub mended_volume: f64,
    /// Offset of the meshed level set, signed distance = offset; local.
    pub offset: f64,
    /// Side of the grid's cubes, local.
    pub spacing: f64,
}

impl LatticeLevel {
    /// Volume of all bodies, local.
    pub fn volume(&self) -> f64 {
        self.bodies.iter().map(Lattice::volume).sum()
    }

    /// Number of nodes of all bodies.
    pub fn node_count(&self) -> usize {
        self.bodies.iter().map(|body| body.nodes.len()).sum()
    }

    /// Number of tetrahedra of all bodies.
    pub fn tet_count(&self) -> usize {
        self.bodies.iter().map(|body| body.tets.len()).sum()
    }
}

/// Fills a shape with tetrahedra on a body-centered cubic grid of cubes of side `spacing` (local).
///
/// Without `volume` the surface is the level set signed distance = 0. With it (local, positive), it is a level set
/// within half a spacing, chosen so that the bodies have that volume to 0.1 %. This compensates chords, which cut up to
/// a seventh off thin limbs. If no level set has that volume, the nearest is taken; see [`LatticeLevel::volume`].
///
/// Every dihedral angle lies within [10.7°, 164.8°] (Labelle & Shewchuk 2007). The result depends only on the
/// arguments. Errors: see [`LatticeError`].
///
/// # Errors
/// See [`LatticeError`].
pub fn stuff(
    shape: &dyn SignedDistance,
    spacing: f64,
    volume: Option<f64>,
    token: &CancelToken,
) -> Result<LatticeLevel, LatticeError> {
    if let Some(volume) = volume.filter(|volume| !(volume.is_finite() && *volume > 0.0)) {
        return Err(LatticeError::VolumeNotPositive { volume });
    }
    let grid = Grid::over(shape, spacing)?;
    let values = grid.sample(shape, token)?;
    let mut cutter = Cutter::new(shape, &grid, &values);
    let mut level_at = |offset: f64| {
        let cuts = cutter.cut(offset, token)?;
        token.check()?;
        Ok(split(&fill(&grid, &values, offset, &cuts), offset, spacing))
    };
    let level = match volume {
        None => level_at(0.0)?,
        Some(volume) => meet_volume(level_at, volume, spacing)?,
    };
    if level.bodies.is_empty() { Err(LatticeError::NothingInside { spacing }) } else { Ok(level) }
}

/// Meets a volume by safeguarded secant steps on the offset, from 0 and with the boundary's area as the first slope.
fn meet_volume(
    mut level_at: impl FnMut(f64) -> Result<LatticeLevel, LatticeError>,
    volume: f64,
    spacing: f64,
) -> Result<LatticeLevel, LatticeError> {
    let mut best = level_at(0.0)?;
    let (mut low, mut high) = (-0.5 * spacing, 0.5 * spacing);
    let (mut offset, mut reached) = (0.0, best.volume());
    let area: f64 = best.bodies.iter().map(Lattice::boundary_area).sum();
    let mut slope = area;
    for _ in 1..OFFSETS_MAX {
        let missing = volume - reached;
        if missing.abs() <= VOLUME_TOLERANCE * volume || slope <= 0.0 {
            break;
        }
        if missing > 0.0 {
            low = offset
        } else {
            high = offset
        }
        let step = (offset + missing / slope).clamp(low, high);
        // The ends of the range may be tried; an offset that was tried before is replaced by the middle of the range.
        let next = if step == offset { 0.5 * (low + high) } else { step };
        if next == offset {
            break;
        }
        let level = level_at(next)?;
        let secant = (level.volume() - reached) / (next - offset);
        slope = secant.clamp(area / 3.0, area * 3.0);
        (offset, reached) = (next, level.volume());
        if (volume - reached).abs() < (volume - best.volume()).abs() {
            best = level;
        }
    }
    Ok(best)
}

/// Splits a filled grid into face-connected bodies.
///
/// Drops tiny components, repairs the boundary of the others, and splits again what the repair separated.
pub(super) fn split(filled: &Lattice, offset: f64, spacing: f64) -> LatticeLevel {
    let total = filled.volume();
    let mut level = LatticeLevel {
        bodies: Vec::new(),
        dropped: Vec::new(),
        pinches_mended: 0,
        mended_volume: 0.0,
        offset,
        spacing,
    };
    let components = filled.components().into_iter().map(|tets| filled.part(&tets)).collect();
    for body in keep_large(components, total, &mut level.dropped) {
        let Some((repaired, took)) = repair_manifold(&body) else {
            level.bodies.push(body);
            continue;
        };
        level.pinches_mended += took.pinches;
        level.mended_volume += took.volume;
        level.bodies.extend(repaired.components().into_iter().map(|tets| repaired.part(&tets)));
    }
    level.bodies = keep_large(level.bodies, total, &mut level.dropped);
    level.dropped.sort_by(|a, b| b.volume.total_cmp(&a.volume));
    level
}

/// Components that are large enough, by decreasing volume. The others go to `dropped`.
fn keep_large(components: Vec<Lattice>, total: f64, dropped: &mut Vec<DroppedComponent>) -> Vec<Lattice> {
    let mut sized: Vec<(f64, Lattice)> = components.into_iter().map(|body| (body.volume(), body)).collect();
    sized.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut kept = Vec::new();
    for (volume, body) in sized {
        if kept.is_empty() || volume >= BODY_SHARE_MIN * total && body.tets.len() >= BODY_TETS_MIN {
            kept.push(body);
        } else {
            dropped.push(DroppedComponent { volume, tets: body.tets.len(), place: body.center() });
        }
    }
    kept
}

impl Lattice {
    /// Center of volume, local.
    pub fn center(&self) -> Point3<f64> {
        let (mut moment, mut volume) = (Vector3::zeros(), 0.0);
        for tet in 0..self.tets.len() {
            let [a, b, c, d] = self.corners(tet).map(|corner| corner.coords);
            moment += (a + b + c + d) * (self.tet_volume(tet) / 4.0);
            volume += self.tet_volume(tet);
        }
        Point3::from(moment / volume)
    }
}
