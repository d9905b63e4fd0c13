//! Bodies as they are baked at the default preset, on stuffed lattices, against closed forms.
//!
//! Based on: G. Lamé, lectures on elasticity (1852): the hollow sphere under pressure; A. I. Lur'e, *Three-Dimensional
//! Problems of the Theory of Elasticity* (1964), ch. 6: the solid sphere under a load that is symmetric about an axis;
//! S. Timoshenko & S. Woinowsky-Krieger, *Theory of Plates and Shells* (1959), §19: circular plates.

use super::quadratic::tractions;
use super::walls::{baked, struck, turns};
use super::*;
use crate::pipeline::{ElementChoice, PreparedObject};
use crate::surface::{RawMesh, shapes};
use nalgebra::Rotation3;
use std::f64::consts::PI;

/// Largest relative error of an elastic energy at the preset `game`.
const BOUND: f64 = 0.05;

/// Solid of the only body.
fn solid(prepared: &PreparedObject) -> (&Elasticity, &Lattice, f64) {
    let solid = prepared.bodies[0].solid.as_ref().unwrap();
    (&solid.elasticity, &solid.lattice, prepared.parameters.material.poisson)
}

/// Energy of `forces` on the nodes, for linear elements.
fn energy(body: &Elasticity, forces: &[f64]) -> f64 {
    body.elastic_energy(forces, &solve(body, forces))
}

/// Ball of unit diameter with a hollow of half its radius.
fn hollow_ball() -> RawMesh {
    let [mut mesh, hollow] = [0.5, 0.25].map(|radius| shapes::sphere(radius, 4));
    let first = mesh.positions_m.len() as u32;
    mesh.positions_m.extend(&hollow.positions_m);
    mesh.triangles.extend(hollow.triangles.iter().map(|&[a, b, c]| [first + a, first + c, first + b]));
    mesh
}

/// Pressure inside: U = ½ p u(a) 4πa², u(a) = p a³ ((1 − 2ν) a + (1 + ν) b³/2a²) / (E (b³ − a³)).
#[test]
fn a_hollow_sphere_under_pressure_has_the_energy_of_lame() {
    let prepared = baked(&hollow_ball(), Rotation3::identity(), ElementChoice::Auto);
    let (body, lattice, poisson) = solid(&prepared);
    let [a, b] = [0.25, 0.5].map(|radius: f64| radius / prepared.frame.diagonal_m);
    let center = prepared.frame.to_local(&Point3::origin());
    let pressure = |place: Point3<f64>| {
        Matrix3::from_diagonal_element(if (place - center).norm() < 0.5 * (a + b) { -1.0 } else { 0.0 })
    };
    let mut forces = tractions(body, lattice, pressure);
    body.relieve(&mut forces);
    let widening =
        a.powi(3) * ((1.0 - 2.0 * poisson) * a + (1.0 + poisson) * b.powi(3) / (2.0 * a * a)) / (b.powi(3) - a.powi(3));
    let ratio = energy(body, &forces) / (0.5 * widening * 4.0 * PI * a * a);
    println!("hollow sphere, {} nodes: {ratio:.4} of the closed form", lattice.nodes.len());
    assert!((ratio - 1.0).abs() < BOUND, "{ratio}");
}

/// Legendre polynomials P_0 to P_n at `x`, and their derivatives.
fn legendre(x: f64, n: usize) -> Vec<[f64; 2]> {
    let mut found = vec![[1.0, 0.0], [x, 1.0]];
    for k in 2..=n {
        let ([before, _], [last, slope]) = (found[k - 2], found[k - 1]);
        let count = k as f64;
        found.push([((2.0 * count - 1.0) * x * last - (count - 1.0) * before) / count, x * slope + count * last]);
    }
    found
}

