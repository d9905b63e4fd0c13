//! First-moment bound: the largest E_1 per unit of energy, for any distribution of the energy in the body.
//!
//! Based on: M. Bădoiu & K. L. Clarkson, *Smaller core-sets for balls* (SODA 2003), for a center close to all points.
//! The bound is ours.
//!
//! E_1 = Σ w_v q_v(c), where
//!
//! - w_v is the energy of node v, raised to the smallest value of a field ([`FLOOR`]);
//! - q_v(p) = |X_v − p|² + 2 b_v·(X_v − p) + m_v is the mean of |X − p|² over node v's cell;
//! - c is the center of energy.
//!
//! As a function of p, the sum Σ w_v q_v(p) is least at c, where its gradient −2 Σ w_v (X_v + b_v − p) vanishes. Let U
//! be the energy before it was raised. Then for every p
//!
//! E_1 ≤ Σ w_v q_v(p) ≤ Σ w_v · max q_v(p) ≤ (1 + [`FLOOR`]) U · max q_v(p),
//!
//! because no w_v is raised by more than [`FLOOR`] times the mean density times the node's volume.

use crate::centroidal::FLOOR;
use crate::lift::LiftedLattice;
use std::ops::RangeInclusive;

/// Number of steps of the center. The largest q_v is then within a few percent of its minimum.
const STEPS: usize = 64;

/// Number of steps in the check of a stored bound.
const CHECK_STEPS: usize = 8;

/// Relative rounding error allowed between a bound and its range.
const CHECK_TOLERANCE: f64 = 1e-6;

/// (1 + FLOOR) · max q_v(p) about a nearly optimal p, local length squared. E_1 of a body is at most this times its
/// energy.
pub fn reach(lift: &LiftedLattice) -> f64 {
    (1.0 + FLOOR) * *enclosed(lift, STEPS).end()
}

/// A range that contains [`reach`], computed in a fraction of its time, to check stored values.
///
/// The lower end is the mean of q_v over the nodes that were farthest, about the center where that mean is least; no
/// center has a smaller maximum. The upper end follows from the first steps of [`reach`].
pub fn reach_range(lift: &LiftedLattice) -> RangeInclusive<f64> {
    let all = enclosed(lift, CHECK_STEPS);
    (1.0 - CHECK_TOLERANCE) * (1.0 + FLOOR) * all.start()..=(1.0 + CHECK_TOLERANCE) * (1.0 + FLOOR) * all.end()
}

/// Lower and upper bound of the minimum over p of max q_v(p), after this many steps.
fn enclosed(lift: &LiftedLattice, steps: usize) -> RangeInclusive<f64> {
    let m = lift.dimension;
    let offset = |node: usize| &lift.first_moment[node * m..][..m];
    let mut center = vec![0.0; m];
    let nodes = lift.second_moment.len();
    for node in 0..nodes {
        center.iter_mut().zip(lift.at(node)).for_each(|(sum, x)| *sum += x / nodes as f64);
    }
    let mut least = f64::INFINITY;
    let (mut farthest, mut moments) = (vec![0.0; m], 0.0);
    for step in 1..=steps {
        let square = |node: usize| {
            let sum =
                lift.at(node).iter().zip(offset(node)).zip(&center).map(|((x, b), p)| (x - p) * (x - p + 2.0 * b));
            sum.sum::<f64>() + lift.second_moment[node]
        };
        let farther = |best: (usize, f64), next: (usize, f64)| if next.1 > best.1 { next } else { best };
        let (node, most) = (0..nodes).map(|node| (node, square(node))).fold((0, 0.0), farther);
        least = least.min(most);
        let towards = lift.at(node).iter().zip(offset(node)).map(|(x, b)| x + b);
        moments += lift.at(node).iter().zip(offset(node)).map(|(x, b)| x * (x + 2.0 * b)).sum::<f64>();
        moments += lift.second_moment[node];
        for ((p, sum), x) in center.iter_mut().zip(&mut farthest).zip(towards) {
            *p += (x - *p) / (step + 1) as f64;
            *sum += x;
        }
    }
    let count = steps as f64;
    let square = farthest.iter().map(|sum| (sum / count).powi(2)).sum::<f64>();
    moments / count - square..=least
}
