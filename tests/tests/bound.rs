//! The bound of E_1 before the elastic stage: how often it ends a request, and that it never ends one that would break the object.

use nalgebra::{Point3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, bake, load, save};
use shatter_fracture::lift::LiftKind;
use shatter_fracture::pipeline::{
    DegreeRequest, DisplacementMethod, ElementChoice, FractureOutcome, FractureRequest, ImpactSampler, PreparedObject,
    RequestContext, Stage, StageObserver, Workspace, strike, strike_again,
};
use shatter_fracture::random::RandomStream;
use shatter_fracture::scene::{EffectKind, EffectSet};
use shatter_fracture::strength::Criterion;
use shatter_fracture::surface::{RawMesh, shapes};
use shatter_tests::real;
use shatter_tests::struck::outcome;
use std::cell::RefCell;

fn baked(name: &str, mesh: RawMesh, spacings: [f64; 2]) -> PreparedObject {
    let [elastic_spacing, crack_spacing] = spacings.map(Some);
    let request = BakeRequest { elastic_spacing, crack_spacing, kappa: Some(2.0), ..real::request(name, "ceramic") };
    bake(mesh, &request, &CancelToken::default(), &mut |_| ()).unwrap()
}

/// Two blocks that do not touch.
fn blocks() -> RawMesh {
    let block = |x: f64| {
        let mesh = shapes::cuboid([0.1, 0.2, 0.1]);
        mesh.positions_m.iter().map(move |point| point + Vector3::new(x, 0.0, 0.0)).collect::<Vec<Point3<f64>>>()
    };
    let triangles = shapes::cuboid([0.1, 0.2, 0.1]).triangles;
    let (left, right) = (block(-0.1), block(0.1));
    let count = left.len() as u32;
    let more: Vec<[u32; 3]> = triangles.iter().map(|corners| corners.map(|corner| corner + count)).collect();
    RawMesh::new([left, right].concat(), [triangles, more].concat())
}

/// The same impact with its impulses times `factor`.
fn times(request: &FractureRequest, factor: f64) -> FractureRequest {
    let mut request = request.clone();
    request.contacts.iter_mut().for_each(|contact| contact.impulse_ns *= factor);
    request
}

/// Factor on the impulses that just breaks the object.
fn factor_at_threshold(prepared: &PreparedObject, request: &FractureRequest) -> f64 {
    let exact = FractureRequest { threshold_only: true, ..request.clone() };
    let found = outcome(prepared, &exact).unwrap();
    assert!(!found.threshold().is_bound, "thresholds are exact");
    found.threshold().impulse_factor
}

/// An impact of the object's sampler, as a host sends it.
fn sampled(prepared: &PreparedObject, index: u64) -> FractureRequest {
    FractureRequest { elastic: DisplacementMethod::Reduced, ..ImpactSampler::new(prepared).impact(7, index) }
}

/// Share of 25 sampled impacts that the bound ends, by their share of the threshold, percent.
#[test]
fn most_weak_impacts_end_before_the_elastic_stage() {
    const SHARES: [f64; 4] = [0.01, 1.0 / 30.0, 0.1, 1.0 / 3.0];
    let (linear, quadratic) = (ElementChoice::Linear, ElementChoice::Quadratic);
    for (name, mesh, elements, least) in [
        ("cube", shapes::cuboid([0.2; 3]), linear, [100, 90, 50, 0]),
        ("mug", shapes::mug(), linear, [100, 90, 20, 0]),
        ("horseshoe", shapes::horseshoe(), linear, [100, 60, 10, 0]),
        ("quadratic mug", shapes::mug(), quadratic, [100, 40, 0, 0]),
    ] {
        let request = BakeRequest { elements, kappa: Some(2.0), ..real::request(name, "ceramic") };
        let prepared = bake(mesh, &request, &CancelToken::default(), &mut |_| ()).unwrap();
        let mut ended = [0; SHARES.len()];
        for index in 0..25 {
            let request = sampled(&prepared, index);
            let factor_at_threshold = factor_at_threshold(&prepared, &request);
            for (share, ended) in SHARES.into_iter().zip(&mut ended) {
                let found = outcome(&prepared, &times(&request, share * factor_at_threshold)).unwrap();
                *ended += 4 * u32::from(found.threshold().is_bound);
                let exact = share * share;
                let right = if found.threshold().is_bound { found.threshold().e1_over_gamma >= exact } else { true };
                assert!(right && found.meshes().is_none(), "{} of {exact}", found.threshold().e1_over_gamma);
                assert_eq!(found.threshold().strain_j.is_none(), found.threshold().is_bound);
            }
        }
        println!("{name}: ended at 1/100, 1/30, 1/10 and 1/3 of the threshold: {ended:?} %");
        assert!(ended.iter().zip(least).all(|(ended, least)| *ended >= least), "{ended:?}");
    }
}

