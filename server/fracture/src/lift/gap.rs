//! Cut of a spectrum at a gap, so that no multiplet is split.

/// Largest distance of the cut from the requested number of modes: 4 to 16 functions for the default of 10.
///
/// That suffices for the multiplets of a cube (6) and a sphere (9). It also suffices to keep limbs of the same kind
/// together, whose eigenvalues lie close to each other (15 for a brush of 16 prongs).
pub(super) const WINDOW: usize = 6;

/// Number of eigenpairs that [`cut`] needs to choose `modes`, at most `available`.
pub(super) fn needed(modes: usize, available: usize) -> usize {
    (modes + WINDOW + 1).min(available)
}

/// Number of the ascending, positive `eigenvalues` to keep.
///
/// It is the cut within [`WINDOW`] of `modes` across which the eigenvalues grow by the largest factor. Of equal factors
/// the one nearest to `modes` wins, then the lower. `whole` states that the spectrum ends with the last eigenvalue; if
/// the window reaches it, all are kept, because no cut is cleaner.
///
/// |X(x) − X(y)| depends on the lattice alone if whole eigenspaces are kept, because the basis within one is arbitrary.
pub(super) fn cut(eigenvalues: &[f64], modes: usize, whole: bool) -> usize {
    let count = eigenvalues.len();
    if whole && modes + WINDOW >= count {
        return count;
    }
    let mut candidates: Vec<usize> = (modes.saturating_sub(WINDOW).max(1)..=modes + WINDOW).collect();
    candidates.retain(|&kept| kept < count);
    candidates.sort_by_key(|&kept| (kept.abs_diff(modes), kept));
    let growth = |kept: usize| eigenvalues[kept] / eigenvalues[kept - 1];
    let better = |best: usize, kept: usize| if growth(kept) > growth(best) { kept } else { best };
    candidates.into_iter().reduce(better).unwrap_or(count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[track_caller]
    fn check(eigenvalues: &[f64], modes: usize, whole: bool, expected: usize) {
        assert_eq!(cut(eigenvalues, modes, whole), expected);
    }

    #[test]
    fn the_cut_keeps_the_multiplets_of_a_cube_whole() {
        let cube = [1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 3.0, 4.0, 4.0, 4.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 6.0];
        check(&cube, 3, false, 3);
        check(&cube, 1, false, 3);
        check(&cube, 9, false, 3);
        check(&cube, 10, false, 6);
        check(&cube, 13, false, 7);
        check(&cube[..12], 14, false, 10);
    }

    #[test]
    fn the_cut_keeps_all_of_a_spectrum_that_ends() {
        check(&[1.0, 2.0, 3.0], 16, true, 3);
        check(&[1.0, 2.0, 3.0], 3, true, 3);
        check(&[1.0], 1, false, 1);
        check(&[], 4, true, 0);
    }

    #[test]
    fn equal_gaps_are_cut_nearest_to_the_number_asked_for() {
        let geometric: Vec<f64> = (0..20).map(|power| f64::from(1 << power)).collect();
        check(&geometric, 8, false, 8);
        check(&geometric, 10, false, 10);
    }

    proptest! {
        #[test]
        fn multiplets_that_fit_the_window_are_never_torn(
            multiplets in prop::collection::vec((1usize..=2 * WINDOW + 1, 1.05f64..3.0), 1..20),
            modes in 1usize..40,
        ) {
            let mut eigenvalues = Vec::new();
            let (mut value, mut ends) = (1.0, vec![]);
            for (size, growth) in multiplets {
                // Rounding within an eigenspace.
                eigenvalues.extend((0..size).map(|k| value * (1.0 + 1e-12 * k as f64)));
                ends.push(eigenvalues.len());
                value *= growth;
            }
            let kept = cut(&eigenvalues, modes, true);
            prop_assert!(ends.contains(&kept) || modes <= WINDOW, "{kept} is not in {ends:?}");
            prop_assert!(kept <= modes + WINDOW);
        }
    }
}
