//! The widest instructions of the machine for the loops that take the time of a reduced strike, and numbers side by side for them.
//!
//! Ours: a kernel is compiled twice, for the baseline and for AVX2 without fused multiply-add, and sums in lanes that are written out: equal
//! bits from both.

use std::ops::{Add, Mul, Sub};

/// A loop over many numbers; its `run` is to be inlined, and all that it calls.
pub(crate) trait Kernel {
    /// What it finds.
    type Output;
    /// Runs it.
    fn run(self) -> Self::Output;
}

/// Runs `kernel` with the widest instructions that this machine has.
pub(crate) fn widest<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has just said that it has AVX2.
        return unsafe { avx2(kernel) };
    }
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

/// N numbers side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lanes<const N: usize>(pub [f64; N]);

impl<const N: usize> Lanes<N> {
    /// The same number N times.
    #[inline(always)]
    pub fn all(value: f64) -> Self {
        Self([value; N])
    }

    /// `of` each.
    #[inline(always)]
    pub fn map(self, of: impl Fn(f64) -> f64) -> Self {
        let mut result = [0.0; N];
        for (result, a) in result.iter_mut().zip(self.0) {
            *result = of(a);
        }
        Self(result)
    }

    /// `of` each pair.
    #[inline(always)]
    pub fn zip(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        let mut result = [0.0; N];
        for (result, (a, b)) in result.iter_mut().zip(self.0.into_iter().zip(other.0)) {
            *result = of(a, b);
        }
        Self(result)
    }

    /// The square of what is above 0.
    #[inline(always)]
    pub fn positive_square(self) -> Self {
        self.map(|a| if a > 0.0 { a * a } else { 0.0 })
    }
}

impl<const N: usize> Add for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl<const N: usize> Sub for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl<const N: usize> Mul for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl<const N: usize> Mul<f64> for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self.map(|a| a * factor)
    }
}
