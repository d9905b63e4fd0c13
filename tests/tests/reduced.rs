//! Reduced elasticity: its accuracy on impacts that are not examples, and the conditions of its use.

use nalgebra::{Point3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, BakeShare, PartialBake, bake, load, save};
use shatter_fracture::elasticity::{ElasticWorkspace, NodalLoad};
use shatter_fracture::pipeline::{
    ContactSet, DisplacementMethod, ElementChoice, FractureOutcome, FractureRequest, ImpactSampler, PreparedObject,
    RANK_MAX, REDUCED_ERROR_MAX, RequestContext, SurfaceKind, Workspace, reduce, strain_energy, strike,
};
use shatter_fracture::scene::EffectKind;
use shatter_fracture::surface::{RawMesh, shapes};
use shatter_tests::real;
use shatter_tests::struck::{energy as body_energy, outcome};
use std::sync::LazyLock;

/// An arch with a good basis.
static ARCH: LazyLock<PreparedObject> = LazyLock::new(|| arch(160, RANK_MAX));

/// An arch whose basis is made from this many impacts; without learned degrees.
fn arch(impacts: u64, rank_max: usize) -> PreparedObject {
    made(shapes::arch(), "arch", impacts, rank_max)
}

fn made(mesh: RawMesh, name: &str, impacts: u64, rank_max: usize) -> PreparedObject {
    let request =
        BakeRequest { elastic_spacing: Some(0.06), crack_spacing: Some(0.05), ..real::request(name, "ceramic") };
    let mut prepared = bake(mesh, &request, &CancelToken::default(), &mut |_| ()).unwrap();
    prepared.impacts = impacts;
    reduce(&mut prepared, rank_max, &CancelToken::default()).unwrap();
    prepared
}

/// An impact on the arch at the top.
fn impact_at_the_top(prepared: &PreparedObject, elastic: DisplacementMethod) -> FractureRequest {
    let top = prepared.bodies[0].crack.nodes.iter().max_by(|a, b| a.y.total_cmp(&b.y)).unwrap();
    let point_m: Point3<f64> = prepared.frame.to_meters(top);
    FractureRequest { elastic, ..FractureRequest::at(point_m, Vector3::new(1.0, -3.0, 0.5)).seeded(1) }
}

/// Strikes the arch at the top.
fn struck(prepared: &PreparedObject, elastic: DisplacementMethod) -> FractureOutcome {
    let request = impact_at_the_top(prepared, elastic);
    strike(RequestContext::new(prepared, &request, &CancelToken::default(), &()), &mut Workspace::default()).unwrap()
}

#[test]
fn without_impacts_or_without_rank_there_is_no_basis() {
    for prepared in [arch(0, RANK_MAX), arch(60, 0)] {
        assert!(prepared.reduction.is_none() && prepared.bodies[0].reduced().is_none());
        assert_eq!(struck(&prepared, DisplacementMethod::Reduced).threshold().reduced_error, None);
    }
}

#[test]
fn an_object_that_is_to_be_solved_learns_degrees_and_has_no_basis() {
    let request = BakeRequest {
        elastic_spacing: Some(0.08),
        crack_spacing: Some(0.06),
        examples: 10,
        elastic: DisplacementMethod::Solve,
        ..real::request("arch", "ceramic")
    };
    let prepared = bake(shapes::arch(), &request, &CancelToken::default(), &mut |_| ()).unwrap();
    assert!(prepared.learned.is_some() && prepared.reduction.is_none() && prepared.bodies[0].reduced().is_none());
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("arch.shatter");
    save(&prepared, &file).unwrap();
    let more = PartialBake::add(load(&file).unwrap(), 2, BakeShare::WHOLE).unwrap();
    let more = more.complete(&CancelToken::default(), &mut |_| ()).unwrap();
    assert!(more.examples.len() > prepared.examples.len() && more.reduction.is_none(), "it stays so");
    assert_eq!(struck(&more, DisplacementMethod::Reduced).threshold().reduced_error, None);
}

#[test]
fn a_reduced_strike_is_within_its_estimate_and_a_solve_is_the_same_with_a_basis() {
    let (bare, prepared) = (arch(0, 0), &*ARCH);
    let reduction = prepared.reduction.clone().unwrap();
    println!("{reduction:?}");
    assert!(reduction.energy_error_median < 0.01 && reduction.density_error_median < 0.06, "{reduction:?}");
    let [reduced, solved] =
        [DisplacementMethod::Reduced, DisplacementMethod::Solve].map(|elastic| struck(prepared, elastic));
    let error = (reduced.threshold().e1_over_gamma / solved.threshold().e1_over_gamma - 1.0).abs();
    println!("E_1 is {error:.2e} off, energy estimated {:?}", reduced.threshold().reduced_error);
    let estimate = reduced.threshold().reduced_error.expect("the basis is good enough");
    assert!(estimate <= REDUCED_ERROR_MAX && error <= 3.0 * estimate, "{error} against {estimate}");
    assert_eq!(solved.threshold().reduced_error, None);
    let without = struck(&bare, DisplacementMethod::Reduced);
    assert_eq!(
        (solved.threshold().e1_over_gamma, solved.sites()),
        (without.threshold().e1_over_gamma, without.sites())
    );
}

