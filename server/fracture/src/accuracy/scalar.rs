//! Errors that compare numbers. All are relative, so without unit, and 0 where nothing differs.

use super::AccuracyError;

/// |U − U_ref| / U_ref of the elastic energies, both in one unit.
pub fn energy_error(energy: f64, reference: f64) -> f64 {
    ((energy - reference) / reference).abs()
}

/// ∫|W − W_ref| / ∫W_ref, 0 ..= 2 where the totals agree: `energies` and `reference` are the energies of the nodes of one common
/// lattice (∫ W times the node's hat function), both in one unit. Differences within a node's cell are not seen.
///
/// # Errors
/// [`AccuracyError::Length`].
pub fn density_error(energies: &[f64], reference: &[f64]) -> Result<f64, AccuracyError> {
    AccuracyError::check("energies", reference.len(), energies.len())?;
    Ok(l1(energies, reference))
}

/// |n − n_ref| / n_ref of fracture degrees. Degrees before rounding may be compared, too: κ and steps of whole fragments then do not
/// hide what the field does.
pub fn degree_error(degree: f64, reference: f64) -> f64 {
    ((degree - reference) / reference).abs()
}

/// (F − F_best) / F_best, F = Σ_v w_v|X_v − p|² of diagrams of one field with one number of sites. F_best is the least of several
/// starts that were run to tolerance 0; it is an upper bound of the least of all, so gaps may be negative, and are at least as large as
/// stated.
pub fn cvd_gap(energy: f64, best: f64) -> f64 {
    (energy - best) / best
}

/// Wasserstein-1 distance of two distributions of fragment volumes over the mean volume of the reference: ∫₀¹|Q(t) − Q_ref(t)|dt / mean,
/// Q the quantile functions. By what share of a mean fragment sizes are off, were fragments matched by rank; the numbers may
/// differ. Infinite where one of them has no fragment.
pub fn size_distance(volumes: &[f64], reference: &[f64]) -> f64 {
    let sorted = |volumes: &[f64]| {
        let mut sorted = volumes.to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted
    };
    let (own, wanted) = (sorted(volumes), sorted(reference));
    if own.is_empty() || wanted.is_empty() {
        return f64::INFINITY;
    }
    let (mut sum, mut from, mut i, mut k) = (0.0, 0.0, 0, 0);
    while i < own.len() && k < wanted.len() {
        // Steps of both quantile functions, compared as whole numbers.
        let (next_own, next_wanted) = ((i + 1) * wanted.len(), (k + 1) * own.len());
        let to = next_own.min(next_wanted) as f64 / (own.len() * wanted.len()) as f64;
        sum += (to - from) * (own[i] - wanted[k]).abs();
        from = to;
        i += usize::from(next_own <= next_wanted);
        k += usize::from(next_wanted <= next_own);
    }
    sum / (wanted.iter().sum::<f64>() / wanted.len() as f64)
}

/// Σ|V_i − V_i,ref| / Σ V_i,ref over the sites, 0 ..= 2 where the totals agree: volumes of the cells of the same sites.
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
