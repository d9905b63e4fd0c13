//! Cost of requests on one object, predicted from the number of sites.
//!
//! Ours. A caller with a clock times a few requests with several numbers of sites, and the times of the stages are
//! fitted by straight lines. An assignment with n sites takes n comparisons per node. The area of n sites' cracks grows
//! with the cube root of n. A square root replaces it, because every fragment also has a constant cost.

use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::prepared::parameters::DisplacementMethod;

/// Approximate number of iterations of an unlimited descent.
const ITERATIONS_USUAL: f64 = 12.0;

/// Number of diagrams of a verification: at least two starts for each of two numbers of sites, and half as many again.
const DIAGRAMS_VERIFIED: f64 = 6.0;

/// Range to which the measured pace of a request is limited.
const SCALE_RANGE: [f64; 2] = [0.25, 4.0];

/// Cost of requests on one object and one machine, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RequestCost {
    /// Time before the degree with a reduced displacement, s.
    pub reduced_s: f64,
    /// Time before the degree with a solve, s.
    pub solve_s: f64,
    /// Time of a diagram's start: constant, and per site, s.
    pub start_s: [f64; 2],
    /// Time of one iteration: constant, and per site, s.
    pub iteration_s: [f64; 2],
    /// Time after the diagram: constant, and per √site, s.
    pub rest_s: [f64; 2],
}

/// Measured times of one request.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CostSample {
    /// Number of sites.
    pub sites: u32,
    /// True if the displacement was solved for.
    pub solved: bool,
    /// Number of iterations of the diagram.
    pub iterations: usize,
    /// Time before the degree, s.
    pub front_s: f64,
    /// Time of the diagram, s.
    pub diagram_s: f64,
    /// Time after the diagram, s.
    pub rest_s: f64,
}

impl RequestCost {
    /// Default cost of an object without samples, from typical times per node and tetrahedron.
    pub fn typical(prepared: &PreparedObject) -> Self {
        let count = |count: usize| count as f64;
        let (elastic, nodes) = (count(prepared.elastic_nodes()), count(prepared.crack_nodes()));
        let tets = count(prepared.crack_tets());
        Self {
            reduced_s: 1.5e-7 * elastic,
            solve_s: 7e-7 * elastic,
            start_s: [5e-8 * nodes, 1.5e-9 * nodes],
            iteration_s: [2e-8 * nodes, 1e-9 * nodes],
            rest_s: [1e-8 * tets, 4e-9 * tets],
        }
    }

    /// Fits the cost to measured times.
    ///
    /// `None` without samples for at least two numbers of sites, each with and without iterations.
    pub fn fit(samples: &[CostSample]) -> Option<Self> {
        let least = |solved: bool| {
            let fronts = samples.iter().filter(|sample| sample.solved == solved).map(|sample| sample.front_s);
            fronts.reduce(f64::min)
        };
        let whole = |own: &CostSample| (own.front_s + own.diagram_s + own.rest_s).is_finite();
        samples.iter().all(whole).then_some(())?;
        let front = least(false).or(least(true))?;
        let starts: Vec<[f64; 2]> = pairs(samples.iter().filter(|sample| sample.iterations == 0), |own| own.diagram_s);
        let step = |own: &CostSample| {
            let start = starts.iter().find(|start| start[0] == f64::from(own.sites)).map_or(0.0, |start| start[1]);
            (own.diagram_s - start).max(0.0) / own.iterations as f64
        };
        let steps = pairs(samples.iter().filter(|sample| sample.iterations > 0), step);
        let mut rests = pairs(samples.iter(), |own| own.rest_s);
        rests.iter_mut().for_each(|rest| rest[0] = rest[0].sqrt());
        Some(Self {
            reduced_s: front,
            solve_s: least(true).unwrap_or(front),
            start_s: line(&starts)?,
            iteration_s: line(&steps)?,
            rest_s: line(&rests)?,
        })
    }

    /// Time before the degree, s.
    pub fn front_s(&self, elastic: DisplacementMethod) -> f64 {
        match elastic {
            DisplacementMethod::Reduced => self.reduced_s,
            DisplacementMethod::Solve => self.solve_s,
        }
    }

    /// Time of the start of a diagram with this number of sites, including labels, s.
    pub fn start_s(&self, sites: u32) -> f64 {
        self.start_s[0] + self.start_s[1] * f64::from(sites)
    }

