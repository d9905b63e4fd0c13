//! Conversion of engine errors to wire errors.

use nalgebra::Point3;
use shatter_fracture::pipeline::{DEGREE_MAX, FractureError, PartnerError};
use shatter_fracture::scene::EffectKind;
use shatter_proto::convention::Convention;
use shatter_proto::text::number;
use shatter_proto::{Error, ErrorKind};

/// Converts an engine error in meters, with its points and lengths in the coordinates and the unit of the request.
pub(crate) fn engine_error_in(error: FractureError, convention: &Convention) -> Error {
    let point = |point: Point3<f64>| Point3::from(convention.vector(point.coords.into()));
    let (length, unit_m) = (|meters| convention.length(meters), convention.meters_per_unit);
    engine_error(match error {
        FractureError::TooFar { contact, distance, limit, surface, .. } => {
            let (distance, limit, surface) = (length(distance), length(limit), point(surface));
            FractureError::TooFar { contact, distance, limit, surface, unit_m }
        }
        FractureError::RayMissed { ray, surface, distance, .. } => {
            let (ray, surface, distance) = (point(ray), point(surface), length(distance));
            FractureError::RayMissed { ray, surface, distance, unit_m }
        }
        error => error,
    })
}

/// Converts an engine error.
pub fn engine_error(error: FractureError) -> Error {
    let of = |contact: &usize, field: &str| format!("contacts[{contact}].{field}");
    let (kind, at) = match &error {
        FractureError::ContactCount(count) => (ErrorKind::ContactCount, count.to_string()),
        FractureError::Number { contact, key, .. } => match *key {
            "point" => (ErrorKind::ContactPoint, of(contact, "point_m")),
            "duration" => (ErrorKind::ContactDuration, of(contact, "duration_s")),
            "radius" => (ErrorKind::ContactRadius, of(contact, "radius_m")),
            _ => (ErrorKind::Impulse, of(contact, "impulse_ns")),
        },
        FractureError::ZeroImpulse { contact } => (ErrorKind::Impulse, of(contact, "impulse_ns")),
        FractureError::Partner(error) => of_partner(error),
        FractureError::Balanced { body } => (ErrorKind::Impulse, format!("body {body}")),
        FractureError::Gamma(gamma) => (ErrorKind::Gamma, number(*gamma)),
        FractureError::StrengthScale(_) => (ErrorKind::Configuration, "strength_scale".to_owned()),
        FractureError::Range(e1_over_gamma) => (ErrorKind::Gamma, number(*e1_over_gamma)),
        FractureError::Degree { degree, .. } => (ErrorKind::Degree, degree.to_string()),
        FractureError::ElasticityUnprepared { .. } => (ErrorKind::Effect, EffectKind::Elastic.name().to_owned()),
        FractureError::AnchorsUnprepared { effect } | FractureError::AttributesUnprepared { effect } => {
            (ErrorKind::Effect, effect.name().to_owned())
        }
        FractureError::DynamicsUnprepared { .. }
        | FractureError::DynamicsAnchorsUnprepared { .. }
        | FractureError::DynamicsGravity
        | FractureError::FragmentDynamics { .. } => (ErrorKind::Effect, EffectKind::Dynamics.name().to_owned()),
        FractureError::SkinUnprepared { .. } => (ErrorKind::Effect, EffectKind::Skin.name().to_owned()),
        FractureError::LiftUnprepared { lift, .. } => (ErrorKind::Lift, lift.to_string()),
        FractureError::TooFar { contact, .. } => (ErrorKind::ContactTooFar, of(contact, "point_m")),
        FractureError::RayDirection => (ErrorKind::Ray, of(&0, "ray")),
        FractureError::RayOrigin => (ErrorKind::Ray, of(&0, "point_m")),
        FractureError::RayMissed { .. } => (ErrorKind::RayMissed, of(&0, "ray")),
        FractureError::Canceled(_) => (ErrorKind::Canceled, "client".to_owned()),
        FractureError::Elasticity { body, .. } | FractureError::Field { body, .. } => {
            let kind = if error.is_callers() { ErrorKind::Unsolvable } else { ErrorKind::Failed };
            (kind, format!("body {body}"))
        }
        FractureError::UnknownFragment { fragment, .. } => (ErrorKind::UnknownFragment, fragment.to_string()),
        FractureError::FragmentSmall { fragment }
        | FractureError::FragmentUndivided { fragment }
        | FractureError::FragmentLarge { fragment, .. } => (ErrorKind::FragmentSize, fragment.to_string()),
        FractureError::FragmentLiftKind { lift, .. } => (ErrorKind::Lift, lift.to_string()),
        FractureError::FragmentLift { fragment, .. } => (ErrorKind::Unsolvable, format!("fragment {fragment}")),
        FractureError::OtherObject => (ErrorKind::Failed, "kept".to_owned()),
        FractureError::Tessellation(_) | FractureError::SectionLengths { .. } => {
            (ErrorKind::Failed, "tessellation".to_owned())
        }
    };
    Error::new(kind, at, explained(&error).unwrap_or_else(|| error.to_string()))
}

