//! Near field of small contacts, against uniformly refined lattices.

use super::*;
use crate::BakeRequest;
use crate::database::{Tables, bake};
use crate::pipeline::{DisplacementMethod, ElementChoice, SurfaceKind};
use crate::scene::Material;
use crate::surface::shapes;
use std::sync::LazyLock;

/// Largest difference of energies, relative to that of the refined body.
const ERROR_MAX: f64 = 0.1;

const NU: f64 = 0.25;

/// Along the normal of the block's upper face, across it, and oblique.
const FORCES: [[f64; 3]; 3] = [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [-0.6, 0.3, -0.7]];

struct Body {
    body: Elasticity,
    refined: RefinedBody,
}

/// Energies of one impact.
struct Energies {
    /// Of the lattice and the near field.
    own: f64,
    /// Of the near field alone.
    near: f64,
    /// Radius whose energy it is, and that of the lattice's load, in spacings, of the first contact.
    radii: [f64; 2],
}

impl Body {
    fn new(lattice: &Lattice, body: Elasticity, poisson: f64, count: usize) -> Self {
        Self { body, refined: RefinedBody::new(lattice, poisson, count, &CancelToken::default()).unwrap() }
    }

    fn energies(&self, contacts: &[ContactLoad]) -> Energies {
        let load = load(&self.body, contacts);
        let lattice = self.body.elastic_energy(&load.forces, &solve(&self.body, &load.forces));
        let near = load.near_energy();
        let touch = &load.touches[0];
        let radii = [touch.radius, touch.spread].map(|radius| radius / self.body.spacing());
        Energies { own: lattice + near, near, radii }
    }

    /// Energies of impacts on the finest lattice.
    fn fine(&self, impacts: &[Vec<ContactLoad>]) -> Vec<f64> {
        let found = self.refined.impact_energies(self.refined.count(), impacts, &CancelToken::default()).unwrap();
        found.into_iter().map(|own| own.energy).collect()
    }

    /// Errors of the near fields of single contacts over the energy: against what the refined body has more under the effective
    /// radius than under that of the lattice's load. Those of the lattice itself do not count.
    fn near_errors(&self, contacts: &[ContactLoad]) -> Vec<(Energies, f64)> {
        let spacing = self.body.spacing();
        let own: Vec<Energies> = contacts.iter().map(|contact| self.energies(&[*contact])).collect();
        let [told, spread] = [0, 1].map(|kind| {
            let with = |(contact, own): (&ContactLoad, &Energies)| {
                vec![ContactLoad { radius: own.radii[kind] * spacing, ..*contact }]
            };
            self.fine(&contacts.iter().zip(&own).map(with).collect::<Vec<_>>())
        });
        let error = |((own, told), spread): ((Energies, &f64), &f64)| {
            let error = (own.near - (told - spread)) / told;
            println!("radii {:.2?}, near field {:.3}: {:+.1} %", own.radii, own.near / told, 100.0 * error);
            (own, error)
        };
        own.into_iter().zip(&told).zip(&spread).map(error).collect()
    }
}

/// Block of 5 cells along each side, refined three times.
static BLOCK: LazyLock<Body> = LazyLock::new(|| {
    let lattice = block([5; 3], 0.2);
    Body::new(&lattice, free(&lattice, NU), NU, 3)
});

fn contact(point: [f64; 3], impulse: [f64; 3], radius: f64) -> ContactLoad {
    ContactLoad { point: Point3::from(point), impulse: Vector3::from(impulse), radius }
}

/// Checks whole energies inside a face of the block.
fn check_inside(cases: &[([f64; 2], usize, f64)]) {
    let spacing = BLOCK.body.spacing();
    let of =
        |&([x, y], force, factor): &([f64; 2], usize, f64)| vec![contact([x, y, 0.5], FORCES[force], factor * spacing)];
    let impacts: Vec<Vec<ContactLoad>> = cases.iter().map(of).collect();
    for ((impact, fine), case) in impacts.iter().zip(BLOCK.fine(&impacts)).zip(cases) {
        let own = BLOCK.energies(impact);
        let [error, lattice] = [own.own, own.own - own.near].map(|energy| energy / fine - 1.0);
        println!("{case:?}: {:+.1} %, without {:+.1} %", 100.0 * error, 100.0 * lattice);
        assert!((own.radii[0] - case.2).abs() < 1e-12, "told {:?}", own.radii);
        assert!(error.abs() < ERROR_MAX && lattice < -0.25, "{case:?}: {error}, without {lattice}");
    }
}

