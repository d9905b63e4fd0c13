//! The page *What breaks, and why*: its figures by hand and those of the daemon.

use serde_json::Value;
use shatter_tests::fixture::{Fixture, program};
use shatter_tests::pages::{blocks, text};
use std::f64::consts::{FRAC_PI_2, PI};

const PAGE: &str = "client/guide/src/breaking.md";

/// Difference of a figure of the page from the recomputed one, which its rounding explains.
const ROUNDING: f64 = 6e-3;

/// Runs the page's shell blocks in one shell; returns the documents of its impacts.
fn documents() -> Vec<Value> {
    let fixture = Fixture::new();
    let of = |language: &str| {
        let own = blocks(PAGE).into_iter().filter(|block| block.language == language);
        own.map(|block| block.text).collect::<Vec<_>>().concat()
    };
    std::fs::write(fixture.path("breaking.toml"), of("toml")).unwrap();
    let script = format!("set -eu\ntrap 'kill $(jobs -p) 2>/dev/null || :; wait' EXIT\n{}", of("sh"));
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths([program("")].into_iter().chain(std::env::split_paths(&path))).unwrap();
    let mut bash = fixture.foreign("bash");
    let run = bash.args(["-c", &script]).current_dir(fixture.path("")).env("PATH", path).output().unwrap();
    let [output, error] = [&run.stdout, &run.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    assert!(run.status.success(), "{}: {output}{error}", run.status);
    // Before them are the reports of the bakes.
    let first = output.find("\n{\n").unwrap();
    serde_json::Deserializer::from_str(&output[first..]).into_iter().map(Result::unwrap).collect()
}

/// Figures by hand and of the daemon in the page's last table.
fn table() -> Vec<[f64; 2]> {
    let page = text(PAGE);
    let rows = page.split("| by hand | daemon |").nth(1).unwrap().lines().skip(2);
    let number = |cell: &str| cell.split_whitespace().next()?.parse::<f64>().ok();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let unit = if cells.get(2)?.ends_with("mJ") { 1e-3 } else { 1.0 };
        Some([number(cells.get(2)?)? * unit, number(cells.get(3)?)? * unit])
    };
    rows.map_while(row).collect()
}

/// Stress of a bar of this width and thickness under a bending moment.
fn bending_stress(moment: f64, width: f64, thick: f64) -> f64 {
    6.0 * moment / (width * thick * thick)
}

/// The page's figures by hand, in the order of its table.
fn by_hand() -> [f64; 6] {
    let peak = |impulse: f64, duration: f64| FRAC_PI_2 * impulse / duration;
    let (glass_pa, ceramic_pa, concrete_pa) = (45e6, 40e6, 2.9e6);
    let (side, span, force) = (0.008_f64, 0.09_f64, peak(11.0, 0.1));
    let rod_stress = bending_stress(force * span / 4.0, side, side) / glass_pa;
    let rod_j = force * force * span.powi(3) / (96.0 * 70e9 * side.powi(4) / 12.0);
    let speed = (2.0 * 9.81 * 0.75_f64).sqrt();
    // Of a ring that one force moves: 3/(4π).
    let moment = 3.0 / (4.0 * PI) * peak(0.597 * speed, 2e-4) * 0.0355;
    let mug_stress = bending_stress(moment, 0.1, 0.009) / ceramic_pa;
    let (height, thick, force) = (0.44_f64, 0.1_f64, peak(7.26 * 5.0, 5e-3));
    let wall_stress = bending_stress(force * height, 1.0, thick) / concrete_pa;
    let wall_j = force * force * height.powi(3) / (6.0 * 33e9 * thick.powi(3) / 12.0);
    [rod_stress, rod_j, mug_stress, wall_stress, wall_j, 4.0 * wall_j / (41.0 * 0.05)]
}

#[test]
fn figures_of_the_page_are_those_of_formulas_and_of_the_daemon() {
    let documents = documents();
    let [held, broken, mug, slow, fast] = &documents[..] else { panic!("{documents:?}") };
    let [pieces, stress, energy]: [fn(&Value) -> f64; 3] = [
        |document| document["fragments"].as_array().map_or(0, Vec::len) as f64,
        |document| document["ledger"]["stress_over_strength"].as_f64().unwrap(),
        |document| document["ledger"]["strain_j"].as_f64().unwrap(),
    ];
    println!("pieces: {:?}", documents.iter().map(pieces).collect::<Vec<_>>());
    let found = [stress(held), energy(held), stress(mug), stress(slow), energy(slow), energy(fast) / (41.0 * 0.05)];
    let table = table();
    assert_eq!(table.len(), found.len());
    for ((told, hand), found) in table.iter().zip(by_hand()).zip(found) {
        println!("by hand {hand:.4}, daemon {found:.4}, told {told:?}");
        assert!((told[0] / hand - 1.0).abs() < ROUNDING && (told[1] / found - 1.0).abs() < ROUNDING);
    }
    assert_eq!([held, slow].map(pieces), [0.0; 2]);
    assert!(pieces(broken) > 1.0 && pieces(fast) > 1.0 && stress(broken) >= 1.0, "{broken} {fast}");
    // Other processors round otherwise.
    let page = text(PAGE);
    let before = |words: &str| page.split_once(words).unwrap().0.rsplit(' ').next().unwrap().parse::<f64>().unwrap();
    assert!((before(" pieces.") - pieces(mug)).abs() <= 2.0, "{} pieces", pieces(mug));
    let survives_cm = 75.0 / stress(mug).powi(2);
    assert!((before(" cm, and no more") - survives_cm).abs() < 0.6, "{survives_cm} cm");
}
