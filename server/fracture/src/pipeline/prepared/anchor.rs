//! Anchoring of an object.

use super::anchored::{AnchorError, AnchorNodes, AnchoredBody, AnchoredObject};
use super::object::PreparedObject;
use crate::cancel_token::CancelToken;
use crate::elasticity::{ElasticityError, ElementOrder, ReducedBasis};
use crate::pipeline::error::FractureError;
use crate::scene::{Anchors, EffectKind, EffectSet};

impl PreparedObject {
    /// The nodes inside `anchors`, after a check that they hold every body that they touch.
    ///
    /// # Errors
    /// [`AnchorError::ElasticityUnprepared`], [`AnchorError::Whole`], [`AnchorError::Empty`],
    /// [`AnchorError::Loose`].
    pub fn anchor_nodes(&self, anchors: &Anchors) -> Result<AnchorNodes, AnchorError> {
        let mut anchored_nodes =
            AnchorNodes { counts: vec![0; anchors.regions.len()], nodes: Vec::with_capacity(self.bodies.len()) };
        let mut spacing = 0.0f64;
        for (body, own) in self.bodies.iter().enumerate() {
            let solid = own.solid.as_ref().ok_or(AnchorError::ElasticityUnprepared { body })?;
            spacing = spacing.max(solid.elasticity.spacing());
            let before = anchored_nodes.counts.clone();
            let mut nodes = Vec::new();
            for (node, place) in solid.lattice.nodes.iter().enumerate() {
                let place_m = self.frame.to_meters(place);
                let mut any = false;
                for (region, count) in anchors.regions.iter().zip(&mut anchored_nodes.counts) {
                    let holds = region.holds(&place_m);
                    *count += usize::from(holds);
                    any |= holds;
                }
                if any {
                    nodes.push(node as u32);
                }
            }
            let reach = || (0..before.len()).filter(|&region| anchored_nodes.counts[region] > before[region]);
            if let Some(Err(source)) = (!nodes.is_empty()).then(|| solid.elasticity.check_anchors(&nodes)) {
                return Err(AnchorError::Loose { body, regions: named(reach()), source });
            }
            anchored_nodes.nodes.push(nodes);
        }
        let nodes: usize = self.bodies.iter().flat_map(|body| &body.solid).map(|solid| solid.lattice.nodes.len()).sum();
        if anchored_nodes.nodes.iter().map(Vec::len).sum::<usize>() == nodes {
            return Err(AnchorError::Whole { nodes });
        }
        match anchored_nodes.counts.iter().position(|count| *count == 0) {
            Some(region) => {
                let (what, spacing_m) = (anchors.regions[region].to_string(), spacing * self.frame.diagonal_m);
                let object_m = self.bounds_m().map(|corner| corner.coords.into());
                Err(AnchorError::Empty { region, what, spacing_m, object_m })
            }
            None => Ok(anchored_nodes),
        }
    }

    /// Anchors the object for requests with [`EffectKind::Anchored`]: factors the anchored stiffness, solves for the
    /// weight, and takes the bases that [`Self::anchored_bases`] has for these anchors.
    ///
    /// Requests without that effect use the free object.
    ///
    /// # Errors
    /// Those of [`Self::anchor_nodes`], and [`AnchorError::Canceled`].
    pub fn anchor(&mut self, anchors: &Anchors, token: &CancelToken) -> Result<(), AnchorError> {
        let anchored_nodes = self.anchor_nodes(anchors)?;
        let mut bodies = Vec::with_capacity(anchored_nodes.nodes.len());
        for (body, nodes) in anchored_nodes.nodes.into_iter().enumerate() {
            let solid = self.bodies[body].solid.as_ref().ok_or(AnchorError::ElasticityUnprepared { body })?;
            let failed = |source| match source {
                ElasticityError::Canceled(canceled) => AnchorError::Canceled(canceled),
                source => AnchorError::Loose { body, regions: named(0..anchors.regions.len()), source },
            };
            let mut bases = self.anchored_bases.iter().filter(|own| own.body == body);
            let basis = bases.find(|own| own.nodes == nodes).map(|own| own.basis.clone());
            let own = (!nodes.is_empty()).then(|| AnchoredBody::new(&solid.elasticity, (nodes, basis), anchors, token));
            bodies.push(own.transpose().map_err(failed)?);
        }
        self.held = Some(AnchoredObject::new(anchors.clone(), bodies));
        Ok(())
    }

