//! Position of presets relative to the Pareto front.
//!
//! **Per diagram**: a preset is on the front unless another point of the same diagram is both faster, beyond the whiskers (its last
//! decile of times before the preset's first), and more accurate. A setting that reduces a single error may beat a preset there, which
//! reduces several at once.
//!
//! **Combined**: therefore presets are also judged by the worst of their errors ([`COMBINED`]), each relative to that of `game`, among
//! all points that have all of these errors.

use super::page::together;
use super::{AccuracyFindings, Measure, StudyPoint};
use serde_json::{Value, json};

/// Errors that count in the combined one: of elasticity, of cells, of cracks.
const COMBINED: [Measure; 3] = [Measure::Energy, Measure::Gap, Measure::Label];

/// Preset whose errors are the units of the combined one.
const UNIT: &str = "game";

/// Standing of one preset in one diagram.
#[derive(Clone, Debug, PartialEq)]
pub struct PresetStanding {
    /// Name of the preset.
    pub preset: &'static str,
    /// Name of the diagram, or `combined`.
    pub diagram: &'static str,
    /// Error of the diagram; `None` for the combined one.
    pub measure: Option<Measure>,
    /// First point that is both faster and more accurate: its setting and value; `None` on the front.
    pub beaten_by: Option<[String; 2]>,
}

impl PresetStanding {
    /// JSON document of the standing.
    pub fn document(&self) -> Value {
        json!({
            "preset": self.preset,
            "diagram": self.diagram,
            "error": self.measure.map_or("combined", Measure::name),
            "front": self.beaten_by.is_none(),
            "beaten_by": self.beaten_by,
        })
    }
}

/// Standings of all presets, diagram by diagram, then combined.
pub fn preset_standings(findings: &AccuracyFindings) -> Vec<PresetStanding> {
    let mut all = Vec::new();
    for (diagram, measure, points) in together(findings) {
        let placed: Vec<Placed> =
            points.into_iter().filter_map(|point| Some((point, point.errors.get(measure)?))).collect();
        all.extend(standings_of(diagram, Some(measure), &placed));
    }
    all.extend(standings_of("combined", None, &combined(&findings.points)));
    all
}

/// Point and its error.
type Placed<'a> = (&'a StudyPoint, f64);

fn standings_of(diagram: &'static str, measure: Option<Measure>, points: &[Placed]) -> Vec<PresetStanding> {
    let presets = points.iter().filter_map(|own| Some((own, own.0.preset?)));
    let standing = |(own, preset): (&Placed, &'static str)| {
        let better = points.iter().find(|other| beats(other, own));
        let beaten_by = better.map(|(point, _)| [point.setting.to_owned(), point.label()]);
        PresetStanding { preset, diagram, measure, beaten_by }
    };
    presets.map(standing).collect()
}

/// Whether the first point is faster, beyond the whiskers, and more accurate.
fn beats((one, error): &Placed, (other, other_error): &Placed) -> bool {
    one.times.at(0.9) < other.times.at(0.1) && error < other_error
}

/// Points with the worst of their errors in units of those of [`UNIT`]; empty without that preset.
fn combined(points: &[StudyPoint]) -> Vec<Placed<'_>> {
    let Some(unit) = points.iter().find(|point| point.preset == Some(UNIT)) else { return Vec::new() };
    let worst = |point: &StudyPoint| {
        let ratios = COMBINED.map(|measure| Some(point.errors.get(measure)? / unit.errors.get(measure)?));
        ratios.into_iter().try_fold(0.0, |most: f64, ratio| Some(most.max(ratio?)))
    };
    points.iter().filter_map(|point| Some((point, worst(point)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::accuracy::{PointErrors, PointTimes};

    fn point(setting: &'static str, preset: Option<&'static str>, times: [f64; 3], errors: [f64; 3]) -> StudyPoint {
        let errors =
            COMBINED.iter().zip(errors).fold(PointErrors::default(), |sum, (own, error)| sum.with(*own, error));
        StudyPoint { setting, value: json!(1), preset, times: PointTimes(times.to_vec()), errors }
    }

    fn check(points: Vec<StudyPoint>, diagram: &str, preset: &str, front: bool) {
        let all = preset_standings(&AccuracyFindings { points, ..AccuracyFindings::default() });
        let own: Vec<&PresetStanding> =
            all.iter().filter(|own| own.diagram == diagram && own.preset == preset).collect();
        assert!(!own.is_empty() && own.iter().all(|own| own.beaten_by.is_none() == front), "{own:?}");
    }

    #[test]
    fn only_what_is_faster_and_more_accurate_beats_a_preset() {
        let game = || point("preset", Some("game"), [5.0, 6.0, 7.0], [0.1; 3]);
        let rank = |times: [f64; 3], error: f64| point("rank", None, times, [error; 3]);
        check(vec![game(), rank([1.0, 2.0, 3.0], 0.05)], "elasticity", "game", false);
        check(vec![game(), rank([1.0, 2.0, 3.0], 0.2)], "elasticity", "game", true);
        // Whiskers overlap, or the errors are equal.
        check(vec![game(), rank([4.0, 5.0, 6.0], 0.05)], "elasticity", "game", true);
        check(vec![game(), rank([1.0, 2.0, 3.0], 0.1)], "elasticity", "game", true);
        // A setting of another diagram does not count.
        check(vec![game(), point("cvd_tolerance", None, [1.0; 3], [0.05; 3])], "elasticity", "game", true);
    }

    #[test]
    fn bundles_are_judged_by_the_worst_of_their_errors() {
        let game = || point("preset", Some("game"), [5.0; 3], [0.1, 0.02, 0.004]);
        let film = |errors| point("preset", Some("film"), [50.0; 3], errors);
        // With one of three errors equal to game's, the slower preset is beaten; with all three smaller it is not.
        check(vec![game(), film([0.05, 0.03, 0.001])], "combined", "film", false);
        check(vec![game(), film([0.05, 0.019, 0.001])], "combined", "film", true);
        check(vec![game(), film([0.05, 0.019, 0.001])], "combined", "game", true);
        assert!(combined(&[film([0.1; 3])]).is_empty());
    }
}
