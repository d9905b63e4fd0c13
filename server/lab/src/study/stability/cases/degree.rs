//! Cases: the degree without examples, and close to the threshold.

use super::super::trial::{TrialFault, at, baked, coarse, struck};
use shatter_fracture::database::BakeRequest;
use shatter_fracture::degree::{TrainingSample, train};
use shatter_fracture::pipeline::{DegreeRequest, DegreeSource, FractureRequest, PreparedObject, TrainingExample};
use shatter_fracture::surface::{RawMesh, shapes};

/// Arch, request, and the factor on its impulse that just breaks the arch.
fn threshold() -> Result<(PreparedObject, FractureRequest, f64), TrialFault> {
    let prepared = baked(shapes::arch(), &coarse()?)?;
    let strike = FractureRequest { degree: DegreeRequest::ClosedForm, ..at(&prepared, [0.4, 1.0, 0.1]) };
    let factor = struck(&prepared, &strike)?.impulse_factor;
    Ok((prepared, strike, factor))
}

fn degree(prepared: &PreparedObject, strike: &FractureRequest, factor: f64) -> Result<u32, TrialFault> {
    let own = FractureRequest::at(strike.contacts[0].point_m, strike.contacts[0].impulse_ns * factor).seeded(1);
    Ok(struck(prepared, &FractureRequest { degree: strike.degree, ..own })?.degree)
}

/// Degree just above the threshold minus degree just below.
pub fn by_a_hair() -> Result<f64, TrialFault> {
    let (prepared, strike, factor) = threshold()?;
    let below = degree(&prepared, &strike, factor * (1.0 - 1e-9))?;
    Ok(f64::from(degree(&prepared, &strike, factor * (1.0 + 1e-9))?) - f64::from(below))
}

/// 0 if the degree source of an object without examples is the closed form.
pub fn no_example() -> Result<f64, TrialFault> {
    let (prepared, strike, factor) = threshold()?;
    let own = FractureRequest::at(strike.contacts[0].point_m, strike.contacts[0].impulse_ns * (3.0 * factor)).seeded(1);
    let result = struck(&prepared, &own)?;
    Ok(f64::from(u8::from(result.source != DegreeSource::ClosedForm)))
}

/// Arch that learned from a dozen impacts.
fn taught() -> Result<PreparedObject, TrialFault> {
    baked(shapes::arch(), &BakeRequest { examples: 12, ..coarse()? })
}

/// Largest relative change of an inferred number when every example is duplicated.
pub fn duplicate_examples() -> Result<f64, TrialFault> {
    let examples = taught()?.examples;
    let once = samples(&examples);
    let again = once.iter().map(|sample| TrainingSample { example: sample.example + examples.len(), ..sample.clone() });
    let twice: Vec<TrainingSample> = once.iter().cloned().chain(again).collect();
    let [Some(one), Some(two)] = [&once, &twice].map(|samples| train(samples, 1)) else {
        return Err(TrialFault::ours("learning", "too few training samples"));
    };
    let change = |sample: &TrainingSample| {
        let [a, b] = [&one, &two].map(|trained| trained.network.predict(&sample.descriptor).value);
        (b - a).exp_m1().abs()
    };
    Ok(once.iter().map(change).fold(0.0, f64::max))
}

fn samples(examples: &[TrainingExample]) -> Vec<TrainingSample> {
    examples.iter().enumerate().flat_map(|(k, example)| example.samples(k)).collect()
}

/// 0 if the degree of an impact like the examples is inferred, and of one a million times as strong is not.
pub fn far_outside() -> Result<f64, TrialFault> {
    let prepared = taught()?;
    let strike = breaking_request(&prepared)?;
    let source = |times: f64| -> Result<DegreeSource, TrialFault> {
        let mut own = strike.clone();
        own.contacts.iter_mut().for_each(|contact| contact.impulse_ns *= times);
        Ok(struck(&prepared, &own)?.source)
    };
    let right = [source(6.0)? == DegreeSource::Inferred, source(6e6)? == DegreeSource::ClosedForm];
    Ok(right.iter().filter(|right| !**right).count() as f64)
}

/// Impact of the first example with the impulse that just breaks the object.
fn breaking_request(prepared: &PreparedObject) -> Result<FractureRequest, TrialFault> {
    let first = prepared.examples.first().ok_or_else(|| TrialFault::ours("learning", "no example"))?;
    let mut strike = FractureRequest { contacts: first.contacts.clone(), ..at(prepared, [0.0, 1.0, 0.0]) };
    strike.degree = DegreeRequest::Inferred;
    let factor = struck(prepared, &strike)?.impulse_factor;
    strike.contacts.iter_mut().for_each(|contact| contact.impulse_ns *= factor);
    Ok(strike)
}

/// Largest decrease of the optimized degree while γ decreases.
pub fn monotone() -> Result<f64, TrialFault> {
    let (prepared, mut strike, factor) = threshold()?;
    strike.degree = DegreeRequest::Optimized;
    let (mut last, mut worst) = (0, 0.0f64);
    for times in [0.9, 1.1, 1.3, 1.6, 2.0, 2.5] {
        let own = degree(&prepared, &strike, factor * times)?;
        worst = worst.max(f64::from(last) - f64::from(own));
        last = own;
    }
    Ok(worst)
}

/// Closed-form degree over the optimized one for an impact that breaks the object into a dozen fragments or more.
fn closed_over_optimized(mesh: RawMesh, outward: [f64; 3]) -> Result<f64, TrialFault> {
    let prepared = baked(mesh, &coarse_for_thin()?)?;
    let strike = FractureRequest { degree: DegreeRequest::ClosedForm, ..at(&prepared, outward) };
    let factor = struck(&prepared, &strike)?.impulse_factor;
    let closed = degree(&prepared, &strike, factor * 6.0)?;
    let optimized = degree(&prepared, &FractureRequest { degree: DegreeRequest::Optimized, ..strike }, factor * 6.0)?;
    Ok(f64::from(closed) / f64::from(optimized))
}

fn coarse_for_thin() -> Result<shatter_fracture::database::BakeRequest, TrialFault> {
    let mut request = coarse()?;
    (request.elastic_spacing, request.crack_spacing) = (None, None);
    Ok(request)
}

pub fn of_a_plate() -> Result<f64, TrialFault> {
    closed_over_optimized(shapes::cuboid([1.0, 1.0, 0.04]), [0.2, 0.1, 1.0])
}

pub fn of_a_rod() -> Result<f64, TrialFault> {
    closed_over_optimized(shapes::cuboid([1.0, 0.04, 0.04]), [0.1, 1.0, 0.2])
}
