//! Errors of invalid input.

use super::*;

fn prepare(lattice: &Lattice, poisson: f64) -> Option<ElasticityError> {
    Elasticity::prepare(lattice, poisson, &CancelToken::default()).err()
}

#[test]
fn poisson_ratios_outside_the_range_are_refused() {
    let lattice = block([1, 1, 1], 1.0);
    for poisson in [-1.0, 0.5, 0.7, f64::NEG_INFINITY] {
        assert_eq!(prepare(&lattice, poisson), Some(ElasticityError::PoissonOutOfRange { poisson }));
    }
    assert!(matches!(prepare(&lattice, f64::NAN), Some(ElasticityError::PoissonOutOfRange { .. })));
    for poisson in [0.451, 0.499] {
        assert_eq!(prepare(&lattice, poisson), Some(ElasticityError::LockingPoisson { poisson }));
    }
    for poisson in [-0.9, 0.0, POISSON_MAX] {
        assert_eq!(prepare(&lattice, poisson), None);
    }
}

#[test]
fn invalid_lattices_are_rejected() {
    assert_eq!(prepare(&Lattice::default(), 0.3), Some(ElasticityError::EmptyLattice));
    let mut flat = block([1, 1, 1], 1.0);
    flat.tets[7].swap(0, 1);
    assert_eq!(prepare(&flat, 0.3), Some(ElasticityError::DegenerateTet { tet: 7 }));
    let mut infinite = block([1, 1, 1], 1.0);
    infinite.nodes[infinite.tets[3][2] as usize].y = f64::NAN;
    assert!(matches!(prepare(&infinite, 0.3), Some(ElasticityError::DegenerateTet { .. })));
    let anchored = Support::Anchored(vec![0, 99]);
    let error = Elasticity::supported(&block([1, 1, 1], 1.0), 0.3, anchored, &CancelToken::default()).err();
    assert_eq!(error, Some(ElasticityError::UnknownAnchor { node: 99 }));
}

/// Two cubes that share a corner or an edge. Rounding may let the factorization pass.
#[test]
fn mechanisms_are_refused() {
    let slab = block([2, 2, 2], 0.37);
    let cubes = |second: [f64; 3]| {
        carve(&slab, move |place| {
            let inside = |corner: [f64; 3]| (0..3).all(|axis| place[axis] * corner[axis] > 0.0);
            inside([-1.0, -1.0, -1.0]) || inside(second)
        })
    };
    for lattice in [cubes([1.0, 1.0, 1.0]), cubes([1.0, 1.0, -1.0])] {
        let error = prepare(&lattice, 0.3);
        assert!(matches!(error, Some(ElasticityError::Mechanism { .. } | ElasticityError::Stiffness(_))), "{error:?}");
        let later = Elasticity::assembled(&lattice, 0.3, &CancelToken::default()).unwrap();
        if let Err(ElasticityError::Mechanism { .. }) = later.factor() {
            let tet = later.weakest_tet(&lattice).unwrap();
            let center = lattice.corners(tet).iter().map(|corner| corner.coords).sum::<Vector3<f64>>() / 4.0;
            // The joint is the middle, or the vertical line through it.
            assert!(center.xy().norm() < 0.37, "{center}");
        }
        assert_eq!(free(&block([2, 2, 2], 0.37), 0.3).weakest_tet(&lattice), None);
        let forces = vec![0.0; later.size()];
        let solved = later.solve(&forces, &mut Vec::new(), &mut ElasticWorkspace::default(), &CancelToken::default());
        assert_eq!((solved.err(), later.factor().err()), (error, error), "every use must fail");
    }
    assert_eq!(prepare(&cubes([1.0, -1.0, -1.0]), 0.3), None, "a shared face connects them");
}

