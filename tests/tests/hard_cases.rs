//! The catalog of hard cases: every figure within its bound.

use crate::exact_surface::REPAIRED;
use rayon::prelude::*;
use shatter_lab::study::stability::{CASES, CaseOutcome, REAL, judge, real};
use shatter_tests::real::mesh;

#[test]
fn every_hard_case_holds() {
    let judged = CASES.par_iter().map(|case| {
        let begun = std::time::Instant::now();
        let row = judge(case);
        let figure = row.figure.map_or("-".to_owned(), |figure| format!("{figure:.3e}"));
        println!("{:36} {figure:>10}  {:20} {:?}, {:.1?}", row.name, row.expected, row.outcome, begun.elapsed());
        row
    });
    let failed: Vec<_> = judged.filter(|row| row.outcome == CaseOutcome::Failed).collect();
    assert!(failed.is_empty(), "{failed:#?}");
}

/// Those that `exact_surface` does not bake at the same spacings.
#[test]
fn real_meshes_bake_and_break() {
    check_real(|file| !REPAIRED.iter().any(|(own, _)| own == file));
}

#[test]
#[ignore = "takes minutes"]
fn all_real_meshes_bake_and_break() {
    check_real(|_| true);
}

fn check_real(is_baked: impl Fn(&&str) -> bool) {
    let mut failed = Vec::new();
    for file in REAL.iter().filter(|file| is_baked(file)) {
        let Some(path) = mesh(file) else { continue };
        let Some(folder) = path.parent() else { continue };
        let (row, _) = real(folder, file, false);
        println!("{file}: {:?} {:?} {:?}", row.outcome, row.figure, row.message);
        if row.outcome == CaseOutcome::Failed {
            failed.push(row);
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}
