//! Bad meshes at scale: every mutant ends in a checked result or in an error that names the reason.

use shatter_lab::study::mesh_fuzz::{
    BaseMesh, FuzzPlan, FuzzTally, FuzzVerdict, Judge, MUST_ACCEPT_RATE_MIN, MeshSize, Mutant, REGRESSIONS,
    from_folder, generated, run,
};
use std::path::Path;
use std::time::{Duration, Instant};

/// Mutants of usual runs, of the generated shapes and of the real meshes: 10 and 1 or 2 per defect.
const USUAL: [usize; 2] = [90, 14];

/// Mutants of long runs: those of usual runs and more.
/// `shatterd study stability --mutants 15000` runs more.
const LONG: [usize; 2] = [880, 180];

/// Time after which a mutant counts as hanging; much longer than a busy machine needs.
const DEADLINE: Duration = Duration::from_secs(60);

/// The real meshes, if there are any.
fn real() -> Vec<BaseMesh> {
    match std::env::var_os("SHATTER_MESHES") {
        Some(folder) => from_folder(Path::new(&folder), MeshSize::Small).unwrap(),
        None => {
            println!("skipped: SHATTER_MESHES is not set (mutants of real meshes)");
            Vec::new()
        }
    }
}

/// Checks that every mutant has a result or an error with a reason, and that those that must be accepted have a result.
fn check(meshes: Vec<BaseMesh>, count: usize) {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let judge = Judge::new(MeshSize::Small, DEADLINE).unwrap();
    let plan = FuzzPlan { count, seed: 1, meshes, judge, repeat_every: 13, threads };
    let begun = Instant::now();
    let tally: FuzzTally = run(&plan, &mut |_, _| ());
    println!("{count} mutants in {:.1} s\n{tally}", begun.elapsed().as_secs_f64());
    assert_eq!((tally.all.tried, tally.all.failed), (count as u64, 0));
    assert!(tally.must_accept_rate >= MUST_ACCEPT_RATE_MIN, "{}", tally.must_accept_rate);
    for row in tally.per_defect.iter().filter(|row| row.must_accept.tried >= 10) {
        assert!(row.must_accept.accept_rate() >= MUST_ACCEPT_RATE_MIN, "{row:?}");
    }
}

fn check_all([of_generated, of_real]: [usize; 2]) {
    check(generated(MeshSize::Small), of_generated);
    let real = real();
    if !real.is_empty() {
        check(real, of_real);
    }
}

#[test]
fn damaged_meshes_are_baked_or_rejected() {
    check_all(USUAL);
}

/// `cargo test --release --workspace --test suite mesh_fuzz:: -- --ignored --nocapture`
#[test]
#[ignore = "minutes"]
fn a_thousand_damaged_meshes_are_baked_or_rejected() {
    check_all(LONG);
}

#[test]
fn fixed_mesh_regressions_stay_fixed() {
    let (meshes, judge) =
        ([generated(MeshSize::Small), real()].concat(), Judge::new(MeshSize::Small, DEADLINE).unwrap());
    for id in REGRESSIONS {
        let mutant: Mutant = id.parse().unwrap();
        let Some(base) = meshes.iter().find(|base| base.name == mutant.mesh) else {
            println!("skipped: {id}: no such mesh");
            continue;
        };
        match judge.mutant(&base.mesh, &mutant) {
            FuzzVerdict::Failed(fault) => panic!("{id}: {fault}"),
            FuzzVerdict::Refused { message, justified: false, .. } => panic!("{id}: refused: {message}"),
            FuzzVerdict::Checked { .. } | FuzzVerdict::Refused { .. } => {}
        }
    }
}
