//! Test of the accuracy study on a small block: its structure, not its values.

use serde_json::Value;
use shatter_fracture::surface::shapes;
use shatter_lab::report;
use shatter_lab::study::accuracy::{AccuracyFindings, AccuracyPlan, Measure, drawn, page, run};
use std::collections::HashSet;

/// Required keys of the document.
const KEYS: [&str; 15] = [
    "dial",
    "value",
    "preset",
    "time_ms_p50",
    "time_ms_p99",
    "energy_error",
    "density_error",
    "degree_error",
    "cvd_gap",
    "size_distance",
    "label_fraction",
    "crack_distance_mean",
    "crack_distance_max",
    "volume_l1",
    "estimate",
];

fn findings() -> (AccuracyPlan, AccuracyFindings, usize) {
    let plan = AccuracyPlan::quick("block", shapes::cuboid([0.3, 0.2, 0.15]));
    let mut steps = 0;
    let findings = run(&plan, &mut |_| steps += 1).unwrap();
    (plan, findings, steps)
}

/// Values of one error over the points of one setting.
fn points<'a>(findings: &'a AccuracyFindings, setting: &'a str, measure: Measure) -> impl Iterator<Item = f64> + 'a {
    findings
        .points
        .iter()
        .filter(move |point| point.setting == setting)
        .filter_map(move |point| point.errors.get(measure))
}

#[test]
fn a_study_of_accuracy_has_the_keys_of_the_contract_and_a_point_for_every_setting() {
    let (plan, findings, steps) = findings();
    let named = |[what, _]: &[String; 2]| what.starts_with("rank_own") || what.starts_with("lift_dimension");
    assert!(findings.left_out.iter().all(named), "{:?}", findings.left_out);
    assert_eq!(steps, plan.steps());

    let document = findings.document();
    let report = document["points"].as_array().unwrap();
    assert_eq!(report.len(), findings.points.len());
    for point in report {
        assert!(KEYS.iter().all(|key| point.get(key).is_some()), "{point}");
        assert!(point["time_ms_p50"].as_f64().is_some_and(|time| time > 0.0), "{point}");
        let measured = Measure::ALL.iter().filter(|measure| point[measure.name()] != Value::Null);
        let not_known = point["not_known_yet"].as_array().map_or(0, Vec::len);
        assert!(measured.count() + not_known > 0, "{point}");
    }

    let settings: HashSet<&str> = findings.points.iter().map(|point| point.setting).collect();
    let every = [
        "elastic_spacing",
        "factor_precision",
        "preset",
        "rank",
        "cvd_tolerance",
        "degree",
        "lift",
        "lift_dimension",
        "crack_spacing",
        "tessellation",
    ];
    assert!(every.iter().all(|setting| settings.contains(setting)), "{settings:?}");

    // `film` and `reference` have more elastic nodes than the reference: their elastic errors are not known.
    for point in findings.points.iter().filter(|point| matches!(point.preset, Some("film" | "reference"))) {
        assert!(point.errors.is_not_known(Measure::Energy) && point.errors.get(Measure::Energy).is_none(), "{point:?}");
        assert!(point.errors.get(Measure::Label).is_some(), "cracks are measured on their own lattice: {point:?}");
    }
    assert!(findings.points.iter().any(|point| point.preset == Some("film")));

    // A tighter tolerance ends with less energy, and the exact diagram has a smaller error than node labels.
    let gaps: Vec<f64> = points(&findings, "cvd_tolerance", Measure::Gap).collect();
    assert!(gaps[1] <= gaps[0], "{gaps:?}");
    let labels: Vec<f64> = points(&findings, "tessellation", Measure::Label).collect();
    assert!(labels[1] < labels[0], "{labels:?}");
    assert!(points(&findings, "elastic_spacing", Measure::Energy).all(|error| error > 0.0 && error < 1.0));

    let drawn = drawn(&findings).unwrap();
    let html = report::study(&page(&findings, &drawn, findings.close_up.png().unwrap()));
    assert!(drawn.iter().all(|own| own.svg.starts_with("<svg") && own.csv.lines().count() > 1));
    assert_eq!(findings.close_up.names(), ["input", "draft", "game", "film"]);
    assert!(html.contains("From the left: input, draft, game, film."));
    let zeros = |measure| findings.points.iter().any(|point| point.errors.get(measure) == Some(0.0));
    assert!(html.contains("not known yet"));
    assert_eq!(html.contains("no error at all"), Measure::ALL.into_iter().any(zeros));
    assert!(html.contains("Degree ablation") && html.contains(&findings.ground.machine.replace('&', "&amp;")));
}
