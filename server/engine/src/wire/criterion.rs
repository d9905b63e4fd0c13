//! Criterion of a request, and what its result tells of it: the rule of the degree, the figures of strength and energy.

use shatter_fracture::pipeline::{DegreeSource, FractureOutcome};
use shatter_fracture::strength::Criterion;
use shatter_proto::convention::Convention;
use shatter_proto::request::RequestedCriterion;
use shatter_proto::result::{DegreeOrigin, FractureCriterion, SummaryWire};

/// Engine criterion of a wire criterion.
pub(super) fn of(requested: RequestedCriterion) -> Criterion {
    match requested {
        RequestedCriterion::Paper => Criterion::Paper,
        RequestedCriterion::Strength => Criterion::Strength,
    }
}

/// Writes the figures of the criterion by strength and energy into the summary, if that decided; lengths in the unit of `to`.
pub(super) fn write_summary(result: &FractureOutcome, to: &Convention, summary: &mut SummaryWire) {
    let Some(onset) = result.threshold().onset else { return };
    summary.criterion = FractureCriterion::Strength.code();
    summary.stress_over_strength = onset.stress_over_strength;
    summary.averaged_over_m = to.length(onset.averaged_over_m);
    summary.averaged_over_cell = u32::from(onset.is_averaged_over_cell);
    let ledger = result.fracture().and_then(|fracture| fracture.ledger).unwrap_or_default();
    (summary.surface_j, summary.deficit_j) = (ledger.surface_j, ledger.deficit_j);
    summary.released_j = ledger.released_j.unwrap_or(0.0);
}

/// Writes the energy of the impactor into the summary, if that is known.
pub(super) fn write_impactor(result: &FractureOutcome, summary: &mut SummaryWire) {
    let Some(impactor) = result.threshold().impactor else { return };
    (summary.has_impactor, summary.impactor_j) = (1, impactor.energy_j);
    summary.has_load_factor = u32::from(impactor.load_factor.is_some());
    summary.load_factor = impactor.load_factor.unwrap_or(0.0);
}

/// Wire value of the rule that chose a degree.
pub(super) fn degree_origin(source: DegreeSource) -> DegreeOrigin {
    match source {
        DegreeSource::Threshold => DegreeOrigin::Threshold,
        DegreeSource::ClosedForm => DegreeOrigin::ClosedForm,
        DegreeSource::Inferred => DegreeOrigin::Inferred,
        DegreeSource::Verified => DegreeOrigin::Verified,
        DegreeSource::Optimized => DegreeOrigin::Optimized,
        DegreeSource::Forced => DegreeOrigin::Forced,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn criteria_have_the_same_names_on_the_wire() {
        for own in RequestedCriterion::ALL {
            assert_eq!(own.name(), of(own).name());
        }
        assert_eq!(Criterion::ALL.len(), RequestedCriterion::ALL.len());
    }

    #[test]
    fn degree_sources_have_the_same_names_on_the_wire() {
        for source in [
            DegreeSource::Threshold,
            DegreeSource::ClosedForm,
            DegreeSource::Inferred,
            DegreeSource::Verified,
            DegreeSource::Optimized,
            DegreeSource::Forced,
        ] {
            assert_eq!(serde_json::json!(source), degree_origin(source).name());
        }
    }
}
