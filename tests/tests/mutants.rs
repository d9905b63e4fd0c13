//! Bad meshes at scale: every mutant ends in a checked answer or in a refusal that names its reason.

use shatter_server::study::mutants::{
    Base, Judge, Mutant, Plan, REGRESSIONS, Tally, Verdict, from_folder, generated, run,
};
use std::path::Path;
use std::time::{Duration, Instant};

/// Rounds of all meshes and defects: more than a thousand mutants of the generated shapes alone.
const ROUNDS: usize = 7;

/// Where something hangs; far from what a busy machine needs.
const DEADLINE: Duration = Duration::from_secs(60);

/// Share of the mutants that must be accepted that is.
const MUST_ACCEPT_RATE_MIN: f64 = 0.95;

/// The generated shapes, and the real meshes if there are any.
fn meshes() -> Vec<Base> {
    let mut meshes = generated();
    match std::env::var_os("SHATTER_MESHES") {
        Some(folder) => meshes.extend(from_folder(Path::new(&folder)).unwrap()),
        None => println!("skipped: SHATTER_MESHES is not set (mutants of real meshes)"),
    }
    meshes
}

/// A number from the environment, for longer runs than the usual one.
fn number(key: &str) -> Option<usize> {
    std::env::var(key).ok().map(|value| value.parse().unwrap())
}

fn tally() -> Tally {
    let meshes = meshes();
    let count = number("SHATTER_MUTANTS").unwrap_or(20 * ROUNDS * meshes.len());
    let seed = number("SHATTER_MUTANTS_SEED").unwrap_or(1) as u64;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let judge = Judge::new(DEADLINE).unwrap();
    let plan = Plan { count, seed, meshes, judge, repeat_every: 13, threads };
    let begun = Instant::now();
    let tally = run(&plan, &mut |mutant, verdict| {
        if let Verdict::Failed(fault) = verdict {
            println!("failed: {mutant}: {fault}");
        }
    });
    println!("{count} mutants in {:.1} s", begun.elapsed().as_secs_f64());
    tally.unwrap()
}

#[test]
fn a_thousand_mutants_are_answered_or_refused_and_good_ones_are_answered() {
    let tally = tally();
    println!("{tally}");
    assert_eq!(tally.all.failed, 0);
    assert!(tally.all.tried >= 1000 || number("SHATTER_MUTANTS").is_some());
    assert!(tally.must_accept_rate >= MUST_ACCEPT_RATE_MIN, "{}", tally.must_accept_rate);
    for row in tally.per_defect.iter().filter(|row| row.must_accept.tried > 0) {
        assert!(row.must_accept.accept_rate() >= MUST_ACCEPT_RATE_MIN, "{row:?}");
    }
}

#[test]
fn what_was_mended_stays_mended() {
    let (meshes, judge) = (meshes(), Judge::new(DEADLINE).unwrap());
    for id in REGRESSIONS {
        let mutant: Mutant = id.parse().unwrap();
        let Some(base) = meshes.iter().find(|base| base.name == mutant.mesh) else {
            println!("skipped: {id}: no such mesh");
            continue;
        };
        match judge.mutant(&base.mesh, &mutant) {
            Verdict::Failed(fault) => panic!("{id}: {fault}"),
            Verdict::Refused { message, justified: false, .. } => panic!("{id}: refused: {message}"),
            Verdict::Checked { .. } | Verdict::Refused { .. } => {}
        }
    }
}
