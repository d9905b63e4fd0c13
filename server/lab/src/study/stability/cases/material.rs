//! Cases: materials and thresholds at the ends of their ranges.

use super::super::trial::{TrialFault, TrialResult, at, baked, coarse, difference, sound, struck};
use shatter_fracture::database::BakeRequest;
use shatter_fracture::pipeline::{DegreeRequest, FractureRequest};
use shatter_fracture::surface::shapes;

/// Sound request on an arch with this Poisson's ratio.
fn with_poisson(poisson: f64) -> Result<f64, TrialFault> {
    let mut request = coarse()?;
    request.material.poisson = poisson;
    let prepared = baked(shapes::arch(), &request)?;
    sound(&prepared, &struck(&prepared, &at(&prepared, [0.4, 1.0, 0.1]))?)
}

pub fn poisson_zero() -> Result<f64, TrialFault> {
    with_poisson(0.0)
}

pub fn poisson_045() -> Result<f64, TrialFault> {
    with_poisson(0.45)
}

pub fn poisson_0499() -> Result<f64, TrialFault> {
    with_poisson(0.499)
}

pub fn poisson_half() -> Result<f64, TrialFault> {
    with_poisson(0.5)
}

pub fn poisson_negative() -> Result<f64, TrialFault> {
    with_poisson(-0.3)
}

/// Request on the arch with E times `stiffer` and γ scaled so that W/γ is constant; degree by the closed form.
fn with_modulus(stiffer: f64) -> Result<TrialResult, TrialFault> {
    let base = coarse()?;
    let mut request = BakeRequest { gamma_j_m2: Some(1e-9 / stiffer), ..base };
    request.material.young_pa *= stiffer;
    let prepared = baked(shapes::arch(), &request)?;
    let strike = at(&prepared, [0.4, 1.0, 0.1]);
    let just =
        struck(&prepared, &FractureRequest { degree: DegreeRequest::ClosedForm, ..strike.clone() })?.impulse_factor;
    let mut strike =
        FractureRequest::at(strike.contacts[0].point_m, strike.contacts[0].impulse_ns * (4.0 * just)).seeded(1);
    strike.seed = 3;
    struck(&prepared, &strike)
}

pub fn modulus_over_twelve_decades() -> Result<f64, TrialFault> {
    let own = with_modulus(1.0)?;
    let (soft, stiff) = (with_modulus(1e-6)?, with_modulus(1e6)?);
    Ok(difference(&own, &soft, 1.0).max(difference(&own, &stiff, 1.0)))
}

/// Result for an arch with this γ: degree, and whether it was capped.
fn with_gamma(gamma_j_m2: f64) -> Result<TrialResult, TrialFault> {
    let prepared = baked(shapes::arch(), &coarse()?)?;
    let strike = at(&prepared, [0.4, 1.0, 0.1]);
    let strike = FractureRequest { gamma_j_m2: Some(gamma_j_m2), degree: DegreeRequest::ClosedForm, ..strike };
    let result = struck(&prepared, &strike)?;
    if !result.rows.is_empty() {
        sound(&prepared, &result)?;
    }
    Ok(result)
}

pub fn gamma_to_zero() -> Result<f64, TrialFault> {
    let result = with_gamma(1e-300)?;
    if result.capped { Ok(f64::from(result.degree)) } else { Err(TrialFault::ours("cap", "the cap is not reported")) }
}

pub fn gamma_to_infinity() -> Result<f64, TrialFault> {
    Ok(f64::from(with_gamma(1e300)?.degree))
}

pub fn gamma_zero() -> Result<f64, TrialFault> {
    Ok(f64::from(with_gamma(0.0)?.degree))
}
