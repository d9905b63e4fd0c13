//! Load and elasticity of a request, stage by stage, beside a plain implementation of each: the gain of stored gradients, sequential reads,
//! and rows shared among threads. `cargo bench --bench elastic` runs it on a generated mug and a generated statue, and on the mesh file
//! that `SHATTER_BENCH_MESH` names, if it is set. Ratios are valid within one run.

use criterion::{BenchmarkGroup, Criterion, criterion_group, criterion_main, measurement::WallTime};
use nalgebra::{Matrix3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, bake};
use shatter_fracture::elasticity::{self, DrivingEnergy, Elasticity, NodalLoad};
use shatter_fracture::lattice::{EnergyTransfer, Lattice};
use shatter_fracture::pipeline::{
    ContactSet, DisplacementMethod, ElasticModel, FractureRequest, ImpactSampler, PreparedObject, RANK_MAX,
    RequestContext, Workspace, reduce, strain_energy,
};
use shatter_fracture::sparse::Precision;
use shatter_fracture::surface::{self, LengthUnit, RawMesh, UpAxis, shapes};
use shatter_tests::real;
use std::hint::black_box;

/// Number of impacts for each basis.
const IMPACTS: u64 = 120;

fn meshes() -> Vec<(String, RawMesh)> {
    let named = std::env::var_os("SHATTER_BENCH_MESH").map(|path| {
        let mesh = surface::read(path.as_ref(), LengthUnit::M, UpAxis::Y).unwrap();
        ("mesh".to_owned(), mesh)
    });
    let made = [("mug", shapes::mug()), ("statue", shapes::statue())].map(|(name, mesh)| (name.to_owned(), mesh));
    named.map_or_else(|| made.into(), |named| vec![named])
}

fn prepared(name: &str, mesh: RawMesh) -> PreparedObject {
    let request = BakeRequest { examples: 0, ..real::request(name, "ceramic") };
    let mut prepared = bake(mesh, &request, &CancelToken::default(), &mut |_| ()).unwrap();
    prepared.impacts = IMPACTS;
    reduce(&mut prepared, RANK_MAX, &CancelToken::default()).unwrap();
    prepared
}

/// The first impact on one body that needs no solve; the contact has the default radius.
fn request(prepared: &PreparedObject) -> FractureRequest {
    let (sampler, mut workspace) = (ImpactSampler::new(prepared), Workspace::default());
    let drawn = |index| {
        let mut strike = sampler.impact(!prepared.parameters.seed, index);
        strike.contacts.truncate(1);
        strike.contacts[0].radius_m = None;
        strike
    };
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

type Group<'a> = BenchmarkGroup<'a, WallTime>;

fn whole(group: &mut Group, prepared: &PreparedObject, request: &FractureRequest) {
    let (mut workspace, token) = (Workspace::default(), CancelToken::default());
    group.bench_function("contacts", |bencher| bencher.iter(|| ContactSet::new(prepared, black_box(request)).unwrap()));
    let mut run = |name: &str, elastic, rank_max| {
        let impact = ContactSet::new(prepared, &FractureRequest { elastic, rank_max, ..request.clone() }).unwrap();
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                strain_energy(
                    RequestContext::new(
                        prepared,
                        &FractureRequest { elastic, rank_max, ..request.clone() },
                        &token,
                        &(),
                    ),
                    black_box(&impact),
                    &mut workspace,
                )
                .unwrap()
            })
        });
    };
    run("load and elasticity: solve", DisplacementMethod::Solve, None);
    run("load and elasticity: reduced", DisplacementMethod::Reduced, None);
    for rank in [32, 64] {
        run(&format!("load and elasticity: rank {rank}"), DisplacementMethod::Reduced, Some(rank));
    }
}