/// Energy of a sphere of unit radius and unit Young's modulus that two unit forces press together along its axis. They
/// are spread as a contact of this radius spreads them.
///
/// With p_n P_n the normal traction and q_n dP_n/dθ that along the meridian, and displacements
/// u_r = (A (n + 1)(n − 2 + 4ν) + B n) P_n and u_θ = (A (n + 5 − 4ν) + B) dP_n/dθ, A and B follow from
/// p_n = 2G (A (n + 1)(n² − n − 2 − 2ν) + B n (n − 1)) and q_n = 2G (A (n² + 2n − 1 + 2ν) + B (n − 1)).
fn pressed_sphere(radius: f64, poisson: f64) -> f64 {
    const TERMS: usize = 400;
    const STEPS: usize = 20_000;
    let bell = |angle: f64| ((-0.5 * (angle / radius).powi(2)).exp() - (-4.5_f64).exp()).max(0.0);
    let (mut total, mut normal, mut along) = (0.0, vec![0.0; TERMS + 1], vec![0.0; TERMS + 1]);
    let step = 3.0 * radius / STEPS as f64;
    for index in 0..STEPS {
        let angle = (index as f64 + 0.5) * step;
        let (sin, cos) = angle.sin_cos();
        let ring = bell(angle) * sin * step;
        total += 2.0 * PI * ring;
        for (n, [value, slope]) in legendre(cos, TERMS).into_iter().enumerate() {
            normal[n] -= ring * cos * value;
            along[n] -= ring * sin * sin * slope;
        }
    }
    let shear = 0.5 / (1.0 + poisson);
    let mut energy = 0.0;
    // The opposite force doubles the even terms and cancels the odd ones.
    for n in (0..=TERMS).step_by(2) {
        let k = n as f64;
        let share = 2.0 * k + 1.0;
        let p = normal[n] * share / total / (2.0 * shear);
        let q = if n == 0 { 0.0 } else { along[n] * share / (k * (k + 1.0)) / total / (2.0 * shear) };
        let rows = [
            [(k + 1.0) * (k * k - k - 2.0 - 2.0 * poisson), k * (k - 1.0)],
            [k * k + 2.0 * k - 1.0 + 2.0 * poisson, k - 1.0],
        ];
        let determinant = rows[0][0] * rows[1][1] - rows[0][1] * rows[1][0];
        let [a, b] = if n == 0 {
            [p / rows[0][0], 0.0]
        } else {
            [(p * rows[1][1] - q * rows[0][1]) / determinant, (q * rows[0][0] - p * rows[1][0]) / determinant]
        };
        let radial = a * (k + 1.0) * (k - 2.0 + 4.0 * poisson) + b * k;
        let meridian = a * (k + 5.0 - 4.0 * poisson) + b;
        energy += 0.5 * 2.0 * shear * 4.0 * PI / share * (p * radial + q * meridian * k * (k + 1.0));
    }
    energy
}

#[test]
fn a_pressed_sphere_has_the_energy_of_lure() {
    let prepared = baked(&shapes::sphere(0.5, 5), Rotation3::identity(), ElementChoice::Auto);
    let (_, lattice, poisson) = solid(&prepared);
    println!("{} nodes", lattice.nodes.len());
    for turn in [Vector3::x(), Vector3::new(1.0, 2.0, 3.0).normalize()] {
        for share in [0.15, 0.2, 0.3] {
            let forces = [1.0, -1.0].map(|side| (Point3::from(turn * (side * 0.5)), turn * -side));
            // Energies of unit forces are those of unit length over the length.
            let exact = pressed_sphere(share, poisson) * prepared.frame.diagonal_m / 0.5;
            let ratio = struck(&prepared, Rotation3::identity(), &forces, 0.5 * share) / exact;
            println!("sphere, contact radius {share} R: {ratio:.4} of the closed form");
            assert!((ratio - 1.0).abs() < BOUND, "{ratio}");
        }
    }
}

/// Disc around z, its ends triangulated from their middles.
pub(super) fn disc(radius: f64, thick: f64) -> RawMesh {
    let count = 256_u32;
    let mut positions = vec![Point3::new(0.0, 0.0, -0.5 * thick), Point3::new(0.0, 0.0, 0.5 * thick)];
    for index in 0..count {
        let (sin, cos) = (2.0 * PI * f64::from(index) / f64::from(count)).sin_cos();
        positions.extend([-0.5, 0.5].map(|side| Point3::new(radius * cos, radius * sin, side * thick)));
    }
    let mut triangles = Vec::new();
    for index in 0..count {
        let [here, next] = [2 + 2 * index, 2 + 2 * ((index + 1) % count)];
        triangles.extend([
            [0, next, here],
            [1, here + 1, next + 1],
            [here, next, next + 1],
            [here, next + 1, here + 1],
        ]);
    }
    RawMesh::new(positions, triangles)
}

/// D of unit Young's modulus.
fn plate_stiffness(thick: f64, poisson: f64) -> f64 {
    thick.powi(3) / (12.0 * (1.0 - poisson * poisson))
}

/// Nodes whose places in the mesh, before it was turned, pass `is_held`.
fn held(prepared: &PreparedObject, turn: Rotation3<f64>, is_held: impl Fn(Point3<f64>) -> bool) -> Elasticity {
    let (body, lattice, _) = solid(prepared);
    let place = |node: &Point3<f64>| turn.inverse() * prepared.frame.to_meters(node);
    let nodes = (0..lattice.nodes.len() as u32).filter(|&node| is_held(place(&lattice.nodes[node as usize]))).collect();
    body.anchored(nodes, &CancelToken::default()).unwrap()
}

