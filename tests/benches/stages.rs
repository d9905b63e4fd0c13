//! Time per stage of a request, and of baking. `cargo bench` runs it on a generated mug, and on the mesh file that `SHATTER_BENCH_MESH`
//! names, if it is set.

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Point3;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::centroidal::{self, DiagramOptions, EnergyField};
use shatter_fracture::database::bake;
use shatter_fracture::degree;
use shatter_fracture::fragment::properties;
use shatter_fracture::lift::{self, Extension, SURFACE_MODES_DEFAULT};
use shatter_fracture::pipeline::{
    self, ContactSet, DegreeRequest, FractureRequest, PreparedObject, RequestContext, Workspace, strain_energy,
};
use shatter_fracture::surface::{self, LengthUnit, RawMesh, UpAxis, shapes};
use shatter_fracture::tessellation::{BisectorSites, Components, CrackPoints, FixedPoints, Tessellation};
use shatter_tests::real;
use std::hint::black_box;

const SITES: u32 = 50;

fn mesh() -> RawMesh {
    match std::env::var_os("SHATTER_BENCH_MESH") {
        Some(path) => surface::read(path.as_ref(), LengthUnit::M, UpAxis::Y).unwrap(),
        None => shapes::mug(),
    }
}

fn request(prepared: &PreparedObject) -> FractureRequest {
    let body = &prepared.bodies[0];
    let node = body.topology.boundary[body.topology.boundary.len() / 2].nodes[0];
    let point: Point3<f64> = body.crack.nodes[node as usize];
    let request = FractureRequest::at(prepared.frame.to_meters(&point), -point.coords).seeded(1);
    FractureRequest { degree: DegreeRequest::Sites(SITES), ..request }
}

fn stages(criterion: &mut Criterion) {
    let prepared = bake(mesh(), &real::request("bench", "ceramic"), &CancelToken::default(), &mut |_| ()).unwrap();
    println!("{} elastic nodes, {} crack nodes, {SITES} sites", prepared.elastic_nodes(), prepared.crack_nodes());
    let (strike, token) = (request(&prepared), CancelToken::default());
    let mut workspace = Workspace::default();
    let body = &prepared.bodies[0];
    let impact = ContactSet::new(&prepared, &strike).unwrap();

    criterion.bench_function("load and elasticity", |bencher| {
        bencher.iter(|| {
            strain_energy(RequestContext::new(&prepared, &strike, &token, &()), black_box(&impact), &mut workspace)
                .unwrap()
        })
    });
    let mut shares = strain_energy(RequestContext::new(&prepared, &strike, &token, &()), &impact, &mut workspace)
        .unwrap()
        .remove(0)
        .shares;
    let field = EnergyField::new(body.interior.as_ref().unwrap(), &body.volumes, &mut shares).unwrap();
    criterion.bench_function("threshold", |bencher| bencher.iter(|| degree::first_moment(black_box(&field))));
    criterion.bench_function("degree (closed form)", |bencher| {
        bencher.iter(|| degree::closed_form(black_box(&field), &body.slenderness, 1.0))
    });
    let options = DiagramOptions::new(SITES as usize, 1);
    let mut cells = centroidal::DiagramWorkspace::default();
    criterion.bench_function("centroidal", |bencher| {
        bencher.iter(|| centroidal::diagram(black_box(&field), &options, &mut cells, &token).unwrap())
    });
    let diagram = centroidal::diagram(&field, &options, &mut cells, &token).unwrap();
    let mut components = Components::default();
    criterion.bench_function("labels", |bencher| {
        bencher.iter(|| components.split(&body.topology, black_box(&diagram.labels)))
    });
    let (mut points, mut tessellation) = (CrackPoints::default(), Tessellation::default());
    let mut scratch = shatter_fracture::tessellation::TessellationWorkspace::default();
    criterion.bench_function("tessellation", |bencher| {
        bencher.iter(|| {
            let sites = BisectorSites {
                lift: body.interior.as_ref().unwrap(),
                coordinates: &diagram.sites,
                of_fragment: &components.sites,
                of_node: None,
            };
            let fixed = FixedPoints::default();
            points.find(&body.crack, &body.topology, &components.labels, Some(sites), &fixed).unwrap();
            tessellation.build(&body.crack, &body.topology, &components.labels, &points, &mut scratch).unwrap();
        })
    });
    let mut measured = Vec::new();
    criterion.bench_function("fragments (properties)", |bencher| {
        bencher.iter(|| properties(black_box(&tessellation), &mut measured))
    });
    criterion.bench_function("strike with emission", |bencher| {
        bencher.iter(|| {
            let outcome =
                pipeline::strike(pipeline::RequestContext::new(&prepared, &strike, &token, &()), &mut workspace)
                    .unwrap();
            let pieces = outcome.into_meshes().unwrap();
            let mut positions = vec![[0.0; 3]; pieces.counts.vertices];
            let mut indices = vec![0; pieces.counts.indices];
            let mut merges = vec![[0; 2]; pieces.counts.merges];
            pieces.emit(&mut positions, &mut indices, &mut merges).unwrap();
            (positions, indices, merges)
        })
    });
    criterion.bench_function("bake: interior lift", |bencher| {
        bencher
            .iter(|| lift::interior(&body.crack, prepared.parameters.modes, prepared.parameters.alpha, &token).unwrap())
    });
    criterion.bench_function("bake: surface lift", |bencher| {
        bencher
            .iter(|| lift::surface_diffusion(&body.crack, Extension::Harmonic, SURFACE_MODES_DEFAULT, &token).unwrap())
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = stages
}
criterion_main!(benches);
