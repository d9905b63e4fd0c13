//! SIMD dispatch and lanes of f64 for the loops that dominate a request on the reduced basis.
//!
//! `pulp` compiles each kernel for the baseline and for AVX2. Both yield equal bits: kernels sum in explicit lanes, and
//! rustc never contracts a product and a sum.

use pulp::{Arch, NullaryFnOnce};
use std::ops::{Add, Mul, Sub};

/// Runs `kernel` with the widest instructions of this machine.
///
/// The `call` of the kernel, and everything that it calls, must be inlined.
#[inline]
pub(crate) fn widest<K: NullaryFnOnce>(kernel: K) -> K::Output {
    #[cfg(test)]
    if let Some(forced) = tests::forced() {
        return forced.dispatch(kernel);
    }
    Arch::new().dispatch(kernel)
}

/// N numbers side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SimdLanes<const N: usize>(pub [f64; N]);

impl<const N: usize> SimdLanes<N> {
    /// N copies of one number.
    #[inline(always)]
    pub fn all(value: f64) -> Self {
        Self([value; N])
    }

    /// Applies `of` to each lane.
    #[inline(always)]
    #[must_use]
    pub fn map(self, of: impl Fn(f64) -> f64) -> Self {
        let mut result = [0.0; N];
        for (result, a) in result.iter_mut().zip(self.0) {
            *result = of(a);
        }
        Self(result)
    }

    /// Applies `of` to each pair of lanes.
    #[inline(always)]
    #[must_use]
    pub fn zip(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        let mut result = [0.0; N];
        for (result, (a, b)) in result.iter_mut().zip(self.0.into_iter().zip(other.0)) {
            *result = of(a, b);
        }
        Self(result)
    }

    /// Square of each positive lane; 0 in the others.
    #[inline(always)]
    #[must_use]
    pub fn positive_square(self) -> Self {
        self.map(|a| if a > 0.0 { a * a } else { 0.0 })
    }
}

impl<const N: usize> Add for SimdLanes<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl<const N: usize> Sub for SimdLanes<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl<const N: usize> Mul for SimdLanes<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl<const N: usize> Mul<f64> for SimdLanes<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self.map(|a| a * factor)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::fmt::Debug;
    use std::mem::discriminant;
    use std::sync::Mutex;

    /// Held by the test that forces an instruction set, so that only one does at a time.
    static FORCING: Mutex<()> = Mutex::new(());

    /// Instruction set forced on all threads. Tests that run meanwhile compute the same bits.
    static FORCED: Mutex<Option<Arch>> = Mutex::new(None);

    /// Forced instruction set, if any.
    pub(super) fn forced() -> Option<Arch> {
        *FORCED.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    fn force(arch: Option<Arch>) {
        *FORCED.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = arch;
    }

    /// Every compilation that this machine can run, the baseline first.
    fn available() -> Vec<Arch> {
        let mut all = vec![Arch::Scalar];
        #[cfg(target_arch = "x86_64")]
        match pulp::x86::V3::try_new() {
            Some(v3) => all.push(Arch::V3(v3)),
            None => println!("skipped: this processor lacks AVX2"),
        }
        // Covers other processors, and builds in which another crate enables more of `pulp`.
        if all.iter().all(|arch| discriminant(arch) != discriminant(&Arch::new())) {
            all.push(Arch::new());
        }
        all
    }

    /// Asserts that every compilation that this machine can run returns the baseline's value, and returns it.
    #[track_caller]
    pub(crate) fn same_on_every_path<T: PartialEq + Debug>(run: impl Fn() -> T) -> T {
        let _one_at_a_time = FORCING.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let mut plain = None;
        for arch in available() {
            force(Some(arch));
            let found = run();
            force(None);
            match &plain {
                Some(plain) => assert_eq!(found, *plain, "{arch:?}"),
                None => plain = Some(found),
            }
        }
        plain.expect("the baseline is always available")
    }

    #[test]
    fn every_path_can_be_forced_and_the_baseline_is_first() {
        let available = available();
        assert!(matches!(available[0], Arch::Scalar));
        assert!(available.iter().any(|arch| discriminant(arch) == discriminant(&Arch::new())), "the widest is tried");
        let seen = Mutex::new(Vec::new());
        same_on_every_path(|| seen.lock().unwrap().push(discriminant(&forced().unwrap())));
        let all: Vec<_> = available.iter().map(discriminant).collect();
        assert_eq!(seen.into_inner().unwrap(), all);
    }
}