    /// The anchored object under `effects`; `None` without [`EffectKind::Anchored`].
    ///
    /// # Errors
    /// [`FractureError::AnchorsUnprepared`].
    pub fn held(&self, effects: EffectSet) -> Result<Option<&AnchoredObject>, FractureError> {
        if !effects.has(EffectKind::Anchored) {
            return Ok(None);
        }
        let held = self.held.as_ref().ok_or(FractureError::AnchorsUnprepared { effect: EffectKind::Anchored })?;
        match held.anchors().gravity_m_s2 {
            None if effects.has(EffectKind::Gravity) => {
                Err(FractureError::AnchorsUnprepared { effect: EffectKind::Gravity })
            }
            _ => Ok(Some(held)),
        }
    }

    /// The basis of displacements of body `body` under `effects`; `None`: every impact is solved.
    pub fn basis(&self, body: usize, effects: EffectSet) -> Option<&ReducedBasis> {
        let held = self.held.as_ref().filter(|_| effects.has(EffectKind::Anchored));
        match held.and_then(|held| held.body(body)) {
            Some(own) => own.reduced.as_deref(),
            None => self.bodies[body].reduced(),
        }
    }

    /// True if `anchors` hold a body with quadratic elements that has a basis, but none for them: its solves take long.
    pub fn lacks_anchored_basis(&self, anchors: &Anchors) -> bool {
        let Ok(anchored_nodes) = self.anchor_nodes(anchors) else { return false };
        let is_slow = |(body, nodes): (usize, &Vec<u32>)| {
            let own = &self.bodies[body];
            let is_quadratic =
                own.solid.as_ref().is_some_and(|solid| solid.elasticity.order() == ElementOrder::Quadratic);
            let mut bases = self.anchored_bases.iter().filter(|basis| basis.body == body);
            !nodes.is_empty() && is_quadratic && own.reduced().is_some() && !bases.any(|basis| basis.nodes == *nodes)
        };
        anchored_nodes.nodes.iter().enumerate().any(is_slow)
    }
}

/// Names of regions in the form "anchors[0], anchors[2]".
fn named(regions: impl Iterator<Item = usize>) -> String {
    regions.map(|region| format!("anchors[{region}]")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::database::{BakeRequest, Tables, bake};
    use crate::pipeline::{DisplacementMethod, ElementChoice, SurfaceKind};
    use crate::scene::{Material, Region};
    use crate::surface::shapes;
    use nalgebra::Point3;

    #[test]
    fn anchored_bodies_have_the_elements_of_the_free_ones() {
        let order = |elements| {
            let request = BakeRequest {
                elements,
                elastic: DisplacementMethod::Solve,
                tables: Tables { elastic: true, ..Tables::NONE },
                surface: SurfaceKind::Lattice,
                elastic_spacing: Some(0.06),
                crack_spacing: Some(0.06),
                ..BakeRequest::new("plate", "glass", Material::named("glass").unwrap())
            };
            let token = CancelToken::default();
            let mut plate = bake(shapes::cuboid([0.4, 0.3, 0.05]), &request, &token, &mut |_| ()).unwrap();
            let region = Region::Cuboid { min_m: Point3::new(-1.0, -1.0, -1.0), max_m: Point3::new(-0.1, 1.0, 1.0) };
            plate.anchor(&Anchors { regions: vec![region], gravity_m_s2: None }, &token).unwrap();
            let anchored = plate.held.as_ref().unwrap().body(0).unwrap();
            [plate.bodies[0].solid.as_ref().unwrap().elasticity.order(), anchored.elasticity.order()]
        };
        assert_eq!(order(ElementChoice::Auto), [ElementOrder::Quadratic; 2]);
        assert_eq!(order(ElementChoice::Quadratic), [ElementOrder::Quadratic; 2]);
        assert_eq!(order(ElementChoice::Linear), [ElementOrder::Linear; 2]);
    }
}
