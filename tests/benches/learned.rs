//! Savings by examples: displacements without a solve, degrees without an optimization; and the time for loading a database with them.
//! `cargo bench --bench learned` runs it on a generated mug, and on the mesh file that `SHATTER_BENCH_MESH` names, if it is set;
//! `SHATTER_BENCH_EXAMPLES` sets the number of impacts to learn from (40 by default).

use criterion::{Criterion, criterion_group, criterion_main};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::centroidal::{self, EnergyField};
use shatter_fracture::database::{BakeRequest, bake, load, save};
use shatter_fracture::degree::{self, CurveOptions, EnergyCurve};
use shatter_fracture::elasticity::{self, NodalLoad};
use shatter_fracture::pipeline::{
    ContactSet, DisplacementMethod, FractureRequest, ImpactSampler, PreparedObject, RequestContext, Workspace,
    strain_energy,
};
use shatter_fracture::surface::{self, LengthUnit, RawMesh, UpAxis, shapes};
use shatter_tests::real;
use std::hint::black_box;

/// E_1/γ at which the degree is inferred: some thirty sites.
const DRIVE: f64 = 300.0;

fn mesh() -> RawMesh {
    match std::env::var_os("SHATTER_BENCH_MESH") {
        Some(path) => surface::read(path.as_ref(), LengthUnit::M, UpAxis::Y).unwrap(),
        None => shapes::mug(),
    }
}

fn prepared() -> PreparedObject {
    let examples = std::env::var("SHATTER_BENCH_EXAMPLES").map_or(40, |count| count.parse().unwrap());
    let request = BakeRequest { examples, ..real::request("bench", "ceramic") };
    bake(mesh(), &request, &CancelToken::default(), &mut |_| ()).unwrap()
}

/// The first impact on one body that is not an example and needs no solve.
fn request(prepared: &PreparedObject) -> FractureRequest {
    let (sampler, mut workspace) = (ImpactSampler::new(prepared), Workspace::default());
    let drawn = |index| sampler.impact(!prepared.parameters.seed, index);
    let mut strikes = (0..1000).map(|index| FractureRequest { elastic: DisplacementMethod::Reduced, ..drawn(index) });
    let reduced = |strike: &FractureRequest| {
        let impact = ContactSet::new(prepared, strike).unwrap();
        let energies =
            strain_energy(RequestContext::new(prepared, strike, &CancelToken::default(), &()), &impact, &mut workspace)
                .unwrap();
        energies.len() == 1 && energies[0].reduced_error.is_some()
    };
    strikes.find(reduced).unwrap()
}

fn learned(criterion: &mut Criterion) {
    let prepared = prepared();
    println!("{} elastic nodes, {:?}", prepared.elastic_nodes(), prepared.reduction);
    let (body, token) = (&prepared.bodies[0], CancelToken::default());
    let solid = body.solid.as_ref().unwrap();
    let reduced = solid.reduced.as_ref().unwrap();
    let solve = FractureRequest { elastic: DisplacementMethod::Solve, ..request(&prepared) };
    let requests = [solve.clone(), FractureRequest { elastic: DisplacementMethod::Reduced, ..solve }];
    let impacts = requests.each_ref().map(|request| ContactSet::new(&prepared, request).unwrap());

    let (mut load_, mut workspace, mut displacement) =
        (NodalLoad::default(), elasticity::ElasticWorkspace::default(), Vec::new());
    solid.elasticity.load(&impacts[0].bodies[0].1, &mut load_, &mut workspace).unwrap();
    criterion.bench_function("displacement: solve", |bencher| {
        bencher.iter(|| {
            solid.elasticity.solve(black_box(&load_.forces), &mut displacement, &mut workspace, &token).unwrap()
        })
    });
    let mut coordinates = Vec::new();
    criterion.bench_function("displacement: reduced", |bencher| {
        bencher.iter(|| {
            reduced.project(black_box(&load_), &mut coordinates);
            let residual = reduced.residual(&solid.elasticity, &load_, &coordinates, &mut workspace);
            reduced.expand(&coordinates, &mut displacement, &mut workspace);
            residual
        })
    });
    let mut workspace = Workspace::default();
    let names = ["load and elasticity: solve", "load and elasticity: reduced"];
    for ((name, impact), request) in names.into_iter().zip(&impacts).zip(&requests) {
        criterion.bench_function(name, |bencher| {
            bencher.iter(|| {
                strain_energy(RequestContext::new(&prepared, request, &token, &()), black_box(impact), &mut workspace)
                    .unwrap()
            })
        });
    }

    let mut shares =
        strain_energy(RequestContext::new(&prepared, &requests[0], &token, &()), &impacts[0], &mut workspace)
            .unwrap()
            .remove(0)
            .shares;
    let field = EnergyField::new(body.interior.as_ref().unwrap(), &body.volumes, &mut shares).unwrap();
    let first_moment = degree::first_moment(&field);
    let gamma = first_moment / DRIVE;
    let network = &prepared.learned.as_ref().unwrap().network;
    criterion.bench_function("degree: inferred", |bencher| {
        bencher.iter(|| {
            let [estimate, evenness] = degree::closed_form_and_evenness(black_box(&field), &body.slenderness, gamma);
            degree::sites(network.predict(&degree::descriptor(estimate, first_moment, evenness, gamma)).value, estimate)
        })
    });
    let mut cells = centroidal::DiagramWorkspace::default();
    criterion.bench_function("degree: optimized", |bencher| {
        bencher.iter(|| {
            let mut curve = EnergyCurve::new(&field, CurveOptions::default());
            curve.extend(black_box(&field), gamma, &mut cells, &token).unwrap();
            curve.points().len()
        })
    });

    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bench.shatter");
    save(&prepared, &file).unwrap();
    println!("database: {} bytes", std::fs::metadata(&file).unwrap().len());
    criterion.bench_function("load and verify the database", |bencher| bencher.iter(|| load(&file).unwrap()));
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = learned
}
criterion_main!(benches);
