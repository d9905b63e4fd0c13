//! The degree without examples, and where it is decided by a hair.

use super::super::trial::{Fault, at, baked, coarse, struck};
use shatter_fracture::pipeline::{DegreeRequest, DegreeSource, Prepared, Strike};
use shatter_fracture::surface::{RawMesh, shapes};

/// An arch, a strike, and the factor at which it just breaks.
fn threshold() -> Result<(Prepared, Strike, f64), Fault> {
    let prepared = baked(shapes::arch(), &coarse()?)?;
    let strike = Strike { degree: DegreeRequest::ClosedForm, ..at(&prepared, [0.4, 1.0, 0.1]) };
    let factor = struck(&prepared, &strike)?.impulse_factor;
    Ok((prepared, strike, factor))
}

fn degree(prepared: &Prepared, strike: &Strike, factor: f64) -> Result<u32, Fault> {
    let own = Strike::at(strike.contacts[0].point_m, strike.contacts[0].impulse_ns * factor);
    Ok(struck(prepared, &Strike { degree: strike.degree, ..own })?.degree)
}

/// Degree just above the threshold minus degree just below.
pub fn by_a_hair() -> Result<f64, Fault> {
    let (prepared, strike, factor) = threshold()?;
    let below = degree(&prepared, &strike, factor * (1.0 - 1e-9))?;
    Ok(f64::from(degree(&prepared, &strike, factor * (1.0 + 1e-9))?) - f64::from(below))
}

/// 0 if an object without examples says that the closed form decided.
pub fn no_example() -> Result<f64, Fault> {
    let (prepared, strike, factor) = threshold()?;
    let own = Strike::at(strike.contacts[0].point_m, strike.contacts[0].impulse_ns * (3.0 * factor));
    let answer = struck(&prepared, &own)?;
    Ok(f64::from(u8::from(answer.source != DegreeSource::ClosedForm)))
}

/// Largest fall of the optimised degree while γ falls.
pub fn monotone() -> Result<f64, Fault> {
    let (prepared, mut strike, factor) = threshold()?;
    strike.degree = DegreeRequest::Optimised;
    let (mut last, mut worst) = (0, 0.0f64);
    for times in [0.9, 1.1, 1.3, 1.6, 2.0, 2.5] {
        let own = degree(&prepared, &strike, factor * times)?;
        worst = worst.max(f64::from(last) - f64::from(own));
        last = own;
    }
    Ok(worst)
}

/// Closed-form degree over the optimised one where the object breaks into a dozen pieces or more.
fn closed_over_optimised(mesh: RawMesh, outward: [f64; 3]) -> Result<f64, Fault> {
    let prepared = baked(mesh, &coarse_for_thin()?)?;
    let strike = Strike { degree: DegreeRequest::ClosedForm, ..at(&prepared, outward) };
    let factor = struck(&prepared, &strike)?.impulse_factor;
    let closed = degree(&prepared, &strike, factor * 6.0)?;
    let optimised = degree(&prepared, &Strike { degree: DegreeRequest::Optimised, ..strike }, factor * 6.0)?;
    Ok(f64::from(closed) / f64::from(optimised))
}

fn coarse_for_thin() -> Result<shatter_fracture::database::BakeRequest, Fault> {
    let mut request = coarse()?;
    (request.elastic_spacing, request.crack_spacing) = (None, None);
    Ok(request)
}

pub fn of_a_plate() -> Result<f64, Fault> {
    closed_over_optimised(shapes::cuboid([1.0, 1.0, 0.04]), [0.2, 0.1, 1.0])
}

pub fn of_a_rod() -> Result<f64, Fault> {
    closed_over_optimised(shapes::cuboid([1.0, 0.04, 0.04]), [0.1, 1.0, 0.2])
}
