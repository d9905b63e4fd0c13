//! Refined bodies with quadratic elements against exact solutions, and impacts against references of one more level.
//!
//! A displacement without body force, and its stress, solve any body under the tractions of the stress on its boundary.
//! The energy is half the work of the tractions, whatever the shape of the lattice.
//!
//! Based on: P. F. Papkovich (1932) and H. Neuber (1934), displacements from harmonic functions; G. Lamé, lectures on
//! elasticity (1852), the hollow sphere under pressure.

use super::tests::{check_order, refined};
use super::*;
use crate::accuracy::Extrapolation;
use crate::lattice::{SignedDistance, stuff};
use crate::random::RandomStream;
use crate::reference::{ball, kuhn, perturbed};
use nalgebra::{Complex, Isometry3, Matrix3, Point3, Rotation3, Vector3};

/// Order of the energy with which the references of the accuracy study are extrapolated.
const STUDY: f64 = 2.0;

/// Order of the energy with quadratic elements on smooth problems.
const THEORY: f64 = 4.0;

/// Displacement and stress at a place, for unit Young's modulus.
type Field<'a> = dyn Fn(&Point3<f64>) -> (Vector3<f64>, Matrix3<f64>) + Sync + 'a;

/// Polynomial displacement 2G u = 4(1 − ν) B − ∇(x·B), with the harmonic B = Re b (a·x)ⁿ and a·a = 0.
struct Polynomial {
    a: Vector3<Complex<f64>>,
    b: Vector3<Complex<f64>>,
    degree: i32,
    poisson: f64,
}

impl Polynomial {
    fn random(stream: &mut RandomStream, degree: i32, poisson: f64) -> Self {
        let mut angle = || 6.0 * stream.uniform();
        let turn = Rotation3::from_euler_angles(angle(), angle(), angle());
        let complex = |re: Vector3<f64>, im: Vector3<f64>| re.zip_map(&im, Complex::new);
        let a = complex(turn * Vector3::x(), turn * Vector3::y());
        let mut any = || Vector3::from_fn(|_, _| stream.uniform() - 0.5);
        Self { a, b: complex(any(), any()), degree, poisson }
    }

    fn at(&self, place: &Point3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
        let Self { a, b, degree, poisson } = self;
        let (x, count) = (place.coords.map(Complex::from), f64::from(*degree));
        let power = |less: i32| a.dot(&x).powi(degree - less);
        let slope = b * a.transpose() * (power(1) * count);
        let moved = b * power(0) * Complex::from(3.0 - 4.0 * poisson) - a * (x.dot(b) * power(1) * count);
        let bent = a * a.transpose() * (x.dot(b) * power(2) * (count * (count - 1.0)));
        let slope = slope.map(|entry| entry.re);
        let stress = (slope + slope.transpose()) * (1.0 - 2.0 * poisson)
            + Matrix3::from_diagonal_element(2.0 * poisson * slope.trace())
            - bent.map(|entry| entry.re);
        (moved.map(|entry| entry.re * (1.0 + poisson)), stress)
    }
}

/// Lamé's hollow sphere with the radii 0.25 and 0.5 about the origin under unit pressure inside.
fn lame(place: &Point3<f64>, poisson: f64) -> (Vector3<f64>, Matrix3<f64>) {
    let [inner, outer] = [0.25_f64, 0.5].map(|radius| radius.powi(3));
    let (r, scale) = (place.coords.norm(), inner / (outer - inner));
    let normal = place.coords / r;
    let moved = normal * (scale * ((1.0 - 2.0 * poisson) * r + (1.0 + poisson) * outer / (2.0 * r * r)));
    let [radial, around] = [-1.0, 0.5].map(|share| scale * (1.0 + share * outer / r.powi(3)));
    let along = normal * normal.transpose();
    (moved, along * radial + (Matrix3::identity() - along) * around)
}

/// A stress that bends a beam along x purely, σ_xx = z, and its displacement, turned.
fn bending(place: &Point3<f64>, turn: &Rotation3<f64>, poisson: f64) -> (Vector3<f64>, Matrix3<f64>) {
    let own = turn.inverse() * place;
    let [x, y, z] = own.coords.data.0[0];
    let moved = Vector3::new(x * z, -poisson * y * z, -0.5 * (x * x + poisson * (z * z - y * y)));
    let turn = turn.matrix();
    (turn * moved, turn * Matrix3::from_diagonal(&Vector3::new(z, 0.0, 0.0)) * turn.transpose())
}