/// ½ f·u of the solve, whatever part of the energy drives the cracks, and within the estimate of the basis.
#[test]
fn a_result_tells_the_strain_energy_of_the_whole_body() {
    let prepared = &*ARCH;
    let request = impact_at_the_top(prepared, DisplacementMethod::Solve);
    let impact = ContactSet::new(prepared, &request).unwrap();
    let (body, token) = (&prepared.solid(0).unwrap().elasticity, CancelToken::default());
    let (mut load, mut displacement, mut workspace) = (NodalLoad::default(), Vec::new(), ElasticWorkspace::default());
    body.load(&impact.bodies[0].1, &mut load, &mut workspace).unwrap();
    body.solve(&load.forces, &mut displacement, &mut workspace, &token).unwrap();
    let work: f64 = load.forces.iter().zip(&displacement).map(|(f, u)| f * u).sum();
    let exact = 0.5 * work * impact.unit_j(prepared);
    for effect in [EffectKind::Tensile, EffectKind::Bonds] {
        let request = FractureRequest { effects: request.effects.with(effect), ..request.clone() };
        let own = body_energy(prepared, &request);
        assert!((own.strain_j.unwrap() / exact - 1.0).abs() < 1e-10, "{:?} of {exact} J", own.strain_j);
        assert_eq!((own.energy_j / exact - 1.0).abs() < 1e-6, effect == EffectKind::Bonds, "{}", own.energy_j);
        let threshold = outcome(prepared, &request).unwrap().threshold().clone();
        assert_eq!(threshold.strain_j, own.strain_j);
    }
    let reduced = body_energy(prepared, &FractureRequest { elastic: DisplacementMethod::Reduced, ..request.clone() });
    let (strain_j, estimate) = (reduced.strain_j.unwrap(), reduced.reduced_error.unwrap());
    assert!((strain_j / exact - 1.0).abs() <= 3.0 * estimate, "{strain_j} of {exact} J, estimate {estimate}");
    let without = request.effects.without(EffectKind::Elastic);
    assert_eq!(body_energy(prepared, &FractureRequest { effects: without, ..request.clone() }).strain_j, None);
    let told = |effects| {
        let outcome = outcome(prepared, &FractureRequest { effects, ..request.clone() }).unwrap();
        outcome.threshold().discretization_error
    };
    assert!(told(request.effects).is_some() && told(without).is_none());
}

/// A bar with a good basis.
static BAR: LazyLock<PreparedObject> = LazyLock::new(|| {
    let request =
        BakeRequest { elastic_spacing: Some(0.03), crack_spacing: Some(0.03), ..real::request("bar", "glass") };
    let mut prepared = bake(shapes::cuboid([1.0, 0.2, 0.2]), &request, &CancelToken::default(), &mut |_| ()).unwrap();
    prepared.impacts = 200;
    reduce(&mut prepared, RANK_MAX, &CancelToken::default()).unwrap();
    println!("{:?}", prepared.reduction);
    prepared
});

#[test]
fn an_impact_with_the_default_radius_needs_no_solve() {
    let outcome = struck(&BAR, DisplacementMethod::Reduced);
    assert!(
        outcome.threshold().radius_m < 1.01 * 0.04 * BAR.frame.diagonal_m,
        "the lattice resolves the default radius"
    );
    assert!(outcome.threshold().reduced_error.is_some());
}

