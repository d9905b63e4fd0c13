//! Energies of impacts against closed forms, and loads that they limit.

use super::*;
use crate::cancel_token::CancelToken;
use crate::database::BakeRequest;
use crate::pipeline::stages::contact_set::ContactSet;
use crate::pipeline::{
    DegreeRequest, ElementChoice, FractureError, FractureOutcome, FractureRequest, ImpactContact, Preset,
    RequestContext, Workspace, strike_again,
};
use crate::random::RandomStream;
use crate::scene::{Anchors, Material, Region};
use crate::strength::Criterion;
use crate::surface::{RawMesh, shapes};
use std::sync::LazyLock;

/// Sides of the bar, m.
const SIDES_M: [f64; 3] = [0.4, 0.08, 0.08];

const DENSITY_KG_M3: f64 = 2500.0;

fn baked(mesh: RawMesh, examples: u64) -> PreparedObject {
    let request = BakeRequest {
        quality: Preset::Draft,
        elastic_spacing: Some(0.05),
        crack_spacing: Some(0.05),
        examples,
        elements: ElementChoice::Linear,
        ..BakeRequest::new("bar", "glass", Material::named("glass").unwrap())
    };
    let mut object = request.bake(mesh).unwrap();
    object.parameters.material.density_kg_m3 = DENSITY_KG_M3;
    object
}

static BAR: LazyLock<PreparedObject> = LazyLock::new(|| baked(shapes::cuboid(SIDES_M), 12));

/// The bar, held at its left end.
static HELD: LazyLock<PreparedObject> = LazyLock::new(|| {
    let mut bar = baked(shapes::cuboid(SIDES_M), 0);
    let region = Region::Cuboid { min_m: Point3::new(-1.0, -1.0, -1.0), max_m: Point3::new(-0.15, 1.0, 1.0) };
    let anchors = Anchors { regions: vec![region], gravity_m_s2: None };
    bar.anchor(&anchors, &CancelToken::default()).unwrap();
    bar
});

/// The bar and another, twice as long, above it.
static PAIR: LazyLock<PreparedObject> = LazyLock::new(|| {
    let [mut mesh, other] = [SIDES_M, [0.8, 0.08, 0.08]].map(shapes::cuboid);
    let count = mesh.positions_m.len() as u32;
    mesh.positions_m.extend(other.positions_m.iter().map(|point| point + Vector3::new(0.0, 0.2, 0.0)));
    mesh.triangles.extend(other.triangles.iter().map(|corners| corners.map(|corner| corner + count)));
    baked(RawMesh::new(mesh.positions_m, mesh.triangles), 0)
});

fn mass_kg() -> f64 {
    DENSITY_KG_M3 * SIDES_M.iter().product::<f64>()
}

/// A partner that does not rotate.
fn partner(id: u64, mass_kg: f64, speed_m_s: f64) -> ImpactPartner {
    ImpactPartner { id, mass_kg, center_m: Point3::origin(), inertia_kg_m2: [0.0; 6], speed_m_s }
}

fn hit(point_m: [f64; 3], impulse_ns: [f64; 3], partner: ImpactPartner) -> ImpactContact {
    let (point_m, impulse_ns) = (point_m.into(), impulse_ns.into());
    ImpactContact { point_m, impulse_ns, duration_s: Some(1e-3), radius_m: None, partner: Some(partner) }
}

fn struck(contacts: Vec<ImpactContact>) -> FractureRequest {
    let base = FractureRequest::at(Point3::origin(), Vector3::y());
    let effects = base.effects.with(EffectKind::Anchored);
    FractureRequest { contacts, effects, criterion: Criterion::Strength, ..base }
}

/// The same request without anchors, which free objects do not have.
fn free(contacts: Vec<ImpactContact>) -> FractureRequest {
    let request = struck(contacts);
    FractureRequest { effects: request.effects.without(EffectKind::Anchored), ..request }
}

fn found(object: &PreparedObject, request: &FractureRequest) -> Result<f64, PartnerError> {
    let contacts = ContactSet::new(object, request).unwrap();
    impactor_energy_j(object, request, &contacts).map(Option::unwrap)
}