fn stages(group: &mut Group, solid: &ElasticModel, poisson: f64, contacts: &[elasticity::ContactLoad]) {
    let (mut workspace, token) = (elasticity::ElasticWorkspace::default(), CancelToken::default());
    let (elasticity, reduced) = (&solid.elasticity, solid.reduced.as_ref().unwrap());
    let (mut load, mut coordinates, mut displacement) = (NodalLoad::default(), Vec::new(), Vec::new());
    let (mut energies, mut shares) = (Vec::new(), Vec::new());
    group.bench_function("load", |bencher| {
        bencher.iter(|| elasticity.load(black_box(contacts), &mut load, &mut workspace).unwrap())
    });
    elasticity.load(contacts, &mut load, &mut workspace).unwrap();
    println!("{} nodes are pressed", load.applied.len());
    group.bench_function("coordinates and residual", |bencher| {
        bencher.iter(|| {
            reduced.project(black_box(&load), &mut coordinates);
            reduced.residual(elasticity, &load, &coordinates, &mut workspace)
        })
    });
    group.bench_function("displacement", |bencher| {
        bencher.iter(|| reduced.expand(black_box(&coordinates), &mut displacement, &mut workspace))
    });
    group.bench_function("displacement, plain", |bencher| {
        bencher.iter(|| plain_expand(reduced.basis(), black_box(&coordinates)))
    });
    for driving in [DrivingEnergy::Tensile, DrivingEnergy::Total] {
        group.bench_function(format!("energy of tetrahedra, {driving:?}"), |bencher| {
            bencher.iter(|| {
                let token = &token;
                elasticity.tet_energy(&solid.lattice, black_box(&displacement), driving, &mut energies, token).unwrap()
            })
        });
    }
    group.bench_function("energy of tetrahedra, Total, plain", |bencher| {
        bencher.iter(|| plain_energy(&solid.lattice, black_box(&displacement)))
    });
    group
        .bench_function("transfer", |bencher| bencher.iter(|| solid.transfer.apply(black_box(&energies), &mut shares)));
    group.bench_function("transfer, plain", |bencher| {
        bencher.iter(|| plain_transfer(&solid.transfer, black_box(&energies)))
    });
    let narrow = Elasticity::assembled(&solid.lattice, poisson, &token).unwrap().of_precision(Precision::F32);
    for (name, body) in [("solve, f64", elasticity), ("solve, f32 refined", &narrow)] {
        let mut solve = || body.solve(black_box(&load.forces), &mut displacement, &mut workspace, &token).unwrap();
        let solved = solve();
        println!("{name}: {solved:?}, {:?}, {} bytes", body.precision(), body.own_bytes());
        group.bench_function(name, |bencher| bencher.iter(&mut solve));
    }
}

/// Expands the basis, one row after another.
fn plain_expand(basis: &[f32], coordinates: &[f64]) -> Vec<f64> {
    let rows = basis.chunks_exact(coordinates.len());
    rows.map(|row| row.iter().zip(coordinates).map(|(b, q)| b * *q as f32).sum::<f32>().into()).collect()
}

/// Strain energies with the inverse of every tetrahedron's edges, one after another; Poisson's ratio ¼.
fn plain_energy(lattice: &Lattice, displacement: &[f64]) -> Vec<f64> {
    let at = |node: u32| Vector3::from_column_slice(&displacement[3 * node as usize..][..3]);
    let energy = |tet: usize| {
        let edges = lattice.edge_matrix(tet);
        let [a, b, c, d] = lattice.tets[tet].map(at);
        let gradient = Matrix3::from_columns(&[b - a, c - a, d - a]) * edges.try_inverse().unwrap();
        let strain = (gradient + gradient.transpose()) * 0.5;
        let density = 0.2 * strain.trace().powi(2) + 0.4 * strain.norm_squared();
        density * edges.determinant() / 6.0
    };
    (0..lattice.tets.len()).map(energy).collect()
}

/// Transfers energies, one row after another.
fn plain_transfer(transfer: &EnergyTransfer, energies: &[f64]) -> Vec<f64> {
    let of = |row: &[u32]| {
        let row = row[0] as usize..row[1] as usize;
        let shares = transfer.tets[row.clone()].iter().zip(&transfer.shares[row]);
        shares.map(|(&tet, share)| share * energies[tet as usize]).sum::<f64>()
    };
    transfer.offsets.windows(2).map(of).collect()
}

fn elastic(criterion: &mut Criterion) {
    for (name, mesh) in meshes() {
        let prepared = prepared(&name, mesh);
        let solid = prepared.bodies[0].solid.as_ref().unwrap();
        println!(
            "{name}: {} elastic nodes, {} tetrahedra, {} shares of {} crack nodes, {:?}",
            prepared.elastic_nodes(),
            prepared.elastic_tets(),
            solid.transfer.shares.len(),
            prepared.crack_nodes(),
            prepared.reduction
        );
        let request = request(&prepared);
        let mut group = criterion.benchmark_group(&name);
        let contacts = ContactSet::new(&prepared, &request).unwrap().bodies.remove(0).1;
        stages(&mut group, solid, prepared.parameters.material.poisson, &contacts);
        whole(&mut group, &prepared, &request);
        group.finish();
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(30);
    targets = elastic
}
criterion_main!(benches);
