//! One level: from a signed distance to bodies that are safe to solve on and to cut.

use super::cut::Cutter;
use super::grid::Grid;
use super::manifold_repair::repair_manifold;
use super::stuffing::fill;
use super::{Lattice, LatticeError, SignedDistance};
use crate::cancel_token::CancelToken;
use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

/// A component is dropped if it holds less than this share of the lattice's volume …
pub const BODY_SHARE_MIN: f64 = 1e-3;

/// … or fewer tetrahedra than this. The largest component is kept in any case.
pub const BODY_TETS_MIN: usize = 12;

/// How far the lattice's volume may stay from the one asked for, as a share of it.
pub const VOLUME_TOLERANCE: f64 = 1e-3;

/// Offsets tried to meet a volume, at most.
const OFFSETS_MAX: usize = 8;

/// A component that was left out of a level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DroppedComponent {
    /// Its volume, local.
    pub volume: f64,
    /// Its tetrahedra.
    pub tets: usize,
    /// Its center of volume, local.
    pub place: Point3<f64>,
}

/// The bodies of a shape at one spacing.
#[derive(Clone, Debug)]
pub struct LatticeLevel {
    /// The bodies, by decreasing volume. Each holds the invariants of [`Lattice`].
    pub bodies: Vec<Lattice>,
    /// Components left out ([`BODY_SHARE_MIN`], [`BODY_TETS_MIN`]), by decreasing volume.
    pub dropped: Vec<DroppedComponent>,
    /// Places where the boundary was not a 2-manifold before tetrahedra were dropped there.
    pub pinches_mended: usize,
    /// Volume of the tetrahedra dropped to mend them, local.
    pub mended_volume: f64,
    /// The level set that was meshed: signed distance = offset, local.
    pub offset: f64,
    /// Side of the grid's cubes, local.
    pub spacing: f64,
}

impl LatticeLevel {
    /// Volume of all bodies, local.
    pub fn volume(&self) -> f64 {
        self.bodies.iter().map(Lattice::volume).sum()
    }

    /// Nodes of all bodies.
    pub fn node_count(&self) -> usize {
        self.bodies.iter().map(|body| body.nodes.len()).sum()
    }

    /// Tetrahedra of all bodies.
    pub fn tet_count(&self) -> usize {
        self.bodies.iter().map(|body| body.tets.len()).sum()
    }
}

/// Fills a shape with tetrahedra on a body-centered cubic grid of cubes of side `spacing` (local).
///
/// Without `volume` the surface is signed distance = 0. With it (local, positive), the level set within half a
/// spacing of it is searched whose bodies hold that volume to 0.1 %: chords cut up to a seventh off thin limbs. Where
/// none does, the nearest is taken; [`LatticeLevel::volume`] tells.
///
/// Every dihedral angle lies within [10.7°, 164.8°] (Labelle & Shewchuk 2007). The result depends on nothing but the arguments.
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

/// Safeguarded secant steps on the offset, starting at 0 with the boundary's area as the slope.
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
        // The ends of the range may be tried themselves; an offset already tried tells nothing new.
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

/// Splits into face-connected components, drops the tiny, mends the others, and splits again what mending parted.
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
        let Some((mended, took)) = repair_manifold(&body) else {
            level.bodies.push(body);
            continue;
        };
        level.pinches_mended += took.pinches;
        level.mended_volume += took.volume;
        level.bodies.extend(mended.components().into_iter().map(|tets| mended.part(&tets)));
    }
    level.bodies = keep_large(level.bodies, total, &mut level.dropped);
    level.dropped.sort_by(|a, b| b.volume.total_cmp(&a.volume));
    level
}

/// The components that are large enough, by decreasing volume; the others go to `dropped`.
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
    /// The center of volume, local.
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
