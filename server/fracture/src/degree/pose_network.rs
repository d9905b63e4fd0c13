//! Learned degree: a Gaussian radial basis function network from a field's descriptor to the number of fragments.
//!
//! Based on: Schvartzman & Otaduy (I3D 2014), section 3: a radial basis function network learns the fracture degree
//! from examples. D. S. Broomhead & D. Lowe, *Multivariable functional interpolation and adaptive networks* (1988):
//! centers and linear weights. Ridge and leave-one-out as in M. J. L. Orr, *Introduction to radial basis function
//! networks* (1996).

use super::training_sample::TrainingSample;
use crate::memory::held;
use crate::random::RandomStream;
use nalgebra::{Cholesky, DMatrix, DVector};
use std::collections::HashMap;

/// Candidate numbers of centers, widths (over the spread of the descriptors) and ridges, all compared in training.
const CENTERS: [usize; 4] = [4, 8, 16, 32];
const WIDTHS: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
const RIDGES: [f64; 4] = [1e-4, 1e-2, 1e-1, 1.0];

/// Largest number of k-means iterations.
const SWEEPS: usize = 50;

/// Quantile of the distances from a sample to the nearest sample of another example that sets the range of the network.
///
/// Errors were measured up to such distances.
const REACHED: f64 = 0.95;

/// Number of samples used for that quantile.
const REACH_SAMPLE: usize = 2000;

/// Smallest range, standardized, for samples that are all equal.
const REACH_MIN: f64 = 1e-9;

/// Smallest number of examples for training.
pub const EXAMPLES_MIN: usize = 8;

/// A trained network, with its training samples, from which it computes a query's distance.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseNetwork {
    /// Mean of the descriptors, one entry per component.
    pub mean: Vec<f64>,
    /// Standard deviation of the descriptors, one entry per component.
    pub spread: Vec<f64>,
    /// Centers, standardized, row by row.
    pub centers: Vec<f64>,
    /// Weights: constant, one per component, one per center.
    pub weights: Vec<f64>,
    /// Width of the Gaussians, standardized.
    pub width: f64,
    /// Range: the largest distance from the nearest sample, standardized, at which a prediction is valid.
    pub reach: f64,
    /// Standardized descriptors of all samples, row by row.
    known: Vec<f64>,
}

/// Prediction of a network.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Predicted target.
    pub value: f64,
    /// Confidence: 1 at a sample, e^(−1/2) at the end of the range, 0 far away.
    pub confidence: f64,
    /// True within the range of the samples.
    pub within_reach: bool,
}

/// A network with its cross-validation.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainedNetwork {
    /// Network trained on all samples.
    pub network: PoseNetwork,
    /// Prediction for each sample by a network trained without the sample's example.
    pub left_out: Vec<f64>,
}

/// Trains on `samples` with the centers, width and ridge of the smallest mean absolute error in leave-one-example-out
/// cross-validation.
///
/// `None` with too few samples, or if all are equal. Duplicate samples count once; otherwise a sample left out with one
/// example would remain in another.
pub fn train(samples: &[TrainingSample], seed: u64) -> Option<TrainedNetwork> {
    let (firsts, places) = distinct(samples);
    let TrainedNetwork { network, left_out } = trained(&firsts, seed)?;
    Some(TrainedNetwork { network, left_out: places.into_iter().map(|place| left_out[place]).collect() })
}

/// The samples without duplicates, and for every sample its index among them.
fn distinct(samples: &[TrainingSample]) -> (Vec<TrainingSample>, Vec<usize>) {
    let (mut firsts, mut known) = (Vec::new(), HashMap::new());
    let place = |sample: &TrainingSample| {
        let bits: Vec<u64> = sample.descriptor.iter().chain([&sample.target]).map(|x| x.to_bits()).collect();
        *known.entry(bits).or_insert_with(|| {
            firsts.push(sample.clone());
            firsts.len() - 1
        })
    };
    let places = samples.iter().map(place).collect();
    (firsts, places)
}

