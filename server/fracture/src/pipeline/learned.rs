//! What an object has learned from its examples, and how well.

use super::{Example, Prepared, Sampler, StrikeError, Workspace, examples};
use crate::degree::{self, Lesson, Network, SITES_MIN};
use crate::token::Token;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Impacts between two looks at the progress.
const BATCH: u64 = 16;

/// One impact of this many is labelled twice, from other starts: what labels are worth.
const TWICE: u64 = 8;

/// Examples, and the network that they taught.
#[derive(Clone, Debug, PartialEq)]
pub struct Learned {
    /// By number of their impact.
    pub examples: Vec<Example>,
    /// From descriptor to target.
    pub network: Network,
    /// How well it does.
    pub quality: Quality,
}

/// Relative errors |Δn|/n of degrees of at least [`SITES_MIN`], each example left out in turn.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Labels that the figures are over.
    pub holdout: usize,
    /// Median of the network.
    pub median_relative_error: f64,
    /// Nine of ten labels are within this.
    pub p90_relative_error: f64,
    /// Median of the closed form with the κ of these examples.
    pub closed_form_median: f64,
    /// Its ninth decile.
    pub closed_form_p90: f64,
    /// Median of a network on the impact's pose and magnitude instead.
    pub pose_network_median: f64,
    /// Median difference between two labels of one field at one γ from different starts: the floor for any learner.
    pub label_noise_median: f64,
}

/// Examples and what they are worth as labels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sampled {
    /// By number of their impact.
    pub examples: Vec<Example>,
    /// |Δn|/n between two labels of one field.
    pub noise: Vec<f64>,
}

/// The examples of impacts 0 to `count` of the object's seed, on all threads of the current pool. `progress` is told how many
/// are done.
pub fn sampled(
    prepared: &Prepared,
    count: u64,
    token: &Token,
    progress: &mut dyn FnMut(u64),
) -> Result<Sampled, StrikeError> {
    let (sampler, seed) = (Sampler::new(prepared), prepared.parameters.seed);
    let one = |workspace: &mut Workspace, index: u64| -> Result<Sampled, StrikeError> {
        let mut own = |starts: u64| examples(prepared, &sampler, [seed, index, starts], workspace, token);
        let examples = own(0)?;
        let again = if index.is_multiple_of(TWICE) { own(1)? } else { Vec::new() };
        let noise = examples.iter().zip(&again).flat_map(|(one, other)| one.noise(other)).collect();
        Ok(Sampled { examples, noise })
    };
    let mut all = Sampled::default();
    for first in (0..count).step_by(BATCH as usize) {
        progress(first);
        let batch = (first..count.min(first + BATCH)).into_par_iter();
        let batch: Vec<Sampled> = batch.map_init(Workspace::default, one).collect::<Result<_, _>>()?;
        for Sampled { examples, noise } in batch {
            all.examples.extend(examples);
            all.noise.extend(noise);
        }
    }
    progress(count);
    Ok(all)
}

impl Sampled {
    /// κ and the network; `None` where the examples have too few labels.
    pub fn learn(self, seed: u64) -> Option<(f64, Learned)> {
        let lessons = lessons(&self.examples);
        let trained = degree::train(&lessons, seed)?;
        let labels: Vec<(f64, f64)> = self
            .examples
            .iter()
            .flat_map(Example::labels)
            .map(|(_, estimate, sites)| (estimate, f64::from(sites)))
            .collect();
        let counts = |(_, sites): &(f64, f64)| *sites >= SITES_MIN as f64;
        let kappa =
            Errors::of(labels.iter().filter(|label| counts(label)).map(|(estimate, sites)| sites / estimate))?.median;
        let error = |found: f64, sites: f64| (found.round().max(2.0) - sites).abs() / sites;
        let network = |left_out: &[f64]| {
            let each = labels.iter().zip(left_out).filter(|(label, _)| counts(label));
            Errors::of(each.map(|((estimate, sites), found)| error(degree::sites(*found, *estimate), *sites)))
        };
        let own = network(&trained.left_out)?;
        let closed =
            labels.iter().filter(|label| counts(label)).map(|(estimate, sites)| error(kappa * estimate, *sites));
        let closed = Errors::of(closed)?;
        let pose: Vec<Lesson> = self.examples.iter().enumerate().flat_map(|(k, example)| example.poses(k)).collect();
        let pose = degree::train(&pose, seed).and_then(|trained| network(&trained.left_out))?;
        let quality = Quality {
            holdout: own.count,
            median_relative_error: own.median,
            p90_relative_error: own.p90,
            closed_form_median: closed.median,
            closed_form_p90: closed.p90,
            pose_network_median: pose.median,
            label_noise_median: Errors::of(self.noise.into_iter())?.median,
        };
        Some((kappa, Learned { examples: self.examples, network: trained.network, quality }))
    }
}

/// The lessons of all examples, in order.
pub(crate) fn lessons(examples: &[Example]) -> Vec<Lesson> {
    examples.iter().enumerate().flat_map(|(k, example)| example.lessons(k)).collect()
}

/// Middle and ninth decile of some numbers.
struct Errors {
    count: usize,
    median: f64,
    p90: f64,
}

impl Errors {
    /// `None` of none.
    fn of(values: impl Iterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.collect();
        sorted.sort_by(f64::total_cmp);
        let count = sorted.len();
        let median = *sorted.get(count / 2)?;
        Some(Self { count, median, p90: sorted[count * 9 / 10] })
    }
}
