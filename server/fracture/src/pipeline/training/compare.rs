//! Lifts side by side on one body: what each makes of the same number of sites of uniform density.
//!
//! Based on: the house's method, section 3. A cell that an interior distance cannot reach around a concavity falls into
//! pieces; the volume of those pieces, their number and the stretch of the lift tell how well it fits a tessellator.

use crate::cancel_token::{CancelToken, Cancelled};
use crate::centroidal::{self, DiagramOptions, DiagramWorkspace, EnergyField, FieldError};
use crate::lift::{Extension, LiftError, LiftKind, LiftedLattice, Stretch, stretch, surface_diffusion};
use crate::pipeline::prepared::object::PreparedBody;
use crate::tessellation::components;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// One lift, one number of sites, one seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LiftRow {
    /// Which lift.
    pub lift: LiftKind,
    /// What carried it inside; only a surface lift is carried.
    pub carry: Option<Extension>,
    /// m.
    pub dimension: usize,
    /// Sites asked for.
    pub sites: usize,
    /// Start of the diagram.
    pub seed: u64,
    /// Cells that got a node.
    pub cells: usize,
    /// Connected components of the cells; as many as `cells` at best.
    pub components: usize,
    /// Volume outside the largest component of each cell, over the body's.
    pub stray_volume: f64,
    /// Uneven stretch of the lift; it does not depend on the sites.
    pub stretch: Stretch,
}

/// Why lifts were not compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LiftComparisonError {
    /// A lift could not be made.
    #[error("lift carried by {carry:?}: {source}")]
    Lift {
        /// Which surface lift.
        carry: Extension,
        /// Why.
        source: LiftError,
    },
    /// A lift and the body's volumes are no field.
    #[error("lift {lift}: {source}")]
    Field {
        /// Which lift.
        lift: LiftKind,
        /// Why.
        source: FieldError,
    },
    /// Cancelled at a checkpoint.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// The lifts of one body, each made once, to be compared at any number of sites.
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
    /// Euclidean and interior as `body` has them, and the surface lift with about `modes` functions, carried both ways;
    /// the mean value coordinates take seconds on a body of 12 000 nodes.
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

    /// One row per lift, in the order euclidean, interior, surface by harmonic and by mean value coordinates: a
    /// centroidal diagram of `sites` sites of uniform energy from the start that `seed` gives.
    ///
    /// # Errors
    /// [`LiftComparisonError::Field`], [`LiftComparisonError::Cancelled`].
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
        // The components of one site are neighbors in the list.
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
