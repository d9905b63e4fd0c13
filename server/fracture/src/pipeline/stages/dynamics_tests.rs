//! Responses to pulses, from contacts to energies, stresses and errors.

use super::contact_set::ContactSet;
use super::energy::{BodyEnergy, strain_energy};
use crate::cancel_token::CancelToken;
use crate::database::{BakeRequest, load, save};
use crate::elasticity::{ElasticWorkspace, ModalResponse, NodalLoad, Pulse, PulseLoad, RESPONSE_MAX, ReducedBasis};
use crate::pipeline::prepared::reduction::TRAINED_RADIUS_MIN;
use crate::pipeline::{
    DisplacementMethod, ElementChoice, FractureError, FractureRequest, ImpactContact, PreparedObject, Preset,
    RequestContext, Workspace, reduce_anchored,
};
use crate::scene::{Anchors, EffectKind, EffectSet, Material, Region};
use crate::strength::Criterion;
use crate::surface::shapes;
use nalgebra::{Point3, Vector3};
use std::f64::consts::PI;
use std::sync::LazyLock;

fn baked(sides_m: [f64; 3], spacing: f64, examples: u64, elements: ElementChoice) -> PreparedObject {
    let request = BakeRequest {
        quality: Preset::Draft,
        elastic_spacing: Some(spacing),
        crack_spacing: Some(spacing),
        examples,
        elements,
        ..BakeRequest::new("specimen", "glass", Material::named("glass").unwrap())
    };
    request.bake(shapes::cuboid(sides_m)).unwrap()
}

/// Bar of linear elements.
static BAR: LazyLock<PreparedObject> = LazyLock::new(|| baked([0.4, 0.08, 0.08], 0.05, 12, ElementChoice::Linear));

/// Plate of quadratic elements.
static PLATE: LazyLock<PreparedObject> = LazyLock::new(|| baked([0.4, 0.3, 0.05], 0.06, 0, ElementChoice::Quadratic));

/// Points on the upper faces of both, between nodes, m.
const PLACES_M: [[f64; 3]; 2] = [[0.03, 0.01, 0.04], [0.07, 0.05, 0.025]];

fn basis(object: &PreparedObject) -> &ReducedBasis {
    object.bodies[0].reduced().unwrap()
}

/// Period of the slowest vibration, s.
fn period_s(object: &PreparedObject) -> f64 {
    2.0 * PI / basis(object).modes().unwrap().frequencies()[0] / ContactSet::times_per_s(object)
}

/// A contact whose peak force is 1 kN in this direction.
fn contact(point_m: [f64; 3], direction: [f64; 3], duration_s: f64) -> ImpactContact {
    let impulse_ns = Vector3::from(direction).normalize() * (1000.0 * duration_s * 2.0 / PI);
    ImpactContact { point_m: point_m.into(), impulse_ns, duration_s: Some(duration_s), radius_m: None, partner: None }
}

fn down(object: usize, duration_s: f64) -> ImpactContact {
    contact(PLACES_M[object], [0.1, 0.0, -1.0], duration_s)
}

fn dynamic(contacts: Vec<ImpactContact>, elastic: DisplacementMethod, error_max: f64) -> FractureRequest {
    let effects = EffectSet::default().with(EffectKind::Dynamics);
    let base = FractureRequest::at(Point3::origin(), Vector3::y());
    FractureRequest { contacts, effects, elastic, reduced_error_max: error_max, ..base }
}

fn at_rest(request: &FractureRequest) -> FractureRequest {
    FractureRequest { effects: request.effects.without(EffectKind::Dynamics), ..request.clone() }
}

fn energy(object: &PreparedObject, request: &FractureRequest) -> BodyEnergy {
    let contacts = ContactSet::new(object, request).unwrap();
    let (token, mut workspace) = (CancelToken::default(), Workspace::default());
    let context = RequestContext::new(object, request, &token, &());
    strain_energy(context, &contacts, &mut workspace).unwrap().remove(0)
}

/// Strain energy over the unit of local energies.
fn local(object: &PreparedObject, request: &FractureRequest, own: &BodyEnergy) -> f64 {
    own.strain_j.unwrap() / ContactSet::new(object, request).unwrap().unit_j(object)
}

const REDUCED: DisplacementMethod = DisplacementMethod::Reduced;

