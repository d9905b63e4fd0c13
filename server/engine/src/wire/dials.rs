//! Dials of accuracy and time: what a strike asks for, and what its answer tells of them.

use shatter_fracture::pipeline::{self, Budget, Cost, DegreeRequest, Dials, ElasticRequest, Outcome, Prepared};
use shatter_proto::answer::{DEGREES, STOP_REASONS, SummaryWire};
use shatter_proto::effect::Effects;
use shatter_proto::request::{Degree, Elastic, Quality, Strike};

/// The engine's preset.
pub(crate) fn preset(quality: Quality) -> pipeline::Quality {
    match quality {
        Quality::Draft => pipeline::Quality::Draft,
        Quality::Game => pipeline::Quality::Game,
        Quality::Film => pipeline::Quality::Film,
        Quality::Reference => pipeline::Quality::Reference,
    }
}

/// The preset that lattices are of.
pub(super) fn of_lattices(quality: pipeline::Quality) -> Quality {
    Quality::ALL.into_iter().find(|own| preset(*own) == quality).unwrap_or_default()
}

/// The dials of `strike`: those that it gives, else those of `quality`.
pub(super) fn of(strike: &Strike, quality: Quality) -> Dials {
    let preset = preset(quality).dials();
    Dials {
        elastic: match strike.elastic {
            Elastic::Preset => preset.elastic,
            Elastic::Reduced => ElasticRequest::Reduced,
            Elastic::Solve => ElasticRequest::Solve,
        },
        degree: match strike.degree {
            Degree::Preset => preset.degree,
            Degree::Inferred => DegreeRequest::Inferred,
            Degree::Verified => DegreeRequest::Verified,
            Degree::ClosedForm => DegreeRequest::ClosedForm,
            Degree::Optimised => DegreeRequest::Optimised,
            Degree::Sites(sites) => DegreeRequest::Sites(sites),
        },
        iterations_max: strike.iterations_max.map_or(preset.iterations_max, |count| count as usize),
        ..preset
    }
}

/// `request` with what `asked` says of error and time, whose own dials stay.
pub(super) fn bounded(request: pipeline::Strike, asked: &Strike, cost: Cost) -> pipeline::Strike {
    let Some(error_max) = asked.error_max else { return timed(request, asked, cost) };
    let (elastic, iterations_max) = (request.elastic, request.iterations_max);
    let mut request = request.to_the_error(error_max);
    if asked.elastic != Elastic::Preset {
        request.elastic = elastic;
    }
    if asked.iterations_max.is_some() {
        request.iterations_max = iterations_max;
    }
    timed(request, asked, cost)
}

/// `request` with what may fall if `asked` bounds its time.
fn timed(request: pipeline::Strike, asked: &Strike, cost: Cost) -> pipeline::Strike {
    let elastic_falls = asked.elastic == Elastic::Preset;
    let budget = Budget { cost, elastic_falls, degree_falls: asked.degree == Degree::Preset };
    pipeline::Strike { budget: asked.time_ms_max.map(|_| budget), ..request }
}

/// The numbers by which an answer is computed, as far as the outcome does not tell them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Used {
    /// What is on.
    pub effects: Effects,
    quality: Quality,
    degree: DegreeRequest,
    tolerance: f64,
    iterations_max: usize,
    rank: usize,
    lift_modes: usize,
    elastic_nodes: usize,
    crack_nodes: usize,
    /// Whether displacements could have been reduced ones.
    pub is_reducible: bool,
}

impl Used {
    /// Of `request`, with those effects and so much of a basis at most, asked of `prepared`.
    pub(super) fn of(
        prepared: &Prepared,
        effects: Effects,
        quality: Quality,
        request: &pipeline::Strike,
        rank_max: Option<u32>,
    ) -> Self {
        let planned = request.planned();
        let modes = |body: &pipeline::Body| body.lift(planned.lift).map_or(0, |lift| lift.dimension.saturating_sub(3));
        let rank = |body: &pipeline::Body| body.reduced().map_or(0, |reduced| reduced.used(rank_max));
        Self {
            effects,
            quality,
            degree: planned.degree,
            tolerance: planned.tolerance,
            iterations_max: planned.iterations_max,
            rank: prepared.bodies.iter().map(rank).max().unwrap_or(0),
            lift_modes: prepared.bodies.iter().map(modes).max().unwrap_or(0),
            elastic_nodes: prepared.elastic_nodes(),
            crack_nodes: prepared.crack_nodes(),
            is_reducible: planned.elastic == ElasticRequest::Reduced
                && prepared.bodies.iter().any(|body| body.reduced().is_some()),
        }
    }

    /// Writes them beside what `outcome` tells.
    pub(super) fn tell(&self, outcome: &Outcome, summary: &mut SummaryWire) {
        let number = |names: &[&str], name: &str| names.iter().position(|own| *own == name).unwrap_or(0) as u32;
        summary.quality = self.quality.number();
        summary.degree = number(&DEGREES, degree(self.degree));
        summary.stop_reason = number(&STOP_REASONS, outcome.stop_reason().name());
        (summary.tolerance, summary.iterations_max) = (self.tolerance, count(self.iterations_max));
        (summary.iterations, summary.cvd_gap) = (count(outcome.iterations), outcome.cvd_gap.unwrap_or(0.0));
        summary.rank = if outcome.reduced_error.is_some() { count(self.rank) } else { 0 };
        summary.lift_modes = count(self.lift_modes);
        summary.reduced_error_max = outcome.reduced_error_max;
        (summary.elastic_nodes, summary.crack_nodes) = (count(self.elastic_nodes), count(self.crack_nodes));
    }
}

fn degree(request: DegreeRequest) -> &'static str {
    match request {
        DegreeRequest::Sites(_) => "sites",
        DegreeRequest::ClosedForm => "closed_form",
        DegreeRequest::Inferred => "inferred",
        DegreeRequest::Verified => "verified",
        DegreeRequest::Optimised => "optimised",
    }
}

fn count(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_have_the_same_names_on_the_wire() {
        for quality in Quality::ALL {
            assert_eq!(quality.name(), preset(quality).name());
            assert_eq!(of_lattices(preset(quality)), quality);
        }
    }

    #[test]
    fn what_is_asked_for_by_itself_goes_before_the_preset() {
        let strike = Strike { elastic: Elastic::Solve, degree: Degree::Sites(7), ..Strike::default() };
        let draft = pipeline::Quality::Draft.dials();
        let expected = Dials { elastic: ElasticRequest::Solve, degree: DegreeRequest::Sites(7), ..draft };
        assert_eq!(of(&strike, Quality::Draft), expected);
        let few = Strike { iterations_max: Some(3), elastic: Elastic::Reduced, ..Strike::default() };
        let film = pipeline::Quality::Film.dials();
        let expected = Dials { iterations_max: 3, elastic: ElasticRequest::Reduced, ..film };
        assert_eq!(of(&few, Quality::Film), expected);
    }
}
