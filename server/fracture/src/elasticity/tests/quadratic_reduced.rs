//! Reduced bases of quadratic elements, which keep only values at the nodes.

use super::*;

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
    reduced.expand(&coordinates, &mut expanded, &mut ElasticWorkspace::default());
    let parts = (coordinates.as_slice(), expanded.as_slice());
    reduced.tet_energy((body, lattice), parts, driving, &mut energies, &CancelToken::default()).unwrap();
    (energy, energies)
}

#[test]
fn the_basis_reproduces_its_snapshots() {
    let (lattice, body) = plate();
    let loads = loads(&body, 12, 1);
    let reduced = body.reduce(&loads, 256, &CancelToken::default()).unwrap().unwrap();
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
            assert!((energy / solved - 1.0).abs() < 1e-4, "{energy} of {solved}");
            let sum: f64 = own.iter().sum();
            let apart = own.iter().zip(&parts).map(|(a, b)| (a - b).abs()).sum::<f64>() / sum;
            let whole = parts.iter().sum::<f64>() / sum;
            println!("{driving:?}: energies of tetrahedra differ by {apart:.3}, their sum is {whole:.4}");
            assert!(apart < most && (driving == DrivingEnergy::Tensile || (whole - 1.0).abs() < 1e-4));
        }
        let mut coordinates = Vec::new();
        reduced.project(load, &mut coordinates);
        let residual = reduced.residual(&body, load, &coordinates, &mut ElasticWorkspace::default());
        assert!(residual < 1e-4, "{residual:e}");
    }
}

/// The residual from values at the nodes is that of the quadratic displacement itself.
#[test]
fn the_residual_is_that_of_the_quadratic_displacement() {
    let (_, body) = plate();
    let all = loads(&body, 2, 3);
    let snapshot = solve(&body, &all[0].forces);
    let reduced = body.reduce(&all[..1], 1, &CancelToken::default()).unwrap().unwrap();
    let mut coordinates = Vec::new();
    reduced.project(&all[1], &mut coordinates);
    let root = (2.0 * body.elastic_energy(&all[0].forces, &snapshot)).sqrt();
    let exact: f64 = snapshot.iter().zip(&all[1].forces).map(|(u, f)| u * f).sum::<f64>() / root;
    assert!((coordinates[0].abs() / exact.abs() - 1.0).abs() < 1e-4, "{} for {exact}", coordinates[0]);
    let displacement: Vec<f64> = snapshot.iter().map(|u| u * exact / root).collect();
    let mut product = vec![0.0; body.unknowns()];
    body.edges.as_ref().unwrap().multiply(body.lame, &body.elements, &displacement, &mut product);
    let rest = all[1].forces.iter().zip(&product).zip(body.inverse_diagonal());
    let rest: f64 = rest.map(|((f, own), inverse)| (f - own).powi(2) * inverse).sum();
    let found = reduced.residual(&body, &all[1], &coordinates, &mut ElasticWorkspace::default());
    assert!((found * exact * exact / rest - 1.0).abs() < 1e-3, "{found} for {}", rest / (exact * exact));
}

#[test]
fn more_displacements_capture_more_energy_and_never_too_much() {
    let (_, body) = plate();
    let (known, fresh) = (loads(&body, 60, 5), loads(&body, 5, 6));
    let mut last = [0.0; 5];
    for rank in [2, 8, 32] {
        let reduced = body.reduce(&known, rank, &CancelToken::default()).unwrap().unwrap();
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
    let (_, body) = plate();
    let known = loads(&body, 20, 5);
    let made = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| body.reduce(&known, 10, &CancelToken::default()).unwrap().unwrap())
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
