//! Metric g = JᵀJ of a lift: its scale, and the moments of each node's cell.

use super::LiftedLattice;
use crate::lattice::Lattice;
use nalgebra::Matrix3;
use rayon::prelude::*;

/// Metric g = JᵀJ on tetrahedron `tet`, with J the m × 3 gradient of X; 3 × 3, dimensionless.
///
/// The identity for a tetrahedron without volume.
pub fn metric(lift: &LiftedLattice, lattice: &Lattice, tet: usize) -> Matrix3<f64> {
    let nodes = lattice.tets[tet];
    let Some(inverse) = lattice.edge_matrix(tet).try_inverse() else { return Matrix3::identity() };
    let base = lift.at(nodes[0] as usize);
    let mut gram = Matrix3::zeros();
    for (i, &a) in nodes[1..].iter().enumerate() {
        for (j, &b) in nodes[1..].iter().enumerate() {
            let (xa, xb) = (lift.at(a as usize), lift.at(b as usize));
            gram[(i, j)] = (0..lift.dimension).map(|k| (xa[k] - base[k]) * (xb[k] - base[k])).sum();
        }
    }
    inverse.transpose() * gram * inverse
}

/// (det g)^(1/5) per tetrahedron, the factor of the optimal site density in three dimensions.
///
/// √det g is computed as the volume that the lifted edges span over that of the edges. The determinant of the computed
/// g is noise if σ₂σ₃ < 10⁻⁸ σ₁².
fn densities(lift: &LiftedLattice, lattice: &Lattice) -> Vec<f64> {
    let density = |edges: &mut Vec<f64>, tet| {
        let volume = lattice.edge_matrix(tet).determinant().abs();
        if volume > 0.0 { (lifted_volume(lift, lattice.tets[tet], edges) / volume).powf(0.4) } else { 1.0 }
    };
    (0..lattice.tets.len()).into_par_iter().map_init(Vec::new, density).collect()
}

/// Volume of the parallelepiped in R^m that the lifted edges from the first node span.
///
/// Gram–Schmidt runs twice; the second pass removes the rounding error of the first. `edges` is scratch memory.
fn lifted_volume(lift: &LiftedLattice, nodes: [u32; 4], edges: &mut Vec<f64>) -> f64 {
    let [base, ends @ ..] = nodes.map(|node| lift.at(node as usize));
    edges.clear();
    let mut volume = 1.0;
    for end in ends {
        let start = edges.len();
        edges.extend(end.iter().zip(base).map(|(x, y)| x - y));
        let (units, edge) = edges.split_at_mut(start);
        for unit in units.chunks_exact(lift.dimension).chain(units.chunks_exact(lift.dimension)) {
            let along: f64 = unit.iter().zip(edge.iter()).map(|(x, y)| x * y).sum();
            edge.iter_mut().zip(unit).for_each(|(x, y)| *x -= along * y);
        }
        let length = edge.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length == 0.0 {
            return 0.0;
        }
        volume *= length;
        edge.iter_mut().for_each(|x| *x /= length);
    }
    volume
}

/// Scales X so that the volume mean of (det g)^(1/5) is 1. det g grows with the sixth power of the scale.
pub fn scale(lift: &mut LiftedLattice, lattice: &Lattice) {
    let (mut sum, mut volume) = (0.0, 0.0);
    for (tet, density) in densities(lift, lattice).iter().enumerate() {
        let tet_volume = lattice.tet_volume(tet);
        sum += tet_volume * density;
        volume += tet_volume;
    }
    let factor = (sum / volume).powf(-5.0 / 6.0);
    if factor != 1.0 && factor.is_finite() {
        lift.coordinates.iter_mut().for_each(|x| *x *= factor);
    }
}

