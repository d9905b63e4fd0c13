//! Held: an object whose anchors do not move, and its weight.
//!
//! Based on: T. J. R. Hughes, *The Finite Element Method* (1987), chapter 2: prescribed displacements and body forces.
//! Linear elasticity superposes, so the weight is solved for once, of unit density under the acceleration g, K w = ∫φ g, and
//! every strike adds its displacement. With diagonal L, density ρ and peak force F, forces are fractions of F and volumes are in
//! L³: the weight is ρL³/F times that of unit density, and so is what it displaces.

use crate::cancel_token::{CancelToken, Cancelled};
use crate::elasticity::{ElasticWorkspace, Elasticity, ElasticityError};
use crate::memory::held;
use crate::scene::Anchors;

/// What a scene's anchors make of an object.
pub struct AnchoredObject {
    anchors: Anchors,
    /// One per body; `None`: no anchor reaches it, it is free.
    bodies: Vec<Option<AnchoredBody>>,
}

/// One held body.
pub struct AnchoredBody {
    /// The body with its anchored nodes held; it shares all but its factor with the free one.
    pub elasticity: Elasticity,
    /// w, three components per node: local, per unit of density; `None`: it has no weight.
    pub sag: Option<Vec<f64>>,
}

/// Which nodes of the elastic lattices are held.
#[derive(Clone, Debug, PartialEq)]
pub struct AnchorNodes {
    /// By region: how many nodes lie in it.
    pub counts: Vec<usize>,
    /// By body: those that lie in some region, ascending.
    pub nodes: Vec<Vec<u32>>,
}

/// Why an object cannot be held; the scene's fault, no use to retry.
#[derive(Debug, thiserror::Error)]
pub enum AnchorError {
    /// The object is not prepared for deformation.
    #[error("body {body} is not prepared for elasticity, without which nothing is held")]
    ElasticityUnprepared {
        /// Which body.
        body: usize,
    },
    /// A region in which there is nothing to hold.
    #[error("anchors[{region}], {what}, holds no node of the elastic lattice, whose edges are {spacing_m:.4} m long")]
    Empty {
        /// Which region.
        region: usize,
        /// What it is.
        what: String,
        /// Mean edge length, m.
        spacing_m: f64,
    },
    /// The regions leave a body a motion, or their equations cannot be solved.
    #[error("body {body} is not held by {regions}: {source}")]
    Loose {
        /// Which body.
        body: usize,
        /// The regions that reach it.
        regions: String,
        /// Why.
        source: ElasticityError,
    },
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl AnchoredObject {
    /// Of the bodies as they are held.
    pub(in crate::pipeline) fn new(anchors: Anchors, bodies: Vec<Option<AnchoredBody>>) -> Self {
        Self { anchors, bodies }
    }

    /// Body `body` as it is held; `None`: it is free.
    pub fn body(&self, body: usize) -> Option<&AnchoredBody> {
        self.bodies[body].as_ref()
    }

    /// The anchors.
    pub fn anchors(&self) -> &Anchors {
        &self.anchors
    }

    /// Bytes that it holds beyond those of the free object.
    pub fn bytes(&self) -> usize {
        let own = |body: &AnchoredBody| body.elasticity.own_bytes() + body.sag.as_ref().map_or(0, held);
        held(&self.anchors.regions) + held(&self.bodies) + self.bodies.iter().flatten().map(own).sum::<usize>()
    }
}

impl AnchoredBody {
    pub(in crate::pipeline) fn new(
        free: &Elasticity,
        nodes: Vec<u32>,
        anchors: &Anchors,
        token: &CancelToken,
    ) -> Result<Self, ElasticityError> {
        let elasticity = free.anchored(nodes, token)?;
        let solved = |gravity| {
            let mut sag = Vec::new();
            elasticity.solve(&elasticity.weight(&gravity), &mut sag, &mut ElasticWorkspace::default(), token)?;
            Ok::<_, ElasticityError>(sag)
        };
        let sag = anchors.gravity_m_s2.map(solved).transpose()?;
        Ok(Self { elasticity, sag })
    }
}
