//! Judging of many mutants in parallel.

use super::check::FuzzFault;
use super::{BaseMesh, FuzzDefect, FuzzTally, FuzzVerdict, Judge, Mutant};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};

/// Number of threads on which mutants are judged again.
const OTHER_THREADS: usize = 3;

/// Plan of a run.
///
/// Mutants come in a fixed order: one defect after the other, each on the next mesh; after every pair of mesh and defect, again with the
/// next seed.
#[derive(Clone, Debug)]
pub struct FuzzPlan {
    /// Number of mutants.
    pub count: usize,
    /// First seed.
    pub seed: u64,
    /// Base meshes with distinct names.
    pub meshes: Vec<BaseMesh>,
    /// Judge of the mutants.
    pub judge: Judge,
    /// One mutant of this many is judged again on several threads, and the results compared; 0: none.
    pub repeat_every: usize,
    /// Number of mutants judged at once, at least one.
    pub threads: usize,
}

impl FuzzPlan {
    /// Mutant number `index` and its base mesh; `None` without meshes.
    pub fn mutant(&self, index: usize) -> Option<(&BaseMesh, Mutant)> {
        let round = self.meshes.len() * FuzzDefect::ALL.len();
        let (turn, defect) = (index / FuzzDefect::ALL.len(), index % FuzzDefect::ALL.len());
        let base = self.meshes.get((turn + defect).checked_rem(self.meshes.len())?)?;
        let defect = FuzzDefect::ALL[defect];
        Some((base, Mutant { mesh: base.name.clone(), defect, seed: self.seed + (index / round) as u64 }))
    }

    /// Judges mutant number `index`, a second time on other threads if it is its turn.
    fn judge(&self, index: usize) -> Option<FuzzVerdict> {
        let (base, mutant) = self.mutant(index)?;
        let verdict = self.judge.mutant(&base.mesh, &mutant);
        if self.repeat_every == 0 || !index.is_multiple_of(self.repeat_every) {
            return Some(verdict);
        }
        let again = Judge { threads: OTHER_THREADS, ..self.judge.clone() }.mutant(&base.mesh, &mutant);
        if again == verdict {
            Some(verdict)
        } else {
            Some(FuzzVerdict::Failed(FuzzFault::Differs(format!("{again:?}"))))
        }
    }
}

/// Judges every mutant of the plan. Calls `progress` for each as it ends, in any order; the tally depends on the plan only.
pub fn run(plan: &FuzzPlan, progress: &mut dyn FnMut(&Mutant, &FuzzVerdict)) -> FuzzTally {
    let next = AtomicUsize::new(0);
    let mut verdicts: Vec<Option<FuzzVerdict>> = vec![None; plan.count];
    std::thread::scope(|scope| {
        let (sender, receiver) = channel();
        for _ in 0..plan.threads.max(1) {
            let (sender, next) = (sender.clone(), &next);
            scope.spawn(move || work(plan, next, &sender));
        }
        drop(sender);
        for (index, verdict) in receiver {
            if let Some((_, mutant)) = plan.mutant(index) {
                progress(&mutant, &verdict);
            }
            verdicts[index] = Some(verdict);
        }
    });
    let mut tally = FuzzTally::new(plan.meshes.iter().map(|base| base.name.as_str()));
    for (index, verdict) in verdicts.iter().enumerate() {
        if let (Some((_, mutant)), Some(verdict)) = (plan.mutant(index), verdict) {
            tally.add(mutant, verdict);
        }
    }
    tally
}

/// Judges mutants until none is left.
fn work(plan: &FuzzPlan, next: &AtomicUsize, sender: &Sender<(usize, FuzzVerdict)>) {
    let mut indices = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed)).take_while(|&i| i < plan.count);
    // There is no receiver only if the caller's thread has ended.
    while let Some((index, verdict)) = indices.next().and_then(|index| Some((index, plan.judge(index)?))) {
        if sender.send((index, verdict)).is_err() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{MeshSize, generated};
    use super::*;
    use std::collections::BTreeSet;
    use std::time::Duration;

    fn plan(count: usize, threads: usize) -> FuzzPlan {
        let judge = Judge::new(MeshSize::Small, Duration::from_secs(60)).unwrap();
        let meshes = generated(MeshSize::Small).into_iter().take(2).collect();
        FuzzPlan { count, seed: 5, meshes, judge, repeat_every: 8, threads }
    }

    #[test]
    fn mutants_come_in_a_fixed_order() {
        let plan = plan(100, 1);
        let name = |index: usize| plan.mutant(index).unwrap().1.to_string();
        assert_eq!([name(0), name(1), name(20)], ["sphere/nan/5", "cuboid/infinity/5", "cuboid/nan/5"]);
        assert_eq!([name(39), name(40)], ["sphere/mixed_winding/5", "sphere/nan/6"]);
        assert_eq!((0..40).map(name).collect::<BTreeSet<_>>().len(), 40);
        assert!(FuzzPlan { meshes: Vec::new(), ..plan }.mutant(0).is_none());
    }

    #[test]
    fn the_tally_does_not_depend_on_threads() {
        let mut reported = 0;
        let one = run(&plan(20, 1), &mut |_, _| reported += 1);
        assert_eq!((reported, one.all.tried), (20, 20), "one of each defect");
        assert_eq!(one, run(&plan(20, 3), &mut |_, _| ()));
    }
}