#[test]
fn slow_pulses_deform_as_at_rest_and_short_ones_less() {
    for (index, object) in [&*BAR, &*PLATE].into_iter().enumerate() {
        for (elastic, error_max) in [(REDUCED, f64::INFINITY), (REDUCED, 0.1), (DisplacementMethod::Solve, 0.1)] {
            let ratio = |periods: f64| {
                let request = dynamic(vec![down(index, periods * period_s(object))], elastic, error_max);
                let [own, whole] = [&request, &at_rest(&request)].map(|own| energy(object, own));
                assert!(elastic == REDUCED || own.reduced_error.is_none(), "{index}");
                own.strain_j.unwrap() / whole.strain_j.unwrap()
            };
            let ratios = [0.02, 0.2, 1.0, 400.0].map(ratio);
            println!("body {index}, {elastic:?} to {error_max}: {ratios:.4?} of the energy at rest");
            assert!((ratios[3] - 1.0).abs() < 0.02, "{}", ratios[3]);
            // Faster vibrations than the slowest one exceed their state at rest under the second pulse.
            assert!(ratios[0] < 0.3 && ratios[0] < ratios[1], "{ratios:?}");
            assert!(ratios.iter().all(|ratio| *ratio < RESPONSE_MAX.powi(2)), "{ratios:?}");
        }
    }
}

/// The response to one contact, the share of energy that the basis misses, and the peak load.
fn by_hand(object: &PreparedObject, request: &FractureRequest) -> (ModalResponse, f64, NodalLoad) {
    let (solid, basis) = (object.bodies[0].solid.as_ref().unwrap(), basis(object));
    let (mut load, mut workspace, mut coordinates) = (NodalLoad::default(), ElasticWorkspace::default(), Vec::new());
    let contacts = ContactSet::new(object, request).unwrap();
    let spread_min = if request.elastic == REDUCED { TRAINED_RADIUS_MIN } else { 0.0 };
    solid.elasticity.touch(&contacts.bodies[0].1, spread_min, &mut load, &mut workspace).unwrap();
    basis.project(&load, &mut coordinates);
    let missed = basis.estimate().error(basis.residual(&solid.elasticity, &load, &coordinates, &mut workspace));
    let material = &object.parameters.material;
    let speed_m_s = (material.young_pa / material.density_kg_m3).sqrt();
    let duration = request.contacts[0].duration_s.unwrap() * speed_m_s / object.frame.diagonal_m;
    let own = PulseLoad { pulse: Pulse { duration }, coordinates: &coordinates };
    (basis.modes().unwrap().respond(&[own], missed), missed, load)
}