/// Energy of one unit force on a held body.
fn struck_held(
    prepared: &PreparedObject,
    turn: Rotation3<f64>,
    held: &Elasticity,
    at: Point3<f64>,
    radius: f64,
) -> f64 {
    let point = prepared.frame.to_local(&(turn * at));
    let contact = ContactLoad { point, impulse: turn * -Vector3::z(), radius: radius / prepared.frame.diagonal_m };
    energy(held, &load(held, &[contact]).forces)
}

/// Energy of a free plate of radius R under a unit force in its middle and the inertia of its acceleration, for unit
/// Young's modulus: with q = F/πR², w = F r² ln r / 8πD − q r⁴/64D + C r², whose bending moment vanishes at R;
/// U = −½ ∫ q w.
pub(super) fn free_plate(radius: f64, thick: f64, poisson: f64) -> f64 {
    let (stiffness, log, pressure) = (plate_stiffness(thick, poisson), radius.ln(), 1.0 / (PI * radius * radius));
    let moments = (2.0 * log + 3.0 + poisson * (2.0 * log + 1.0)) / (8.0 * PI * stiffness)
        - pressure * radius * radius * (3.0 + poisson) / (16.0 * stiffness);
    let c = -moments / (2.0 * (1.0 + poisson));
    // ∫ r² ln r · r dr = R⁴ (ln R/4 − 1/16), ∫ r⁴ · r dr = R⁶/6, ∫ r² · r dr = R⁴/4.
    let integral = radius.powi(4) * (log / 4.0 - 1.0 / 16.0) / (8.0 * PI * stiffness)
        - pressure * radius.powi(6) / 6.0 / (64.0 * stiffness)
        + c * radius.powi(4) / 4.0;
    -0.5 * pressure * 2.0 * PI * integral
}

/// Energy of a plate that is held at the radius R and beyond: U = ½ F w, w = F R²/16πD.
fn clamped_plate(radius: f64, thick: f64, poisson: f64) -> f64 {
    radius * radius / (32.0 * PI * plate_stiffness(thick, poisson))
}

#[test]
fn plates_struck_in_the_middle_have_the_energies_of_kirchhoff() {
    let ([radius, clamp], thick) = ([0.55_f64, 0.5], 0.022);
    let middle = Point3::new(0.0, 0.0, 0.5 * thick);
    for turn in [turns()[0], turns()[1]] {
        let prepared = baked(&disc(radius, thick), turn, ElementChoice::Auto);
        let poisson = solid(&prepared).2;
        let exact = free_plate(radius, thick, poisson) * prepared.frame.diagonal_m;
        let free = struck(&prepared, turn, &[(middle, -Vector3::z())], 0.01) / exact;
        let held = held(&prepared, turn, |place| place.x.hypot(place.y) >= clamp);
        let exact = clamped_plate(clamp, thick, poisson) * prepared.frame.diagonal_m;
        let clamped = struck_held(&prepared, turn, &held, middle, 0.01) / exact;
        println!("plate 1:50, free {free:.4}, clamped {clamped:.4} of the closed form");
        assert!([free, clamped].iter().all(|ratio| (ratio - 1.0).abs() < BOUND), "{free}, {clamped}");
    }
}

/// A beam held at its root, pushed at its tip: U = F² (L³/6EI + 3L/5GA).
#[test]
fn cantilevers_bend_as_beams_do_in_five_orientations() {
    let [length, side, root] = [1.0_f64, 0.08, 0.1];
    let more = [[0.9, -0.2, 0.3], [0.2, 0.7, 2.0]].map(|[x, y, z]| Rotation3::from_euler_angles(x, y, z));
    for turn in turns().into_iter().chain(more) {
        let prepared = baked(&shapes::cuboid([length, side, side]), turn, ElementChoice::Auto);
        let held = held(&prepared, turn, |place| place.x <= root - 0.5 * length);
        let tip = 0.45 * length;
        let (span, poisson) = (tip + 0.5 * length - root, solid(&prepared).2);
        let exact = span.powi(3) / (6.0 * side.powi(4) / 12.0) + 0.6 * span * 2.0 * (1.0 + poisson) / (side * side);
        let at = Point3::new(tip, 0.0, 0.5 * side);
        let ratio = struck_held(&prepared, turn, &held, at, 0.04) / (exact * prepared.frame.diagonal_m);
        let report = &prepared.report.elastic[0];
        println!("cantilever, {} nodes, {:.2} across: {ratio:.4}", held.size() / 3, report.elements_across);
        assert!((ratio - 1.0).abs() < BOUND, "{ratio}");
    }
}
