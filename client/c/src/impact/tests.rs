use super::*;
use shatter_client::Error;

/// The value of `ShatterContact contact = {0};` in C.
const NOWHERE: Contact = Contact {
    point_m: [0.0; 3],
    impulse_ns: [0.0; 3],
    duration_s: 0.0,
    radius_m: 0.0,
    ray: [0.0; 3],
    partner: 0,
    partner_mass_kg: 0.0,
    speed_m_s: 0.0,
    partner_center_m: [0.0; 3],
    partner_inertia_kg_m2: [0.0; 6],
};

const CONTACTS: [Contact; 2] = [
    Contact { point_m: [0.1, 0.2, 0.3], impulse_ns: [-1.0, 0.0, 0.5], ..NOWHERE },
    Contact { point_m: [0.4, 0.5, 0.6], impulse_ns: [0.0, 2.0, 0.0], duration_s: 0.001, radius_m: 0.02, ..NOWHERE },
];

/// The value of `ShatterImpact impact = {0};` in C, with some contacts.
fn zero(contact_count: usize) -> Impact {
    // SAFETY: all fields are numbers and a pointer, for which zero is a value.
    let impact: Impact = unsafe { std::mem::MaybeUninit::zeroed().assume_init() };
    Impact { contacts: CONTACTS.as_ptr(), contact_count, ..impact }
}

fn read(impact: Impact) -> Result<shatter_client::Impact, Failure> {
    // SAFETY: no test passes a larger count than there are contacts.
    unsafe { impact.read() }
}

#[track_caller]
fn refused(impact: Impact) -> Error {
    match read(impact) {
        Err(Failure::Refused(error)) => error,
        other => panic!("it was to be refused: {other:?}"),
    }
}

#[test]
fn zero_is_the_default_of_everything_but_the_contacts() {
    let first = shatter_client::Contact::new([0.1, 0.2, 0.3]).impulse([-1.0, 0.0, 0.5]);
    assert_eq!(read(zero(1)).unwrap(), shatter_client::Impact::new([first]));
    let second = shatter_client::Contact::new([0.4, 0.5, 0.6]).impulse([0.0, 2.0, 0.0]).duration(0.001).radius(0.02);
    assert_eq!(read(zero(2)).unwrap(), shatter_client::Impact::new([first, second]));
}

#[test]
fn partners_reach_the_client() {
    let read = |contact: Contact| shatter_client::Contact::from(&contact).partner;
    assert_eq!(read(CONTACTS[1]), None);
    let (center_m, inertia_kg_m2) = ([0.1, 0.2, 0.3], [1.0, 2.0, 3.0, 0.1, 0.2, 0.3]);
    let own = Contact { partner: 7, partner_mass_kg: f64::INFINITY, speed_m_s: -2.0, ..CONTACTS[0] };
    let own = Contact { partner_center_m: center_m, partner_inertia_kg_m2: inertia_kg_m2, ..own };
    let wanted = ContactPartner::new(7, f64::INFINITY, -2.0).rotating(center_m, inertia_kg_m2);
    assert_eq!(read(own), Some(wanted));
    // The client refuses a speed alone, for its mass.
    let alone = Contact { speed_m_s: 1.0, ..CONTACTS[0] };
    assert_eq!(read(alone), Some(ContactPartner::new(0, 0.0, 1.0)));
}