/// Barycentric coordinates and weights of a rule that integrates polynomials of degree 8 over triangles: Gauss's five
/// points along two sides of a square whose one side is moved into a corner.
fn triangle_rule() -> Vec<([f64; 3], f64)> {
    let root = (10.0_f64 / 7.0).sqrt();
    let [near, far] = [-2.0, 2.0].map(|share| (5.0 + share * root).sqrt() / 3.0);
    let [heavy, light] = [13.0, -13.0].map(|share| (322.0 + share * 70.0_f64.sqrt()) / 1800.0);
    let line = [(-far, light), (-near, heavy), (0.0, 64.0 / 225.0), (near, heavy), (far, light)]
        .map(|(at, weight)| (0.5 * (1.0 + at), weight));
    let pairs = line.iter().flat_map(|u| line.iter().map(move |v| (*u, *v)));
    pairs.map(|((u, wu), (v, wv))| ([1.0 - u, u * (1.0 - v), u * v], 2.0 * u * wu * wv)).collect()
}

/// Forces of the tractions of a field on the nodes and edges of a level, and the energy of the field.
fn tractions(body: &RefinedBody, level: usize, field: &Field<'_>) -> (Vec<f64>, f64) {
    let (lattice, rule) = (body.lattice(level), triangle_rule());
    let (edges, size) = (lattice.edges(), 3 * lattice.nodes.len());
    let edge = |a: u32, b: u32| edges.binary_search(&[a.min(b), a.max(b)]).unwrap();
    let (mut forces, mut work) = (vec![0.0; body.unknowns(level)], 0.0);
    for face in lattice.boundary() {
        let nodes = face.nodes;
        let corners = nodes.map(|node| lattice.nodes[node as usize]);
        let area = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])) * 0.5;
        for (l, weight) in &rule {
            let place = Point3::from((0..3).map(|k| corners[k].coords * l[k]).sum::<Vector3<f64>>());
            let (moved, stress) = field(&place);
            let force = stress * area * *weight;
            work += force.dot(&moved);
            for k in 0..3 {
                let [next, other] = [(k + 1) % 3, (k + 2) % 3];
                let on_edge = size + 3 * edge(nodes[next], nodes[other]);
                for (first, share) in [(3 * nodes[k] as usize, l[k]), (on_edge, 4.0 * l[next] * l[other])] {
                    (0..3).for_each(|axis| forces[first + axis] += share * force[axis]);
                }
            }
        }
    }
    body.surface(level).1.relieve(&mut forces[..size]);
    (forces, 0.5 * work)
}

/// Energies on the levels 0, 1, 2, and the exact one.
fn energies(body: &RefinedBody, field: &Field<'_>) -> ([f64; 3], f64) {
    let found = [0, 1, 2].map(|level| {
        let (forces, exact) = tractions(body, level, field);
        let given = |_: usize, _: &mut ElasticWorkspace| Ok(forces.clone());
        (body.energies(level, 1, &given, &CancelToken::default()).unwrap()[0].energy, exact)
    });
    (found.map(|(energy, _)| energy), found[2].1)
}

/// Hollow sphere with the radii 0.25 and 0.5.
struct HollowSphere;

impl SignedDistance for HollowSphere {
    fn signed_distance(&self, point: &Point3<f64>) -> f64 {
        (point.coords.norm() - 0.375).abs() - 0.125
    }

    fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        (Point3::new(-0.5, -0.5, -0.5), Point3::new(0.5, 0.5, 0.5))
    }
}

fn quadratic(lattice: &Lattice, poisson: f64, count: usize) -> RefinedBody {
    refined(lattice, poisson, count).of_order(ElementOrder::Quadratic).unwrap()
}

fn turned(lattice: &Lattice, turn: Rotation3<f64>) -> Lattice {
    lattice.transformed(&Isometry3::from_parts(Default::default(), turn.into()))
}

fn hollow_sphere(spacing: f64) -> Lattice {
    stuff(&HollowSphere, spacing, None, &CancelToken::default()).unwrap().bodies.remove(0)
}

/// Extrapolated energy with the bar of the accuracy study: levels may agree better than they are solved.
fn extrapolated(body: &RefinedBody, values: [f64; 3]) -> Extrapolation {
    let found = Extrapolation::new(values, STUDY);
    found.widened(body.accuracy() * found.value)
}