/// One to four contacts at random positions, of random direction and magnitude.
fn random(prepared: &PreparedObject, stream: &mut RandomStream) -> FractureRequest {
    let sampler = ImpactSampler::new(prepared);
    let count = 1 + (4.0 * stream.uniform()) as usize;
    let contact = |stream: &mut RandomStream| {
        let (point, _) = sampler.point(stream);
        let direction = Vector3::from_fn(|_, _| stream.uniform() - 0.5);
        let radius_m = prepared.frame.diagonal_m * 0.01 * 40f64.powf(stream.uniform());
        (prepared.frame.to_meters(&point), direction, radius_m)
    };
    let contacts: Vec<_> = (0..count).map(|_| contact(stream)).collect();
    let mut request = FractureRequest::at(contacts[0].0, contacts[0].1).seeded(1);
    request.contacts = contacts
        .into_iter()
        .flat_map(|(point, impulse, radius_m)| {
            let own = FractureRequest::at(point, impulse).contacts;
            own.into_iter()
                .map(move |contact| shatter_fracture::pipeline::ImpactContact { radius_m: Some(radius_m), ..contact })
        })
        .collect();
    request
}

/// All values of an outcome, bitwise.
fn bytes(outcome: &FractureOutcome) -> Vec<u64> {
    let numbers = [
        outcome.threshold().gamma_j_m2,
        outcome.threshold().e1_over_gamma,
        outcome.threshold().impulse_factor,
        outcome.threshold().radius_m,
    ];
    let mut all: Vec<u64> = numbers.iter().map(|number| number.to_bits()).collect();
    all.extend([u64::from(outcome.sites()), u64::from(outcome.fracture_degree()), outcome.degree_source() as u64]);
    if let Some(pieces) = &outcome.meshes() {
        let counts = pieces.counts;
        let mut positions = vec![[0.0f32; 3]; counts.vertices];
        let (mut indices, mut merges) = (vec![0; counts.indices], vec![[0; 2]; counts.merges]);
        pieces.emit(&mut positions, &mut indices, &mut merges).unwrap();
        all.extend(positions.as_flattened().iter().map(|x| u64::from(x.to_bits())));
        all.extend(indices.iter().chain(merges.as_flattened()).map(|&index| u64::from(index)));
    }
    all
}

/// The same object without a bound.
fn without_bounds(mut prepared: PreparedObject) -> PreparedObject {
    prepared.bodies.iter_mut().for_each(|body| body.bound = None);
    prepared
}

