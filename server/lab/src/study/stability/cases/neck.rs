//! Case of a weak neck: a dumbbell may snap at its neck, or the neck may shatter.

use super::super::portrait::portrait;
use super::super::trial::{TrialFault, TrialResult, at, baked, fine, sound, struck};
use crate::report::ReportFigure;
use nalgebra::Vector3;
use shatter_fracture::pipeline::{DegreeRequest, FractureRequest, PreparedObject};
use shatter_fracture::surface::shapes;
use shatter_proto::text::counted;

/// Result of one impulse on a dumbbell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neck {
    /// Impulse over the one that just breaks it.
    pub times: f64,
    /// Number of fragments.
    pub fragments: usize,
    /// Number of fragments whose center is in the neck.
    pub in_neck: usize,
    /// Largest fragment at either end, over the volume of one end.
    pub ends_kept: f64,
}

/// Half the length of the neck over that of the dumbbell along its axis.
const NECK: f64 = 0.2;

/// Dumbbell with one end pushed sideways, so that the neck bends.
fn pushed() -> Result<(PreparedObject, FractureRequest, f64), TrialFault> {
    let prepared = baked(shapes::dumbbell(), &fine()?)?;
    let side = at(&prepared, [0.3, 1.0, 0.0]).contacts[0].point_m;
    let strike = FractureRequest {
        degree: DegreeRequest::ClosedForm,
        ..FractureRequest::at(side, Vector3::new(-1.0, -0.2, 0.1)).seeded(1)
    };
    let factor = struck(&prepared, &strike)?.impulse_factor;
    Ok((prepared, strike, factor))
}

fn measure(prepared: &PreparedObject, times: f64, result: &TrialResult) -> Neck {
    let half = prepared.bodies[0].crack.nodes.iter().map(|node| node.y.abs()).fold(0.0, f64::max);
    let place = |center_m: [f64; 3]| (center_m[1] - prepared.frame.center_m.y) / prepared.frame.diagonal_m / half;
    let in_neck = result.rows.iter().filter(|row| place(row.center_m).abs() < NECK).count();
    let end = |sign: f64| {
        let own = result.rows.iter().filter(|row| place(row.center_m) * sign > NECK).map(|row| row.volume_m3);
        own.fold((0.0f64, 0.0f64), |(most, sum), volume| (most.max(volume), sum + volume))
    };
    let kept = [1.0, -1.0].map(end).map(|(most, sum)| if sum > 0.0 { most / sum } else { 0.0 });
    Neck { times, fragments: result.rows.len(), in_neck, ends_kept: kept[0].min(kept[1]) }
}

/// Results over a range of impulses; all must be sound.
pub fn neck_over_impulses() -> Result<Vec<Neck>, TrialFault> {
    let (prepared, strike, factor) = pushed()?;
    let mut necks = Vec::new();
    for times in [1.01, 1.5, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0] {
        let own =
            FractureRequest::at(strike.contacts[0].point_m, strike.contacts[0].impulse_ns * (factor * times)).seeded(1);
        let result = struck(&prepared, &own)?;
        sound(&prepared, &result)?;
        necks.push(measure(&prepared, times, &result));
    }
    Ok(necks)
}

/// Pictures of the dumbbell's fragments at three of these impulses.
pub fn neck_portraits() -> Result<Vec<ReportFigure>, TrialFault> {
    let (prepared, strike, factor) = pushed()?;
    let picture = |times: f64| {
        let own =
            FractureRequest::at(strike.contacts[0].point_m, strike.contacts[0].impulse_ns * (factor * times)).seeded(1);
        let result = struck(&prepared, &own)?;
        portrait(
            &prepared,
            &result,
            format!("{times} × the breaking impulse: {}", counted(result.rows.len() as u64, "fragment")),
        )
    };
    [1.01, 5.0, 12.0].into_iter().map(picture).collect()
}

/// Share of each end that stays in one fragment just above the threshold.
pub fn snaps_near_the_threshold() -> Result<f64, TrialFault> {
    Ok(neck_over_impulses()?[0].ends_kept)
}

/// Share of the fragments from the neck at twelve times the threshold.
pub fn shatters_far_above() -> Result<f64, TrialFault> {
    let far = neck_over_impulses()?[6];
    Ok(far.in_neck as f64 / far.fragments as f64)
}
