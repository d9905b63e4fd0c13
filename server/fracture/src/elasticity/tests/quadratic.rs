//! Quadratic elements: patch test, rigid motions, exact bending, observed order, loads, anchors, determinism.

use super::*;
use crate::elasticity::quadratic::SOLVED;
use crate::lattice::EDGES;
use crate::sparse::Precision;

/// Points and weights of a rule that integrates polynomials of degree 5 over triangles (Hammer, Marlowe & Stroud 1956).
fn triangle_rule() -> Vec<([f64; 3], f64)> {
    let root = 15.0_f64.sqrt();
    let mut rule = vec![([1.0 / 3.0; 3], 9.0 / 40.0)];
    for sign in [-1.0, 1.0] {
        let (a, weight) = ((6.0 + sign * root) / 21.0, (155.0 + sign * root) / 1200.0);
        let b = 1.0 - 2.0 * a;
        rule.extend([([b, a, a], weight), ([a, b, a], weight), ([a, a, b], weight)]);
    }
    rule
}

/// Forces of the traction σ(x) n on the boundary of a body of quadratic elements, for stresses up to cubic ones.
pub(super) fn tractions(
    body: &Elasticity,
    lattice: &Lattice,
    stress: impl Fn(Point3<f64>) -> Matrix3<f64>,
) -> Vec<f64> {
    let (edges, size) = (body.edges.as_ref().unwrap(), body.size());
    let mut forces = vec![0.0; body.unknowns()];
    for (face, own) in lattice.boundary().iter().enumerate() {
        let corners = own.nodes.map(|node| lattice.nodes[node as usize]);
        let area = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])) * 0.5;
        for (l, weight) in triangle_rule() {
            let place = Point3::from((0..3).map(|k| corners[k].coords * l[k]).sum::<Vector3<f64>>());
            let force = stress(place) * area * weight;
            for k in 0..3 {
                let places = [
                    (3 * own.nodes[k] as usize, l[k]),
                    (size + 3 * edges.faces[face][k] as usize, 4.0 * l[(k + 1) % 3] * l[(k + 2) % 3]),
                ];
                for (first, share) in places {
                    (0..3).for_each(|axis| forces[first + axis] += share * force[axis]);
                }
            }
        }
    }
    forces
}

fn quadratic(lattice: &Lattice, poisson: f64) -> Elasticity {
    free(lattice, poisson).of_order(ElementOrder::Quadratic, lattice).unwrap()
}

/// Displacement under `forces`, to rounding.
fn solve_exactly(body: &Elasticity, forces: &[f64]) -> Vec<f64> {
    let (mut displacement, token) = (forces.to_vec(), CancelToken::default());
    let edges = body.edges.as_ref().unwrap();
    body.iterate(edges, &mut displacement, 0.0, &mut ElasticWorkspace::default(), &token).unwrap();
    displacement
}

fn total(body: &Elasticity, lattice: &Lattice, forces: &[f64]) -> f64 {
    let displacement = solve_exactly(body, forces);
    let mut energies = Vec::new();
    body.tet_energy(lattice, &displacement, DrivingEnergy::Total, &mut energies, &CancelToken::default()).unwrap();
    energies.iter().sum()
}

#[test]
fn constant_stress_is_exact_in_every_tetrahedron() {
    let (lattice, poisson) = (perturbed([3, 2, 3], 0.5, 0.1, 3), 0.3);
    let body = quadratic(&lattice, poisson);
    for (row, column) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
        let mut stress = Matrix3::zeros();
        (stress[(row, column)], stress[(column, row)]) = (1.0, 1.0);
        let strain = stress * (1.0 + poisson) - Matrix3::from_diagonal_element(poisson * stress.trace());
        let displacement = solve_exactly(&body, &tractions(&body, &lattice, |_| stress));
        for (driving, share) in
            [(DrivingEnergy::Total, 1.0), (DrivingEnergy::Tensile, if row == column { 0.0 } else { 0.5 })]
        {
            let mut energies = Vec::new();
            body.tet_energy(&lattice, &displacement, driving, &mut energies, &CancelToken::default()).unwrap();
            let exact = |tet: usize| share * 0.5 * stress.dot(&strain) * lattice.tet_volume(tet);
            let worst =
                energies.iter().enumerate().map(|(tet, own)| (own / exact(tet) - 1.0).abs()).fold(0.0, f64::max);
            assert!(share == 0.0 || worst < 1e-3, "{worst:e} for {row}, {column}");
        }
    }
}

