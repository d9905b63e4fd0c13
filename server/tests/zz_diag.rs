//! Diagnosis.
mod support;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use shatter_client::{Impact, Quality};
use shatter_fracture::database::{BakeRequest, bake, load, save};
use shatter_fracture::pipeline::Sampler;
use shatter_fracture::scene::Materials;
use shatter_fracture::surface::shapes;
use shatter_fracture::token::Token;
use shatter_server::wire;
use support::{InProcess, TestPlace, patience};
#[test]
#[ignore]
fn diag() {
    let here = TestPlace::new("diag");
    let materials = Materials::parse(include_str!("../../config/materials.toml")).unwrap();
    let plaster = materials.get("plaster").unwrap().clone();
    let kept = std::path::Path::new("/tmp/h3_statue.shatter");
    if !kept.exists() {
        let request = BakeRequest { examples: 40, ..BakeRequest::new("statue", "plaster", plaster) };
        let prepared = bake(shapes::statue(), &request, &Token::default(), &mut |_| ()).unwrap();
        save(&prepared, kept).unwrap();
    }
    std::fs::copy(kept, here.databases().join("statue.shatter")).unwrap();
    let prepared = load(kept).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let sampler = Sampler::new(&prepared);
    let impacts: Vec<Impact> = (0..250)
        .map(|index| {
            let contact = sampler.impact(11, index).contacts[0];
            let sites = 10 + (random.next_u64() % 90) as u32;
            let impact = Impact::at(contact.point_m.into()).impulse(contact.impulse_ns.into()).seed(index);
            impact.degree(shatter_client::Degree::Sites(sites))
        })
        .collect();
    let daemon = InProcess::start_with(here, "", wire::loader(None));
    let statue = daemon.connect().object("statue", patience()).unwrap();
    let modes: [(&str, f64); 7] =
        [("draft", 0.0), ("game", 0.0), ("zero", 0.0), ("t", 6.0), ("t", 8.0), ("t", 12.0), ("t", 16.7)];
    for (name, time_ms) in modes {
        for impact in &impacts {
            let impact = impact.clone();
            let impact = match name {
                "draft" => impact.quality(Quality::Draft),
                "game" => impact,
                "zero" => impact.iterations(0),
                _ => impact.time_ms(time_ms),
            };
            let broken = statue.strike(&impact).unwrap().wait(patience()).unwrap();
            let s = broken.summary();
            let stages: Vec<String> =
                broken.stages().iter().map(|row| format!("{:.4}", row.ns as f64 * 1e-6)).collect();
            let tris: u32 = broken.fragments().map(|f| f.indices().len() as u32 / 3).sum();
            println!(
                "ROW,{name},{time_ms},{},{},{},{:.4},{},{:.5},{:.4},{},{}",
                s.sites,
                s.iterations,
                s.stop_reason(),
                s.time_ns as f64 * 1e-6,
                s.elastic(),
                s.energy_error,
                s.cvd_gap,
                tris,
                stages.join(",")
            );
        }
    }
}
