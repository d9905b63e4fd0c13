//! The solids of a surface: which of them holds a point.

use super::Surface;
use super::tree::{BoundingBox, TriangleTree};
use super::winding::WindingMoments;
use nalgebra::Point3;

/// Solids of a surface, one by one.
pub(crate) struct Solids {
    all: Vec<Solid>,
}

/// One solid.
struct Solid {
    bounds: BoundingBox,
    tree: TriangleTree,
    winding: WindingMoments,
}

impl Solids {
    /// The solids of `surface`.
    pub fn of(surface: &Surface) -> Self {
        let mut triangles = vec![Vec::new(); surface.solid_count];
        for (triangle, &solid) in surface.solids.iter().enumerate() {
            triangles[solid as usize].push(surface.corners(triangle));
        }
        let solid = |triangles: Vec<[Point3<f64>; 3]>| {
            let tree = TriangleTree::new(&triangles);
            let winding = WindingMoments::new(&tree, surface.closed);
            Solid { bounds: BoundingBox::of(triangles.iter().flatten()), tree, winding }
        };
        Self { all: triangles.into_iter().map(solid).collect() }
    }

    /// The solid that holds `point`, local: its winding number is the largest there, and above one half.
    pub fn holding(&self, point: &Point3<f64>) -> Option<usize> {
        let near = self.all.iter().enumerate().filter(|(_, solid)| solid.bounds.distance_squared(point) <= 0.0);
        let windings = near.map(|(index, solid)| (index, solid.winding.at(&solid.tree, &[*point])[0]));
        let inside = windings.filter(|(_, winding)| *winding > 0.5);
        inside.reduce(|best, next| if next.1 > best.1 { next } else { best }).map(|(index, _)| index)
    }
}
