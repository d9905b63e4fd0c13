//! Training examples: impacts whose fracture degree is known at every magnitude and threshold.
//!
//! Based on: Schvartzman & Otaduy (I3D 2014), section 3: the degree is learned from examples fractured by full
//! optimization. Labeling every γ by one curve E_max(n) is ours: n depends on W/γ only.

use crate::degree::{self, SITES_MIN, TrainingSample};
use crate::pipeline::contact::ImpactContact;
/// One in this many impacts is labeled twice.
pub(in crate::pipeline) const TWICE: u64 = 8;

/// One point of an example's curve E_max(n).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DegreeCurvePoint {
    /// Number of sites n.
    pub sites: u32,
    /// Smaller E_max(n) of the starts, in shares of the body's energy times local length squared.
    pub energy_max: f64,
    /// Larger E_max(n) of the starts.
    pub energy_max_worst: f64,
    /// E_max(n) from other starts, which measures the noise of labels; 0 for the seven of eight impacts labeled once.
    pub energy_max_again: f64,
    /// n₀ at the threshold that this point labels; 0 if it labels none.
    pub estimate: f64,
}

/// A strain energy field and its curve.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainingExample {
    /// Number of the impact. An impact on two bodies makes two examples.
    pub impact: u64,
    /// Index of the body.
    pub body: usize,
    /// All contacts of the impact.
    pub contacts: Vec<ImpactContact>,
    /// Strain energy of the body, J.
    pub energy_j: f64,
    /// E_1, in the units of the points.
    pub first_moment: f64,
    /// Evenness of the energy's distribution: [`degree::evenness`].
    pub evenness: f64,
    /// Points of the curve by ascending n, from 1.
    pub points: Vec<DegreeCurvePoint>,
    /// Crack nodes nearest to the sites of the best diagram, point after point, without n = 1.
    pub site_nodes: Vec<u32>,
}

impl TrainingExample {
    /// Crack nodes nearest to the sites of the best diagram of point `place`; empty where n = 1.
    pub fn sites(&self, place: usize) -> &[u32] {
        let length = |point: &DegreeCurvePoint| if point.sites > 1 { point.sites as usize } else { 0 };
        let begin: usize = self.points[..place].iter().map(length).sum();
        &self.site_nodes[begin..][..length(&self.points[place])]
    }

    /// γ, n₀ and n of each label. The γ are the logarithmic middles of the intervals in which the degree is constant.
    pub fn labels(&self) -> impl Iterator<Item = (f64, f64, u32)> + '_ {
        records(self.points.iter().map(|point| point.energy_max)).map(|(place, gamma)| {
            let point = &self.points[place];
            (gamma, point.estimate, point.sites)
        })
    }

    /// The degree at γ; `None` beyond the end of the curve.
    pub fn degree(&self, gamma: f64) -> Option<u32> {
        self.points.iter().find(|point| point.energy_max <= gamma).map(|point| point.sites)
    }

    /// One training sample per label.
    pub fn samples(&self, example: usize) -> impl Iterator<Item = TrainingSample> + '_ {
        self.labels().map(move |(gamma, estimate, found)| TrainingSample {
            example,
            descriptor: degree::descriptor(estimate, self.first_moment, self.evenness, gamma),
            target: degree::target(f64::from(found), estimate),
        })
    }

    /// Training samples from the impact's pose and magnitude only: point and direction of the first contact, its
    /// radius, and ln J²/γ.
    pub(in crate::pipeline) fn poses(&self, example: usize) -> impl Iterator<Item = TrainingSample> + '_ {
        let first = self.contacts[0];
        let (place, magnitude) = (first.point_m.coords, first.impulse_ns.norm());
        let direction = first.impulse_ns / magnitude;
        let radius = first.radius_m.unwrap_or(1.0).ln();
        self.labels().map(move |(gamma, estimate, found)| {
            let drive = (magnitude * magnitude / (gamma * self.energy_j)).ln();
            TrainingSample {
                example,
                descriptor: place.iter().chain(direction.iter()).copied().chain([radius, drive]).collect(),
                target: degree::target(f64::from(found), estimate),
            }
        })
    }

    /// Label noise |Δn|/n: the difference of both curves' degrees at the γ of the first curve's labels; empty with one
    /// curve.
    pub fn noise(&self) -> impl Iterator<Item = f64> + '_ {
        let again = |gamma: f64| self.points.iter().find(|point| (0.0..=gamma).contains(&point.energy_max_again));
        let twice = self.impact.is_multiple_of(TWICE);
        self.labels().filter(move |(.., found)| twice && *found as usize >= SITES_MIN).filter_map(
            move |(gamma, _, found)| {
                let found = f64::from(found);
                Some((f64::from(again(gamma)?.sites) - found).abs() / found)
            },
        )
    }
}

/// Indices at which the running minimum falls, without the first, and the γ in the middle of the fall.
pub(in crate::pipeline) fn records(energies: impl Iterator<Item = f64>) -> impl Iterator<Item = (usize, f64)> {
    let mut least = f64::INFINITY;
    energies.enumerate().filter_map(move |(place, energy)| {
        let before = least;
        least = before.min(energy);
        (place > 0 && energy < before && energy > 0.0).then(|| (place, before.sqrt() * energy.sqrt()))
    })
}
