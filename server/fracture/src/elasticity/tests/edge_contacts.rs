//! Tests of contacts near edges and on thin walls: line of the force, side of the wall, energy, exact symmetries.

use super::*;
use crate::elasticity::load_front::LoadFront;
use crate::lattice::{SignedDistance, stuff};
use proptest::prelude::*;
use std::sync::LazyLock;

/// Ellipsoid of half-axes 0.5, 0.3 and 0.2.
struct Ellipsoid;

const HALF_AXES: Vector3<f64> = Vector3::new(0.5, 0.3, 0.2);

impl SignedDistance for Ellipsoid {
    fn signed_distance(&self, point: &Point3<f64>) -> f64 {
        (point.coords.component_div(&HALF_AXES).norm() - 1.0) * HALF_AXES.min()
    }

    fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        (Point3::from(-HALF_AXES), Point3::from(HALF_AXES))
    }
}

fn contact(point: Point3<f64>, impulse: [f64; 3], radius: f64) -> ContactLoad {
    ContactLoad { point, impulse: Vector3::from(impulse), radius }
}

fn plate() -> Lattice {
    block([16, 16, 1], 0.0625)
}

/// Block, carved block, thin plate, block with displaced nodes, and an ellipsoid as it is baked.
static BODIES: LazyLock<Vec<(&str, Elasticity)>> = LazyLock::new(|| {
    let carved = carve(&block([6, 6, 5], 0.16), |place| place.x < 0.0 || place.y < 0.0 || place.z < -0.2);
    let ellipsoid = stuff(&Ellipsoid, 0.08, None, &CancelToken::default()).unwrap().bodies.remove(0);
    let lattices = [
        ("block", block([5; 3], 0.2)),
        ("carved block", carved),
        ("plate", plate()),
        ("perturbed block", perturbed([5, 4, 4], 0.2, 0.12, 7)),
        ("ellipsoid", ellipsoid),
    ];
    lattices.map(|(name, lattice)| (name, free(&lattice, 0.25))).into()
});

/// A point of the boundary: on a face, on an edge of one, or in a corner, by `weights`.
fn boundary_point(body: &Elasticity, face: usize, weights: [f64; 3]) -> Point3<f64> {
    // Faces of the lattice with nodes on sharp edges reach these with a weight of zero.
    let weights = weights.map(|weight| (weight - 0.5).max(0.0) + 1e-300);
    let corners = body.boundary.corners(face % body.boundary.faces.len());
    let total: f64 = weights.iter().sum();
    Point3::from(
        corners.iter().zip(weights).map(|(corner, weight)| corner.coords * (weight / total)).sum::<Vector3<f64>>(),
    )
}

/// Net force less that of the contact, and moment about its place over the radius, both over the force.
fn errors(body: &Elasticity, lattice_nodes: impl Fn(u32) -> Point3<f64>, contact: &ContactLoad) -> [f64; 2] {
    let load = load(body, &[*contact]);
    let touch = load.touches[0];
    let (mut force, mut moment) = (-contact.impulse, Vector3::zeros());
    for (node, own) in &load.applied {
        force += own;
        moment += (lattice_nodes(*node) - touch.place).cross(own);
    }
    [force.norm(), moment.norm() / touch.radius].map(|error| error / contact.impulse.norm())
}

/// Position of a lattice node on the boundary.
fn place_of(body: &Elasticity) -> impl Fn(u32) -> Point3<f64> {
    |node| body.boundary.positions[body.boundary.nodes.binary_search(&node).unwrap()]
}

/// Share of `forces` on nodes that pass, by magnitude.
fn share(body: &Elasticity, forces: &[(u32, Vector3<f64>)], passes: impl Fn(Point3<f64>) -> bool) -> f64 {
    let place = place_of(body);
    let on = forces.iter().filter(|(node, _)| passes(place(*node))).map(|(_, force)| force.norm()).sum::<f64>();
    on / forces.iter().map(|(_, force)| force.norm()).sum::<f64>()
}

