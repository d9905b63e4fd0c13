use super::*;
use nalgebra::{Rotation3, Vector3};

const BALL: ContactBody = ContactBody { material: ElasticMaterial::STEEL, mass_kg: 0.033, radius_m: 0.01 };
const CERAMIC: ElasticMaterial = ElasticMaterial { young_pa: 70e9, poisson: 0.2 };
const VASE: ContactBody = ContactBody { material: CERAMIC, mass_kg: 1.2, radius_m: 0.08 };

#[track_caller]
fn check(what: &str, found: f64, expected: f64, error: f64) {
    let off = (found / expected - 1.0).abs();
    assert!(off <= error, "{what}: {found:e} instead of {expected:e}, off by {off:.1e}");
}

fn hertz(one: &ContactBody, other: &ContactBody, speed_m_s: f64) -> HertzContact {
    HertzContact::of(one, other, speed_m_s).unwrap()
}

/// Twice the integral of (1 − x^(5/2))^(-1/2) from 0 to 1, with x = 1 − s², which removes the singularity; midpoint rule.
fn duration_by_quadrature() -> f64 {
    let steps = 20_000;
    let at = |k: u32| (f64::from(k) + 0.5) / f64::from(steps);
    let value = |s: f64| 2.0 * s / (1.0 - (1.0 - s * s).powf(2.5)).sqrt();
    2.0 * (0..steps).map(|k| value(at(k))).sum::<f64>() / f64::from(steps)
}

#[test]
fn the_duration_is_that_of_the_equation_of_motion() {
    check("quadrature", duration_by_quadrature(), DURATION, 1e-8);
    check("Johnson's 2.87", DURATION * (15.0_f64 / 16.0).powf(0.4), 2.87, 1e-3);
}

#[test]
fn a_steel_ball_on_steel_is_as_calculated_by_hand() {
    // E* = 210e9 / (2 · 0.91) = 115.385 GPa, R = 0.01 m, m* = 0.033 kg, v = 1 m/s:
    // δ^(5/2) = 15 · 0.033 / (16 · 115.385e9 · 0.1) = 2.6813e-12.
    let found = hertz(&BALL, &ContactBody::ground(ElasticMaterial::STEEL), 1.0);
    check("approach", found.approach_m, 2.3514e-5, 1e-4);
    check("radius", found.radius_m, 4.849e-4, 1e-4);
    check("force", found.force_n, 1754.0, 1e-3);
    let johnson = 2.87 * (0.033_f64.powi(2) / (0.01 * 115.385e9_f64.powi(2))).powf(0.2);
    check("duration", found.duration_s, johnson, 1e-3);
    // The work of the contact force is the initial energy: 2/5 F δ = ½ m* v².
    check("energy", 0.4 * found.force_n * found.approach_m, 0.5 * 0.033, 1e-12);
}

#[test]
fn the_force_is_that_of_a_ball_pressed_on() {
    // Johnson's a³ = 3 F R / (4 E*).
    let found = hertz(&BALL, &VASE, 2.5);
    let modulus_pa = 1.0 / (0.91 / 210e9 + 0.96 / 70e9);
    let radius_m = 1.0 / (1.0 / 0.01 + 1.0 / 0.08);
    check("radius", found.radius_m.powi(3), 3.0 * found.force_n * radius_m / (4.0 * modulus_pa), 1e-12);
}

#[test]
fn scaling_exponents_match_hertz_theory() {
    let (slow, fast) = (hertz(&BALL, &VASE, 0.5), hertz(&BALL, &VASE, 8.0));
    let exponent = |a: f64, b: f64| (b / a).ln() / 16.0_f64.ln();
    check("duration", exponent(slow.duration_s, fast.duration_s), -0.2, 1e-12);
    check("radius", exponent(slow.radius_m, fast.radius_m), 0.4, 1e-12);
    check("approach", exponent(slow.approach_m, fast.approach_m), 0.8, 1e-12);
    check("force", exponent(slow.force_n, fast.force_n), 1.2, 1e-12);
    let stiff = ContactBody { material: ElasticMaterial { young_pa: 70e9 * 32.0, ..CERAMIC }, ..VASE };
    let ball = ContactBody { material: ElasticMaterial { young_pa: 210e9 * 32.0, ..ElasticMaterial::STEEL }, ..BALL };
    check("stiffness", hertz(&ball, &stiff, 0.5).duration_s / slow.duration_s, 0.25, 1e-12);
}

