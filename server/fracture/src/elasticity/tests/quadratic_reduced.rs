//! Reduced bases of quadratic elements, which keep only values at the nodes.

use super::*;
use crate::elasticity::quadratic::SNAPSHOT;

/// A plate of one cell across.
fn plate() -> (Lattice, Elasticity) {
    let lattice = perturbed([12, 8, 1], 0.05, 0.05, 8);
    let body = free(&lattice, 0.3).of_order(ElementOrder::Quadratic, &lattice).unwrap();
    (lattice, body)
}

/// Loads of `count` random contacts on both sides.
fn loads(body: &Elasticity, count: u64, seed: u64) -> Vec<NodalLoad> {
    let mut stream = RandomStream::new(seed, 0);
    let one = |_| {
        let [x, y, side] = [0.28, 0.18, 0.025].map(|half| (stream.uniform() - 0.5) * 2.0 * half);
        let point = Point3::new(x, y, 0.025_f64.copysign(side));
        let impulse = Vector3::from_fn(|_, _| stream.uniform() - 0.5);
        load(body, &[ContactLoad { point, impulse, radius: 0.1 }])
    };
    (0..count).map(one).collect()
}

fn reduced_energies(
    (lattice, body): (&Lattice, &Elasticity),
    reduced: &ReducedBasis,
    load: &NodalLoad,
    driving: DrivingEnergy,
) -> (f64, Vec<f64>) {
    let (mut coordinates, mut expanded, mut energies) = (Vec::new(), Vec::new(), Vec::new());
    let energy = reduced.project(load, &mut coordinates);
    let mut workspace = ElasticWorkspace::default();
    reduced.expand(&coordinates, &mut expanded, &mut workspace);
    let (parts, token) = ((&mut energies, &mut workspace), CancelToken::default());
    reduced.tet_energy((body, lattice), (&expanded, energy), driving, parts, &token).unwrap();
    (energy, energies)
}

#[test]
fn the_basis_reproduces_its_snapshots() {
    let (lattice, body) = plate();
    let loads = loads(&body, 12, 1);
    let reduced = body.reduce(&lattice, &loads, 256, &CancelToken::default()).unwrap().unwrap();
    for load in &loads {
        for (driving, most) in [(DrivingEnergy::Total, 0.2), (DrivingEnergy::Tensile, 0.25)] {
            let solved = energies(&body, &lattice, &load.forces, DrivingEnergy::Total).iter().sum::<f64>();
            let own = {
                let displacement = solve(&body, &load.forces);
                let mut own = Vec::new();
                body.tet_energy(&lattice, &displacement, driving, &mut own, &CancelToken::default()).unwrap();
                own
            };
            let (energy, parts) = reduced_energies((&lattice, &body), &reduced, load, driving);
            assert!((energy / solved - 1.0).abs() < 1e-3, "{energy} of {solved}");
            let sum: f64 = own.iter().sum();
            let apart = own.iter().zip(&parts).map(|(a, b)| (a - b).abs()).sum::<f64>() / sum;
            let whole = parts.iter().sum::<f64>() / sum;
            println!("{driving:?}: energies of tetrahedra differ by {apart:.3}, their sum is {whole:.4}");
            assert!(apart < most && (driving == DrivingEnergy::Tensile || (whole - 1.0).abs() < 1e-3));
        }
        let mut coordinates = Vec::new();
        reduced.project(load, &mut coordinates);
        let residual = reduced.residual(&body, load, &coordinates, &mut ElasticWorkspace::default());
        println!("residual {residual:.1e}");
        assert!(residual < 1e-3, "{residual:e}");
    }
}