/// Forces without the couple and on all faces along the boundary.
fn uncorrected(body: &Elasticity, contact: &ContactLoad) -> Vec<(u32, Vector3<f64>)> {
    let (boundary, radius) = (&body.boundary, contact.radius.max(RADIUS_SPACINGS_MIN * body.spacing()));
    let nearest = boundary.nearest(&contact.point).unwrap();
    let mut front = LoadFront::default();
    let reached = front.run(boundary, &nearest, 3.0 * radius);
    let weight = |&(node, distance): &(u32, f64)| {
        let bell = (-0.5 * (distance / radius).powi(2)).exp() - (-4.5_f64).exp();
        (boundary.nodes[node as usize], boundary.areas[node as usize] * bell.max(0.0))
    };
    let weights: Vec<_> = reached.iter().map(weight).collect();
    let total: f64 = weights.iter().map(|(_, weight)| weight).sum();
    weights.into_iter().map(|(node, weight)| (node, contact.impulse * (weight / total))).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn a_contact_keeps_the_line_of_its_force(
        body in 0..5_usize,
        face in 0..100_000_usize,
        weights in prop::array::uniform3(0.0..1.0_f64),
        impulse in prop::array::uniform3(-1.0..1.0_f64),
        radius in 0.001..0.3_f64,
    ) {
        let (name, body) = &BODIES[body];
        let contact = contact(boundary_point(body, face, weights), impulse, radius);
        let [force, moment] = errors(body, place_of(body), &contact);
        prop_assert!(force < 1e-12 && moment < 1e-10, "{name}: force {force:e}, moment {moment:e}");
        // No face of these lattices needs a larger radius than the spacing.
        let radius = radius.max(RADIUS_SPACINGS_MIN * body.spacing());
        prop_assert_eq!(load(body, &[contact]).touches[0].spread, radius);
    }
}

/// Quadratic elements add forces on functions of edges, which do no work in a rigid motion.
#[test]
fn a_contact_on_quadratic_elements_keeps_the_line_of_its_force() {
    let lattice = block([8, 8, 1], 0.1);
    let anchored = Support::Anchored(vec![0, 1, 2, 3]);
    let linear = Elasticity::supported(&lattice, 0.25, anchored, &CancelToken::default()).unwrap();
    let body = linear.of_order(ElementOrder::Quadratic, &lattice).unwrap();
    let contact = contact(Point3::new(0.4, 0.4, 0.05), [0.3, -0.2, -1.0], 0.15);
    let load = load(&body, &[contact]);
    assert!(load.forces[body.size()..].iter().any(|force| *force != 0.0));
    let mut motion = vec![0.0; body.unknowns()];
    for axis in 0..3 {
        for (own, place) in motion.chunks_exact_mut(3).zip(&lattice.nodes) {
            own.copy_from_slice(Vector3::ith(axis, 1.0).cross(&(place - load.touches[0].place)).as_slice());
        }
        let work: f64 = motion.iter().zip(&load.forces).map(|(motion, force)| motion * force).sum();
        assert!(work.abs() < 1e-14, "{axis}: {work:e}");
    }
}

#[test]
fn a_contact_on_a_thin_plate_loads_the_side_that_it_touches() {
    let body = &BODIES[2].1;
    let (half, thick, radius) = (0.5, 0.03125, 0.125);
    let is_far = |place: Point3<f64>| place.z < -0.99 * thick;
    let is_inside = move |place: Point3<f64>| place.x.abs().max(place.y.abs()) < 0.99 * half;
    for (name, from_rim, limit) in [("middle", 0.5, 0.0), ("1 r from the rim", radius, 0.03), ("rim", 0.0, 0.15)] {
        for impulse in [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.3, 0.5, -0.8]] {
            let contact = contact(Point3::new(half - from_rim, 0.013, thick), impulse, radius);
            let applied = load(body, &[contact]).applied;
            let far = share(body, &applied, is_far);
            let before = share(body, &uncorrected(body, &contact), is_far);
            println!("{name}, {impulse:?}: {:.2} % on the far side, {:.2} % before", 100.0 * far, 100.0 * before);
            assert!(far <= limit, "{name}: {far}");
            assert_eq!(share(body, &applied, |place| is_far(place) && is_inside(place)), 0.0, "{name}");
        }
    }
}

