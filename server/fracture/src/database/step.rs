//! Steps of a bake, and what the rest of it will take once its lattices are known.

use super::BakeRequest;
use crate::lattice::Levels;
use crate::sparse::Precision;

/// What baking does, in order; the caller may show it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Welding, orienting, naming defects.
    Surface,
    /// Winding numbers and the volume that they enclose.
    Volume,
    /// Both lattices and the operator between them.
    Lattices,
    /// The lattices are there: how large they are. Nothing begins with it.
    Sized(Size),
    /// Eigenpairs of body `0`.
    Lift(usize),
    /// Stiffness and factor of body `0`.
    Elasticity(usize),
    /// Reduced elastic bases from the examples' impacts.
    Reduction,
    /// κ, from sampled impacts.
    Calibration,
    /// Examples, and what is learned from them.
    Examples {
        /// Impacts that are done.
        done: u64,
        /// All of them.
        of: u64,
    },
}

/// How large a bake is, from which its cost follows, approximately.
///
/// Calibrated on generated shapes (horseshoe, arch, statue, mug, vase: 3 100 to 58 900 elastic and 9 000 to 58 900 crack nodes) and on
/// the mug with 24 and 100 examples. Processor times are of one core of an AMD EPYC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Nodes of all elastic lattices; 0: no elasticity is prepared.
    pub elastic_nodes: usize,
    /// Nodes of all crack lattices.
    pub crack_nodes: usize,
    /// Impacts to learn from.
    pub examples: u64,
    /// Precision of the factor that was asked for.
    pub factor: Precision,
}

/// Crack nodes to which times are given.
const CRACK_NODES: f64 = 9_576.0;

/// Seconds of one core for the lifts and the calibration of so many crack nodes, and for one example there.
const CRACK_S: [f64; 2] = [1.7, 0.33];

/// Elastic nodes to which time and memory are given, and seconds of one core to factor and solve them.
const ELASTIC: [f64; 2] = [58_868.0, 12.0];

/// Bytes that an object holds per crack node, and per elastic node of 4 500. The latter grow with the nodes, to this power: the factor
/// fills in.
const HELD: [f64; 3] = [1_900.0, 6_350.0, 0.29];

/// What a factor in single precision leaves of the bytes per elastic node.
const SINGLE: f64 = 0.6;

/// A bake holds so many bytes, and so many times those of the object, at its peak.
const PEAK: [f64; 2] = [30e6, 2.05];

impl Size {
    /// That of these lattices.
    pub(super) fn of(levels: &Levels, request: &BakeRequest) -> Self {
        let elastic = request.tables().elastic;
        let nodes = levels.bodies.iter().map(|body| [body.elastic.nodes.len(), body.crack.nodes.len()]);
        let [elastic_nodes, crack_nodes] = nodes.fold([0; 2], |sum, own| [sum[0] + own[0], sum[1] + own[1]]);
        let elastic_nodes = if elastic { elastic_nodes } else { 0 };
        Self { elastic_nodes, crack_nodes, examples: request.examples, factor: request.factor }
    }

    /// Seconds that the rest of the bake keeps one core busy, approximately; most of it runs on all cores.
    pub fn core_seconds(&self) -> f64 {
        let crack = self.crack_nodes as f64 / CRACK_NODES;
        let elastic = (self.elastic_nodes as f64 / ELASTIC[0]).powi(2) * ELASTIC[1];
        elastic + crack * (CRACK_S[0] + CRACK_S[1] * self.examples as f64)
    }

    /// Bytes that whoever serves the object will hold, approximately.
    pub fn held_bytes(&self) -> u64 {
        let [crack, elastic, fill] = HELD;
        let nodes = self.elastic_nodes as f64;
        let precision = if self.factor == Precision::F32 { SINGLE } else { 1.0 };
        let elastic = precision * elastic * nodes * (nodes / 4_500.0).powf(fill);
        (crack * self.crack_nodes as f64 + elastic) as u64
    }

    /// Bytes that the bake holds at its peak, approximately.
    pub fn peak_bytes(&self) -> u64 {
        (PEAK[0] + PEAK[1] * self.held_bytes() as f64) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check([elastic_nodes, crack_nodes]: [usize; 2], held: f64, peak: f64) {
        let size = Size { elastic_nodes, crack_nodes, examples: 0, factor: Precision::F64 };
        let near = |found: u64, measured: f64| (0.7..1.5).contains(&(found as f64 / measured));
        assert!(near(size.held_bytes(), held), "{} bytes held, {held} measured", size.held_bytes());
        assert!(near(size.peak_bytes(), peak), "{} bytes at the peak, {peak} measured", size.peak_bytes());
    }

    #[test]
    fn memory_is_near_what_was_measured() {
        check([4_645, 9_576], 48.3e6, 139e6);
        check([4_356, 9_340], 44.9e6, 114e6);
        check([58_868, 58_868], 885e6, 1_831e6);
    }

    #[test]
    fn what_is_asked_for_costs_more() {
        let size = |elastic_nodes, examples, factor| Size { elastic_nodes, crack_nodes: 9_000, examples, factor };
        let plain = size(3_000, 0, Precision::F64);
        assert!(size(3_000, 100, Precision::F64).core_seconds() > 10.0 * plain.core_seconds());
        assert!(size(3_000, 0, Precision::F32).held_bytes() < plain.held_bytes());
        assert!(size(0, 0, Precision::F64).held_bytes() < size(0, 0, Precision::F64).peak_bytes());
        assert!(size(0, 0, Precision::F64).core_seconds() < plain.core_seconds());
    }
}
