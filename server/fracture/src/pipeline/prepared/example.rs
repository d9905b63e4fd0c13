//! Examples: impacts whose fracture degree is known at every magnitude and every threshold.
//!
//! Based on: Schvartzman & Otaduy (I3D 2014), section 3: examples fractured with a full optimisation teach the degree. That
//! one curve E_max(n) labels every γ is ours: n depends on W/γ alone.

use crate::degree::{self, SITES_MIN, TrainingSample};
use crate::pipeline::contact::ImpactContact;
/// One impact of this many is labelled twice.
pub(in crate::pipeline) const TWICE: u64 = 8;

/// One point of an example's curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainingExamplePoint {
    /// n.
    pub sites: u32,
    /// E_max(n), the better of the starts; shares of the body's energy times local length squared.
    pub energy_max: f64,
    /// The worse of the starts.
    pub energy_max_worst: f64,
    /// E_max(n) from other starts: one impact of eight is labelled twice, to see what labels are worth; 0 elsewhere.
    pub energy_max_again: f64,
    /// n₀ at the threshold that this point is a label of; 0 where it is none.
    pub estimate: f64,
}

/// One strain energy field and its curve.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainingExample {
    /// Number of the impact; two bodies that it strikes make two examples.
    pub impact: u64,
    /// The body.
    pub body: usize,
    /// The whole impact.
    pub contacts: Vec<ImpactContact>,
    /// The body's strain energy, J.
    pub energy_j: f64,
    /// E_1 in the units of the points.
    pub first_moment: f64,
    /// How evenly the energy is spread: [`degree::evenness`].
    pub evenness: f64,
    /// E_max(n) by rising n, from 1.
    pub points: Vec<TrainingExamplePoint>,
    /// The sites of the best diagram of each point but n = 1, as the crack nodes nearest to them, point after point.
    pub site_nodes: Vec<u32>,
}

impl TrainingExample {
    /// The sites of the best diagram of point `place`, as crack nodes; none where n = 1.
    pub fn sites(&self, place: usize) -> &[u32] {
        let length = |point: &TrainingExamplePoint| if point.sites > 1 { point.sites as usize } else { 0 };
        let begin: usize = self.points[..place].iter().map(length).sum();
        &self.site_nodes[begin..][..length(&self.points[place])]
    }

    /// γ of each label, its n₀ and its n: the middles, in the logarithm, of the intervals of γ whose degree some point is.
    pub fn labels(&self) -> impl Iterator<Item = (f64, f64, u32)> + '_ {
        records(self.points.iter().map(|point| point.energy_max)).map(|(place, gamma)| {
            let point = &self.points[place];
            (gamma, point.estimate, point.sites)
        })
    }

    /// The degree at γ; `None` beyond the curve's end.
    pub fn degree(&self, gamma: f64) -> Option<u32> {
        self.points.iter().find(|point| point.energy_max <= gamma).map(|point| point.sites)
    }

    /// One lesson per label.
    pub fn lessons(&self, example: usize) -> impl Iterator<Item = TrainingSample> + '_ {
        self.labels().map(move |(gamma, estimate, found)| TrainingSample {
            example,
            descriptor: degree::descriptor(estimate, self.first_moment, self.evenness, gamma),
            target: degree::target(f64::from(found), estimate),
        })
    }

    /// Lessons from the impact's pose and magnitude alone: place and direction of the first contact, its radius, and ln J²/γ.
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

    /// |Δn|/n between the degrees of both curves at the γ of the first one's labels; nothing where there is one curve.
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

/// Places at which the running minimum falls, beyond the first, and the middle γ of the fall.
pub(in crate::pipeline) fn records(energies: impl Iterator<Item = f64>) -> impl Iterator<Item = (usize, f64)> {
    let mut least = f64::INFINITY;
    energies.enumerate().filter_map(move |(place, energy)| {
        let before = least;
        least = before.min(energy);
        (place > 0 && energy < before && energy > 0.0).then(|| (place, before.sqrt() * energy.sqrt()))
    })
}