#[test]
fn rigid_motions_are_free_of_force() {
    let lattice = perturbed([3, 2, 2], 0.5, 0.1, 4);
    let body = quadratic(&lattice, 0.3);
    let edges = body.edges.as_ref().unwrap();
    let mut forces = vec![0.0; body.unknowns()];
    let mut stream = RandomStream::new(2, 0);
    let mut motion: Vec<f64> = (0..body.unknowns()).map(|_| stream.uniform() - 0.5).collect();
    edges.multiply(body.lame, &body.elements, &motion, &mut forces);
    let usual = forces.iter().map(|f| f.abs()).fold(0.0, f64::max);
    for axis in 0..6 {
        let unit = Vector3::ith(axis % 3, 1.0);
        motion.fill(0.0);
        for (own, place) in motion.chunks_exact_mut(3).zip(&lattice.nodes) {
            own.copy_from_slice(if axis < 3 { unit } else { unit.cross(&place.coords) }.as_slice());
        }
        edges.multiply(body.lame, &body.elements, &motion, &mut forces);
        let greatest = forces.iter().map(|f| f.abs()).fold(0.0, f64::max);
        assert!(greatest < 1e-13 * usual, "{greatest:e} of {usual:e}");
    }
}

/// K u by finite differences of the energy, which the kernel of the energies computes.
#[test]
fn products_are_derivatives_of_the_energy() {
    let lattice = perturbed([1, 2, 1], 0.5, 0.0, 4);
    let body = quadratic(&lattice, 0.2);
    let mut stream = RandomStream::new(3, 0);
    let mut motion: Vec<f64> = (0..body.unknowns()).map(|_| stream.uniform() - 0.5).collect();
    let mut forces = vec![0.0; body.unknowns()];
    body.edges.as_ref().unwrap().multiply(body.lame, &body.elements, &motion, &mut forces);
    let energy = |motion: &[f64]| {
        let mut energies = Vec::new();
        body.tet_energy(&lattice, motion, DrivingEnergy::Total, &mut energies, &CancelToken::default()).unwrap();
        energies.iter().sum::<f64>()
    };
    for unknown in (0..body.unknowns()).step_by(7) {
        let [above, below] = [1.0, -1.0].map(|step| {
            motion[unknown] += step;
            let value = energy(&motion);
            motion[unknown] -= step;
            value
        });
        assert!((0.5 * (above - below) - forces[unknown]).abs() < 1e-10, "{unknown}");
    }
}

#[test]
fn bending_is_exact_with_one_cell_across() {
    let lattice = block([12, 2, 1], 0.5);
    let forces =
        |body: &Elasticity| tractions(body, &lattice, |x| Matrix3::from_diagonal(&Vector3::new(x.z, 0.0, 0.0)));
    let exact = 0.5 * 6.0 * 1.0 * 0.5_f64.powi(3) / 12.0;
    let body = quadratic(&lattice, 0.3);
    let quadratic = total(&body, &lattice, &forces(&body)) / exact;
    let linear = 1.0 - bending_error(&lattice, 0.3).unwrap();
    println!("pure bending, one cell across: quadratic {quadratic:.6}, linear {linear:.3} of the exact energy");
    assert!((quadratic - 1.0).abs() < 1e-5 && linear < 0.8);
}