/// On the rim itself both sides are alike.
#[test]
fn a_contact_on_the_rim_of_a_plate_loads_both_sides_alike() {
    let body = &BODIES[2].1;
    let applied = load(body, &[contact(Point3::new(0.5, 0.0, 0.0), [-1.0, 0.0, 0.0], 0.125)]).applied;
    let sides = [-1.0, 1.0].map(|side| share(body, &applied, |place| place.z * side > 0.03));
    assert!((sides[0] - sides[1]).abs() < 1e-12 && sides[0] > 0.2, "{sides:?}");
}

#[test]
fn a_contact_keeps_its_forces_over_the_edge_of_a_block() {
    let body = &BODIES[0].1;
    let places = [[0.5 - 1e-9, 0.03, 0.5], [0.5, 0.03, 0.5 - 1e-9]];
    let [top, side] = places.map(|place| load(body, &[contact(Point3::from(place), [-0.5, 0.2, -1.0], 0.25)]).forces);
    assert!(difference(&top, &side) < 1e-6, "{:e}", difference(&top, &side));
}

/// The place is a node or an edge, so rounding decides which face is nearest.
#[test]
fn rounding_does_not_choose_the_faces_that_are_loaded() {
    let body = &BODIES[4].1;
    let middles = body.boundary.faces.iter().map(|own| {
        let [a, b] = [own[0], own[1]].map(|node| body.boundary.positions[node as usize]);
        nalgebra::center(&a, &b)
    });
    for place in body.boundary.positions.iter().copied().chain(middles).step_by(7) {
        let forces = |shift: Vector3<f64>| load(body, &[contact(place + shift, [-0.5, 0.2, -1.0], 0.15)]).forces;
        let expected = forces(Vector3::zeros());
        for axis in 0..3 {
            let error = difference(&expected, &forces(Vector3::ith(axis, 1e-10)));
            assert!(error < 1e-5, "{place}, {axis}: {error:e}");
        }
    }
}

/// A contact much wider than the body loads all of its surface evenly.
#[test]
fn a_contact_wider_than_the_body_loads_all_of_it() {
    let body = &BODIES[4].1;
    let load = load(body, &[contact(Point3::new(0.5, 0.0, 0.0), [1.0, 0.0, 0.0], 1e9)]);
    assert!(load.applied.len() == body.boundary.nodes.len() && load.applied.iter().all(|(_, force)| force.x > 0.0));
}

#[test]
fn far_from_edges_forces_are_those_of_the_bell() {
    let body = free(&block([12, 12, 6], 0.1), 0.25);
    for [x, y] in [[0.0, 0.0], [0.05, 0.05], [0.013, 0.031], [0.08, -0.02]] {
        for impulse in [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0]] {
            let contact = contact(Point3::new(x, y, 0.3), impulse, 0.15);
            let (now, bell) = (load(&body, &[contact]).applied, uncorrected(&body, &contact));
            let greatest = bell.iter().map(|(_, force)| force.norm()).fold(0.0, f64::max);
            let moved = now.iter().zip(&bell).map(|(a, b)| (a.1 - b.1).norm()).fold(0.0, f64::max) / greatest;
            assert!(now.len() == bell.len() && moved < 0.01, "{x}, {y}: {moved}");
        }
    }
}