/// [`train`] on samples without duplicates.
fn trained(samples: &[TrainingSample], seed: u64) -> Option<TrainedNetwork> {
    let columns = samples.first()?.descriptor.len();
    let (mean, spread) = moments(samples, columns);
    let known: Vec<f64> = samples.iter().flat_map(|sample| standardized(&sample.descriptor, &mean, &spread)).collect();
    let targets = DVector::from_iterator(samples.len(), samples.iter().map(|sample| sample.target));
    let examples: Vec<usize> = samples.iter().map(|sample| sample.example).collect();
    if examples.chunk_by(|a, b| a == b).count() < EXAMPLES_MIN {
        return None;
    }
    let reach = reach(&known, columns, &examples);
    let mut best: Option<(f64, PoseNetwork, Vec<f64>)> = None;
    for count in CENTERS.into_iter().filter(|count| 4 * count <= samples.len()) {
        let centers = k_means(&known, columns, count, seed);
        for width in WIDTHS {
            let design = design(&known, columns, &centers, width);
            for ridge in RIDGES {
                let Some((weights, left_out)) = solve(&design, &targets, &examples, ridge) else { continue };
                let error = left_out.iter().zip(&targets).map(|(found, wanted)| (found - wanted).abs()).sum::<f64>();
                if best.as_ref().is_none_or(|(least, ..)| error < *least) {
                    let (mean, spread) = (mean.clone(), spread.clone());
                    let network = PoseNetwork::new(mean, spread, centers.clone(), weights, [width, reach]);
                    best = Some((error, network, left_out));
                }
            }
        }
    }
    let (_, network, left_out) = best?;
    Some(TrainedNetwork { network: PoseNetwork { known, ..network }, left_out })
}

impl PoseNetwork {
    /// A network with these parameters (see its fields; `scales` are width and range), without training samples.
    pub fn new(mean: Vec<f64>, spread: Vec<f64>, centers: Vec<f64>, weights: Vec<f64>, scales: [f64; 2]) -> Self {
        Self { mean, spread, centers, weights, width: scales[0], reach: scales[1], known: Vec::new() }
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let Self { mean, spread, centers, weights, known, width: _, reach: _ } = self;
        held(mean) + held(spread) + held(centers) + held(weights) + held(known)
    }

    /// The same network with the descriptors of `samples`, for one whose parameters were stored.
    #[must_use]
    pub fn with_reach_of(mut self, samples: &[TrainingSample]) -> Self {
        let firsts = distinct(samples).0;
        self.known =
            firsts.iter().flat_map(|sample| standardized(&sample.descriptor, &self.mean, &self.spread)).collect();
        self
    }

    /// The prediction for `descriptor`.
    pub fn predict(&self, descriptor: &[f64]) -> Prediction {
        let columns = self.mean.len();
        let place = standardized(descriptor, &self.mean, &self.spread);
        let row = design(&place, columns, &self.centers, self.width);
        let value = row.row(0).iter().zip(&self.weights).map(|(basis, weight)| basis * weight).sum();
        let nearest = self.known.chunks(columns).map(|known| squared(known, &place)).fold(f64::INFINITY, f64::min);
        let share = nearest.sqrt() / self.reach;
        Prediction { value, confidence: (-0.5 * share * share).exp(), within_reach: share <= 1.0 }
    }
}

/// Mean and standard deviation of each component; 1 for a constant component.
fn moments(samples: &[TrainingSample], columns: usize) -> (Vec<f64>, Vec<f64>) {
    let count = samples.len() as f64;
    let mean = |of: &dyn Fn(&TrainingSample) -> f64| samples.iter().map(of).sum::<f64>() / count;
    let means: Vec<f64> = (0..columns).map(|k| mean(&|sample| sample.descriptor[k])).collect();
    let spread = |k: usize| {
        let variance = mean(&|sample| (sample.descriptor[k] - means[k]).powi(2));
        if variance > 0.0 { variance.sqrt() } else { 1.0 }
    };
    let spreads = (0..columns).map(spread).collect();
    (means, spreads)
}

fn standardized(descriptor: &[f64], mean: &[f64], spread: &[f64]) -> Vec<f64> {
    descriptor.iter().zip(mean).zip(spread).map(|((x, mean), spread)| (x - mean) / spread).collect()
}

