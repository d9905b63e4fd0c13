//! Invariances of the energies, and their scaling.

use super::*;

fn contacts() -> [ContactLoad; 2] {
    let contact = |point, impulse: [f64; 3]| ContactLoad { point, impulse: Vector3::from(impulse), radius: 0.25 };
    [contact(Point3::new(0.4, 0.1, -0.1), [-2.0, 0.3, 0.0]), contact(Point3::new(-0.1, -0.3, 0.1), [0.1, 1.0, -0.4])]
}

fn body_lattice() -> Lattice {
    perturbed([4, 3, 3], 0.2, 0.12, 5)
}

#[test]
fn strains_do_not_depend_on_the_pins() {
    let lattice = body_lattice();
    let far = free(&lattice, 0.3);
    let forces = load(&far, &contacts()).forces;
    let expected = energies(&far, &lattice, &forces, DrivingEnergy::Total);
    for nodes in [[0, 1, 2], [30, 60, 90], [5, 100, 17]] {
        let pins = PinnedNodes::on(&lattice, nodes).unwrap();
        let other = Elasticity::supported(&lattice, 0.3, Support::Free(pins), &CancelToken::default()).unwrap();
        let error = difference(&expected, &energies(&other, &lattice, &forces, DrivingEnergy::Total));
        assert!(error < 1e-10, "pins {nodes:?}: {error:e}");
    }
}

/// Largest change of an energy when body and contacts rotate together.
fn turned_difference(lattice: &Lattice, contacts: &[ContactLoad], driving: DrivingEnergy) -> f64 {
    let turn = nalgebra::Isometry3::new(Vector3::new(0.3, -0.1, 0.2), Vector3::new(0.4, -1.1, 2.0));
    let mut turned = lattice.clone();
    turned.nodes.iter_mut().for_each(|place| *place = turn * *place);
    let moved: Vec<ContactLoad> =
        contacts.iter().map(|c| ContactLoad { point: turn * c.point, impulse: turn * c.impulse, ..*c }).collect();
    difference(&strike(lattice, contacts, driving), &strike(&turned, &moved, driving))
}

#[test]
fn rotating_lattice_and_contacts_keeps_the_energies() {
    for driving in [DrivingEnergy::Total, DrivingEnergy::Tensile] {
        let error = turned_difference(&body_lattice(), &contacts(), driving);
        assert!(error < 1e-9, "{driving:?}: {error:e}");
    }
}

/// On a regular lattice, rounding decides which face is nearest and whether a node is on the rim of the patch.
#[test]
fn equidistant_nodes_do_not_change_the_energies() {
    let lattice = block([4, 4, 4], 0.2);
    let contact = |point: [f64; 3]| ContactLoad {
        point: Point3::from(point),
        impulse: Vector3::new(-1.0, 0.2, -0.1),
        radius: 0.2,
    };
    for point in [[0.4, 0.4, 0.4], [0.4, 0.4, 0.0], [0.4, 0.0, 0.0], [0.4, 0.1, 0.1], [0.4, 0.05, 0.05]] {
        let error = turned_difference(&lattice, &[contact(point)], DrivingEnergy::Total);
        assert!(error < 1e-9, "{point:?}: {error:e}");
    }
}

/// With E = 1 and fixed forces, lengths ×s scale stress by s⁻², energy by s⁻⁴·s³ = s⁻¹.
#[test]
fn energies_scale_with_length_and_with_the_square_of_the_load() {
    let lattice = body_lattice();
    for driving in [DrivingEnergy::Total, DrivingEnergy::Tensile] {
        let expected = strike(&lattice, &contacts(), driving);
        let mut larger = lattice.clone();
        larger.nodes.iter_mut().for_each(|place| *place *= 8.0);
        let moved = contacts().map(|c| ContactLoad { point: c.point * 8.0, radius: c.radius * 8.0, ..c });
        let scaled: Vec<f64> = strike(&larger, &moved, driving).iter().map(|energy| energy * 8.0).collect();
        assert!(difference(&expected, &scaled) < 1e-12);
        for factor in [1e-9, 3.0, 1e9] {
            let harder = contacts().map(|c| ContactLoad { impulse: c.impulse * factor, ..c });
            let scaled: Vec<f64> =
                strike(&lattice, &harder, driving).iter().map(|energy| energy / (factor * factor)).collect();
            let error = difference(&expected, &scaled);
            assert!(error < 1e-11, "load × {factor}: {error:e}");
        }
    }
}

