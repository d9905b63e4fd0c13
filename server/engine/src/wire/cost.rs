//! Measurement of request times of an object, for the prediction of costs.

use super::EngineObject;
use crate::object::{ServedObject, write_profiled};
use crate::stage_profiler::StageProfiler;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::pipeline::{CostSample, DisplacementMethod, ImpactSampler, RequestCost, Workspace};
use shatter_proto::Error;
use shatter_proto::layout::Layout;
use shatter_proto::request::{Contact, DegreeRule, DisplacementSource, Request};
use shatter_proto::result::{AlignedBlock, StageCost, StageKind};
use std::time::{Duration, Instant};

/// Seed of the measured impacts.
const SEED: u64 = 1;

/// Plan of a measurement: each number of sites with each of the two settings, one of which solves.
struct Plan {
    sites: &'static [u32],
    iterations: [(u32, DisplacementSource); 2],
    rounds: u64,
}

/// Plan of the requests to which the prediction is fitted.
const FITTED: Plan = Plan {
    sites: &[8, 32, 128],
    iterations: [(0, DisplacementSource::Solve), (6, DisplacementSource::Reduced)],
    rounds: 2,
};

/// Plan of the requests by which the prediction is judged.
const JUDGED: Plan = Plan {
    sites: &[12, 20, 50, 90],
    iterations: [(3, DisplacementSource::Solve), (12, DisplacementSource::Reduced)],
    rounds: 3,
};

/// Predicted cost of requests, and the error of the prediction.
#[derive(Clone, Copy, Debug)]
pub struct CostReport {
    /// Predicted cost.
    pub cost: RequestCost,
    /// Number of requests compared with the prediction.
    pub strikes: usize,
    /// Median of |log(expected/taken)|: 0.1 is ten percent.
    pub error_median: f64,
    /// Ninth decile of the same error.
    pub error_p90: f64,
}

/// Cost sample of a request that took `took`, from the times of its stages.
pub(super) fn sample(sites: u32, solved: bool, iterations: usize, took: Duration, costs: &[StageCost]) -> CostSample {
    let [degree, diagram] = [StageKind::Degree, StageKind::Centroidal].map(StageKind::code);
    let sum = |of: &dyn Fn(u32) -> bool| -> Duration {
        costs.iter().filter(|cost| of(cost.stage.code())).map(|cost| cost.time).sum()
    };
    let seconds = |of: &dyn Fn(u32) -> bool| sum(of).as_secs_f64();
    CostSample {
        sites,
        solved,
        iterations,
        front_s: seconds(&|stage| stage < degree),
        diagram_s: seconds(&|stage| stage == diagram),
        rest_s: took.saturating_sub(sum(&|stage| stage <= diagram)).as_secs_f64(),
    }
}

impl EngineObject {
    /// Measures the requests to which a prediction is fitted.
    ///
    /// # Errors
    /// Those of the requests.
    pub(super) fn timed(&self) -> Result<Vec<CostSample>, Error> {
        self.effective_cost(&FITTED)
    }

    /// Fits a prediction and judges it by other requests; `None` if no fit is possible.
    ///
    /// # Errors
    /// Those of the requests.
    pub fn timing(&self) -> Result<Option<CostReport>, Error> {
        let Some(cost) = RequestCost::fit(&self.timed()?) else { return Ok(None) };
        let judged = self.effective_cost(&JUDGED)?;
        let error = |own: &CostSample| {
            let elastic = if own.solved { DisplacementMethod::Solve } else { DisplacementMethod::Reduced };
            let took_s = own.front_s + own.diagram_s + own.rest_s;
            (cost.request_s(elastic, own.sites, own.iterations) / took_s).ln().abs()
        };
        let mut errors: Vec<f64> = judged.iter().map(error).collect();
        errors.sort_by(f64::total_cmp);
        let [error_median, error_p90] = [errors.len() / 2, errors.len() * 9 / 10].map(|place| errors[place]);
        Ok(Some(CostReport { cost, strikes: errors.len(), error_median, error_p90 }))
    }

    /// Runs the requests of a plan; their results are written to a scratch buffer.
    fn effective_cost(&self, plan: &Plan) -> Result<Vec<CostSample>, Error> {
        let sampler = ImpactSampler::new(&self.prepared);
        let (mut workspace, mut payload) = (Workspace::default(), Vec::new());
        let mut samples = Vec::new();
        for round in 0..plan.rounds {
            let drawn = sampler.impact(SEED, round);
            let contacts = drawn.contacts.iter().map(|contact| Contact {
                point_m: contact.point_m.into(),
                ray: None,
                impulse_ns: contact.impulse_ns.into(),
                duration_s: contact.duration_s,
                radius_m: contact.radius_m,
                partner: None,
            });
            let contacts: Vec<Contact> = contacts.collect();
            for &sites in plan.sites {
                let sites = self.terms.sites_max.map_or(sites, |most| most.min(sites));
                for (iterations, elastic) in plan.iterations {
                    let strike = Request {
                        contacts: contacts.clone(),
                        degree: DegreeRule::Sites(sites),
                        iterations_max: Some(iterations),
                        elastic,
                        ..Request::default()
                    };
                    samples.push(self.time(&strike, sites, &mut workspace, &mut payload)?);
                }
            }
        }
        Ok(samples)
    }

    fn time(
        &self,
        strike: &Request,
        sites: u32,
        workspace: &mut Workspace,
        payload: &mut Vec<AlignedBlock>,
    ) -> Result<CostSample, Error> {
        let (profiler, begun) = (StageProfiler::default(), Instant::now());
        let outcome = self.strike(strike, workspace, &CancelToken::default(), &profiler)?;
        if let Some(layout) = Layout::new(&outcome.counts()) {
            payload.resize(payload.len().max(layout.blocks()), AlignedBlock { bytes: [0; 64] });
            if let Some(mut sections) = layout.split(payload) {
                write_profiled(outcome.as_ref(), &mut sections, layout.base_bytes(), &profiler)?;
            }
        }
        let iterations = strike.iterations_max.unwrap_or(0) as usize;
        Ok(sample(sites, strike.elastic == DisplacementSource::Solve, iterations, begun.elapsed(), &profiler.stages()))
    }
}