    /// Time of one iteration of such a diagram, s.
    pub fn iteration_s(&self, sites: u32) -> f64 {
        self.iteration_s[0] + self.iteration_s[1] * f64::from(sites)
    }

    /// Time after the diagram, s.
    pub fn rest_s(&self, sites: u32) -> f64 {
        self.rest_s[0] + self.rest_s[1] * f64::from(sites).sqrt()
    }

    /// Time of a whole request, s.
    pub fn request_s(&self, elastic: DisplacementMethod, sites: u32, iterations: usize) -> f64 {
        let diagram_s = self.start_s(sites) + iterations as f64 * self.iteration_s(sites);
        self.front_s(elastic) + diagram_s + self.rest_s(sites)
    }

    /// Time of a verification of this estimated number of sites, s.
    pub fn verify_s(&self, sites: u32) -> f64 {
        DIAGRAMS_VERIFIED * (self.start_s(sites) + ITERATIONS_USUAL * self.iteration_s(sites))
    }

    /// Time of a search for the degree from below that ends at this number of sites, s.
    ///
    /// It makes two starts for each number of sites up to 16, then for numbers in steps of a tenth.
    pub fn optimize_s(&self, sites: u32) -> f64 {
        let numbers =
            std::iter::successors(Some(2), |sites: &u32| Some(sites + if *sites < 16 { 1 } else { sites / 10 }));
        let one = |sites: u32| 2.0 * (self.start_s(sites) + ITERATIONS_USUAL * self.iteration_s(sites));
        numbers.take_while(|own| *own <= sites.max(2)).map(one).sum()
    }

    /// Ratio of the measured to the expected time before the degree.
    ///
    /// It applies to later stages too, because a slow stage, such as with other programs on the same cores, is followed
    /// by slow ones. Over whole requests on a busy machine, the pace leaves a third of the spread.
    pub fn time_scale(&self, elastic: DisplacementMethod, front_s: f64) -> f64 {
        let time_scale = front_s / self.front_s(elastic);
        if time_scale.is_normal() { time_scale.clamp(SCALE_RANGE[0], SCALE_RANGE[1]) } else { 1.0 }
    }

    /// The cost with the times of the diagram and after it multiplied by `time_scale`.
    #[must_use]
    pub fn scaled_by(self, time_scale: f64) -> Self {
        let Self { start_s, iteration_s, rest_s, .. } = self;
        let [start_s, iteration_s, rest_s] =
            [start_s, iteration_s, rest_s].map(|line| line.map(|value| time_scale * value));
        Self { start_s, iteration_s, rest_s, ..self }
    }

    /// The cost with all times multiplied by `factor`.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self { reduced_s: factor * self.reduced_s, solve_s: factor * self.solve_s, ..self.scaled_by(factor) }
    }

    /// The cost with the time after the diagram multiplied by `factor`.
    #[must_use]
    pub fn with_rest(self, factor: f64) -> Self {
        Self { rest_s: self.rest_s.map(|value| factor * value), ..self }
    }
}

/// Pairs of a number of sites and the smallest value of `of` among its samples.
fn pairs<'a>(samples: impl Iterator<Item = &'a CostSample>, of: impl Fn(&CostSample) -> f64) -> Vec<[f64; 2]> {
    let mut pairs: Vec<[f64; 2]> = Vec::new();
    for sample in samples {
        let sites = f64::from(sample.sites);
        match pairs.iter_mut().find(|pair| pair[0] == sites) {
            Some(pair) => pair[1] = pair[1].min(of(sample)),
            None => pairs.push([sites, of(sample)]),
        }
    }
    pairs
}

