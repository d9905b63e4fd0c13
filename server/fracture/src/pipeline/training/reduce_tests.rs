//! Tests of the bases and of the impacts that fit their error estimates.

use super::*;
use crate::database::{BakeRequest, Tables};
use crate::lattice::LatticeStretch;
use crate::pipeline::SurfaceKind;
use crate::pipeline::prepared::parameters::{DisplacementMethod, RANK_MAX};
use crate::random::RandomStream;
use crate::scene::Material;
use crate::surface::shapes;

/// A glass strip of 0.2 × 0.05 × 0.02 m, said to be a sheet on long cells.
fn sheet() -> PreparedObject {
    let request = BakeRequest {
        tables: Tables { elastic: true, ..Tables::NONE },
        surface: SurfaceKind::Lattice,
        elastic: DisplacementMethod::Solve,
        elastic_spacing: Some(0.06),
        crack_spacing: Some(0.06),
        ..BakeRequest::new("strip", "glass", Material::named("glass").unwrap())
    };
    let mut sheet = request.bake(shapes::cuboid([0.2, 0.05, 0.02])).unwrap();
    sheet.report.stretch = Some(LatticeStretch { axis: [0.0, 0.0, 1.0], factor: 2.0 });
    sheet
}

/// Strain energy of an impact, and its estimated error, if errors of `reduced_error_max` are accepted.
fn energy(object: &PreparedObject, impact: &FractureRequest, reduced_error_max: f64) -> (f64, Option<f64>) {
    let request = FractureRequest { reduced_error_max, ..impact.clone() };
    let (token, contacts) = (CancelToken::default(), ContactSet::new(object, &request).unwrap());
    let context = RequestContext::new(object, &request, &token, &());
    let own = strain_energy(context, &contacts, &mut Workspace::default()).unwrap().remove(0);
    (own.strain_j.unwrap(), own.reduced_error)
}

#[test]
fn the_basis_alone_serves_up_to_a_share_of_the_accepted_error() {
    let mut strip = sheet();
    strip.report.stretch = None;
    reduce(&mut strip, RANK_MAX, &CancelToken::default()).unwrap();
    let drawn = held_out(&ImpactSampler::new(&strip), &strip, 2);
    let effects = [drawn.effects, drawn.effects.with(EffectKind::Dynamics)];
    for effects in effects {
        let mut impact = FractureRequest { effects, elastic: DisplacementMethod::Reduced, ..drawn.clone() };
        impact.contacts.iter_mut().for_each(|contact| contact.duration_s = Some(0.1));
        let (alone_j, error) = energy(&strip, &impact, f64::INFINITY);
        let [completed, alone] = [3.2, 3.5].map(|share| energy(&strip, &impact, share * error.unwrap()));
        assert_eq!(alone, (alone_j, error));
        assert!(
            completed.0 > alone_j && completed.1.is_some_and(|own| own != error.unwrap()),
            "{completed:?} {alone:?}"
        );
    }
}

#[test]
fn displacements_of_sheets_are_always_completed() {
    let mut sheet = sheet();
    reduce(&mut sheet, RANK_MAX, &CancelToken::default()).unwrap();
    let basis = sheet.bodies[0].reduced().unwrap();
    assert!(basis.completed_estimate().unwrap().power >= 1.0 && basis.estimate().power >= 1.0);
    let sampler = ImpactSampler::new(&sheet);
    let impact = |number: u64| {
        let mut own = held_out(&sampler, &sheet, number);
        // Pulses so long that the largest energy is under forces.
        own.contacts.iter_mut().for_each(|contact| contact.duration_s = Some(0.1));
        let effects = if number < 6 { own.effects } else { own.effects.with(EffectKind::Dynamics) };
        FractureRequest { effects, ..own }
    };
    let impacts: Vec<FractureRequest> = (0..12).map(impact).collect();
    let found = |sheet: &PreparedObject, elastic: DisplacementMethod| {
        let request = |impact: &FractureRequest| FractureRequest { elastic, ..impact.clone() };
        impacts.iter().map(|impact| energy(sheet, &request(impact), f64::INFINITY)).collect::<Vec<_>>()
    };
    let solved = found(&sheet, DisplacementMethod::Solve);
    let completed = found(&sheet, DisplacementMethod::Reduced);
    sheet.report.stretch = None;
    let alone = found(&sheet, DisplacementMethod::Reduced);
    for ((alone, completed), solved) in alone.iter().zip(&completed).zip(&solved) {
        assert!(alone.0 < completed.0 && completed.0 < solved.0 * 1.0001, "{alone:?} {completed:?} {solved:?}");
        assert!(alone.1 != completed.1, "the error is that of the completion: {alone:?} {completed:?}");
    }
}

