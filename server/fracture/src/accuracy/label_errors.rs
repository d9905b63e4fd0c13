//! Label errors: volume that a tessellation assigns to another site than the nearest.

use super::candidate_sites::{CandidateSite, CandidateSites};
use super::exact_cells::CHUNK;
use super::polytope::{Polytope, point};
use super::regions::Regions;
use super::{AccuracyError, exact_cells::placed};
use crate::cancel_token::CancelToken;
use crate::lattice::{Lattice, LatticePoint, Locator};
use crate::lift::LiftedLattice;
use rayon::prelude::*;

/// Errors of a tessellation by node labels against the exact diagram of the same sites on the same lattice.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LabelErrors {
    /// Volume that the tessellation assigns to each site, local. They sum to the lattice's volume.
    pub volumes: Vec<f64>,
    /// Exact label fraction: volume that is assigned to another site than the nearest, over the lattice's volume.
    pub fraction: f64,
}

/// Compares the regions of labels with the exact diagram of `sites` (site-major) in `lift`,
/// both on the lattice of `regions`.
///
/// # Errors
/// [`AccuracyError::Length`], [`AccuracyError::Canceled`].
pub fn misplaced(
    regions: &Regions<'_>,
    lift: &LiftedLattice,
    sites: &[f64],
    token: &CancelToken,
) -> Result<LabelErrors, AccuracyError> {
    let rivals = CandidateSites::new(regions.lattice, lift, sites)?;
    let tets = regions.lattice.tets.len();
    let chunks = (0..tets.div_ceil(CHUNK)).into_par_iter().map(|chunk| {
        token.check()?;
        Ok(of_chunk(regions, rivals, chunk * CHUNK..tets.min((chunk + 1) * CHUNK)))
    });
    let parts: Vec<(Vec<f64>, f64)> = chunks.collect::<Result<_, AccuracyError>>()?;
    let (mut volumes, mut lost) = (vec![0.0; rivals.count()], 0.0);
    for (part, missing) in parts {
        volumes.iter_mut().zip(part).for_each(|(sum, volume)| *sum += volume);
        lost += missing;
    }
    Ok(LabelErrors { fraction: lost / volumes.iter().sum::<f64>(), volumes })
}

/// Assigned volumes by site, and the misplaced volume, over a range of tetrahedra.
fn of_chunk(regions: &Regions<'_>, rivals: CandidateSites<'_>, tets: std::ops::Range<usize>) -> (Vec<f64>, f64) {
    let (mut volumes, mut lost) = (vec![0.0; rivals.count()], 0.0);
    let (mut all, mut own) = (Vec::new(), Vec::new());
    for tet in tets {
        let volume = regions.lattice.tet_volume(tet);
        rivals.of(tet, &mut all, &mut own);
        let uniform = regions.is_uniform(tet);
        let parts = match uniform {
            true => vec![(regions.lattice.tets[tet][0], None)],
            false => regions.flags(tet).into_iter().map(|(node, corners)| (node, Some(oriented(corners)))).collect(),
        };
        for (node, corners) in parts {
            let label = regions.labels[node as usize];
            let part = corners.map_or_else(Polytope::whole, Polytope::spanned);
            let given = volume * part.volume();
            volumes[label as usize] += given;
            match own.as_slice() {
                [alone] if alone.site == label => {}
                _ => lost += given - volume * kept(label, &own, part),
            }
        }
    }
    (volumes, lost)
}

/// Volume of the part of `part` that is nearest to the site `label`.
fn kept(label: u32, rivals: &[CandidateSite], part: Polytope) -> f64 {
    rivals.iter().find(|rival| rival.site == label).map_or(0.0, |own| own.cell(rivals, part).volume())
}

/// Orders corners so that their volume is positive.
fn oriented(corners: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
    let [a, b, c, d] = corners;
    let [p, q, r, s] = corners.map(|corner| point(&corner));
    if (q - p).dot(&(r - p).cross(&(s - p))) < 0.0 { [b, a, c, d] } else { corners }
}

/// Sampled label fraction between two lattices of one body.
///
/// This is the volume of the `reference` lattice whose nearest site differs from the label `given` at the same position
/// on `lattice`, over the whole volume. `sites` is site-major, in `lift`, the lift of the reference. One point samples
/// each reference tetrahedron, its centroid. Points outside `lattice` are projected to its boundary.
///
/// # Errors
/// [`AccuracyError::Length`], [`AccuracyError::Canceled`].
pub fn label_fraction(
    lattice: &Lattice,
    given: &(dyn Fn(&LatticePoint) -> u32 + Sync),
    reference: &Lattice,
    lift: &LiftedLattice,
    sites: &[f64],
    token: &CancelToken,
) -> Result<f64, AccuracyError> {
    let rivals = CandidateSites::new(reference, lift, sites)?;
    let locator = Locator::new(lattice);
    let tets = reference.tets.len();
    let chunks = (0..tets.div_ceil(CHUNK)).into_par_iter().map(|chunk| {
        token.check()?;
        let (mut hint, mut lost, mut sum) = (None, 0.0, 0.0);
        for tet in chunk * CHUNK..tets.min((chunk + 1) * CHUNK) {
            let centroid = placed(&reference.corners(tet), &[0.25; 4]);
            let found = locator.locate(&centroid, hint);
            hint = found.map(|found| found.tet);
            let volume = reference.tet_volume(tet);
            sum += volume;
            if found.map(|found| given(&found)) != Some(rivals.nearest(tet, &[0.25; 4])) {
                lost += volume;
            }
        }
        Ok((lost, sum))
    });
    let parts: Vec<(f64, f64)> = chunks.collect::<Result<_, AccuracyError>>()?;
    Ok(parts.iter().map(|part| part.0).sum::<f64>() / parts.iter().map(|part| part.1).sum::<f64>())
}

/// Nearest of `sites` (site-major) to a point of `lattice` in its lift; ties go to the lowest index.
///
/// The exact diagram assigns the point to this site.
///
/// # Errors
/// [`AccuracyError::Length`].
pub fn nearest(
    lattice: &Lattice,
    lift: &LiftedLattice,
    sites: &[f64],
    place: &LatticePoint,
) -> Result<u32, AccuracyError> {
    Ok(CandidateSites::new(lattice, lift, sites)?.nearest(place.tet as usize, &place.barycentric))
}

/// Interpolates a lift linearly at the nodes of another lattice of the same body.
///
/// `lift` belongs to `lattice`, which `locator` searches. The cell moments are measured on the lattice `to`. Nodes
/// outside take the nearest point of the boundary. The lift is not scaled again, so sites keep their positions.
pub fn carried(lift: &LiftedLattice, lattice: &Lattice, locator: &Locator, to: &Lattice) -> LiftedLattice {
    let place = |node| locator.locate(node, None);
    let rows: Vec<Vec<f64>> = to
        .nodes
        .par_iter()
        .map(|node| {
            let mut row = vec![0.0; lift.dimension];
            let found = place(node);
            for (corner, weight) in found.iter().flat_map(|at| lattice.tets[at.tet as usize].iter().zip(at.barycentric))
            {
                row.iter_mut().zip(lift.at(*corner as usize)).for_each(|(sum, x)| *sum += weight * x);
            }
            row
        })
        .collect();
    LiftedLattice::measured(lift.kind, to, lift.dimension, rows.concat())
}
