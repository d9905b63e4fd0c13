//! Mass and speed of an impactor through both programs: the object stores no more energy than strikes it.

use serde_json::Value;
use shatter_fracture::database::{self, BakeRequest};
use shatter_fracture::pipeline::{ElementChoice, SurfaceKind};
use shatter_fracture::scene::Material;
use shatter_fracture::surface::shapes;
use shatter_tests::fixture::Fixture;
use shatter_tests::real;

const SIDES_M: [f64; 3] = [0.3, 0.3, 0.02];

/// A served pane of quadratic elements, whose basis needs no examples.
fn pane() -> Fixture {
    let mut fixture = Fixture::new();
    let request = BakeRequest {
        elastic_spacing: Some(0.022),
        crack_spacing: Some(0.022),
        elements: ElementChoice::Quadratic,
        surface: SurfaceKind::Lattice,
        ..real::request("pane", "glass")
    };
    let prepared = request.bake(shapes::cuboid(SIDES_M)).unwrap();
    std::fs::create_dir_all(fixture.databases()).unwrap();
    database::save(&prepared, &fixture.databases().join("pane.shatter")).unwrap();
    fixture.serve(&[]);
    fixture
}

/// A ball of 0.26 kg at 10 m/s that bounces back from the middle.
const STRIKE: [&str; 8] = ["impact", "pane", "--point", "0,0,0.01", "--impulse", "0,0,-5.2", "--duration-s", "0.0001"];

const BALL: [&str; 4] = ["--speed", "10", "--impactor-mass", "0.26"];

fn number(document: &Value, key: &str) -> f64 {
    document["ledger"][key].as_f64().unwrap_or_else(|| panic!("{key}: {}", document["ledger"]))
}

#[test]
fn a_pane_stores_no_more_than_the_ball_has() {
    let fixture = pane();
    let mass_kg = Material::named("glass").unwrap().density_kg_m3 * SIDES_M.iter().product::<f64>();
    let exact_j = 0.5 * 100.0 / (1.0 / 0.26 + 1.0 / mass_kg);
    for effects in [&[][..], &["--enable", "dynamics"]] {
        let free = fixture.ok("shatter", &[&STRIKE[..], effects].concat());
        assert!(["impactor_j", "remainder_j", "load_factor"].iter().all(|key| free["ledger"][key].is_null()));
        let limited = fixture.ok("shatter", &[&STRIKE[..], &BALL, effects].concat());
        let [energy, strain, remainder, factor] =
            ["impactor_j", "strain_j", "remainder_j", "load_factor"].map(|key| number(&limited, key));
        println!("{effects:?}: {} J without a limit, {strain} of {energy} J with it", number(&free, "strain_j"));
        // The boundary of the lattice rounds the corners of the pane off.
        assert!((energy / exact_j - 1.0).abs() < 1e-4, "{energy} of {exact_j} J");
        assert!(strain <= energy * (1.0 + 1e-9) && (strain + remainder - energy).abs() < 1e-9 * energy);
        assert!((factor * factor * number(&free, "strain_j") / strain - 1.0).abs() < 1e-9, "{factor}");
        // At rest the pane would store 2.9 times the energy, and in response to the pulse half of that.
        assert_eq!(factor < 0.7, effects.is_empty(), "{factor}");
        let fast = ["--speed", "30", "--impactor-mass", "0.26"];
        let whole = fixture.ok("shatter", &[&STRIKE[..], &fast, effects].concat());
        let [own, alone] = [&whole, &free].map(|document| number(document, "strain_j"));
        assert_eq!((number(&whole, "load_factor"), own), (1.0, alone));
        assert_eq!(whole["fragments"], free["fragments"]);
        let output = fixture.run("shatter", &[&STRIKE[..], &BALL, effects].concat());
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && text.contains("load lowered to "), "{text}");
    }
    let wall = fixture.ok("shatter", &[&STRIKE[..], &["--speed", "-1", "--impactor-mass", "inf"]].concat());
    assert_eq!([number(&wall, "load_factor"), number(&wall, "strain_j"), number(&wall, "impactor_j")], [0.0; 3]);
    assert_eq!(wall["fracture_degree"], 1);
    let refused = |more: &[&str]| {
        let (code, document) = fixture.json("shatter", &[&STRIKE[..], more].concat());
        (code, document["error"]["kind"].as_str().unwrap().to_owned())
    };
    let massless = refused(&["--speed", "1", "--impactor-mass", "0"]);
    assert_eq!(massless, (3, "contact_partner".to_owned()));
    let inelastic = refused(&[&BALL[..], &["--disable", "elastic"]].concat());
    assert_eq!(inelastic, (3, "effect".to_owned()));
    let alone = fixture.run("shatter", &[&STRIKE[..], &["--speed", "1"]].concat());
    assert_eq!(alone.status.code(), Some(2), "{alone:?}");
}