/// Random impacts from a thousandth to three times the threshold: those that the bound ends would not have broken the object, and the
/// others give the same bytes as without a bound.
#[test]
fn the_energy_bound_never_ends_a_breaking_request() {
    for (name, mesh) in [("arch", shapes::arch()), ("blocks", blocks()), ("bar", shapes::cuboid([0.6, 0.1, 0.08]))] {
        let prepared = || baked(name, mesh.clone(), [0.08, 0.06]);
        let (prepared, bare) = (prepared(), without_bounds(prepared()));
        let mut stream = RandomStream::new(5, 0);
        let (mut ended, mut broken) = (0, 0);
        for (lift, tensile) in [
            (LiftKind::Interior, false),
            (LiftKind::Interior, true),
            (LiftKind::Euclidean, false),
            (LiftKind::Euclidean, true),
            (LiftKind::SurfaceDiffusion, false),
            (LiftKind::SurfaceDiffusion, true),
        ] {
            let effects = if tensile { EffectSet::default().with(EffectKind::Tensile) } else { EffectSet::default() };
            for _ in 0..50 {
                let request = FractureRequest { lift, effects, degree_max: 3, ..random(&prepared, &mut stream) };
                let factor_at_threshold = factor_at_threshold(&prepared, &request);
                let request = times(&request, factor_at_threshold * 1e-3 * 3000f64.powf(stream.uniform()));
                let (found, exact) = (outcome(&prepared, &request).unwrap(), outcome(&bare, &request).unwrap());
                assert!(!exact.threshold().is_bound);
                if found.threshold().is_bound {
                    ended += 1;
                    assert!(
                        exact.threshold().e1_over_gamma <= found.threshold().e1_over_gamma
                            && found.threshold().e1_over_gamma <= 1.0,
                        "{request:?}"
                    );
                    assert!(
                        exact.threshold().impulse_factor >= found.threshold().impulse_factor
                            && found.threshold().impulse_factor >= 1.0
                    );
                    assert!(exact.meshes().is_none() && found.meshes().is_none());
                    assert_eq!(
                        (found.threshold().radius_m, found.degree_source()),
                        (exact.threshold().radius_m, exact.degree_source())
                    );
                } else {
                    broken += u32::from(found.meshes().is_some());
                    assert_eq!(bytes(&found), bytes(&exact), "{request:?}");
                }
            }
        }
        println!("{name}: of 300 strikes {ended} ended by the bound, {broken} broke");
        assert!(ended > 60 && broken > 30, "{ended} ended, {broken} broke");
    }
}

/// Impacts by the criterion of strength end with the displacement of the basis alone where that tells less than a quarter of
/// the strength, with an error of the energy of up to a half. The stress of a solve is still below the strength then.
#[test]
fn weak_impacts_need_the_basis_alone() {
    for (name, mesh) in [("mug", shapes::mug()), ("arch", shapes::arch()), ("plate", shapes::cuboid([0.5, 0.4, 0.03]))]
    {
        let request =
            BakeRequest { kappa: Some(2.0), elements: ElementChoice::Quadratic, ..real::request(name, "ceramic") };
        let prepared = bake(mesh, &request, &CancelToken::default(), &mut |_| ()).unwrap();
        let (mut stream, mut least, mut judged, mut weak) = (RandomStream::new(9, 0), f64::INFINITY, 0, 0);
        for _ in 0..60 {
            let request = FractureRequest { criterion: Criterion::Strength, ..random(&prepared, &mut stream) };
            let stress = |request: FractureRequest| {
                let found = outcome(&prepared, &FractureRequest { threshold_only: true, ..request }).unwrap();
                (found.threshold().onset.unwrap().stress_over_strength, found.threshold().reduced_error)
            };
            let reduced = FractureRequest { elastic: DisplacementMethod::Reduced, ..request.clone() };
            let (alone, error) = stress(FractureRequest { reduced_error_max: 10.0, ..reduced.clone() });
            let (solved, _) = stress(FractureRequest { elastic: DisplacementMethod::Solve, ..request.clone() });
            let is_rough = |own: &FractureOutcome| {
                own.threshold().reduced_error.is_some_and(|error| error > reduced.reduced_error_max)
            };
            let found = outcome(&prepared, &times(&reduced, 0.2 / solved)).unwrap();
            assert!(found.meshes().is_none(), "{request:?}");
            weak += u32::from(is_rough(&found));
            // Stresses from half of the strength on are as accurate as the request asks.
            for share in [0.5, 1.05, 2.0] {
                let found =
                    outcome(&prepared, &times(&FractureRequest { degree_max: 3, ..reduced.clone() }, share / solved));
                assert!(!is_rough(&found.unwrap()), "{share}: {request:?}");
            }
            if error.is_some_and(|error| error <= 0.5) {
                (least, judged) = (least.min(alone / solved), judged + 1);
            }
        }
        println!("{name}: stress of the basis over that of solves at least {least:.3} of {judged} of 60; {weak} weak");
        assert!(least > 0.5 && judged > 50 && weak > 0, "{name}: {least} of {judged}");
    }
}