#[test]
fn other_units_give_the_same_contact() {
    let (length, time, mass) = (1e2, 1e3, 7.0);
    let other = |one: &ContactBody| ContactBody {
        material: ElasticMaterial { young_pa: one.material.young_pa * mass / (length * time * time), ..one.material },
        mass_kg: one.mass_kg * mass,
        radius_m: one.radius_m * length,
    };
    let (here, there) = (hertz(&BALL, &VASE, 3.0), hertz(&other(&BALL), &other(&VASE), 3.0 * length / time));
    check("duration", there.duration_s, here.duration_s * time, 1e-12);
    check("radius", there.radius_m, here.radius_m * length, 1e-12);
    check("force", there.force_n, here.force_n * mass * length / (time * time), 1e-12);
}

#[test]
fn swapping_the_bodies_changes_nothing() {
    let (here, there) = (hertz(&BALL, &VASE, 3.0), hertz(&VASE, &BALL, 3.0));
    check("duration", there.duration_s, here.duration_s, 1e-14);
    check("radius", there.radius_m, here.radius_m, 1e-14);
}

#[test]
fn a_small_impulse_gives_the_effective_mass() {
    let floor = ContactBody::ground(ElasticMaterial::CONCRETE);
    let (central, heavy) = (hertz(&VASE, &floor, 2.0), HertzContact::of_impulse(&VASE, &floor, 2.0, 1e3).unwrap());
    assert_eq!(central, heavy, "a resting contact is no heavier than its bodies");
    let light = HertzContact::of_impulse(&VASE, &floor, 2.0, 0.1 * 2.4).unwrap();
    check("a tenth of the mass", light.duration_s / central.duration_s, 0.1_f64.powf(0.4), 1e-12);
}

#[test]
fn contacts_without_finite_curvature_are_rejected() {
    let floor = ContactBody::ground(ElasticMaterial::CONCRETE);
    let refused = |one: ContactBody, other: ContactBody, speed| HertzContact::of(&one, &other, speed).unwrap_err();
    assert_eq!(refused(floor, floor, 1.0), ContactError::NoMass);
    let slab = ContactBody { mass_kg: 3.0, ..floor };
    assert_eq!(refused(slab, floor, 1.0), ContactError::NoPoint(f64::INFINITY, f64::INFINITY));
    let bowl = ContactBody { radius_m: -0.01, ..VASE };
    assert_eq!(refused(bowl, BALL, 1.0), ContactError::NoPoint(-0.01, 0.01));
    for speed in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(refused(BALL, VASE, speed), ContactError::NotPositive { key: "speed_m_s", .. }));
    }
    assert!(matches!(refused(ContactBody { mass_kg: 0.0, ..BALL }, VASE, 1.0), ContactError::NotPositive { .. }));
    let odd = ElasticMaterial { poisson: 0.7, ..CERAMIC };
    assert_eq!(refused(ContactBody { material: odd, ..BALL }, VASE, 1.0), ContactError::Poisson(0.7));
    for speed in [1e308, 5e-324, 1e-300] {
        assert!(matches!(refused(BALL, VASE, speed), ContactError::Range { .. }), "{speed}");
    }
    let soft = ElasticMaterial { young_pa: 5e-324, ..BALL.material };
    assert!(matches!(refused(ContactBody { material: soft, ..BALL }, VASE, 1.0), ContactError::Range { .. }));
    assert!(HertzContact::of(&BALL, &ContactBody { radius_m: -0.02, ..VASE }, 1.0).is_ok(), "a ball in a wider bowl");
}

fn touch(point_m: [f64; 3], impulse_ns: [f64; 3]) -> ContactEvent {
    ContactEvent { point_m, impulse_ns, speed_m_s: 3.0, other: BALL }
}

/// Contacts of the impact that one step of these contacts makes.
fn merged_contacts(touches: &[ContactEvent], terms: ContactPolicy) -> Vec<MergedContact> {
    let mut contacts = ContactCollector::default();
    contacts.watch(1, terms);
    touches.iter().for_each(|touch| contacts.touch(&1, *touch));
    contacts.step(0.0).pop().map_or(Vec::new(), |(_, merged_contacts)| merged_contacts.unwrap())
}