#[test]
fn energies_are_those_of_the_response_by_hand() {
    for (index, object) in [&*BAR, &*PLATE].into_iter().enumerate() {
        let (solid, basis) = (object.bodies[0].solid.as_ref().unwrap(), basis(object));
        let (mut workspace, mut over) = (ElasticWorkspace::default(), 0);
        for periods in [0.005, 1.0, 3.0] {
            let strike =
                |elastic, error_max| dynamic(vec![down(index, periods * period_s(object))], elastic, error_max);
            let request = strike(REDUCED, f64::INFINITY);
            let (response, missed, mut load) = by_hand(object, &request);
            let (force, square) = (response.forces[0], response.forces[0].powi(2));
            let (vibrating, near) = (ReducedBasis::energy(&response.coordinates), square * load.near_energy());
            let mut coordinates = Vec::new();
            let projected = basis.project(&load, &mut coordinates);
            let own = energy(object, &request);
            assert!((local(object, &request, &own) / (vibrating + near) - 1.0).abs() < 1e-9, "{index}, {periods}");
            // The static remainder at that time, and what is lost of it since the peak.
            let error = missed * projected / vibrating;
            assert!((own.reduced_error.unwrap() - error).abs() <= 1e-6 * error, "{:?}, {error}", own.reduced_error);
            over += u32::from(force == 0.0);
            // The same load without a basis; a basis that misses too much is completed, or not used.
            let request = strike(DisplacementMethod::Solve, 0.0);
            let (response, _, mut narrow) = by_hand(object, &request);
            let square = response.forces[0].powi(2);
            let mut solution = Vec::new();
            solid.elasticity.balance(&mut narrow);
            let solved = solid.elasticity.solve(&narrow.forces, &mut solution, &mut workspace, &CancelToken::default());
            solved.unwrap();
            let rest =
                solid.elasticity.elastic_energy(&narrow.forces, &solution) - basis.project(&narrow, &mut coordinates);
            let whole = ReducedBasis::energy(&response.coordinates) + square * (rest + narrow.near_energy());
            let own = energy(object, &request);
            assert!((local(object, &request, &own) / whole - 1.0).abs() < 1e-6, "{index}, {periods}");
            assert_eq!(own.reduced_error, None);
            if index == 0 {
                // The displacement has the energy that was counted.
                assert!((own.energy_j / own.strain_j.unwrap() - 1.0).abs() < 1e-4, "{periods}: {}", own.energy_j);
            }
            let token = CancelToken::default();
            basis.project(&load, &mut coordinates);
            let completed =
                basis.complete(&solid.elasticity, &mut load, &mut coordinates, &mut Vec::new(), &mut workspace, &token);
            if let Some(completed) = completed.unwrap().filter(|_| force != 0.0) {
                let whole = vibrating + square * (completed.energy - projected);
                let accepted = square * completed.error * completed.energy / whole;
                let request = strike(REDUCED, 1.001 * accepted);
                let own = energy(object, &request);
                let told = accepted + missed * (1.0 - square) * projected / vibrating;
                assert!((own.reduced_error.unwrap() / told - 1.0).abs() < 1e-6, "{:?}, {told}", own.reduced_error);
                assert!((local(object, &request, &own) / (whole + near) - 1.0).abs() < 1e-6, "{periods}");
            }
        }
        assert_eq!(over, 1, "the shortest contact is over");
    }
}

/// Strains of quadratic elements are superposed, not displacements.
#[test]
fn energy_of_slow_pulses_lies_where_it_does_at_rest() {
    for (index, object) in [&*BAR, &*PLATE].into_iter().enumerate() {
        let slow = |elastic, error_max| {
            let request = dynamic(vec![down(index, 400.0 * period_s(object))], elastic, error_max);
            let [own, whole] = [&request, &at_rest(&request)].map(|own| energy(object, own).shares);
            own.iter().zip(&whole).map(|(own, whole)| (own - whole).abs()).sum::<f64>()
        };
        let off = [slow(REDUCED, f64::INFINITY), slow(REDUCED, 0.1), slow(DisplacementMethod::Solve, 0.1)];
        println!("body {index}: {off:.4?} of the energy elsewhere");
        assert!(off.iter().all(|off| *off < 0.03), "{off:?}");
    }
}

#[test]
fn contacts_of_one_duration_are_one_group_or_several() {
    let object = &*PLATE;
    let duration_s = 0.7 * period_s(object);
    let strained = |duration_s: [f64; 2], elastic| {
        let two = [down(1, duration_s[0]), contact([-0.1, -0.06, 0.025], [0.0, 0.2, -1.0], duration_s[1])];
        energy(object, &dynamic(two.to_vec(), elastic, 0.5)).strain_j.unwrap()
    };
    for elastic in [REDUCED, DisplacementMethod::Solve] {
        let one = strained([duration_s; 2], elastic);
        let two = strained([duration_s, duration_s.next_up()], elastic);
        assert!((two / one - 1.0).abs() < 1e-12, "{two} of {one}");
        let other = strained([duration_s, 0.3 * duration_s], elastic);
        assert!((other / one - 1.0).abs() > 0.05, "{other} of {one}");
    }
}

/// Two contacts that cancel at rest deform the body if one of them lasts longer.
#[test]
fn contacts_of_several_durations_act_at_one_time() {
    let object = &*PLATE;
    let periods = [0.6, 1.5];
    let push = |periods: f64, sign: f64| contact(PLACES_M[1], [0.0, 0.0, sign], periods * period_s(object));
    let alone = |periods| energy(object, &dynamic(vec![push(periods, -1.0)], REDUCED, f64::INFINITY));
    let both = dynamic(vec![push(periods[0], -1.0), push(periods[1], 1.0)], REDUCED, f64::INFINITY);
    let both = energy(object, &both).strain_j.unwrap();
    let sum: f64 = periods.map(|periods| alone(periods).strain_j.unwrap().sqrt()).iter().sum();
    assert!(both > 0.01 * sum * sum && both.sqrt() < sum, "{both} of {}", sum * sum);
}