/// A beam whose moment varies: σ_xx = x z, σ_xz = (c² − z²)/2. Its displacement is cubic, so energies converge with order
/// four.
#[test]
fn energies_converge_with_order_four() {
    let stress = |x: Point3<f64>| {
        let mut stress = Matrix3::zeros();
        (stress[(0, 0)], stress[(0, 2)]) = (x.x * x.z, 0.5 * (0.25 - x.z * x.z));
        stress[(2, 0)] = stress[(0, 2)];
        stress
    };
    // ½ ∫ (σ_xx² + 2 σ_xz²) over 2 × 1 × 1. Only with ν = 0 is the strain compatible.
    let exact = 0.5 * (2.0 / 3.0 / 12.0 + 2.0 * 2.0 / 120.0);
    let errors = [1, 2, 4].map(|fine| {
        let lattice = block([2 * fine, fine, fine], 1.0 / fine as f64);
        let body = quadratic(&lattice, 0.0);
        1.0 - total(&body, &lattice, &tractions(&body, &lattice, stress)) / exact
    });
    let orders = [(errors[0] / errors[1]).log2(), (errors[1] / errors[2]).log2()];
    println!("errors {errors:?}, orders {orders:?}");
    assert!(errors.iter().all(|error| *error > 0.0) && (3.5..4.3).contains(&orders[1]), "{orders:?}, {errors:?}");
}

/// Applied forces, their inertia and the weight agree with the integrals over the elements.
#[test]
fn loads_on_edges_are_consistent() {
    let lattice = perturbed([4, 3, 2], 0.25, 0.1, 5);
    let body = quadratic(&lattice, 0.25);
    // Uniform pressure through the contacts' path: forces of area times traction on every boundary node.
    let (boundary, mut forces) = (&body.boundary, vec![0.0; body.unknowns()]);
    let pull = Vector3::new(0.3, -0.2, 1.0);
    let applied: Vec<_> =
        boundary.nodes.iter().zip(&boundary.areas).map(|(node, area)| (*node, pull * *area)).collect();
    let size = body.size();
    body.edges.as_ref().unwrap().add_applied(boundary, &applied, &mut forces[size..]);
    // A traction of this kind is that of one stress on each face.
    let mut wanted = vec![0.0; body.unknowns()];
    for (face, own) in lattice.boundary().iter().enumerate() {
        let [a, b, c] = own.nodes.map(|node| lattice.nodes[node as usize]);
        let area = 0.5 * (b - a).cross(&(c - a)).norm();
        for edge in body.edges.as_ref().unwrap().faces[face] {
            (0..3).for_each(|axis| wanted[size + 3 * edge as usize + axis] += pull[axis] * area / 3.0);
        }
    }
    assert!(difference(&forces, &wanted) < 1e-13);
    // The weight does the work of a uniform acceleration on b_e and on all of the functions.
    let weight = body.weight(&Vector3::x());
    let [nodes, edges] = [&weight[..size], &weight[size..]].map(|part| part.iter().sum::<f64>());
    let whole: f64 = (0..lattice.tets.len()).map(|tet| EDGES.len() as f64 * lattice.tet_volume(tet) / 5.0).sum();
    assert!((nodes / lattice.volume() - 1.0).abs() < 1e-12 && (edges / whole - 1.0).abs() < 1e-12);
    // A body that is accelerated by its own weight is not deformed.
    let mut fall = weight.clone();
    body.relieve(&mut fall);
    assert!(fall.iter().all(|force| force.abs() < 1e-14), "free fall");
}

/// A bar that hangs by its weight: σ = x, U = A L³ / 6, exact for quadratic elements with ν = 0.
#[test]
fn an_anchored_bar_hangs_exactly() {
    let lattice = block([8, 2, 2], 0.125);
    let end = (0..lattice.nodes.len() as u32).filter(|&node| lattice.nodes[node as usize].x < -0.499).collect();
    let token = CancelToken::default();
    let body =
        Elasticity::assembled(&lattice, 0.0, &token).unwrap().of_order(ElementOrder::Quadratic, &lattice).unwrap();
    let body = body.anchored(end, &token).unwrap();
    let energy = total(&body, &lattice, &body.weight(&Vector3::x()));
    assert!((energy / (0.0625 / 6.0) - 1.0).abs() < 1e-5, "{energy}");
}