#[track_caller]
fn check(object: &PreparedObject, contacts: Vec<ImpactContact>, expected_j: f64) {
    let energy_j = found(object, &free(contacts)).unwrap();
    assert!((energy_j - expected_j).abs() <= 1e-9 * expected_j, "{energy_j} of {expected_j} J");
}

const END_M: [f64; 3] = [-0.2, 0.0, 0.0];
const ALONG_X: [f64; 3] = [3.0, 0.0, 0.0];
const DOWN: [f64; 3] = [0.0, 0.0, -2.0];

#[test]
fn a_central_impact_has_the_energy_of_the_reduced_mass() {
    let (mass_kg, speed) = (mass_kg(), 7.0);
    let reduced = |own: f64| 0.5 * speed * speed / (1.0 / mass_kg + 1.0 / own);
    for own in [0.01, 5.0, f64::INFINITY] {
        check(&BAR, vec![hit(END_M, ALONG_X, partner(1, own, speed))], reduced(own));
    }
    // Contacts that separate or slide bring nothing, alone and beside others.
    for other in [0.0, -speed] {
        check(&BAR, vec![hit(END_M, ALONG_X, partner(1, 5.0, other))], 0.0);
    }
    let apart = hit([0.0, 0.0, 0.04], DOWN, partner(2, 5.0, -speed));
    check(&BAR, vec![hit(END_M, ALONG_X, partner(1, 5.0, speed)), apart], reduced(5.0));
}

/// 1/m_eff = 1/M + x²/I + 1/m (P. A. Engel, *Impact Wear of Materials*, 1976, or any text on rigid bodies).
#[test]
fn an_eccentric_impact_turns_a_rod() {
    let (mass_kg, speed, own) = (mass_kg(), 4.0, 0.5);
    let inertia = mass_kg * (SIDES_M[0].powi(2) + SIDES_M[2].powi(2)) / 12.0;
    for x in [0.0, 0.07, -0.19] {
        let inverse = 1.0 / mass_kg + x * x / inertia + 1.0 / own;
        check(&BAR, vec![hit([x, 0.0, 0.04], DOWN, partner(1, own, speed))], 0.5 * speed * speed / inverse);
    }
}

#[test]
fn a_partner_counts_once_and_two_add() {
    let (mass_kg, speed, own) = (mass_kg(), 4.0, 0.5);
    let with = |mass: f64| 0.5 * speed * speed / (1.0 / mass_kg + 1.0 / mass);
    let same = hit(END_M, ALONG_X, partner(1, own, speed));
    check(&BAR, vec![same, same], with(own));
    check(&BAR, vec![same; 8], with(own));
    let other = hit(END_M, ALONG_X, partner(2, own, speed));
    check(&BAR, vec![same, other], with(2.0 * own));
    // From both sides, the bar stays where it is.
    let opposite = hit([0.2, 0.0, 0.0], [-1.0, 0.0, 0.0], partner(2, own, speed));
    check(&BAR, vec![same, opposite], 2.0 * 0.5 * own * speed * speed);
}

#[test]
fn a_partner_that_rotates_is_lighter() {
    let (mass_kg, speed, own) = (mass_kg(), 4.0, 0.5);
    let [xx, yy, zz, xy, xz, yz] = [3e-3, 4e-3, 5e-3, 1e-3, -5e-4, 7e-4];
    let center_m = Point3::new(0.03, -0.02, 0.3);
    let turning = ImpactPartner { center_m, inertia_kg_m2: [xx, yy, zz, xy, xz, yz], ..partner(1, own, speed) };
    let lever = (Point3::new(0.0, 0.0, 0.04) - center_m).cross(&-Vector3::z());
    let inertia = Matrix3::from_columns(&[[xx, xy, xz].into(), [xy, yy, yz].into(), [xz, yz, zz].into()]);
    let inverse = 1.0 / mass_kg + 1.0 / own + lever.dot(&(inertia.try_inverse().unwrap() * lever));
    check(&BAR, vec![hit([0.0, 0.0, 0.04], DOWN, turning)], 0.5 * speed * speed / inverse);
}

