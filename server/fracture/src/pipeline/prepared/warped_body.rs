//! What an artist's controls make of one body.

use crate::cancel_token::Cancelled;
use crate::lift::{LiftError, LiftKind, LiftedLattice};
/// Why controls cannot be had of an object.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WarpError {
    /// Space folds: the waves are too steep.
    #[error(
        "waves: space folds in body {body} near ({x:.4}, {y:.4}, {z:.4}); {}",
        advice(*.slope), x = .at_m[0], y = .at_m[1], z = .at_m[2]
    )]
    Folds {
        /// Which body.
        body: usize,
        /// Where, m.
        at_m: [f64; 3],
        /// A slope at which no body folds, if there is one.
        slope: Option<f64>,
    },
    /// Waves that no lattice can show.
    #[error("waves: a length of {length_m} m is below two spacings of the crack lattice, {least_m:.4} m")]
    Short {
        /// The length given, m.
        length_m: f64,
        /// The least that can be, m.
        least_m: f64,
    },
    /// The lift cannot be made in the bent space.
    #[error("body {body} has no {lift} lift in the bent space: {source}")]
    Lift {
        /// Which body.
        body: usize,
        /// Which lift.
        lift: LiftKind,
        /// Why.
        source: LiftError,
    },
    /// A protected region that holds nothing of the object.
    #[error("protect[{region}] holds nothing of the object")]
    Region {
        /// Which, from 0.
        region: usize,
    },
    /// A site outside the object.
    #[error("sites[{site}] is {distance_m:.4} m from the object")]
    Site {
        /// Which, from 0.
        site: usize,
        /// Distance to the nearest node of a lattice, m.
        distance_m: f64,
    },
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// What can be done where space folds.
fn advice(slope: Option<f64>) -> String {
    slope.map_or_else(
        || "no slope of waves avoids that: the grain does it, lower its ratio".to_owned(),
        |slope| format!("a slope of {slope} does not fold"),
    )
}

/// What the controls make of one body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WarpedBody {
    /// In the bent space, of the kinds that the body has; none where nothing bends.
    pub(in crate::pipeline) lifts: Vec<LiftedLattice>,
    /// Nodes of each protected region; no node is in two.
    pub(in crate::pipeline) protected: Vec<Vec<u32>>,
    /// Nodes of the sites that stay, all different.
    pub(in crate::pipeline) pins: Vec<u32>,
    /// By node, times how much energy counts when sites are placed; empty: as it is.
    pub(in crate::pipeline) factors: Vec<f64>,
    /// Whether as many pieces do as without: neither grain nor paint.
    pub(in crate::pipeline) alike: bool,
}

impl WarpedBody {
    /// The lift of that kind in the bent space.
    pub(in crate::pipeline) fn lift(&self, kind: LiftKind) -> Option<&LiftedLattice> {
        self.lifts.iter().find(|lift| lift.kind == kind)
    }

    /// Gives each protected region the label that most of its volume has, ties to the lowest.
    pub(in crate::pipeline) fn keep_whole(&self, labels: &mut [u32], volumes: &[f64], sites: usize) {
        for region in &self.protected {
            let mut shares = vec![0.0; sites];
            region.iter().for_each(|&node| shares[labels[node as usize] as usize] += volumes[node as usize]);
            let most = (0..sites).rev().max_by(|&a, &b| shares[a].total_cmp(&shares[b]));
            if let Some(label) = most {
                region.iter().for_each(|&node| labels[node as usize] = label as u32);
            }
        }
    }
}