#[test]
fn quarters_of_a_spacing_inside_a_face_have_their_energy() {
    check_inside(&[([0.0, 0.0], 0, 0.25), ([0.08, -0.03], 1, 0.25), ([0.1, 0.1], 2, 0.25), ([0.02, 0.01], 0, 0.25)]);
}

#[test]
fn larger_parts_of_a_spacing_inside_a_face_have_their_energy() {
    check_inside(&[([0.0, 0.0], 0, 0.5), ([0.08, -0.03], 1, 0.5), ([0.1, 0.1], 2, 0.75), ([0.02, 0.01], 1, 0.75)]);
}

#[test]
fn contacts_closer_than_their_radii_act_together() {
    let spacing = BLOCK.body.spacing();
    let pairs = [[FORCES[0], FORCES[0]], [FORCES[0], [0.0, 0.0, 1.0]], [FORCES[1], FORCES[0]], [FORCES[1], FORCES[1]]];
    let (half, radius) = (0.2 * spacing, 0.5 * spacing);
    let of = |[first, second]: [[f64; 3]; 2]| {
        vec![contact([0.02 - half, 0.01, 0.5], first, radius), contact([0.02 + half, 0.01, 0.5], second, radius)]
    };
    let impacts = pairs.map(of);
    for ((impact, fine), pair) in impacts.iter().zip(BLOCK.fine(&impacts)).zip(pairs) {
        let own = BLOCK.energies(impact);
        let [error, lattice] = [own.own, own.own - own.near].map(|energy| energy / fine - 1.0);
        println!("{pair:?}: {:+.1} %, without {:+.1} %", 100.0 * error, 100.0 * lattice);
        assert!(error.abs() < ERROR_MAX && lattice < -0.5, "{pair:?}: {error}, without {lattice}");
    }
    // Opposite forces at one place have no energy.
    let opposite = [impacts[0][0], ContactLoad { impulse: -impacts[0][0].impulse, ..impacts[0][0] }];
    assert_eq!(BLOCK.energies(&opposite).near, 0.0);
}

/// At an edge the body is no half-space: the effective radius is that whose energy is computed.
#[test]
fn next_to_an_edge_the_effective_radius_is_that_of_the_energy() {
    let lattice = block([5; 3], 0.2);
    let edge = Body::new(&lattice, free(&lattice, NU), NU, 2);
    let spacing = edge.body.spacing();
    let places = [0.0, 0.5, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5];
    let at = |from: &f64| contact([0.5 - from * spacing, 0.03, 0.5], FORCES[0], 0.5 * spacing);
    let contacts: Vec<ContactLoad> = places.iter().map(at).collect();
    let found = edge.near_errors(&contacts);
    let mut last = f64::INFINITY;
    for (from, (own, error)) in places.iter().zip(&found) {
        let told = own.radii[0];
        assert!((0.5..=1.0 + 1e-12).contains(&told) && told <= last + 1e-12, "{from}: {told}");
        assert!(error.abs() < ERROR_MAX, "{from}: {error}");
        last = told;
    }
    assert!((found[0].0.radii[0] - 1.0).abs() < 1e-12 && (last - 0.5).abs() < 1e-12);
}

#[test]
fn energies_are_continuous_in_the_radius_and_in_the_place() {
    let spacing = BLOCK.body.spacing();
    let energy = |x: f64, factor: f64| BLOCK.energies(&[contact([x, 0.03, 0.5], FORCES[2], factor * spacing)]).own;
    for x in [0.0, 0.28, 0.5] {
        let [below, above] = [1.0 - 1e-7, 1.0 + 1e-7].map(|factor| energy(x, factor));
        assert!((below / above - 1.0).abs() < 1e-5, "{x}: {below} and {above}");
    }
    // From where the whole correction applies to where there is none, in steps of a hundredth of a spacing.
    let steps = (0..150).map(|step| 0.2 + 0.01 * spacing * f64::from(step));
    let energies: Vec<f64> = steps.map(|x| energy(x, 0.25)).collect();
    let jump = energies.windows(2).map(|two| (two[1] / two[0] - 1.0).abs()).fold(0.0, f64::max);
    println!("largest step {:.2} %", 100.0 * jump);
    assert!(jump < 0.1, "{jump}");
}

