//! Exact bodies, invariances, and every defect of an open mesh.

use super::*;
use crate::random::RandomStream;
use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

struct Body {
    vertices: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
}

impl Body {
    fn properties(&self) -> RigidProperties {
        RigidProperties::of_surface(&self.vertices, self.triangles.iter().copied())
    }

    fn moved(&self, motion: &Isometry3<f64>) -> Self {
        Self {
            vertices: self.vertices.iter().map(|vertex| motion * vertex).collect(),
            triangles: self.triangles.clone(),
        }
    }

    fn f32(&self) -> (Vec<[f32; 3]>, Vec<u32>) {
        let positions =
            self.vertices.iter().map(|vertex| [vertex.x as f32, vertex.y as f32, vertex.z as f32]).collect();
        (positions, self.triangles.as_flattened().to_vec())
    }
}

fn cuboid(size: [f64; 3]) -> Body {
    let vertices = (0..8)
        .map(|k| Point3::from(Vector3::from_fn(|axis, _| size[axis] * (f64::from(k >> axis & 1) - 0.5))))
        .collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    Body { vertices, triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect() }
}

/// An octahedron subdivided `levels` times onto the unit sphere.
fn ball(levels: usize) -> Body {
    let vertices: Vec<Point3<f64>> =
        [1.0, -1.0].iter().flat_map(|s| (0..3).map(move |k| Point3::from(Vector3::ith(k, *s)))).collect();
    let mut soup: Vec<[Vector3<f64>; 3]> =
        [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
            .iter()
            .map(|t| t.map(|k: usize| vertices[k].coords))
            .collect();
    for _ in 0..levels {
        soup = soup
            .iter()
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [(a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let triangles = (0..soup.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    Body { vertices: soup.iter().flatten().map(|&place| Point3::from(place)).collect(), triangles }
}

fn motion(seed: u64) -> Isometry3<f64> {
    let mut random = RandomStream::new(seed, 0);
    let mut draw = || Vector3::from_fn(|_, _| 4.0 * random.uniform() - 2.0);
    Isometry3::new(draw(), draw())
}

fn check(found: &RigidProperties, volume: f64, center: Point3<f64>, inertia: Matrix3<f64>) {
    assert!((found.volume / volume - 1.0).abs() < 1e-12, "{} {volume}", found.volume);
    assert!((found.center - center).norm() < 1e-12, "{} {center}", found.center);
    assert!((found.inertia - inertia).norm() < 1e-12 * inertia.norm().max(1.0), "{} {inertia}", found.inertia);
    found.rigid().unwrap();
}

#[test]
fn a_box_has_the_moments_of_a_box() {
    let [a, b, c] = [0.5, 1.25, 2.0];
    let volume: f64 = a * b * c;
    let inertia = Matrix3::from_diagonal(&Vector3::new(b * b + c * c, a * a + c * c, a * a + b * b)) * (volume / 12.0);
    check(&cuboid([a, b, c]).properties(), volume, Point3::origin(), inertia);
}

#[test]
fn a_corner_tetrahedron_has_the_moments_of_the_simplex() {
    let vertices =
        vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0), Point3::new(0.0, 0.0, 1.0)];
    let body = Body { vertices, triangles: vec![[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]] };
    // About the centroid, ∫x² = 1/160 and ∫xy = −1/480.
    let inertia = Matrix3::from_fn(|i, j| if i == j { 2.0 / 160.0 } else { 1.0 / 480.0 });
    check(&body.properties(), 1.0 / 6.0, Point3::new(0.25, 0.25, 0.25), inertia);
}

#[test]
fn a_fine_ball_tends_to_the_sphere_at_second_order() {
    let sphere = 4.0 / 3.0 * std::f64::consts::PI;
    let errors = [2, 3, 4].map(|levels| {
        let found = ball(levels).properties();
        let isotropic = Matrix3::identity() * (found.inertia.trace() / 3.0);
        assert!((found.inertia - isotropic).norm() < 1e-12 && found.center.coords.norm() < 1e-14);
        [sphere - found.volume, 0.4 * sphere - found.inertia[(0, 0)]]
    });
    for pair in errors.windows(2) {
        for (coarse, fine) in pair[0].iter().zip(pair[1]) {
            let order = (coarse / fine).log2();
            assert!((1.85..2.1).contains(&order), "{order}");
        }
    }
}

#[test]
fn moving_a_body_moves_its_center_and_turns_its_inertia() {
    let body = cuboid([0.3, 0.7, 1.1]);
    let still = body.properties();
    for seed in 0..8 {
        let motion = motion(seed);
        let turn = motion.rotation.to_rotation_matrix();
        let inertia = turn.matrix() * still.inertia * turn.matrix().transpose();
        check(&body.moved(&motion).properties(), still.volume, motion * still.center, inertia);
    }
}

#[test]
fn the_parts_of_a_box_make_up_its_inertia() {
    let whole = cuboid([1.0, 0.6, 0.4]).properties();
    let half = cuboid([0.5, 0.6, 0.4]);
    let mut inertia = Matrix3::zeros();
    for side in [-0.25, 0.25] {
        let part = half.moved(&Isometry3::translation(side, 0.0, 0.0)).properties();
        let arm = part.center - whole.center;
        // Parallel axes (Huygens, Steiner): I + V (|d|² I − d dᵀ).
        let steiner = Matrix3::identity() * arm.norm_squared() - arm * arm.transpose();
        inertia += part.inertia + steiner * part.volume;
    }
    assert!((inertia - whole.inertia).norm() < 1e-15);
}

#[test]
fn a_small_body_far_from_the_origin_keeps_its_moments() {
    let size = 1e-3;
    let body = cuboid([size; 3]);
    let far = body.moved(&Isometry3::translation(0.5, -0.5, 0.5)).properties();
    assert!((far.inertia[(0, 0)] / (size.powi(5) / 6.0) - 1.0).abs() < 1e-11);
    far.rigid().unwrap();
}

#[test]
fn impossible_bodies_are_not_rigid() {
    let mut inside_out = cuboid([1.0; 3]);
    inside_out.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
    assert_eq!(inside_out.properties().rigid(), Err(NotRigid::Volume { volume: -1.0 }));
    assert!(matches!(RigidProperties::of_surface(&[], []).rigid(), Err(NotRigid::Volume { volume: 0.0 })));
    let good = cuboid([1.0; 3]).properties();
    let center = Point3::new(f64::NAN, 0.0, 0.0);
    assert_eq!(RigidProperties { center, ..good }.rigid(), Err(NotRigid::Center));
    assert_eq!(RigidProperties { inertia: -good.inertia, ..good }.rigid(), Err(NotRigid::Inertia));
    let inertia = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 2.5));
    assert_eq!(RigidProperties { inertia, ..good }.rigid(), Err(NotRigid::Moments));
}

#[test]
fn a_closed_surface_is_closed_with_and_without_shared_vertices() {
    for body in [cuboid([1.0, 2.0, 3.0]), ball(2)] {
        let (positions, indices) = body.f32();
        closed(&positions, &indices).unwrap();
        let soup: Vec<[f32; 3]> = indices.iter().map(|&vertex| positions[vertex as usize]).collect();
        let order: Vec<u32> = (0..soup.len() as u32).collect();
        closed(&soup, &order).unwrap();
    }
}

#[test]
fn every_kind_of_open_mesh_is_reported() {
    let (positions, indices) = cuboid([1.0; 3]).f32();
    assert_eq!(closed(&positions, &[]), Err(OpenMesh::Empty));
    assert_eq!(closed(&positions, &indices[1..]), Err(OpenMesh::IndexCount { count: 35 }));
    let hole = closed(&positions, &indices[3..]);
    assert!(matches!(hole, Err(OpenMesh::Edge { forward: 1, backward: 0, .. })), "{hole:?}");
    let doubled = [&indices[..], &indices[..3]].concat();
    assert!(matches!(closed(&positions, &doubled), Err(OpenMesh::Edge { forward: 2, .. })));
    let mut flipped = indices.clone();
    flipped.swap(0, 1);
    assert!(matches!(closed(&positions, &flipped), Err(OpenMesh::Edge { .. })));
    let mut far = indices.clone();
    far[7] = 8;
    assert_eq!(closed(&positions, &far), Err(OpenMesh::VertexOutOfRange { at: 7, vertex: 8 }));
    let mut torn = positions.clone();
    torn[3][1] = f32::NAN;
    assert_eq!(closed(&torn, &indices), Err(OpenMesh::NonFiniteVertex { vertex: 3 }));
    let mut pinched = positions.clone();
    pinched[4] = pinched[0];
    assert_eq!(closed(&pinched, &indices), Err(OpenMesh::Degenerate { triangle: 0 }));
    let reversed: Vec<u32> = indices.chunks(3).flat_map(|t| [t[0], t[2], t[1]]).collect();
    assert_eq!(closed(&positions, &reversed), Err(OpenMesh::Volume { volume: -1.0 }));
    // One bit off at a shared corner: still the same vertex by index, but not by position in a soup.
    let mut soup: Vec<[f32; 3]> = indices.iter().map(|&vertex| positions[vertex as usize]).collect();
    soup[0][0] = f32::from_bits(soup[0][0].to_bits() + 1);
    let order: Vec<u32> = (0..soup.len() as u32).collect();
    assert!(matches!(closed(&soup, &order), Err(OpenMesh::Edge { .. })));
}

#[test]
fn wide_instructions_do_not_change_a_bit() {
    crate::simd::tests::same_on_every_path(|| ball(4).moved(&Isometry3::translation(0.3, -2.0, 0.7)).properties());
}
