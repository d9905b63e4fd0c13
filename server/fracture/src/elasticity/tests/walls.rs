//! Thin walls as they are baked, turned out of the lattice's directions, struck as by a request, against closed forms.
//!
//! Based on: S. Timoshenko, *Strength of Materials* I (1940): the free beam under its inertia, and the ring under two
//! opposite forces, δ = (π/4 − 2/π) F R³ / (E I).

use super::*;
use crate::BakeRequest;
use crate::database::{Tables, bake};
use crate::pipeline::{DisplacementMethod, ElementChoice, PreparedObject, SurfaceKind};
use crate::scene::Material;
use crate::surface::{RawMesh, shapes};
use nalgebra::Rotation3;
use std::f64::consts::PI;

/// Orientations: that of the lattice, and two out of all its directions.
pub(super) fn turns() -> [Rotation3<f64>; 3] {
    [[0.0; 3], [0.4, 1.1, -0.7], [-1.3, 0.5, 0.25]].map(|[x, y, z]| Rotation3::from_euler_angles(x, y, z))
}

/// Object at default spacings, with elasticity only and without a mesh of its surface.
pub(super) fn baked(mesh: &RawMesh, turn: Rotation3<f64>, elements: ElementChoice) -> PreparedObject {
    let mut mesh = mesh.clone();
    mesh.positions_m.iter_mut().for_each(|place| *place = turn * *place);
    let tables = Tables { elastic: true, ..Tables::NONE };
    let request = BakeRequest::new("wall", "glass", Material::named("glass").unwrap());
    let (elastic, surface) = (DisplacementMethod::Solve, SurfaceKind::Lattice);
    let request = BakeRequest { tables, elements, elastic, surface, ..request };
    bake(mesh, &request, &CancelToken::default(), &mut |_| ()).unwrap()
}

/// Energy of `forces` at points, both in the coordinates of the mesh, in local units of unit Young's modulus.
pub(super) fn struck(
    prepared: &PreparedObject,
    turn: Rotation3<f64>,
    forces: &[(Point3<f64>, Vector3<f64>)],
    radius_m: f64,
) -> f64 {
    let body = &prepared.bodies[0].solid.as_ref().unwrap().elasticity;
    let contacts: Vec<ContactLoad> = forces
        .iter()
        .map(|(place, force)| ContactLoad {
            point: prepared.frame.to_local(&(turn * place)),
            impulse: turn * force,
            radius: radius_m / prepared.frame.diagonal_m,
        })
        .collect();
    let forces = load(body, &contacts).forces;
    let start = std::time::Instant::now();
    let displacement = solve(body, &forces);
    let energy = body.elastic_energy(&forces, &displacement);
    let report = &prepared.report.elastic[0];
    let volume = prepared.bodies[0].solid.as_ref().unwrap().lattice.volume() * prepared.frame.diagonal_m.powi(3);
    let volume = volume / prepared.report.input_volume_m3;
    println!(
        "{} nodes, {:?}, {:.2} across, volume {volume:.4}, solved in {:?}",
        body.size() / 3,
        report.order,
        report.elements_across,
        start.elapsed()
    );
    energy
}

/// Strip of 1 m × 0.1 m, struck in the middle: U = F² L³ / (640 E I).
fn strip_ratio(turn: Rotation3<f64>, elements: ElementChoice, thick: f64) -> f64 {
    let [length, width] = [1.0, 0.1];
    let prepared = baked(&shapes::cuboid([length, width, thick]), turn, elements);
    let force = (Point3::new(0.0, 0.0, 0.5 * thick), -Vector3::z());
    let exact = length.powi(3) / (640.0 * width * thick.powi(3) / 12.0) * prepared.frame.diagonal_m;
    struck(&prepared, turn, &[force], 0.01) / exact
}

/// Energy of a short tube, five times as wide as thick, pressed together by two opposite forces, over that of the ring, U = δ F / 2.
pub(super) fn ring_ratio(turn: Rotation3<f64>, elements: ElementChoice, thick: f64) -> f64 {
    let (radius, width) = (0.5, 5.0 * thick);
    let prepared = baked(&tube(radius, thick, width), turn, elements);
    let outer = radius + 0.5 * thick;
    let forces = [1.0, -1.0].map(|side| (Point3::new(side * outer, 0.0, 0.0), Vector3::x() * -side));
    let exact =
        0.5 * (PI / 4.0 - 2.0 / PI) * radius.powi(3) / (width * thick.powi(3) / 12.0) * prepared.frame.diagonal_m;
    struck(&prepared, turn, &forces, 0.01) / exact
}

/// Tube around z of this mean radius, with 360 corners around.
fn tube(radius: f64, thick: f64, width: f64) -> RawMesh {
    let count = 360_u32;
    let mut positions = Vec::new();
    for index in 0..count {
        let (sin, cos) = (2.0 * PI * f64::from(index) / f64::from(count)).sin_cos();
        for [side, end] in [[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]] {
            let r = radius + 0.5 * side * thick;
            positions.push(Point3::new(r * cos, r * sin, 0.5 * end * width));
        }
    }
    let mut triangles = Vec::new();
    for index in 0..count {
        let [here, next] = [4 * index, 4 * ((index + 1) % count)];
        for corner in 0..4 {
            let other = (corner + 1) % 4;
            triangles
                .extend([[here + corner, next + corner, next + other], [here + corner, next + other, here + other]]);
        }
    }
    RawMesh::new(positions, triangles)
}

#[test]
fn strips_bend_as_beams_do() {
    for turn in turns().into_iter().take(2) {
        let ratio = strip_ratio(turn, ElementChoice::Auto, 0.01);
        println!("strip 1:100: {ratio:.4} of the closed form");
        assert!((0.97..1.03).contains(&ratio), "{ratio}");
    }
    let linear = strip_ratio(turns()[1], ElementChoice::Linear, 0.01);
    println!("strip 1:100, linear elements: {linear:.4}");
    assert!(linear < 0.75, "{linear}");
}

/// Strips that are too thin for regular lattices have cells that are longer along the strip than across it.
#[test]
fn strips_on_stretched_cells_bend_as_beams_do() {
    let ratio = strip_ratio(turns()[1], ElementChoice::Auto, 0.002);
    println!("strip 1:500: {ratio:.4} of the closed form");
    assert!((0.97..1.03).contains(&ratio), "{ratio}");
}

#[test]
fn tubes_bend_as_rings_do() {
    for turn in turns().into_iter().take(2) {
        let ratio = ring_ratio(turn, ElementChoice::Auto, 0.02);
        println!("tube, radius over thickness 25: {ratio:.4} of the closed form");
        assert!((0.95..1.05).contains(&ratio), "{ratio}");
    }
    let linear = ring_ratio(turns()[1], ElementChoice::Linear, 0.02);
    println!("tube, linear elements: {linear:.4}");
    assert!(linear < 0.75, "{linear}");
}
