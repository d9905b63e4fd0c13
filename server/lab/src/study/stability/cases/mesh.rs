//! Cases: defective and extreme meshes.

use super::super::trial::{self, TrialFault, at, baked, coarse, fine, sound, struck, survives};
use nalgebra::{Point3, Vector3};
use shatter_fracture::pipeline::PreparedObject;
use shatter_fracture::surface::{DefectKind, RawMesh, SINGLE, shapes};
use std::f64::consts::PI;

/// Sphere of radius 1.
fn ball() -> RawMesh {
    shapes::sphere(1.0, 4)
}

/// Mesh of two meshes, the second moved.
pub(super) fn joined(mut one: RawMesh, two: &RawMesh, offset: [f64; 3]) -> RawMesh {
    let first = one.positions_m.len() as u32;
    one.positions_m.extend(two.positions_m.iter().map(|point| point + Vector3::from(offset)));
    one.triangles.extend(two.triangles.iter().map(|corners| corners.map(|vertex| vertex + first)));
    one
}

fn inverted(mut mesh: RawMesh) -> RawMesh {
    mesh.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
    mesh
}

/// Mesh without the triangles that `drop` selects by number.
fn without(mut mesh: RawMesh, drop: impl Fn(usize) -> bool) -> RawMesh {
    let mut number = 0..;
    mesh.triangles.retain(|_| number.next().is_none_or(|number| !drop(number)));
    mesh
}

/// Relative difference of the lattice's volume from `volume_m3`, after a request that must be sound.
fn volume(mesh: RawMesh, volume_m3: f64) -> Result<f64, TrialFault> {
    let prepared = baked(mesh, &coarse()?)?;
    sound(&prepared, &struck(&prepared, &at(&prepared, [1.0, 0.3, 0.2]))?)?;
    Ok((prepared.report.lattice_volume_m3 / volume_m3 - 1.0).abs())
}

/// Relative difference of the lattice's volume between a damaged arch and the intact one.
fn as_the_arch(damage: impl FnOnce(RawMesh) -> RawMesh) -> Result<f64, TrialFault> {
    let arch = baked(shapes::arch(), &coarse()?)?;
    volume(damage(shapes::arch()), arch.report.lattice_volume_m3)
}

/// Ball beside 20 crumbs that have a fortieth of its volume and are too small for the lattice.
pub fn small_components() -> Result<f64, TrialFault> {
    let fragment_cube = shapes::cuboid([0.17; 3]);
    let places = (0..20).map(|k| [k / 10, k / 5 % 2, k % 5].map(|k| f64::from(k) * 0.4));
    let mesh = places.fold(ball(), |mesh, [x, y, z]| joined(mesh, &fragment_cube, [1.3 + x, y - 0.2, z - 0.8]));
    volume(mesh, 4.0 / 3.0 * PI)
}

pub fn inside_out() -> Result<f64, TrialFault> {
    as_the_arch(inverted)
}

pub fn mixed_winding() -> Result<f64, TrialFault> {
    as_the_arch(|mut mesh| {
        mesh.triangles.iter_mut().step_by(3).for_each(|corners| corners.swap(0, 1));
        mesh
    })
}

pub fn duplicated() -> Result<f64, TrialFault> {
    as_the_arch(|mut mesh| {
        mesh.triangles.extend_from_within(..);
        mesh
    })
}

pub fn degenerate() -> Result<f64, TrialFault> {
    as_the_arch(|mut mesh| {
        let flat: Vec<[u32; 3]> = mesh.triangles.iter().flat_map(|&[a, b, _]| [[a, a, b], [b, b, b]]).collect();
        mesh.triangles.extend(flat);
        mesh
    })
}

pub fn t_junctions() -> Result<f64, TrialFault> {
    as_the_arch(|mut mesh| {
        for triangle in (0..mesh.triangles.len()).step_by(5) {
            let [a, b, c] = mesh.triangles[triangle];
            let middle = nalgebra::center(&mesh.positions_m[a as usize], &mesh.positions_m[b as usize]);
            mesh.positions_m.push(middle);
            let new = mesh.positions_m.len() as u32 - 1;
            mesh.triangles[triangle] = [a, new, c];
            mesh.triangles.push([new, b, c]);
        }
        mesh
    })
}

pub fn open() -> Result<f64, TrialFault> {
    volume(without(ball(), |number| number % 50 == 0), 4.0 / 3.0 * PI)
}

pub fn self_intersecting() -> Result<f64, TrialFault> {
    // Two unit balls, centers 1 apart: each loses a cap of height ½, π h²(3 − h)/3.
    let cap = PI * 0.25 * 2.5 / 3.0;
    volume(joined(ball(), &ball(), [1.0, 0.0, 0.0]), 8.0 / 3.0 * PI - 2.0 * cap)
}

pub fn nested() -> Result<f64, TrialFault> {
    let cavity = inverted(shapes::sphere(0.6, 4));
    volume(joined(ball(), &cavity, [0.0; 3]), 4.0 / 3.0 * PI * (1.0 - 0.216))
}

fn bodies(prepared: &PreparedObject, expected: usize) -> f64 {
    (prepared.bodies.len() as f64 - expected as f64).abs()
}

