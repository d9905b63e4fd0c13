//! Extrapolation of values on nested lattices to spacing 0, with an error bar.
//!
//! Based on: L. F. Richardson, *The approximate arithmetical solution by finite differences* (1911); P. J. Roache,
//! *Perspective: a method for uniform reporting of grid refinement studies* (Journal of Fluids Engineering 116, 1994),
//! observed orders.

use super::energy_error;

/// Smallest and largest observed order, over that of the theory, with which a sequence is extrapolated.
const ORDER_RANGE: [f64; 2] = [0.5, 1.5];

/// Factor on the bar of a sequence whose observed order is outside the range.
const WIDER: f64 = 2.0;

/// Number of bars below which an error is not told from that of its reference.
pub const BARS_MIN: f64 = 3.0;

/// Values are taken as equal if they differ by less than this share. Algebraic errors are below it.
const EQUAL: f64 = 1e-9;

/// Extrapolated value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extrapolation {
    /// Value at spacing 0.
    pub value: f64,
    /// Error bar of the value: the distance from the finest level, and the difference between extrapolation with the
    /// observed order and with that of the theory. Wider where the order is far from the theory's.
    pub bar: f64,
    /// Observed order; `None` if the values do not converge monotonically, or are equal.
    pub order: Option<f64>,
}

impl Extrapolation {
    /// Extrapolates the values on three levels, each with half the spacing of the one before. `theory` is the order that
    /// smooth problems have.
    pub fn new(values: [f64; 3], theory: f64) -> Self {
        let [first, second] = [values[1] - values[0], values[2] - values[1]];
        let finest = values[2];
        let rounding = EQUAL * values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        if first.abs() <= rounding && second.abs() <= rounding {
            return Self { value: finest, bar: rounding, order: None };
        }
        let ratio = first / second;
        if !(ratio > 0.0 && ratio.is_finite()) {
            return Self { value: finest, bar: WIDER * first.abs().max(second.abs()), order: None };
        }
        let order = ratio.log2();
        let at = |order: f64| finest + second / (order.exp2() - 1.0);
        let [low, high] = ORDER_RANGE.map(|share| share * theory);
        let value = at(order.clamp(low, high));
        let bar = (value - finest).abs() + (value - at(theory)).abs();
        // Differences that fall too fast may have met a level by chance, so the last one alone says little.
        let bar = match order {
            order if order < low => WIDER * bar,
            order if order > high => WIDER * (at(theory) - finest).abs().max(bar),
            _ => bar,
        };
        Self { value, bar: bar.max(rounding), order: Some(order) }
    }

    /// As [`Self::new`] from two levels, with the order of the theory. The bar is the difference of the levels, which
    /// holds for true orders down to half of the theory's.
    pub fn of_two([first, finest]: [f64; 2], theory: f64) -> Self {
        let step = finest - first;
        Self { value: finest + step / (theory.exp2() - 1.0), bar: step.abs(), order: None }
    }

    /// The same value with a bar that is wider by another error.
    #[must_use]
    pub fn widened(self, error: f64) -> Self {
        Self { bar: self.bar + error, ..self }
    }

    /// Relative error of `value` against this one, and the relative bar.
    pub fn error(&self, value: f64) -> [f64; 2] {
        [energy_error(value, self.value), (self.bar / self.value).abs()]
    }
}

/// Whether an error is so small that its reference's bar hides it.
pub fn is_hidden(error: f64, bar: f64) -> bool {
    error < BARS_MIN * bar
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::RandomStream;

    #[test]
    fn powers_of_the_spacing_are_extrapolated_exactly() {
        for order in [1.0, 1.5, 2.0, 2.8] {
            let found = Extrapolation::new([0, 1, 2].map(|level| 5.0 - 0.7 * (-order * f64::from(level)).exp2()), 2.0);
            assert!((found.value - 5.0).abs() < 1e-12 && (found.order.unwrap() - order).abs() < 1e-9, "{found:?}");
            assert!(found.bar >= 0.7 * (-2.0 * order).exp2() - 1e-12, "{found:?}");
        }
    }

    #[test]
    fn two_levels_have_a_wide_bar() {
        for order in [1.0, 1.5, 2.0] {
            let found = Extrapolation::of_two([0, 1].map(|level| 3.0 - (-order * f64::from(level)).exp2()), 2.0);
            assert!((found.value - 3.0).abs() <= found.bar, "{found:?}");
        }
    }

    /// Value 1 approached as c h^p (1 + a h), from both sides.
    #[test]
    fn manufactured_sequences_lie_within_their_bars() {
        let (mut stream, mut inside, count) = (RandomStream::new(3, 0), 0, 400);
        for _ in 0..count {
            let [order, size, more] = [0.8 + 1.6 * stream.uniform(), stream.uniform() - 0.5, stream.uniform() - 0.5];
            let value = |level: i32| {
                let spacing = (-f64::from(level)).exp2();
                1.0 + size * spacing.powf(order) * (1.0 + more * spacing)
            };
            let found = Extrapolation::new([0, 1, 2].map(value), 2.0);
            inside += usize::from((found.value - 1.0).abs() <= found.bar);
        }
        println!("{inside} of {count} inside their bars");
        assert!(inside * 100 >= 95 * count, "{inside} of {count}");
    }

    #[test]
    fn values_that_do_not_converge_have_wide_bars() {
        let turned = Extrapolation::new([1.0, 1.1, 1.05], 2.0);
        assert_eq!((turned.value, turned.order), (1.05, None));
        assert!(turned.bar >= 0.1);
        let slow = Extrapolation::new([1.0, 1.1, 1.19], 2.0);
        assert!(slow.order.unwrap() < 1.0 && slow.bar > 0.18, "{slow:?}");
        let fast = Extrapolation::new([1.0, 1.1, 1.101], 2.0);
        assert!(fast.order.unwrap() > 3.0 && fast.bar > 0.0005, "{fast:?}");
        let equal = Extrapolation::new([2.0; 3], 2.0);
        assert_eq!((equal.value, equal.order), (2.0, None));
        assert!(equal.bar < 1e-8);
    }

    #[test]
    fn small_errors_are_hidden_by_the_bar() {
        let found = Extrapolation::new([0.9, 0.975, 0.99375], 2.0);
        let [error, bar] = found.error(0.9);
        assert!((error - 0.1).abs() < 1e-9 && !is_hidden(error, bar), "{error} {bar}");
        let [error, bar] = found.error(0.99375);
        assert!(is_hidden(error, bar), "{error} {bar}");
    }
}