/// Kind of an error of partners, and the field or effect at fault.
fn of_partner(error: &PartnerError) -> (ErrorKind, String) {
    let field = |name: &str| match name {
        "speed" => "speed_m_s",
        "center" => "partner_center_m",
        "inertia" => "partner_inertia_kg_m2",
        _ => "partner_mass_kg",
    };
    let of = |contact: &usize, name: &str| format!("contacts[{contact}].{}", field(name));
    let at = match error {
        PartnerError::Missing { contact } | PartnerError::Mass { contact, .. } => of(contact, "mass"),
        PartnerError::Number { contact, key, .. } => of(contact, key),
        PartnerError::Inertia { contact } => of(contact, "inertia"),
        PartnerError::Differs { contacts, key } => of(&contacts[1], key),
        PartnerError::Immovable { contacts } => of(contacts.first().unwrap_or(&0), "mass"),
        PartnerError::Energy(_) => of(&0, "speed"),
        PartnerError::Threshold => "purpose".to_owned(),
        PartnerError::Gravity => return (ErrorKind::Effect, EffectKind::Gravity.name().to_owned()),
        PartnerError::Elastic => return (ErrorKind::Effect, EffectKind::Elastic.name().to_owned()),
    };
    (ErrorKind::ContactPartner, at)
}

/// Distance from which on the nearest point is meaningless because of rounding or overflow, m.
const FAR_M: f64 = 1e9;