/// The residual from values at the nodes is that of the quadratic displacement itself.
#[test]
fn the_residual_is_that_of_the_quadratic_displacement() {
    let (lattice, body) = plate();
    let all = loads(&body, 2, 3);
    let (mut snapshot, token) = (all[0].forces.clone(), CancelToken::default());
    let edges = body.edges.as_ref().unwrap();
    body.iterate(edges, &mut snapshot, SNAPSHOT, &mut ElasticWorkspace::default(), &token).unwrap();
    let reduced = body.reduce(&lattice, &all[..1], 1, &CancelToken::default()).unwrap().unwrap();
    let mut coordinates = Vec::new();
    reduced.project(&all[1], &mut coordinates);
    let root = (2.0 * body.elastic_energy(&all[0].forces, &snapshot)).sqrt();
    let exact: f64 = snapshot.iter().zip(&all[1].forces).map(|(u, f)| u * f).sum::<f64>() / root;
    assert!((coordinates[0].abs() / exact.abs() - 1.0).abs() < 1e-4, "{} for {exact}", coordinates[0]);
    let displacement: Vec<f64> = snapshot.iter().map(|u| u * exact / root).collect();
    let mut product = vec![0.0; body.unknowns()];
    edges.multiply(body.lame, &body.elements, &displacement, &mut product);
    let rest = all[1].forces.iter().zip(&product).zip(body.inverse_diagonal());
    let rest: f64 = rest.map(|((f, own), inverse)| (f - own).powi(2) * inverse).sum();
    let found = reduced.residual(&body, &all[1], &coordinates, &mut ElasticWorkspace::default());
    assert!((found * exact * exact / rest - 1.0).abs() < 0.02, "{found} for {}", rest / (exact * exact));
}

#[test]
fn more_displacements_capture_more_energy_and_never_too_much() {
    let (lattice, body) = plate();
    let (known, fresh) = (loads(&body, 60, 5), loads(&body, 5, 6));
    let mut last = [0.0; 5];
    for rank in [2, 8, 32] {
        let reduced = body.reduce(&lattice, &known, rank, &CancelToken::default()).unwrap().unwrap();
        for (load, last) in fresh.iter().zip(&mut last) {
            let energy = reduced.project(load, &mut Vec::new());
            let exact = body.elastic_energy(&load.forces, &solve(&body, &load.forces));
            assert!(energy <= (1.0 + 1e-4) * exact && energy >= *last, "{energy} of {exact} with {rank}");
            *last = energy / exact * exact;
            assert!(rank < 32 || energy > 0.9 * exact, "{energy} of {exact}");
        }
    }
}

#[test]
fn bases_do_not_depend_on_the_number_of_threads() {
    let (lattice, body) = plate();
    let known = loads(&body, 20, 5);
    let made = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| body.reduce(&lattice, &known, 10, &CancelToken::default()).unwrap().unwrap())
    };
    assert_eq!(made(1), made(3));
}

#[test]
fn many_right_hand_sides_are_solved_as_one_by_one() {
    let (_, body) = plate();
    let loads = loads(&body, 11, 9);
    let all = body.solve_all(&loads, &CancelToken::default()).unwrap();
    for (column, load) in all.chunks_exact(body.unknowns()).zip(&loads) {
        let single = solve(&body, &load.forces);
        let [a, b] = [column, &single].map(|u| body.elastic_energy(&load.forces, u));
        assert!((a / b - 1.0).abs() < 1e-6, "{a} and {b}");
    }
}

/// A completed displacement of one load: its energy, those of the tetrahedra, and the energy of the basis alone.
struct Completed {
    own: CompletedEnergy,
    parts: Vec<f64>,
    alone: f64,
}

fn completed(body: &Elasticity, lattice: &Lattice, reduced: &ReducedBasis, load: &NodalLoad) -> Completed {
    let (mut load, token) = (load.clone(), CancelToken::default());
    let (mut coordinates, mut expanded, mut parts) = (Vec::new(), Vec::new(), Vec::new());
    let mut workspace = ElasticWorkspace::default();
    let alone = reduced.project(&load, &mut coordinates);
    let own = reduced.complete(body, &mut load, &mut coordinates, &mut expanded, &mut workspace, &token);
    let own = own.unwrap().unwrap();
    let expanded = (expanded.as_slice(), own.energy);
    let tets = (&mut parts, &mut workspace);
    reduced.tet_energy((body, lattice), expanded, DrivingEnergy::Total, tets, &token).unwrap();
    Completed { own, parts, alone }
}