/// Stages that ran, and effects that they reported.
#[derive(Default)]
struct Ran(RefCell<Vec<&'static str>>, RefCell<Vec<EffectKind>>);

impl StageObserver for Ran {
    fn enter(&self, stage: Stage) {
        self.0.borrow_mut().push(stage.name());
    }
    fn leave(&self, _: Stage, _: u64) {}
    fn begin(&self, effect: EffectKind) {
        self.1.borrow_mut().push(effect);
    }
    fn end(&self, effect: EffectKind, _: u64) {
        self.1.borrow_mut().push(effect);
    }
    fn part(&self, effect: EffectKind, _: u64) {
        self.1.borrow_mut().push(effect);
    }
}

/// Runs a request, and checks whether the bound ends it (`ends`).
#[track_caller]
fn check(prepared: &PreparedObject, request: &FractureRequest, ends: bool) {
    let ran = Ran::default();
    let found =
        strike(RequestContext::new(prepared, request, &CancelToken::default(), &ran), &mut Workspace::default())
            .unwrap();
    assert_eq!(found.threshold().is_bound, ends, "{request:?}");
    if ends {
        // The load stage runs for the contacts, and once per body.
        let (mut stages, effects) = (ran.0.into_inner(), ran.1.into_inner());
        stages.dedup();
        assert_eq!((stages, effects), (vec!["load", "threshold"], vec![]), "{request:?}");
    }
}

#[test]
fn exact_figures_disable_the_energy_bound() {
    let prepared = baked("arch", shapes::arch(), [0.08, 0.06]);
    let request = sampled(&prepared, 0);
    let request = times(&request, 0.01 * factor_at_threshold(&prepared, &request));
    let default = EffectSet::default();
    for degree in
        [DegreeRequest::Inferred, DegreeRequest::ClosedForm, DegreeRequest::Verified, DegreeRequest::Optimized]
    {
        check(&prepared, &FractureRequest { degree, ..request.clone() }, true);
    }
    check(&prepared, &FractureRequest { effects: default.without(EffectKind::Interior), ..request.clone() }, true);
    check(&prepared, &FractureRequest { degree: DegreeRequest::Sites(2), ..request.clone() }, false);
    check(&prepared, &FractureRequest { elastic: DisplacementMethod::Solve, ..request.clone() }, false);
    check(&prepared, &FractureRequest { threshold_only: true, ..request.clone() }, false);
    check(&prepared, &FractureRequest { effects: default.without(EffectKind::Elastic), ..request.clone() }, false);
    // A stored bound, and a file without one.
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("arch.shatter");
    save(&prepared, &file).unwrap();
    let stored = load(&file).unwrap();
    assert_eq!(stored.bodies[0].bound, prepared.bodies[0].bound);
    check(&stored, &request, true);
    save(&without_bounds(stored), &file).unwrap();
    check(&load(&file).unwrap(), &request, false);
}

#[test]
fn a_fragment_that_is_struck_again_has_no_bound() {
    let prepared = baked("arch", shapes::arch(), [0.08, 0.06]);
    let (node, own) = (prepared.bodies[0].crack.nodes[0], Vector3::new(0.3, -1.0, 0.2));
    let request = FractureRequest::at(prepared.frame.to_meters(&node), own).seeded(1);
    let broken = outcome(&prepared, &FractureRequest { degree: DegreeRequest::Sites(2), ..request })
        .unwrap()
        .into_meshes()
        .unwrap();
    let kept = broken.keep();
    let (mut workspace, token) = (Workspace::default(), CancelToken::default());
    let struck = prepared.bodies[0].crack.nodes.iter().find_map(|node| {
        let weak = FractureRequest::at(prepared.frame.to_meters(node), own * 1e-6).seeded(1);
        strike_again(RequestContext::new(&prepared, &weak, &token, &()), (&kept, 0), &mut workspace).ok()
    });
    let struck = struck.expect("some node is of the fragment");
    assert!(!struck.threshold().is_bound && struck.meshes().is_none() && struck.threshold().e1_over_gamma < 1e-3);
}

/// Requests that the bound does not cover are solved for.
#[test]
fn an_object_that_is_to_be_solved_has_no_bound() {
    let request = BakeRequest {
        elastic_spacing: Some(0.08),
        crack_spacing: Some(0.06),
        kappa: Some(2.0),
        elastic: DisplacementMethod::Solve,
        ..real::request("arch", "ceramic")
    };
    let prepared = bake(shapes::arch(), &request, &CancelToken::default(), &mut |_| ()).unwrap();
    assert!(prepared.bodies.iter().all(|body| body.bound.is_none()));
}
