//! Tests of contacts: distribution of their force, and inertia relief.

use super::*;
use crate::elasticity::load_front::LoadFront;
use proptest::prelude::*;

fn contact(point: [f64; 3], impulse: [f64; 3], radius: f64) -> ContactLoad {
    ContactLoad { point: Point3::from(point), impulse: Vector3::from(impulse), radius }
}

/// Net force and torque about the origin, relative to the sum of the magnitudes.
fn imbalance(lattice: &Lattice, forces: &[f64]) -> f64 {
    let (mut force, mut torque, mut total) = (Vector3::zeros(), Vector3::zeros(), 0.0);
    for (place, own) in lattice.nodes.iter().zip(forces.chunks_exact(3)) {
        let own = Vector3::from_column_slice(own);
        force += own;
        torque += place.coords.cross(&own);
        total += own.norm();
    }
    force.norm().max(torque.norm()) / total
}

#[test]
fn net_force_and_torque_vanish_to_rounding_and_leave_no_residual() {
    let lattice = perturbed([4, 3, 2], 0.2, 0.12, 3);
    let body = free(&lattice, 0.3);
    let strikes = [
        vec![contact([0.4, 0.1, 0.0], [-3.0, 0.2, 1.0], 0.1)],
        vec![contact([0.0, 0.3, 0.0], [0.0, -1e9, 0.0], 0.3), contact([-0.4, 0.0, 0.1], [1e-3, 1.0, 0.0], 0.2)],
        vec![contact([0.4, 0.3, 0.2], [0.0, 0.0, 1e-12], 0.5)],
    ];
    for contacts in strikes {
        let forces = load(&body, &contacts).forces;
        let error = imbalance(&lattice, &forces);
        assert!(error < 1e-12, "{error:e}");
        let solved =
            body.solve(&forces, &mut Vec::new(), &mut ElasticWorkspace::default(), &CancelToken::default()).unwrap();
        assert!(solved.residual <= 1e-9 && solved.sweeps == 0, "{solved:?}");
    }
}

/// ∫ φ_i a(x) dx for a(x) = a₀ + α × x, by the exact rule ∫ φ_i φ_j = V (1 + δ_ij)/20 per tetrahedron.
fn rigid_acceleration(lattice: &Lattice, linear: Vector3<f64>, angular: Vector3<f64>) -> Vec<f64> {
    let mut forces = vec![0.0; 3 * lattice.nodes.len()];
    for (tet, nodes) in lattice.tets.iter().enumerate() {
        let own = nodes.map(|node| linear + angular.cross(&lattice.nodes[node as usize].coords));
        let sum: Vector3<f64> = own.iter().sum();
        for (&node, own) in nodes.iter().zip(own) {
            let force = (sum + own) * (lattice.tet_volume(tet) / 20.0);
            forces[3 * node as usize..][..3].iter_mut().zip(force.iter()).for_each(|(f, df)| *f += df);
        }
    }
    forces
}

#[test]
fn uniform_gravity_and_rigid_spin_cancel() {
    let lattice = carve(&block([4, 3, 3], 0.2), |place| place.x < 0.0 || place.y < -0.1);
    let body = free(&lattice, 0.3);
    for (linear, angular) in [([0.0, -9.81, 0.0], [0.0; 3]), ([0.0; 3], [1.0, -2.0, 0.5]), ([1.0; 3], [0.0, 3.0, 0.0])]
    {
        let mut forces = rigid_acceleration(&lattice, Vector3::from(linear), Vector3::from(angular));
        let before = forces.iter().map(|f| f.abs()).fold(0.0, f64::max);
        body.relieve(&mut forces);
        let after = forces.iter().map(|f| f.abs()).fold(0.0, f64::max);
        assert!(after < 1e-13 * before, "{after:e} of {before:e} is left");
        solve(&body, &forces);
    }
}

#[test]
fn the_whole_force_is_applied_with_the_radii_that_are_reported() {
    let lattice = block([4, 4, 4], 0.2);
    let body = free(&lattice, 0.2);
    let anchored =
        Elasticity::supported(&lattice, 0.2, Support::Anchored(vec![0, 1, 2, 3]), &CancelToken::default()).unwrap();
    let load = load(&anchored, &[contact([0.41, 0.05, 0.1], [1.0, 2.0, 3.0], 0.02)]);
    let sum = load.forces.chunks_exact(3).map(Vector3::from_column_slice).sum::<Vector3<f64>>();
    assert!((sum - Vector3::new(1.0, 2.0, 3.0)).norm() < 1e-13);
    let touch = load.touches[0];
    assert!((touch.distance - 0.01).abs() < 1e-12 && (touch.place - Point3::new(0.4, 0.05, 0.1)).norm() < 1e-12);
    assert_eq!(touch.spread, RADIUS_SPACINGS_MIN * body.spacing());
    assert!(touch.radius >= 0.02 && touch.radius <= touch.spread);
    let wide = super::load(&body, &[contact([0.4, 0.0, 0.0], [1.0, 0.0, 0.0], 0.5)]);
    assert_eq!([wide.touches[0].radius, wide.touches[0].spread], [0.5; 2]);
}

