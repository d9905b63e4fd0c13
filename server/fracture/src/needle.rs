//! Division of needle-shaped triangles: as strips between their divided edges.
//!
//! Ours. Repeated halving of the edges of a needle triples its triangles per pass, because each cut makes a new long edge.
//! A strip has about as many triangles as the divided edges have parts.

use nalgebra::Point3;

/// Least length of the longest edge of a needle, relative to its height. Halving makes fewer triangles of others.
const ASPECT_MIN: f64 = 8.0;
/// Least length of the longest edge of a needle, relative to the longest edge wanted.
const LENGTH_MIN: f64 = 4.0;
/// Passes in which needles are divided. A strip of needles needs another pass.
pub(crate) const PASSES_MAX: usize = 8;

/// Returns true if strips divide a triangle into edges of at most `length_max` better than halving does.
pub(crate) fn is_needle(corners: &[Point3<f64>; 3], length_max: f64) -> bool {
    let [a, b, c] = corners;
    let longest = edge_lengths(corners).into_iter().fold(0.0, f64::max);
    let height = (b - a).cross(&(c - a)).norm() / longest;
    longest > LENGTH_MIN * length_max && longest > ASPECT_MIN * height
}

/// Corner at which the longest edge of a triangle begins. Of equal edges the first.
pub(crate) fn longest_edge_start(corners: &[Point3<f64>; 3]) -> usize {
    let lengths = edge_lengths(corners);
    (1..3).fold(0, |best, k| if lengths[k] > lengths[best] { k } else { best })
}

fn edge_lengths([a, b, c]: &[Point3<f64>; 3]) -> [f64; 3] {
    [(b - a).norm(), (c - b).norm(), (a - c).norm()]
}

/// Divides a triangle with points on its edges into triangles without other points.
///
/// `outline` holds the corners and the points on the edges, counter-clockwise. It begins with the longest edge, whose
/// other end is at index `end`. The triangles are indices into `outline`, counter-clockwise.
pub(crate) fn strip(outline: &[Point3<f64>], end: usize) -> Vec<[usize; 3]> {
    let count = outline.len();
    // The other two edges, from the start of the longest edge to its end.
    let upper = |j: usize| (count - j) % count;
    let upper_end = count - end;
    let mut triangles = vec![[0, 1, upper(1)]];
    let (mut i, mut j) = (1, 1);
    while i + 1 < end || j + 1 < upper_end {
        // No triangle lies within an edge: both chains reach their common end with the last triangle.
        let is_lower = j + 1 == upper_end
            || i + 1 < end && {
                let [lower, higher] = [[i + 1, upper(j)], [i, upper(j + 1)]];
                let [lower, higher] = [lower, higher].map(|[p, q]| (outline[p] - outline[q]).norm_squared());
                lower <= higher
            };
        if is_lower {
            triangles.push([i, i + 1, upper(j)]);
            i += 1;
        } else {
            triangles.push([i, upper(j + 1), upper(j)]);
            j += 1;
        }
    }
    triangles.push([i, end, upper(j)]);
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// Corners and points on the edges that divide them into that many parts.
    fn outline(corners: [[f64; 2]; 3], parts: [usize; 3]) -> Vec<Point3<f64>> {
        let at = corners.map(|[x, y]| Point3::new(x, y, 0.0));
        let edge = |k: usize| {
            let [from, to] = [at[k], at[(k + 1) % 3]];
            (0..parts[k]).map(move |part| from + (to - from) * (part as f64 / parts[k] as f64))
        };
        (0..3).flat_map(edge).collect()
    }

    #[test]
    fn strips_tile_a_needle_without_other_points() {
        let needles = [
            [[0.0, 0.0], [1.0, 0.0], [1.0, 0.01]],
            [[0.0, 0.0], [1.0, 0.0], [0.0, 0.01]],
            [[0.0, 0.0], [1.0, 0.0], [0.3, 0.001]],
        ];
        for corners in needles {
            for parts in [[64, 32, 1], [64, 1, 64], [8, 4, 8], [2, 1, 1], [16, 16, 16]] {
                let points = outline(corners, parts);
                let triangles = strip(&points, parts[0]);
                assert_eq!(triangles.len(), points.len() - 2);
                let double = |&[p, q, r]: &[usize; 3]| {
                    (points[q] - points[p]).cross(&(points[r] - points[p])).dot(&Vector3::z())
                };
                assert!(triangles.iter().all(|own| double(own) > 0.0), "{corners:?} {parts:?}");
                let [whole, sum] = [corners[2][1], triangles.iter().map(double).sum()];
                assert!((sum - whole).abs() < 1e-12 * whole.max(1e-3), "{sum} of {whole}");
            }
        }
    }

    #[test]
    fn only_long_thin_triangles_are_needles() {
        let triangle = |width: f64| [Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(1.0, width, 0.0)];
        assert!(is_needle(&triangle(0.01), 0.1));
        assert!(!is_needle(&triangle(0.2), 0.1), "not thin");
        assert!(!is_needle(&triangle(0.01), 0.3), "hardly divided");
        assert_eq!(longest_edge_start(&triangle(0.01)), 2);
    }
}
