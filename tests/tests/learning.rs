//! The degree inferred from examples: its accuracy, and that it is stored and used as it was learned.

use rayon::ThreadPoolBuilder;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::centroidal::EnergyField;
use shatter_fracture::database::{BakeRequest, BakeShare, PartialBake, bake, load, save};
use shatter_fracture::degree::{self, SITES_MIN};
use shatter_fracture::lift::LiftKind;
use shatter_fracture::pipeline::{
    ContactSet, DegreeRequest, DegreeSource, DisplacementMethod, FractureOutcome, FractureRequest, ImpactContact,
    ImpactSampler, PreparedObject, RequestContext, TrainingExample, Workspace, examples, sampled, strain_energy,
    strike,
};
use shatter_fracture::random::RandomStream;
use shatter_fracture::surface::shapes;
use shatter_tests::real;
use std::sync::LazyLock;

/// The same for all tests that do not bake it their own way.
static HORSESHOE: LazyLock<PreparedObject> = LazyLock::new(horseshoe);

/// A horseshoe on coarse lattices that learned from 24 impacts.
fn horseshoe() -> PreparedObject {
    horseshoe_after(24)
}

fn horseshoe_after(examples: u64) -> PreparedObject {
    let request = BakeRequest {
        elastic_spacing: Some(0.08),
        crack_spacing: Some(0.05),
        examples,
        ..real::request("horseshoe", "stone")
    };
    bake(shapes::horseshoe(), &request, &CancelToken::default(), &mut |_| ()).unwrap()
}

fn struck(prepared: &PreparedObject, strike_: &FractureRequest) -> FractureOutcome {
    strike(RequestContext::new(prepared, strike_, &CancelToken::default(), &()), &mut Workspace::default()).unwrap()
}

/// An impact like the examples, but not one of them, with `times` the breaking impulse.
fn request(prepared: &PreparedObject, times: f64, degree: DegreeRequest) -> FractureRequest {
    let like = ImpactSampler::new(prepared).impact(!prepared.parameters.seed, 0);
    let factor = struck(prepared, &FractureRequest { threshold_only: true, ..like.clone() }).threshold().impulse_factor;
    let harder =
        |contact: &ImpactContact| ImpactContact { impulse_ns: contact.impulse_ns * factor * times, ..*contact };
    FractureRequest { contacts: like.contacts.iter().map(harder).collect(), degree, ..like }
}

#[test]
fn what_was_learned_is_stored_and_the_same_for_any_number_of_threads() {
    let pool = |threads| ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let known = |of: &PreparedObject| (of.examples.clone(), of.learned.clone(), of.kappa);
    let (one, three) = (pool(1).install(horseshoe), pool(3).install(horseshoe));
    assert_eq!(known(&one), known(&three));
    let folder = tempfile::tempdir().unwrap();
    let [first, second] = ["a", "b"].map(|name| folder.path().join(name));
    save(&one, &first).unwrap();
    let loaded = load(&first).unwrap();
    assert_eq!(known(&loaded), known(&one));
    save(&loaded, &second).unwrap();
    assert_eq!(std::fs::read(first).unwrap(), std::fs::read(second).unwrap());
}

#[test]
fn examples_that_are_added_are_those_of_an_undivided_bake() {
    let folder = tempfile::tempdir().unwrap();
    let file = |prepared: &PreparedObject, name: &str| {
        let path = folder.path().join(name);
        save(prepared, &path).unwrap();
        (load(&path).unwrap(), std::fs::read(path).unwrap())
    };
    let (part, _) = file(&horseshoe_after(10), "part");
    let more = PartialBake::add(part, 14, BakeShare::WHOLE).unwrap();
    let part = more.complete(&CancelToken::default(), &mut |_| ()).unwrap();
    assert!(file(&part, "added").1 == file(&HORSESHOE, "whole").1);
}

