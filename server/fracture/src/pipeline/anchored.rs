//! Held: an object whose anchors do not move, and its weight.
//!
//! Based on: T. J. R. Hughes, *The Finite Element Method* (1987), chapter 2: prescribed displacements and body forces.
//! Linear elasticity superposes, so the weight is solved for once, of unit density under the acceleration g, K w = ∫φ g, and
//! every strike adds its displacement. With diagonal L, density ρ and peak force F, forces are fractions of F and volumes are in
//! L³: the weight is ρL³/F times that of unit density, and so is what it displaces.

use super::{ContactSet, FractureError, PreparedObject};
use crate::cancel_token::{CancelToken, Cancelled};
use crate::elasticity::{ElasticWorkspace, Elasticity, ElasticityError};
use crate::memory::held;
use crate::scene::{Anchors, EffectKind, EffectSet};

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

impl PreparedObject {
    /// The nodes that `anchors` hold, after a check that they do hold every body that they reach.
    ///
    /// Errors: [`AnchorError::ElasticityUnprepared`], [`AnchorError::Empty`], [`AnchorError::Loose`].
    pub fn anchor_nodes(&self, anchors: &Anchors) -> Result<AnchorNodes, AnchorError> {
        let mut grip =
            AnchorNodes { counts: vec![0; anchors.regions.len()], nodes: Vec::with_capacity(self.bodies.len()) };
        let mut spacing = 0.0f64;
        for (body, own) in self.bodies.iter().enumerate() {
            let solid = own.solid.as_ref().ok_or(AnchorError::ElasticityUnprepared { body })?;
            spacing = spacing.max(solid.elasticity.spacing());
            let before = grip.counts.clone();
            let mut nodes = Vec::new();
            for (node, place) in solid.lattice.nodes.iter().enumerate() {
                let place_m = self.frame.to_meters(place);
                let mut any = false;
                for (region, count) in anchors.regions.iter().zip(&mut grip.counts) {
                    let holds = region.holds(&place_m);
                    *count += usize::from(holds);
                    any |= holds;
                }
                if any {
                    nodes.push(node as u32);
                }
            }
            let reach = || (0..before.len()).filter(|&region| grip.counts[region] > before[region]);
            if let Some(Err(source)) = (!nodes.is_empty()).then(|| solid.elasticity.check_anchors(&nodes)) {
                return Err(AnchorError::Loose { body, regions: named(reach()), source });
            }
            grip.nodes.push(nodes);
        }
        match grip.counts.iter().position(|count| *count == 0) {
            Some(region) => {
                let (what, spacing_m) = (anchors.regions[region].to_string(), spacing * self.frame.diagonal_m);
                Err(AnchorError::Empty { region, what, spacing_m })
            }
            None => Ok(grip),
        }
    }

    /// Holds the object by `anchors`, for strikes with [`EffectKind::Anchored`]: factors what they hold, and solves for its weight.
    /// Strikes without it find the object as it was.
    ///
    /// Errors: those of [`Self::anchor_nodes`], and [`AnchorError::Cancelled`].
    pub fn anchor(&mut self, anchors: &Anchors, token: &CancelToken) -> Result<(), AnchorError> {
        let grip = self.anchor_nodes(anchors)?;
        let mut bodies = Vec::with_capacity(grip.nodes.len());
        for (body, nodes) in grip.nodes.into_iter().enumerate() {
            let solid = self.bodies[body].solid.as_ref().ok_or(AnchorError::ElasticityUnprepared { body })?;
            let failed = |source| match source {
                ElasticityError::Cancelled(cancelled) => AnchorError::Cancelled(cancelled),
                source => AnchorError::Loose { body, regions: named(0..anchors.regions.len()), source },
            };
            let own = (!nodes.is_empty()).then(|| AnchoredBody::new(&solid.elasticity, nodes, anchors, token));
            bodies.push(own.transpose().map_err(failed)?);
        }
        self.held = Some(AnchoredObject { anchors: anchors.clone(), bodies });
        Ok(())
    }

    /// What holds the object under `effects`; nothing without [`EffectKind::Anchored`].
    ///
    /// Errors: [`FractureError::Unheld`].
    pub fn held(&self, effects: EffectSet) -> Result<Option<&AnchoredObject>, FractureError> {
        if !effects.has(EffectKind::Anchored) {
            return Ok(None);
        }
        let held = self.held.as_ref().ok_or(FractureError::Unheld { effect: EffectKind::Anchored })?;
        match held.anchors.gravity_m_s2 {
            None if effects.has(EffectKind::Gravity) => Err(FractureError::Unheld { effect: EffectKind::Gravity }),
            _ => Ok(Some(held)),
        }
    }

    /// ρL³/F: fractions of the peak force of `impact` per unit of local weight of unit density.
    pub fn weight_unit(&self, impact: &ContactSet) -> f64 {
        self.parameters.material.density_kg_m3 * self.frame.diagonal_m.powi(3) / impact.peak_force_n
    }
}

/// "anchors[0], anchors[2]".
fn named(regions: impl Iterator<Item = usize>) -> String {
    regions.map(|region| format!("anchors[{region}]")).collect::<Vec<_>>().join(", ")
}

impl AnchoredObject {
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
    fn new(
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
