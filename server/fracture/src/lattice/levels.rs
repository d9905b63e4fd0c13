//! Two lattice levels of one shape, paired by body: a coarse one for elasticity and a fine one for cracks.

use super::boundary_fit::stuff_fitted;
use super::level::{DroppedComponent, LatticeLevel, stuff};
use super::measure::DihedralRange;
use super::{ELASTIC_NODES_MAX, EnergyTransfer, Lattice, LatticeError, Locator, SignedDistance};
use crate::cancel_token::{CancelToken, Canceled};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Smallest share of a crack body's volume inside an elastic body on which it is solved.
pub const OVERLAP_MIN: f64 = 0.75;

/// Largest share of crack nodes farther than the elastic spacing from the lattice they are solved on.
pub const FAR_SHARE_MAX: f64 = 0.002;

/// Factor on the elastic spacing per refinement, while more nodes than that are far.
const REFINEMENT: f64 = 0.88;

/// One body at both levels.
#[derive(Clone, Debug)]
pub struct BodyLattice {
    /// Lattice for elasticity.
    pub elastic: Lattice,
    /// Lattice for cracks.
    pub crack: Lattice,
    /// Energy transfer from the elastic to the crack lattice.
    pub transfer: EnergyTransfer,
}

/// Reason for solving a body on its crack lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Replacement {
    /// The coarse level contains too little of it ([`OVERLAP_MIN`]).
    Lost,
    /// The coarse level joins it with another body.
    Fused,
}

/// Body that is solved on its crack lattice.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReplacedBody {
    /// Index into [`LatticeLevels::bodies`].
    pub body: usize,
    /// Reason for the replacement.
    pub reason: Replacement,
    /// Share of its volume inside the elastic body that it overlaps most, 0 … 1.
    pub overlap: f64,
}

/// Statistics of one level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LatticeLevelReport {
    /// Side of the grid's cubes, local.
    pub spacing: f64,
    /// Offset of the meshed level set, local.
    pub offset: f64,
    /// Volume of all bodies, local.
    pub volume: f64,
    /// Number of bodies.
    pub bodies: usize,
    /// Number of nodes of all bodies.
    pub nodes: usize,
    /// Number of tetrahedra of all bodies.
    pub tets: usize,
    /// Extreme dihedral angles over all bodies.
    pub dihedral: DihedralRange,
    /// Components left out.
    pub dropped: Vec<DroppedComponent>,
    /// Number of places where the boundary was repaired to be a 2-manifold.
    pub pinches_mended: usize,
    /// Volume dropped by the repair, local.
    pub mended_volume: f64,
}

/// Both levels of a shape, body by body, with their statistics.
#[derive(Clone, Debug)]
pub struct LatticeLevels {
    /// Bodies, by decreasing volume of their crack lattices.
    pub bodies: Vec<BodyLattice>,
    /// Statistics of the crack level.
    pub crack: LatticeLevelReport,
    /// Statistics of the elastic level before bodies were paired. `None` if no tetrahedron was inside at that spacing.
    pub elastic: Option<LatticeLevelReport>,
    /// Bodies that are solved on their crack lattice.
    pub replaced: Vec<ReplacedBody>,
    /// Volume of elastic bodies on which no crack body is solved, local.
    pub unmatched_volume: f64,
    /// Crack nodes farther than the elastic spacing from the lattice that they are solved on.
    ///
    /// They take the deformation of the nearest part.
    pub far: Vec<Point3<f64>>,
}

/// Spacings of two levels, local.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spacings {
    /// Spacing of the elastic level.
    pub elastic: f64,
    /// Spacing of the crack level.
    pub crack: f64,
    /// Refines the elastic level, down to the crack level, until it contains thin limbs.
    pub refine: bool,
    /// Fits the boundary of the elastic level to ridges and creases, so that walls keep their thickness.
    pub fits_elastic: bool,
}