#[test]
fn contacts_superpose_in_load_and_displacement() {
    let lattice = body_lattice();
    let body = free(&lattice, 0.3);
    let [first, second] = contacts();
    let [a, b, both] = [&[first][..], &[second], &[first, second]].map(|contacts| load(&body, contacts).forces);
    let sum: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a + b).collect();
    assert!(difference(&both, &sum) < 1e-13);
    let [a, b, both] = [a, b, both].map(|forces| solve(&body, &forces));
    let sum: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a + b).collect();
    assert!(difference(&both, &sum) < 1e-10);
}

#[test]
fn a_point_symmetric_load_gives_symmetric_energies() {
    let lattice = block([4, 3, 3], 0.2);
    let [first, _] = contacts();
    let opposite = ContactLoad { point: -first.point, impulse: -first.impulse, ..first };
    let key = |place: Point3<f64>| [place.x, place.y, place.z].map(|x| (x * 1e6).round() as i64);
    let index: std::collections::HashMap<_, _> =
        (0..lattice.tets.len()).map(|tet| (key(centroid(&lattice, tet)), tet)).collect();
    for driving in [DrivingEnergy::Total, DrivingEnergy::Tensile] {
        let energies = strike(&lattice, &[first, opposite], driving);
        let mirrored: Vec<f64> =
            (0..energies.len()).map(|tet| energies[index[&key(-centroid(&lattice, tet))]]).collect();
        let error = difference(&energies, &mirrored);
        assert!(error < 1e-10, "{driving:?}: {error:e}");
    }
}

#[test]
fn the_tensile_part_is_all_of_a_tension_and_none_of_a_pressure() {
    let lattice = block([2, 2, 2], 0.3);
    let body = free(&lattice, 0.3);
    let of = |stress: f64| {
        let forces = traction(&lattice, |_| Matrix3::from_diagonal_element(stress));
        let [total, tensile] = [DrivingEnergy::Total, DrivingEnergy::Tensile]
            .map(|driving| energies(&body, &lattice, &forces, driving).iter().sum::<f64>());
        tensile / total
    };
    assert!((of(1.0) - 1.0).abs() < 1e-12);
    assert_eq!(of(-1.0), 0.0);
    let struck = body_lattice();
    let total = strike(&struck, &contacts(), DrivingEnergy::Total);
    let tensile = strike(&struck, &contacts(), DrivingEnergy::Tensile);
    assert!(total.iter().zip(&tensile).all(|(total, tensile)| (0.0..=total * (1.0 + 1e-12)).contains(tensile)));
    let share = tensile.iter().sum::<f64>() / total.iter().sum::<f64>();
    assert!((0.05..0.95).contains(&share), "tensile share {share}");
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads_or_on_what_ran_before() {
    let lattice = block([6, 5, 5], 0.1);
    let contact = ContactLoad { point: Point3::new(0.3, 0.0, 0.05), impulse: -Vector3::x(), radius: 0.2 };
    let run = || strike(&lattice, &[contact], DrivingEnergy::Tensile);
    let in_pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run);
    let one = in_pool(1);
    assert!(one == in_pool(2) && one == in_pool(4));

    let body = free(&lattice, 0.25);
    let (mut load, mut displacement, mut energies) = (NodalLoad::default(), Vec::new(), Vec::new());
    let (mut workspace, token) = (ElasticWorkspace::default(), CancelToken::default());
    let other = ContactLoad { point: Point3::new(-0.3, 0.1, 0.0), impulse: Vector3::y(), radius: 0.3 };
    for contact in [contact, other, contact] {
        body.load(&[contact], &mut load, &mut workspace).unwrap();
        body.solve(&load.forces, &mut displacement, &mut workspace, &token).unwrap();
        body.tet_energy(&lattice, &displacement, DrivingEnergy::Tensile, &mut energies, &token).unwrap();
    }
    assert!(energies == one);
}
