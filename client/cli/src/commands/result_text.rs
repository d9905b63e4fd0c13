//! Text of a result for people.

use super::{CliError, out};
use shatter_client::{
    DegreeOrigin, Effect, EnergySource, FractureCriterion, FractureResult, FragmentSurface, Hit, Quality, Summary,
};
use shatter_proto::text::{counted, fixed};

/// Relative difference of radii that is rounding.
const RADIUS_TOLERANCE: f64 = 1e-3;

/// Name of the preset.
pub(super) fn preset(summary: &Summary) -> &'static str {
    summary.quality.map_or("unknown", Quality::name)
}

/// Line of a ray's first hit on the object, for people.
pub(super) fn hit_line(hit: &Hit) -> String {
    let [point, normal] = [hit.point_m, hit.normal].map(|vector| fixed(&vector));
    format!("ray hits {point} (outward normal {normal})")
}

/// Line of the result's error estimates, for people.
fn trust(summary: &Summary) -> String {
    if summary.energy_source == EnergySource::Falloff {
        let confidence = summary.confidence;
        return format!("energy: falloff, no elasticity, no estimate; confidence in the degree {confidence:.2}");
    }
    if summary.energy_source == EnergySource::Bounded {
        return "energy: bounded from above without a solve, because the bound is below the threshold".to_owned();
    }
    // The error is relative to a solve.
    let error = match summary.energy_source {
        EnergySource::Solve => String::new(),
        _ => format!(", energy error {:.2} % (estimated)", 100.0 * summary.energy_error),
    };
    let of_lattice = |error: f64| format!("; lattice error {:.1} % (estimated)", 100.0 * error);
    let lattice = summary.discretization_error.map_or_else(String::new, of_lattice);
    format!(
        "displacements: {}{error}; confidence in the degree {:.2}{lattice}",
        summary.energy_source, summary.confidence
    )
}

/// Note that a contact is wider than the radius that was asked for, m; `None` if it is not.
pub(super) fn widened(asked_m: Option<f64>, radius_m: f64) -> Option<String> {
    let asked_m = asked_m.filter(|asked_m| radius_m > asked_m * (1.0 + RADIUS_TOLERANCE))?;
    let [found, asked] = [radius_m, asked_m].map(significant);
    Some(format!("contact radius {found} m instead of {asked} m: lattice and basis resolve no narrower contact there"))
}

/// Note that the load was lowered to the energy of the impact; `None` if it was not.
fn lowered(summary: &Summary) -> Option<String> {
    let factor = summary.load_factor.filter(|factor| *factor < 1.0)?;
    let (percent, energy_j) = (significant(100.0 * factor), significant(summary.impactor_j?));
    Some(format!("load lowered to {percent} %: the object cannot store more than the {energy_j} J of the impact"))
}

/// Advice for an object that stays whole: the factor of the impulse that breaks it, since E₁ grows with its square. `None` without
/// energy, and if the weight of an anchored object is part of the energy.
fn missing_impulse(summary: &Summary, has_weight: bool) -> Option<String> {
    let factor = match summary.criterion {
        FractureCriterion::Strength => summary.threshold_impulse_factor,
        _ => 1.0 / summary.e1_over_gamma.sqrt(),
    };
    (factor.is_finite() && factor >= 1.0 && !has_weight).then(|| {
        let times = significant(factor);
        match summary.energy_source {
            // The energy is at most the bound, so that the impulse may have to be much larger.
            EnergySource::Bounded => format!(
                "to break it: at least {times} times this impulse, by the bound; `shatter threshold` gives the impulse that does"
            ),
            _ => format!("to break it: about {times} times this impulse"),
        }
    })
}

/// Whether the weight of an anchored object is part of the energy.
pub(super) fn has_weight(result: &FractureResult) -> bool {
    result.effects().any(|cost| cost.effect == Effect::Gravity && cost.has_run)
}

/// Text of the threshold and of the energy relative to it; an even division by falloff alone has no energy to show.
fn load(summary: &Summary) -> String {
    let gamma = format!("γ {:.3e} J·m²", summary.gamma_j_m2);
    if summary.energy_source == EnergySource::Falloff && summary.degree_origin == DegreeOrigin::Forced {
        return gamma;
    }
    if let Some(stress) = summary.stress_over_strength {
        let energy =
            summary.strain_j.map_or(String::new(), |joules| format!(", strain energy {} J", significant(joules)));
        let surface =
            summary.surface_j.map_or(String::new(), |joules| format!(", new surface {} J", significant(joules)));
        let deficit =
            summary.deficit_j.map_or(String::new(), |joules| format!(", {} J short of it", significant(joules)));
        return format!("largest stress {} of the strength{energy}{surface}{deficit}", significant(stress));
    }
    let most = if summary.energy_source == EnergySource::Bounded { "at most " } else { "" };
    format!("{gamma}, E₁/γ {most}{}", significant(summary.e1_over_gamma))
}

