//! Beams and bars against exact solutions, with the observed order of convergence.

use super::*;
use crate::reference::{bar_error, bending_sagitta_error, cantilever_error, plate_error};

#[test]
fn pure_bending_converges_with_order_two_from_below() {
    let errors = [2, 4, 6].map(|fine| bending_error(&block([4 * fine, fine, fine], 1.0 / fine as f64), 0.3).unwrap());
    assert!(errors.iter().all(|&error| error > 0.0), "a displacement method must be too stiff: {errors:?}");
    let orders = [(errors[0] / errors[1]).log2(), (errors[1] / errors[2]).ln() / 1.5_f64.ln()];
    assert!(orders.iter().all(|order| (1.7..2.1).contains(order)), "orders {orders:?}, errors {errors:?}");
}

#[test]
fn bending_holds_up_to_the_accepted_poisson_ratio_and_locks_beyond() {
    let lattice = kuhn([12, 4, 4], 0.25);
    let relaxed = bending_error(&lattice, 0.0).unwrap();
    assert!(bending_error(&lattice, POISSON_MAX).unwrap() < 2.5 * relaxed);
    assert!(bending_error(&lattice, 0.499).unwrap() > 4.0 * relaxed);
}

#[test]
fn a_pushed_bar_has_the_energy_of_its_inertia() {
    let errors = [1, 2, 4].map(|fine| bar_error(fine).unwrap());
    let orders = [(errors[0] / errors[1]).log2(), (errors[1] / errors[2]).log2()];
    assert!(orders.iter().all(|order| (1.8..2.2).contains(order)), "orders {orders:?}, errors {errors:?}");
}

#[test]
fn an_anchored_cantilever_bends_like_a_beam() {
    let error = cantilever_error(4).unwrap();
    assert!((0.0..0.1).contains(&error), "{error}");
}

#[test]
fn a_plate_bent_to_a_sphere_converges_with_order_two() {
    let errors = [2, 4].map(|fine| plate_error(&block([6 * fine, 6 * fine, fine], 1.0 / fine as f64), 0.3).unwrap());
    let order = (errors[0] / errors[1]).log2();
    assert!((1.7..2.2).contains(&order) && errors[1] > 0.0, "order {order}, errors {errors:?}");
}

#[test]
fn the_sagitta_of_a_bent_beam_converges_with_order_two() {
    let errors =
        [2, 4].map(|fine| bending_sagitta_error(&block([4 * fine, fine, fine], 1.0 / fine as f64), 0.3).unwrap());
    let order = (errors[0] / errors[1]).log2();
    assert!((1.7..2.2).contains(&order), "order {order}, errors {errors:?}");
}

/// The residual of a slender body is the rounding of its displacement, which hardly changes energies.
#[test]
fn needles_and_plates_of_one_cell_are_solved() {
    for (cells, bound) in [([100, 1, 1], 1e-7), ([30, 30, 1], 1e-7), ([333, 1, 1], 1e-5)] {
        let lattice = block(cells, 0.01);
        let body = free(&lattice, 0.3);
        let tip = Point3::new(cells[0] as f64 * 0.005, 0.0, 0.0);
        let contact = ContactLoad { point: tip, impulse: Vector3::new(0.1, 0.0, -1.0), radius: 0.01 };
        let forces = load(&body, &[contact]).forces;
        let of = |body: &Elasticity| {
            let mut out = Vec::new();
            body.tet_energy(&lattice, &solve(body, &forces), DrivingEnergy::Total, &mut out, &CancelToken::default())
                .unwrap();
            out
        };
        let last = lattice.nodes.len() as u32 - 1;
        let pins = PinnedNodes::on(&lattice, [last, 2, last / 2]).unwrap();
        let other = Elasticity::supported(&lattice, 0.3, Support::Free(pins), &CancelToken::default()).unwrap();
        let error = difference(&of(&body), &of(&other));
        println!("{cells:?}: energies differ by {error:.1e} between pins");
        assert!(error < bound, "{cells:?}: {error:e}");
    }
}