#[test]
fn responses_have_the_same_bits_for_any_number_of_threads() {
    for (index, object) in [&*BAR, &*PLATE].into_iter().enumerate() {
        for elastic in [REDUCED, DisplacementMethod::Solve] {
            let two = vec![down(index, 0.7 * period_s(object)), down(index, 0.2 * period_s(object))];
            let request = dynamic(two, elastic, 0.05);
            let on = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| energy(object, &request))
            };
            assert_eq!(on(1), on(5));
        }
    }
    let bake = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| baked([0.4, 0.3, 0.08], 0.1, 0, ElementChoice::Quadratic))
    };
    let [one, five] = [1, 5].map(bake);
    assert!(basis(&one).mass().is_some() && basis(&one) == basis(&five));
}

/// Stresses around contacts are those of the force at the time of the largest energy.
#[test]
fn contacts_press_with_the_force_of_that_time() {
    let object = &*PLATE;
    let request = dynamic(vec![down(1, period_s(object))], REDUCED, f64::INFINITY);
    let request = FractureRequest { criterion: Criterion::Strength, ..request };
    let force = by_hand(object, &request).0.forces[0];
    let [own, whole] = [&request, &at_rest(&request)].map(|request| {
        let energy = energy(object, request);
        energy.peaks.iter().find(|peak| peak.is_contact).unwrap().stress_over_strength
    });
    assert!((0.1..0.999).contains(&force) && (own / whole / force - 1.0).abs() < 1e-9, "{own} of {whole}: {force}");
}

/// The bound of weak impacts holds for responses, too, and is none where durations differ.
#[test]
fn bounds_of_weak_impacts_are_those_of_responses() {
    let object = &*PLATE;
    let duration_s = 0.8 * period_s(object);
    let mut request = dynamic(vec![down(1, duration_s)], REDUCED, f64::INFINITY);
    let exact = object.strike(&FractureRequest { threshold_only: true, ..request.clone() }).unwrap();
    let share = 0.01 * exact.threshold().impulse_factor;
    request.contacts[0].impulse_ns *= share;
    let [bounded, whole] =
        [&request, &at_rest(&request)].map(|request| object.strike(request).unwrap().threshold().clone());
    assert!(bounded.is_bound && whole.is_bound && bounded.e1_over_gamma >= 1e-4, "{bounded:?}");
    assert!((bounded.e1_over_gamma / whole.e1_over_gamma / RESPONSE_MAX.powi(2) - 1.0).abs() < 1e-12);
    let mut other = request.contacts[0];
    other.duration_s = Some(2.0 * duration_s);
    request.contacts.push(other);
    let [own, whole] =
        [&request, &at_rest(&request)].map(|request| object.strike(request).unwrap().threshold().clone());
    assert!(!own.is_bound && whole.is_bound);
}

#[test]
fn bodies_without_vibrations_and_held_objects_are_refused() {
    let plain = baked([0.2, 0.1, 0.1], 0.1, 0, ElementChoice::Linear);
    let strike_with = |object: &PreparedObject, effects: EffectSet, share: f64| {
        let mut request = dynamic(vec![contact([0.0, 0.0, 0.05], [0.0, 0.0, -1.0], 1e-4)], REDUCED, 0.1);
        request.contacts[0].impulse_ns *= share;
        object.strike(&FractureRequest { effects, ..request })
    };
    let strike = |object: &PreparedObject, effects: EffectSet| strike_with(object, effects, 1.0).err().unwrap();
    let effects = EffectSet::default().with(EffectKind::Dynamics);
    let error = strike(&plain, effects);
    assert!(matches!(error, FractureError::DynamicsUnprepared { body: 0 }) && error.is_callers(), "{error}");
    // So are impacts that a bound decides.
    assert!(strike_with(&plain, EffectSet::default(), 1e-4).unwrap().threshold().is_bound);
    let weak = strike_with(&plain, effects, 1e-4).err();
    assert!(matches!(weak, Some(FractureError::DynamicsUnprepared { body: 0 })), "{weak:?}");
    let message = error.to_string();
    assert!(
        message.contains("has no basis of displacements with masses") && message.contains("--examples"),
        "{message}"
    );
    let error = strike(&PLATE, effects.with(EffectKind::Gravity));
    assert!(matches!(error, FractureError::DynamicsGravity) && error.is_callers(), "{error}");
}

