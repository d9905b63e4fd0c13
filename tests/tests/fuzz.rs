//! The fuzz targets in every test run: seeds, inputs that once failed, and a few mutations of both. Long runs, guided by coverage:
//! `tests/fuzz/run`.

use shatter_tests::fuzz::{FuzzTarget, mutated};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs the target, and names an input that violates an invariant.
fn run(target: FuzzTarget, input: &[u8], what: &str) -> bool {
    catch_unwind(AssertUnwindSafe(|| target.run(input))).unwrap_or_else(|_| {
        let path = std::env::temp_dir().join(format!("fuzz-{}-failed", target.name()));
        std::fs::write(&path, input).unwrap();
        panic!("{}: {what} failed; the input is {}", target.name(), path.display())
    })
}

/// Checks that all seeds are read, and that `count` mutations end without a defect.
fn check(target: FuzzTarget, count: u64) {
    let seeds = target.seeds();
    let known = target.regressions().unwrap();
    let read = seeds.iter().enumerate().filter(|(index, seed)| run(target, seed, &format!("seed {index}"))).count();
    for (path, input) in &known {
        run(target, input, &path.display().to_string());
    }
    let all: Vec<&Vec<u8>> = seeds.iter().chain(known.iter().map(|(_, input)| input)).collect();
    let accepted = (0..count).filter(|number| {
        let (one, other) = (number % all.len() as u64, number / all.len() as u64 % all.len() as u64);
        let input = mutated(all[one as usize], all[other as usize], *number);
        run(target, &input, &format!("mutation {number}"))
    });
    let accepted = accepted.count() as u64;
    println!(
        "{}: {read} of {} seeds read, {} known inputs, {accepted} of {count} mutations read",
        target.name(),
        seeds.len(),
        known.len()
    );
    assert!(accepted > 0 && accepted < count, "mutations reach both ends");
}

#[test]
fn mutated_meshes_are_read_or_refused() {
    check(FuzzTarget::Mesh, 6000);
}

#[test]
fn mutated_databases_are_struck_or_refused() {
    check(FuzzTarget::Database, 600);
}

#[test]
fn mutated_requests_are_understood_or_refused() {
    check(FuzzTarget::Request, 60_000);
}

#[test]
fn mutated_configurations_are_read_or_refused() {
    check(FuzzTarget::Toml, 2000);
}

#[test]
fn mutated_scenes_are_read_or_refused() {
    check(FuzzTarget::Scene, 2000);
}
