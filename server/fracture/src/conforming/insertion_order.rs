//! Order in which points are inserted: rounds of doubling size, each along a Hilbert curve.
//!
//! Based on: N. Amenta, S. Choi, G. Rote, *Incremental constructions con BRIO* (2003).

use super::hilbert::hilbert_indices;
use nalgebra::Point3;

/// Largest number of rounds.
const ROUNDS_MAX: u32 = 12;

/// Indices of `points` in the order of insertion. It depends on the points alone.
pub(super) fn insertion_order(points: &[Point3<f64>]) -> Vec<u32> {
    let round = |index: u32| ROUNDS_MAX - hash(index).trailing_zeros().min(ROUNDS_MAX);
    let mut keys: Vec<(u32, u64, u32)> =
        (0..).zip(hilbert_indices(points)).map(|(index, on_curve)| (round(index), on_curve, index)).collect();
    keys.sort_unstable();
    keys.into_iter().map(|(.., index)| index).collect()
}

/// Mixes the bits of an index, so that half of all indices end in 0, a quarter in 00, and so on.
fn hash(index: u32) -> u32 {
    let mixed = (u64::from(index) + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    ((mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_point_occurs_once() {
        let points: Vec<Point3<f64>> = (0..100).map(|k| Point3::new(f64::from(k % 7), f64::from(k % 5), 0.5)).collect();
        let mut order = insertion_order(&points);
        order.sort_unstable();
        assert_eq!(order, (0..100).collect::<Vec<u32>>());
    }
}