/// Message for a point that is too far away for a meaningful distance, or for a degree above the limit of a scene.
fn explained(error: &FractureError) -> Option<String> {
    match error {
        FractureError::TooFar { contact, distance, unit_m, .. }
            if (distance * unit_m).is_nan() || distance * unit_m >= FAR_M =>
        {
            let advice = "`shatter list` prints the bounds of the object";
            Some(format!("contact {contact}: the point is more than {FAR_M:e} m from the object; {advice}"))
        }
        FractureError::Degree { cap, .. } if *cap < DEGREE_MAX => Some(format!("{error} (`sites_max` of the scene)")),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_fracture::lift::LiftKind;

    #[test]
    fn engine_errors_name_the_field() {
        let surface = Point3::new(0.1, 0.2, -0.3);
        let far = |distance| FractureError::TooFar { contact: 2, distance, limit: 0.5, surface, unit_m: 1.0 };
        let error = engine_error_in(far(1.0), &Convention::UNREAL);
        assert_eq!((error.kind, error.at.as_str()), (ErrorKind::ContactTooFar, "contacts[2].point_m"));
        for distance in [f64::INFINITY, f64::NAN, 1e200] {
            let message = engine_error_in(far(distance), &Convention::UNREAL).message;
            assert!(message.contains("more than 1e9 m") && message.len() < 150, "{message}");
        }
        let many = |cap| super::engine_error(FractureError::Degree { degree: 5000, cap }).message;
        assert!(
            many(40).ends_with("pass 1 to 40 sites (`sites_max` of the scene)") && many(DEGREE_MAX).ends_with("sites")
        );
        let number = FractureError::Number {
            contact: 0,
            key: "the square of impulse over duration",
            value: f64::INFINITY,
            positive: true,
        };
        assert_eq!(super::engine_error(number).kind, ErrorKind::Impulse);
        let unprepared =
            super::engine_error(FractureError::LiftUnprepared { body: 0, lift: LiftKind::SurfaceDiffusion });
        assert_eq!((unprepared.kind, unprepared.at.as_str()), (ErrorKind::Lift, "surface_diffusion"));
        let canceled = FractureError::Canceled(shatter_fracture::cancel_token::Canceled);
        assert_eq!(super::engine_error(canceled).kind, ErrorKind::Canceled);
    }

    #[test]
    fn errors_of_partners_name_the_contact() {
        let of = |error| {
            let error = super::engine_error(FractureError::Partner(error));
            (error.kind, error.at)
        };
        let at = |text: &str| (ErrorKind::ContactPartner, text.to_owned());
        assert_eq!(of(PartnerError::Missing { contact: 2 }), at("contacts[2].partner_mass_kg"));
        assert_eq!(of(PartnerError::Mass { contact: 1, value: 0.0 }), at("contacts[1].partner_mass_kg"));
        assert_eq!(of(PartnerError::Inertia { contact: 1 }), at("contacts[1].partner_inertia_kg_m2"));
        for (key, field) in [("speed", "speed_m_s"), ("center", "partner_center_m"), ("mass", "partner_mass_kg")] {
            let wanted = at(&format!("contacts[3].{field}"));
            assert_eq!(of(PartnerError::Number { contact: 3, key, value: f64::NAN }), wanted);
            assert_eq!(of(PartnerError::Differs { contacts: [0, 3], key }), wanted);
        }
        assert_eq!(of(PartnerError::Immovable { contacts: vec![4, 5] }), at("contacts[4].partner_mass_kg"));
        assert_eq!(of(PartnerError::Threshold), at("purpose"));
        assert_eq!(of(PartnerError::Gravity), (ErrorKind::Effect, "gravity".to_owned()));
        assert_eq!(of(PartnerError::Elastic), (ErrorKind::Effect, "elastic".to_owned()));
    }

    #[test]
    fn all_lengths_of_a_message_are_in_the_unit_of_the_request() {
        let surface = Point3::new(0.1, 0.2, -0.3);
        let far = || FractureError::TooFar { contact: 2, distance: 1.0, limit: 0.5, surface, unit_m: 1.0 };
        let missed = || FractureError::RayMissed { ray: Point3::origin(), surface, distance: 0.25, unit_m: 1.0 };
        let halves = Convention { meters_per_unit: 0.5, ..Convention::GLTF };
        for (error, convention, parts) in [
            (
                far(),
                Convention::GLTF,
                ["is 1.000000 m from", "at most 0.500000 m", "in m in the request's coordinates: 0.1"],
            ),
            (
                far(),
                Convention::UNREAL,
                [
                    "is 100.000000 cm from",
                    "at most 50.000000 cm",
                    "in cm in the request's coordinates: 10.000000,-30.000000,20.000000",
                ],
            ),
            (
                missed(),
                Convention::GLTF,
                ["by 0.250000 m;", "0.000000,0.000000,0.000000 m is", "0.100000,0.200000,-0.300000 m."],
            ),
            (
                missed(),
                Convention::UNREAL,
                ["by 25.000000 cm;", "0.000000 cm is", "10.000000,-30.000000,20.000000 cm."],
            ),
            (
                missed(),
                halves,
                [
                    "by 0.500000 units of 0.5 m;",
                    "0.000000 units of 0.5 m is",
                    "0.200000,0.400000,-0.600000 units of 0.5 m.",
                ],
            ),
        ] {
            let message = engine_error_in(error, &convention).message;
            assert!(parts.iter().all(|part| message.contains(part)), "{message}");
        }
    }
}
