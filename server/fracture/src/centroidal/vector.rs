//! Sums over the coordinates of the lift, in a fixed order that vectorizes.

/// Padding of rows of f64: their length is a multiple of this.
pub(super) const LANES: usize = 4;

/// Squared distance |a − b|², summed in [`LANES`] interleaved parts so that it vectorizes in a fixed order.
///
/// Zeros at the end of both do not change a bit.
#[inline(always)]
pub(super) fn square_distance(a: &[f64], b: &[f64]) -> f64 {
    let mut parts = [0.0; LANES];
    let (a, a_rest) = a.as_chunks::<LANES>();
    let (b, b_rest) = b.as_chunks::<LANES>();
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            let offset = a[lane] - b[lane];
            parts[lane] += offset * offset;
        }
    }
    for ((part, a), b) in parts.iter_mut().zip(a_rest).zip(b_rest) {
        *part += (a - b) * (a - b);
    }
    (parts[0] + parts[1]) + (parts[2] + parts[3])
}
