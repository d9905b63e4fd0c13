//! Steps of a bake, and what the rest of it will take once its lattices are known.

use super::{BakeRequest, lost_parts};
use crate::lattice::Lattice;
use crate::pipeline::{BakeParameters, ElasticModel};
use crate::surface::Surface;

/// What baking does, in order; the caller may show it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BakeStep {
    /// Welding, orienting, naming defects.
    Surface,
    /// Winding numbers and the volume that they enclose.
    Volume,
    /// Both lattices and the operator between them.
    Lattices,
    /// The lattices are there: how large they are. Nothing begins with it.
    Sized(BakeSize),
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
/// Calibrated on generated shapes in `draft` and `game` (dumbbell, arch, horseshoe, mug, statue, vase: 1 500 to 58 900 elastic and 3 000
/// to 58 900 crack nodes) and on the mug with 24 and 100 examples. Processor times are of one core of an AMD EPYC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BakeSize {
    /// Nodes of all elastic lattices; 0: no elasticity is prepared.
    pub elastic_nodes: usize,
    /// Nodes of all crack lattices.
    pub crack_nodes: usize,
    /// Impacts to learn from.
    pub examples: u64,
    /// Bytes of the factors, in the precision that was asked for: balls have three times as many as rods of as many nodes.
    pub factor_bytes: u64,
    /// Triangles that show the input; 0: none are kept.
    pub skin_triangles: usize,
}

/// Crack nodes to which times are given.
const CRACK_NODES: f64 = 9_576.0;

/// Seconds of one core for the lifts and the calibration of so many crack nodes, and for one example there.
const CRACK_S: [f64; 2] = [1.7, 0.33];

/// Elastic nodes to which time and memory are given, and seconds of one core to factor and solve them.
const ELASTIC: [f64; 2] = [58_868.0, 12.0];

/// Bytes that an object holds per crack node, per elastic node beside the factor, and per triangle of its skin.
const HELD: [f64; 3] = [1_810.0, 1_490.0, 72.0];

/// Triangles of a skin per square of the crack spacing, beside those of the mesh.
const SKIN_DENSITY: f64 = 6.0;

/// A bake holds so many bytes, and so many times those of the object, at its peak.
const PEAK: [f64; 2] = [30e6, 1.85];

impl BakeSize {
    /// That of these bodies.
    pub(super) fn of(
        bodies: &[(Lattice, Option<ElasticModel>)],
        surface: &Surface,
        parameters: &BakeParameters,
        request: &BakeRequest,
    ) -> Self {
        let solids = || bodies.iter().filter_map(|(_, solid)| solid.as_ref());
        let spacings = lost_parts::area(surface) / parameters.crack_spacing.powi(2);
        let triangles = surface.triangles.len().max((SKIN_DENSITY * spacings) as usize);
        Self {
            elastic_nodes: solids().map(|solid| solid.lattice.nodes.len()).sum(),
            crack_nodes: bodies.iter().map(|(crack, _)| crack.nodes.len()).sum(),
            examples: request.examples,
            factor_bytes: solids().map(|solid| solid.elasticity.factor_bytes() as u64).sum(),
            skin_triangles: if request.tables().skin { triangles } else { 0 },
        }
    }

    /// Seconds that the rest of the bake keeps one core busy, approximately; most of it runs on all cores.
    pub fn core_seconds(&self) -> f64 {
        let crack = self.crack_nodes as f64 / CRACK_NODES;
        let elastic = (self.elastic_nodes as f64 / ELASTIC[0]).powi(2) * ELASTIC[1];
        elastic + crack * (CRACK_S[0] + CRACK_S[1] * self.examples as f64)
    }

    /// Bytes that a daemon will hold for the object, approximately.
    pub fn held_bytes(&self) -> u64 {
        let [crack, elastic, triangle] = HELD;
        let nodes = crack * self.crack_nodes as f64 + elastic * self.elastic_nodes as f64;
        self.factor_bytes + (nodes + triangle * self.skin_triangles as f64) as u64
    }

    /// Bytes that the bake holds at its peak, approximately.
    pub fn peak_bytes(&self) -> u64 {
        (PEAK[0] + PEAK[1] * self.held_bytes() as f64) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cancel_token::CancelToken;
    use crate::database::bake;
    use crate::pipeline::Preset;
    use crate::scene::Materials;
    use crate::surface::shapes;

    const MUG: BakeSize = BakeSize {
        elastic_nodes: 4_645,
        crack_nodes: 9_576,
        examples: 0,
        factor_bytes: 27_200_000,
        skin_triangles: 130_196,
    };

    #[test]
    fn the_peak_is_near_what_was_measured() {
        let peak = MUG.peak_bytes() as f64 / 139e6;
        assert!((0.9..1.2).contains(&peak), "{peak}");
    }

    #[test]
    fn what_is_asked_for_costs_more() {
        let learning = BakeSize { examples: 100, ..MUG };
        assert!(learning.core_seconds() > 10.0 * MUG.core_seconds());
        let hollow = BakeSize { elastic_nodes: 0, factor_bytes: 0, ..MUG };
        assert!(hollow.held_bytes() < hollow.peak_bytes() && hollow.core_seconds() < MUG.core_seconds());
    }

    #[test]
    fn what_a_daemon_will_hold_is_near_what_it_holds() {
        let materials = Materials::parse(crate::scene::MATERIALS).unwrap();
        for (shape, quality) in [
            ("arch", Preset::Draft),
            ("dumbbell", Preset::Draft),
            ("horseshoe", Preset::Draft),
            ("arch", Preset::Game),
            ("dumbbell", Preset::Game),
            ("horseshoe", Preset::Game),
            ("mug", Preset::Game),
            ("statue", Preset::Game),
        ] {
            let glass = materials.get("glass").unwrap().clone();
            let request = BakeRequest { quality, kappa: Some(2.0), ..BakeRequest::new(shape, "glass", glass) };
            let mut told = 0;
            let mut hear = |step| {
                if let BakeStep::Sized(size) = step {
                    told = size.held_bytes();
                }
            };
            let prepared = bake(shapes::by_name(shape).unwrap(), &request, &CancelToken::default(), &mut hear).unwrap();
            let ratio = told as f64 / prepared.bytes() as f64;
            println!("{shape} {}: {told} bytes told, {ratio:.3} of those held", quality.name());
            assert!((0.9..1.1).contains(&ratio), "{shape} {}: {ratio}", quality.name());
        }
    }
}
