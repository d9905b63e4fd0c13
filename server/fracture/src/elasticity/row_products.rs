//! Rows of bases, and their products with coordinates.

use super::workspace::SIDE;
use crate::memory::held;
use crate::simd::widest;
use pulp::NullaryFnOnce;
use rayon::prelude::*;

/// Rows per parallel task.
const ROWS: usize = 1024;

/// Rows of a basis in half of single precision: 16-bit integers times a power of two for each row.
///
/// Each entry is within 2⁻¹⁵ of the largest magnitude in its row. Rows that were converted once stay the same when they are
/// converted back and again. Blocks of 16 rows are stored by columns, so that each SIMD lane sums up one row.
#[derive(Clone, Debug, PartialEq)]
pub struct ScaledRows {
    rank: usize,
    count: usize,
    /// `rank` columns of each block; zeros after the last row.
    columns: Vec<[i16; SIDE]>,
    /// Scales of the rows of each block.
    scales: Vec<[f32; SIDE]>,
}

impl ScaledRows {
    /// Converts rows of `rank` entries each, whose magnitudes must be at most half of the largest number.
    pub fn new(rank: usize, rows: &[f32]) -> Self {
        let count = rows.len() / rank;
        let blocks = count.div_ceil(SIDE);
        let (mut columns, mut scales) = (vec![[0; SIDE]; blocks * rank], vec![[0.0; SIDE]; blocks]);
        for (at, row) in rows.chunks_exact(rank).enumerate() {
            let (block, lane) = (at / SIDE, at % SIDE);
            let scale = scale(row);
            scales[block][lane] = scale;
            for (column, entry) in columns[block * rank..].iter_mut().zip(row) {
                column[lane] = (entry / scale).round() as i16;
            }
        }
        Self { rank, count, columns, scales }
    }

    /// The rows in single precision, without a rounding.
    pub fn to_rows(&self) -> Vec<f32> {
        let entry = |row: usize, column: usize| {
            let (block, lane) = (row / SIDE, row % SIDE);
            f32::from(self.columns[block * self.rank + column][lane]) * self.scales[block][lane]
        };
        (0..self.count).flat_map(|row| (0..self.rank).map(move |column| entry(row, column))).collect()
    }

    /// Number of rows.
    pub fn count(&self) -> usize {
        self.count
    }

    pub(super) fn bytes(&self) -> usize {
        held(&self.columns) + held(&self.scales)
    }

    /// Products of the first entries of all rows with `coordinates`; resizes `products`.
    pub(super) fn products(&self, coordinates: &[f64], products: &mut Vec<f64>, narrow: &mut Vec<[f32; SIDE]>) {
        let narrow = narrowed(coordinates, narrow);
        products.resize(self.count, 0.0);
        products.par_chunks_mut(ROWS).enumerate().for_each(|(chunk, sums)| {
            let (first, rank) = (chunk * ROWS / SIDE, self.rank);
            let (columns, scales) = (&self.columns[first * rank..], &self.scales[first..]);
            widest(ScaledProducts { rank, columns, scales, coordinates: &narrow[..coordinates.len()], sums });
        });
    }
}

/// Writes `coordinates` in single precision, followed by zeros to whole lanes.
fn narrowed<'a>(coordinates: &[f64], narrow: &'a mut Vec<[f32; SIDE]>) -> &'a [f32] {
    narrow.clear();
    narrow.resize(coordinates.len().div_ceil(SIDE), [0.0; SIDE]);
    narrow.as_flattened_mut().iter_mut().zip(coordinates).for_each(|(narrow, q)| *narrow = *q as f32);
    narrow.as_flattened()
}

/// Kernel that multiplies blocks of scaled rows by coordinates.
struct ScaledProducts<'a> {
    rank: usize,
    columns: &'a [[i16; SIDE]],
    scales: &'a [[f32; SIDE]],
    coordinates: &'a [f32],
    sums: &'a mut [f64],
}

impl NullaryFnOnce for ScaledProducts<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let blocks = self.columns.chunks_exact(self.rank).zip(self.scales);
        for ((columns, scales), sums) in blocks.zip(self.sums.chunks_mut(SIDE)) {
            let mut lanes = [0.0f32; SIDE];
            for (column, q) in columns.iter().zip(self.coordinates) {
                for lane in 0..SIDE {
                    lanes[lane] += f32::from(column[lane]) * q;
                }
            }
            for ((sum, lane), scale) in sums.iter_mut().zip(lanes).zip(scales) {
                *sum = f64::from(lane) * f64::from(*scale);
            }
        }
    }
}

/// The least power of two, not subnormal, times which 16-bit integers hold all entries of `row`.
fn scale(row: &[f32]) -> f32 {
    let most = row.iter().fold(0.0, |most: f32, entry| most.max(entry.abs()));
    let mut scale = f32::from_bits((most / f32::from(i16::MAX)).to_bits() & f32::INFINITY.to_bits());
    scale = scale.max(f32::MIN_POSITIVE);
    if most / scale > f32::from(i16::MAX) { 2.0 * scale } else { scale }
}

/// Products of the first entries of all rows, of the rank each, with `coordinates`; resizes `products`.
pub(super) fn products(
    (rank, rows): (usize, &[f32]),
    coordinates: &[f64],
    products: &mut Vec<f64>,
    narrow: &mut Vec<[f32; SIDE]>,
) {
    narrowed(coordinates, narrow);
    products.resize(rows.len() / rank, 0.0);
    products.par_chunks_mut(ROWS).enumerate().for_each(|(chunk, sums)| {
        widest(Products { rank, rows: &rows[chunk * ROWS * rank..], coordinates: narrow, sums });
    });
}