#[test]
fn degrees_are_inferred_within_reach_and_said_to_be() {
    let prepared = &*HORSESHOE;
    let quality = prepared.learned.as_ref().unwrap().quality;
    println!("{quality:?}");
    assert!(quality.median_relative_error < quality.pose_network_median, "{quality:?}");
    assert!(quality.label_noise_median < 0.2, "{quality:?}");
    let source = |times: f64, degree| struck(prepared, &request(prepared, times, degree)).degree_source();
    assert_eq!(source(0.5, DegreeRequest::Inferred), DegreeSource::Threshold);
    assert_eq!(source(8.0, DegreeRequest::Inferred), DegreeSource::Inferred);
    assert_eq!(source(8.0, DegreeRequest::ClosedForm), DegreeSource::ClosedForm);
    assert_eq!(source(8.0, DegreeRequest::Verified), DegreeSource::Verified);
    assert_eq!(source(1e5, DegreeRequest::Inferred), DegreeSource::ClosedForm, "no example is so violent");
    let euclidean = FractureRequest { lift: LiftKind::Euclidean, ..request(prepared, 8.0, DegreeRequest::Inferred) };
    assert_eq!(
        struck(prepared, &euclidean).degree_source(),
        DegreeSource::ClosedForm,
        "examples have the interior lift"
    );
    let inferred = struck(prepared, &request(prepared, 8.0, DegreeRequest::Inferred));
    assert!((0.6..=1.0).contains(&inferred.confidence()), "{}", inferred.confidence());
}

/// Largest E_i of the fragments over γ.
fn excess(outcome: &FractureOutcome) -> f64 {
    let pieces = outcome.meshes().unwrap();
    pieces.fragments.iter().map(|row| row.energy_j_m2).fold(0.0, f64::max) / outcome.threshold().gamma_j_m2
}

#[test]
fn a_verified_degree_holds_and_is_near_the_optimized_one() {
    let prepared = &*HORSESHOE;
    for times in [1.1, 3.0, 8.0, 20.0] {
        let of = |degree| struck(prepared, &request(prepared, times, degree));
        let (verified, optimized) = (of(DegreeRequest::Verified), of(DegreeRequest::Optimized));
        assert!(excess(&verified) <= 1.0 + 1e-12, "{times}: {}", excess(&verified));
        let (found, wanted) = (f64::from(verified.fracture_degree()), f64::from(optimized.fracture_degree()));
        println!("{times}: verified {found}, optimized {wanted}");
        assert!((found - wanted).abs() <= (0.15 * wanted).max(1.0), "{times}: {found} against {wanted}");
    }
}

/// Thresholds of an example, drawn uniformly in the logarithm, with n₀ (interpolated between its labels: nearly a power law) and the
/// degree.
fn drawn(example: &TrainingExample) -> Vec<(f64, f64, u32)> {
    let labels: Vec<(f64, f64, u32)> = example.labels().collect();
    let (most, least) = (labels[0].0.ln(), labels[labels.len() - 1].0.ln());
    let mut stream = RandomStream::new(example.impact, 77);
    let mut draw = || -> Option<(f64, f64, u32)> {
        let gamma = (most + (least - most) * stream.uniform()).exp();
        let above = labels.iter().rposition(|label| label.0 >= gamma)?;
        let ([high, low], sites) = ([labels[above], *labels.get(above + 1)?], example.degree(gamma)?);
        let share = (gamma / high.0).ln() / (low.0 / high.0).ln();
        let estimate = (high.1.ln() + share * (low.1 / high.1).ln()).exp();
        Some((gamma, estimate, sites))
    };
    (0..20).filter_map(|_| draw()).collect()
}

