//! Test of the accuracy study on a small block: its structure, not its values.

use serde_json::Value;
use shatter_fracture::surface::shapes;
use shatter_lab::report;
use shatter_lab::study::accuracy::{
    AccuracyFindings, AccuracyPlan, DISTANCES, Measure, StudyBody, StudyError, drawn, page, results, run,
};
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

/// Checks the errors of the presets on several bodies.
fn check_bodies(document: &Value, plan: &AccuracyPlan) {
    let bodies = document["bodies"].as_array().unwrap();
    assert_eq!(bodies.len(), 2 * plan.body_presets.len(), "{bodies:?}");
    let names: Vec<_> = bodies.iter().map(|body| body["body"].as_str().unwrap()).collect();
    assert_eq!(names, ["block", "block", "ball", "ball"]);
    for body in bodies {
        let error = &body["energy_error"];
        let known = ["median", "bar", "p90"].iter().all(|key| error[key].as_f64().is_some_and(|own| own > 0.0));
        assert!(known && error["at_most"].is_boolean() && body["elastic_nodes"].as_u64() > Some(0), "{body}");
        assert!(body["energy_error_lattice"]["median"].as_f64().is_some_and(|own| own > 0.0), "{body}");
        // Errors of reduced and of solved impacts are apart.
        let solved = body["solved"].as_f64().unwrap();
        assert_eq!(body["energy_error_reduced"].is_null(), solved == 1.0, "{body}");
        assert_eq!(body["energy_error_solved"].is_null(), solved == 0.0, "{body}");
    }
    // Each preset has its median over both bodies, of reduced impacts.
    let over_all = document["all_bodies"].as_array().unwrap();
    assert_eq!(over_all.len(), plan.body_presets.len(), "{over_all:?}");
    for point in over_all {
        let own = bodies.iter().filter(|body| body["preset"] == point["preset"]);
        let reduced = own.filter(|body| body["solved"].as_f64() < Some(1.0)).count();
        assert_eq!(point["bodies"], reduced, "{point}");
        assert_eq!(point["energy_error_reduced"].is_null(), reduced == 0, "{point}");
    }
    // The finest lattice has no finer one to tell its shape from.
    for pair in bodies.chunks_exact(2) {
        assert!(pair[0]["geometry_error"]["median"].is_f64() && pair[1]["geometry_error"].is_null(), "{pair:?}");
    }
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
        assert!(measured.count() > 0, "{point}");
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

    // Every preset has a reference of its own, with an error bar, an interval over the impacts and a ninth decile.
    let presets: Vec<_> = findings.points.iter().filter(|point| point.preset.is_some()).collect();
    assert_eq!(presets.len(), 4);
    for point in presets {
        for measure in [Measure::Energy, Measure::Density, Measure::Degree] {
            let error = point.errors.get(measure).unwrap();
            assert!(error > 0.0 && point.errors.bar(measure).is_some_and(|bar| bar > 0.0), "{point:?}");
        }
        let spread = point.errors.spread(Measure::Energy).unwrap();
        assert!(spread.median[0] <= spread.median[1] && spread.p90 > 0.0, "{point:?}");
        assert!(point.errors.get(Measure::Label).is_some(), "{point:?}");
    }
    check_bodies(&document, &plan);

    // Whole results of the two presets, against both seeds of the reference.
    let outcomes = document["outcomes"].as_array().unwrap();
    assert_eq!(outcomes.len(), plan.outcome_presets.len(), "{outcomes:?}");
    for outcome in outcomes {
        assert_eq!(outcome["pairs"], plan.impacts * plan.outcome_seeds);
        let is_known = |name: &&str| outcome["median"][name].is_f64() && outcome["scatter_median"][name].is_f64();
        assert!(DISTANCES.iter().all(is_known) && outcome["within_scatter_all"].is_f64(), "{outcome}");
    }

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
    assert!(html.contains("all bodies"));
    assert!(html.contains("Elastic energies of several bodies") && html.contains("Whole results, end to end"));
    assert_eq!(html.contains("no error at all"), Measure::ALL.into_iter().any(zeros));
    assert!(html.contains("Degree ablation") && html.contains(&findings.ground.machine.replace('&', "&amp;")));
}

#[test]
fn a_reference_as_coarse_as_its_subject_is_refused() {
    let plan = AccuracyPlan {
        // About as many nodes as `film` and all presets have at the spacing of this plan, so they cannot be refined.
        refined_nodes_max: 1_000,
        ..AccuracyPlan::quick("block", shapes::cuboid([0.3, 0.2, 0.15]))
    };
    let error = run(&plan, &mut |_| ()).unwrap_err();
    let StudyError::CoarseReference { reference, subject } = error else { panic!("{error}") };
    assert!(reference <= 2 * subject && subject > 1_500, "{error}");
    assert!(error.to_string().contains(&subject.to_string()), "{error}");
}

/// Prints what the guide says about the presets' elastic errors; `SHATTER_IMPACTS` changes the number of impacts.
#[test]
#[ignore = "takes minutes: the presets on all bodies"]
fn presets_on_all_bodies() {
    let statue = AccuracyPlan::statue();
    let impacts = std::env::var("SHATTER_IMPACTS").ok().and_then(|text| text.parse().ok());
    for body in [vec![StudyBody::new("statue", statue.mesh)], statue.bodies].concat() {
        let plan = AccuracyPlan {
            impacts: impacts.unwrap_or(statue.impacts),
            snapshots: statue.snapshots,
            refined_nodes_max: statue.refined_nodes_max,
            body_presets: statue.body_presets.clone(),
            elastic: Vec::new(),
            ranks: Vec::new(),
            crack: Vec::new(),
            tolerances: Vec::new(),
            bodies: vec![body],
            ..AccuracyPlan::quick("block", shapes::cuboid([0.3, 0.2, 0.15]))
        };
        let start = std::time::Instant::now();
        let findings = run(&plan, &mut |_| ()).unwrap();
        println!("left out: {:?}", findings.left_out);
        findings.bodies.iter().for_each(|point| println!("{}", point.document()));
        println!("{:?}", start.elapsed());
    }
}

/// Prints what the guide says about whole results of the presets; `SHATTER_IMPACTS` changes the number of impacts.
#[test]
#[ignore = "takes minutes: whole results of the presets on the statue"]
fn whole_results_of_presets() {
    let impacts = std::env::var("SHATTER_IMPACTS").ok().and_then(|text| text.parse().ok());
    let statue = AccuracyPlan::statue();
    let plan = AccuracyPlan { impacts: impacts.unwrap_or(statue.impacts), ..statue };
    let start = std::time::Instant::now();
    for point in results(&plan).unwrap() {
        println!("{}", point.document());
    }
    println!("{:?}", start.elapsed());
}
