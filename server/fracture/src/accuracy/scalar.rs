//! Relative errors of scalars. They have no unit, and are 0 for equal values.

use super::AccuracyError;

/// Relative energy error |U − U_ref| / U_ref; both in one unit.
pub fn energy_error(energy: f64, reference: f64) -> f64 {
    ((energy - reference) / reference).abs()
}

/// Relative error of the energy distribution, ∫|W − W_ref| / ∫W_ref; 0 ..= 2 if the totals agree.
///
/// `energies` and `reference` are energies of the nodes of one common lattice (∫ W times the node's hat function), in
/// one unit. Differences within a node's cell are not detected.
///
/// # Errors
/// [`AccuracyError::Length`].
pub fn density_error(energies: &[f64], reference: &[f64]) -> Result<f64, AccuracyError> {
    AccuracyError::check("energies", reference.len(), energies.len())?;
    Ok(l1(energies, reference))
}

/// Relative error of fracture degrees, |n − n_ref| / n_ref.
///
/// Degrees before rounding may be compared, too, so that κ and steps of whole fragments do not
/// hide the effect of the field.
pub fn degree_error(degree: f64, reference: f64) -> f64 {
    ((degree - reference) / reference).abs()
}

/// Relative energy gap of a diagram, (F − F_best) / F_best with F = Σ_v w_v|X_v − p|².
///
/// Both diagrams have the same field and number of sites. F_best is the least of several starts run to tolerance 0. It
/// is an upper bound of the true minimum, so gaps may be negative, and true gaps are at least as large.
pub fn cvd_gap(energy: f64, best: f64) -> f64 {
    (energy - best) / best
}

/// Distance of two distributions of fragment volumes: Wasserstein-1 distance over the mean volume of the reference.
///
/// This is the mean error of fragment sizes, matched by rank, relative to the mean fragment. The numbers of fragments may
/// differ. Infinite if one of them has no fragment.
pub fn size_distance(volumes: &[f64], reference: &[f64]) -> f64 {
    wasserstein(volumes, reference) / (reference.iter().sum::<f64>() / reference.len() as f64)
}

/// Wasserstein-1 distance of two sets of values with equal weights, ∫₀¹|Q(t) − Q_ref(t)|dt with Q the quantile functions.
///
/// The sets may differ in size. Infinite if one is empty. The unit is that of the values.
pub fn wasserstein(values: &[f64], reference: &[f64]) -> f64 {
    let sorted = |values: &[f64]| {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted
    };
    let (own, wanted) = (sorted(values), sorted(reference));
    if own.is_empty() || wanted.is_empty() {
        return f64::INFINITY;
    }
    let (mut sum, mut from, mut i, mut k) = (0.0, 0.0, 0, 0);
    while i < own.len() && k < wanted.len() {
        // Steps of both quantile functions, compared as integers.
        let (next_own, next_wanted) = ((i + 1) * wanted.len(), (k + 1) * own.len());
        let to = next_own.min(next_wanted) as f64 / (own.len() * wanted.len()) as f64;
        sum += (to - from) * (own[i] - wanted[k]).abs();
        from = to;
        i += usize::from(next_own <= next_wanted);
        k += usize::from(next_wanted <= next_own);
    }
    sum
}

/// Relative error of cell volumes, Σ|V_i − V_i,ref| / Σ V_i,ref over the same sites; 0 ..= 2 if the totals agree.
///
/// # Errors
/// [`AccuracyError::Length`].
pub fn volume_l1(volumes: &[f64], reference: &[f64]) -> Result<f64, AccuracyError> {
    AccuracyError::check("volumes", reference.len(), volumes.len())?;
    Ok(l1(volumes, reference))
}

fn l1(values: &[f64], reference: &[f64]) -> f64 {
    values.iter().zip(reference).map(|(own, wanted)| (own - wanted).abs()).sum::<f64>() / reference.iter().sum::<f64>()
}
