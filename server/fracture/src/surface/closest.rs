//! Closest triangle of a triangle soup, by best-first descent of its bounding-box hierarchy.

use super::tree::{STACK, TriangleTree};
use crate::triangle::closest_point;
use nalgebra::Point3;

/// Squared distance from `point` to the nearest triangle, and the index of that triangle in the list
/// that the tree was built from.
///
/// Returns (∞, 0) if the tree is empty.
pub(super) fn nearest(tree: &TriangleTree, point: &Point3<f64>) -> (f64, u32) {
    let mut best = (f64::INFINITY, 0);
    if tree.nodes.is_empty() {
        return best;
    }
    let mut stack = [(0.0, 0u32); STACK];
    let mut top = 1;
    while top > 0 {
        top -= 1;
        let (bound, index) = stack[top];
        if bound >= best.0 {
            continue;
        }
        let node = &tree.nodes[index as usize];
        if node.is_leaf() {
            for place in node.range() {
                let distance_squared = (closest_point(&tree.triangles[place], point) - point).norm_squared();
                if distance_squared < best.0 {
                    best = (distance_squared, tree.order[place]);
                }
            }
            continue;
        }
        let left = (tree.nodes[index as usize + 1].bounds.distance_squared(point), index + 1);
        let right = (tree.nodes[node.right as usize].bounds.distance_squared(point), node.right);
        let (nearer, further) = if left.0 <= right.0 { (left, right) } else { (right, left) };
        for child in [further, nearer] {
            if child.0 < best.0 {
                stack[top] = child;
                top += 1;
            }
        }
    }
    best
}