#[test]
fn bad_contacts_are_refused() {
    let lattice = block([2, 2, 2], 0.5);
    let body = free(&lattice, 0.3);
    let good = ContactLoad { point: Point3::new(0.5, 0.0, 0.0), impulse: -Vector3::x(), radius: 0.1 };
    let error = |bad: ContactLoad| {
        body.load(&[good, bad], &mut NodalLoad::default(), &mut ElasticWorkspace::default()).unwrap_err()
    };
    let none = body.load(&[], &mut NodalLoad::default(), &mut ElasticWorkspace::default());
    assert_eq!(none, Err(ElasticityError::NoContacts));
    let at = |x: f64| ContactLoad { point: Point3::new(x, 0.0, 0.0), ..good };
    assert_eq!(error(at(f64::NAN)), ElasticityError::NonFinitePoint { contact: 1 });
    let impulse = |impulse| error(ContactLoad { impulse, ..good });
    assert_eq!(impulse(Vector3::new(0.0, f64::INFINITY, 0.0)), ElasticityError::NonFiniteImpulse { contact: 1 });
    assert_eq!(impulse(Vector3::zeros()), ElasticityError::ZeroImpulse { contact: 1 });
    for radius in [0.0, -1.0, f64::INFINITY] {
        let refused = error(ContactLoad { radius, ..good });
        assert_eq!(refused, ElasticityError::RadiusOutOfRange { contact: 1, radius });
    }
    match error(at(0.7)) {
        ElasticityError::TooFar { contact: 1, distance, radius: 0.1 } => assert!((distance - 0.2).abs() < 1e-12),
        other => panic!("{other}"),
    }
    assert!(matches!(error(at(0.2)), ElasticityError::TooFar { .. }), "depth inside counts as distance");
    assert!(matches!(error(at(1e300)), ElasticityError::TooFar { .. }));
    assert!((body.distance(&Point3::new(0.7, 0.0, 0.0)) - 0.2).abs() < 1e-12);
    let huge = load(&body, &[ContactLoad { radius: 1e300, ..good }]);
    assert!(huge.forces.iter().all(|force| force.is_finite()));
}

#[test]
fn unbalanced_loads_and_wrong_array_lengths_are_rejected() {
    let lattice = block([2, 2, 2], 0.5);
    let body = free(&lattice, 0.3);
    let (mut workspace, token, mut out) = (ElasticWorkspace::default(), CancelToken::default(), Vec::new());
    let mut push = vec![0.0; body.size()];
    push[3 * 40] = 1.0;
    let raw = body.solve(&push, &mut out, &mut workspace, &token);
    assert!(matches!(raw, Err(ElasticityError::Residual { residual }) if residual > 0.1), "{raw:?}");
    push[3] = f64::NAN;
    assert!(matches!(body.solve(&push, &mut out, &mut workspace, &token), Err(ElasticityError::Residual { .. })));
    let short = body.solve(&push[3..], &mut out, &mut workspace, &token);
    assert!(matches!(short, Err(ElasticityError::OtherLattice { .. })));
    let other = body.tet_energy(&block([2, 2, 1], 0.5), &push, DrivingEnergy::Total, &mut out, &token);
    assert!(matches!(other, Err(ElasticityError::OtherLattice { .. })));
    let still = body.solve(&vec![0.0; body.size()], &mut out, &mut workspace, &token);
    assert_eq!(still, Ok(SolveReport { residual: 0.0, sweeps: 0 }));
    assert!(out.iter().all(|&u| u == 0.0));
}

#[test]
fn canceled_work_stops() {
    let lattice = block([2, 2, 2], 0.5);
    let body = free(&lattice, 0.3);
    let (mut out, token) = (Vec::new(), CancelToken::default());
    token.cancel();
    let canceled = ElasticityError::Canceled(crate::cancel_token::Canceled);
    assert_eq!(Elasticity::prepare(&lattice, 0.3, &token).err(), Some(canceled));
    let forces = vec![0.0; body.size()];
    assert_eq!(body.solve(&forces, &mut out, &mut ElasticWorkspace::default(), &token), Err(canceled));
    assert_eq!(body.tet_energy(&lattice, &forces, DrivingEnergy::Total, &mut out, &token), Err(canceled));
}
