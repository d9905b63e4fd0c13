//! Numbers out of a range, found by parts side by side.

use super::span::each_span;
use rayon::prelude::*;

/// Numbers that one task looks through.
pub(super) const PART: usize = 8192;

/// The numbers below a count that are wanted, ascending; what it holds besides is scratch memory.
#[derive(Clone, Debug, Default)]
pub(super) struct IndexSet {
    /// Each part's own, at its beginning.
    room: Vec<u32>,
    /// How many of each part.
    counts: Vec<usize>,
    /// Sums of those.
    firsts: Vec<usize>,
}

impl IndexSet {
    /// Fills `all` with what is `wanted` of 0 .. `count`.
    pub fn choose(&mut self, count: usize, all: &mut Vec<u32>, wanted: impl Fn(usize) -> bool + Sync) {
        self.room.resize(count, 0);
        let choose = |(part, own): (usize, &mut [u32])| {
            let (first, mut next) = (part * PART, 0);
            for offset in 0..own.len() {
                // Always written, kept if it counts: a branch would be a guess.
                own[next] = (first + offset) as u32;
                next += usize::from(wanted(first + offset));
            }
            next
        };
        self.room.par_chunks_mut(PART).enumerate().map(choose).collect_into_vec(&mut self.counts);
        self.firsts.clear();
        self.firsts.push(0);
        self.firsts.extend(self.counts.iter().scan(0, |sum, count| {
            *sum += count;
            Some(*sum)
        }));
        all.resize(self.firsts[self.firsts.len() - 1], 0);
        let room = &self.room;
        each_span(&self.firsts, all, &|part, own| own.copy_from_slice(&room[part * PART..][..own.len()]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_wanted_is_chosen_in_order() {
        let (mut chosen, mut all) = (IndexSet::default(), Vec::new());
        for (count, step) in [(3 * PART + 17, 3), (PART, 1), (0, 1), (5, 7), (2 * PART, usize::MAX)] {
            chosen.choose(count, &mut all, |number| number % step == step / 2);
            let expected: Vec<u32> =
                (0..count).filter(|number| number % step == step / 2).map(|number| number as u32).collect();
            assert_eq!(all, expected, "{count} by {step}");
        }
    }
}
