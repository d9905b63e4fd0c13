//! Inputs that break naive implementations.

use super::*;
use proptest::prelude::*;

#[test]
fn one_site_is_the_center_of_energy() {
    let mut case = Case::generic(5);
    let result = case.diagram(DiagramOptions::new(1, 0));
    let total: f64 = case.mass.iter().sum();
    for axis in 0..5 {
        let mean = (0..case.mass.len()).map(|v| case.mass[v] * case.lift.at(v)[axis]).sum::<f64>() / total;
        assert!((mean - result.site(0)[axis]).abs() < 1e-13);
    }
}

#[test]
fn zero_sites_are_one_and_too_many_are_one_per_node() {
    assert_eq!(Case::cube(2).diagram(DiagramOptions::new(0, 0)).count(), 1);
    let nodes = Case::cube(2).volumes.len();
    for wanted in [nodes - 1, nodes, nodes + 1, 10 * nodes] {
        let result = Case::cube(2).diagram(DiagramOptions::new(wanted, 3));
        assert_eq!(result.count(), wanted.min(nodes));
        assert!((0..result.count() as u32).all(|site| result.labels.contains(&site)), "an empty cell");
    }
}

#[test]
fn coincident_nodes_share_the_lowest_label() {
    let mut case = Case::cube(3);
    case.lift.coordinates.fill(0.25);
    case.lift.first_moment.fill(0.0);
    let result = case.diagram(DiagramOptions::new(6, 1));
    assert!(result.labels.iter().all(|&label| label == 0));
    assert_eq!(result.energy, 0.0);
    assert!(result.converged && result.iterations() <= 2, "{:?}", result.history);
}

#[test]
fn two_clumps_of_nodes_fill_two_cells_of_many() {
    let mut case = Case::cube(3);
    let half = case.lift.coordinates.len() / 2 / 3 * 3;
    case.lift.coordinates[..half].fill(0.0);
    case.lift.coordinates[half..].fill(1.0);
    case.lift.first_moment.fill(0.0);
    let result = case.diagram(DiagramOptions::new(5, 1));
    assert!(result.energy < 1e-12);
    let mut used = result.labels.clone();
    used.sort_unstable();
    used.dedup();
    assert_eq!(used.len(), 2);
}

#[test]
fn all_energy_at_one_node_still_divides_the_rest() {
    for sites in [1, 2, 20, 150] {
        let mut case = Case::cube(5);
        case.mass.fill(0.0);
        case.mass[77] = 3.0;
        let result = case.diagram(DiagramOptions::new(sites, 9));
        assert!((0..sites as u32).all(|site| result.labels.contains(&site)), "an empty cell among {sites}");
    }
}

#[test]
fn perfect_symmetry_is_broken_by_the_seed_alone() {
    for sites in [2, 4, 8, 27] {
        let result = Case::cube(6).diagram(DiagramOptions { tolerance: 0.0, ..DiagramOptions::new(sites, 5) });
        assert!(result == Case::cube(6).diagram(DiagramOptions { tolerance: 0.0, ..DiagramOptions::new(sites, 5) }));
    }
}

#[test]
fn sites_on_top_of_each_other_yield_to_the_first() {
    let mut case = Case::cube(4);
    let field = EnergyField::new(&case.lift, &case.volumes, &mut case.mass).unwrap();
    let sites = [0.3, 0.0, 0.0, -0.3, 0.0, 0.0, 0.3, 0.0, 0.0];
    let result = assign(&field, &sites, &mut DiagramWorkspace::default());
    assert!(result.labels.iter().all(|&label| label < 2) && result.cell_energy[2] == 0.0);
    check(&field, &DiagramOptions::new(3, 0), &result);
}

#[test]
fn far_from_the_origin_and_on_a_plane() {
    let mut far = Case::generic(3);
    far.lift.coordinates.iter_mut().for_each(|x| *x += 1e6);
    far.diagram(DiagramOptions::new(30, 2));
    let mut flat = Case::generic(3);
    flat.lift.coordinates.chunks_exact_mut(3).for_each(|place| place[2] = 0.0);
    flat.lift.first_moment.chunks_exact_mut(3).for_each(|offset| offset[2] = 0.0);
    flat.lift.density.fill(0.0);
    flat.diagram(DiagramOptions::new(30, 2));
}

#[test]
fn invalid_fields_are_rejected_by_name() {
    let check = |damage: &dyn Fn(&mut Case)| {
        let mut case = Case::cube(2);
        damage(&mut case);
        EnergyField::new(&case.lift, &case.volumes, &mut case.mass).map(|_| ()).unwrap_err()
    };
    assert!(matches!(check(&|case| case.mass[3] = f64::NAN), FieldError::Mass { node: 3, .. }));
    assert!(matches!(check(&|case| case.mass[4] = -1e-9), FieldError::Mass { node: 4, .. }));
    assert!(matches!(check(&|case| case.mass.fill(0.0)), FieldError::Total { .. }));
    assert!(matches!(check(&|case| case.mass.fill(f64::MAX)), FieldError::Total { .. }));
    assert!(matches!(check(&|case| case.volumes[5] = 0.0), FieldError::Volume { node: 5, .. }));
    assert!(matches!(check(&|case| case.lift.coordinates[7] = f64::INFINITY), FieldError::Lift { node: 2 }));
    assert!(matches!(check(&|case| case.lift.density[1] = -1.0), FieldError::Lift { node: 1 }));
    assert!(matches!(check(&|case| case.mass.truncate(1)), FieldError::Length { array: "mass", found: 1, .. }));
}

#[test]
fn the_floor_raises_unstressed_nodes_alone() {
    let mut case = Case::cube(2);
    case.mass[0] = 0.0;
    let before = case.mass.clone();
    let field = EnergyField::new(&case.lift, &case.volumes, &mut case.mass).unwrap();
    assert!(field.mass()[0] > 0.0 && field.mass()[0] < 1.1 * FLOOR * case.volumes[0]);
    assert_eq!(field.mass()[1..], before[1..]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn any_masses_give_a_diagram(seed: u64, sites in 1usize..90, exponents in prop::collection::vec(-60i32..2, 35)) {
        let mut case = Case::cube(2);
        for (mass, exponent) in case.mass.iter_mut().zip(exponents.into_iter().cycle()) {
            *mass *= f64::powi(2.0, exponent);
        }
        case.diagram(DiagramOptions::new(sites, seed));
    }
}
