//! Crack points in barycentric coordinates, moved inside their simplices.
//!
//! They are the intersections of bisectors, triple lines and quadruple points with edges, faces and tetrahedra.
//!
//! Based on: Schvartzman & Otaduy, *Fracture Animation Based on High-Dimensional Voronoi Diagrams* (I3D 2014): inside a
//! tetrahedron |X − p_i|² − |X − p_j|² is linear. The margin is ours. The projection onto the simplex, shrunk by the
//! margin, is that of Held, Wolfe & Crowder, *Validation of subgradient optimization* (Mathematical Programming 6,
//! 1974).

use nalgebra::Point3;

/// Smallest barycentric coordinate ε of a crack point on a face or in a tetrahedron.
///
/// On the boundary of their simplices, crack points could coincide.
pub const MARGIN: f64 = 0.02;

/// Smallest local distance of a crack point from the nodes of its edge.
///
/// Large enough for distinct positions in f32, small enough that bisectors stay flat to 1e-5 of the diagonal.
const EDGE_DISTANCE: f64 = 2e-6;

/// Smallest distance of a crack point from the nodes of its edge, over the edge's length.
pub(super) const EDGE_MARGIN: f64 = 1e-4;

/// Largest margin in a short edge, over its length.
const EDGE_MARGIN_MAX: f64 = 0.4;

/// Largest margin in a small face or tetrahedron.
const SIMPLEX_MARGIN_MAX: f64 = 0.2;

/// Smallest barycentric coordinate of a crack point on an edge of the given local length.
///
/// At most [`MARGIN`], except on edges shorter than 100 times the smallest distance, which only the input surface has.
#[inline(always)]
pub fn edge_margin(length: f64) -> f64 {
    (EDGE_DISTANCE / length).clamp(EDGE_MARGIN, EDGE_MARGIN_MAX)
}

/// Smallest barycentric coordinate of a crack point in a face or tetrahedron of the given smallest height, local.
#[inline(always)]
pub fn simplex_margin(height: f64) -> f64 {
    (EDGE_DISTANCE / height).clamp(MARGIN, SIMPLEX_MARGIN_MAX)
}

/// Smallest height of a triangle.
#[inline(always)]
pub fn triangle_height([a, b, c]: [Point3<f64>; 3]) -> f64 {
    let longest = (b - a).norm_squared().max((c - a).norm_squared()).max((c - b).norm_squared()).sqrt();
    (b - a).cross(&(c - a)).norm() / longest
}

/// Smallest height of a tetrahedron.
pub fn smallest_height([a, b, c, d]: &[Point3<f64>; 4]) -> f64 {
    let volume = (b - a).cross(&(c - a)).dot(&(d - a)).abs();
    let area = |p: &Point3<f64>, q: &Point3<f64>, r: &Point3<f64>| (q - p).cross(&(r - p)).norm();
    volume / area(b, c, d).max(area(a, c, d)).max(area(a, b, d)).max(area(a, b, c))
}

/// Smallest height of a tetrahedron, over its longest edge.
pub fn relative_height(corners: &[Point3<f64>; 4]) -> f64 {
    let pairs = (0..4).flat_map(|i| (0..i).map(move |j| (corners[i] - corners[j]).norm()));
    smallest_height(corners) / pairs.fold(0.0, f64::max)
}

/// Relative magnitude below which a determinant counts as zero, over the sum of its terms' magnitudes.
const DEGENERATE: f64 = 1e-9;

/// f_a − f_b at a node with lift coordinates `x`, where f_i(X) = |p_i|² − 2 p_i·X; negative if `a` is nearer.
///
/// Computed without cancellation as Σ_k (p_b − p_a)_k (2 X − p_a − p_b)_k. All slices have the lift's dimension.
#[inline(always)]
pub fn preference(x: &[f64], a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 4];
    let (xs, x_rest) = x.as_chunks::<4>();
    let (aa, a_rest) = a.as_chunks::<4>();
    let (bs, b_rest) = b.as_chunks::<4>();
    for ((x, a), b) in xs.iter().zip(aa).zip(bs) {
        for k in 0..4 {
            lanes[k] += (b[k] - a[k]) * ((x[k] - a[k]) + (x[k] - b[k]));
        }
    }
    let rest: f64 = x_rest.iter().zip(a_rest).zip(b_rest).map(|((x, a), b)| (b - a) * ((x - a) + (x - b))).sum();
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]) + rest
}

/// The zero of a linear function on an edge with end values `h`, as barycentric coordinates of at least `margin`.
///
/// The midpoint if there is no zero.
#[inline(always)]
pub fn on_edge(h: [f64; 2], margin: f64) -> [f64; 2] {
    let t = h[0] / (h[0] - h[1]);
    if !t.is_finite() {
        return [0.5; 2];
    }
    let t = t.clamp(margin, 1.0 - margin);
    [1.0 - t, t]
}

/// The common zero of two linear functions on a triangle, given by their values at its nodes, moved inside the margin.
///
/// The barycenter without a unique zero.
pub fn on_face(h: [[f64; 3]; 2], margin: f64) -> [f64; 3] {
    let minor = |i: usize, j: usize| h[0][i] * h[1][j] - h[0][j] * h[1][i];
    normalized([minor(1, 2), minor(2, 0), minor(0, 1)], margin)
}

/// The common zero of three linear functions on a tetrahedron, given by their values at its nodes, moved inside the
/// margin.
///
/// The barycenter without a unique zero.
pub fn in_tet(h: [[f64; 4]; 3], margin: f64) -> [f64; 4] {
    let minor = |i: usize, j: usize, k: usize| {
        let pair = |p: usize, q: usize| h[1][p] * h[2][q] - h[1][q] * h[2][p];
        h[0][i] * pair(j, k) - h[0][j] * pair(i, k) + h[0][k] * pair(i, j)
    };
    normalized([minor(1, 2, 3), -minor(0, 2, 3), minor(0, 1, 3), -minor(0, 1, 2)], margin)
}

