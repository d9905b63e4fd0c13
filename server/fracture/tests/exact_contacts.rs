//! Contacts and rays on exact surfaces: they meet the input surface, also where the lattice lost it.

use nalgebra::{Point3, Vector3};
use shatter_fracture::database::{BakeRequest, Tables};
use shatter_fracture::elasticity::SurfaceFaces;
use shatter_fracture::pipeline::{
    AimRay, ContactSet, DegreeRequest, FractureError, FractureRequest, PreparedObject, SurfaceHit, SurfaceKind, aim,
    aim_again,
};
use shatter_fracture::random::RandomStream;
use shatter_fracture::scene::{MATERIALS, Materials};
use shatter_fracture::surface::{InsideTest, RawMesh, Surface, shapes};
use std::sync::LazyLock;

/// A block with a plate of 0.3 spacings on its top, which the lattice lost; its diagonal is about 1 m.
static FIN: LazyLock<PreparedObject> = LazyLock::new(|| baked(fin(FIN_HALF_M), SPACING));

/// A statue, whose lattice rounds its surface off.
static STATUE: LazyLock<PreparedObject> = LazyLock::new(|| baked(shapes::statue_on(0.03), 0.06));

const SPACING: f64 = 0.05;

/// Half of the fin's thickness, m.
const FIN_HALF_M: f64 = 0.15 * SPACING;

fn baked(mesh: RawMesh, spacing: f64) -> PreparedObject {
    let material = Materials::parse(MATERIALS).unwrap().get("ceramic").unwrap().clone();
    let request = BakeRequest {
        surface: SurfaceKind::Exact,
        kappa: Some(1.0),
        elastic_spacing: Some(1.5 * spacing),
        crack_spacing: Some(spacing),
        tables: Tables { interior: true, elastic: true, ..Tables::NONE },
        ..BakeRequest::new("object", "ceramic", material)
    };
    let prepared = request.bake(mesh).unwrap();
    assert_eq!(prepared.report.surface.reason, None);
    prepared
}

/// A block with a plate on its top between y = 0.1 m and 0.4 m, twice `half` thick.
fn fin(half: f64) -> RawMesh {
    let outline =
        [[-0.3, -0.3], [0.3, -0.3], [0.3, 0.1], [half, 0.1], [half, 0.4], [-half, 0.4], [-half, 0.1], [-0.3, 0.1]];
    let caps = [[0, 1, 2], [0, 2, 3], [0, 3, 6], [0, 6, 7], [3, 4, 5], [3, 5, 6]];
    let count = outline.len() as u32;
    let layer = |z: f64| outline.map(|[x, y]| Point3::new(x, y, z));
    let mut triangles = Vec::new();
    for k in 0..count {
        let next = (k + 1) % count;
        triangles.extend([[k, next, count + next], [k, count + next, count + k]]);
    }
    for [a, b, c] in caps {
        triangles.extend([[a, c, b], [count + a, count + b, count + c]]);
    }
    RawMesh::new([layer(-0.25), layer(0.25)].concat(), triangles)
}

fn ray(origin_m: [f64; 3], direction: [f64; 3]) -> AimRay {
    AimRay { origin_m: origin_m.into(), direction: direction.into() }
}

#[test]
fn a_fin_that_the_lattice_lost_is_hit() {
    let at_fin = ray([1.0, 0.35, 0.1], [-2.0, 0.0, 0.0]);
    let hit = aim(&FIN, SurfaceKind::Exact, &at_fin).unwrap();
    assert!((hit.point_m - Point3::new(FIN_HALF_M, 0.35, 0.1)).norm() < 1e-9, "{hit:?}");
    assert!((hit.normal - Vector3::x()).norm() < 1e-9 && (hit.distance_m - (1.0 - FIN_HALF_M)).abs() < 1e-9, "{hit:?}");
    assert_eq!(hit.surface, SurfaceKind::Exact);
    let lost = aim(&FIN, SurfaceKind::Lattice, &at_fin);
    assert!(matches!(lost, Err(FractureError::RayMissed { .. })), "{lost:?}");
}

#[test]
fn a_contact_on_a_lost_fin_loads_its_anchor() {
    let tip = Point3::new(0.0, 0.4, 0.1);
    let mut strike = FractureRequest::at(tip, Vector3::new(-1.0, -1.0, 0.0)).seeded(2);
    (strike.degree, strike.contacts[0].radius_m) = (DegreeRequest::Sites(8), Some(1e-3));
    let impact = ContactSet::new(&FIN, &strike).unwrap();
    let load = impact.bodies[0].1[0];
    let place = FIN.frame.to_meters(&load.point);
    let off = Vector3::new(place.x, place.y - 0.1, place.z - 0.1);
    assert!(off.amax() < 1.5 * SPACING, "the load acts at {place}");
    assert!(load.radius * FIN.frame.diagonal_m < 1.5 * SPACING, "{load:?}");
    assert!(FIN.strike(&strike).unwrap().meshes().unwrap().fragments.len() > 1);
    let lattice = FractureRequest { surface: SurfaceKind::Lattice, ..strike };
    let refused = FIN.strike(&lattice).err();
    assert!(matches!(refused, Some(FractureError::TooFar { .. })), "{refused:?}");
}