#[test]
fn anchors_take_the_place_of_a_mass() {
    let tip = |own| struck(vec![hit([0.15, 0.0, 0.04], DOWN, partner(1, own, 4.0))]);
    assert!((found(&HELD, &tip(0.5)).unwrap() / 4.0 - 1.0).abs() < 1e-12);
    let error = found(&HELD, &tip(f64::INFINITY)).unwrap_err();
    assert_eq!(error, PartnerError::Immovable { contacts: vec![0] });
    // The effect decides, not the anchors.
    let request = free(tip(f64::INFINITY).contacts);
    assert!(found(&HELD, &request).unwrap() > 0.0);
}

#[test]
fn bodies_of_one_object_move_on_their_own() {
    let (mass_kg, speed, own) = (mass_kg(), 4.0, 0.5);
    assert_eq!(PAIR.bodies.len(), 2);
    let both = |second: u64| {
        let first = hit([-0.2, 0.0, 0.0], ALONG_X, partner(1, own, speed));
        vec![first, hit([-0.4, 0.2, 0.0], ALONG_X, partner(second, own, speed))]
    };
    let reduced = |mass: f64| 0.5 * speed * speed / (1.0 / own + 1.0 / mass);
    check(&PAIR, both(1), reduced(3.0 * mass_kg));
    check(&PAIR, both(2), reduced(mass_kg) + reduced(2.0 * mass_kg));
}

/// No pushing impulses take more, and some of the speeds need a contact to be left out.
#[test]
fn no_other_impulses_take_more_energy() {
    let mut stream = RandomStream::new(11, 0);
    let mut signed = move || 2.0 * stream.uniform() - 1.0;
    let mut partial = 0;
    for _ in 0..200 {
        let count = 4;
        let root = DMatrix::from_fn(count, count, |_, _| signed());
        let inverse_masses = &root * root.transpose() + DMatrix::identity(count, count) * 0.05;
        let speeds = DVector::from_fn(count, |_, _| signed());
        let energy_j = energy_j(&inverse_masses, &speeds);
        let whole = 0.5 * speeds.dot(&(inverse_masses.clone().try_inverse().unwrap() * &speeds));
        assert!((0.0..=whole * (1.0 + 1e-6)).contains(&energy_j), "{energy_j} of {whole}");
        partial += u32::from(energy_j < 0.999 * whole);
        // Each impulse in turn takes what it can, until none takes more.
        let mut impulses = DVector::zeros(count);
        for turn in 0..20_000 {
            let own = turn % count;
            let rest = speeds[own] - (inverse_masses.row(own) * &impulses)[0];
            impulses[own] = f64::max(impulses[own] + rest / inverse_masses[(own, own)], 0.0);
        }
        let taken = speeds.dot(&impulses) - 0.5 * impulses.dot(&(&inverse_masses * &impulses));
        assert!(taken <= energy_j * (1.0 + 1e-9) && taken >= 0.99 * energy_j, "{taken} of {energy_j}");
    }
    assert!((100..200).contains(&partial), "{partial}");
}

/// The limit of dependent contacts, [`DEPENDENT`].
#[test]
fn rounded_speeds_change_little() {
    let mut worst: f64 = 0.0;
    for quarters in 4..44 {
        let apart = 0.1_f64.powf(0.25 * f64::from(quarters));
        let turning =
            |speed| ImpactPartner { inertia_kg_m2: [1e-3, 1e-3, 1e-3, 0.0, 0.0, 0.0], ..partner(1, 0.5, speed) };
        let energies = [0.0, 1.2e-7].map(|rounding| {
            let at = |x: f64, speed: f64| hit([x, 0.0, 0.04], DOWN, turning(speed));
            found(&BAR, &free(vec![at(0.0, 3.0), at(apart, 3.0 * (1.0 + rounding))])).unwrap()
        });
        worst = worst.max((energies[1] / energies[0] - 1.0).abs());
    }
    println!("worst change: {worst:.1e}");
    assert!(worst < 1e-6, "{worst}");
}