/// Error of a step of these contacts, which makes no impact.
fn lost(touches: &[ContactEvent], terms: ContactPolicy) -> ImpulseLost {
    let mut contacts = ContactCollector::default();
    contacts.watch(1, terms.cooldown(1.0));
    let mut step = || {
        touches.iter().for_each(|touch| contacts.touch(&1, *touch));
        contacts.step(0.0).pop().unwrap().1.unwrap_err()
    };
    let first = step();
    assert_eq!(step(), first, "a body that was not struck does not cool down");
    first
}

#[test]
fn canceled_impulses_are_reported_with_their_size() {
    let face = ContactBody { radius_m: f64::INFINITY, ..VASE };
    let floor = ContactBody::ground(ElasticMaterial::CONCRETE);
    let corner = |x: f64| ContactEvent { other: floor, ..touch([x, 0.0, 0.0], [0.0, 0.9, 0.0]) };
    let flat = lost(&[corner(0.0), corner(0.1)], ContactPolicy::new(face));
    assert_eq!((flat.given_ns, flat.kept_ns), (1.8, 0.0));
    assert_eq!(flat.cause, Some(ContactError::NoPoint(f64::INFINITY, f64::INFINITY)));
    assert!(flat.to_string().contains("1.8 N·s") && flat.to_string().contains("ContactPolicy::radius"), "{flat}");
    let cancel =
        lost(&[touch([0.0; 3], [1.0, 0.0, 0.0]), touch([0.0; 3], [-0.75, 0.0, 0.0])], ContactPolicy::new(VASE));
    assert_eq!((cancel.given_ns, cancel.kept_ns, cancel.cause), (1.75, 0.25, None));
    let ball = ContactEvent { impulse_ns: [1.9, 0.0, 0.0], ..corner(0.0) };
    let mostly = merged_contacts(&[ContactEvent { other: BALL, ..ball }, corner(0.1)], ContactPolicy::new(face));
    assert_eq!(mostly.len(), 1, "less than half is lost");
}

#[test]
fn merging_many_contacts_conserves_the_impulse() {
    let all: Vec<ContactEvent> =
        (0..1000).map(|k| touch([f64::from(k), 0.0, 0.0], [0.0, 1.0 + f64::from(k % 7), 0.0])).collect();
    let given: f64 = all.iter().map(|touch| touch.impulse_ns[1]).sum();
    let sent: f64 =
        merged_contacts(&all, ContactPolicy::new(VASE)).iter().map(|merged_contact| merged_contact.impulse_ns[1]).sum();
    check("impulse", sent, given, 1e-9);
}

#[test]
fn near_contacts_merge_weighted_by_impulse() {
    let all = [
        touch([0.0, 0.0, 0.0], [3.0, 0.0, 0.0]),
        touch([0.004, 0.0, 0.0], [0.0, 1.0, 0.0]),
        touch([0.5, 0.0, 0.0], [0.0, 0.0, 2.0]),
    ];
    let found = merged_contacts(&all, ContactPolicy::new(VASE).merge(0.01));
    assert_eq!(found.len(), 2);
    check("place", found[0].point_m[0], 0.001, 1e-12);
    assert_eq!((found[0].impulse_ns, found[1].impulse_ns), ([3.0, 1.0, 0.0], [0.0, 0.0, 2.0]));
    assert_eq!(merged_contacts(&all, ContactPolicy::new(VASE).merge(0.0)).len(), 3);
}

#[test]
fn the_impulse_of_a_resting_face_is_the_weight() {
    // Four corners of a face that together stop the whole vase.
    let corner = |x: f64, z: f64| ContactEvent {
        other: ContactBody::ground(ElasticMaterial::CONCRETE),
        ..touch([x, 0.0, z], [0.0, 0.9, 0.0])
    };
    let all = [corner(0.0, 0.0), corner(0.002, 0.0), corner(0.0, 0.002), corner(0.002, 0.002)];
    let found = merged_contacts(&all, ContactPolicy::new(VASE).merge(0.01));
    assert_eq!(found.len(), 1);
    let whole = hertz(&VASE, &ContactBody::ground(ElasticMaterial::CONCRETE), 3.0);
    check("duration", found[0].hertz.duration_s, whole.duration_s, 1e-12);
}

