//! An anchored object: nodes that do not move, and the displacement under its weight.
//!
//! Based on: T. J. R. Hughes, *The Finite Element Method* (1987), chapter 2: prescribed displacements and body forces.
//!
//! Linear elasticity superposes. The weight of unit density under the acceleration g is therefore solved for once, K w
//! = ∫φ g, and every request adds its displacement. With diagonal L, density ρ and peak force F, forces are fractions
//! of F and volumes are in L³. The weight is then ρL³/F times that of unit density, and so is its displacement.

use crate::cancel_token::{CancelToken, Canceled};
use crate::elasticity::{ElasticWorkspace, Elasticity, ElasticityError, ReducedBasis};
use crate::memory::held;
use crate::scene::Anchors;
use nalgebra::Vector3;
use std::sync::Arc;

/// An object held by the anchors of a scene.
pub struct AnchoredObject {
    anchors: Anchors,
    /// One entry per body; `None`: no anchor touches it, it is free.
    bodies: Vec<Option<AnchoredBody>>,
}

/// An anchored body.
pub struct AnchoredBody {
    /// Elasticity with the anchored nodes fixed. It shares all tables but its factor with the free body.
    pub elasticity: Elasticity,
    /// Basis of displacements that keep these nodes where they are; `None`: every impact is solved.
    pub reduced: Option<Arc<ReducedBasis>>,
    /// Its weight; `None`: no gravity.
    pub weight: Option<Weight>,
}

/// Basis of displacements of a body that some nodes hold. It is part of the object's database.
#[derive(Clone, Debug, PartialEq)]
pub struct AnchoredBasis {
    /// Index of the body.
    pub body: usize,
    /// Nodes that do not move, ascending.
    pub nodes: Vec<u32>,
    /// The basis.
    pub basis: Arc<ReducedBasis>,
}

/// Weight of a body of unit density.
pub struct Weight {
    /// Acceleration of gravity, m/s².
    pub gravity: Vector3<f64>,
    /// Displacement w under the weight, local: [`Elasticity::unknowns`] components.
    pub displacement: Vec<f64>,
}

/// Anchored nodes of the elastic lattices.
#[derive(Clone, Debug, PartialEq)]
pub struct AnchorNodes {
    /// Number of nodes in each region.
    pub counts: Vec<usize>,
    /// Nodes in any region, ascending, for each body.
    pub nodes: Vec<Vec<u32>>,
}

/// Errors of anchoring an object. The scene is at fault; a retry does not help.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AnchorError {
    /// The body has no elasticity tables.
    #[error("body {body} has no elasticity tables, which anchors need; bake the object with elasticity")]
    ElasticityUnprepared {
        /// Index of the body.
        body: usize,
    },
    /// A region contains no node.
    #[error(
        "anchors[{region}], {what}, contains no node of the elastic lattice (edges of {spacing_m:.4} m); enlarge it, or move it \
         into the object, which extends from {:.4?} to {:.4?} m", .object_m[0], .object_m[1]
    )]
    Empty {
        /// Index of the region.
        region: usize,
        /// Description of the region.
        what: String,
        /// Mean edge length of the elastic lattice, m.
        spacing_m: f64,
        /// Lowest and highest corner of the object's bounding box, m.
        object_m: [[f64; 3]; 2],
    },
    /// The regions contain every node.
    #[error(
        "the anchors contain all {nodes} nodes of the elastic lattice, so that nothing can deform or break; make the regions smaller"
    )]
    Whole {
        /// Number of nodes.
        nodes: usize,
    },
    /// The regions leave a body a rigid motion, or its equations cannot be solved.
    #[error("body {body} is not held by {regions}: {source}")]
    Loose {
        /// Index of the body.
        body: usize,
        /// Names of the regions that touch it.
        regions: String,
        /// Cause.
        source: ElasticityError,
    },
    /// Canceled.
    #[error(transparent)]
    Canceled(#[from] Canceled),
}

impl AnchoredObject {
    /// An anchored object with these bodies.
    pub(in crate::pipeline) fn new(anchors: Anchors, bodies: Vec<Option<AnchoredBody>>) -> Self {
        Self { anchors, bodies }
    }

    /// Body `body` if it is anchored; `None`: it is free.
    pub fn body(&self, body: usize) -> Option<&AnchoredBody> {
        self.bodies[body].as_ref()
    }

    /// The anchors.
    pub fn anchors(&self) -> &Anchors {
        &self.anchors
    }

    /// Memory beyond that of the free object, bytes.
    pub fn bytes(&self) -> usize {
        let weight = |weight: &Weight| held(&weight.displacement);
        let own = |body: &AnchoredBody| {
            let basis = body.reduced.as_ref().map_or(0, |basis| basis.bytes());
            body.elasticity.own_bytes() + basis + body.weight.as_ref().map_or(0, weight)
        };
        held(&self.anchors.regions) + held(&self.bodies) + self.bodies.iter().flatten().map(own).sum::<usize>()
    }
}

impl AnchoredBasis {
    /// Memory, bytes.
    pub(super) fn bytes(&self) -> usize {
        held(&self.nodes) + self.basis.bytes()
    }
}

impl AnchoredBody {
    pub(in crate::pipeline) fn new(
        free: &Elasticity,
        (nodes, reduced): (Vec<u32>, Option<Arc<ReducedBasis>>),
        anchors: &Anchors,
        token: &CancelToken,
    ) -> Result<Self, ElasticityError> {
        let elasticity = free.anchored(nodes, token)?;
        let solved = |gravity| {
            let mut displacement = Vec::new();
            let forces = elasticity.weight(&gravity);
            elasticity.solve(&forces, &mut displacement, &mut ElasticWorkspace::default(), token)?;
            Ok::<_, ElasticityError>(Weight { gravity, displacement })
        };
        let weight = anchors.gravity_m_s2.map(solved).transpose()?;
        Ok(Self { elasticity, reduced, weight })
    }
}
