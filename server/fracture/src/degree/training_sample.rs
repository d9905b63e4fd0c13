//! What is learned: how far the degree is from the closed form, given how the energy is spread.
//!
//! Ours (method of the house, section 5): the target is ln(n/(1 + n₀)), the descriptor ln n₀, ln E_1/γ and the logarithm of the
//! field's evenness. The three tell how much energy there is, how far it is spread, and how concentrated it is: the closed form
//! makes one number of them. Measured on the bunny (200 examples, 100 impacts held out): median error 6.9 % without the
//! evenness, 5.6 % with it, nine of ten within 17 % and 14 %.

/// One labelled field at one threshold.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainingSample {
    /// Which example it comes from: its lessons are left out together.
    pub example: usize,
    /// What is known before the degree is; the same length for all.
    pub descriptor: Vec<f64>,
    /// What is to be learned.
    pub target: f64,
}

/// Components of [`descriptor`].
pub const DESCRIPTOR_LENGTH: usize = 3;

/// The descriptor of a field: `estimate` is n₀, the moment E_1 and γ are in one unit, `evenness` is
/// [`evenness`](super::evenness). All positive.
pub fn descriptor(estimate: f64, first_moment: f64, evenness: f64, gamma: f64) -> Vec<f64> {
    vec![estimate.ln(), (first_moment / gamma).ln(), evenness.ln()]
}

/// ln(n/(1 + n₀)).
pub fn target(sites: f64, estimate: f64) -> f64 {
    (sites / (1.0 + estimate)).ln()
}

/// n for a [`target`], not rounded.
pub fn sites(target: f64, estimate: f64) -> f64 {
    target.exp() * (1.0 + estimate)
}
