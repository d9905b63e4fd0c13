//! Strikes with a time, through the daemon: how often it is kept. Nothing is asserted of it but what holds on every machine.

mod support;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use shatter_client::{Impact, Object, Quality};
use shatter_fracture::database::{BakeRequest, bake, save};
use shatter_fracture::pipeline::Sampler;
use shatter_fracture::scene::Materials;
use shatter_fracture::surface::shapes;
use shatter_fracture::token::Token;
use shatter_server::wire;
use std::collections::BTreeMap;
use support::{InProcess, TestPlace, patience};

/// Strikes of each time.
const STRIKES: u64 = 250;

/// Times, ms.
const TIMES_MS: [f64; 4] = [6.0, 8.0, 12.0, 16.7];

/// Times of strikes of a preset without a time, ms, sorted.
fn free(statue: &Object, impacts: &[Impact], quality: Quality) -> Vec<f64> {
    let time = |impact: &Impact| {
        let broken = statue.strike(&impact.clone().quality(quality)).unwrap().wait(patience()).unwrap();
        broken.summary().time_ns as f64 * 1e-6
    };
    let mut times: Vec<f64> = impacts.iter().map(time).collect();
    times.sort_by(f64::total_cmp);
    times
}

#[test]
#[ignore = "a minute; says how well times are kept"]
fn times_that_are_asked_for() {
    let here = TestPlace::new("times");
    let materials = Materials::parse(include_str!("../../config/materials.toml")).unwrap();
    let plaster = materials.get("plaster").unwrap().clone();
    let request = BakeRequest { examples: 40, ..BakeRequest::new("statue", "plaster", plaster) };
    let prepared = bake(shapes::statue(), &request, &Token::default(), &mut |_| ()).unwrap();
    save(&prepared, &here.databases().join("statue.shatter")).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let sampler = Sampler::new(&prepared);
    let impacts: Vec<Impact> = (0..STRIKES)
        .map(|index| {
            let contact = sampler.impact(11, index).contacts[0];
            let sites = 10 + (random.next_u64() % 90) as u32;
            let impact = Impact::at(contact.point_m.into()).impulse(contact.impulse_ns.into()).seed(index);
            impact.degree(shatter_client::Degree::Sites(sites))
        })
        .collect();
    let daemon = InProcess::start_with(here, "", wire::loader(None));
    let statue = daemon.connect().object("statue", patience()).unwrap();
    for quality in [Quality::Draft, Quality::Game] {
        let times = free(&statue, &impacts, quality);
        let [p50, p95] = [0.5, 0.95].map(|share| times[(times.len() as f64 * share) as usize]);
        println!("{}: {p50:.2} ms, 95 % within {p95:.2} ms", quality.name());
    }
    for time_ms in TIMES_MS {
        let (mut met, mut ends, mut iterations, mut gaps) = (0, BTreeMap::new(), 0, Vec::new());
        for impact in &impacts {
            let broken = statue.strike(&impact.clone().time_ms(time_ms)).unwrap().wait(patience()).unwrap();
            assert!(broken.fragments().all(|fragment| fragment.is_closed()));
            let summary = broken.summary();
            met += u32::from(summary.time_ns as f64 * 1e-6 <= time_ms);
            *ends.entry(summary.stop_reason()).or_insert(0) += 1;
            iterations += summary.iterations;
            gaps.push(summary.cvd_gap);
        }
        gaps.sort_by(f64::total_cmp);
        let (share, mean) = (100.0 * f64::from(met) / STRIKES as f64, f64::from(iterations) / STRIKES as f64);
        let gap = 100.0 * gaps[gaps.len() / 2];
        println!(
            "{time_ms} ms: kept by {share:.1} %, {mean:.1} iterations, gap {gap:.2} % (estimated, median), {ends:?}"
        );
    }
}