#[test]
fn only_the_strongest_contacts_are_kept() {
    let all: Vec<ContactEvent> =
        (0..500).map(|k| touch([f64::from(k), 0.0, 0.0], [0.0, 1.0 + f64::from(k % 7), 0.0])).collect();
    let found = merged_contacts(&all, ContactPolicy::new(VASE).merge(0.01));
    assert_eq!(found.len(), CONTACTS_MAX);
    assert!(found.windows(2).all(|pair| pair[0].impulse_ns[1] >= pair[1].impulse_ns[1]), "{found:?}");
    let few: Vec<ContactEvent> = all.into_iter().take(100).collect();
    let given: f64 = few.iter().map(|touch| touch.impulse_ns[1]).sum();
    let sent: f64 =
        merged_contacts(&few, ContactPolicy::new(VASE)).iter().map(|merged_contact| merged_contact.impulse_ns[1]).sum();
    check("impulse", sent, given, 1e-12);
}

#[test]
fn rotating_the_scene_rotates_the_contacts() {
    let turn = Rotation3::from_euler_angles(0.3, -1.1, 2.2);
    let turned = |vector: [f64; 3]| -> [f64; 3] { (turn * Vector3::from(vector)).into() };
    let all: Vec<ContactEvent> = (0..40)
        .map(f64::from)
        .map(|k| touch([(1.7 * k).sin(), (2.3 * k).cos(), 0.1 * k], [k.cos(), 1.0 + k.sin(), 0.3]))
        .collect();
    let other: Vec<ContactEvent> = all
        .iter()
        .map(|touch| ContactEvent { point_m: turned(touch.point_m), impulse_ns: turned(touch.impulse_ns), ..*touch })
        .rev()
        .collect();
    let (here, there) =
        (merged_contacts(&all, ContactPolicy::new(VASE)), merged_contacts(&other, ContactPolicy::new(VASE)));
    assert_eq!(here.len(), there.len());
    for (a, b) in here.iter().zip(&there) {
        let off = |x: [f64; 3], y: [f64; 3]| (Vector3::from(turned(x)) - Vector3::from(y)).norm();
        assert!(off(a.point_m, b.point_m) < 1e-12 && off(a.impulse_ns, b.impulse_ns) < 1e-12);
        check("duration", b.hertz.duration_s, a.hertz.duration_s, 1e-12);
    }
}

#[test]
fn weak_slow_and_invalid_contacts_are_ignored() {
    let (sound, terms) = (touch([0.0; 3], [1.0, 0.0, 0.0]), ContactPolicy::new(VASE));
    assert_eq!(merged_contacts(&[sound], terms).len(), 1);
    assert!(merged_contacts(&[sound], terms.impulse_min(1.001)).is_empty());
    assert_eq!(merged_contacts(&[sound, touch([9.0; 3], [0.0, 0.01, 0.0])], terms.impulse_min(1.001)).len(), 2);
    assert!(merged_contacts(&[sound], terms.speed_min(3.1)).is_empty());
    for odd in [
        touch([f64::NAN; 3], [1.0; 3]),
        touch([0.0; 3], [f64::INFINITY; 3]),
        touch([0.0; 3], [0.0; 3]),
        ContactEvent { speed_m_s: f64::NAN, ..sound },
    ] {
        assert!(merged_contacts(&[odd], terms).is_empty());
    }
}

#[test]
fn a_struck_body_has_its_own_cooldown() {
    let mut contacts = ContactCollector::default();
    contacts.watch("a", ContactPolicy::new(VASE).cooldown(0.5));
    contacts.watch("b", ContactPolicy::new(VASE));
    let mut step = |now_s: f64| {
        ["a", "b", "unwatched"].iter().for_each(|body| contacts.touch(body, touch([0.0; 3], [1.0, 0.0, 0.0])));
        contacts.step(now_s).iter().map(|(body, _)| *body).collect::<String>()
    };
    let struck: Vec<String> = [0.0, 0.4, 0.5, 0.9, 0.2].into_iter().map(&mut step).collect();
    assert_eq!(struck, ["ab", "b", "ab", "b", "ab"], "a simulation set back to 0.2 does not wait");
    assert!(contacts.step(9.0).is_empty(), "contacts are those of one step");
    contacts.forget(&"a");
    contacts.touch(&"a", touch([0.0; 3], [1.0, 0.0, 0.0]));
    assert!(contacts.step(10.0).is_empty() && contacts.terms(&"a").is_none());
}
