//! Threshold test, and closed-form estimate of the number of fragments.
//!
//! Based on: H. Schvartzman and M. A. Otaduy, *Fracture Animation Based on High-Dimensional Voronoi Diagrams* (I3D
//! 2014), for the criterion; A. Gersho, *Asymptotically optimal block quantization* (1979) and P. Zador, *Asymptotic
//! quantization error of continuous signals and the quantization dimension* (1982) for the estimate.
//!
//! The distance-weighted energy of a fragment is E_i = ∫ W|X − p_i|² over its cell. The fracture degree is the smallest
//! number of fragments with every E_i ≤ γ. Energies and γ have the unit of the field's masses times local length
//! squared.
//! and γ the same.

use super::slenderness::Slenderness;
use crate::centroidal::{EnergyField, cube_root, three_fifths};
use rayon::prelude::*;

/// c = 3 G_3, the dimension times the normalized second moment of the body-centered cubic lattice (Barnes and Sloane
/// 1983).
///
/// A region of volume V and density W then has the energy c·W·V^(5/3) about its center.
pub const COEFFICIENT: f64 = 3.0 * 0.0785433;

/// c_2 = 2 G_2, of the hexagonal tiling of the plane (Fejes Tóth 1959).
const COEFFICIENT_PLATE: f64 = 2.0 * 0.080_187_537_387_448_2;

/// c_1 = G_1, of equal segments of a line.
const COEFFICIENT_ROD: f64 = 1.0 / 12.0;

/// E_1 = ∫W|X − c|² over the whole body about its center of energy c: the energy of the body as one fragment.
///
/// Exact for W constant on each node's cell, because the cells' own moments are included. One pass sums about the node
/// r with the most energy, whose distance from c is at most of the order of the energy's spread. The parallel axis
/// theorem then shifts the sum to c with little loss of precision.
pub fn first_moment(field: &EnergyField) -> f64 {
    let m = field.dimension();
    let most = |most: usize, node: usize| if field.mass()[node] > field.mass()[most] { node } else { most };
    let about = field.lift().at((1..field.nodes()).fold(0, most));
    // Sums: w(X − r + b) by coordinate; w|X − r|² + 2 w b·(X − r) by coordinate; w; w m_v.
    let sums = in_parts(field.nodes(), 2 * m + 2, |part, sums| {
        let (levers, sums) = sums.split_at_mut(m);
        let (squares, sums) = sums.split_at_mut(m);
        for node in part * PART..field.nodes().min((part + 1) * PART) {
            let (mass, offset) = (field.mass()[node], &field.lift().first_moment[node * m..][..m]);
            let places = field.lift().at(node).iter().zip(about).zip(offset);
            for ((lever, square), ((x, r), b)) in levers.iter_mut().zip(squares.iter_mut()).zip(places) {
                let arm = x - r;
                *lever += mass * (arm + b);
                *square += mass * (arm * (arm + (b + b)));
            }
            sums[0] += mass;
            sums[1] += mass * field.lift().second_moment[node];
        }
    });
    let (about_r, total) = (sums[m..2 * m].iter().sum::<f64>() + sums[2 * m + 1], sums[2 * m]);
    about_r - sums[..m].iter().map(|lever| lever * lever).sum::<f64>() / total
}

/// Number of nodes of one part.
const PART: usize = 2048;

/// `length` sums over `count` nodes, merged by parts in order: the same bits for any number of threads.
fn in_parts(count: usize, length: usize, sum: impl Fn(usize, &mut [f64]) + Sync) -> Vec<f64> {
    let mut parts = vec![0.0; count.div_ceil(PART) * length];
    parts.par_chunks_mut(length).enumerate().for_each(|(part, sums)| sum(part, sums));
    let mut all = vec![0.0; length];
    parts.chunks(length).for_each(|part| all.iter_mut().zip(part).for_each(|(all, part)| *all += part));
    all
}