/// Errors over impacts that were not learned: relative errors of network and closed form if n ≥ 8, and the share of the others for which
/// the network is off by one at most.
fn held_out(prepared: &PreparedObject, impacts: u64) -> ([Vec<f64>; 2], f64) {
    let learned = prepared.learned.as_ref().unwrap();
    let sampler = ImpactSampler::new(prepared);
    let own = |index| {
        let (mut workspace, token) = (Workspace::default(), CancelToken::default());
        examples(prepared, &sampler, !prepared.parameters.seed, index, &mut workspace, &token).unwrap()
    };
    let mut errors = [Vec::new(), Vec::new()];
    let mut few = [0, 0];
    for example in (0..impacts).flat_map(own) {
        for (gamma, estimate, sites) in drawn(&example) {
            let output =
                learned.network.predict(&degree::descriptor(estimate, example.first_moment, example.evenness, gamma));
            let error = |found: f64| (found.round() / f64::from(sites) - 1.0).abs();
            let network = degree::sites(output.value, estimate);
            if (sites as usize) < SITES_MIN {
                let close = (network.round().max(2.0) - f64::from(sites)).abs() <= 1.0;
                few = [few[0] + usize::from(close), few[1] + 1];
                continue;
            }
            errors[0].push(error(network));
            errors[1].push(error(prepared.kappa * estimate));
        }
    }
    errors.iter_mut().for_each(|errors| errors.sort_by(f64::total_cmp));
    (errors, few[0] as f64 / few[1] as f64)
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * share) as usize]
}

/// Checks the median (at most 6 % or 1.5 times the noise of labels), nine of ten within 20 %, no worse than the closed form, better than
/// pose; and nine of ten degrees below 8 off by one at most.
fn check(prepared: &PreparedObject, impacts: u64) {
    let quality = prepared.learned.as_ref().unwrap().quality;
    let ([network, closed], few) = held_out(prepared, impacts);
    let figures = [&network, &closed].map(|errors| [0.5, 0.9].map(|share| quantile(errors, share)));
    println!(
        "{}: {} labels held out: network {:?}, closed form {:?}; below 8 within one {few:.3}; {quality:?}",
        prepared.name,
        network.len(),
        figures[0],
        figures[1]
    );
    assert!(figures[0][0] <= 0.06_f64.max(1.5 * quality.label_noise_median), "{figures:?}");
    assert!(figures[0][1] <= 0.20, "{figures:?}");
    assert!(few >= 0.9, "{few}");
    assert!(
        figures[0][0] <= figures[1][0] && quality.median_relative_error < quality.pose_network_median,
        "{figures:?}"
    );
}

#[test]
#[ignore = "minutes: 200 examples and 100 held out impacts of three objects; run with --ignored"]
fn two_hundred_examples_teach_the_degree() {
    let with_examples = |request: BakeRequest| BakeRequest { examples: 200, ..request };
    let baked = |raw, name| {
        bake(raw, &with_examples(real::request(name, "glass")), &CancelToken::default(), &mut |_| ()).unwrap()
    };
    check(&baked(shapes::horseshoe(), "horseshoe"), 100);
    for file in ["horse.ply", "stanford-bunny.obj"] {
        if let Some(raw) = real::raw(file) {
            check(&baked(raw, file), 100);
        }
    }
}

#[test]
fn an_example_is_the_field_of_its_impact() {
    let prepared = &*HORSESHOE;
    let all = sampled(prepared, &[0, 1, 2, 3], &CancelToken::default()).unwrap();
    assert_eq!(all[..], prepared.examples[..all.len()]);
    let TrainingExample { impact, contacts, first_moment, body, .. } = &all[2];
    let at = FractureRequest::at(contacts[0].point_m, contacts[0].impulse_ns).seeded(1);
    let again = FractureRequest { contacts: contacts.clone(), seed: *impact, elastic: DisplacementMethod::Solve, ..at };
    let impact = ContactSet::new(prepared, &again).unwrap();
    let mut energies = strain_energy(
        RequestContext::new(prepared, &again, &CancelToken::default(), &()),
        &impact,
        &mut Workspace::default(),
    )
    .unwrap();
    let energy = energies.iter_mut().find(|energy| energy.body == *body).unwrap();
    let own = &prepared.bodies[*body];
    let field = EnergyField::new(own.interior.as_ref().unwrap(), &own.volumes, &mut energy.shares).unwrap();
    assert_eq!(degree::first_moment(&field), *first_moment);
}
