//! Candidate sites of a tetrahedron: those that may own a part of it.
//!
//! Our own method. X is linear on a tetrahedron, so |X − p_i|² − |X − p_j|² is linear, too, and takes its extremes at
//! the corners. A site that is farther than one other site from all four corners owns nothing in between. Comparing
//! with the sites nearest to the corners first leaves few candidates.

use super::AccuracyError;
use super::polytope::{BarycentricWeights, Polytope};
use crate::lattice::Lattice;
use crate::lift::LiftedLattice;

/// Site with its squared lifted distances from the four corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct CandidateSite {
    /// Index of the site.
    pub(super) site: u32,
    /// Squared lifted distance from each corner.
    pub(super) squares: [f64; 4],
}

impl CandidateSite {
    /// |X − p|² − |X − p_other|² at the corners.
    pub(super) fn against(&self, other: &Self) -> [f64; 4] {
        std::array::from_fn(|corner| self.squares[corner] - other.squares[corner])
    }

    /// Returns true if it owns no part of the tetrahedron because of `other`.
    fn loses_to(&self, other: &Self) -> bool {
        let heights = self.against(other);
        heights.iter().all(|height| *height > 0.0)
            || other.site < self.site && heights.iter().all(|height| *height == 0.0)
    }

    /// Clips `part` to the region that is nearest to this site among `rivals`.
    pub(super) fn cell(&self, rivals: &[Self], mut part: Polytope) -> Polytope {
        for rival in rivals.iter().filter(|rival| rival.site != self.site) {
            part.clip(&self.against(rival), rival.site);
        }
        part
    }
}

/// Sites of one diagram on one lattice.
#[derive(Clone, Copy)]
pub(super) struct CandidateSites<'a> {
    /// Lattice of the diagram.
    pub(super) lattice: &'a Lattice,
    lift: &'a LiftedLattice,
    sites: &'a [f64],
}

impl<'a> CandidateSites<'a> {
    /// Creates the list from `sites`: site-major, with as many coordinates each as the lift has.
    pub(super) fn new(lattice: &'a Lattice, lift: &'a LiftedLattice, sites: &'a [f64]) -> Result<Self, AccuracyError> {
        AccuracyError::check("lift", lattice.nodes.len() * lift.dimension, lift.coordinates.len())?;
        let whole = sites.len() - sites.len() % lift.dimension.max(1);
        AccuracyError::check("sites", whole.max(lift.dimension), sites.len())?;
        Ok(Self { lattice, lift, sites })
    }

    /// Number of sites.
    pub(super) fn count(&self) -> usize {
        self.sites.len() / self.lift.dimension
    }

    /// Lists in `rivals` the sites that may own a part of tetrahedron `tet`, by site; at least one.
    pub(super) fn of(&self, tet: usize, all: &mut Vec<CandidateSite>, rivals: &mut Vec<CandidateSite>) {
        let corners = self.lattice.tets[tet].map(|node| self.lift.at(node as usize));
        all.clear();
        all.extend(
            self.sites.chunks_exact(self.lift.dimension).zip(0..).map(|(site, number)| CandidateSite {
                site: number,
                squares: corners.map(|corner| square(corner, site)),
            }),
        );
        let nearest: [Option<CandidateSite>; 4] = std::array::from_fn(|corner| {
            all.iter().min_by(|a, b| a.squares[corner].total_cmp(&b.squares[corner])).copied()
        });
        rivals.clear();
        rivals.extend(all.iter().filter(|own| !nearest.iter().flatten().any(|other| own.loses_to(other))));
    }

    /// Nearest site to a point of tetrahedron `tet`; ties go to the lowest index.
    pub(super) fn nearest(&self, tet: usize, weights: &BarycentricWeights) -> u32 {
        let corners = self.lattice.tets[tet].map(|node| self.lift.at(node as usize));
        let at: Vec<f64> = (0..self.lift.dimension)
            .map(|axis| corners.iter().zip(weights).map(|(corner, weight)| corner[axis] * weight).sum())
            .collect();
        let sites = self.sites.chunks_exact(self.lift.dimension).map(|site| square(&at, site));
        sites.zip(0..).min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |(_, site)| site)
    }
}

/// Squared distance |x − p|².
fn square(at: &[f64], site: &[f64]) -> f64 {
    at.iter().zip(site).map(|(x, p)| (x - p) * (x - p)).sum()
}
