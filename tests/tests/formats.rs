//! A database of the present format that was baked once and never changes: every later program reads it, and breaks it as recorded.
//!
//! `formats/1.shatter` is a corner of a cube of 1 m, baked by `shatterd bake wedge.obj --name wedge --elastic-spacing 0.2
//! --crack-spacing 0.2 --examples 8`. It holds every kind of tensor but texture coordinates and materials.

use serde_json::Value;
use shatter_tests::fixture::Fixture;
use std::path::Path;

/// Largest relative difference of a number from the recorded one: processors round differently.
const TOLERANCE: f64 = 1e-6;

/// A request to the frozen database, and its outcome since contacts keep the line of their force (5a916eec). The impulse has since become
/// smaller, for fewer sites than the lattice has nodes.
struct RecordedResult {
    options: &'static [&'static str],
    degree_source: &'static str,
    /// Number of sites, and of fragments.
    sites: u64,
    e1_over_gamma: f64,
    /// Volumes of the three largest fragments, m³.
    largest_m3: [f64; 3],
}

const RECORDED: [RecordedResult; 2] = [
    RecordedResult {
        options: &["--degree", "3", "--elastic", "solve"],
        degree_source: "forced",
        sites: 3,
        e1_over_gamma: 20.83378990057288,
        largest_m3: [0.07311831361976373, 0.05347694670038921, 0.04007090515161289],
    },
    RecordedResult {
        options: &["--degree", "inferred", "--elastic", "reduced"],
        degree_source: "inferred",
        sites: 23,
        e1_over_gamma: 20.5187040975633,
        largest_m3: [0.024723255277782765, 0.02471947757165611, 0.023931242480500013],
    },
];

#[track_caller]
fn check_close(found: &Value, recorded: f64) {
    let found = found.as_f64().unwrap();
    assert!((found / recorded - 1.0).abs() <= TOLERANCE, "{found}, recorded {recorded}");
}

fn check_result(fixture: &Fixture, recorded: &RecordedResult) {
    let impact = ["impact", "wedge", "--point", "0.3,0.3,0.3", "--impulse=-700,-600,-550", "--disable", "slivers"];
    let document = fixture.ok("shatter", &[&impact, recorded.options].concat());
    let fragments = document["fragments"].as_array().unwrap();
    let mut volumes: Vec<&Value> = fragments.iter().map(|fragment| &fragment["volume_m3"]).collect();
    volumes.sort_by(|a, b| b.as_f64().unwrap().total_cmp(&a.as_f64().unwrap()));
    assert_eq!(document["degree_source"], recorded.degree_source);
    assert_eq!((document["sites"].as_u64(), volumes.len() as u64), (Some(recorded.sites), recorded.sites));
    check_close(&document["e1_over_gamma"], recorded.e1_over_gamma);
    volumes.iter().zip(recorded.largest_m3).for_each(|(found, recorded)| check_close(found, recorded));
}

#[test]
fn the_frozen_database_is_read_and_struck_as_recorded() {
    let mut fixture = Fixture::new();
    let frozen = Path::new(env!("CARGO_MANIFEST_DIR")).join("formats/1.shatter");
    std::fs::create_dir_all(fixture.databases()).unwrap();
    let file = fixture.databases().join("wedge.shatter");
    std::fs::copy(frozen, &file).unwrap();
    let inspected = fixture.ok("shatterd", &["inspect", file.to_str().unwrap()]);
    assert_eq!((&inspected["format"], &inspected["examples"]), (&"1".into(), &8.into()), "{inspected}");
    assert_eq!((&inspected["crack_nodes"], &inspected["reduced"]["rank"][0]), (&42.into(), &33.into()), "{inspected}");
    assert!(inspected["learned"].is_object(), "{inspected}");
    let output = fixture.run("shatterd", &["inspect", file.to_str().unwrap()]);
    let text = String::from_utf8(output.stdout).unwrap();
    for wanted in
        ["  crack lattice    42 nodes", " m³, ", " J·m²", "Young's modulus ", " kg/m³", "8 examples of ", "format 1, "]
    {
        assert!(text.contains(wanted), "{wanted}: {text}");
    }
    let keys = inspected.as_object().unwrap().keys();
    let raw = keys.filter(|key| key.contains('_')).find(|key| text.contains(key.as_str()));
    assert_eq!(raw, None, "a key of the document in the text for people: {text}");
    fixture.serve(&[]);
    RECORDED.iter().for_each(|recorded| check_result(&fixture, recorded));
}
