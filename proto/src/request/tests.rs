use super::*;
use proptest::prelude::*;

fn strike() -> Request {
    let contact = Contact {
        point_m: [0.1, 0.2, 0.3],
        ray: None,
        impulse_ns: [-1.0, 0.5, 0.0],
        duration_s: Some(1e-4),
        radius_m: None,
        partner: None,
    };
    Request {
        object: "Vase 花".into(),
        contacts: vec![contact; 3],
        gamma_j_m2: Some(2.5),
        seed: 7,
        ..Request::default()
    }
}

fn wire() -> RequestWire {
    RequestWire { sequence: 42, ..strike().wire([9; 16]).unwrap() }
}

/// Checks the error of an invalid request.
fn check(change: impl FnOnce(&mut RequestWire), kind: ErrorKind, at: &str) {
    let mut wire = wire();
    change(&mut wire);
    let error = wire.validate().expect_err(at);
    assert_eq!((error.kind, error.at.as_str()), (kind, at), "{}", error.message);
    assert!(!error.message.is_empty());
}

#[test]
fn a_request_round_trips() {
    assert_eq!(wire().validate().unwrap(), strike());
    let optimized = Request {
        purpose: Purpose::Threshold,
        degree: DegreeRule::Optimized,
        fragments_max: Some(9),
        bytes_max: Some(1 << 20),
        deadline: Some(Duration::from_millis(12)),
        from: Some(RetainedFragment { handle: 7, fragment: 9 }),
        keep: true,
        quality: Some(Quality::Film),
        error_max: Some(0.02),
        time_ms_max: Some(7.5),
        iterations_max: Some(0),
        ..strike()
    };
    for quality in Quality::ALL {
        let strike = Request { quality: Some(quality), elastic: DisplacementSource::Reduced, ..optimized.clone() };
        assert_eq!(strike.wire([0; 16]).unwrap().validate().unwrap(), strike);
        assert_eq!(Quality::by_name(quality.name()), Ok(quality));
    }
    for degree in
        [DegreeRule::Preset, DegreeRule::Inferred, DegreeRule::Verified, DegreeRule::ClosedForm, DegreeRule::Sites(7)]
    {
        let strike = Request { degree, ..optimized.clone() };
        assert_eq!(strike.wire([0; 16]).unwrap().validate().unwrap(), strike);
    }
    for (_, convention) in Convention::NAMED {
        let strike = Request { convention, ..optimized.clone() };
        assert_eq!(strike.wire([0; 16]).unwrap().validate().unwrap(), strike);
    }
    for surface in RequestedSurface::ALL {
        let strike = Request { surface, ..optimized.clone() };
        assert_eq!(strike.wire([0; 16]).unwrap().validate().unwrap(), strike);
    }
    for criterion in RequestedCriterion::ALL.map(Some).into_iter().chain([None]) {
        let strike = Request { criterion, ..optimized.clone() };
        assert_eq!(strike.wire([0; 16]).unwrap().validate().unwrap(), strike);
    }
    for lift in [Lift::Euclidean, Lift::Interior, Lift::SurfaceDiffusion] {
        let strike = Request { lift: Some(lift), ..optimized.clone() };
        assert_eq!(strike.wire([0; 16]).unwrap().validate().unwrap(), strike);
    }
}

