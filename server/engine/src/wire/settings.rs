//! Solver settings: accuracy and time of a request, and their values in its result.

use shatter_fracture::pipeline::{
    self, DegreeRequest, DisplacementMethod, FractureOutcome, PreparedObject, RequestCost, StopReason, TimeBudget,
};
use shatter_proto::effect::Effects;
use shatter_proto::request::{DegreeRule, DisplacementSource, Quality, Request};
use shatter_proto::result::{DegreeMethod, StopCriterion, SummaryWire};

/// Engine preset of a wire preset.
pub(crate) fn preset(quality: Quality) -> pipeline::Preset {
    match quality {
        Quality::Draft => pipeline::Preset::Draft,
        Quality::Game => pipeline::Preset::Game,
        Quality::Film => pipeline::Preset::Film,
        Quality::Reference => pipeline::Preset::Reference,
    }
}

/// Wire preset of an engine preset.
pub(super) fn of_lattices(quality: pipeline::Preset) -> Quality {
    Quality::ALL.into_iter().find(|own| preset(*own) == quality).unwrap_or_default()
}

/// `request`, which holds the settings of a preset, with those of the error bound of `asked`, then with those that `asked` gives.
pub(super) fn given(request: pipeline::FractureRequest, asked: &Request) -> pipeline::FractureRequest {
    let request = match asked.error_max {
        Some(error_max) => request.to_the_error(error_max),
        None => request,
    };
    pipeline::FractureRequest {
        elastic: match asked.elastic {
            DisplacementSource::Preset => request.elastic,
            DisplacementSource::Reduced => DisplacementMethod::Reduced,
            DisplacementSource::Solve => DisplacementMethod::Solve,
        },
        degree: match asked.degree {
            DegreeRule::Preset => request.degree,
            DegreeRule::Inferred => DegreeRequest::Inferred,
            DegreeRule::Verified => DegreeRequest::Verified,
            DegreeRule::ClosedForm => DegreeRequest::ClosedForm,
            DegreeRule::Optimized => DegreeRequest::Optimized,
            DegreeRule::Sites(sites) => DegreeRequest::Sites(sites),
        },
        iterations_max: asked.iterations_max.map_or(request.iterations_max, |count| count as usize),
        ..request
    }
}

/// Applies the time bound of `asked` to `request`, and marks which settings may be degraded for it.
pub(super) fn timed(
    request: pipeline::FractureRequest,
    asked: &Request,
    cost: RequestCost,
) -> pipeline::FractureRequest {
    let elastic_falls = asked.elastic == DisplacementSource::Preset;
    let budget = TimeBudget { cost, elastic_falls, degree_falls: asked.degree == DegreeRule::Preset };
    pipeline::FractureRequest { budget: asked.time_ms_max.map(|_| budget), ..request }
}

/// Settings by which a result is computed, as far as the engine's result does not contain them.
#[derive(Clone, Copy, Debug)]
pub(super) struct EffectiveSettings {
    /// Effects that are on.
    pub effects: Effects,
    quality: Quality,
    degree: DegreeRequest,
    tolerance: f64,
    iterations_max: usize,
    rank: usize,
    lift_modes: usize,
    elastic_nodes: usize,
    crack_nodes: usize,
    /// Fewest cells across the walls of any body; `None`: unknown.
    elements_across: Option<f64>,
    /// Whether reduced displacements were possible.
    pub is_reducible: bool,
}

impl EffectiveSettings {
    /// Settings of `request` for `prepared`, with these effects and a reduced basis of at most rank `rank_max`.
    pub(super) fn of(
        prepared: &PreparedObject,
        effects: Effects,
        quality: Quality,
        request: &pipeline::FractureRequest,
        rank_max: Option<u32>,
    ) -> Self {
        let planned = request.planned();
        let modes =
            |body: &pipeline::PreparedBody| body.lift(planned.lift).map_or(0, |lift| lift.dimension.saturating_sub(3));
        let rank = |body| prepared.basis(body, request.effects).map_or(0, |reduced| reduced.used(rank_max));
        Self {
            effects,
            quality,
            degree: planned.degree,
            tolerance: planned.tolerance,
            iterations_max: planned.iterations_max,
            rank: (0..prepared.bodies.len()).map(rank).max().unwrap_or(0),
            lift_modes: prepared.bodies.iter().map(modes).max().unwrap_or(0),
            elastic_nodes: prepared.elastic_nodes(),
            crack_nodes: prepared.crack_nodes(),
            elements_across: prepared.report.elements_across(),
            is_reducible: is_reducible(prepared, &planned),
        }
    }

