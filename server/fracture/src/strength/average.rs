//! Averages of the equivalent stress over the characteristic length.
//!
//! Based on: D. Taylor, *The Theory of Critical Distances* (2007), line method: stress counts as its mean over a line of
//! twice the characteristic length. Here the line is a disc of the boundary with the characteristic length as radius.

use crate::elasticity::BoundaryNodes;
use nalgebra::{Point3, Vector3};

/// Share of the radius within which an average stands for those of all nodes.
const SAME_RADIUS: f64 = 0.25;

/// Difference of values and averages that is rounding, over the greatest value.
const EQUAL: f64 = 1e-9;

/// Averages over discs of a boundary, and their memory.
pub struct SurfaceAverage<'a> {
    boundary: &'a BoundaryNodes,
    normals: &'a [Vector3<f64>],
    /// Radius of the discs, local.
    radius: f64,
    /// Number of the disc that last reached each node; 0: none.
    reached_by: Vec<u32>,
    /// Nodes of the current disc.
    disc: Vec<u32>,
    discs: u32,
    /// True for nodes that a nearby average stands for.
    is_settled: Vec<bool>,
}

impl<'a> SurfaceAverage<'a> {
    /// Averages over discs of `radius` around nodes of `boundary` with these outer `normals`.
    pub fn new(boundary: &'a BoundaryNodes, normals: &'a [Vector3<f64>], radius: f64) -> Self {
        let count = boundary.nodes.len();
        let (reached_by, is_settled) = (vec![0; count], vec![false; count]);
        Self { boundary, normals, radius, reached_by, disc: Vec::new(), discs: 0, is_settled }
    }

    /// The node with the largest average of `values`, and that average; `None` without a node that counts.
    ///
    /// Only nodes with `counts` take part. Where discs hold many nodes, nodes within a quarter of the radius share the
    /// average of the one with the largest value. Of equal averages, the node closest to the middle of the boundary has the
    /// largest, since cracks there divide a body under uniform stress.
    pub fn largest(mut self, values: &[f64], counts: impl Fn(usize) -> bool) -> Option<(usize, f64)> {
        let mut order: Vec<usize> = (0..values.len()).filter(|node| counts(*node)).collect();
        let (middle, greatest) = (self.middle(), values.iter().fold(0.0, |most: f64, value| most.max(value.abs())));
        let off_middle = |node: usize| (self.boundary.positions[node] - middle).norm();
        // Rounded, so that nodes of equal values are ordered by their distance.
        let rounded = |node: usize| (values[node] / greatest / EQUAL).round();
        order.sort_by(|a, b| {
            let by_distance = || off_middle(*a).total_cmp(&off_middle(*b)).then(a.cmp(b));
            rounded(*b).total_cmp(&rounded(*a)).then_with(by_distance)
        });
        let mut best: Option<(usize, f64)> = None;
        for node in order {
            // No average exceeds the largest value that is left.
            if best.is_some_and(|(_, average)| values[node] < average - EQUAL * greatest) {
                break;
            }
            if !self.is_settled[node] {
                let average = self.around(node, values, &counts);
                let is_better = best.is_none_or(|(other, most)| {
                    let is_equal = (average - most).abs() <= EQUAL * greatest;
                    if is_equal { off_middle(node) < off_middle(other) } else { average > most }
                });
                best = if is_better { Some((node, average)) } else { best };
            }
        }
        best
    }

    /// Middle of the boundary, by area.
    fn middle(&self) -> Point3<f64> {
        let BoundaryNodes { positions, areas, .. } = self.boundary;
        let moment: Vector3<f64> = positions.iter().zip(areas).map(|(place, area)| place.coords * *area).sum();
        Point3::from(moment / areas.iter().sum::<f64>())
    }

    /// Mean of `values` over the disc around `node`, by area.
    ///
    /// The disc is the connected part of the boundary within the radius that faces the same way as the node, so that the
    /// other side of a thin wall does not count.
    fn around(&mut self, node: usize, values: &[f64], counts: &impl Fn(usize) -> bool) -> f64 {
        let BoundaryNodes { positions, areas, faces, .. } = self.boundary;
        self.discs += 1;
        self.disc.clear();
        self.disc.push(node as u32);
        self.reached_by[node] = self.discs;
        let (mut sum, mut area, mut next) = (0.0, 0.0, 0);
        while let Some(&own) = self.disc.get(next) {
            next += 1;
            sum += areas[own as usize] * values[own as usize];
            area += areas[own as usize];
            if (positions[own as usize] - positions[node]).norm() <= SAME_RADIUS * self.radius {
                self.is_settled[own as usize] = true;
            }
            for &other in self.boundary.around(own).iter().flat_map(|face| &faces[*face as usize]) {
                let index = other as usize;
                let is_new = self.reached_by[index] != self.discs && counts(index);
                if is_new
                    && (positions[index] - positions[node]).norm() <= self.radius
                    && self.normals[index].dot(&self.normals[node]) > 0.0
                {
                    self.reached_by[index] = self.discs;
                    self.disc.push(other);
                }
            }
        }
        sum / area
    }
}

/// Outer unit normals of boundary nodes: the mean of those of the faces around them, by area.
pub fn node_normals(boundary: &BoundaryNodes) -> Vec<Vector3<f64>> {
    let mut normals = vec![Vector3::zeros(); boundary.nodes.len()];
    for face in &boundary.faces {
        let [a, b, c] = face.map(|node| boundary.positions[node as usize]);
        let area = (b - a).cross(&(c - a));
        face.iter().for_each(|node| normals[*node as usize] += area);
    }
    normals.into_iter().map(|normal| normal.try_normalize(0.0).unwrap_or_default()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::block;

    #[test]
    fn a_peak_counts_by_its_mean_over_a_disc_of_one_face() {
        let boundary = BoundaryNodes::new(&block([16, 16, 1], 1.0 / 16.0));
        let normals = node_normals(&boundary);
        let [top, middle] = [1.0 / 32.0, 0.0];
        // 1 − 2ρ on the top face, 0 on the bottom face.
        let value = |point: &Point3<f64>| {
            let distance = (point.x - middle).hypot(point.y - middle);
            if point.z == top { 1.0 - 2.0 * distance } else { 0.0 }
        };
        let values: Vec<f64> = boundary.positions.iter().map(value).collect();
        for radius in [0.2, 0.4] {
            let (node, found) = SurfaceAverage::new(&boundary, &normals, radius).largest(&values, |_| true).unwrap();
            let exact = 1.0 - 4.0 / 3.0 * radius;
            assert!((found - exact).abs() < 0.03, "{found} for {exact}");
            assert_eq!(boundary.positions[node].z, top);
        }
        let none = SurfaceAverage::new(&boundary, &normals, 0.1).largest(&values, |_| false);
        assert_eq!(none, None);
    }

    #[test]
    fn uniform_values_keep_their_value() {
        let boundary = BoundaryNodes::new(&block([4, 4, 4], 0.25));
        let normals = node_normals(&boundary);
        let values = vec![3.0; boundary.nodes.len()];
        for radius in [0.01, 0.3, 10.0] {
            let (node, found) = SurfaceAverage::new(&boundary, &normals, radius).largest(&values, |_| true).unwrap();
            assert!((found - 3.0).abs() < 1e-12);
            // The middle of a face.
            assert!(boundary.positions[node].coords.norm() < 0.51);
        }
    }
}