/// Files of earlier versions have no masses.
#[test]
fn objects_without_masses_are_struck_as_before_and_refuse_the_effect() {
    let mut plate = baked([0.4, 0.3, 0.05], 0.1, 0, ElementChoice::Quadratic);
    let request = dynamic(vec![down(1, 1e-4)], REDUCED, 0.1);
    let before = plate.strike(&at_rest(&request)).unwrap();
    let solid = plate.bodies[0].solid.as_mut().unwrap();
    let basis = solid.reduced.take().unwrap();
    let (rows, gram, estimate) = (basis.basis().to_vec(), basis.gram().to_vec(), basis.estimate());
    let tables = basis.quadratic().unwrap().clone();
    solid.reduced = Some(ReducedBasis::stored_quadratic(&solid.elasticity, rows, gram, tables, estimate));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("plate.shatter");
    save(&plate, &file).unwrap();
    let loaded = load(&file).unwrap();
    assert!(self::basis(&loaded).mass().is_none());
    let after = loaded.strike(&at_rest(&request)).unwrap();
    assert_eq!((before.threshold(), before.fracture_degree()), (after.threshold(), after.fracture_degree()));
    let error = loaded.strike(&request).err().unwrap();
    assert!(matches!(error, FractureError::DynamicsUnprepared { body: 0 }), "{error}");
}

/// A strip that is anchored at one end, with a basis for that.
fn anchored_strip() -> PreparedObject {
    let mut strip = baked([0.4, 0.05, 0.02], 0.03, 0, ElementChoice::Auto);
    let region = Region::Cuboid { min_m: Point3::new(-1.0, -1.0, -1.0), max_m: Point3::new(-0.175, 1.0, 1.0) };
    let anchors = Anchors { regions: vec![region], gravity_m_s2: None };
    let token = CancelToken::default();
    reduce_anchored(&mut strip, &[&anchors], &token, &mut |_| ()).unwrap();
    strip.anchor(&anchors, &token).unwrap();
    strip
}

/// L. Meirovitch, *Fundamentals of Vibrations* (2001), section 8.5: (1.8751)² √(EI / ρA) / l² of a cantilever.
#[test]
fn an_anchored_strip_vibrates_as_a_cantilever() {
    let strip = anchored_strip();
    let effects = EffectSet::of([EffectKind::Elastic, EffectKind::Anchored, EffectKind::Dynamics]);
    let modes = strip.basis(0, effects).unwrap().modes().unwrap();
    let frequency = modes.frequencies()[0] * ContactSet::times_per_s(&strip);
    let Material { young_pa, density_kg_m3, .. } = strip.parameters.material;
    // From the last nodes that do not move.
    let places = &strip.bodies[0].solid.as_ref().unwrap().lattice.nodes;
    let held = strip.anchored_bases[0].nodes.iter().map(|node| strip.frame.to_meters(&places[*node as usize]).x);
    let length = 0.2 - held.fold(f64::NEG_INFINITY, f64::max);
    let exact = 1.8751f64.powi(2) * 0.02 * (young_pa / (12.0 * density_kg_m3)).sqrt() / length.powi(2);
    println!("{frequency:.1} for {exact:.1} rad/s");
    assert!((frequency / exact - 1.0).abs() < 0.05, "{frequency} for {exact}");

    let ratio = |periods: f64, elastic| {
        let tip = contact([0.19, 0.0, 0.01], [0.0, 0.0, -1.0], periods * 2.0 * PI / exact);
        let request = FractureRequest { effects, ..dynamic(vec![tip], elastic, 0.1) };
        energy(&strip, &request).strain_j.unwrap() / energy(&strip, &at_rest(&request)).strain_j.unwrap()
    };
    for elastic in [REDUCED, DisplacementMethod::Solve] {
        let ratios = [0.02, 0.2, 1.0, 400.0].map(|periods| ratio(periods, elastic));
        println!("{elastic:?}: {ratios:.4?} of the energy at rest");
        assert!((ratios[3] - 1.0).abs() < 0.02 && ratios[0] < 0.1 * ratios[2], "{ratios:?}");
    }
}