    /// Writes the settings into the summary.
    pub(super) fn write_summary(&self, result: &FractureOutcome, summary: &mut SummaryWire) {
        summary.quality = self.quality.number();
        summary.degree = degree_method(self.degree).code();
        summary.stop_reason = stop_criterion(result.stop_reason()).code();
        (summary.tolerance, summary.iterations_max) = (self.tolerance, count(self.iterations_max));
        (summary.iterations, summary.cvd_gap) = (count(result.iterations()), result.cvd_gap().unwrap_or(0.0));
        summary.rank = if result.threshold().reduced_error.is_some() { count(self.rank) } else { 0 };
        summary.lift_modes = count(self.lift_modes);
        summary.reduced_error_max = result.threshold().reduced_error_max;
        (summary.elastic_nodes, summary.crack_nodes) = (count(self.elastic_nodes), count(self.crack_nodes));
        summary.elements_across = self.elements_across.unwrap_or(0.0) as f32;
        summary.discretization_error = result.threshold().discretization_error.unwrap_or(0.0);
    }
}

/// Whether the displacements of `request` on the whole object may be reduced ones.
pub(super) fn is_reducible(prepared: &PreparedObject, request: &pipeline::FractureRequest) -> bool {
    request.elastic == DisplacementMethod::Reduced
        && (0..prepared.bodies.len()).any(|body| prepared.basis(body, request.effects).is_some())
}

fn degree_method(request: DegreeRequest) -> DegreeMethod {
    match request {
        DegreeRequest::Sites(_) => DegreeMethod::Sites,
        DegreeRequest::ClosedForm => DegreeMethod::ClosedForm,
        DegreeRequest::Inferred => DegreeMethod::Inferred,
        DegreeRequest::Verified => DegreeMethod::Verified,
        DegreeRequest::Optimized => DegreeMethod::Optimized,
    }
}

fn stop_criterion(reason: StopReason) -> StopCriterion {
    match reason {
        StopReason::Complete => StopCriterion::Complete,
        StopReason::Capped => StopCriterion::Capped,
        StopReason::Converged => StopCriterion::Converged,
        StopReason::ErrorMet => StopCriterion::ErrorMet,
        StopReason::Time => StopCriterion::Time,
        StopReason::Iterations => StopCriterion::Iterations,
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
    fn explicit_settings_override_the_preset() {
        let strike = Request { elastic: DisplacementSource::Solve, degree: DegreeRule::Sites(7), ..Request::default() };
        let request = pipeline::FractureRequest::at(nalgebra::Point3::origin(), nalgebra::Vector3::x());
        let draft = request.clone().of_quality(pipeline::Preset::Draft);
        let degree = DegreeRequest::Sites(7);
        let expected = pipeline::FractureRequest { elastic: DisplacementMethod::Solve, degree, ..draft.clone() };
        assert_eq!(given(draft, &strike), expected);
        let few = Request { iterations_max: Some(3), elastic: DisplacementSource::Reduced, ..Request::default() };
        let film = request.of_quality(pipeline::Preset::Film);
        let expected =
            pipeline::FractureRequest { iterations_max: 3, elastic: DisplacementMethod::Reduced, ..film.clone() };
        assert_eq!(given(film, &few), expected);
    }

    #[test]
    fn explicit_settings_override_the_error_bound() {
        let point = pipeline::FractureRequest::at(nalgebra::Point3::origin(), nalgebra::Vector3::x());
        let game = point.of_quality(pipeline::Preset::Game);
        let bounded = Request { error_max: Some(0.02), ..Request::default() };
        assert_eq!(given(game.clone(), &bounded), game.clone().to_the_error(0.02));
        let (elastic, iterations_max) = (DisplacementSource::Solve, Some(3));
        let expected = pipeline::FractureRequest {
            elastic: DisplacementMethod::Solve,
            iterations_max: 3,
            ..game.clone().to_the_error(0.02)
        };
        assert_eq!(given(game, &Request { elastic, iterations_max, ..bounded }), expected);
    }
}
