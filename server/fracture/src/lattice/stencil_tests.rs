use super::*;
use nalgebra::{Matrix3, Point3};

/// Every combination of the three sides on four nodes.
fn combinations() -> impl Iterator<Item = [LevelSetSide; 4]> {
    (0..81).map(|code| {
        [1, 3, 9, 27].map(|power| [LevelSetSide::Inside, LevelSetSide::On, LevelSetSide::Outside][code / power % 3])
    })
}

const TWICE: [[i32; 3]; 4] = [[1, 1, 1], [3, 1, 1], [2, 0, 0], [2, 2, 0]];

fn place(corner: StencilCorner) -> Point3<f64> {
    let node = |node: u32| Point3::from(TWICE[node as usize].map(f64::from));
    match corner {
        StencilCorner::Node(at) => node(at),
        StencilCorner::Cut(a, b) => nalgebra::center(&node(a), &node(b)),
    }
}

fn volumes(sides: [LevelSetSide; 4]) -> Vec<f64> {
    let mut volumes = Vec::new();
    clip([0, 1, 2, 3], sides, &|node| TWICE[node as usize], |corners| {
        let [a, b, c, d] = corners.map(place);
        volumes.push(Matrix3::from_columns(&[b - a, c - a, d - a]).determinant() / 6.0);
    });
    volumes
}

#[test]
fn parts_are_positive_and_with_those_outside_fill_the_tetrahedron() {
    let whole = volumes([LevelSetSide::Inside; 4]);
    assert_eq!(whole.len(), 1);
    for sides in combinations() {
        let inside = volumes(sides);
        assert!(inside.iter().all(|volume| *volume > 1e-3), "{sides:?} {inside:?}");
        assert_eq!(inside.is_empty(), !sides.contains(&LevelSetSide::Inside));
        let outside = volumes(sides.map(|side| match side {
            LevelSetSide::Inside => LevelSetSide::Outside,
            LevelSetSide::On => LevelSetSide::On,
            LevelSetSide::Outside => LevelSetSide::Inside,
        }));
        let sum: f64 = inside.iter().chain(&outside).sum();
        let expected = if sides == [LevelSetSide::On; 4] { 0.0 } else { whole[0] };
        assert!((sum - expected).abs() < 1e-14, "{sides:?}: {sum}");
    }
}
