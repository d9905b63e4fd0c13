//! Recovery of strains, loads as tractions, and solves with linear elements of quadratic bodies.

use super::quadratic::tractions;
use super::*;

fn quadratic(lattice: &Lattice, poisson: f64) -> Elasticity {
    free(lattice, poisson).of_order(ElementOrder::Quadratic, lattice).unwrap()
}

fn bending(place: Point3<f64>) -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(place.z, 0.0, 0.0))
}

/// Energy of the recovery over that of the solution.
fn recovered(body: &Elasticity, lattice: &Lattice, forces: &[f64]) -> f64 {
    let displacement = solve(body, forces);
    body.recovery_energy(lattice, &displacement).unwrap() / body.elastic_energy(forces, &displacement)
}

/// Constant strains for linear elements, and linear ones for quadratic elements.
#[test]
fn strains_that_the_elements_hold_are_recovered() {
    let lattice = perturbed([4, 3, 2], 0.25, 0.1, 5);
    let body = free(&lattice, 0.3);
    let constant = recovered(&body, &lattice, &traction(&lattice, |_| Matrix3::from_diagonal_element(1.0)));
    let body = quadratic(&lattice, 0.3);
    let linear = recovered(&body, &lattice, &tractions(&body, &lattice, bending));
    println!("{constant:e} of the energy with linear elements, {linear:e} with quadratic ones");
    assert!(constant < 1e-20 && linear < 1e-3);
}

/// On smooth problems the energy of the recovery tends to the energy that is missing.
#[test]
fn recovery_is_near_the_missing_energy_of_bending() {
    for cells in [4, 8] {
        let lattice = block([3 * cells, cells, cells], 1.0 / cells as f64);
        let (body, error) = (free(&lattice, 0.3), bending_error(&lattice, 0.3).unwrap());
        let ratio = recovered(&body, &lattice, &traction(&lattice, bending)) / error;
        println!("{cells} cells across: {ratio:.3} of the error {error:.4}");
        assert!((0.7..1.3).contains(&ratio));
    }
}

#[test]
fn wide_instructions_do_not_change_a_bit_of_a_recovery() {
    let lattice = perturbed([3, 1, 2], 0.5, 0.1, 3);
    for body in [free(&lattice, 0.3), quadratic(&lattice, 0.3)] {
        let displacement: Vec<f64> = (0..body.unknowns()).map(|place| (place as f64).sin()).collect();
        let energy =
            crate::simd::tests::same_on_every_path(|| body.recovery_energy(&lattice, &displacement).unwrap().to_bits());
        assert!(f64::from_bits(energy) > 0.0);
    }
}

/// A traction that is linear on every face, against its integrals face by face.
#[test]
fn tractions_of_applied_forces_are_consistent() {
    let lattice = perturbed([4, 3, 2], 0.25, 0.1, 5);
    let boundary = BoundaryNodes::new(&lattice);
    let pull = |place: &Point3<f64>| Vector3::new(place.x, 1.0 + place.y * 2.0, place.z - place.x);
    let places = boundary.nodes.iter().zip(&boundary.positions).zip(&boundary.areas);
    let applied: Vec<_> = places.map(|((node, place), area)| (*node, pull(place) * *area)).collect();
    for body in [free(&lattice, 0.3), quadratic(&lattice, 0.3)] {
        let mut wanted = vec![0.0; body.unknowns()];
        for own in lattice.boundary() {
            let [a, b, c] = own.nodes.map(|node| lattice.nodes[node as usize]);
            let area = 0.5 * (b - a).cross(&(c - a)).norm();
            let sum = pull(&a) + pull(&b) + pull(&c);
            for (node, place) in own.nodes.iter().zip([a, b, c]) {
                let force = (sum + pull(&place)) * (area / 12.0);
                (0..3).for_each(|axis| wanted[3 * *node as usize + axis] += force[axis]);
            }
        }
        if let Some(edges) = &body.edges {
            let size = body.size();
            edges.add_applied(&body.boundary, &applied, &mut wanted[size..]);
        }
        body.relieve(&mut wanted);
        assert!(difference(&body.traction_forces(&applied), &wanted) < 1e-12);
    }
}

/// A body with quadratic elements has the linear elements of its lattice.
#[test]
fn linear_solves_of_quadratic_bodies_are_those_of_linear_ones() {
    let lattice = perturbed([6, 2, 1], 0.2, 0.1, 5);
    let contact = ContactLoad { point: Point3::new(0.3, 0.0, 0.1), impulse: -Vector3::z(), radius: 0.2 };
    let (linear, body) = (free(&lattice, 0.3), quadratic(&lattice, 0.3));
    let forces = load(&body, &[contact]).forces;
    let own = load(&linear, &[contact]).forces;
    let displacement = body.linear_displacement(&forces, &mut ElasticWorkspace::default()).unwrap();
    let exact = solve(&linear, &own);
    assert!(difference(&displacement, &exact) < 1e-9);
    let energy = body.linear_energy(&forces, &displacement);
    assert!((energy / linear.elastic_energy(&own, &exact) - 1.0).abs() < 1e-9);
    // A displacement that is too small by 1 % misses 0.01 % of the energy.
    let smaller: Vec<f64> = displacement.iter().map(|own| 0.99 * own).collect();
    assert!((body.linear_energy(&forces, &smaller) / energy - 0.9999).abs() < 1e-6);
    let other = body.recovery_energy(&block([1, 1, 1], 1.0), &displacement);
    assert!(matches!(other, Err(ElasticityError::OtherLattice { .. })));
}
