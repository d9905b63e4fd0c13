//! What the engine refuses, on the wire.

use nalgebra::Point3;
use shatter_fracture::pipeline::StrikeError;
use shatter_fracture::scene::Effect;
use shatter_proto::convention::Convention;
use shatter_proto::{Kind, Refusal};

/// A refusal of the engine, with its points in the coordinates of the strike.
pub(crate) fn refusal_in(error: StrikeError, convention: &Convention) -> Refusal {
    let own = |point: Point3<f64>| Point3::from(convention.vector(point.coords.into()));
    refusal(match error {
        StrikeError::TooFar { contact, distance_m, radius_m, surface_m } => {
            StrikeError::TooFar { contact, distance_m, radius_m, surface_m: own(surface_m) }
        }
        StrikeError::RayMissed { ray_m, surface_m, distance_m } => {
            StrikeError::RayMissed { ray_m: own(ray_m), surface_m: own(surface_m), distance_m }
        }
        error => error,
    })
}

/// A refusal of the engine on the wire.
pub fn refusal(error: StrikeError) -> Refusal {
    let of = |contact: &usize, field: &str| format!("contacts[{contact}].{field}");
    let (kind, at) = match &error {
        StrikeError::ContactCount(count) => (Kind::ContactCount, count.to_string()),
        StrikeError::Number { contact, key, .. } => match *key {
            "point" => (Kind::ContactPoint, of(contact, "point_m")),
            "duration" => (Kind::ContactDuration, of(contact, "duration_s")),
            "radius" => (Kind::ContactRadius, of(contact, "radius_m")),
            _ => (Kind::Impulse, of(contact, "impulse_ns")),
        },
        StrikeError::ZeroImpulse { contact } => (Kind::Impulse, of(contact, "impulse_ns")),
        StrikeError::Balanced { body } => (Kind::Impulse, format!("body {body}")),
        StrikeError::Gamma(gamma) => (Kind::Gamma, gamma.to_string()),
        StrikeError::Range(e1_over_gamma) => (Kind::Gamma, e1_over_gamma.to_string()),
        StrikeError::Degree { degree, .. } => (Kind::Degree, degree.to_string()),
        StrikeError::ElasticityUnprepared { .. } => (Kind::Effect, Effect::Elastic.name().to_owned()),
        StrikeError::Unheld { effect } | StrikeError::Bare { effect } => (Kind::Effect, effect.name().to_owned()),
        StrikeError::Undressed { .. } => (Kind::Effect, Effect::Skin.name().to_owned()),
        StrikeError::LiftUnprepared { lift, .. } => (Kind::Lift, lift.to_string()),
        StrikeError::TooFar { contact, .. } => (Kind::ContactTooFar, of(contact, "point_m")),
        StrikeError::RayDirection => (Kind::Ray, of(&0, "ray")),
        StrikeError::RayMissed { .. } => (Kind::RayMissed, of(&0, "ray")),
        StrikeError::Cancelled(_) => (Kind::Cancelled, "client".to_owned()),
        StrikeError::Elasticity { body, .. } | StrikeError::Field { body, .. } => {
            let kind = if error.is_callers() { Kind::Unsolvable } else { Kind::Failed };
            (kind, format!("body {body}"))
        }
        StrikeError::UnknownFragment { fragment, .. } => (Kind::UnknownFragment, fragment.to_string()),
        StrikeError::FragmentSmall { fragment } | StrikeError::FragmentLarge { fragment, .. } => {
            (Kind::FragmentSize, fragment.to_string())
        }
        StrikeError::FragmentLiftKind { lift, .. } => (Kind::Lift, lift.to_string()),
        StrikeError::FragmentLift { fragment, .. } => (Kind::Unsolvable, format!("fragment {fragment}")),
        StrikeError::OtherObject => (Kind::Failed, "kept".to_owned()),
        StrikeError::Tessellation(_) | StrikeError::SectionLengths { .. } => (Kind::Failed, "tessellation".to_owned()),
    };
    Refusal::new(kind, at, far_off(&error).unwrap_or_else(|| error.to_string()))
}

/// Distances from which on a nearest point says nothing, and rounding or overflow has the last word, m.
const FAR_M: f64 = 1e9;

/// What is said of a point or a ray so far off that its distance is hardly a number.
fn far_off(error: &StrikeError) -> Option<String> {
    let is_far = |distance_m: f64| distance_m.is_nan() || distance_m >= FAR_M;
    let advice = "`shatter list` shows between which corners the object lies";
    match error {
        StrikeError::TooFar { contact, distance_m, .. } if is_far(*distance_m) => {
            Some(format!("contact {contact}: the point is more than {FAR_M:e} m from the object; {advice}"))
        }
        StrikeError::RayMissed { distance_m, .. } if is_far(*distance_m) => {
            Some(format!("the ray begins or passes more than {FAR_M:e} m from the object and misses it; {advice}"))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_fracture::lift::LiftKind;

    #[test]
    fn refusals_of_the_engine_name_the_offender() {
        let surface_m = Point3::new(0.1, 0.2, -0.3);
        let far = StrikeError::TooFar { contact: 2, distance_m: 1.0, radius_m: 0.5, surface_m };
        let refusal = refusal_in(far, &Convention::UNREAL);
        assert!(refusal.message.contains("10.000000,-30.000000,20.000000"), "{}", refusal.message);
        assert_eq!((refusal.kind, refusal.at.as_str()), (Kind::ContactTooFar, "contacts[2].point_m"));
        for distance_m in [f64::INFINITY, f64::NAN, 1e200] {
            let far = StrikeError::TooFar { contact: 0, distance_m, radius_m: 0.5, surface_m };
            let missed = StrikeError::RayMissed { ray_m: surface_m, surface_m, distance_m };
            for error in [far, missed] {
                let message = super::refusal(error).message;
                assert!(message.contains("more than 1e9 m") && message.len() < 150, "{message}");
            }
        }
        let number = StrikeError::Number { contact: 0, key: "peak force", value: f64::INFINITY, positive: true };
        assert_eq!(super::refusal(number).kind, Kind::Impulse);
        let unprepared = super::refusal(StrikeError::LiftUnprepared { body: 0, lift: LiftKind::SurfaceDiffusion });
        assert_eq!((unprepared.kind, unprepared.at.as_str()), (Kind::Lift, "surface_diffusion"));
        let cancelled = StrikeError::Cancelled(shatter_fracture::token::Cancelled);
        assert_eq!(super::refusal(cancelled).kind, Kind::Cancelled);
    }
}