/// Fills a shape at two spacings, both to `volume` (local, positive), and pairs their bodies.
///
/// Bodies are paired by overlap. A body that the coarse level lost, or joined with another, is solved on its crack
/// lattice. So distinct bodies never share a solve and none is missing.
///
///
///
/// # Errors
/// Those of [`stuff`]; an empty elastic level is none.
pub fn levels(
    shape: &dyn SignedDistance,
    spacings: Spacings,
    volume: f64,
    token: &CancelToken,
) -> Result<LatticeLevels, LatticeError> {
    let crack = stuff(shape, spacings.crack, Some(volume), token)?;
    levels_by(crack, &|spacing| elastic_level(shape, spacing, spacings, volume, token), spacings, token)
}

/// As [`levels`], with the boundary of the crack level fitted to ridges and creases.
///
/// The last bits of a position may decide which nodes move. The same shape in another place or unit may therefore get a
/// different lattice of equal quality.
///
/// # Errors
/// Those of [`levels`].
pub fn fitted_levels(
    shape: &dyn SignedDistance,
    spacings: Spacings,
    volume: f64,
    token: &CancelToken,
) -> Result<LatticeLevels, LatticeError> {
    let crack = stuff_fitted(shape, spacings.crack, volume, token)?;
    levels_by(crack, &|spacing| elastic_level(shape, spacing, spacings, volume, token), spacings, token)
}

fn elastic_level(
    shape: &dyn SignedDistance,
    spacing: f64,
    spacings: Spacings,
    volume: f64,
    token: &CancelToken,
) -> Result<LatticeLevel, LatticeError> {
    match spacings.fits_elastic {
        true => stuff_fitted(shape, spacing, volume, token),
        false => stuff(shape, spacing, Some(volume), token),
    }
}

/// Pairs the bodies of a crack level with those that `stuffed` creates at the elastic spacing.
pub(super) fn levels_by(
    crack: LatticeLevel,
    stuffed: &dyn Fn(f64) -> Result<LatticeLevel, LatticeError>,
    spacings: Spacings,
    token: &CancelToken,
) -> Result<LatticeLevels, LatticeError> {
    let mut spacing = spacings.elastic;
    loop {
        let elastic = match stuffed(spacing) {
            Ok(level) => Some(level),
            Err(LatticeError::NothingInside { .. }) => None,
            Err(error) => return Err(error),
        };
        let far = far_nodes(&crack.bodies, elastic.as_ref().map_or(&[], |level| &level.bodies), spacing);
        let finer = (spacing * REFINEMENT).max(spacings.crack);
        let nodes = elastic.as_ref().map_or(0, LatticeLevel::node_count) as f64 * (spacing / finer).powi(3);
        let near = far.len() as f64 <= FAR_SHARE_MAX * crack.node_count() as f64;
        if near || !spacings.refine || finer == spacing || nodes > ELASTIC_NODES_MAX as f64 {
            return Ok(pair(crack, elastic, far, token)?);
        }
        spacing = finer;
    }
}

/// Crack nodes farther than `spacing` from the elastic body of their own body: ends of
/// limbs that the coarse level lost.
fn far_nodes(crack: &[Lattice], elastic: &[Lattice], spacing: f64) -> Vec<Point3<f64>> {
    let locators: Vec<Locator> = elastic.iter().map(Locator::new).collect();
    let mut far = Vec::new();
    for (body, (container, overlap)) in crack.iter().zip(containing_bodies(crack, &locators)) {
        if overlap < OVERLAP_MIN {
            continue;
        }
        let locator = &locators[container];
        let is_far = |point: &&Point3<f64>| {
            locator.containing(point, None).is_none()
                && locator.nearest(point).is_none_or(|near| near.distance > spacing)
        };
        far.par_extend(body.nodes.par_iter().filter(is_far).copied());
    }
    far
}

