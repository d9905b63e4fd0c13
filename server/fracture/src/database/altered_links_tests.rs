//! Databases in which entries of one table refer to other entries of another, with matching checksums: a block with a skin and attributes.

use super::altered_tests::{File, Trial, load_altered};
use crate::pipeline::ElementChoice;

/// Places of a tensor that are tried.
const PLACES: usize = 24;

/// Loads the file with `alter` applied to each of some entries of `tensor`, by index; returns how many were tried and the wrong results:
/// places that were served, or refused without the names `named`.
fn tried(file: &File, tensor: &str, named: &[&str], alter: impl Fn(&mut [u32], usize)) -> (usize, Vec<String>) {
    let count = file.bytes(tensor).len() / 4;
    let (mut all, mut wrong) = (0, Vec::new());
    for place in (1..count).step_by(count.div_ceil(PLACES)) {
        let mut is_changed = false;
        let loaded = load_altered(file, tensor, |bytes| {
            let words = bytes.as_chunks_mut::<4>().0;
            let before: Vec<u32> = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
            let mut after = before.clone();
            alter(&mut after, place);
            is_changed = after != before;
            words.iter_mut().zip(after).for_each(|(word, value)| *word = value.to_le_bytes());
        });
        if is_changed {
            all += 1;
            if !loaded.as_ref().is_err_and(|error| named.iter().any(|name| error.contains(name))) {
                wrong.push(format!("{tensor}[{place}]: {loaded:?}"));
            }
        }
    }
    println!("{tensor}: {} of {all} refused", all - wrong.len());
    (all, wrong)
}

#[test]
fn entries_that_refer_to_others_are_refused() {
    let file = Trial::of(ElementChoice::default()).file;
    assert_eq!(load_altered(&file, "skin.spots", |_| ()), Ok(()));
    // A share that moves to the node before may keep the order of its row; a tetrahedron beside a carrier may carry its corner, too.
    let mostly = |(all, wrong): (usize, Vec<String>)| assert!(all > 10 && 5 * wrong.len() <= all, "{wrong:#?}");
    let always = |(all, wrong): (usize, Vec<String>)| assert!(all > 10 && wrong.is_empty(), "{wrong:#?}");
    let transfer = ["body0.transfer", "body0.elastic"];
    mostly(tried(&file, "body0.transfer.offsets", &transfer, |own, at| own[at] += 1));
    mostly(tried(&file, "body0.transfer.offsets", &transfer, |own, at| own[at] = own[(at + 1).min(own.len() - 1)]));
    let carriers = ["body0.cutting.carriers", "anchored nodes"];
    let half = file.bytes("body0.crack.tets").len() as u32 / 32;
    mostly(tried(&file, "body0.cutting.carriers", &carriers, |own, at| own[at] = (own[at] + half) % (2 * half)));
    let corners = ["body0.cutting.outer.corners"];
    always(tried(&file, corners[0], &corners, |own, at| own[at] = 0));
    always(tried(&file, corners[0], &corners, |own, at| own.swap(at, at / 2)));
    let skin = ["skin."];
    mostly(tried(&file, "skin.triangles", &skin, |own, at| own[at] = 0));
    mostly(tried(&file, "skin.vertices", &skin, |own, at| own[at] = 0));
    mostly(tried(&file, "skin.spots", &skin, |own, at| own[at | 1] = 0));
}

#[test]
fn moved_skin_points_and_a_bound_beyond_the_stiffness_are_refused() {
    let altered = |file: &File, tensor: &str, place: usize, by: fn(f64) -> f64| {
        let loaded = load_altered(file, tensor, |bytes| {
            let own = &mut bytes.as_chunks_mut::<8>().0[place];
            *own = by(f64::from_le_bytes(*own)).to_le_bytes();
        });
        assert!(loaded.as_ref().is_err_and(|error| error.contains(tensor)), "{tensor}[{place}]: {loaded:?}");
    };
    let quadratic = Trial::of(ElementChoice::Quadratic).file;
    let moved = |x| if x > 0.0 { x - 0.3 } else { x + 0.3 };
    (0..300).step_by(11).for_each(|place| altered(&quadratic, "skin.points", place, moved));
    altered(&Trial::of(ElementChoice::Linear).file, "body0.elastic.bound", 0, |floor| 10.0 * floor);
    // The bound of quadratic elements is 3 to 5 times lower than needed.
    altered(&quadratic, "body0.elastic.bound", 0, |floor| 100.0 * floor);
}