/// Value at 0 and slope of the line with the least squared relative errors at `points`, neither negative.
///
/// `None` if all points have the same abscissa, or a time is not positive.
fn line(points: &[[f64; 2]]) -> Option<[f64; 2]> {
    let first = points.first()?[0];
    if points.iter().all(|[x, _]| *x == first) || points.iter().any(|[_, y]| *y <= 0.0 || !y.is_finite()) {
        return None;
    }
    let sum = |of: &dyn Fn(f64, f64) -> f64| points.iter().map(|[x, y]| of(*x, *y)).sum::<f64>();
    let [weight, x, xx] = [sum(&|_, y| 1.0 / (y * y)), sum(&|x, y| x / (y * y)), sum(&|x, y| x * x / (y * y))];
    let [one, own] = [sum(&|_, y| 1.0 / y), sum(&|x, y| x / y)];
    let determinant = weight * xx - x * x;
    let [at_0, slope] = [(one * xx - own * x) / determinant, (weight * own - x * one) / determinant];
    Some(match (at_0 < 0.0, slope < 0.0) {
        (false, false) => [at_0, slope],
        (true, _) => [0.0, own / xx],
        (_, true) => [one / weight, 0.0],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOWN: RequestCost = RequestCost {
        reduced_s: 1e-3,
        solve_s: 3e-3,
        start_s: [2e-4, 1e-5],
        iteration_s: [1e-4, 1e-5],
        rest_s: [1e-3, 2e-4],
    };

    fn sample(sites: u32, iterations: usize, solved: bool) -> CostSample {
        let elastic = if solved { DisplacementMethod::Solve } else { DisplacementMethod::Reduced };
        let diagram_s = KNOWN.start_s(sites) + iterations as f64 * KNOWN.iteration_s(sites);
        CostSample {
            sites,
            solved,
            iterations,
            front_s: KNOWN.front_s(elastic),
            diagram_s,
            rest_s: KNOWN.rest_s(sites),
        }
    }

    #[track_caller]
    fn check(samples: &[CostSample]) {
        let fitted = RequestCost::fit(samples).unwrap();
        for sites in [2, 17, 50, 300] {
            for elastic in [DisplacementMethod::Reduced, DisplacementMethod::Solve] {
                let ratio = fitted.request_s(elastic, sites, 7) / KNOWN.request_s(elastic, sites, 7);
                assert!((ratio - 1.0).abs() < 1e-9, "{sites} {elastic:?}: {ratio}");
            }
        }
    }

    #[test]
    fn the_cost_model_recovers_measured_costs() {
        let all = [8, 32, 128]
            .into_iter()
            .flat_map(|sites| [(0, true), (8, false)].map(|(iterations, solved)| sample(sites, iterations, solved)));
        check(&all.collect::<Vec<_>>());
    }

    #[test]
    fn a_slow_start_scales_the_expected_rest() {
        for (elastic, front_s) in
            [(DisplacementMethod::Reduced, KNOWN.reduced_s), (DisplacementMethod::Solve, KNOWN.solve_s)]
        {
            let slow = KNOWN.scaled_by(KNOWN.time_scale(elastic, 1.5 * front_s));
            let after_s = |cost: RequestCost| cost.request_s(elastic, 30, 4) - front_s;
            assert!((after_s(slow) / after_s(KNOWN) - 1.5).abs() < 1e-12 && slow.front_s(elastic) == front_s);
        }
        for nonsense in [0.0, f64::NAN, f64::INFINITY] {
            assert_eq!(KNOWN.time_scale(DisplacementMethod::Reduced, nonsense), 1.0);
        }
        assert_eq!(KNOWN.time_scale(DisplacementMethod::Reduced, 1e9), SCALE_RANGE[1]);
    }

    #[test]
    fn too_few_samples_give_no_cost_model() {
        assert_eq!(RequestCost::fit(&[]), None);
        assert_eq!(RequestCost::fit(&[sample(8, 0, true), sample(8, 4, false)]), None);
        assert_eq!(RequestCost::fit(&[sample(8, 0, true), sample(32, 0, true)]), None);
        let invalid = CostSample { rest_s: f64::NAN, ..sample(32, 4, true) };
        assert_eq!(RequestCost::fit(&[sample(8, 0, true), sample(32, 0, true), sample(8, 4, true), invalid]), None);
    }

    #[test]
    fn fitted_costs_are_never_negative() {
        let samples: Vec<CostSample> = [(8, 4e-3), (32, 3e-3), (128, 2e-3)]
            .into_iter()
            .flat_map(|(sites, rest_s)| [0, 8].map(|its| CostSample { rest_s, ..sample(sites, its, true) }))
            .collect();
        let fitted = RequestCost::fit(&samples).unwrap();
        assert!(fitted.rest_s[1] == 0.0 && (2e-3..4e-3).contains(&fitted.rest_s[0]), "{fitted:?}");
    }
}
