//! Selection of indices from a range, in parallel.

use super::span::each_span;
use rayon::prelude::*;

/// Number of indices per task.
pub(super) const PART: usize = 8192;

/// Selects the wanted indices below a count, in ascending order. All fields are scratch memory.
#[derive(Clone, Debug, Default)]
pub(super) struct IndexSet {
    /// Selected indices of each part, at its beginning.
    marks_memory: Vec<u32>,
    /// Number of selected indices of each part.
    counts: Vec<usize>,
    /// Prefix sums of the counts.
    firsts: Vec<usize>,
}

impl IndexSet {
    /// Fills `all` with the indices in 0 .. `count` that are `wanted`.
    pub fn choose(&mut self, count: usize, all: &mut Vec<u32>, wanted: impl Fn(usize) -> bool + Sync) {
        self.marks_memory.resize(count, 0);
        let choose = |(part, own): (usize, &mut [u32])| {
            let (first, mut next) = (part * PART, 0);
            for offset in 0..own.len() {
                // Written always and kept if selected, because a branch here is hard to predict.
                own[next] = (first + offset) as u32;
                next += usize::from(wanted(first + offset));
            }
            next
        };
        self.marks_memory.par_chunks_mut(PART).enumerate().map(choose).collect_into_vec(&mut self.counts);
        self.firsts.clear();
        self.firsts.push(0);
        self.firsts.extend(self.counts.iter().scan(0, |sum, count| {
            *sum += count;
            Some(*sum)
        }));
        all.resize(self.firsts[self.firsts.len() - 1], 0);
        let marks_memory = &self.marks_memory;
        each_span(&self.firsts, all, &|part, own| own.copy_from_slice(&marks_memory[part * PART..][..own.len()]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wanted_indices_are_selected_in_order() {
        let (mut chosen, mut all) = (IndexSet::default(), Vec::new());
        for (count, step) in [(3 * PART + 17, 3), (PART, 1), (0, 1), (5, 7), (2 * PART, usize::MAX)] {
            chosen.choose(count, &mut all, |number| number % step == step / 2);
            let expected: Vec<u32> =
                (0..count).filter(|number| number % step == step / 2).map(|number| number as u32).collect();
            assert_eq!(all, expected, "{count} by {step}");
        }
    }
}
