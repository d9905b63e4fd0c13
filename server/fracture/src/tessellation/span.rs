//! Parallel access to disjoint sub-slices, without allocation.

/// Total length below which one thread processes all spans.
const GRAIN: usize = 4096;

/// Calls `work(k, slice[offsets[k] .. offsets[k + 1]])` for every k, in parallel. `offsets` ascend from 0 to the length
/// of `slice`.
pub(super) fn each_span<T: Send>(offsets: &[usize], slice: &mut [T], work: &(impl Fn(usize, &mut [T]) + Sync)) {
    descend(0, offsets, slice, work);
}

fn descend<T: Send>(first: usize, offsets: &[usize], slice: &mut [T], work: &(impl Fn(usize, &mut [T]) + Sync)) {
    let spans = offsets.len().saturating_sub(1);
    if spans > 1 && slice.len() > GRAIN {
        let middle = middle(offsets);
        let (left, right) = slice.split_at_mut(offsets[middle] - offsets[0]);
        rayon::join(
            || descend(first, &offsets[..=middle], left, work),
            || descend(first + middle, &offsets[middle..], right, work),
        );
        return;
    }
    let mut rest = slice;
    for span in 0..spans {
        let (own, others) = rest.split_at_mut(offsets[span + 1] - offsets[span]);
        work(first + span, own);
        rest = others;
    }
}

/// The span boundary, neither first nor last, next to the middle of the spans' total length.
fn middle(offsets: &[usize]) -> usize {
    let last = offsets.len() - 1;
    let half = (offsets[0] + offsets[last]) / 2;
    offsets.partition_point(|&offset| offset < half).clamp(1, last - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_element_is_given_once_with_its_span() {
        let lengths = [0, 5000, 1, 0, 3, 9000, 2, 0];
        let mut offsets = vec![0];
        lengths.iter().for_each(|length| offsets.push(offsets[offsets.len() - 1] + length));
        let mut slice = vec![usize::MAX; offsets[lengths.len()]];
        each_span(&offsets, &mut slice, &|span, own| own.iter_mut().for_each(|x| *x = span));
        let expected: Vec<usize> = lengths.iter().enumerate().flat_map(|(k, &n)| std::iter::repeat_n(k, n)).collect();
        assert_eq!(slice, expected);
        each_span(&[0], &mut [0u8; 0], &|_, _| unreachable!("no spans"));
    }
}
