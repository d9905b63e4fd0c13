//! Order of points along a Hilbert curve, in which neighbors in the order are near each other in space.
//!
//! Based on: J. Skilling, *Programming the Hilbert curve* (2004).

use nalgebra::Point3;

/// Bits per axis of the position on the curve.
const BITS: u32 = 20;

/// Indices of `points` in the order of the curve through their bounding box.
pub(crate) fn hilbert_order(points: &[Point3<f64>]) -> Vec<u32> {
    let mut keys: Vec<(u64, u32)> = hilbert_indices(points).into_iter().zip(0..).collect();
    keys.sort_unstable();
    keys.into_iter().map(|(_, index)| index).collect()
}

/// Position of each point on the curve through their bounding box.
pub(super) fn hilbert_indices(points: &[Point3<f64>]) -> Vec<u64> {
    let Some(first) = points.first() else { return Vec::new() };
    let (low, high) = points.iter().fold((*first, *first), |(low, high), point| (low.inf(point), high.sup(point)));
    let extent = (high - low).max();
    let scale = if extent > 0.0 { f64::from((1_u32 << BITS) - 1) / extent } else { 0.0 };
    points.iter().map(|point| hilbert_index((point - low).map(|x| (x * scale) as u32).into())).collect()
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
}