#[test]
fn partners_that_do_not_fit_are_refused() {
    let good = partner(1, 0.5, 4.0);
    let of = |own: ImpactPartner| free(vec![hit(END_M, ALONG_X, good), hit([0.0, 0.0, 0.04], DOWN, own)]);
    let refused = |request: &FractureRequest| match BAR.strike(request).err() {
        Some(FractureError::Partner(error)) => error,
        other => panic!("{other:?}"),
    };
    for value in [0.0, -1.0, f64::NAN] {
        let error = refused(&of(ImpactPartner { mass_kg: value, ..good }));
        assert!(matches!(error, PartnerError::Mass { contact: 1, .. }), "{error}");
    }
    let infinite = Point3::new(0.0, f64::INFINITY, 0.0);
    for (own, name) in [
        (ImpactPartner { speed_m_s: f64::NAN, ..good }, "speed"),
        (ImpactPartner { center_m: infinite, ..good }, "center"),
        (ImpactPartner { inertia_kg_m2: [1.0, 1.0, f64::INFINITY, 0.0, 0.0, 0.0], ..good }, "inertia"),
    ] {
        let error = refused(&of(ImpactPartner { id: 2, ..own }));
        assert!(matches!(error, PartnerError::Number { contact: 1, key, .. } if key == name), "{error}");
    }
    for inertia_kg_m2 in
        [[1.0, 1.0, -1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0, 2.0, 0.0, 0.0], [1.0, 0.0, 1.0, 0.0, 0.0, 0.0]]
    {
        let error = refused(&of(ImpactPartner { inertia_kg_m2, ..good }));
        assert_eq!(error, PartnerError::Inertia { contact: 1 });
    }
    for (own, name) in [
        (ImpactPartner { mass_kg: 0.6, ..good }, "mass"),
        (ImpactPartner { center_m: Point3::new(0.0, 0.1, 0.0), ..good }, "center"),
        (ImpactPartner { inertia_kg_m2: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0], ..good }, "inertia"),
    ] {
        assert_eq!(refused(&of(own)), PartnerError::Differs { contacts: [0, 1], key: name });
    }
    let mut mixed = of(good);
    mixed.contacts[1].partner = None;
    assert_eq!(refused(&mixed), PartnerError::Missing { contact: 1 });
    let fast = free(vec![hit(END_M, ALONG_X, partner(1, 1.0, 1e200))]);
    assert!(matches!(refused(&fast), PartnerError::Energy(_)));
    let request = of(good);
    let with = |effect| FractureRequest { effects: request.effects.with(effect), ..request.clone() };
    assert_eq!(refused(&with(EffectKind::Gravity)), PartnerError::Gravity);
    let inelastic = FractureRequest { effects: request.effects.without(EffectKind::Elastic), ..request.clone() };
    assert_eq!(refused(&inelastic), PartnerError::Elastic);
    assert_eq!(refused(&FractureRequest { threshold_only: true, ..request }), PartnerError::Threshold);
}

/// Random impacts of up to three contacts, with partners of random masses and speeds.
fn random(stream: &mut RandomStream) -> Vec<ImpactContact> {
    let count = 1 + (3.0 * stream.uniform()) as usize;
    let mut contact = |id: usize| {
        let mut signed = || 2.0 * stream.uniform() - 1.0;
        let point_m = [0.18 * signed(), 0.03 * signed(), 0.04];
        let impulse_ns = [signed(), signed(), -3.0 - signed()];
        // The bar stores some J of these impulses.
        let (mass_kg, speed) = (10.0_f64.powf(signed()), 3.0 * signed() + 2.0);
        hit(point_m, impulse_ns.map(|x| 30.0 * x), partner(id as u64, mass_kg, speed))
    };
    (0..count).map(&mut contact).collect()
}

