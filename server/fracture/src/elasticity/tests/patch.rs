//! Patch test: constant stress is exact on any lattice, for any Poisson's ratio.

use super::*;

const STATES: [[f64; 6]; 6] = [
    [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
    [0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
    [0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
];

/// ε = sym(∇u) of tetrahedron `tet`, and its volume.
fn strain(lattice: &Lattice, tet: usize, displacement: &[f64]) -> (Matrix3<f64>, f64) {
    let edges = lattice.edge_matrix(tet);
    let [a, b, c, d] =
        lattice.tets[tet].map(|node| Vector3::from_column_slice(&displacement[3 * node as usize..][..3]));
    let gradient = Matrix3::from_columns(&[b - a, c - a, d - a]) * edges.try_inverse().unwrap();
    ((gradient + gradient.transpose()) * 0.5, edges.determinant() / 6.0)
}

fn check(lattice: &Lattice, poisson: f64, [xx, yy, zz, yz, xz, xy]: [f64; 6]) {
    let stress = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let exact = stress * (1.0 + poisson) - Matrix3::from_diagonal_element(poisson * stress.trace());
    let density = 0.5 * stress.dot(&exact);
    let body = free(lattice, poisson);
    let forces = traction(lattice, |_| stress);
    let displacement = solve(&body, &forces);
    let energies = energies(&body, lattice, &forces, DrivingEnergy::Total);
    for (tet, energy) in energies.iter().enumerate() {
        let (strain, volume) = strain(lattice, tet, &displacement);
        assert!((strain - exact).norm() <= 1e-10 * exact.norm(), "ν = {poisson}, {stress}: strain {strain}");
        assert!((energy - density * volume).abs() <= 1e-10 * density * volume);
    }
}

#[test]
fn constant_stress_is_exact_in_all_six_states() {
    let lattice = perturbed([3, 2, 2], 0.2, 0.12, 11);
    for poisson in [-0.5, 0.0, 0.3, POISSON_MAX] {
        STATES.iter().for_each(|&state| check(&lattice, poisson, state));
    }
}

#[test]
fn constant_stress_is_exact_on_any_perturbed_block() {
    for seed in 0..6 {
        let mut stream = RandomStream::new(seed, 1);
        let state = [(); 6].map(|_| stream.uniform() - 0.5);
        check(&perturbed([2, 3, 2], 0.3, 0.12, seed), 0.2, state);
    }
}