#[test]
fn on_walls_of_one_and_two_cells_the_effective_radius_is_that_of_the_energy() {
    for (cells, whole) in [(1, false), (2, true)] {
        let lattice = block([8, 8, cells], 0.125);
        let wall = Body::new(&lattice, free(&lattice, NU), NU, 2);
        let z = 0.0625 * cells as f64;
        let at = |force: [f64; 3]| contact([0.03, 0.01, z], force, 0.5 * wall.body.spacing());
        for (own, error) in wall.near_errors(&FORCES.map(at)) {
            assert_eq!(own.radii[0] < 0.5 + 1e-12, whole, "{cells} cells: {:?}", own.radii);
            assert!(error.abs() < ERROR_MAX, "{cells} cells, {:?}: {error}", own.radii);
        }
    }
}

/// A curved wall of nearly two cells, on linear elements and on quadratic ones, which thin walls have by default.
#[test]
fn small_contacts_on_a_mug_have_their_energy() {
    let tables = Tables { elastic: true, ..Tables::NONE };
    let request = BakeRequest::new("mug", "glass", Material::named("glass").unwrap());
    let (elements, elastic_spacing, surface) = (ElementChoice::Quadratic, Some(0.025), SurfaceKind::Lattice);
    let elastic = DisplacementMethod::Solve;
    let request = BakeRequest { tables, elements, elastic_spacing, elastic, surface, ..request };
    let mut prepared = bake(shapes::mug(), &request, &CancelToken::default(), &mut |_| ()).unwrap();
    let solid = prepared.bodies[0].solid.take().unwrap();
    let poisson = prepared.parameters.material.poisson;
    assert_eq!(solid.elasticity.order(), ElementOrder::Quadratic);
    let mut mug = Body::new(&solid.lattice, solid.elasticity, poisson, 1);
    // Outside of the wall, opposite to the handle.
    let point = prepared.frame.to_local(&Point3::new(-0.04, 0.05, 0.0));
    for is_linear in [false, true] {
        if is_linear {
            mug.body = free(&solid.lattice, poisson);
        }
        let spacing = mug.body.spacing();
        let at = |factor: f64| {
            [Vector3::x(), Vector3::y()].map(|impulse| ContactLoad { point, impulse, radius: factor * spacing })
        };
        let found = mug.near_errors(&[0.5, 0.75].map(at).concat());
        for ((own, error), asked) in found.iter().zip([0.5, 0.5, 0.75, 0.75]) {
            assert!((own.radii[0] - asked).abs() < 1e-12, "told {:?}", own.radii);
            assert!(error.abs() < ERROR_MAX, "{:?}: {error}", own.radii);
        }
    }
}

/// The energy of the near field is in the tetrahedra behind the loaded faces.
#[test]
fn the_near_field_is_where_the_contact_is() {
    let lattice = block([5; 3], 0.2);
    let place = contact([0.1, 0.05, 0.5], FORCES[2], 0.05);
    let load = load(&BLOCK.body, &[place]);
    let mut energies = vec![0.0; lattice.tets.len()];
    BLOCK.body.add_near_field(&load, 0.5, &mut energies);
    assert!((energies.iter().sum::<f64>() / (0.5 * load.near_energy()) - 1.0).abs() < 1e-12);
    let reach = BELL_RADII * load.touches[0].spread + 0.2;
    for (tet, energy) in energies.iter().enumerate().filter(|(_, energy)| **energy != 0.0) {
        assert!(*energy > 0.0 && (centroid(&lattice, tet) - place.point).norm() < reach, "{tet}: {energy}");
    }
    let sum = BLOCK.body.near_field_sum(&load, &vec![2.0; lattice.tets.len()]);
    assert!((sum / (2.0 * load.near_energy()) - 1.0).abs() < 1e-12);
}
