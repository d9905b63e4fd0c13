//! Conjugate gradients with the V-cycle as a preconditioner, for a few right-hand sides together.
//!
//! A free body's stiffness is singular, and forces in equilibrium keep all steps apart from rigid motions.
//!
//! Every step adds a known part to the energy (Z. Strakoš & P. Tichý, *On error estimation in the conjugate gradient
//! method*, ETNA 13, 2002), as in the solver of quadratic elements.

use super::cycle::{Cycle, NodeRow, WIDTH, ZERO};
use super::level::RefinedLevel;
use super::quadratic::QuadraticLevel;
use crate::cancel_token::CancelToken;
use crate::elasticity::ElasticityError;
use crate::simd::{SimdLanes, widest};
use pulp::NullaryFnOnce;

/// Share of the energy that the last steps of a solve added at most. The missing share is smaller, and far below the
/// error of any discretization that is measured.
///
/// At 1e-6, extrapolated energies of the sphere differ by at most 6e-9 from those at 1e-9, but the energy of a pulled block
/// by more than 1e-8.
pub(super) const ACCURACY: f64 = 1e-7;

/// As [`ACCURACY`], with quadratic elements, whose solves need more steps. Displacements of degree two, which the elements
/// have exactly, missed 2e-6 to 9.3e-6 of the energy on five shapes of lattices. At 1e-4, energies of the mug move by 1.5e-5
/// to 5e-5, in three quarters of the steps.
pub(super) const ACCURACY_QUADRATIC: f64 = 1e-5;

/// Number of the last steps whose parts of the energy are added up.
const DELAY: usize = 2;

/// Decrease of the preconditioned norm of the residual, squared, that rounding allows.
const ROUNDING: f64 = 1e-22;

/// Largest number of steps. Bodies without thin walls need ten, plates of 1:100 about a hundred.
const STEPS_MAX: usize = 400;

type Lanes = SimdLanes<WIDTH>;

/// Displacements of a few right-hand sides.
pub(super) struct Solution {
    pub(super) displacement: Vec<NodeRow>,
    /// ½ f·u of each.
    pub(super) energies: [f64; WIDTH],
    /// Number of steps.
    pub(super) steps: usize,
}

/// Stiffness of the elements of a level.
#[derive(Clone, Copy)]
pub(super) enum Stiffness<'a> {
    Linear(&'a RefinedLevel),
    Quadratic(&'a QuadraticLevel),
}

impl Stiffness<'_> {
    fn multiply(self, x: &[NodeRow], out: &mut [NodeRow]) {
        match self {
            Self::Linear(level) => level.multiply(x, out),
            Self::Quadratic(level) => level.multiply(x, out),
        }
    }

    fn precondition(self, cycle: &mut Cycle<'_>, right: &[NodeRow], x: &mut [NodeRow]) {
        match self {
            Self::Linear(_) => cycle.apply(right, x),
            Self::Quadratic(level) => {
                cycle.apply(&right[..level.nodes()], &mut x[..level.nodes()]);
                level.precondition_edges(right, x);
            }
        }
    }
}

/// Solves for the displacements under `forces`, which are in equilibrium, until the last steps add at most `accuracy` to the
/// energy.
pub(super) fn solve(
    stiffness: Stiffness<'_>,
    cycle: &mut Cycle<'_>,
    (forces, accuracy): (Vec<NodeRow>, f64),
    token: &CancelToken,
) -> Result<Solution, ElasticityError> {
    let mut residual = forces;
    let zeros = || vec![ZERO; residual.len()];
    let [mut displacement, mut direction, mut image, mut preconditioned] = [(); 4].map(|()| zeros());
    let mut state = State::default();
    for step in 0..STEPS_MAX {
        token.check()?;
        stiffness.precondition(cycle, &residual, &mut preconditioned);
        let ratio = state.turn(dot(&preconditioned, &residual), step == 0);
        combine(&mut direction, &preconditioned, ratio);
        if state.has_converged(accuracy) {
            return Ok(Solution { displacement, energies: state.energies.map(|twice| 0.5 * twice).0, steps: step });
        }
        stiffness.multiply(&direction, &mut image);
        let length = state.advance(dot(&direction, &image), step);
        add(&mut displacement, &direction, length);
        add(&mut residual, &image, length * -1.0);
    }
    Err(ElasticityError::Residual { residual: state.worst() })
}

/// Scalars of all right-hand sides.
struct State {
    /// r'M⁻¹r now and at the beginning.
    square: Lanes,
    first: Lanes,
    /// Twice the energies, and the parts that the last steps added.
    energies: Lanes,
    gains: [Lanes; DELAY],
}

impl Default for State {
    fn default() -> Self {
        let all = SimdLanes::all;
        Self { square: all(0.0), first: all(0.0), energies: all(0.0), gains: [all(f64::INFINITY); DELAY] }
    }
}

impl State {
    /// Takes the next r'M⁻¹r and returns the factor of the old direction.
    fn turn(&mut self, square: Lanes, is_first: bool) -> Lanes {
        let ratio = if is_first { SimdLanes::all(0.0) } else { square.zip(self.square, quotient) };
        self.first = if is_first { square } else { self.first };
        self.square = square;
        ratio
    }

    /// Takes p'Kp and returns the length of the step.
    fn advance(&mut self, curvature: Lanes, step: usize) -> Lanes {
        let length = self.square.zip(curvature, quotient);
        let gain = length * self.square;
        self.energies = self.energies + gain;
        self.gains[step % DELAY] = gain;
        length
    }

    fn has_converged(&self, accuracy: f64) -> bool {
        (0..WIDTH).all(|lane| {
            let gained: f64 = self.gains.iter().map(|gain| gain.0[lane]).sum();
            self.square.0[lane] <= ROUNDING * self.first.0[lane] || gained <= accuracy * self.energies.0[lane]
        })
    }

    /// Largest ratio of a residual's preconditioned norm to that at the beginning.
    fn worst(&self) -> f64 {
        self.square.zip(self.first, quotient).0.into_iter().fold(0.0, f64::max).sqrt()
    }
}

/// a/b; 0 where b is, as for a column without forces.
fn quotient(a: f64, b: f64) -> f64 {
    if b == 0.0 { 0.0 } else { a / b }
}

/// Kernels on whole vectors.
struct Dot<'a>(&'a [NodeRow], &'a [NodeRow]);

impl NullaryFnOnce for Dot<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn call(self) -> Lanes {
        let mut sums = ZERO;
        for (a, b) in self.0.iter().zip(self.1) {
            for axis in 0..3 {
                sums[axis] = sums[axis] + a[axis] * b[axis];
            }
        }
        sums[0] + sums[1] + sums[2]
    }
}

fn dot(a: &[NodeRow], b: &[NodeRow]) -> Lanes {
    widest(Dot(a, b))
}

/// sum += factor · more.
fn add(sum: &mut [NodeRow], more: &[NodeRow], factor: Lanes) {
    for (sum, more) in sum.iter_mut().zip(more) {
        sum.iter_mut().zip(more).for_each(|(sum, more)| *sum = *sum + *more * factor);
    }
}

/// direction ← more + factor · direction.
fn combine(direction: &mut [NodeRow], more: &[NodeRow], factor: Lanes) {
    for (own, more) in direction.iter_mut().zip(more) {
        own.iter_mut().zip(more).for_each(|(own, more)| *own = *more + *own * factor);
    }
}
