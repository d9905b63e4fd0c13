use super::super::{RawMesh, Surface};
use crate::surface::{DefectKind, shapes};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

/// Length of one side of the grid.
const SIDE: usize = 3;

/// Unit cube at a place of a grid, with the second diagonal in the faces whose bits are set.
#[derive(Clone, Copy, Debug)]
struct Cell {
    at: [usize; 3],
    is_inverted: bool,
    diagonals: u8,
}

impl Cell {
    fn add_to(self, mesh: &mut RawMesh) {
        for (axis, step) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let corner = |[a, b]: [usize; 2]| {
                let mut corner = self.at;
                (corner[axis], corner[u], corner[v]) = (corner[axis] + step, corner[u] + a, corner[v] + b);
                Point3::from(corner.map(|k| k as f64))
            };
            let is_forward = (step == 1) != self.is_inverted;
            let mut corners =
                if is_forward { [[0, 0], [1, 0], [1, 1], [0, 1]] } else { [[0, 0], [0, 1], [1, 1], [1, 0]] };
            corners.rotate_left(usize::from(self.diagonals >> (2 * axis + step) & 1));
            let first = mesh.positions_m.len() as u32;
            mesh.positions_m.extend(corners.map(corner));
            mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
}

fn repaired(cells: &[Cell]) -> Surface {
    let mut mesh = RawMesh::new(Vec::new(), Vec::new());
    cells.iter().for_each(|cell| cell.add_to(&mut mesh));
    Surface::repair(mesh).unwrap()
}

fn volume_m3(surface: &Surface) -> f64 {
    surface.signed_volume() * surface.frame.diagonal_m.powi(3)
}

fn flipped(surface: &Surface) -> u64 {
    surface.defects.iter().find(|defect| defect.kind == DefectKind::FlippedShell).map_or(0, |defect| defect.count)
}

#[test]
fn inverted_cubes_among_others_are_turned_and_counted() {
    let plus = [[1, 1, 1], [0, 1, 1], [2, 1, 1], [1, 0, 1], [1, 2, 1], [1, 1, 0], [1, 1, 2]];
    for (inverted, diagonals) in [(0, 0), (0, 21), (3, 0), (3, 21), (3, 63)] {
        let cell = |(place, at): (usize, &[usize; 3])| Cell { at: *at, is_inverted: place == inverted, diagonals };
        let surface = repaired(&plus.iter().enumerate().map(cell).collect::<Vec<_>>());
        assert_eq!(flipped(&surface), 1, "{inverted} {diagonals} {:?}", surface.defects);
        assert!(surface.closed && (volume_m3(&surface) - 7.0).abs() < 1e-12, "{}", volume_m3(&surface));
    }
}

/// Parts as (size, center, whether it is inside out).
fn boxes(parts: &[([f64; 3], [f64; 3], bool)]) -> Surface {
    let mut mesh = RawMesh::new(Vec::new(), Vec::new());
    for (size, center, is_inverted) in parts {
        let (first, part) = (mesh.positions_m.len() as u32, shapes::cuboid(*size));
        mesh.positions_m.extend(part.positions_m.iter().map(|point| point + Vector3::from(*center)));
        let wound = |[a, b, c]: [u32; 3]| if *is_inverted { [b, a, c] } else { [a, b, c] };
        mesh.triangles.extend(part.triangles.iter().map(|corners| wound(*corners).map(|vertex| vertex + first)));
    }
    Surface::repair(mesh).unwrap()
}

#[test]
fn an_inverted_part_beside_a_hollow_one_is_turned() {
    let hollow = [([6.0; 3], [0.0; 3], false), ([2.0; 3], [0.0; 3], true)];
    let surface = boxes(&[hollow[0], hollow[1], ([2.0, 6.0, 6.0], [4.0, 0.0, 0.0], true)]);
    assert_eq!(flipped(&surface), 1, "{:?}", surface.defects);
    assert!((volume_m3(&surface) - 280.0).abs() < 1e-9, "{}", volume_m3(&surface));
}

/// A box, the same box inside out, and a cavity: two layers that enclose nothing are no part beside which another is inverted.
#[test]
fn a_cavity_in_doubled_layers_stays() {
    let surface = boxes(&[([6.0; 3], [0.0; 3], false), ([6.0; 3], [0.0; 3], true), ([2.0; 3], [0.0; 3], true)]);
    assert_eq!(flipped(&surface), 0, "{:?}", surface.defects);
    assert!((volume_m3(&surface) - 208.0).abs() < 1e-9, "{}", volume_m3(&surface));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// Cubes that touch in all ways keep their volume, whichever of them are inside out and however their faces are divided.
    #[test]
    fn random_cubes_keep_their_volume(
        filled in proptest::collection::vec(proptest::bool::weighted(0.6), SIDE.pow(3)),
        inverted in proptest::collection::vec(proptest::bool::weighted(0.3), SIDE.pow(3)),
        diagonals in proptest::collection::vec(0..64_u8, SIDE.pow(3)),
        has_equal_diagonals: bool,
    ) {
        let at = |k: usize| [k % SIDE, k / SIDE % SIDE, k / SIDE / SIDE];
        let diagonals = |k: usize| if has_equal_diagonals { 0 } else { diagonals[k] };
        let cell = |k: usize| Cell { at: at(k), is_inverted: inverted[k], diagonals: diagonals(k) };
        let cells: Vec<Cell> = (0..SIDE.pow(3)).filter(|&k| filled[k]).map(cell).collect();
        prop_assume!(!cells.is_empty());
        let (surface, expected) = (repaired(&cells), cells.len() as f64);
        prop_assert!(surface.closed);
        prop_assert!((volume_m3(&surface) - expected).abs() < 1e-9, "{} instead of {expected}", volume_m3(&surface));
    }
}