#[test]
fn estimates_are_fitted_to_narrow_contacts_too() {
    let mut sheet = sheet();
    let radius = |strike: FractureRequest| strike.contacts[0].radius_m.unwrap();
    let pairs = |sheet: &PreparedObject| {
        let sampler = ImpactSampler::new(sheet);
        let drawn = |number| radius(sampler.impact(sheet.parameters.seed, HELD_OUT_FIRST + number));
        (0..8).map(|number| (radius(held_out(&sampler, sheet, number)), drawn(number))).collect::<Vec<_>>()
    };
    let scales = [1.0, 1.0, 0.5, 0.5, 0.25, 0.25, 1.0, 1.0];
    let least = TRAINED_RADIUS_MIN * sheet.frame.diagonal_m;
    for ((long, drawn), scale) in pairs(&sheet).into_iter().zip(scales) {
        assert_eq!(long, scale * drawn);
    }
    sheet.report.stretch = None;
    for ((regular, drawn), scale) in pairs(&sheet).into_iter().zip(scales) {
        assert_eq!(regular, least.max(scale * drawn));
    }
    assert!(pairs(&sheet).iter().any(|(regular, drawn)| *regular == least && *drawn > least));
}

#[test]
fn other_impacts_fit_estimates_of_completions_and_are_not_told() {
    let mut strip = sheet();
    assert_eq!(held_out_counts(&strip), [24, 0, 0]);
    strip.report.stretch = None;
    assert_eq!(held_out_counts(&strip), [24, 12, 6]);
    let sampler = ImpactSampler::new(&strip);
    let cosine = |number| {
        let mut stream = RandomStream::new(strip.parameters.seed, HELD_OUT_FIRST + number);
        // The number of contacts, then the first one.
        stream.uniform();
        let (_, inward) = sampler.point(&mut stream);
        held_out(&sampler, &strip, number).contacts[0].impulse_ns.normalize().dot(&inward)
    };
    assert!((0..24).all(|number| cosine(number) > 0.499));
    assert!((24..36).map(cosine).reduce(f64::min).unwrap() < 0.2 && (24..36).any(|number| cosine(number) > 0.8));
    assert!((36..42).all(|number| cosine(number).abs() < 1e-9));
    reduce(&mut strip, RANK_MAX, &CancelToken::default()).unwrap();
    assert_eq!(strip.reduction.as_ref().unwrap().holdout, 24);
    let trials = trials(&strip, None, &CancelToken::default()).unwrap();
    assert_eq!([trials.len(), trials.iter().filter(|own| own.fits).count()], [42, 24]);
    let mut every = trials;
    let basis = |trials: &[Trial]| fitted(strip.bodies[0].reduced().unwrap().clone(), (0, false), trials);
    let all = basis(&every);
    let most: Vec<Trial> = every.iter().filter(|own| own.is_told).cloned().collect();
    assert_eq!(basis(&most).estimate(), all.estimate());
    assert_ne!(basis(&most).completed_estimate(), all.completed_estimate());
    // Impacts along the surface only bound the estimate, by the worst error of all.
    let bound = all.completed_estimate().unwrap();
    let worst = |own: &Trial| 1.5 * own.completed.as_ref().unwrap().energy_error;
    assert_eq!(bound.error_max, every.iter().map(worst).fold(0.0, f64::max));
    assert_eq!(bound.error(1e9), bound.error_max);
    every[40].completed.as_mut().unwrap().energy_error = 2.0;
    let wide = basis(&every).completed_estimate().unwrap();
    assert_eq!(wide, ErrorEstimate { error_max: 3.0, ..bound });
    assert_eq!(basis(&every[..7]).completed_estimate().unwrap().error_max, f64::INFINITY);
    every.iter_mut().for_each(|own| own.energy_error = own.residual.sqrt());
    assert_eq!(basis(&every).estimate().power, 1.0);
    let steep = fitted(strip.bodies[0].reduced().unwrap().clone(), (0, true), &every);
    assert_eq!(steep.completed_estimate().unwrap().error_max, f64::INFINITY);
}

#[test]
fn most_contacts_of_quadratic_elements_yield_one_snapshot() {
    let impulse = Vector3::new(0.0, 0.6, -0.9);
    let axes: Vec<_> = (0..3).map(|axis| Vector3::ith(axis, 1.0)).collect();
    let all = |order| (0..16).map(|number| directions(order, number, &impulse)).collect::<Vec<_>>();
    assert!(all(ElementOrder::Linear).iter().all(|own| *own == axes));
    for (number, own) in all(ElementOrder::Quadratic).into_iter().enumerate() {
        assert_eq!(own, if number.is_multiple_of(8) { axes.clone() } else { vec![impulse.normalize()] });
    }
    let mut sheet = sheet();
    let count = |sheet: &PreparedObject| contacts(sheet, 0).unwrap().len();
    let long = count(&sheet);
    sheet.report.stretch = None;
    let regular = count(&sheet);
    sheet.impacts = 40;
    let learned = count(&sheet);
    assert!((32..60).contains(&long) && 60 <= regular && 80 <= learned, "{long}, {regular}, {learned}");
}
