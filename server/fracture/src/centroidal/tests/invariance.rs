//! Invariances of diagrams.

use super::*;

#[test]
fn threads_do_not_change_a_bit() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Case::generic(16).diagram(DiagramOptions::new(60, 11)))
    };
    let one = run(1);
    assert!(one == run(2));
    assert!(one == run(4));
}

#[test]
fn wide_instructions_do_not_change_a_bit() {
    for m in [3, 5, 16, 19] {
        let mut case = Case::generic(m);
        let field = EnergyField::new(&case.lift, &case.volumes, &mut case.mass).unwrap();
        let run = |path: KernelPath| {
            let mut workspace =
                DiagramWorkspace { scratch: AssignScratch::with_path(path), ..DiagramWorkspace::default() };
            diagram(&field, &DiagramOptions::new(33, 2), &mut workspace, &CancelToken::default()).unwrap()
        };
        let plain = run(KernelPath::baseline());
        assert!(KernelPath::all().into_iter().all(|path| run(path) == plain));
    }
}

#[test]
fn powers_of_two_scale_through_to_the_last_bit() {
    let original = Case::generic(7).diagram(DiagramOptions::new(25, 4));
    for (energy, length) in [(20, 0), (-31, 0), (0, 5), (3, -7)] {
        let (energy, length) = (f64::powi(2.0, energy), f64::powi(2.0, length));
        let mut case = Case::generic(7);
        case.mass.iter_mut().for_each(|mass| *mass *= energy);
        case.volumes.iter_mut().for_each(|volume| *volume *= length.powi(3));
        case.lift.coordinates.iter_mut().for_each(|x| *x *= length);
        case.lift.first_moment.iter_mut().for_each(|b| *b *= length);
        case.lift.second_moment.iter_mut().for_each(|moment| *moment *= length * length);
        let scaled = case.diagram(DiagramOptions::new(25, 4));
        assert!(original.labels == scaled.labels);
        assert!(original.sites.iter().zip(&scaled.sites).all(|(a, b)| a * length == *b));
        assert_eq!(original.energy * energy * length * length, scaled.energy);
    }
}

#[test]
fn translation_and_rotation_in_the_lift_keep_the_labels() {
    for m in [3, 8, 19] {
        let original = Case::generic(m).diagram(DiagramOptions::new(50, 21));
        let mut case = Case::generic(m);
        case.lift.coordinates.chunks_exact_mut(m).for_each(|place| turn_and_shift(place, 1.0));
        case.lift.first_moment.chunks_exact_mut(m).for_each(|offset| turn_and_shift(offset, 0.0));
        let moved = case.diagram(DiagramOptions::new(50, 21));
        let differ = original.labels.iter().zip(&moved.labels).filter(|(a, b)| a != b).count();
        assert_eq!(differ, 0, "of {} labels, m = {m}", moved.labels.len());
        assert!((original.energy - moved.energy).abs() <= 1e-12 * original.energy);
        assert!((original.energy_max() - moved.energy_max()).abs() <= 1e-11 * original.energy_max());
    }
}

/// Rotates neighboring axes one after the other, then shifts each axis by its own multiple of `shift`.
fn turn_and_shift(place: &mut [f64], shift: f64) {
    for axis in 0..place.len() {
        let other = (axis + 1) % place.len();
        let (sin, cos) = (0.4 + axis as f64).sin_cos();
        let (a, b) = (place[axis], place[other]);
        (place[axis], place[other]) = (cos * a - sin * b, sin * a + cos * b);
    }
    place.iter_mut().enumerate().for_each(|(axis, x)| *x += shift * (0.37 * axis as f64 - 1.0));
}

#[test]
fn seeds_and_starts_differ_and_repeat() {
    let run = |seed, start| Case::generic(4).diagram(DiagramOptions { start, ..DiagramOptions::new(20, seed) });
    assert!(run(1, 0) == run(1, 0));
    assert!(run(1, 0).labels != run(2, 0).labels);
    assert!(run(1, 0).labels != run(1, 1).labels);
}

#[test]
fn labels_of_given_sites_are_those_of_the_diagram() {
    let mut case = Case::generic(9);
    let result = case.diagram(DiagramOptions::new(14, 8));
    let field = EnergyField::new(&case.lift, &case.volumes, &mut case.mass).unwrap();
    let again = assign(&field, &result.sites, &mut DiagramWorkspace::default());
    assert!(again.labels == result.labels);
    assert_eq!(again.cell_energy, result.cell_energy);
}