/// Between the energy of the basis alone and the true one, and closer to the true one than linear elements.
#[test]
fn a_linear_solve_completes_a_displacement() {
    let (lattice, body) = plate();
    let (known, fresh) = (loads(&body, 20, 5), loads(&body, 12, 6));
    let linear = free(&lattice, 0.3);
    for rank in [1, 6, 20] {
        let reduced = body.reduce(&lattice, &known, rank, &CancelToken::default()).unwrap().unwrap();
        let one = |load: &NodalLoad| {
            let exact = energies(&body, &lattice, &load.forces, DrivingEnergy::Total);
            let true_energy: f64 = exact.iter().sum();
            let forces = &load.forces[..body.size()];
            let stiff = linear.elastic_energy(forces, &solve(&linear, forces));
            let Completed { own, parts, alone } = completed(&body, &lattice, &reduced, load);
            let [alone, stiff, whole] = [alone, stiff, own.energy].map(|energy| 1.0 - energy / true_energy);
            assert!(whole <= alone && whole <= stiff + 0.01, "{whole} of {alone} and {stiff} with rank {rank}");
            assert!(whole > -1e-4, "{whole}: more than the true energy");
            assert!((own.gain - (alone - whole) / (1.0 - whole)).abs() < 1e-6, "{own:?}");
            assert!((parts.iter().sum::<f64>() / own.energy - 1.0).abs() < 1e-12);
            let apart: f64 = parts.iter().zip(&exact).map(|(a, b)| (a - b).abs()).sum();
            [alone, stiff, whole, apart / true_energy]
        };
        let errors: Vec<[f64; 4]> = fresh.iter().map(one).collect();
        let [alone, stiff, whole, apart] = [0, 1, 2, 3].map(|of| {
            let mut sorted: Vec<f64> = errors.iter().map(|own| own[of]).collect();
            sorted.sort_by(f64::total_cmp);
            sorted[sorted.len() / 2]
        });
        println!(
            "rank {rank}, missing: basis {alone:.4}, linear {stiff:.4}, completed {whole:.4}; densities {apart:.3}"
        );
        assert!(rank < 20 || (whole < 0.25 * alone && whole < 0.1 * stiff && apart < 0.1), "{whole}, {apart}");
    }
}

/// Products of the basis are those of its displacements, however few steps made its snapshots.
#[test]
fn a_basis_of_approximate_snapshots_never_exceeds_the_true_energy() {
    let lattice = block([40, 2, 2], 0.025);
    let body = free(&lattice, 0.3).of_order(ElementOrder::Quadratic, &lattice).unwrap();
    // Nearly one mode: all snapshots are alike, and the small differences between them matter.
    let one = |place: f64| {
        let point = Point3::new(place, 0.0, 0.025);
        load(&body, &[ContactLoad { point, impulse: Vector3::new(0.02, 0.01, -1.0), radius: 0.1 }])
    };
    let known: Vec<NodalLoad> = (0..16).map(|index| one(0.03 * f64::from(index) - 0.24)).collect();
    let reduced = body.reduce(&lattice, &known, 256, &CancelToken::default()).unwrap().unwrap();
    for place in [-0.4, -0.11, 0.015, 0.17, 0.35] {
        let load = one(place);
        let exact = body.elastic_energy(&load.forces, &solve(&body, &load.forces));
        let Completed { own, alone, .. } = completed(&body, &lattice, &reduced, &load);
        let [alone, whole] = [alone, own.energy].map(|energy| energy / exact);
        println!("rank {}, at {place}: basis {alone:.6}, completed {whole:.6}", reduced.rank());
        assert!(alone <= whole && whole < 1.0 + 1e-4, "{alone} and {whole}");
    }
}

#[test]
fn completed_displacements_do_not_depend_on_the_number_of_threads() {
    let (lattice, body) = plate();
    let (known, fresh) = (loads(&body, 8, 5), loads(&body, 2, 6));
    let made = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let reduced = body.reduce(&lattice, &known, 10, &CancelToken::default()).unwrap().unwrap();
            let parts = |load| completed(&body, &lattice, &reduced, load).parts;
            fresh.iter().flat_map(parts).map(f64::to_bits).collect::<Vec<_>>()
        })
    };
    assert_eq!(made(1), made(3));
}

#[test]
fn wide_instructions_do_not_change_a_bit_of_a_completed_displacement() {
    let (lattice, body) = plate();
    let (known, fresh) = (loads(&body, 4, 5), loads(&body, 1, 6));
    let reduced = body.reduce(&lattice, &known, 10, &CancelToken::default()).unwrap().unwrap();
    let parts = crate::simd::tests::same_on_every_path(|| completed(&body, &lattice, &reduced, &fresh[0]).parts);
    assert!(parts.iter().sum::<f64>() > 0.0);
}