/// Kernel that multiplies rows of a basis by coordinates.
///
/// Coordinates are padded with zeros to whole lanes, so entries read beyond the end of a row do not count.
struct Products<'a> {
    rank: usize,
    rows: &'a [f32],
    coordinates: &'a [[f32; SIDE]],
    sums: &'a mut [f64],
}

impl NullaryFnOnce for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let length = SIDE * self.coordinates.len();
        for (row, sum) in self.sums.iter_mut().enumerate() {
            let rest = &self.rows[row * self.rank..];
            let mut lanes = [0.0; SIDE];
            let (chunks, end) = rest[..length.min(rest.len())].as_chunks::<SIDE>();
            for (chunk, coordinates) in chunks.iter().zip(self.coordinates) {
                for lane in 0..SIDE {
                    lanes[lane] += chunk[lane] * coordinates[lane];
                }
            }
            // Non-empty only in the last rows.
            for ((lane, b), q) in lanes.iter_mut().zip(end).zip(self.coordinates.last().into_iter().flatten()) {
                *lane += b * q;
            }
            *sum = f64::from(halved(halved(halved(halved(lanes, 8), 4), 2), 1)[0]);
        }
    }
}

/// Adds lanes `half` … 2 · `half` − 1 to the first `half` lanes.
#[inline(always)]
fn halved(mut lanes: [f32; SIDE], half: usize) -> [f32; SIDE] {
    for lane in 0..half {
        lanes[lane] += lanes[lane + half];
    }
    lanes
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The products of `rows` with `coordinates` in double precision.
    fn exact(rank: usize, rows: &[f32], coordinates: &[f64]) -> Vec<f64> {
        let row = |row: &[f32]| row.iter().zip(coordinates).map(|(b, q)| f64::from(*b) * q).sum();
        rows.chunks_exact(rank).map(row).collect()
    }

    proptest! {
        #[test]
        fn scaled_rows_are_near_and_convert_back(
            rank in 1..40_usize,
            entries in prop::collection::vec((-1.0..1.0_f32, -140..120_i32), 40..400),
            used in 0.0..1.0_f64,
        ) {
            let count = entries.len() / rank * rank;
            // Magnitudes differ between rows.
            let entry = |(at, own): (usize, &(f32, i32))| own.0 * f32::powi(2.0, entries[at / rank].1);
            let rows: Vec<f32> = entries[..count].iter().enumerate().map(entry).collect();
            let scaled = ScaledRows::new(rank, &rows);
            let back = scaled.to_rows();
            prop_assert_eq!(&ScaledRows::new(rank, &back), &scaled);
            for (row, back) in rows.chunks_exact(rank).zip(back.chunks_exact(rank)) {
                let most = row.iter().fold(f32::MIN_POSITIVE, |most, own| most.max(own.abs()));
                // Half of a step, which is twice as long beyond 32,767 steps.
                let bound = most / f32::from(i16::MAX) + f32::MIN_POSITIVE;
                prop_assert!(row.iter().zip(back).all(|(a, b)| (a - b).abs() <= bound), "{:?} {:?}", row, back);
            }
            let coordinates: Vec<f64> = (0..(used * rank as f64) as usize).map(|at| (at as f64 + 0.3).sin()).collect();
            let (mut products, mut narrow) = (Vec::new(), Vec::new());
            scaled.products(&coordinates, &mut products, &mut narrow);
            let expected = exact(rank, &back, &coordinates);
            prop_assert_eq!(products.len(), expected.len());
            for (row, (own, expected)) in back.chunks_exact(rank).zip(products.iter().zip(&expected)) {
                let size: f64 = row.iter().map(|b| f64::from(b.abs())).sum();
                prop_assert!((own - expected).abs() <= 1e-6 * size + f64::from(f32::MIN_POSITIVE), "{} {}", own, expected);
            }
        }
    }

    #[test]
    fn beyond_32767_steps_a_step_is_twice_as_long() {
        let rows = |most: f32| ScaledRows::new(2, &[-most, -0.25527954]).to_rows();
        assert_eq!(rows(32_767.0 / 32_768.0)[1], -8_365.0 / 32_768.0);
        assert_eq!(rows(0.9999894), [-1.0, -4_183.0 / 16_384.0]);
    }

    #[test]
    fn wide_and_plain_instructions_give_the_same_bits() {
        let rows: Vec<f32> = (0..19 * 2_100).map(|at| (at as f32).sin()).collect();
        let (scaled, coordinates) = (ScaledRows::new(19, &rows), [0.3, -1.2, 4.5, 2.2, 0.7].repeat(3));
        crate::simd::tests::same_on_every_path(|| {
            let (mut single, mut half, mut narrow) = (Vec::new(), Vec::new(), Vec::new());
            products((19, &rows), &coordinates, &mut single, &mut narrow);
            scaled.products(&coordinates, &mut half, &mut narrow);
            assert!(single.iter().zip(&half).all(|(a, b)| (a - b).abs() < 1e-3));
            (single, half)
        });
    }

    #[test]
    fn rows_of_zeros_and_of_large_numbers_are_kept() {
        for row in [
            [0.0, -0.0],
            [0.5 * f32::MAX, -0.5 * f32::MAX],
            [f32::MIN_POSITIVE, 0.0],
            [1.0, 0.5],
            [32_767.0, -32_767.0],
        ] {
            let scaled = ScaledRows::new(2, &row);
            let back = scaled.to_rows();
            assert_eq!(ScaledRows::new(2, &back), scaled);
            let near = row.iter().zip(&back).all(|(a, b)| (a - b).abs() <= row[0].abs() / 32_767.0 && b.is_finite());
            assert!(near, "{row:?} {back:?}");
        }
    }
}