pub fn several_components() -> Result<f64, TrialFault> {
    let three = joined(joined(ball(), &ball(), [2.5, 0.0, 0.0]), &shapes::sphere(0.5, 3), [0.0, 2.0, 0.0]);
    let prepared = baked(three, &coarse()?)?;
    sound(&prepared, &struck(&prepared, &at(&prepared, [1.0, 0.0, 0.0]))?)?;
    Ok(bodies(&prepared, 3))
}

/// Relative difference of the volume from the box's; an error unless there is one whole body.
fn thin(size_m: [f64; 3]) -> Result<f64, TrialFault> {
    let prepared = baked(shapes::cuboid(size_m), &fine()?)?;
    sound(&prepared, &struck(&prepared, &at(&prepared, [1.0, 1.0, 1.0]))?)?;
    if prepared.bodies.len() != 1 || !prepared.report.defects.is_empty() {
        return Err(TrialFault::ours(
            "lost",
            format!("{} bodies, {:?}", prepared.bodies.len(), prepared.report.defects),
        ));
    }
    Ok(prepared.report.volume_error().abs())
}

pub fn plate() -> Result<f64, TrialFault> {
    thin([1.0, 0.25, 0.01])
}

pub fn needle() -> Result<f64, TrialFault> {
    thin([1.0, 0.01, 0.01])
}

pub fn foil() -> Result<f64, TrialFault> {
    thin([1.0, 1.0, 0.0005])
}

pub fn lost_wall() -> Result<f64, TrialFault> {
    survives(shapes::vase())
}

/// Number of samples counted by defects of this kind.
fn named(prepared: &PreparedObject, kind: DefectKind) -> f64 {
    prepared.report.defects.iter().filter(|defect| defect.kind == kind).map(|defect| defect.count as f64).sum()
}

pub fn narrow_gap() -> Result<f64, TrialFault> {
    let cube = shapes::cuboid([1.0; 3]);
    let prepared = baked(joined(cube.clone(), &cube, [1.01, 0.0, 0.0]), &coarse()?)?;
    sound(&prepared, &struck(&prepared, &at(&prepared, [1.0, 0.2, 0.1]))?)?;
    Ok(named(&prepared, DefectKind::NarrowGap))
}

pub fn lost_fin() -> Result<f64, TrialFault> {
    let fin = shapes::cuboid([0.01, 0.4, 0.4]);
    let prepared = baked(joined(shapes::cuboid([1.0; 3]), &fin, [0.0, 0.6, 0.0]), &coarse()?)?;
    sound(&prepared, &struck(&prepared, &at(&prepared, [1.0, 0.2, 0.1]))?)?;
    Ok(named(&prepared, DefectKind::ThinWall))
}

pub fn lost_precision() -> Result<f64, TrialFault> {
    let mut mesh = ball();
    mesh.positions_m.iter_mut().for_each(|point| *point += Vector3::repeat(1e6));
    mesh.positions_m.iter_mut().for_each(|point| *point = point.map(|x| f64::from(x as f32)));
    mesh.rounding = SINGLE;
    let prepared = baked(mesh, &coarse()?)?;
    sound(&prepared, &struck(&prepared, &at(&prepared, [1.0, 0.2, 0.1]))?)?;
    Ok(named(&prepared, DefectKind::LostPrecision))
}

/// Arch with one coordinate of one vertex replaced.
fn with(coordinate: f64) -> Result<f64, TrialFault> {
    let mut mesh = shapes::arch();
    mesh.positions_m[7].y = coordinate;
    survives(mesh)
}

pub fn not_a_number() -> Result<f64, TrialFault> {
    with(f64::NAN)
}

pub fn infinite() -> Result<f64, TrialFault> {
    with(f64::INFINITY)
}

pub fn immense() -> Result<f64, TrialFault> {
    with(1e300)
}

pub fn out_of_range() -> Result<f64, TrialFault> {
    let mut mesh = shapes::arch();
    mesh.triangles[5][1] = 1 << 30;
    survives(mesh)
}

pub fn empty() -> Result<f64, TrialFault> {
    survives(RawMesh::new(Vec::new(), Vec::new()))
}

pub fn single_triangle() -> Result<f64, TrialFault> {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Point3::from);
    survives(RawMesh::new(corners.to_vec(), vec![[0, 1, 2]]))
}

pub fn one_point() -> Result<f64, TrialFault> {
    survives(RawMesh::new(vec![Point3::new(3.0, 4.0, 5.0); 3], vec![[0, 1, 2]]))
}

pub fn denormal() -> Result<f64, TrialFault> {
    let mut mesh = ball();
    mesh.positions_m.iter_mut().for_each(|point| *point *= 1e-310);
    survives(mesh)
}

pub fn bow_tie() -> Result<f64, TrialFault> {
    // Two cubes that share one corner: a hinge, which would make the stiffness singular.
    let cube = shapes::cuboid([1.0; 3]);
    let prepared = baked(joined(cube.clone(), &cube, [1.0; 3]), &trial::coarse()?)?;
    sound(&prepared, &struck(&prepared, &at(&prepared, [1.0, 1.0, 1.0]))?)
}
