//! Beams and bars against exact solutions, with the observed order of convergence.

use super::*;

/// Relative error of the strain energy of a free beam along x in pure bending, σ_xx = z.
///
/// Exact: u = (x z, −ν y z, −(x² + ν(z² − y²))/2), which has this stress and no other; energy = ½ ∫ z².
fn bending_error(lattice: &Lattice, poisson: f64) -> f64 {
    let forces = traction(lattice, |place| Matrix3::from_diagonal(&Vector3::new(place.z, 0.0, 0.0)));
    let size = lattice.nodes.iter().fold(Vector3::zeros(), |size: Vector3<f64>, node| size.sup(&node.coords)) * 2.0;
    let exact = 0.5 * size.x * size.y * size.z.powi(3) / 12.0;
    let body = prepare::with_any_law(lattice, poisson);
    let energy: f64 = energies(&body, lattice, &forces, Driving::Total).iter().sum();
    (exact - energy) / exact
}

#[test]
fn pure_bending_converges_with_order_two_from_below() {
    let errors = [2, 4, 6].map(|fine| bending_error(&block([4 * fine, fine, fine], 1.0 / fine as f64), 0.3));
    assert!(errors.iter().all(|&error| error > 0.0), "a displacement method is too stiff: {errors:?}");
    let orders = [(errors[0] / errors[1]).log2(), (errors[1] / errors[2]).ln() / 1.5_f64.ln()];
    assert!(orders.iter().all(|order| (1.7..2.1).contains(order)), "orders {orders:?}, errors {errors:?}");
}

#[test]
fn bending_holds_up_to_the_accepted_poisson_ratio_and_locks_beyond() {
    let lattice = kuhn([12, 4, 4], 0.25);
    let relaxed = bending_error(&lattice, 0.0);
    assert!(bending_error(&lattice, POISSON_MAX) < 2.5 * relaxed);
    assert!(bending_error(&lattice, 0.499) > 4.0 * relaxed);
}

/// Cubes cut into six tetrahedra along one diagonal, all nodes on the corners: locks as early as tetrahedra do.
fn kuhn(cells: [usize; 3], spacing: f64) -> Lattice {
    let counts = cells.map(|cell| cell + 1);
    let half = Vector3::from(cells.map(|count| count as f64)) * 0.5;
    let index = |[x, y, z]: [usize; 3]| (z * counts[1] + y) * counts[0] + x;
    let mut lattice = Lattice::default();
    for node in 0..counts.iter().product() {
        let corner = [node % counts[0], node / counts[0] % counts[1], node / counts[0] / counts[1]];
        lattice.nodes.push(Point3::from((Vector3::from(corner.map(|i| i as f64)) - half) * spacing));
        if (0..3).any(|axis| corner[axis] == cells[axis]) {
            continue;
        }
        for order in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [2, 1, 0], [0, 2, 1]] {
            let mut walk = corner;
            let steps = order.map(|axis| {
                walk[axis] += 1;
                index(walk) as u32
            });
            let odd = (order[0] + 1) % 3 != order[1];
            let [a, b, c] = if odd { [steps[1], steps[0], steps[2]] } else { steps };
            lattice.tets.push([node as u32, a, b, c]);
        }
    }
    lattice
}

/// A bar pushed at one end accelerates as a whole: the axial stress falls linearly to zero at the far end, exactly so
/// for ν = 0, where u is quadratic in x. Energy = ½ ∫ (x/L)² A dx = A L / 6.
#[test]
fn a_pushed_bar_has_the_energy_of_its_inertia() {
    let errors = [1, 2, 4].map(|fine: usize| {
        let lattice = block([4 * fine, fine, fine], 0.25 / fine as f64);
        let body = free(&lattice, 0.0);
        let push = |place: Point3<f64>| if place.x > 0.499 { -1.0 } else { 0.0 };
        let mut forces = traction(&lattice, |place| Matrix3::from_diagonal(&Vector3::new(push(place), 0.0, 0.0)));
        body.relieve(&mut forces);
        let exact = 0.0625 / 6.0;
        (exact - energies(&body, &lattice, &forces, Driving::Total).iter().sum::<f64>()) / exact
    });
    let orders = [(errors[0] / errors[1]).log2(), (errors[1] / errors[2]).log2()];
    assert!(orders.iter().all(|order| (1.8..2.2).contains(order)), "orders {orders:?}, errors {errors:?}");
}

/// A cantilever under a transverse end load, against Timoshenko's beam: energy = F²L³/(6EI) + F²L/(2κGA), κ = 5/6.
#[test]
fn an_anchored_cantilever_bends_like_a_beam() {
    let fine = 4;
    let lattice = block([8 * fine, fine, fine], 1.0 / fine as f64);
    let clamped = (0..lattice.nodes.len() as u32).filter(|&node| lattice.nodes[node as usize].x < -3.999).collect();
    let body = Elasticity::supported(&lattice, 0.0, Support::Anchored(clamped), &Token::default()).unwrap();
    let shear = |place: Point3<f64>| if place.x > 3.999 { 1.0 } else { 0.0 };
    let forces = traction(&lattice, |place| {
        let mut stress = Matrix3::zeros();
        stress[(2, 0)] = shear(place);
        stress
    });
    let energy: f64 = energies(&body, &lattice, &forces, Driving::Total).iter().sum();
    let theory = 8.0_f64.powi(3) / (6.0 / 12.0) + 8.0 / (2.0 * 5.0 / 6.0 * 0.5);
    assert!((0.9..1.0).contains(&(energy / theory)), "energy {energy}, theory {theory}");
}

/// The residual of a slender body is the rounding of its displacement; its energies hardly notice.
#[test]
fn needles_and_plates_of_one_cell_are_solved() {
    for cells in [[100, 1, 1], [30, 30, 1]] {
        let lattice = block(cells, 0.01);
        let body = free(&lattice, 0.3);
        let tip = Point3::new(cells[0] as f64 * 0.005, 0.0, 0.0);
        let contact = Contact { point: tip, impulse: Vector3::new(0.1, 0.0, -1.0), radius: 0.01 };
        let forces = load(&body, &[contact]).forces;
        let of = |body: &Elasticity| {
            let mut out = Vec::new();
            body.tet_energy(&lattice, &solve(body, &forces), Driving::Total, &mut out, &Token::default()).unwrap();
            out
        };
        let last = lattice.nodes.len() as u32 - 1;
        let pins = Pins::on(&lattice, [last, 2, last / 2]).unwrap();
        let other = Elasticity::supported(&lattice, 0.3, Support::Free(pins), &Token::default()).unwrap();
        let error = difference(&of(&body), &of(&other));
        assert!(error < 1e-7, "{cells:?}: {error:e}");
    }
}