/// Two legs half a cell apart: a contact on one must not load the other.
#[test]
fn a_neighboring_leg_is_not_loaded() {
    let horseshoe = carve(&block([5, 8, 2], 0.1), |place| place.x.abs() > 0.05 || place.y > 0.2);
    let body = free(&horseshoe, 0.3);
    // On the inner side of the right leg, near its end. The left leg is 0.1 away; the radius is 0.12.
    let nearest = body.boundary.nearest(&Point3::new(0.05, -0.3, 0.0)).unwrap();
    let mut front = LoadFront::default();
    let reached = front.run(&body.boundary, &nearest, 3.0 * 0.12);
    assert!(reached.len() > 40);
    for &(node, distance) in reached {
        let place = body.boundary.positions[node as usize];
        assert!(place.x > 0.0, "node at {place} on the other leg");
        assert!(distance >= (place - nearest.place).norm() - 1e-12, "no shorter than the straight line");
    }
}

#[test]
fn distance_along_the_boundary_is_exact_on_a_face_and_across_its_edges() {
    let lattice = block([6, 6, 6], 1.0);
    let body = free(&lattice, 0.0);
    let source = body.boundary.nearest(&Point3::new(1.3, 0.4, 3.0)).unwrap();
    let mut front = LoadFront::default();
    let mut compared = [0; 2];
    for &(node, distance) in front.run(&body.boundary, &source, 4.0) {
        let place = body.boundary.positions[node as usize];
        // Unfolded over the edge x = 3: the side face continues the top face.
        let flat = if place.z == 3.0 { [place.x, place.y] } else { [3.0 + (3.0 - place.z), place.y] };
        if place.z < 3.0 && place.x < 3.0 {
            continue;
        }
        let exact = (flat[0] - 1.3).hypot(flat[1] - 0.4);
        let error = (distance - exact).abs();
        assert!(error < 1e-12 * exact.max(1.0) || (place.z < 3.0 && error < 1e-9), "{place}: {distance} for {exact}");
        compared[usize::from(place.z < 3.0)] += 1;
    }
    assert!(compared[0] > 40 && compared[1] > 10, "{compared:?}");
}

#[test]
fn the_smallest_radius_is_resolved_by_the_lattice() {
    let coarse = block([4; 3], 0.25);
    let radius = RADIUS_SPACINGS_MIN * free(&coarse, 0.25).spacing();
    let energy = |lattice: &Lattice, [y, z]: [f64; 2]| -> f64 {
        strike(lattice, &[contact([0.5, y, z], [-1.0, 0.0, 0.0], radius)], DrivingEnergy::Total).iter().sum()
    };
    let fine = block([8; 3], 0.125);
    for place in [[0.0, 0.0], [0.02, 0.01], [0.07, 0.05], [0.125, 0.125]] {
        let error = energy(&coarse, place) / energy(&fine, place) - 1.0;
        assert!(error.abs() < 0.04, "{place:?}: {error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn any_contact_gives_forces_in_equilibrium_and_finite_energies(
        from in prop::array::uniform3(-1.0..1.0_f64),
        impulse in prop::array::uniform3(-1.0..1.0_f64),
        radius in 0.001..1.0_f64,
    ) {
        let lattice = carve(&block([4, 4, 3], 0.2), |place| place.x < 0.0 || place.y < 0.0);
        let body = free(&lattice, 0.3);
        let place = body.boundary.nearest(&Point3::from(from)).unwrap().place;
        let load = load(&body, &[ContactLoad { point: place, impulse: Vector3::from(impulse), radius }]);
        prop_assert!(imbalance(&lattice, &load.forces) < 1e-12);
        let [total, tensile] =
            [DrivingEnergy::Total, DrivingEnergy::Tensile].map(|driving| energies(&body, &lattice, &load.forces, driving));
        for (total, tensile) in total.iter().zip(&tensile) {
            prop_assert!(*total >= 0.0 && *tensile >= 0.0 && *tensile <= total * (1.0 + 1e-12) && total.is_finite());
        }
    }
}