#[test]
fn a_ray_round_trips_and_needs_a_direction_and_one_contact() {
    let aimed = |ray| Contact { ray: Some(ray), ..strike().contacts[0] };
    let one = Request { contacts: vec![aimed([0.0, -2.0, 0.0])], ..strike() };
    assert_eq!(one.wire([0; 16]).unwrap().validate().unwrap(), one);
    let pointless = Contact { impulse_ns: [0.0; 3], ..one.contacts[0] };
    let aim = Request { purpose: Purpose::Aim, contacts: vec![pointless], ..one.clone() };
    assert_eq!(aim.wire([0; 16]).unwrap().validate().unwrap(), aim);
    let endless = Contact { impulse_ns: [f64::NAN, 0.0, 0.0], ..one.contacts[0] };
    let error = Request { contacts: vec![endless], ..aim.clone() }.wire([0; 16]).unwrap_err();
    assert_eq!((error.kind, error.at.as_str()), (ErrorKind::Impulse, "contacts[0].impulse_ns"));
    let unaimed = Request { contacts: vec![strike().contacts[0]], ..aim };
    let several = Request { contacts: vec![aimed([1.0, 0.0, 0.0]), strike().contacts[0]], ..one.clone() };
    let flat = Request { contacts: vec![aimed([0.0; 3])], ..one.clone() };
    let odd = Request { contacts: vec![aimed([f64::NAN, 0.0, 1.0])], ..one };
    for (strike, at) in [unaimed, several, flat, odd].iter().zip(["contacts[0].ray"; 4]) {
        let error = strike.wire([0; 16]).unwrap_err();
        assert_eq!((error.kind, error.at.as_str()), (ErrorKind::Ray, at), "{}", error.message);
    }
}

/// Partners of all contacts, one of which strikes twice.
fn with_partners() -> Request {
    let mut strike = strike();
    let ball = ContactPartner::new(5, 0.26, 10.0).rotating([0.1, 0.2, 0.4], [2e-4, 2e-4, 3e-4, 1e-5, 0.0, -1e-5]);
    let partners = [ball, ContactPartner::new(0, f64::INFINITY, 0.0), ContactPartner { speed_m_s: -3.0, ..ball }];
    for (contact, partner) in strike.contacts.iter_mut().zip(partners) {
        contact.partner = Some(partner);
    }
    strike
}

#[test]
fn partners_round_trip() {
    assert_eq!(with_partners().wire([9; 16]).unwrap().validate().unwrap(), with_partners());
}

#[test]
fn partners_that_do_not_fit_are_refused_by_field() {
    let check = |i: usize, field: &str, change: &dyn Fn(&mut ContactWire)| {
        let mut wire = with_partners().wire([9; 16]).unwrap();
        change(&mut wire.contacts[i]);
        let error = wire.validate().expect_err(field);
        let at = format!("contacts[{i}].{field}");
        assert_eq!((error.kind, error.at), (ErrorKind::ContactPartner, at), "{}", error.message);
        assert!(error.message.starts_with(&format!("contact {i}: ")), "{}", error.message);
    };
    for value in [0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
        check(1, "partner_mass_kg", &|own| own.partner_mass_kg = value);
    }
    for value in [f64::NAN, f64::INFINITY] {
        check(0, "speed_m_s", &|own| own.speed_m_s = value);
        check(0, "partner_center_m", &|own| own.partner_center_m[2] = value);
        check(0, "partner_inertia_kg_m2", &|own| own.partner_inertia_kg_m2[5] = value);
    }
    for inertia in [[-1.0, 1.0, 1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0, 1.0, 0.0, 0.0], [1.0, 1.0, 1.0, 0.8, -0.8, 0.8]] {
        check(0, "partner_inertia_kg_m2", &|own| own.partner_inertia_kg_m2 = inertia);
    }
    // Contact 2 has the partner of contact 0.
    check(2, "partner_mass_kg", &|own| own.partner_mass_kg = 0.27);
    check(2, "partner_center_m", &|own| own.partner_center_m[0] = 0.0);
    check(2, "partner_inertia_kg_m2", &|own| own.partner_inertia_kg_m2 = [0.0; 6]);
    check(1, "partner_mass_kg", &|own| *own = ContactWire { ray: [0.0; 3], ..strike().contacts[1].wire(1).unwrap() });
    // Without a mass, nothing else of a partner is given.
    let alone = |change: &dyn Fn(&mut ContactWire)| {
        let mut wire = wire();
        change(&mut wire.contacts[0]);
        wire.validate().expect_err("no mass").at
    };
    assert_eq!(alone(&|own| own.speed_m_s = 1.0), "contacts[0].partner_mass_kg");
    assert_eq!(alone(&|own| own.partner = 1), "contacts[0].partner_mass_kg");
    assert_eq!(alone(&|own| own.partner_inertia_kg_m2[0] = 1.0), "contacts[0].partner_mass_kg");
    let mut zero = with_partners();
    zero.contacts[1].partner = Some(ContactPartner::new(3, 0.0, 1.0));
    assert_eq!(zero.wire([9; 16]).unwrap_err().at, "contacts[1].partner_mass_kg");
}