#[test]
fn a_bar_stores_no_more_than_strikes_it() {
    let mut stream = RandomStream::new(5, 0);
    let mut lowered = [0; 2];
    for turn in 0..60 {
        let contacts = random(&mut stream);
        let alone: Vec<_> = contacts.iter().map(|own| ImpactContact { partner: None, ..*own }).collect();
        let dynamics = |request: FractureRequest| match turn % 2 {
            0 => request,
            _ => FractureRequest { effects: request.effects.with(EffectKind::Dynamics), ..request },
        };
        let request = dynamics(free(contacts));
        let energy_j = found(&BAR, &request).unwrap();
        let [own, whole] = [request, dynamics(free(alone))].map(|own| BAR.strike(&own).unwrap().threshold().clone());
        let (strain_j, unlimited_j) = (own.strain_j.unwrap(), whole.strain_j.unwrap());
        let impactor = own.impactor.unwrap();
        let factor = impactor.load_factor.unwrap();
        assert_eq!((impactor.energy_j, whole.impactor, whole.remainder_j()), (energy_j, None, None));
        assert!(strain_j <= energy_j * (1.0 + 1e-9), "{strain_j} of {energy_j} J");
        assert!(factor < 1.0 || unlimited_j <= energy_j, "{factor}: {unlimited_j} of {energy_j} J");
        assert!((strain_j - factor * factor * unlimited_j).abs() <= 1e-12 * unlimited_j);
        assert!((own.remainder_j().unwrap() - (energy_j - strain_j)).abs() <= 1e-9 * energy_j);
        assert_eq!(own.impulse_factor, whole.impulse_factor);
        assert!((own.e1_over_gamma - factor * factor * whole.e1_over_gamma).abs() <= 1e-12 * whole.e1_over_gamma);
        let [own, whole] = [own.onset.unwrap(), whole.onset.unwrap()];
        let stress = factor * whole.stress_over_strength;
        assert!((own.stress_over_strength - stress).abs() <= 1e-12 * whole.stress_over_strength);
        let energy = factor * factor * whole.energy_over_section;
        assert!((own.energy_over_section - energy).abs() <= 1e-12 * whole.energy_over_section);
        lowered[turn % 2] += u32::from(factor < 1.0);
    }
    println!("lowered at rest and with dynamics: {lowered:?} of 30 each");
    assert!(lowered.iter().all(|count| (3..=27).contains(count)), "{lowered:?}");
}

/// A rigid ball on a stout body has the force of Hertz's theory, whatever the duration of the request makes of it.
#[test]
fn forces_on_a_stout_body_are_those_of_hertz() {
    let cube = baked(shapes::cuboid([0.2; 3]), 0);
    let Material { young_pa, poisson, .. } = cube.parameters.material;
    let modulus_pa = young_pa / (1.0 - poisson * poisson);
    let (ball_kg, radius_m) = (0.26, 0.02_f64);
    for speed_m_s in [0.5, 2.0, 8.0] {
        let reduced_kg = 1.0 / (1.0 / ball_kg + 1.0 / (DENSITY_KG_M3 * 0.008));
        let (energy_j, stiffness) =
            (0.5 * reduced_kg * speed_m_s * speed_m_s, 4.0 / 3.0 * modulus_pa * radius_m.sqrt());
        let depth_m = (2.5 * energy_j / stiffness).powf(0.4);
        let hertz_n = stiffness * depth_m.powf(1.5);
        for too_large in [1.5, 4.0] {
            let force_n = too_large * hertz_n;
            let contact_m = (0.75 * force_n * radius_m / modulus_pa).cbrt();
            let (duration_s, impulse_ns) = (1e-4, 2e-4 / std::f64::consts::PI * force_n);
            let own = ImpactContact {
                duration_s: Some(duration_s),
                radius_m: Some(contact_m),
                ..hit([0.0, 0.0, 0.1], [0.0, 0.0, -impulse_ns], partner(1, ball_kg, speed_m_s))
            };
            let report = cube.strike(&free(vec![own])).unwrap().threshold().impactor.unwrap();
            let found_n = report.load_factor.unwrap() * force_n;
            println!("{speed_m_s} m/s: {found_n:.0} N for {hertz_n:.0} N");
            assert!((report.energy_j / energy_j - 1.0).abs() < 1e-4);
            assert!((found_n / hertz_n - 1.0).abs() < 0.05, "{found_n} for {hertz_n}");
        }
    }
}

/// Impulses that alone break the bar into many pieces.
fn heavy(mass_kg: f64, speed_m_s: f64) -> FractureRequest {
    free(vec![hit([0.02, 0.01, 0.04], [0.0, 0.0, -3000.0], partner(1, mass_kg, speed_m_s))])
}

fn sites(outcome: &FractureOutcome) -> [f64; 2] {
    [outcome.sites().into(), outcome.threshold().strain_j.unwrap()]
}

