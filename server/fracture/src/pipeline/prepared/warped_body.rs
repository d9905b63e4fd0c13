//! Results of an artist's controls on one body.

use super::region_boundary::RegionBoundary;
use crate::cancel_token::Canceled;
use crate::lift::{LiftError, LiftKind, LiftedLattice};
use crate::scene::{number, rounded};

/// Errors of applying an artist's controls to an object.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WarpError {
    /// The waves are too steep: the warped space folds.
    #[error(
        "waves: space folds in body {body} near ({}); {}",
        .at_m.map(rounded).join(", "), advice(*.slope)
    )]
    Folds {
        /// Index of the body.
        body: usize,
        /// Position, m.
        at_m: [f64; 3],
        /// A slope at which no body folds, if there is one.
        slope: Option<f64>,
    },
    /// The waves are too short for the crack lattice to represent.
    #[error(
        "waves: the length {} m is below two spacings of the crack lattice; use at least {} m",
        number(*.length_m), rounded(*.least_m)
    )]
    Short {
        /// Given length, m.
        length_m: f64,
        /// Smallest possible length, m.
        least_m: f64,
    },
    /// The lift cannot be computed in the warped space.
    #[error("body {body} has no {lift} lift in the warped space: {source}")]
    Lift {
        /// Index of the body.
        body: usize,
        /// Kind of the lift.
        lift: LiftKind,
        /// Cause.
        source: LiftError,
    },
    /// A protected region contains no part of the object.
    #[error("protect[{region}] contains no part of the object; move or enlarge it")]
    Region {
        /// Index of the region, from 0.
        region: usize,
    },
    /// A site lies outside the object.
    #[error("sites[{site}] is {} m from the object; move it into the object", rounded(*.distance_m))]
    Site {
        /// Index of the site, from 0.
        site: usize,
        /// Distance to the nearest node of a crack lattice, m.
        distance_m: f64,
    },
    /// Canceled.
    #[error(transparent)]
    Canceled(#[from] Canceled),
}

/// Advice for waves that fold the space.
fn advice(slope: Option<f64>) -> String {
    slope.map_or_else(
        || {
            "no slope of the waves was found that avoids it; use waves of another length, or a lower ratio of the grain"
                .to_owned()
        },
        |slope| format!("a slope of {slope} does not fold"),
    )
}

/// Results of an artist's controls on one body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WarpedBody {
    /// Lifts in the warped space, of the kinds that the body has; empty if the warp is the identity.
    pub(in crate::pipeline) lifts: Vec<LiftedLattice>,
    /// Nodes in and near each group of protected regions, disjoint.
    pub(in crate::pipeline) protected: Vec<Vec<u32>>,
    /// Boundaries of those groups on the crack lattice; `None` without protected regions.
    pub(in crate::pipeline) boundary: Option<RegionBoundary>,
    /// Boundaries of those groups on the mesh of the input surface, if the body has one.
    pub(in crate::pipeline) cutting_boundary: Option<RegionBoundary>,
    /// Nodes of the fixed sites, all different.
    pub(in crate::pipeline) pins: Vec<u32>,
    /// Factor on the energy in the placement of sites, by node; empty: 1.
    pub(in crate::pipeline) factors: Vec<f64>,
    /// True if the number of sites is as without controls: neither grain nor paint.
    pub(in crate::pipeline) alike: bool,
}

impl WarpedBody {
    /// The lift of the given kind in the warped space.
    pub(in crate::pipeline) fn lift(&self, kind: LiftKind) -> Option<&LiftedLattice> {
        self.lifts.iter().find(|lift| lift.kind == kind)
    }

    /// The label of each group of protected regions: the one that covers most of its volume; ties go to the lowest.
    ///
    /// `labels` and `volumes` are those of the crack lattice's nodes.
    pub(in crate::pipeline) fn protecting_labels(&self, labels: &[u32], volumes: &[f64], sites: usize) -> Vec<u32> {
        let most = |nodes: &Vec<u32>| {
            let mut shares = vec![0.0; sites];
            nodes.iter().for_each(|&node| shares[labels[node as usize] as usize] += volumes[node as usize]);
            (0..sites).rev().max_by(|&a, &b| shares[a].total_cmp(&shares[b])).unwrap_or(0) as u32
        };
        self.protected.iter().map(most).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_write_huge_and_tiny_numbers_shortly() {
        let site = WarpError::Site { site: 2, distance_m: 1.25e300 };
        assert_eq!(site.to_string(), "sites[2] is 1.250e300 m from the object; move it into the object");
        let short = WarpError::Short { length_m: 1e-300, least_m: 0.125 };
        assert!(short.to_string().contains("the length 1e-300 m is below") && short.to_string().ends_with("0.1250 m"));
        let folds = WarpError::Folds { body: 0, at_m: [0.0, 0.5, -1e30], slope: None };
        assert!(folds.to_string().contains("near (0.0000, 0.5000, -1.000e30); "), "{folds}");
    }
}
