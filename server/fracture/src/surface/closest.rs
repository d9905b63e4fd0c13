//! The closest point of a triangle soup.
//!
//! Based on: C. Ericson, *Real-time collision detection* (2005), section 5.1.5 (closest point on a triangle), and a
//! best-first descent of the bounding-box hierarchy.

use super::tree::{STACK, TriangleTree};
use nalgebra::Point3;

/// The squared distance from `point` to the nearest of the tree's triangles and that triangle's place in the list the
/// tree was built from; infinite and 0 without triangles.
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
                let distance_squared = (closest_on(&tree.triangles[place], point) - point).norm_squared();
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

/// The point of a triangle closest to `point`; triangles without area are served by their edges.
pub(super) fn closest_on([a, b, c]: &[Point3<f64>; 3], point: &Point3<f64>) -> Point3<f64> {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return *a;
    }
    let bp = point - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return *b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = point - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return *c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let sum = va + vb + vc;
    a + ab * (vb / sum) + ac * (vc / sum)
}
