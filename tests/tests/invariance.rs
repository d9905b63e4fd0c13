//! Invariance of all stages under position, size and rotation of the object.

use nalgebra::{Isometry3, Point3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, bake};
use shatter_fracture::lift;
use shatter_fracture::pipeline::{
    DegreeRequest, ElasticModel, FractureRequest, FragmentRow, ImpactContact, PreparedBody, PreparedObject,
};
use shatter_fracture::sparse::Precision;
use shatter_fracture::surface::{RawMesh, shapes};
use shatter_tests::{real, struck};

/// All parts of a result's mesh.
struct Meshes {
    rows: Vec<FragmentRow>,
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
}

/// A rotated arch, so that no face lies in a plane of the lattice, where rounding would decide.
fn arch(place: impl Fn(Point3<f64>) -> Point3<f64>) -> PreparedObject {
    let mesh = shapes::arch();
    let askew = Isometry3::rotation(Vector3::new(0.31, 0.17, -0.23));
    let moved = mesh.positions_m.iter().map(|p| place(askew * p)).collect();
    let moved = RawMesh::new(moved, mesh.triangles.clone());
    let spacings =
        BakeRequest { elastic_spacing: Some(0.06), crack_spacing: Some(0.035), ..real::request("arch", "stone") };
    bake(moved, &spacings, &CancelToken::default(), &mut |_| ()).unwrap()
}

/// Strikes with 20 sites at a boundary node of the unmoved arch, which the arguments give in the coordinates of `prepared`.
fn strike(prepared: &PreparedObject, point_m: Point3<f64>, impulse_ns: Vector3<f64>) -> Meshes {
    let contact = ImpactContact { point_m, impulse_ns, duration_s: None, radius_m: None, partner: None };
    let strike = FractureRequest {
        contacts: vec![contact],
        degree: DegreeRequest::Sites(20),
        ..FractureRequest::at(point_m, impulse_ns).seeded(1)
    };
    let pieces = struck::outcome(prepared, &strike).unwrap().into_meshes().unwrap();
    let mut positions = vec![[0.0; 3]; pieces.counts.vertices];
    let mut indices = vec![0; pieces.counts.indices];
    let mut merges = vec![[0; 2]; pieces.counts.merges];
    pieces.emit(&mut positions, &mut indices, &mut merges).unwrap();
    Meshes { rows: pieces.fragments, positions, indices }
}

/// Contact point on the unmoved arch.
fn contact(prepared: &PreparedObject) -> Point3<f64> {
    struck::surface_point(prepared, [0.9, 0.5, 0.5]).0
}

const PUSH: Vector3<f64> = Vector3::new(-0.8, -0.3, 0.1);

/// Checks that there are as many fragments, whose volumes divided by `volume` agree to `tolerance`.
#[track_caller]
fn check(a: &Meshes, b: &Meshes, volume: f64, tolerance: f64) {
    assert_eq!(a.rows.len(), b.rows.len());
    for (a, b) in a.rows.iter().zip(&b.rows) {
        let ratio = b.volume_m3 / a.volume_m3 / volume;
        assert!((ratio - 1.0).abs() < tolerance, "fragment {}: {ratio}", a.id);
    }
}

#[test]
fn scaling_by_a_power_of_two_scales_the_meshes_exactly() {
    let (own, large) = (arch(|p| p), arch(|p| p * 8.0));
    let point = contact(&own);
    let (a, b) = (strike(&own, point, PUSH), strike(&large, point * 8.0, PUSH * 64.0));
    check(&a, &b, 512.0, 1e-12);
    assert!(a.indices == b.indices);
    assert!(a.positions.iter().zip(&b.positions).all(|(a, b)| a.map(|x| 8.0 * x) == *b));
}

#[test]
fn translating_the_prepared_object_and_the_contact_keeps_the_fragments_to_rounding() {
    let offset = Vector3::new(3.0, -7.0, 11.0);
    let (own, mut moved) = (arch(|p| p), arch(|p| p));
    moved.frame.center_m += offset;
    let point = contact(&own);
    check(&strike(&own, point, PUSH), &strike(&moved, point + offset, PUSH), 1.0, 1e-6);
}

#[test]
fn turning_the_prepared_lattice_and_the_contact_keeps_the_fragments_to_rounding() {
    let own = arch(|p| p);
    let turn = Isometry3::rotation(Vector3::new(0.4, -1.1, 0.7));
    let bodies = own.bodies.iter().map(|body| {
        let crack = body.crack.transformed(&turn);
        let (modes, alpha) = (own.parameters.modes, own.parameters.alpha);
        let interior = lift::interior(&crack, modes, alpha, &CancelToken::default()).unwrap();
        let solid = body.solid.as_ref().unwrap();
        let elastic = solid.lattice.transformed(&turn);
        let poisson = own.parameters.material.poisson;
        let solid = ElasticModel::new(
            elastic,
            solid.transfer.clone(),
            (poisson, Precision::F64),
            solid.elasticity.order(),
            &CancelToken::default(),
        )
        .unwrap();
        PreparedBody { solid: Some(solid), interior: Some(interior), ..PreparedBody::new(crack) }
    });
    let turned = PreparedObject {
        bodies: bodies.collect(),
        name: own.name.clone(),
        parameters: own.parameters.clone(),
        report: own.report.clone(),
        ..own
    };
    let own = arch(|p| p);
    let point = contact(&own);
    let point_turned = own.frame.to_meters(&(turn * own.frame.to_local(&point)));
    check(&strike(&own, point, PUSH), &strike(&turned, point_turned, turn * PUSH), 1.0, 1e-6);
}