#[test]
fn every_field_reaches_the_client() {
    let base = read(zero(1)).unwrap();
    let check = |impact: Impact, wanted: shatter_client::Impact| {
        assert_eq!(read(impact).unwrap(), wanted);
        assert_ne!(wanted, base, "the field makes a difference");
    };
    let say = || base.clone();
    check(Impact { purpose: 1, ..zero(1) }, say().threshold_only());
    for (degree, wanted) in [
        (Degree::ClosedForm, shatter_client::DegreeRule::ClosedForm),
        (Degree::Optimized, shatter_client::DegreeRule::Optimized),
        (Degree::Verified, shatter_client::DegreeRule::Verified),
        (Degree::Inferred, shatter_client::DegreeRule::Inferred),
    ] {
        check(Impact { degree: degree as u32, ..zero(1) }, say().degree(wanted));
    }
    check(Impact { degree: 3, degree_sites: 7, ..zero(1) }, say().degree(shatter_client::DegreeRule::Sites(7)));
    for (lift, wanted) in [
        (Lift::Euclidean, shatter_client::Lift::Euclidean),
        (Lift::Interior, shatter_client::Lift::Interior),
        (Lift::SurfaceDiffusion, shatter_client::Lift::SurfaceDiffusion),
    ] {
        check(Impact { lift: lift as u32, ..zero(1) }, say().lift(wanted));
    }
    check(Impact { elastic: 1, ..zero(1) }, say().elastic(shatter_client::DisplacementSource::Solve));
    check(Impact { elastic: 2, ..zero(1) }, say().elastic(shatter_client::DisplacementSource::Reduced));
    let strength = shatter_client::RequestedCriterion::Strength;
    check(Impact { criterion: 2, ..zero(1) }, say().criterion(strength));
    check(Impact { surface: 1, ..zero(1) }, say().surface(shatter_client::RequestedSurface::Lattice));
    for (i, quality) in shatter_client::Quality::ALL.into_iter().enumerate() {
        check(Impact { quality: 1 + i as u32, ..zero(1) }, say().quality(quality));
    }
    check(Impact { iterations_max: 9, ..zero(1) }, say().iterations(9));
    check(Impact { iterations_max: NO_ITERATIONS, ..zero(1) }, say().iterations(0));
    check(Impact { fragments_max: 5, ..zero(1) }, say().fragments_max(5));
    check(Impact { bytes_max: 6, ..zero(1) }, say().bytes_max(6));
    check(Impact { gamma_j_m2: 1.5, ..zero(1) }, say().gamma(1.5));
    check(Impact { error_max: 0.1, ..zero(1) }, say().error(0.1));
    check(Impact { time_ms_max: 8.0, ..zero(1) }, say().time_ms(8.0));
    check(Impact { deadline_ms: 16.5, ..zero(1) }, say().deadline(Duration::from_micros(16_500)));
    check(Impact { seed: 3, ..zero(1) }, say().seed(3));
    check(Impact { from_handle: 4, from_fragment: 2, ..zero(1) }, say().from(4, 2));
    check(Impact { keep: true, ..zero(1) }, say().keep());
}

#[test]
fn effects_have_the_bits_of_the_client() {
    let bits = [
        Effect::Elastic,
        Effect::Tensile,
        Effect::Interior,
        Effect::Examples,
        Effect::Slivers,
        Effect::Release,
        Effect::Normals,
        Effect::Uv,
        Effect::Bonds,
        Effect::Debris,
        Effect::Hulls,
        Effect::Warp,
        Effect::Anchored,
        Effect::Gravity,
        Effect::Attributes,
        Effect::Skin,
        Effect::Dynamics,
    ];
    let base = read(zero(1)).unwrap();
    for (own, theirs) in bits.into_iter().zip(shatter_client::Effect::ALL) {
        assert_eq!((u64::from(own as u32), format!("{own:?}")), (theirs.bit(), format!("{theirs:?}")));
        assert_eq!(read(Impact { enable: theirs.bit(), ..zero(1) }).unwrap(), base.clone().enable(theirs));
        assert_eq!(read(Impact { disable: theirs.bit(), ..zero(1) }).unwrap(), base.clone().disable(theirs));
    }
    assert_eq!(bits.len(), shatter_client::Effect::ALL.len());
}

#[test]
fn invalid_values_are_rejected_by_name() {
    assert_eq!(refused(zero(0)).kind, ErrorKind::ContactCount);
    assert_eq!(refused(zero(9)).kind, ErrorKind::ContactCount);
    assert_eq!(refused(zero(usize::MAX)).kind, ErrorKind::ContactCount);
    assert_eq!(refused(Impact { purpose: 2, ..zero(1) }).kind, ErrorKind::UnknownRequest);
    assert_eq!(refused(Impact { degree: 6, ..zero(1) }).at, "impact.degree");
    assert_eq!(refused(Impact { degree_sites: 1, ..zero(1) }).at, "impact.degree_sites");
    assert_eq!(refused(Impact { lift: 4, ..zero(1) }).kind, ErrorKind::Lift);
    assert_eq!(refused(Impact { elastic: 3, ..zero(1) }).kind, ErrorKind::Elastic);
    assert_eq!(refused(Impact { quality: 5, ..zero(1) }).kind, ErrorKind::Budget);
    assert_eq!(refused(Impact { enable: 1 << 17, ..zero(1) }).kind, ErrorKind::UnknownEffect);
    assert_eq!(refused(Impact { disable: 1 << 63, ..zero(1) }).at, "63");
    assert_eq!(refused(Impact { from_fragment: 1, ..zero(1) }).kind, ErrorKind::UnknownFragment);
    assert_eq!(refused(Impact { reserved: [0, 0, 0, 0, 0, 0, 0, 1], ..zero(1) }).kind, ErrorKind::ReservedField);
    for wrong in [
        Impact { contacts: std::ptr::null(), ..zero(1) },
        Impact { contacts: CONTACTS.as_ptr().cast::<u8>().wrapping_add(1).cast(), ..zero(1) },
        Impact { deadline_ms: -1.0, ..zero(1) },
        Impact { deadline_ms: f64::NAN, ..zero(1) },
        Impact { deadline_ms: f64::INFINITY, ..zero(1) },
    ] {
        assert!(matches!(read(wrong), Err(Failure::Argument { .. })), "{wrong:?}");
    }
}