#[test]
fn zero_is_the_default() {
    let mut wire = wire();
    (wire.degree, wire.lift, wire.gamma_j_m2, wire.convention_meters_per_unit) = (0, 0, 0.0, 1.0);
    let strike = wire.validate().unwrap();
    assert_eq!((strike.degree, strike.lift, strike.gamma_j_m2), (DegreeRule::Preset, None, None));
    assert!(strike.convention.is_default());
    assert_eq!((strike.quality, strike.error_max, strike.time_ms_max, strike.iterations_max), (None, None, None, None));
}

#[test]
fn every_validation_error_names_the_field() {
    check(|w| w.magic = 0, ErrorKind::BadMagic, "0x00000000");
    let later = crate::PROTOCOL_VERSION + 1;
    check(|w| w.version = later, ErrorKind::VersionMismatch, &later.to_string());
    check(|w| w.purpose = 0, ErrorKind::UnknownRequest, "0");
    check(|w| w.contact_count = 0, ErrorKind::ContactCount, "0");
    check(|w| w.contact_count = 9, ErrorKind::ContactCount, "9");
    check(|w| w.contact_count = 2, ErrorKind::ReservedField, "contacts[2]");
    check(|w| w.contacts[1].point_m[2] = f64::NAN, ErrorKind::ContactPoint, "contacts[1].point_m");
    check(|w| w.contacts[2].impulse_ns = [0.0; 3], ErrorKind::Impulse, "contacts[2].impulse_ns");
    check(|w| w.contacts[0].impulse_ns[0] = f64::INFINITY, ErrorKind::Impulse, "contacts[0].impulse_ns");
    check(|w| w.contacts[0].impulse_ns[0] = 1e300, ErrorKind::Impulse, "contacts[0].impulse_ns");
    for (impulse_ns, why) in [
        (1e300, "too large to be squared; pass a smaller one"),
        (f64::NAN, "not finite; pass a finite one"),
        (0.0, "zero or too small to be squared; pass a larger one"),
        (1e-300, "zero or too small to be squared; pass a larger one"),
    ] {
        let mut wire = wire();
        wire.contacts[0].impulse_ns = [impulse_ns, 0.0, 0.0];
        let message = wire.validate().unwrap_err().message;
        assert_eq!(message, format!("contact 0: the impulse is {why}"));
    }
    for impulse_ns in [1e-161, 1e154] {
        let mut wire = wire();
        wire.contacts[0].impulse_ns = [0.0, impulse_ns, 0.0];
        wire.validate().unwrap();
    }
    check(|w| w.contacts[0].duration_s = -1.0, ErrorKind::ContactDuration, "contacts[0].duration_s");
    check(|w| w.contacts[0].radius_m = f64::NAN, ErrorKind::ContactRadius, "contacts[0].radius_m");
    check(|w| w.gamma_j_m2 = -1.0, ErrorKind::Gamma, "gamma_j_m2");
    check(|w| w.gamma_j_m2 = f64::NAN, ErrorKind::Gamma, "gamma_j_m2");
    check(|w| w.degree = 3, ErrorKind::Degree, "0");
    check(|w| w.degree = 6, ErrorKind::Degree, "6");
    check(|w| w.degree_sites = 5, ErrorKind::Degree, "5");
    check(|w| w.lift = 4, ErrorKind::Lift, "4");
    check(|w| w.surface = 2, ErrorKind::Budget, "surface");
    check(|w| w.criterion = 3, ErrorKind::Budget, "criterion");
    check(|w| w.effects_on = 1 << 40, ErrorKind::UnknownEffect, "40");
    check(|w| w.effects_off = 1 << 63 | 4, ErrorKind::UnknownEffect, "63");
    check(|w| w.error_max = f64::NAN, ErrorKind::Budget, "error_max");
    check(|w| w.error_max = 1.5, ErrorKind::Budget, "error_max");
    check(|w| w.error_max = -0.1, ErrorKind::Budget, "error_max");
    check(|w| w.time_ms_max = -8.0, ErrorKind::Budget, "time_ms_max");
    check(|w| w.time_ms_max = f64::INFINITY, ErrorKind::Budget, "time_ms_max");
    check(|w| w.quality = 5, ErrorKind::Budget, "quality");
    check(|w| w.iterations = u32::MAX, ErrorKind::Budget, "iterations_max");
    check(|w| w.elastic = 3, ErrorKind::Elastic, "3");
    check(|w| w.convention_up = 2, ErrorKind::Convention, "convention.up");
    check(|w| w.convention_hand = 2, ErrorKind::Convention, "convention.hand");
    check(|w| w.convention_winding = u32::MAX, ErrorKind::Convention, "convention.winding");
    check(|w| w.convention_meters_per_unit = -0.01, ErrorKind::Convention, "convention.meters_per_unit");
    check(|w| w.convention_meters_per_unit = f64::NAN, ErrorKind::Convention, "convention.meters_per_unit");
    check(|w| w.convention_meters_per_unit = 1e-9, ErrorKind::Convention, "convention.meters_per_unit");
    check(|w| w.fragment = 3, ErrorKind::UnknownFragment, "3");
    check(|w| w.keep = 2, ErrorKind::ReservedField, "keep");
    check(|w| w.reserved[5] = 1, ErrorKind::ReservedField, "reserved[5]");
    check(|w| w.object_length = 65, ErrorKind::ObjectName, "object");
    check(|w| w.object[0] = 0xff, ErrorKind::ObjectName, "object");
    check(|w| w.object_length = 0, ErrorKind::ObjectName, "");
}