/// Evenness of the energy's distribution, ∫(W/W̄)^(3/5) over the volume: 1 for a uniform field, less for concentrated
/// energy.
///
/// The closed form of a solid body is this times a power of energy over γ (ours).
pub fn evenness(field: &EnergyField) -> f64 {
    let (mut sum, mut volume) = (0.0, 0.0);
    for node in 0..field.nodes() {
        sum += field.volume(node) * field.relative_density_three_fifths(node);
        volume += field.volume(node);
    }
    sum / volume
}

/// The factor on the impulse at which a body of first moment `first_moment` just breaks: √(γ/E_1).
///
/// E_1 is proportional to the square of the impulse.
pub fn threshold_factor(first_moment: f64, gamma: f64) -> f64 {
    (gamma / first_moment).sqrt()
}

/// n₀, the number of cells of equal energy γ, not rounded; about 1 or less if the body stays intact.
///
/// In D dimensions n₀ = (c_D/γ)^(D/(D+2)) ∫W^(D/(D+2))(det g)^(1/5) dx, with W integrated over a plate's thickness (D =
/// 2) or a rod's section (D = 1). Each formula holds for cells larger than its domain of integration, and yields the
/// largest number there. The largest of the three is therefore taken for each node (ours).
pub fn closed_form(field: &EnergyField, shape: &Slenderness, gamma: f64) -> f64 {
    closed_form_and_evenness(field, shape, gamma)[0]
}

/// [`closed_form`] and [`evenness`] in one pass.
pub fn closed_form_and_evenness(field: &EnergyField, shape: &Slenderness, gamma: f64) -> [f64; 2] {
    let Slenderness { thickness, section } = *shape;
    let unit = field.mean_density() / gamma;
    let solid_unit = three_fifths(COEFFICIENT * unit);
    let (mut cells, mut even, mut volume) = (0.0, 0.0, 0.0);
    for node in 0..field.nodes() {
        let density = field.relative_density(node) * unit;
        let share = field.relative_density_three_fifths(node);
        let solid = solid_unit * share;
        let plate = (COEFFICIENT_PLATE * density * thickness).sqrt() / thickness;
        let rod = cube_root(COEFFICIENT_ROD * density * section) / section;
        cells += field.measure(node) * solid.max(plate).max(rod);
        even += field.volume(node) * share;
        volume += field.volume(node);
    }
    [cells, even / volume]
}

/// A number of sites, with a flag for its maximum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SiteCount {
    /// Number of sites, at least 1.
    pub sites: usize,
    /// True if the criterion asks for more than the maximum.
    pub capped: bool,
}

/// The degree by the calibrated closed form: 1 if and only if E_1 ≤ γ, else max(2, round(κ n₀)), at most `sites_max`.
///
/// `estimate` is n₀ of [`closed_form`]; `kappa` comes from [`fit_kappa`](super::fit_kappa).
pub fn decide(first_moment: f64, gamma: f64, estimate: f64, kappa: f64, sites_max: usize) -> SiteCount {
    if first_moment <= gamma {
        return SiteCount { sites: 1, capped: false };
    }
    let wanted = (kappa * estimate).round().max(2.0);
    let cap = sites_max.max(1);
    if wanted > cap as f64 {
        SiteCount { sites: cap, capped: true }
    } else {
        SiteCount { sites: wanted as usize, capped: false }
    }
}

/// The default γ, J·m²: c·W_t·d⁵ with the energy density at the tensile strength, W_t = σ_t²/(2E).
///
/// A region of size d strained to its strength just stays intact. γ grows with the fifth power of d, so it belongs to an
/// object rather than to a material.
///
/// `youngs_pa` is E, `strength_pa` is σ_t, `size_m` is the reference fragment size d.
pub fn reference_gamma(youngs_pa: f64, strength_pa: f64, size_m: f64) -> f64 {
    COEFFICIENT * strength_pa * strength_pa / (2.0 * youngs_pa) * size_m.powi(5)
}
