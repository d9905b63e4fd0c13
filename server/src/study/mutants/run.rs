//! Many mutants.
//!
//! Every mutant runs on one thread, and as many mutants at once as there are threads. Each thread has a pool of its own:
//! in a shared one a thread that waits within one mutant would take up another, and neither time nor a panic would belong
//! to one of them.

use super::check::Fault;
use super::{Base, Defect, Judge, Mutant, Tally, Verdict};
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};

/// Threads of the pool in which mutants are judged again.
const OTHER_THREADS: usize = 3;

/// What to try. Mutants come in a fixed order: all meshes under the first defect, all under the second, and so on to the
/// last, then again with the next seed.
#[derive(Clone, Debug)]
pub struct Plan {
    /// How many.
    pub count: usize,
    /// The first seed.
    pub seed: u64,
    /// What is spoiled; names differ.
    pub meshes: Vec<Base>,
    /// How each is judged.
    pub judge: Judge,
    /// One mutant of this many is judged again on several threads, and the results compared; 0: none is.
    pub repeat_every: usize,
    /// Mutants at once, at least one.
    pub threads: usize,
}

impl Plan {
    /// Mutant number `index` and its base mesh; nothing without meshes.
    pub fn mutant(&self, index: usize) -> Option<(&Base, Mutant)> {
        let round = self.meshes.len() * Defect::ALL.len();
        let base = self.meshes.get(index.checked_rem(self.meshes.len())?)?;
        let defect = Defect::ALL[index / self.meshes.len() % Defect::ALL.len()];
        Some((base, Mutant { mesh: base.name.clone(), defect, seed: self.seed + (index / round) as u64 }))
    }

    /// Judges mutant number `index`, again in the pool `other` if it is its turn.
    fn judge(&self, index: usize, other: &ThreadPool) -> Option<Verdict> {
        let (base, mutant) = self.mutant(index)?;
        let verdict = self.judge.mutant(&base.mesh, &mutant);
        if self.repeat_every == 0 || !index.is_multiple_of(self.repeat_every) {
            return Some(verdict);
        }
        let again = other.install(|| self.judge.mutant(&base.mesh, &mutant));
        if again == verdict { Some(verdict) } else { Some(Verdict::Failed(Fault::Differs(format!("{again:?}")))) }
    }
}

/// Judges every mutant of the plan. `progress` is told of each as it ends, in any order; the tally follows from the plan
/// alone. Errors: threads could not be started.
pub fn run(plan: &Plan, progress: &mut dyn FnMut(&Mutant, &Verdict)) -> Result<Tally, ThreadPoolBuildError> {
    let pool = |threads: usize| ThreadPoolBuilder::new().num_threads(threads).build();
    let other = pool(OTHER_THREADS)?;
    let own = (0..plan.threads.max(1)).map(|_| pool(1)).collect::<Result<Vec<_>, _>>()?;
    let next = AtomicUsize::new(0);
    let mut verdicts: Vec<Option<Verdict>> = vec![None; plan.count];
    std::thread::scope(|scope| {
        let (sender, receiver) = channel();
        for pool in &own {
            let (sender, next, other) = (sender.clone(), &next, &other);
            scope.spawn(move || pool.install(|| work(plan, next, other, &sender)));
        }
        drop(sender);
        for (index, verdict) in receiver {
            if let Some((_, mutant)) = plan.mutant(index) {
                progress(&mutant, &verdict);
            }
            verdicts[index] = Some(verdict);
        }
    });
    let mut tally = Tally::new(plan.meshes.iter().map(|base| base.name.as_str()));
    for (index, verdict) in verdicts.iter().enumerate() {
        if let (Some((_, mutant)), Some(verdict)) = (plan.mutant(index), verdict) {
            tally.add(mutant, verdict);
        }
    }
    Ok(tally)
}

/// Takes mutants until none is left.
fn work(plan: &Plan, next: &AtomicUsize, other: &ThreadPool, sender: &Sender<(usize, Verdict)>) {
    let mut indices = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed)).take_while(|&i| i < plan.count);
    // Nobody listens any more only if the caller's thread is gone.
    while let Some((index, verdict)) = indices.next().and_then(|index| Some((index, plan.judge(index, other)?))) {
        if sender.send((index, verdict)).is_err() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::generated;
    use super::*;
    use std::time::Duration;

    fn plan(count: usize, threads: usize) -> Plan {
        let judge = Judge::new(Duration::from_secs(60)).unwrap();
        let meshes = generated().into_iter().take(2).collect();
        Plan { count, seed: 5, meshes, judge, repeat_every: 8, threads }
    }

    #[test]
    fn mutants_come_in_a_fixed_order() {
        let plan = plan(100, 1);
        let name = |index: usize| plan.mutant(index).unwrap().1.to_string();
        assert_eq!([name(0), name(1), name(2)], ["sphere/nan/5", "cuboid/nan/5", "sphere/infinity/5"]);
        assert_eq!([name(39), name(40)], ["cuboid/mixed_winding/5", "sphere/nan/6"]);
        assert!(Plan { meshes: Vec::new(), ..plan }.mutant(0).is_none());
    }

    #[test]
    fn the_tally_does_not_depend_on_threads() {
        let mut told = 0;
        let one = run(&plan(26, 1), &mut |_, _| told += 1).unwrap();
        assert_eq!((told, one.all.tried), (26, 26));
        assert_eq!(one, run(&plan(26, 3), &mut |_, _| ()).unwrap());
    }
}
