//! Order in which points are inserted: rounds of doubling size, each along a Hilbert curve.
//!
//! Based on: N. Amenta, S. Choi, G. Rote, *Incremental constructions con BRIO* (2003); J. Skilling, *Programming the
//! Hilbert curve* (2004).

use nalgebra::Point3;

/// Bits per axis of the position on the curve.
const BITS: u32 = 20;
/// Largest number of rounds.
const ROUNDS_MAX: u32 = 12;

/// Indices of `points` in the order of insertion. It depends on the points alone.
pub(super) fn insertion_order(points: &[Point3<f64>]) -> Vec<u32> {
    let Some(first) = points.first() else { return Vec::new() };
    let (low, high) = points.iter().fold((*first, *first), |(low, high), point| (low.inf(point), high.sup(point)));
    let extent = (high - low).max();
    let scale = if extent > 0.0 { f64::from((1_u32 << BITS) - 1) / extent } else { 0.0 };
    let mut keys: Vec<(u32, u64, u32)> = (0_u32..)
        .zip(points)
        .map(|(index, point)| {
            let cell = (point - low).map(|x| (x * scale) as u32);
            (ROUNDS_MAX - hash(index).trailing_zeros().min(ROUNDS_MAX), hilbert_index(cell.into()), index)
        })
        .collect();
    keys.sort_unstable();
    keys.into_iter().map(|(.., index)| index).collect()
}

/// Mixes the bits of an index, so that half of all indices end in 0, a quarter in 00, and so on.
fn hash(index: u32) -> u32 {
    let mixed = (u64::from(index) + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    ((mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 32) as u32
}

/// Position of a grid cell on the Hilbert curve through a grid of 2^20 cells per axis.
fn hilbert_index(mut cell: [u32; 3]) -> u64 {
    let mut bit = 1 << (BITS - 1);
    while bit > 1 {
        let below = bit - 1;
        for axis in 0..3 {
            if cell[axis] & bit != 0 {
                cell[0] ^= below;
            } else {
                let swapped = (cell[0] ^ cell[axis]) & below;
                cell[0] ^= swapped;
                cell[axis] ^= swapped;
            }
        }
        bit >>= 1;
    }
    cell[1] ^= cell[0];
    cell[2] ^= cell[1];
    let mut turned = 0;
    let mut bit = 1 << (BITS - 1);
    while bit > 1 {
        if cell[2] & bit != 0 {
            turned ^= bit - 1;
        }
        bit >>= 1;
    }
    let cell = cell.map(|coordinate| coordinate ^ turned);
    (0..BITS).rev().fold(0, |index, bit| {
        cell.iter().fold(index, |index, coordinate| (index << 1) | u64::from((coordinate >> bit) & 1))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbors_on_the_curve_are_neighbors_in_the_grid() {
        let mut cells: Vec<[u32; 3]> = (0..512).map(|k| [k % 8, k / 8 % 8, k / 64]).collect();
        cells.sort_by_key(|&cell| hilbert_index(cell));
        for pair in cells.windows(2) {
            let distance: u32 = (0..3).map(|axis| pair[0][axis].abs_diff(pair[1][axis])).sum();
            assert_eq!(distance, 1, "{pair:?}");
        }
    }

    #[test]
    fn each_point_occurs_once() {
        let points: Vec<Point3<f64>> = (0..100).map(|k| Point3::new(f64::from(k % 7), f64::from(k % 5), 0.5)).collect();
        let mut order = insertion_order(&points);
        order.sort_unstable();
        assert_eq!(order, (0..100).collect::<Vec<u32>>());
    }
}
