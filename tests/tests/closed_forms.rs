//! Strain energies of results against closed forms, by a script that knows only the commands.

use shatter_tests::fixture::Fixture;
use shatter_tests::peers;
use std::collections::BTreeSet;

/// Largest relative error of an energy at the preset `game`.
const BOUND: f64 = 0.05;

#[test]
fn beams_plates_and_spheres_have_the_energies_of_closed_forms() {
    let Some(cases) = peers::closed_forms(&Fixture::new()) else { return };
    for case in &cases {
        println!("{case}");
        let ratio = case["ratio"].as_f64().unwrap();
        assert!((ratio - 1.0).abs() < BOUND, "{case}");
    }
    let objects: BTreeSet<_> = cases.iter().map(|case| case["object"].to_string()).collect();
    assert_eq!(objects.len(), 6, "{objects:?}");
}