/// Fills `first_moment`, `second_moment` and `density`, cell by cell.
///
/// A node's barycentric cell in a tetrahedron (a, b, c, d) consists of six small tetrahedra at a. Each is spanned by an
/// edge midpoint, a face centroid and the tetrahedron's centroid, and has volume V/24, V that of the tetrahedron. Their
/// common centroid lies 23/144 of the three edges' sum from a. [`corner_moment`] yields their second moment from the
/// lengths of the edges.
pub fn measure(lift: &mut LiftedLattice, lattice: &Lattice) {
    let densities = densities(lift, lattice);
    let count = lattice.nodes.len();
    let mut moment = vec![0.0; count];
    let mut weighted = vec![0.0; count];
    let mut offset = vec![0.0; count * lift.dimension];
    let mut sum = vec![0.0; lift.dimension];
    for (tet, nodes) in lattice.tets.iter().enumerate() {
        let volume = lattice.tet_volume(tet);
        let corners = nodes.map(|node| lift.at(node as usize));
        for (axis, sum) in sum.iter_mut().enumerate() {
            *sum = corners.iter().map(|corner| corner[axis]).sum();
        }
        let squares = squares(&corners);
        for (corner, &node) in nodes.iter().enumerate() {
            let own = node as usize;
            let offset = &mut offset[own * lift.dimension..][..lift.dimension];
            for ((offset, sum), x) in offset.iter_mut().zip(&sum).zip(corners[corner]) {
                *offset += volume / 4.0 * (23.0 / 144.0) * (sum - 4.0 * x);
            }
            moment[own] += volume / 24.0 * corner_moment(&squares, corner);
            weighted[own] += volume / 4.0 * densities[tet];
        }
    }
    let volumes = lattice.node_volumes();
    for (offset, volume) in offset.chunks_exact_mut(lift.dimension).zip(&volumes) {
        offset.iter_mut().for_each(|sum| *sum /= volume);
    }
    lift.first_moment = offset;
    lift.second_moment = moment.iter().zip(&volumes).map(|(sum, volume)| sum / volume).collect();
    lift.density = weighted.iter().zip(&volumes).map(|(sum, volume)| sum / volume).collect();
}

/// Squared distances between the four corners of a lifted tetrahedron.
fn squares(corners: &[&[f64]; 4]) -> [[f64; 4]; 4] {
    let mut squares = [[0.0; 4]; 4];
    for (i, j) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
        let square = corners[i].iter().zip(corners[j]).map(|(x, y)| (x - y) * (x - y)).sum();
        (squares[i][j], squares[j][i]) = (square, square);
    }
    squares
}

/// Sum over the six small tetrahedra at a corner of the mean of |X − X_corner|², from the squared lengths of the edges.
///
/// With corner vectors u, v, w from X_corner the mean over one is (|u|² + |v|² + |w|² + |u+v+w|²)/20. With u = e_i/2, v
/// = (e_i + e_j)/3, w = (e_1 + e_2 + e_3)/4 the six sum to (161 Σ|e_i|² + 194 Σ e_i·e_j)/720 over edges and pairs of
/// them, and 2 e_i·e_j = |e_i|² + |e_j|² − |e_i − e_j|².
fn corner_moment(squares: &[[f64; 4]; 4], corner: usize) -> f64 {
    let [i, j, k] = [1, 2, 3].map(|step| (corner + step) % 4);
    let own: f64 = [i, j, k].iter().map(|&other| squares[corner][other]).sum();
    let opposite = squares[i][j] + squares[j][k] + squares[k][i];
    (355.0 * own - 97.0 * opposite) / 720.0
}

#[cfg(test)]
mod tests {
    use crate::lattice::block;
    use crate::lift::LiftedLattice;

    #[test]
    fn the_euclidean_lift_of_a_box_has_the_moments_of_its_cells() {
        let lattice = block([2, 2, 2], 0.25);
        let lift = LiftedLattice::euclidean(&lattice);
        assert!((lift.at(5)[1] - lattice.nodes[5].y).abs() < 1e-15, "scale 1");
        assert!(lift.density.iter().all(|density| (density - 1.0).abs() < 1e-12));
        // Over all cells, Σ V_v m_v is positive and at most V·h².
        let total: f64 = lattice.node_volumes().iter().zip(&lift.second_moment).map(|(v, m)| v * m).sum();
        assert!(total > 0.0 && total < lattice.volume() * 0.25 * 0.25);
    }

    #[test]
    fn moments_of_the_cells_add_up_to_those_of_the_box() {
        let lattice = block([3, 2, 4], 0.25);
        let lift = LiftedLattice::euclidean(&lattice);
        let size: [f64; 3] = [0.75, 0.5, 1.0];
        // ∫|x|² over a centered box is V·Σ size²/12 for any spacing, if both moments of every cell are counted.
        let mut sum = 0.0;
        for (node, volume) in lattice.node_volumes().iter().enumerate() {
            let (place, offset) = (lift.at(node), &lift.first_moment[3 * node..][..3]);
            let square: f64 = place.iter().map(|x| x * x).sum();
            let cross: f64 = place.iter().zip(offset).map(|(x, b)| x * b).sum();
            sum += volume * (square + 2.0 * cross + lift.second_moment[node]);
        }
        let exact = lattice.volume() * size.iter().map(|size| size * size).sum::<f64>() / 12.0;
        assert!((sum - exact).abs() < 1e-14, "{sum} {exact}");
    }
}
