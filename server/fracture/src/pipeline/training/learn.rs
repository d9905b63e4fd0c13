//! Training of the degree model on examples.

use super::examples::examples;
use super::sample::ImpactSampler;
use crate::cancel_token::CancelToken;
use crate::degree::{self, SITES_MIN, TrainingSample};
use crate::pipeline::error::FractureError;
use crate::pipeline::prepared::example::TrainingExample;
use crate::pipeline::prepared::learned::{LearnedErrors, LearnedModel};
use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::workspace::Workspace;
use rayon::prelude::*;

/// The examples of the given impacts with the object's seed, in order, computed on all threads of the current pool.
///
/// # Errors
/// [`FractureError`] of the first impact that fails, or for a canceled `token`.
pub fn sampled(
    prepared: &PreparedObject,
    impacts: &[u64],
    token: &CancelToken,
) -> Result<Vec<TrainingExample>, FractureError> {
    let (sampler, seed) = (ImpactSampler::new(prepared), prepared.parameters.seed);
    let one = |workspace: &mut Workspace, index: &u64| examples(prepared, &sampler, seed, *index, workspace, token);
    let all: Vec<Vec<TrainingExample>> =
        impacts.par_iter().map_init(Workspace::default, one).collect::<Result<_, _>>()?;
    Ok(all.into_iter().flatten().collect())
}

/// Trains κ and the network; `None` if the examples have too few labels.
pub fn learn(examples: &[TrainingExample], seed: u64) -> Option<(f64, LearnedModel)> {
    let trained = degree::train(&samples(examples), seed)?;
    let labels: Vec<(f64, f64)> = examples
        .iter()
        .flat_map(TrainingExample::labels)
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
    let closed = labels.iter().filter(|label| counts(label)).map(|(estimate, sites)| error(kappa * estimate, *sites));
    let closed = Errors::of(closed)?;
    let pose: Vec<TrainingSample> = examples.iter().enumerate().flat_map(|(k, example)| example.poses(k)).collect();
    let pose = degree::train(&pose, seed).and_then(|trained| network(&trained.left_out))?;
    let few = labels.iter().zip(&trained.left_out).filter(|(label, _)| !counts(label));
    let off = |((estimate, sites), found): (&(f64, f64), &f64)| {
        (degree::sites(*found, *estimate).round().max(2.0) - sites).abs()
    };
    let few: Vec<f64> = few.map(off).collect();
    let quality = LearnedErrors {
        holdout: own.count,
        median_relative_error: own.median,
        p90_relative_error: own.p90,
        closed_form_median: closed.median,
        closed_form_p90: closed.p90,
        pose_network_median: pose.median,
        pose_network_p90: pose.p90,
        few_holdout: few.len(),
        few_within_one: (!few.is_empty())
            .then(|| few.iter().filter(|off| **off <= 1.0).count() as f64 / few.len() as f64),
        label_noise_median: Errors::of(examples.iter().flat_map(TrainingExample::noise))?.median,
    };
    Some((kappa, LearnedModel { network: trained.network, quality }))
}

/// The training samples of all examples, in order.
pub(crate) fn samples(examples: &[TrainingExample]) -> Vec<TrainingSample> {
    examples.iter().enumerate().flat_map(|(k, example)| example.samples(k)).collect()
}

/// Median and 90th percentile of some numbers.
struct Errors {
    count: usize,
    median: f64,
    p90: f64,
}

impl Errors {
    /// Quantiles of `values`; `None` if empty.
    fn of(values: impl Iterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.collect();
        sorted.sort_by(f64::total_cmp);
        let count = sorted.len();
        let median = *sorted.get(count / 2)?;
        Some(Self { count, median, p90: sorted[count * 9 / 10] })
    }
}
