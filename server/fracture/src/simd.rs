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

/// The compilations of a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Instructions {
    Baseline,
    #[cfg(target_arch = "x86_64")]
    Avx2,
}

impl Instructions {
    /// All compilations, the widest last.
    const COMPILED: &[Self] = &[
        Self::Baseline,
        #[cfg(target_arch = "x86_64")]
        Self::Avx2,
    ];

    /// Whether this machine's processor has them.
    fn are_available(self) -> bool {
        match self {
            Self::Baseline => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => std::arch::is_x86_feature_detected!("avx2"),
        }
    }

    /// The widest that this machine has.
    fn widest() -> Self {
        #[cfg(test)]
        if let Some(forced) = tests::forced() {
            return forced;
        }
        let widest = Self::COMPILED.iter().copied().rev().find(|instructions| instructions.are_available());
        widest.unwrap_or(Self::Baseline)
    }
}

/// Runs `kernel` with the widest instructions that this machine has.
pub(crate) fn widest<K: Kernel>(kernel: K) -> K::Output {
    match Instructions::widest() {
        Instructions::Baseline => kernel.run(),
        // SAFETY: `Instructions::widest` returns what is available, so the processor has said that it has AVX2.
        #[cfg(target_arch = "x86_64")]
        Instructions::Avx2 => unsafe { avx2(kernel) },
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
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
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Held by the test that forces instructions: one at a time.
    static FORCING: Mutex<()> = Mutex::new(());

    /// Position of the forced instructions among the compiled ones, counted from 1, for all threads; 0: none are forced. Other tests
    /// meanwhile get the same bits.
    static FORCED: AtomicUsize = AtomicUsize::new(0);

    pub(super) fn forced() -> Option<Instructions> {
        let position = FORCED.load(Ordering::Relaxed).checked_sub(1)?;
        Instructions::COMPILED.get(position).copied()
    }

    /// Asserts that every compilation that this machine can run gives the same as the baseline; what they give.
    #[track_caller]
    pub(crate) fn same_on_every_path<T: PartialEq + Debug>(run: impl Fn() -> T) -> T {
        let _one_at_a_time = FORCING.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let mut plain = None;
        for (position, instructions) in Instructions::COMPILED.iter().enumerate() {
            if !instructions.are_available() {
                println!("skipped: this processor lacks {instructions:?}");
                continue;
            }
            FORCED.store(position + 1, Ordering::Relaxed);
            let found = run();
            FORCED.store(0, Ordering::Relaxed);
            match &plain {
                Some(plain) => assert_eq!(found, *plain, "{instructions:?}"),
                None => plain = Some(found),
            }
        }
        plain.expect("the baseline is always there")
    }

    #[test]
    fn the_baseline_is_first_and_can_be_forced() {
        assert_eq!(Instructions::COMPILED[0], Instructions::Baseline);
        let seen = Mutex::new(Vec::new());
        same_on_every_path(|| seen.lock().unwrap().push(Instructions::widest()));
        let seen = seen.into_inner().unwrap();
        let available = Instructions::COMPILED.iter().filter(|instructions| instructions.are_available());
        assert!(available.into_iter().all(|instructions| seen.contains(instructions)), "{seen:?}");
    }
}