/// Energies that quadratic elements have exactly, and energies that they do not have, in three orientations.
#[test]
fn known_energies_lie_within_the_bars_with_quadratic_elements() {
    let (mut stream, mut inside, mut count) = (RandomStream::new(17, 0), 0, 0);
    let mut check = |body: &RefinedBody, what: &str, field: &Field<'_>| {
        let (values, exact) = energies(body, field);
        let (found, errors) = (extrapolated(body, values), values.map(|value| 1.0 - value / exact));
        let [error, bar] = found.error(exact);
        println!("{what}: {:.1e} {:.1e} {:.1e}, {error:.1e} ± {bar:.1e}", errors[0], errors[1], errors[2]);
        (inside, count) = (inside + usize::from(error <= bar), count + 1);
    };
    let mut half_ball = ball(2);
    half_ball.nodes.iter_mut().for_each(|node| node.coords *= 0.5);
    let lattices = [perturbed([3, 2, 1], 0.25, 0.15, 3), kuhn([4, 2, 2], 0.25), half_ball];
    for (shape, lattice) in lattices.iter().enumerate() {
        let turns = [[0.0; 3], [0.4, 1.1, -0.7], [-1.3, 0.5, 0.25]];
        for (turn, poisson) in turns.into_iter().zip([0.0, 0.2, 0.3]) {
            let turn = Rotation3::from_euler_angles(turn[0], turn[1], turn[2]);
            let body = quadratic(&turned(lattice, turn), poisson, 2);
            for degree in [2, 3, 5] {
                let own = Polynomial::random(&mut stream, degree, poisson);
                check(&body, &format!("shape {shape}, degree {degree}"), &|place| own.at(place));
            }
            check(&body, &format!("shape {shape}, bending"), &|place| bending(place, &turn, poisson));
        }
    }
    let body = quadratic(&hollow_sphere(0.24), 0.3, 2);
    check(&body, "hollow sphere", &|place| lame(place, 0.3));
    println!("{inside} of {count} inside their bars");
    assert!(count >= 37 && inside * 100 >= 95 * count, "{inside} of {count}");
}

/// Displacements of degree three on a cube. With 16 cells across, instead of 32, the order is still 3.8.
#[test]
fn orders_are_those_of_the_theory_with_quadratic_elements() {
    let (mut stream, poisson) = (RandomStream::new(17, 5), 0.3);
    let body = quadratic(&kuhn([1, 1, 1], 0.5), poisson, 5).with_accuracy(1e-9);
    let own = Polynomial::random(&mut stream, 3, poisson);
    let (mut values, mut exact) = ([0.0; 3], 0.0);
    for (value, level) in values.iter_mut().zip(3..) {
        let (forces, known) = tractions(&body, level, &|place| own.at(place));
        let given = |_: usize, _: &mut ElasticWorkspace| Ok(forces.clone());
        *value = body.energies(level, 1, &given, &CancelToken::default()).unwrap()[0].energy;
        exact = known;
    }
    check_order("degree three", &values, exact, THEORY);
}

/// The order of the errors on the two finest levels.
#[test]
fn the_order_on_a_hollow_sphere_is_near_that_of_the_theory() {
    let body = quadratic(&hollow_sphere(0.24), 0.0, 2);
    let (values, exact) = energies(&body, &|place| lame(place, 0.0));
    let [_, middle, fine] = values.map(|value| 1.0 - value / exact);
    let order = (middle / fine).log2();
    println!("order {order:.3}: {middle:.2e}, {fine:.2e}");
    assert!((order - THEORY).abs() < 0.2, "{order}");
}

/// Contacts of about one spacing, against references of one more level.
#[test]
fn extrapolated_impacts_lie_within_their_bars_with_quadratic_elements() {
    let (mut inside, mut count, mut stream) = (0, 0, RandomStream::new(7, 0));
    for (lattice, radius) in [(perturbed([2, 2, 1], 0.1, 0.1, 2), 0.09), (perturbed([5, 1, 1], 0.1, 0.1, 3), 0.12)] {
        let half = lattice.nodes.iter().fold(Vector3::zeros(), |most: Vector3<f64>, node| most.sup(&node.coords));
        let impact = |_| {
            let [x, y] = [(); 2].map(|()| 1.6 * stream.uniform() - 0.8);
            let point = Point3::new(x * half.x, y * half.y, half.z);
            vec![ContactLoad { point, impulse: Vector3::new(0.2, -0.1, -1.0), radius }]
        };
        let impacts: Vec<Vec<ContactLoad>> = (0..8).map(impact).collect();
        let [low, high] = [2, 3].map(|count| {
            let body = quadratic(&lattice, 0.2, count);
            let level = |level| body.impact_energies(level, &impacts, &CancelToken::default()).unwrap();
            let levels: Vec<Vec<RefinedEnergy>> = (count - 2..=count).map(level).collect();
            let bars = body.load_errors(&impacts, &levels[1], &CancelToken::default()).unwrap();
            let found = |index: usize| {
                let values = [0, 1, 2].map(|level: usize| levels[level][index].energy);
                extrapolated(&body, values).widened(bars[index])
            };
            (0..impacts.len()).map(found).collect::<Vec<_>>()
        });
        for (low, high) in low.into_iter().zip(high) {
            println!("{:.6} ± {:.1e}; {:.6} ± {:.1e}", low.value, low.bar, high.value, high.bar);
            (inside, count) = (inside + usize::from((low.value - high.value).abs() <= low.bar), count + 1);
        }
    }
    println!("{inside} of {count} inside their bars");
    assert!(inside * 100 >= 95 * count, "{inside} of {count}");
}
