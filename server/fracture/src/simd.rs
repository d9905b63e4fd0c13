//! The widest instructions of the machine for the loops that take the time of a reduced strike, and numbers side by side for them.
//!
//! `pulp` compiles a kernel for the baseline and for AVX2. Kernels sum in lanes that are written out, and rustc never contracts a
//! product and a sum: equal bits from both.

use pulp::{Arch, NullaryFnOnce};
use std::ops::{Add, Mul, Sub};

/// Runs `kernel` with the widest instructions that this machine has. Its `call` is to be inlined, and all that it calls.
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

    /// Held by the test that forces instructions: one at a time.
    static FORCING: Mutex<()> = Mutex::new(());

    /// The forced instructions, for all threads. Other tests meanwhile get the same bits.
    static FORCED: Mutex<Option<Arch>> = Mutex::new(None);

    pub(super) fn forced() -> Option<Arch> {
        *FORCED.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    fn force(arch: Option<Arch>) {
        *FORCED.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = arch;
    }

    /// The baseline, then every other compilation that this machine can run.
    fn available() -> Vec<Arch> {
        let mut all = vec![Arch::Scalar];
        #[cfg(target_arch = "x86_64")]
        match pulp::x86::V3::try_new() {
            Some(v3) => all.push(Arch::V3(v3)),
            None => println!("skipped: this processor lacks AVX2"),
        }
        // Further ones, of other processors or where another crate turns on more of `pulp`.
        if all.iter().all(|arch| discriminant(arch) != discriminant(&Arch::new())) {
            all.push(Arch::new());
        }
        all
    }

    /// Asserts that every compilation that this machine can run gives the same as the baseline; what they give.
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
        plain.expect("the baseline is always there")
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
