//! Single-precision factor against a double-precision one.

use super::*;
use crate::sparse::Precision;

/// Body with a factor in either precision.
fn both(lattice: &Lattice) -> [Elasticity; 2] {
    [Precision::F64, Precision::F32]
        .map(|precision| Elasticity::assembled(lattice, 0.3, &CancelToken::default()).unwrap().of_precision(precision))
}

/// Load of an impact across the end of a block.
fn impact_load(body: &Elasticity, lattice: &Lattice) -> NodalLoad {
    let end = lattice.nodes.iter().max_by(|a, b| a.x.total_cmp(&b.x)).unwrap();
    load(body, &[ContactLoad { point: *end, impulse: Vector3::new(-0.3, -1.0, 0.2), radius: 0.2 }])
}

#[test]
fn single_precision_is_refined_until_energies_are_those_of_double() {
    for cells in [[5, 4, 6], [12, 3, 3]] {
        let lattice = block(cells, 0.1);
        let [double, single] = both(&lattice);
        let load = impact_load(&double, &lattice);
        let mut displacement = Vec::new();
        for scale in [1.0, 1e-60, 1e60] {
            let forces: Vec<f64> = load.forces.iter().map(|f| f * scale).collect();
            let token = CancelToken::default();
            let solved = single.solve(&forces, &mut displacement, &mut ElasticWorkspace::default(), &token).unwrap();
            println!("{cells:?}: {solved:?}");
            assert!(solved.residual <= 1e-7 && (1..=2).contains(&solved.sweeps), "{solved:?}");
        }
        let [exact, found] = [&double, &single].map(|body| {
            let (displacement, mut energies) = (solve(body, &load.forces), Vec::new());
            body.tet_energy(&lattice, &displacement, DrivingEnergy::Total, &mut energies, &CancelToken::default())
                .unwrap();
            energies
        });
        assert!(difference(&exact, &found) <= 1e-6, "{}", difference(&exact, &found));
        assert_eq!((double.precision(), single.precision()), (Precision::F64, Precision::F32));
        assert!(single.own_bytes() < double.own_bytes() * 6 / 10, "{} {}", single.own_bytes(), double.own_bytes());
    }
}

#[test]
fn a_slender_body_keeps_its_factor_in_double_precision() {
    let lattice = block([300, 1, 1], 0.01);
    let [double, single] = both(&lattice);
    let load = impact_load(&double, &lattice);
    // Before it is computed, both sizes are possible.
    assert!(single.factor_bytes() < double.factor_bytes() && double.double_precision_bytes() == 0);
    assert_eq!(single.factor_bytes() + single.double_precision_bytes(), double.factor_bytes());
    assert!(!single.rejects_single_precision());
    assert_eq!(solve(&double, &load.forces), solve(&single, &load.forces));
    assert_eq!((single.precision(), single.own_bytes()), (Precision::F64, double.own_bytes()));
    assert!(single.single_precision_saving() == 0 && double.single_precision_saving() > 0, "it was chosen already");
    assert!(single.rejects_single_precision() && !double.rejects_single_precision());
}