fn pair(
    crack: LatticeLevel,
    elastic: Option<LatticeLevel>,
    far: Vec<Point3<f64>>,
    token: &CancelToken,
) -> Result<LatticeLevels, Canceled> {
    let crack_report = report(&crack);
    let elastic_report = elastic.as_ref().map(report);
    let elastic_bodies = elastic.map_or_else(Vec::new, |level| level.bodies);
    let locators: Vec<Locator> = elastic_bodies.iter().map(Locator::new).collect();
    let containing_bodies = containing_bodies(&crack.bodies, &locators);
    let contained_count = |container: usize| {
        containing_bodies.iter().filter(|(at, overlap)| *at == container && *overlap >= OVERLAP_MIN).count()
    };
    let (mut bodies, mut replaced, mut used) = (Vec::new(), Vec::new(), vec![false; elastic_bodies.len()]);
    for (body, crack) in crack.bodies.into_iter().enumerate() {
        token.check()?;
        let (container, overlap) = containing_bodies[body];
        let reason = match overlap {
            overlap if overlap < OVERLAP_MIN => Some(Replacement::Lost),
            _ if contained_count(container) > 1 => Some(Replacement::Fused),
            _ => None,
        };
        bodies.push(match reason {
            Some(reason) => {
                replaced.push(ReplacedBody { body, reason, overlap });
                BodyLattice { elastic: crack.clone(), transfer: EnergyTransfer::identity(&crack), crack }
            }
            None => {
                used[container] = true;
                let elastic = elastic_bodies[container].clone();
                BodyLattice { transfer: EnergyTransfer::between(&elastic, &crack), elastic, crack }
            }
        });
    }
    let unmatched = elastic_bodies.iter().zip(used).filter(|(_, used)| !used).map(|(body, _)| body.volume());
    let unmatched_volume = unmatched.sum();
    Ok(LatticeLevels { bodies, crack: crack_report, elastic: elastic_report, replaced, unmatched_volume, far })
}

/// For each crack body, the elastic body that contains most of its volume (by centroids), and the share contained.
fn containing_bodies(crack: &[Lattice], locators: &[Locator]) -> Vec<(usize, f64)> {
    let container = |body: &Lattice| {
        let held = locators.iter().map(|locator| held(locator, body)).enumerate();
        let most = held.fold((0, 0.0), |best: (usize, f64), next| if next.1 > best.1 { next } else { best });
        (most.0, most.1 / body.volume())
    };
    crack.iter().map(container).collect()
}

/// Volume of the tetrahedra of `body` whose centroid lies in the located lattice.
fn held(locator: &Locator, body: &Lattice) -> f64 {
    let inside: Vec<bool> = (0..body.tets.len())
        .into_par_iter()
        .map(|tet| {
            let centroid = body.corners(tet).iter().map(|corner| corner.coords).sum::<Vector3<f64>>() / 4.0;
            locator.containing(&Point3::from(centroid), None).is_some()
        })
        .collect();
    (0..body.tets.len()).filter(|&tet| inside[tet]).map(|tet| body.tet_volume(tet)).sum()
}

fn report(level: &LatticeLevel) -> LatticeLevelReport {
    let angles = level.bodies.iter().map(Lattice::dihedral);
    let dihedral = angles.fold(DihedralRange { min_deg: 180.0, max_deg: 0.0 }, |sum, next| DihedralRange {
        min_deg: sum.min_deg.min(next.min_deg),
        max_deg: sum.max_deg.max(next.max_deg),
    });
    LatticeLevelReport {
        spacing: level.spacing,
        offset: level.offset,
        volume: level.volume(),
        bodies: level.bodies.len(),
        nodes: level.node_count(),
        tets: level.tet_count(),
        dihedral,
        dropped: level.dropped.clone(),
        pinches_mended: level.pinches_mended,
        mended_volume: level.mended_volume,
    }
}

#[cfg(test)]
#[path = "levels_tests.rs"]
mod tests;
