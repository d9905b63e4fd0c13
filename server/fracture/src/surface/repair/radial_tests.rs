use super::super::{RawMesh, Surface};
use crate::surface::{DefectKind, shapes};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

/// Length of one side of the grid.
const SIDE: usize = 5;

/// Surface of the full cells of a grid, wound outward; touching faces share no triangle.
fn cells(is_full: impl Fn([usize; 3]) -> bool) -> RawMesh {
    let mut mesh = RawMesh::new(Vec::new(), Vec::new());
    let full =
        |cell: [isize; 3]| cell.iter().all(|&k| (0..SIDE as isize).contains(&k)) && is_full(cell.map(|k| k as usize));
    for cell in every_cell().filter(|&cell| is_full(cell)) {
        for (axis, step) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let mut other = cell.map(|k| k as isize);
            other[axis] += if step == 1 { 1 } else { -1 };
            if full(other) {
                continue;
            }
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let corner = |[a, b]: [usize; 2]| {
                let mut corner = cell;
                (corner[axis], corner[u], corner[v]) = (corner[axis] + step, corner[u] + a, corner[v] + b);
                Point3::from(corner.map(|k| k as f64))
            };
            let first = mesh.positions_m.len() as u32;
            let corners = if step == 1 { [[0, 0], [1, 0], [1, 1], [0, 1]] } else { [[0, 0], [0, 1], [1, 1], [1, 0]] };
            mesh.positions_m.extend(corners.map(corner));
            mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    mesh
}

fn every_cell() -> impl Iterator<Item = [usize; 3]> {
    (0..SIDE.pow(3)).map(|k| [k % SIDE, k / SIDE % SIDE, k / SIDE / SIDE])
}

fn volume_m3(surface: &Surface) -> f64 {
    surface.signed_volume() * surface.frame.diagonal_m.powi(3)
}

fn is_inner([i, j, k]: [usize; 3]) -> bool {
    [i, j, k].iter().all(|&k| (1..SIDE - 1).contains(&k))
}

#[test]
fn cavities_that_touch_along_all_their_edges_stay() {
    let is_full = |cell: [usize; 3]| !(is_inner(cell) && cell.iter().sum::<usize>() % 3 == 0);
    let surface = Surface::repair(cells(is_full)).unwrap();
    let flipped = surface.defects.iter().find(|defect| defect.kind == DefectKind::FlippedShell);
    assert!(flipped.is_none() && surface.closed);
    assert!((volume_m3(&surface) - 116.0).abs() < 1e-9, "{}", volume_m3(&surface));
}

#[test]
fn a_cavity_that_touches_the_outer_surface_stays() {
    let hollow = |offset: [f64; 3]| {
        let mut cavity = shapes::cuboid([0.5; 3]);
        cavity.triangles.iter_mut().for_each(|corners| corners.swap(0, 1));
        cavity.positions_m.iter_mut().for_each(|point| *point += Vector3::from(offset));
        Surface::repair(joined(shapes::cuboid([1.0; 3]), &cavity)).unwrap()
    };
    for axis in 0..3 {
        for side in [-0.25, 0.25] {
            let mut offset = [0.0; 3];
            offset[axis] = side;
            assert!((volume_m3(&hollow(offset)) - 0.875).abs() < 1e-12, "{offset:?}");
            // The same box outside is a solid of its own.
            offset[axis] = 3.0 * side;
            assert!((volume_m3(&hollow(offset)) - 1.125).abs() < 1e-12, "{offset:?}");
        }
    }
}

/// A box whose faces are divided into squares, `counts` along each axis, without the vertices of its neighbors' edges.
fn divided(low: [f64; 3], high: [f64; 3], counts: [u32; 3], is_inverted: bool) -> RawMesh {
    let mut mesh = RawMesh::new(Vec::new(), Vec::new());
    for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
        let (u, v, count) = ((axis + 1) % 3, (axis + 2) % 3, counts[axis]);
        for (i, j) in (0..count).flat_map(|i| (0..count).map(move |j| (i, j))) {
            let corner = |[a, b]: [u32; 2]| {
                let mut at = if side == 1 { high } else { low };
                let share = |step: u32| f64::from(step) / f64::from(count);
                at[u] = low[u] + (high[u] - low[u]) * share(i + a);
                at[v] = low[v] + (high[v] - low[v]) * share(j + b);
                Point3::from(at)
            };
            let first = mesh.positions_m.len() as u32;
            let is_forward = (side == 1) != is_inverted;
            let corners = if is_forward { [[0, 0], [1, 0], [1, 1], [0, 1]] } else { [[0, 0], [0, 1], [1, 1], [1, 0]] };
            mesh.positions_m.extend(corners.map(corner));
            mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    mesh
}

fn joined(mut one: RawMesh, other: &RawMesh) -> RawMesh {
    let first = one.positions_m.len() as u32;
    one.positions_m.extend(&other.positions_m);
    one.triangles.extend(other.triangles.iter().map(|corners| corners.map(|vertex| vertex + first)));
    one
}

#[test]
fn cavities_of_divided_faces_stay() {
    let solid = divided([0.0; 3], [6.0; 3], [1, 2, 3], false);
    let cavity = divided([3.0, 3.0, 4.0], [4.0, 4.0, 6.0], [2, 3, 1], true);
    let surface = Surface::repair(joined(solid, &cavity)).unwrap();
    assert!(surface.defects.iter().all(|defect| defect.kind != DefectKind::FlippedShell), "{:?}", surface.defects);
    assert!((volume_m3(&surface) - 214.0).abs() < 1e-9, "{}", volume_m3(&surface));
}

#[test]
fn an_inverted_part_that_shares_a_face_with_another_is_turned() {
    let one = divided([0.0; 3], [1.0; 3], [1; 3], false);
    for is_inverted in [false, true] {
        let other = divided([1.0, 0.0, 0.0], [2.0, 1.0, 1.0], [1; 3], is_inverted);
        let surface = Surface::repair(joined(one.clone(), &other)).unwrap();
        assert!(surface.simple, "{:?}", surface.defects);
        assert!((volume_m3(&surface) - 2.0).abs() < 1e-12, "{}", volume_m3(&surface));
    }
}

#[test]
fn an_inverted_part_that_shares_an_edge_with_another_is_turned() {
    let one = divided([3.0, 5.0, 4.0], [6.0, 8.0, 8.0], [1; 3], false);
    let other = divided([3.0, 1.0, 5.0], [6.0, 5.0, 8.0], [1; 3], true);
    let surface = Surface::repair(joined(one, &other)).unwrap();
    assert!(surface.defects.iter().any(|defect| defect.kind == DefectKind::FlippedShell));
    assert!((volume_m3(&surface) - 72.0).abs() < 1e-9, "{}", volume_m3(&surface));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Solids and cavities that touch along edges and corners in all ways keep their volume.
    #[test]
    fn random_cells_keep_their_volume(
        filled in proptest::collection::vec(proptest::bool::weighted(0.6), SIDE.pow(3)),
        has_hull: bool,
        is_inverted: bool,
    ) {
        let is_full = |cell: [usize; 3]| {
            has_hull && !is_inner(cell) || filled[cell[0] + SIDE * (cell[1] + SIDE * cell[2])]
        };
        let mut mesh = cells(is_full);
        if is_inverted {
            mesh.triangles.iter_mut().for_each(|corners| corners.swap(0, 1));
        }
        let expected = every_cell().filter(|&cell| is_full(cell)).count() as f64;
        let surface = Surface::repair(mesh).unwrap();
        prop_assert!(surface.closed);
        prop_assert!((volume_m3(&surface) - expected).abs() < 1e-9, "{} instead of {expected}", volume_m3(&surface));
    }
}