#[test]
fn opposite_contacts_cancel_exactly_at_an_edge() {
    for (name, body) in BODIES.iter() {
        let place = body.boundary.positions[0];
        let pair = [[0.3, -0.7, 0.2], [-0.3, 0.7, -0.2]].map(|impulse| contact(place, impulse, 0.2));
        let load = load(body, &pair);
        assert!(!load.applied.is_empty() && load.applied.iter().all(|(_, force)| *force == Vector3::zeros()), "{name}");
        assert!(load.forces.iter().all(|force| *force == 0.0), "{name}");
    }
}

/// A reduced basis spans all contacts at a place by those along three axes.
#[test]
fn forces_are_linear_in_the_impulse() {
    for (name, body) in BODIES.iter() {
        let at = |impulse: [f64; 3]| load(body, &[contact(body.boundary.positions[0], impulse, 0.2)]).forces;
        let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(at);
        let sum: Vec<f64> = (0..x.len()).map(|i| 0.3 * x[i] - 0.7 * y[i] + 0.2 * z[i]).collect();
        let error = difference(&sum, &at([0.3, -0.7, 0.2]));
        assert!(error < 1e-13, "{name}: {error:e}");
    }
}

#[test]
fn forces_do_not_depend_on_the_unit_of_length_or_on_earlier_contacts() {
    let lattice = block([5; 3], 0.25);
    let mut larger = lattice.clone();
    larger.nodes.iter_mut().for_each(|place| *place *= 8.0);
    let [body, larger] = [&lattice, &larger].map(|lattice| free(lattice, 0.25));
    let own = contact(Point3::new(0.6, 0.625, 0.1), [0.3, -0.7, 0.2], 0.3);
    let scaled = ContactLoad { point: own.point * 8.0, radius: own.radius * 8.0, ..own };
    let expected = load(&body, &[own]).applied;
    assert_eq!(load(&larger, &[scaled]).applied, expected);
    let (mut load, mut workspace) = (NodalLoad::default(), ElasticWorkspace::default());
    for contact in [own, ContactLoad { point: -own.point, radius: 0.5, ..own }, own] {
        body.touch(&[contact], 0.0, &mut load, &mut workspace).unwrap();
    }
    assert_eq!(load.applied, expected);
}

/// Energy of a contact near an edge, against the same block with a third of the spacing.
#[test]
fn energies_near_an_edge_converge() {
    let bodies = [5, 15].map(|cells| (block([cells; 3], 1.0 / cells as f64), cells));
    let bodies = bodies.map(|(lattice, _)| (free(&lattice, 0.25), lattice));
    let radius = 1.5 * bodies[0].0.spacing();
    for (name, distance, limit) in
        [("edge", 0.0, 0.1), ("r/2 from it", 0.5 * radius, 0.08), ("r from it", radius, 0.05)]
    {
        for impulse in [[0.0, 0.0, -1.0], [-0.6, 0.3, -0.7]] {
            let contact = contact(Point3::new(0.5 - distance, 0.03, 0.5), impulse, radius);
            let [now, before] = [true, false].map(|is_now| {
                let energy = |(body, lattice): &(Elasticity, Lattice)| -> f64 {
                    let mut load = load(body, &[ContactLoad { radius, ..contact }]);
                    if !is_now {
                        load = NodalLoad { applied: uncorrected(body, &contact), ..NodalLoad::default() };
                        load.acceleration = body.inertia.acceleration_of(&load.applied);
                        body.balance(&mut load);
                    }
                    energies(body, lattice, &load.forces, DrivingEnergy::Total).iter().sum()
                };
                let [coarse, fine] = [energy(&bodies[0]), energy(&bodies[1])];
                (coarse / fine - 1.0, fine)
            });
            println!(
                "{name}, {impulse:?}: {:+.1} % (before {:+.1} %), energy {:.3} of that before",
                100.0 * now.0,
                100.0 * before.0,
                now.1 / before.1
            );
            assert!(now.0.abs() < limit, "{name}: {}", now.0);
        }
    }
}