#[test]
fn points_too_far_are_measured_from_the_input_surface() {
    let corner = Point3::new(0.3, -0.3, 0.25);
    let away = Vector3::new(1.0, -2.0, 2.0).normalize() * 0.2;
    let refused = FIN.strike(&FractureRequest::at(corner + away, -away)).err();
    let Some(FractureError::TooFar { distance, surface, unit_m: 1.0, .. }) = refused else { panic!("{refused:?}") };
    assert!((distance - 0.2).abs() < 1e-9 && (surface - corner).norm() < 1e-9, "{distance} {surface}");
    let missed = aim(&FIN, SurfaceKind::Exact, &ray([1.0, 0.45, 0.0], [-1.0, 0.0, 0.0]));
    let Err(FractureError::RayMissed { distance, surface, unit_m: 1.0, .. }) = missed else { panic!("{missed:?}") };
    assert!((distance - 0.05).abs() < 1e-9 && (surface.y - 0.4).abs() < 1e-9, "{distance} {surface}");
}

/// The first hit of a ray on triangles in the coordinates of the file, by all of them.
fn first_of_all<'a>(triangles: impl Iterator<Item = &'a [Point3<f64>; 3]>, ray: &AimRay) -> Option<f64> {
    let direction = ray.direction.normalize();
    let meets = |[a, b, c]: &[Point3<f64>; 3]| {
        let normal = (b - a).cross(&(c - a));
        let distance = (a - ray.origin_m).dot(&normal) / direction.dot(&normal);
        let place = ray.origin_m + direction * distance;
        let side = |p: &Point3<f64>, q: &Point3<f64>| (q - p).cross(&(place - p)).dot(&normal) >= 0.0;
        (distance >= 0.0 && side(a, b) && side(b, c) && side(c, a)).then_some(distance)
    };
    triangles.filter_map(meets).min_by(f64::total_cmp)
}

/// A ray from a random point of a sphere around the object to a random point near its center.
fn random_ray(prepared: &PreparedObject, stream: &mut RandomStream) -> AimRay {
    let size = prepared.frame.diagonal_m;
    let mut random = |scale: f64| Vector3::from([(); 3].map(|()| scale * (stream.uniform() - 0.5)));
    let origin_m = prepared.frame.center_m + random(1.0).normalize() * size;
    AimRay { origin_m, direction: prepared.frame.center_m + random(0.4 * size) - origin_m }
}

#[test]
fn rays_hit_the_input_surface_first() {
    let inside = InsideTest::new(&Surface::repair(shapes::statue_on(0.03)).unwrap());
    let cutting = STATUE.bodies[0].cutting.as_ref().unwrap();
    let corners = |face: usize| cutting.corners(face).map(|corner| STATUE.frame.to_meters(&corner));
    let all: Vec<[Point3<f64>; 3]> = (0..cutting.count()).map(corners).collect();
    let (mut stream, mut hits, mut off) = (RandomStream::new(3, 0), 0, 0.0f64);
    for _ in 0..300 {
        let ray = random_ray(&STATUE, &mut stream);
        let plain = first_of_all(all.iter(), &ray);
        let Ok(hit) = aim(&STATUE, SurfaceKind::Exact, &ray) else {
            assert_eq!(plain, None);
            continue;
        };
        assert!((plain.unwrap() - hit.distance_m).abs() < 1e-9, "{ray:?} {plain:?} {hit:?}");
        assert!(inside.distance(&STATUE.frame.to_local(&hit.point_m)) < 1e-12, "{hit:?}");
        let lattice = aim(&STATUE, SurfaceKind::Lattice, &ray);
        off = off.max(lattice.map_or(0.0, |other| (other.point_m - hit.point_m).norm()));
        hits += 1;
    }
    assert!(hits > 100 && off > 1e-3, "{hits} hits, at most {off} m from those on the lattice");
}

#[test]
fn rays_hit_the_surface_of_a_fragment_with_its_cracks() {
    let mut strike = FractureRequest::at(STATUE.frame.center_m, Vector3::y()).seeded(2);
    (strike.degree, strike.contacts[0].radius_m) = (DegreeRequest::Sites(12), Some(1.0));
    let meshes = STATUE.strike(&strike).unwrap().into_meshes().unwrap();
    let (kept, emitted) = (meshes.keep(), meshes.emitted().unwrap());
    let (mut stream, mut hits) = (RandomStream::new(4, 0), [0; 2]);
    for fragment in emitted.fragments() {
        let center = Vector3::from(fragment.row.center_m);
        let place = |vertex: u32| Point3::from(fragment.positions[vertex as usize]).cast::<f64>() + center;
        let all: Vec<[Point3<f64>; 3]> =
            fragment.indices.chunks(3).map(|own| [0, 1, 2].map(|corner| place(own[corner]))).collect();
        for _ in 0..20 {
            let far = random_ray(&STATUE, &mut stream);
            let ray = AimRay { direction: Point3::from(center) - far.origin_m, ..far };
            let Some(plain) = first_of_all(all.iter(), &ray) else { continue };
            let SurfaceHit { distance_m, point_m, surface, .. } =
                aim_again(&STATUE, (&kept, fragment.row.id), &ray).unwrap();
            // Quadrilaterals of cracks can have another diagonal there.
            let off = (plain - distance_m).abs() / STATUE.frame.diagonal_m;
            assert!(off < 0.1 * STATUE.parameters.crack_spacing, "{plain} {distance_m}");
            assert_eq!(surface, SurfaceKind::Exact);
            hits[usize::from(off < 1e-5)] += 1;
            let on_object = aim(&STATUE, SurfaceKind::Exact, &ray).unwrap();
            assert!(distance_m > on_object.distance_m - 1e-9, "{point_m} is outside of the object");
        }
    }
    println!("hits beside and on the fragments' triangles: {hits:?}");
    assert!(hits[1] > 5 * hits[0] && hits[1] > 100, "{hits:?}");
}
