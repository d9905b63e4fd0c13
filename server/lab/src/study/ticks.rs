//! Ticks of a logarithmic axis.

use std::ops::Range;

/// About four to ten round numbers within `range`: powers of ten, or more digits of each decade if the range is short.
pub(super) fn ticks(range: &Range<f64>) -> Vec<f64> {
    let decades = (range.end / range.start).log10();
    let (mantissas, step): (&[f64], usize) = match decades {
        short if short < 0.9 => (&[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0], 1),
        some if some < 2.2 => (&[1.0, 2.0, 5.0], 1),
        several if several < 3.5 => (&[1.0, 3.0], 1),
        many => (&[1.0], 1 + (many / 9.0) as usize),
    };
    let [first, last] = [range.start, range.end].map(|end| end.log10().floor() as i32);
    let powers = (first..=last).step_by(step);
    let values = powers.flat_map(|power| mantissas.iter().map(move |mantissa| written(*mantissa, power)));
    values.filter(|value| range.contains(value)).collect()
}

/// `mantissa`·10^`power` without the rounding error of the product.
fn written(mantissa: f64, power: i32) -> f64 {
    format!("{mantissa}e{power}").parse().unwrap_or(mantissa)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_and_long_axes_have_marks() {
        assert_eq!(ticks(&(0.03..0.12)), [0.03, 0.04, 0.05, 0.07, 0.1]);
        assert_eq!(ticks(&(0.8..20.0)), [1.0, 2.0, 5.0, 10.0]);
        assert_eq!(ticks(&(0.5..500.0)), [1.0, 3.0, 10.0, 30.0, 100.0, 300.0]);
        assert_eq!(ticks(&(1e-7..1.5)), [1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0]);
        for exponent in -30..30 {
            let from = 1.37 * 10f64.powi(exponent);
            for width in [1.7, 2.0, 5.0, 30.0, 1e3, 1e5, 1e9, 1e20] {
                let found = ticks(&(from..from * width));
                assert!((1..=12).contains(&found.len()) && found.is_sorted(), "{from} {width}: {found:?}");
            }
        }
    }
}