/// Converts homogeneous coordinates to barycentric ones inside the margin.
fn normalized<const N: usize>(homogeneous: [f64; N], margin: f64) -> [f64; N] {
    let sum: f64 = homogeneous.iter().sum();
    let magnitude: f64 = homogeneous.iter().map(|x| x.abs()).sum();
    if sum.is_finite() && sum.abs() > DEGENERATE * magnitude {
        kept_inside(homogeneous.map(|x| x / sum), margin)
    } else {
        [1.0 / N as f64; N]
    }
}

/// The nearest coordinates, in their Euclidean norm, that are all at least `margin`.
///
/// Returns `point` itself, bit for bit, if it is inside. `point` must sum to 1.
pub fn kept_inside<const N: usize>(point: [f64; N], margin: f64) -> [f64; N] {
    if point.iter().all(|&x| x >= margin) {
        return point;
    }
    let free_weight = 1.0 - N as f64 * margin;
    let mut sorted = point.map(|x| x - margin);
    sorted.sort_unstable_by(|a, b| b.total_cmp(a));
    let (mut sum, mut shift) = (0.0, 0.0);
    for (count, &value) in sorted.iter().enumerate() {
        sum += value;
        let candidate = (sum - free_weight) / (count + 1) as f64;
        if value > candidate {
            shift = candidate;
        }
    }
    let mut inside = point.map(|x| (x - margin - shift).max(0.0) + margin);
    let largest = (0..N).fold(0, |best, k| if inside[k] > inside[best] { k } else { best });
    let others: f64 = (0..N).filter(|&k| k != largest).map(|k| inside[k]).sum();
    inside[largest] = 1.0 - others;
    inside
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::RandomStream;

    fn check_inside<const N: usize>(point: [f64; N]) {
        assert!(point.iter().all(|&x| x >= MARGIN), "{point:?}");
        assert!((point.iter().sum::<f64>() - 1.0).abs() < 1e-14, "{point:?}");
    }

    #[test]
    fn zeros_inside_are_exact_and_zeros_outside_are_kept_inside() {
        assert_eq!(on_edge([-1.0, 3.0], MARGIN), [0.75, 0.25]);
        assert_eq!(on_edge([0.0, 3.0], MARGIN), [1.0 - MARGIN, MARGIN]);
        assert_eq!(on_edge([-3.0, 0.0], MARGIN)[1], 1.0 - MARGIN);
        for nowhere in [[0.0, 0.0], [1.0, 1.0], [f64::NAN, 1.0], [f64::INFINITY, 1.0], [f64::INFINITY, f64::INFINITY]] {
            check_inside(on_edge(nowhere, MARGIN));
        }
        assert_eq!(on_face([[0.0; 3]; 2], MARGIN), [1.0 / 3.0; 3]);
        assert_eq!(on_face([[-1.0, 1.0, 0.5], [-1.0, 1.0, 0.5]], MARGIN), [1.0 / 3.0; 3], "parallel bisectors");
        assert_eq!(in_tet([[f64::NAN; 4]; 3], MARGIN), [0.25; 4]);
    }

    #[test]
    fn random_linear_functions_vanish_at_their_common_zero() {
        let mut random = RandomStream::new(3, 0);
        let mut inside = 0;
        for _ in 0..2000 {
            let h: [[f64; 4]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| random.uniform() - 0.5));
            let point = in_tet(h, MARGIN);
            check_inside(point);
            if point.iter().all(|&x| x > MARGIN) {
                inside += 1;
                for row in h {
                    let value: f64 = row.iter().zip(point).map(|(h, x)| h * x).sum();
                    assert!(value.abs() < 1e-13, "{value:e}");
                }
            }
            check_inside(on_face([0, 1].map(|row| [0, 1, 2].map(|k| h[row][k])), MARGIN));
        }
        assert!(inside > 20);
    }

    #[test]
    fn the_kept_point_is_the_nearest() {
        let mut random = RandomStream::new(4, 0);
        for _ in 0..500 {
            let wild: [f64; 3] = std::array::from_fn(|_| 4.0 * random.uniform() - 2.0);
            let wild = [wild[0], wild[1], 1.0 - wild[0] - wild[1]];
            let kept = kept_inside(wild, MARGIN);
            check_inside(kept);
            let apart = |p: [f64; 3]| p.iter().zip(wild).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
            for _ in 0..20 {
                let [u, v] = [random.uniform(), random.uniform()];
                let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
                let other = [u, v, 1.0 - u - v].map(|x| MARGIN + (1.0 - 3.0 * MARGIN) * x);
                assert!(apart(kept) <= apart(other) + 1e-12);
            }
        }
    }

    #[test]
    fn a_far_zero_stays_a_barycentric_point() {
        check_inside(kept_inside([1e9, -1e9 + 0.5, 0.5], MARGIN));
        check_inside(kept_inside([-3e8, 1e8, 1e8, 1e8 + 1.0], MARGIN));
    }

    #[test]
    fn preference_is_the_difference_of_squared_distances() {
        let mut random = RandomStream::new(5, 0);
        for dimension in 3..20 {
            let mut draw = || -> Vec<f64> { (0..dimension).map(|_| random.uniform()).collect() };
            let (x, a, b) = (draw(), draw(), draw());
            let squared = |p: &[f64]| x.iter().zip(p).map(|(x, p)| (x - p) * (x - p)).sum::<f64>();
            assert!((preference(&x, &a, &b) - (squared(&a) - squared(&b))).abs() < 1e-13);
        }
    }
}
