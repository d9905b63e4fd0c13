//! Comparison of lifts on one body by diagrams of the same number of sites and uniform density.
//!
//! Based on: section 3 of the method. If a lift represents interior distances poorly, cells that reach around a
//! concavity split into several components. The volume and number of those components, and the stretch of the lift,
//! measure how well it suits a tessellation.

use crate::cancel_token::{CancelToken, Canceled};
use crate::centroidal::{self, DiagramOptions, DiagramWorkspace, EnergyField, FieldError};
use crate::lift::{Extension, LiftError, LiftKind, LiftedLattice, Stretch, stretch, surface_diffusion};
use crate::pipeline::prepared::object::PreparedBody;
use crate::tessellation::components;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Figures of one lift, number of sites and seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LiftRow {
    /// Kind of the lift.
    pub lift: LiftKind,
    /// Extension of the lift from the surface to the interior; `None` for other lifts than the surface one.
    pub carry: Option<Extension>,
    /// Dimension m of the lift.
    pub dimension: usize,
    /// Requested number of sites.
    pub sites: usize,
    /// Seed of the diagram's start.
    pub seed: u64,
    /// Number of cells with at least one node.
    pub cells: usize,
    /// Number of connected components of the cells; equal to `cells` at best.
    pub components: usize,
    /// Share of the body's volume outside the largest component of each cell.
    pub stray_volume: f64,
    /// Unevenness of the lift's stretch, independent of the sites.
    pub stretch: Stretch,
}

/// Errors of a comparison of lifts.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LiftComparisonError {
    /// A lift could not be computed.
    #[error("lift carried by {carry:?}: {source}")]
    Lift {
        /// Extension of the surface lift.
        carry: Extension,
        /// Cause.
        source: LiftError,
    },
    /// A lift and the body's volumes do not make a valid field.
    #[error("lift {lift}: {source}")]
    Field {
        /// Kind of the lift.
        lift: LiftKind,
        /// Cause.
        source: FieldError,
    },
    /// Canceled at a checkpoint.
    #[error(transparent)]
    Canceled(#[from] Canceled),
}

/// The lifts of one body, computed once and compared at any number of sites.
pub struct LiftComparison<'a> {
    body: &'a PreparedBody,
    lifts: Vec<Candidate<'a>>,
}

struct Candidate<'a> {
    lift: Cow<'a, LiftedLattice>,
    carry: Option<Extension>,
    stretch: Stretch,
}

impl<'a> LiftComparison<'a> {
    /// Takes the Euclidean and interior lifts of `body`, and computes the surface lift with about `modes` functions and
    /// both extensions.
    ///
    /// The mean value coordinates take seconds on a body of 12 000 nodes.
    ///
    /// # Errors
    /// [`LiftComparisonError::Lift`].
    pub fn new(body: &'a PreparedBody, modes: usize, token: &CancelToken) -> Result<Self, LiftComparisonError> {
        let candidate = |lift: Cow<'a, LiftedLattice>, carry| {
            let stretch = stretch(&lift, &body.crack);
            Candidate { lift, carry, stretch }
        };
        let prepared = [Some(&body.euclidean), body.interior.as_ref()].into_iter().flatten();
        let mut lifts: Vec<Candidate> = prepared.map(|lift| candidate(Cow::Borrowed(lift), None)).collect();
        for carry in [Extension::Harmonic, Extension::MeanValue] {
            let lift = surface_diffusion(&body.crack, carry, modes, token)
                .map_err(|source| LiftComparisonError::Lift { carry, source })?;
            lifts.push(candidate(Cow::Owned(lift), Some(carry)));
        }
        Ok(Self { body, lifts })
    }

    /// One row per lift, in the order Euclidean, interior, surface by harmonic extension, surface by mean value
    /// coordinates.
    ///
    /// Each row is measured on a centroidal diagram of `sites` sites and uniform energy, started from `seed`.
    ///
    /// # Errors
    /// [`LiftComparisonError::Field`], [`LiftComparisonError::Canceled`].
    pub fn rows(&self, sites: usize, seed: u64, token: &CancelToken) -> Result<Vec<LiftRow>, LiftComparisonError> {
        self.lifts.iter().map(|candidate| self.row(candidate, sites, seed, token)).collect()
    }

    fn row(
        &self,
        candidate: &Candidate,
        sites: usize,
        seed: u64,
        token: &CancelToken,
    ) -> Result<LiftRow, LiftComparisonError> {
        let volumes = &self.body.volumes;
        let (lift, mut uniform) = (&candidate.lift, volumes.clone());
        let field = EnergyField::new(lift, volumes, &mut uniform)
            .map_err(|source| LiftComparisonError::Field { lift: lift.kind, source })?;
        let options = DiagramOptions::new(sites, seed);
        let diagram = centroidal::diagram(&field, &options, &mut DiagramWorkspace::default(), token)?;
        let split = components(&self.body.topology, &diagram.labels);
        let mut parts = vec![0.0; split.sites.len()];
        for (&part, volume) in split.labels.iter().zip(volumes) {
            parts[part as usize] += volume;
        }
        // The components of one site are consecutive in the list.
        let (mut cells, mut first, mut stray) = (0, 0, 0.0);
        for same in split.sites.chunk_by(|a, b| a == b) {
            let cell = &parts[first..first + same.len()];
            stray += cell.iter().sum::<f64>() - cell.iter().copied().fold(0.0, f64::max);
            first += same.len();
            cells += 1;
        }
        Ok(LiftRow {
            lift: lift.kind,
            carry: candidate.carry,
            dimension: lift.dimension,
            sites,
            seed,
            cells,
            components: split.sites.len(),
            stray_volume: stray / volumes.iter().sum::<f64>(),
            stretch: candidate.stretch,
        })
    }
}
