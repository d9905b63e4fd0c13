//! Equivalent stress.

/// Equivalent stress σ_eq = max(σ₁, σ₁ − (σ_t/σ_c) σ₃) of principal stresses σ₁ ≥ σ₂ ≥ σ₃, with `ratio` = σ_t/σ_c.
///
/// Matter breaks where it reaches σ_t: pulled at σ_t, pressed at σ_c, and sheared at σ_t/(1 + σ_t/σ_c). Source: C. A. Coulomb
/// (1776) and O. Mohr (1900), the straight envelope of both strengths.
pub fn equivalent_of(principal: &[f64; 3], ratio: f64) -> f64 {
    let [most, _, least] = *principal;
    most.max(most - ratio * least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pulled_and_pressed_matter_break_at_their_strengths() {
        let (strength, compressive) = (3.0, 60.0);
        let of = |principal| equivalent_of(&principal, strength / compressive);
        assert_eq!(of([strength, 0.0, 0.0]), strength);
        assert!((of([0.0, 0.0, -compressive]) - strength).abs() < 1e-12);
        // Pressed from all sides, it holds more than its compressive strength.
        assert!(of([-compressive; 3]) < 0.0);
        // Pulled on all sides, it breaks at its tensile strength.
        assert_eq!(of([strength; 3]), strength);
    }
}