/// Four digits, with a power of ten where the number would be long.
pub(super) fn significant(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    if !(1e-3..1e5).contains(&value.abs()) {
        return format!("{value:.3e}");
    }
    let digits = (3 - value.abs().log10().floor() as i32).max(0) as usize;
    format!("{value:.digits$}")
}

/// Prints a result for people.
pub(super) fn screen(result: &FractureResult) -> Result<(), CliError> {
    let summary = result.summary();
    let milliseconds = result.round_trip().as_secs_f64() * 1e3;
    let load = load(&summary);
    if result.is_whole() {
        out(format_args!("{} stays whole ({load}; {milliseconds:.1} ms)\n", summary.object))?;
        result.hit().map_or(Ok(()), |hit| out(format_args!("  {}\n", hit_line(&hit))))?;
        out(format_args!("  {}\n", trust(&summary)))?;
        if let Some(note) = lowered(&summary) {
            return out(format_args!("  {note}\n"));
        }
        return missing_impulse(&summary, has_weight(result))
            .map_or(Ok(()), |advice| out(format_args!("  {advice}\n")));
    }
    let rule = match summary.degree_origin {
        DegreeOrigin::Forced => "request".to_owned(),
        origin => format!("the rule {origin}"),
    };
    out(format_args!(
        "{}: {}, {} by {rule}{} ({load}; {milliseconds:.1} ms, {} bytes)\n",
        summary.object,
        counted(result.fragments().len() as u64, "fragment"),
        counted(u64::from(summary.sites), "site"),
        if summary.is_capped { ", capped" } else { "" },
        result.bytes()
    ))?;
    result.hit().map_or(Ok(()), |hit| out(format_args!("  {}\n", hit_line(&hit))))?;
    out(format_args!("  {}\n", trust(&summary)))?;
    lowered(&summary).map_or(Ok(()), |note| out(format_args!("  {note}\n")))?;
    let effects = result.effects().filter(|cost| cost.has_run && !cost.time.is_zero());
    let times: Vec<String> = (result.stages().filter(|cost| cost.has_run).map(|cost| (cost.stage.name(), cost.time)))
        .chain(effects.map(|cost| (cost.effect.name(), cost.time)))
        .map(|(name, time)| format!("{name} {:.2}", time.as_secs_f64() * 1e3))
        .collect();
    out(format_args!("  ms: {}\n", times.join(", ")))?;
    out(format_args!(
        "  quality: {}, {} ({}), gap of the cells {:.2} % (estimated); {:.2} ms from admission to sending\n",
        preset(&summary),
        counted(summary.iterations.into(), "iteration"),
        summary.stop_criterion,
        100.0 * summary.cvd_gap,
        summary.time.as_secs_f64() * 1e3
    ))?;
    let effects: Vec<&str> = result.effects().filter(|cost| cost.has_run).map(|cost| cost.effect.name()).collect();
    out(format_args!("  effects: {}\n", if effects.is_empty() { "none".to_owned() } else { effects.join(", ") }))?;
    if summary.surface == FragmentSurface::Exact {
        out(format_args!("  surface: exact\n"))?;
    }
    let mut masses: Vec<f64> = result.fragments().map(|fragment| fragment.mass_kg()).collect();
    masses.sort_by(f64::total_cmp);
    let (least, median, most) = (masses[0], masses[masses.len() / 2], masses[masses.len() - 1]);
    let closed = result.fragments().filter(|fragment| fragment.is_closed()).count();
    out(format_args!(
        "  kg: {} in all, {least:.3e} to {most:.3e}, median {median:.3e}; {closed} of {} closed\n",
        significant(masses.iter().sum::<f64>()),
        masses.len()
    ))?;
    if let Some(handle) = result.handle() {
        out(format_args!("  kept: --from {handle}/FRAGMENT strikes a fragment\n"))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{significant, widened};

    #[test]
    fn a_contact_that_was_widened_is_told() {
        let text = widened(Some(5e-4), 0.01506).unwrap();
        assert!(text.starts_with("contact radius 0.01506 m instead of 5.000e-4 m"), "{text}");
        assert_eq!((widened(Some(0.02), 0.02 * (1.0 + 1e-7)), widened(None, 0.02)), (None, None));
    }

    #[test]
    fn numbers_are_printed_with_four_significant_digits() {
        let shown = [0.0, 1.23456, 98_765.4, 1.5e62, 4.2e-7].map(significant);
        assert_eq!(shown, ["0", "1.235", "98765", "1.500e62", "4.200e-7"]);
    }
}