#[test]
fn an_explicit_zero_is_rejected() {
    let kind = |strike: Request| strike.wire([0; 16]).unwrap_err().kind;
    assert_eq!(kind(Request { gamma_j_m2: Some(0.0), ..strike() }), ErrorKind::Gamma);
    assert_eq!(kind(Request { degree: DegreeRule::Sites(0), ..strike() }), ErrorKind::Degree);
    assert_eq!(kind(Request { error_max: Some(0.0), ..strike() }), ErrorKind::Budget);
    assert_eq!(kind(Request { time_ms_max: Some(0.0), ..strike() }), ErrorKind::Budget);
    assert_eq!(kind(Request { iterations_max: Some(u32::MAX), ..strike() }), ErrorKind::Budget);
    assert_eq!(Quality::by_name("fine").unwrap_err().at, "quality");
    assert_eq!(kind(Request { contacts: vec![], ..strike() }), ErrorKind::ContactCount);
    let unit = Convention { meters_per_unit: 0.0, ..Convention::UNREAL };
    assert_eq!(kind(Request { convention: unit, ..strike() }), ErrorKind::Convention);
    let mut zero = strike();
    zero.contacts[1].radius_m = Some(0.0);
    assert_eq!(kind(zero), ErrorKind::ContactRadius);
}

proptest! {
    #[test]
    fn random_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), size_of::<RequestWire>())) {
        let wire: RequestWire = bytemuck::pod_read_unaligned(&bytes);
        prop_assert!(wire.validate().is_err());
    }

    /// One changed byte: either refused, or a request that writes back without loss.
    #[test]
    fn mutated_bytes_never_panic(at in 0..size_of::<RequestWire>(), value in any::<u8>()) {
        let mut bytes = bytemuck::bytes_of(&wire()).to_vec();
        bytes[at] = value;
        let wire: RequestWire = bytemuck::pod_read_unaligned(&bytes);
        if let Ok(strike) = wire.validate() {
            let again = RequestWire { sequence: wire.sequence, ..strike.wire(wire.listener).unwrap() };
            prop_assert_eq!(again.validate().unwrap(), strike);
        }
    }
}