/// Lowered loads break as the lower impulse does.
#[test]
fn fragments_are_those_of_the_lower_load() {
    for criterion in [Criterion::Strength, Criterion::Paper] {
        let limited = FractureRequest { criterion, ..heavy(f64::INFINITY, 2.0) };
        let outcome = BAR.strike(&limited).unwrap();
        let factor = outcome.threshold().impactor.unwrap().load_factor.unwrap();
        assert!(factor < 0.9 && outcome.sites() > 1, "{factor}, {} sites", outcome.sites());
        let mut lower = limited.clone();
        lower.contacts[0].partner = None;
        let whole = BAR.strike(&lower).unwrap();
        lower.contacts[0].impulse_ns *= factor;
        let lower = BAR.strike(&lower).unwrap();
        let energy = |outcome: &FractureOutcome| {
            let fragments = &outcome.fracture().unwrap().meshes.fragments;
            fragments.iter().map(|row| row.energy_j_m2).sum::<f64>()
        };
        assert!((energy(&outcome) / energy(&lower) - 1.0).abs() < 1e-6, "energies of the fragments");
        let [own, whole, lower] = [&outcome, &whole, &lower].map(sites);
        assert!(own[0] == lower[0] && own[0] < whole[0], "{criterion:?}: {own:?}, {lower:?}, {whole:?}");
        assert!((own[1] / lower[1] - 1.0).abs() < 1e-9, "{own:?}, {lower:?}");
        if let Some(ledger) = outcome.fracture().unwrap().ledger {
            assert!(ledger.deficit_j == 0.0 && ledger.surface_j <= own[1], "{ledger:?} of {own:?}");
        }
    }
}

#[test]
fn without_energy_every_object_stays_whole() {
    let request = FractureRequest { degree: DegreeRequest::Sites(5), ..heavy(1.0, -3.0) };
    let outcome = BAR.strike(&request).unwrap();
    assert!(outcome.fracture().is_none());
    let own = outcome.threshold();
    let impactor = own.impactor.unwrap();
    assert_eq!((impactor.energy_j, impactor.load_factor, own.strain_j), (0.0, Some(0.0), Some(0.0)));
    assert!(own.e1_over_gamma == 0.0 && own.impulse_factor > 0.0 && own.remainder_j() == Some(0.0), "{own:?}");
}

/// A bound that leaves the object whole holds for every lower load.
#[test]
fn bounded_requests_know_the_energy_but_no_factor() {
    let mut request = FractureRequest { criterion: Criterion::Paper, ..heavy(0.5, 4.0) };
    request.contacts[0].impulse_ns *= 1e-9;
    let own = BAR.strike(&request).unwrap().threshold().clone();
    let impactor = own.impactor.unwrap();
    assert!(own.is_bound && impactor.energy_j > 1.0, "{own:?}");
    assert_eq!((impactor.load_factor, own.strain_j, own.remainder_j()), (None, None, None));
    request.contacts[0].partner = Some(partner(1, -0.5, 4.0));
    assert!(matches!(BAR.strike(&request).err(), Some(FractureError::Partner(_))));
}

/// A fragment has its own mass.
#[test]
fn fragments_that_are_struck_again_have_their_own_mass() {
    let mut first = FractureRequest { degree: DegreeRequest::Sites(2), ..heavy(1.0, 1.0) };
    first.contacts[0].partner = None;
    let meshes = BAR.strike(&first).unwrap().into_meshes().unwrap();
    let kept = meshes.keep();
    let (row, speed) = (meshes.fragments[0], 3.0);
    let end = if row.center_m[0] < 0.0 { -0.2 } else { 0.2 };
    // Along the line through the center, the fragment does not turn.
    let [_, y, z] = row.center_m;
    let request = free(vec![hit([end, y, z], [-100.0 * end, 0.0, 0.0], partner(1, 0.5, speed))]);
    let token = CancelToken::default();
    let context = RequestContext::new(&BAR, &request, &token, &());
    let outcome = strike_again(context, (&kept, 0), &mut Workspace::default()).unwrap();
    let reduced = 0.5 * speed * speed / (1.0 / 0.5 + 1.0 / row.mass_kg);
    let energy_j = outcome.threshold().impactor.unwrap().energy_j;
    assert!((energy_j / reduced - 1.0).abs() < 1e-6, "{energy_j} of {reduced} J");
}
