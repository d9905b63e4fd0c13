//! The effect `dynamics` through both programs: short contacts deform a body less than their peak force at rest.

use serde_json::Value;
use shatter_fracture::database::{self, BakeRequest};
use shatter_fracture::pipeline::{ElementChoice, SurfaceKind};
use shatter_fracture::surface::shapes;
use shatter_tests::fixture::Fixture;
use shatter_tests::real;

/// A served plate of quadratic elements, whose basis needs no examples.
fn plate() -> Fixture {
    let mut fixture = Fixture::new();
    let request = BakeRequest {
        elastic_spacing: Some(0.06),
        crack_spacing: Some(0.06),
        elements: ElementChoice::Quadratic,
        surface: SurfaceKind::Lattice,
        ..real::request("plate", "glass")
    };
    let prepared = request.bake(shapes::cuboid([0.4, 0.3, 0.05])).unwrap();
    std::fs::create_dir_all(fixture.databases()).unwrap();
    database::save(&prepared, &fixture.databases().join("plate.shatter")).unwrap();
    fixture.serve(&[]);
    fixture
}

fn strike(fixture: &Fixture, duration_s: &str, more: &[&str]) -> Value {
    let impact = ["impact", "plate", "--point", "0.07,0.05,0.025", "--impulse", "0,0,-5", "--degree", "9"];
    fixture.ok("shatter", &[&impact[..], &["--duration-s", duration_s], more].concat())
}

/// Time in nanoseconds and bytes of the effect in the list of stages.
fn cost(document: &Value) -> [u64; 2] {
    let stages = document["stages"].as_array().unwrap();
    let own = stages.iter().find(|stage| stage["name"] == "dynamics").unwrap();
    ["ns", "bytes"].map(|key| own[key].as_u64().unwrap())
}

#[test]
fn short_contacts_deform_less_and_the_result_lists_the_effect() {
    let fixture = plate();
    for lift in ["interior", "euclidean"] {
        let energy = |duration_s, more: &[&str]| {
            let document = strike(&fixture, duration_s, &[&["--lift", lift][..], more].concat());
            let effect = cost(&document);
            assert_eq!(more.is_empty(), effect == [0, 0], "{effect:?}");
            assert!(document["fragments"].as_array().unwrap().len() > 1, "{document}");
            document["ledger"]["strain_j"].as_f64().unwrap()
        };
        let dynamic = ["--enable", "dynamics"];
        let [short, long] = ["0.00003", "0.1"].map(|duration_s| energy(duration_s, &dynamic) / energy(duration_s, &[]));
        println!("{lift}: {short:.4} of the energy at rest for 0.03 ms, {long:.4} for 0.1 s");
        assert!(short < 0.5 && (long - 1.0).abs() < 0.02, "{lift}: {short}, {long}");
    }
}
