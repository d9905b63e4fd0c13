//! Energies of results under balls by Hertz's theory, balanced by a script that knows only the commands and files.

use shatter_tests::fixture::Fixture;
use shatter_tests::peers;

/// Strikes objects; checks that none stores more than strikes it, and that its energies are those of its fragments.
fn check(strikes: u32, objects: &[&str]) {
    let Some(rows) = peers::ledger(&Fixture::new(), strikes, objects) else { return };
    assert_eq!(rows.len(), objects.len());
    let (mut read, mut limited, mut broken) = (0, 0, 0);
    for row in &rows {
        println!("{row}");
        let number = |key: &str| row[key].as_f64().unwrap_or_else(|| panic!("{key}: {row}"));
        assert_eq!(number("strikes"), f64::from(strikes));
        assert!(number("impactor_over_ball") <= 1.0 + 1e-9, "a ball has all that strikes: {row}");
        assert!(number("strain_over_impactor") <= 1.0 + 1e-9, "the object stores no more: {row}");
        assert!(number("spent_over_strain") <= 1.0 + 1e-9, "cracks and release need no more: {row}");
        assert!(number("surface_error") < 1e-6 && number("released_error") < 1e-6, "{row}");
        let counts = [(&mut read, "read"), (&mut limited, "limited"), (&mut broken, "broken")];
        counts.into_iter().for_each(|(sum, key)| *sum += number(key) as u32);
    }
    println!("{read} read, {limited} limited, {broken} broken");
    assert!(read > 0 && limited > 0 && broken > 0, "{rows:?}");
}

#[test]
fn no_object_stores_more_than_strikes_it() {
    check(20, &["mug", "wall"]);
}

#[test]
#[ignore = "takes minutes"]
fn no_object_stores_more_in_2000_strikes() {
    check(400, &["mug", "horseshoe", "statue", "pane", "wall"]);
}
