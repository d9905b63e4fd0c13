use super::*;
use crate::lattice::shapes::{ball, balls};
use crate::lattice::{block, check_manifold};

fn made(list: &[([f64; 3], f64)], elastic: f64, crack: f64) -> LatticeLevels {
    let shape = balls(list.iter().map(|(center, radius)| (Point3::from(*center), *radius)).collect());
    let volume = list.iter().map(|(_, radius)| 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3)).sum();
    let made = levels(
        &shape,
        Spacings { elastic, crack, refine: false, fits_elastic: false },
        volume,
        &CancelToken::default(),
    )
    .unwrap();
    check(&made);
    made
}

/// Checks the invariants of levels: valid lattices, conserved energy, consistent statistics.
fn check(levels: &LatticeLevels) {
    for body in &levels.bodies {
        check_manifold(&body.elastic).unwrap();
        check_manifold(&body.crack).unwrap();
        let energy = vec![1.0; body.elastic.tets.len()];
        let mut nodes = Vec::new();
        body.transfer.apply(&energy, &mut nodes);
        assert_eq!(nodes.len(), body.crack.nodes.len());
        assert!((nodes.iter().sum::<f64>() / energy.len() as f64 - 1.0).abs() < 1e-12);
    }
    let nodes: usize = levels.bodies.iter().map(|body| body.crack.nodes.len()).sum();
    assert_eq!((levels.crack.nodes, levels.crack.bodies), (nodes, levels.bodies.len()));
    for replaced in &levels.replaced {
        let body = &levels.bodies[replaced.body];
        assert_eq!(body.elastic, body.crack);
    }
}

#[test]
fn bodies_of_two_levels_are_paired() {
    let levels = made(&[([-0.2, 0.0, 0.0], 0.12), ([0.2, 0.05, 0.0], 0.18)], 0.06, 0.035);
    assert_eq!((levels.bodies.len(), levels.replaced.len(), levels.unmatched_volume), (2, 0, 0.0));
    for body in &levels.bodies {
        assert!((body.elastic.center() - body.crack.center()).norm() < 0.01);
        assert!(body.elastic.nodes.len() < body.crack.nodes.len());
    }
    assert!(levels.bodies[0].crack.volume() > levels.bodies[1].crack.volume());
}

#[test]
fn a_body_that_the_coarse_level_lost_is_solved_on_its_crack_lattice() {
    let levels = made(&[([-0.2, 0.0, 0.0], 0.25), ([0.3, 0.05, 0.0], 0.06)], 0.2, 0.03);
    assert_eq!(levels.bodies.len(), 2);
    assert_eq!(levels.replaced.len(), 1);
    assert_eq!((levels.replaced[0].body, levels.replaced[0].reason), (1, Replacement::Lost));
}

#[test]
fn bodies_that_the_coarse_level_joins_are_solved_apart() {
    // The gap of 0.02 is far below the coarse spacing, so the grid joins both balls across it.
    let levels = made(&[([-0.16, 0.0, 0.0], 0.15), ([0.16, 0.0, 0.0], 0.15)], 0.15, 0.018);
    assert_eq!(levels.bodies.len(), 2);
    if levels.elastic.as_ref().is_some_and(|report| report.bodies == 1) {
        assert!(levels.replaced.iter().all(|replaced| replaced.reason == Replacement::Fused));
        assert_eq!(levels.replaced.len(), 2);
    }
}

#[test]
fn pairing_reports_fused_and_lost_bodies() {
    let whole = block([4, 1, 1], 0.1);
    let tet_at = |tet: usize| whole.corners(tet).iter().map(|corner| corner.x).sum::<f64>() / 4.0;
    let part = |keep: &dyn Fn(f64) -> bool| {
        whole.part(&(0..whole.tets.len() as u32).filter(|&tet| keep(tet_at(tet as usize))).collect::<Vec<_>>())
    };
    let level = |bodies: Vec<Lattice>| LatticeLevel {
        bodies,
        dropped: Vec::new(),
        pinches_mended: 0,
        mended_volume: 0.0,
        offset: 0.0,
        spacing: 0.1,
    };
    let halves = || vec![part(&|x| x < 0.0), part(&|x| x > 0.0)];
    let reasons = |crack, elastic| {
        let levels = pair(level(crack), Some(level(elastic)), Vec::new(), &CancelToken::default()).unwrap();
        check(&levels);
        (levels.replaced.iter().map(|replaced| replaced.reason).collect::<Vec<_>>(), levels.unmatched_volume)
    };
    let (fused, unmatched) = reasons(halves(), vec![whole.clone()]);
    assert_eq!(fused, [Replacement::Fused; 2]);
    assert!((unmatched - whole.volume()).abs() < 1e-15);
    assert_eq!(reasons(halves(), halves()), (vec![], 0.0));
    let (lost, unmatched) = reasons(vec![whole.clone()], halves());
    assert_eq!(lost, [Replacement::Lost]);
    assert!((unmatched - whole.volume()).abs() < 1e-15);
    assert_eq!(reasons(halves(), vec![part(&|x| x > 0.0)]).0, [Replacement::Lost]);
}

#[test]
fn an_empty_coarse_level_is_no_error() {
    let shape = ball(0.04);
    let levels = levels(
        &shape,
        Spacings { elastic: 0.2, crack: 0.015, refine: false, fits_elastic: false },
        2.6e-4,
        &CancelToken::default(),
    )
    .unwrap();
    check(&levels);
    assert!(levels.elastic.is_none() && levels.replaced.len() == 1);
}