/// The near field has what the examples lack, so that the basis does as well as under wide contacts.
#[test]
fn a_contact_much_smaller_than_those_of_the_examples_needs_no_solve() {
    let energy = |diagonals: f64, elastic: DisplacementMethod, effect: Option<EffectKind>| {
        let request = FractureRequest::at(Point3::new(0.02, 0.1, 0.01), Vector3::new(0.3, -3.0, 0.2)).seeded(1);
        let effects = effect.map_or(request.effects, |effect| request.effects.with(effect));
        let mut request = FractureRequest { elastic, effects, ..request };
        request.contacts[0].radius_m = Some(diagonals * BAR.frame.diagonal_m);
        body_energy(&BAR, &request)
    };
    let wide = energy(0.04, DisplacementMethod::Reduced, None).strain_j.unwrap();
    for (diagonals, factor_min) in [(0.02, 1.1), (0.005, 2.0)] {
        let [reduced, solved] =
            [DisplacementMethod::Reduced, DisplacementMethod::Solve].map(|elastic| energy(diagonals, elastic, None));
        println!("radius {diagonals}: {:?} J, solved {:?} J", reduced.strain_j, solved.strain_j);
        assert!(reduced.reduced_error.is_some() && solved.reduced_error.is_none());
        let strains_j = [&reduced, &solved].map(|own| own.strain_j.unwrap());
        assert!(
            (strains_j[0] / strains_j[1] - 1.0).abs() < 0.05 && strains_j[0] > factor_min * wide,
            "{strains_j:?} J"
        );
        for own in [&reduced, &solved] {
            assert!((own.radius_m / BAR.frame.diagonal_m / diagonals - 1.0).abs() < 1e-9, "{} m", own.radius_m);
            // What drives cracks without the effect `tensile` is all of it.
            assert!((own.energy_j / own.strain_j.unwrap() - 1.0).abs() < 1e-6, "{} J", own.energy_j);
        }
        let tensile = energy(diagonals, DisplacementMethod::Reduced, Some(EffectKind::Tensile));
        assert!(tensile.energy_j > 0.0 && tensile.energy_j < tensile.strain_j.unwrap(), "{} J", tensile.energy_j);
        assert!((tensile.strain_j.unwrap() / strains_j[0] - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_basis_that_is_too_coarse_is_not_used() {
    let prepared = arch(12, 8);
    let reduction = prepared.reduction.clone().unwrap();
    println!("{reduction:?}");
    assert!(reduction.energy_error_median > REDUCED_ERROR_MAX && reduction.solved > 0.5, "{reduction:?}");
}

/// Energy and estimated error of an impact on one body.
fn energy(
    prepared: &PreparedObject,
    request: &FractureRequest,
    workspace: &mut Workspace,
) -> Option<(f64, Option<f64>)> {
    let impact = ContactSet::new(prepared, request).unwrap();
    let found = strain_energy(RequestContext::new(prepared, request, &CancelToken::default(), &()), &impact, workspace)
        .unwrap()
        .pop()?;
    Some((found.energy_j, found.reduced_error))
}

/// Estimated over true relative error of the energy, by rank.
fn ratios(prepared: &PreparedObject, ranks: &[Option<u32>], impacts: std::ops::Range<u64>) -> Vec<Vec<f64>> {
    let (sampler, mut workspace) = (ImpactSampler::new(prepared), Workspace::default());
    let mut ratios = vec![Vec::new(); ranks.len()];
    for number in impacts {
        let request = sampler.impact(77, number);
        let (truth, none) = energy(prepared, &request, &mut workspace).unwrap();
        assert_eq!(none, None);
        let mut last = f64::INFINITY;
        for (rank_max, ratios) in ranks.iter().zip(&mut ratios) {
            let request =
                FractureRequest { elastic: DisplacementMethod::Reduced, rank_max: *rank_max, ..request.clone() };
            let (found, estimate) = energy(prepared, &request, &mut workspace).unwrap();
            let (Some(estimate), error) = (estimate, 1.0 - found / truth) else { continue };
            assert!(error <= last + 1e-5, "impact {number}, rank {rank_max:?}: {error} after {last}");
            last = error;
            ratios.push(estimate / error);
        }
    }
    ratios
}

/// Share of `ratios` within a factor 4 of 1; prints their distribution.
fn within_4(name: &str, ratios: &[f64]) -> f64 {
    let mut sorted = ratios.to_vec();
    sorted.sort_by(f64::total_cmp);
    let quantiles = [0.0, 0.1, 0.5, 0.9, 1.0].map(|share| sorted[((sorted.len() - 1) as f64 * share) as usize]);
    let within = sorted.iter().filter(|ratio| (0.25..=4.0).contains(*ratio)).count() as f64 / sorted.len() as f64;
    println!("{name}: {} estimates, {within:.3} within a factor 4, quantiles {quantiles:.2?}", sorted.len());
    within
}

#[test]
fn a_lower_rank_has_a_larger_reported_error() {
    let ranks = [1, 4, 16, 48, u32::MAX].map(Some);
    let prepared = &*ARCH;
    for (rank, ratios) in ranks.iter().zip(ratios(prepared, &ranks, 0..60)) {
        assert!(within_4(&format!("rank {rank:?}"), &ratios) >= 0.8);
    }
    let request = ImpactSampler::new(prepared).impact(77, 0);
    let of = |rank_max| {
        let request = FractureRequest { elastic: DisplacementMethod::Reduced, rank_max, ..request.clone() };
        energy(prepared, &request, &mut Workspace::default())
    };
    assert_eq!(of(None), of(Some(u32::MAX)));
    assert_eq!(of(Some(0)), of(Some(1)), "at least one");
}

#[test]
fn estimates_hold_on_hundreds_of_impacts_that_no_basis_has_seen() {
    let dumbbell = made(shapes::dumbbell(), "dumbbell", 160, RANK_MAX);
    for (name, prepared) in [("arch", &*ARCH), ("dumbbell", &dumbbell)] {
        let ratios = ratios(prepared, &[Some(24), None], 0..300);
        for (ratios, rank) in ratios.iter().zip(["24", "all"]) {
            assert!(ratios.len() >= 200, "{} of {name} are reduced", ratios.len());
            assert!(within_4(&format!("{name}, rank {rank}"), ratios) >= 0.8);
        }
    }
}

/// Share of the requests without a radius, which have about the smallest one of the examples, that need a solve.
fn solved_at_the_default_radius(prepared: &PreparedObject) -> f64 {
    const STRIKES: u64 = 100;
    let sampler = ImpactSampler::new(prepared);
    let mut workspace = Workspace::default();
    let mut needs_solve = |number: &u64| {
        let mut request = sampler.impact(77, *number);
        request.contacts.truncate(1);
        request.contacts[0].radius_m = None;
        let request = FractureRequest { elastic: DisplacementMethod::Reduced, threshold_only: true, ..request };
        let outcome =
            strike(RequestContext::new(prepared, &request, &CancelToken::default(), &()), &mut workspace).unwrap();
        outcome.threshold().reduced_error.is_none()
    };
    (0..STRIKES).filter(&mut needs_solve).count() as f64 / STRIKES as f64
}

/// Checks energy within 1 % (median), its density within 6 %, n₀ within 0.5 %; nine of ten estimates within a factor 3.
fn check(prepared: &mut PreparedObject) {
    prepared.impacts = 200;
    reduce(prepared, RANK_MAX, &CancelToken::default()).unwrap();
    let reduction = prepared.reduction.as_ref().unwrap();
    println!("{}: {reduction:?}", prepared.name);
    println!("  at the default radius {:.0} % are solved for", 100.0 * solved_at_the_default_radius(prepared));
    assert!(reduction.energy_error_median <= 0.01, "{reduction:?}");
    assert!(reduction.density_error_median <= 0.06, "{reduction:?}");
    assert!(reduction.degree_error_median <= 0.005, "{reduction:?}");
    assert!(reduction.estimates_within_3 >= 0.9, "{reduction:?}");
}

#[test]
#[ignore = "a minute: the bases of two real meshes and a generated one; run with --ignored"]
fn two_hundred_impacts_span_the_others() {
    let glass = |name| real::request(name, "glass");
    check(&mut bake(shapes::horseshoe(), &glass("horseshoe"), &CancelToken::default(), &mut |_| ()).unwrap());
    for file in ["horse.ply", "stanford-bunny.obj"] {
        real::baked(file).iter_mut().for_each(check);
    }
}

/// Strikes that the basis alone misses by more than a tenth need no solve with quadratic elements.
#[test]
fn quadratic_elements_have_a_basis_without_examples() {
    let (elements, surface) = (ElementChoice::Quadratic, SurfaceKind::Lattice);
    let request = BakeRequest { elements, surface, ..real::request("mug", "ceramic") };
    let mug = bake(shapes::mug(), &request, &CancelToken::default(), &mut |_| ()).unwrap();
    let reduction = mug.reduction.clone().unwrap();
    println!("{reduction:?}");
    assert!(mug.impacts == 0 && reduction.energy_error_p90 > 0.1, "the basis alone would not do");
    let completed = reduction.completed.unwrap();
    assert!(completed.energy_error_median < 0.02 && completed.energy_error_p90 < 0.05, "{completed:?}");
    let (sampler, token) = (ImpactSampler::new(&mug), CancelToken::default());
    let mut workspace = Workspace::default();
    let mut energy = |request: &FractureRequest| {
        let contacts = ContactSet::new(&mug, request).unwrap();
        let context = RequestContext::new(&mug, request, &token, &());
        strain_energy(context, &contacts, &mut workspace).unwrap().remove(0)
    };
    for number in 1000..1020 {
        let solved = sampler.impact(7, number);
        let reduced = FractureRequest { elastic: DisplacementMethod::Reduced, ..solved.clone() };
        let [solved, reduced] = [&solved, &reduced].map(&mut energy);
        let error = 1.0 - reduced.energy_j / solved.energy_j;
        println!("impact {number}: {error:.4} missing, estimated {:?}", reduced.reduced_error);
        assert!(solved.reduced_error.is_none() && reduced.reduced_error.is_some_and(|estimate| estimate <= 0.1));
        assert!((-1e-3..0.15).contains(&error), "{error}");
    }
}