/// A solve ends as soon as little energy is missing, for each of several right-hand sides.
#[test]
fn solves_miss_little_energy() {
    let lattice = perturbed([30, 4, 1], 0.05, 0.1, 5);
    let body = quadratic(&lattice, 0.3);
    let places = [Point3::new(0.7, 0.05, 0.025), Point3::new(0.0, 0.0, -0.025), Point3::new(-0.2, 0.1, 0.0)];
    let forces = places
        .map(|point| load(&body, &[ContactLoad { point, impulse: Vector3::new(0.3, 0.1, -1.0), radius: 0.1 }]).forces);
    let (mut columns, token) = (forces.concat(), CancelToken::default());
    let edges = body.edges.as_ref().unwrap();
    body.iterate(edges, &mut columns, SOLVED, &mut ElasticWorkspace::default(), &token).unwrap();
    for (forces, column) in forces.iter().zip(columns.chunks_exact(body.unknowns())) {
        let mut displacement = Vec::new();
        let report = body.solve(forces, &mut displacement, &mut ElasticWorkspace::default(), &token).unwrap();
        let exact = body.elastic_energy(forces, &solve_exactly(&body, forces));
        let [alone, together] = [&displacement, column].map(|found| 1.0 - body.elastic_energy(forces, found) / exact);
        println!("{} steps leave {alone:.1e} of the energy, {together:.1e} in a block", report.sweeps);
        assert!((-1e-10..SOLVED).contains(&alone) && (-1e-10..SOLVED).contains(&together), "{alone} {together}");
        assert!(report.sweeps < 25, "{report:?}");
    }
}

#[test]
fn solutions_have_the_same_bits_on_any_number_of_threads() {
    let lattice = perturbed([5, 4, 1], 0.25, 0.1, 5);
    let contact =
        ContactLoad { point: Point3::new(0.3, 0.1, 0.125), impulse: Vector3::new(0.1, 0.0, -1.0), radius: 0.3 };
    let solved = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let body = quadratic(&lattice, 0.3);
            let displacement = solve(&body, &load(&body, &[contact]).forces);
            let mut energies = Vec::new();
            let token = CancelToken::default();
            body.tet_energy(&lattice, &displacement, DrivingEnergy::Tensile, &mut energies, &token).unwrap();
            (displacement, energies)
        })
    };
    assert_eq!(solved(1), solved(3));
}

#[test]
fn a_narrow_factor_leads_to_the_same_energy() {
    let lattice = block([20, 3, 1], 0.05);
    let contact = ContactLoad { point: Point3::new(0.4, 0.0, 0.025), impulse: -Vector3::z(), radius: 0.1 };
    let [wide, narrow] = [Precision::F64, Precision::F32].map(|precision| {
        let body = Elasticity::assembled(&lattice, 0.3, &CancelToken::default()).unwrap().of_precision(precision);
        let body = body.of_order(ElementOrder::Quadratic, &lattice).unwrap();
        total(&body, &lattice, &load(&body, &[contact]).forces)
    });
    assert!((wide / narrow - 1.0).abs() < 1e-5, "{wide} and {narrow}");
}

#[test]
fn wide_instructions_do_not_change_a_bit_of_a_solution() {
    let lattice = perturbed([3, 1, 2], 0.5, 0.1, 3);
    let body = quadratic(&lattice, 0.3);
    let bending = |place: Point3<f64>| Matrix3::from_diagonal(&Vector3::new(place.z, 0.0, 0.0));
    let forces = tractions(&body, &lattice, bending);
    for driving in [DrivingEnergy::Total, DrivingEnergy::Tensile] {
        let energies = crate::simd::tests::same_on_every_path(|| {
            let (displacement, mut energies) = (solve(&body, &forces), Vec::new());
            body.tet_energy(&lattice, &displacement, driving, &mut energies, &CancelToken::default()).unwrap();
            energies
        });
        assert!(energies.iter().sum::<f64>() > 0.0);
    }
}