/// Range of the network: see [`REACHED`].
fn reach(rows: &[f64], columns: usize, examples: &[usize]) -> f64 {
    let all: Vec<(&[f64], usize)> = rows.chunks(columns).zip(examples.iter().copied()).collect();
    let nearest = |(row, example): &(&[f64], usize)| {
        let others = all.iter().filter(|(_, other)| other != example);
        others.map(|(other, _)| squared(other, row)).fold(f64::INFINITY, f64::min)
    };
    let mut distances: Vec<f64> = all.iter().step_by(all.len().div_ceil(REACH_SAMPLE)).map(nearest).collect();
    distances.sort_by(f64::total_cmp);
    distances[((distances.len() - 1) as f64 * REACHED) as usize].sqrt().max(REACH_MIN)
}

fn squared(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// Design matrix, one row per descriptor: 1, the descriptor itself, a Gaussian per center.
fn design(rows: &[f64], columns: usize, centers: &[f64], width: f64) -> DMatrix<f64> {
    let basis = |row: &[f64]| -> Vec<f64> {
        let bells = centers.chunks(columns).map(|center| (-0.5 * squared(row, center) / (width * width)).exp());
        std::iter::once(1.0).chain(row.iter().copied()).chain(bells).collect()
    };
    let entries: Vec<f64> = rows.chunks(columns).flat_map(basis).collect();
    let width = 1 + columns + centers.len() / columns;
    DMatrix::from_row_slice(rows.len() / columns, width, &entries)
}

/// Ridge regression, with leave-one-example-out predictions. Samples of one example are consecutive.
///
/// With the hat matrix H and the samples b of an example, its residuals are (1 − H_bb)⁻¹ r_b.
fn solve(
    design: &DMatrix<f64>,
    targets: &DVector<f64>,
    examples: &[usize],
    ridge: f64,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let mut normal = design.transpose() * design;
    // The constant has no penalty.
    (1..normal.ncols()).for_each(|k| normal[(k, k)] += ridge);
    let factor = Cholesky::new(normal)?;
    let weights = factor.solve(&(design.transpose() * targets));
    let residuals = targets - design * &weights;
    let spread = factor.solve(&design.transpose());
    let mut left_out = Vec::with_capacity(targets.len());
    for own in examples.chunk_by(|a, b| a == b) {
        let (first, count) = (left_out.len(), own.len());
        let hat = design.rows(first, count) * spread.columns(first, count);
        let without = (DMatrix::identity(count, count) - hat).lu().solve(&residuals.rows(first, count).into_owned())?;
        left_out.extend((0..count).map(|k| targets[first + k] - without[k]));
    }
    Some((weights.iter().copied().collect(), left_out))
}

/// Centers of `count` clusters, row by row, from a start determined by `seed`.
///
/// The probability of each next start center is proportional to the squared distance from the previous ones (Arthur &
/// Vassilvitskii 2007).
fn k_means(rows: &[f64], columns: usize, count: usize, seed: u64) -> Vec<f64> {
    let mut stream = RandomStream::new(seed, count as u64);
    let all: Vec<&[f64]> = rows.chunks(columns).collect();
    let mut centers: Vec<f64> = all[(stream.bits() % all.len() as u64) as usize].to_vec();
    let nearest = |centers: &[f64], row: &[f64]| {
        let distances = centers.chunks(columns).map(|center| squared(center, row)).enumerate();
        distances.fold((0, f64::INFINITY), |best, next| if next.1 < best.1 { next } else { best })
    };
    while centers.len() < count * columns {
        let distances: Vec<f64> = all.iter().map(|row| nearest(&centers, row).1).collect();
        let mut left = stream.uniform() * distances.iter().sum::<f64>();
        let drawn = distances.iter().position(|distance| {
            left -= distance;
            left < 0.0
        });
        centers.extend(all[drawn.unwrap_or(0)]);
    }
    for _ in 0..SWEEPS {
        let mut sums = vec![0.0; centers.len()];
        let mut counts = vec![0.0; count];
        for row in &all {
            let own = nearest(&centers, row).0;
            counts[own] += 1.0;
            sums[own * columns..][..columns].iter_mut().zip(*row).for_each(|(sum, x)| *sum += x);
        }
        for (own, members) in counts.iter().enumerate().filter(|(_, members)| **members > 0.0) {
            let sums = &sums[own * columns..][..columns];
            centers[own * columns..][..columns].iter_mut().zip(sums).for_each(|(center, sum)| *center = sum / members);
        }
    }
    centers
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twenty examples of ten samples each of a smooth function of two variables.
    fn samples(function: fn(f64, f64) -> f64) -> Vec<TrainingSample> {
        let mut stream = RandomStream::new(3, 0);
        (0..200)
            .map(|k| {
                let (x, y) = (4.0 * stream.uniform(), 100.0 * stream.uniform());
                TrainingSample { example: k / 10, descriptor: vec![x, y], target: function(x, y / 100.0) }
            })
            .collect()
    }

    fn curved(x: f64, y: f64) -> f64 {
        (x - 2.0).sin() + 0.5 * y * y
    }

    #[test]
    fn a_smooth_function_is_learned_within_reach_and_not_claimed_beyond() {
        let trained = train(&samples(curved), 1).unwrap();
        let near = trained.network.predict(&[1.3, 62.0]);
        assert!(
            (near.value - curved(1.3, 0.62)).abs() < 0.02 && near.within_reach && near.confidence > 0.6,
            "{near:?}"
        );
        let far = trained.network.predict(&[40.0, -300.0]);
        assert!(!far.within_reach && far.confidence < 1e-6, "{far:?}");
    }

    #[test]
    fn most_samples_like_the_training_set_are_within_reach() {
        let trained = train(&samples(curved), 1).unwrap();
        let mut stream = RandomStream::new(9, 0);
        let mut drawn = |shift: f64| {
            let like = (0..200).map(|_| [4.0 * stream.uniform() + shift, 100.0 * stream.uniform()]);
            like.filter(|descriptor| trained.network.predict(descriptor).within_reach).count()
        };
        let (like, unlike) = (drawn(0.0), drawn(4.5));
        assert!((180..200).contains(&like) && unlike < 20, "{like} and {unlike} of 200");
    }

    #[test]
    fn duplicate_samples_count_once() {
        let once = samples(curved);
        let again = once.iter().map(|sample| TrainingSample { example: sample.example + 20, ..sample.clone() });
        let twice: Vec<TrainingSample> = once.iter().cloned().chain(again).collect();
        let (one, two) = (train(&once, 1).unwrap(), train(&twice, 1).unwrap());
        assert_eq!(two.network, one.network);
        assert_eq!(two.left_out, [one.left_out.as_slice(), &one.left_out].concat());
        assert_eq!(one.network.clone().with_reach_of(&twice), one.network);
    }

    #[test]
    fn the_holdout_prediction_equals_training_without_the_sample() {
        let samples = samples(curved);
        let (mean, spread) = moments(&samples, 2);
        let rows = |samples: &[TrainingSample]| -> Vec<f64> {
            samples.iter().flat_map(|sample| standardized(&sample.descriptor, &mean, &spread)).collect()
        };
        let targets =
            |samples: &[TrainingSample]| DVector::from_iterator(samples.len(), samples.iter().map(|l| l.target));
        let examples =
            |samples: &[TrainingSample]| -> Vec<usize> { samples.iter().map(|sample| sample.example).collect() };
        let centers = k_means(&rows(&samples), 2, 8, 1);
        let fit = |samples: &[TrainingSample]| {
            solve(&design(&rows(samples), 2, &centers, 1.0), &targets(samples), &examples(samples), 0.1).unwrap()
        };
        let (_, left_out) = fit(&samples);
        let others: Vec<TrainingSample> = samples.iter().filter(|sample| sample.example != 7).cloned().collect();
        let weights = DVector::from_vec(fit(&others).0);
        let predicted = design(&rows(&samples[70..80]), 2, &centers, 1.0) * weights;
        for (found, wanted) in predicted.iter().zip(&left_out[70..80]) {
            assert!((found - wanted).abs() < 1e-10, "{found} against {wanted}");
        }
    }

    #[test]
    fn too_few_or_identical_samples_give_no_network() {
        assert_eq!(train(&[], 1), None);
        assert_eq!(train(&samples(curved)[..70], 1), None);
        let alike: Vec<TrainingSample> =
            (0..40).map(|example| TrainingSample { example, descriptor: vec![1.0, 2.0], target: 0.5 }).collect();
        assert_eq!(train(&alike, 1), None, "one sample, forty times");
    }
}
