//! Reduced bases of anchored bodies.
//!
//! Ours. Anchors change every displacement, so each list of anchored nodes has a basis of its own. It comes from the
//! contacts of the object's impacts, as that of the free body does, and from the weight along the three axes.

use super::reduce::{basis, fitted, trials};
use crate::cancel_token::CancelToken;
use crate::elasticity::ElementOrder;
use crate::pipeline::error::FractureError;
use crate::pipeline::prepared::anchored::{AnchorError, AnchoredBasis};
use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::prepared::parameters::DisplacementMethod;
use crate::scene::{Anchors, EffectKind};
use std::sync::Arc;

/// Errors of bases for anchors.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AnchoredBasisError {
    /// The object cannot be anchored so.
    #[error(transparent)]
    Anchors(#[from] AnchorError),
    /// An impact on the anchored object failed.
    #[error(transparent)]
    Impact(#[from] FractureError),
}

/// Gives `prepared` the bases of its bodies with quadratic elements under each of `anchors`, and drops all other bases of
/// anchored bodies. A basis that exists stays as it is. Returns true if any was added or dropped.
///
/// Bodies with linear elements need none, because their solves are short. Objects baked to be solved get none. Calls
/// `progress` with the index of a body before its basis is made.
///
/// # Errors
/// [`AnchoredBasisError`]; the object has then no basis of an anchored body.
pub fn reduce_anchored(
    prepared: &mut PreparedObject,
    anchors: &[&Anchors],
    token: &CancelToken,
    progress: &mut dyn FnMut(usize),
) -> Result<bool, AnchoredBasisError> {
    let before = std::mem::take(&mut prepared.anchored_bases);
    let (mut after, mut is_new) = (Vec::new(), false);
    for anchors in anchors {
        let all = prepared.anchor_nodes(anchors)?.nodes.into_iter().enumerate();
        let wanted = all.filter(|(body, nodes)| !nodes.is_empty() && wants_basis(prepared, *body));
        let mut missing = Vec::new();
        for (body, nodes) in wanted {
            let is_own = |own: &&AnchoredBasis| own.body == body && own.nodes == nodes;
            if after.iter().any(|own| is_own(&own)) {
                continue;
            }
            match before.iter().find(is_own) {
                Some(known) => after.push(known.clone()),
                None => missing.push((body, nodes)),
            }
        }
        missing.iter().for_each(|(body, _)| progress(*body));
        let added = reduced(prepared, missing, anchors, token)?;
        is_new |= !added.is_empty();
        after.extend(added);
    }
    let is_changed = is_new || after.len() != before.len();
    prepared.anchored_bases = after;
    Ok(is_changed)
}

/// True for a body with quadratic elements, whose solves take long, of an object that may use reduced displacements.
fn wants_basis(prepared: &PreparedObject, body: usize) -> bool {
    let solid = prepared.bodies[body].solid.as_ref();
    prepared.parameters.elastic == DisplacementMethod::Reduced
        && solid.is_some_and(|solid| solid.elasticity.order() == ElementOrder::Quadratic)
}

/// The bases of bodies with these nodes held by `anchors`, with estimates of their errors. Leaves `prepared` free and
/// without bases of anchored bodies.
fn reduced(
    prepared: &mut PreparedObject,
    bodies: Vec<(usize, Vec<u32>)>,
    anchors: &Anchors,
    token: &CancelToken,
) -> Result<Vec<AnchoredBasis>, AnchoredBasisError> {
    let rank_max = prepared.parameters.quality.lattices().rank_max;
    let mut bases = Vec::new();
    for (body, nodes) in bodies {
        let failed = |source| FractureError::of_body(body, source);
        let elasticity = prepared.solid(body)?.elasticity.anchored(nodes.clone(), token).map_err(failed)?;
        let made = basis(prepared, body, &elasticity, rank_max, token)?;
        bases.extend(made.map(|basis| AnchoredBasis { body, nodes, basis: Arc::new(basis) }));
    }
    if bases.is_empty() {
        return Ok(bases);
    }
    prepared.anchored_bases.clone_from(&bases);
    prepared.anchor(anchors, token)?;
    let trials = trials(prepared, Some(EffectKind::Anchored), token);
    (prepared.held, prepared.anchored_bases) = (None, Vec::new());
    let trials = trials?;
    let estimating = |own: AnchoredBasis| {
        let basis = fitted(Arc::unwrap_or_clone(own.basis), (own.body, true), &trials);
        AnchoredBasis { basis: Arc::new(basis), ..own }
    };
    Ok(bases.into_iter().map(estimating).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::database::{BakeRequest, Tables, load, save};
    use crate::pipeline::request::context::RequestContext;
    use crate::pipeline::request::fracture_request::FractureRequest;
    use crate::pipeline::request::solver_settings::REDUCED_ERROR_MAX;
    use crate::pipeline::stages::contact_set::ContactSet;
    use crate::pipeline::stages::energy::{BodyEnergy, strain_energy};
    use crate::pipeline::training::sample::ImpactSampler;
    use crate::pipeline::workspace::Workspace;
    use crate::pipeline::{ElementChoice, ImpactContact, SurfaceKind};
    use crate::scene::{EffectSet, Material, Region};
    use crate::surface::shapes;
    use nalgebra::{Point3, Vector3};

    /// A glass strip of 0.2 × 0.05 × 0.02 m, with a basis of the free body if it has quadratic elements.
    fn strip(elements: ElementChoice) -> PreparedObject {
        let request = BakeRequest {
            elements,
            tables: Tables { elastic: true, ..Tables::NONE },
            surface: SurfaceKind::Lattice,
            elastic_spacing: Some(0.06),
            crack_spacing: Some(0.06),
            ..BakeRequest::new("strip", "glass", Material::named("glass").unwrap())
        };
        request.bake(shapes::cuboid([0.2, 0.05, 0.02])).unwrap()
    }

    /// The end of the strip below `x_m`, with weight across it.
    fn end(x_m: f64) -> Anchors {
        let region = Region::Cuboid { min_m: Point3::new(-1.0, -1.0, -1.0), max_m: Point3::new(x_m, 1.0, 1.0) };
        Anchors { regions: vec![region], gravity_m_s2: Some(Vector3::new(0.0, 0.0, -9.81)) }
    }

    fn reduce(strip: &mut PreparedObject, anchors: &[&Anchors]) -> bool {
        reduce_anchored(strip, anchors, &CancelToken::default(), &mut |_| ()).unwrap()
    }

    fn energy(strip: &PreparedObject, request: &FractureRequest, elastic: DisplacementMethod) -> BodyEnergy {
        energy_within(strip, request, elastic, REDUCED_ERROR_MAX)
    }

    /// The energy, with a reduced displacement if its error is at most `error_max`.
    fn energy_within(
        strip: &PreparedObject,
        request: &FractureRequest,
        elastic: DisplacementMethod,
        error_max: f64,
    ) -> BodyEnergy {
        let request = FractureRequest { elastic, reduced_error_max: error_max, ..request.clone() };
        let (token, contacts) = (CancelToken::default(), ContactSet::new(strip, &request).unwrap());
        let context = RequestContext::new(strip, &request, &token, &());
        strain_energy(context, &contacts, &mut Workspace::default()).unwrap().remove(0)
    }

    /// Impacts on the anchored strip outside those of its basis.
    fn impacts(strip: &PreparedObject, effects: &[EffectKind]) -> Vec<FractureRequest> {
        let sampler = ImpactSampler::new(strip);
        let one = |number| {
            let own = sampler.impact(77, number);
            FractureRequest { effects: effects.iter().fold(own.effects, |all, effect| all.with(*effect)), ..own }
        };
        (0..12).map(one).collect()
    }

    #[test]
    fn reduced_energies_of_an_anchored_strip_are_as_accurate_as_they_tell() {
        let mut strip = strip(ElementChoice::Auto);
        let anchors = end(-0.075);
        assert!(reduce(&mut strip, &[&anchors]));
        strip.anchor(&anchors, &CancelToken::default()).unwrap();
        assert!(!strip.lacks_anchored_basis(&anchors));
        for effects in [&[EffectKind::Anchored][..], &[EffectKind::Anchored, EffectKind::Gravity]] {
            let (mut reduced, mut within) = (0, 0);
            for impact in impacts(&strip, effects) {
                let own = energy(&strip, &impact, DisplacementMethod::Reduced);
                let solved = energy(&strip, &impact, DisplacementMethod::Solve);
                let [a, b] = [&own, &solved].map(|energy| energy.strain_j.unwrap());
                let error = (a / b - 1.0).abs();
                assert!(solved.reduced_error.is_none() && error < 3.0 * REDUCED_ERROR_MAX, "{error}");
                let Some(told) = own.reduced_error else { continue };
                reduced += 1;
                within += u32::from(error < 3.0 * told.max(1e-4));
            }
            assert!(reduced >= 8 && within >= reduced - 1, "{effects:?}: {within} of {reduced}");
        }
    }

    /// Near the anchors a basis misses most of the energy, which is small there.
    #[test]
    fn narrow_contacts_near_anchors_tell_their_errors() {
        let mut strip = strip(ElementChoice::Auto);
        let anchors = end(-0.05);
        reduce(&mut strip, &[&anchors]);
        strip.anchor(&anchors, &CancelToken::default()).unwrap();
        let effects = EffectSet::of([EffectKind::Elastic, EffectKind::Anchored]);
        let mut reduced = 0;
        for (x_m, radius_m) in [-0.045, -0.04, -0.03, 0.0].into_iter().flat_map(|x| [(x, 0.004), (x, 0.01)]) {
            let contact = ImpactContact {
                point_m: Point3::new(x_m, 0.003, 0.01),
                impulse_ns: -Vector3::z(),
                duration_s: None,
                radius_m: Some(radius_m),
                partner: None,
            };
            let base = FractureRequest::at(contact.point_m, contact.impulse_ns);
            let request = FractureRequest { contacts: vec![contact], effects, ..base };
            let solved = energy(&strip, &request, DisplacementMethod::Solve).strain_j.unwrap();
            for error_max in [REDUCED_ERROR_MAX, f64::INFINITY] {
                let own = energy_within(&strip, &request, DisplacementMethod::Reduced, error_max);
                let error = (own.strain_j.unwrap() / solved - 1.0).abs();
                println!("x {x_m} m, radius {radius_m} m: {error:.1e}, told {:?}", own.reduced_error);
                let Some(told) = own.reduced_error else { continue };
                reduced += 1;
                assert!(error < 3.0 * told.max(1e-3), "{x_m} m, {radius_m} m: {error} told as {told}");
            }
        }
        assert!(reduced >= 8, "{reduced}");
    }

    /// The strip is hit so softly that its weight, along it or across it, has all the energy.
    #[test]
    fn a_basis_holds_the_displacement_under_the_weight() {
        let mut strip = strip(ElementChoice::Auto);
        let across = end(-0.075);
        let along = Anchors { gravity_m_s2: Some(9.81 * Vector3::x()), ..across.clone() };
        reduce(&mut strip, &[&across]);
        let contact = ImpactContact {
            point_m: Point3::new(0.05, 0.0, 0.01),
            impulse_ns: -1e-9 * Vector3::z(),
            duration_s: None,
            radius_m: Some(0.02),
            partner: None,
        };
        let effects = EffectSet::of([EffectKind::Elastic, EffectKind::Anchored, EffectKind::Gravity]);
        let request = FractureRequest {
            contacts: vec![contact],
            effects,
            ..FractureRequest::at(contact.point_m, contact.impulse_ns)
        };
        for anchors in [across, along] {
            strip.anchor(&anchors, &CancelToken::default()).unwrap();
            let [reduced, solved] = [DisplacementMethod::Reduced, DisplacementMethod::Solve]
                .map(|elastic| energy(&strip, &request, elastic));
            let error = (reduced.strain_j.unwrap() / solved.strain_j.unwrap() - 1.0).abs();
            println!("error {error:.1e}, told {:?}", reduced.reduced_error);
            assert!(reduced.reduced_error.is_some() && error < 2e-4, "{error}");
            let without = FractureRequest { effects: effects.without(EffectKind::Gravity), ..request.clone() };
            let alone = energy(&strip, &without, DisplacementMethod::Reduced);
            assert!(alone.strain_j < reduced.strain_j.map(|energy| 1e-6 * energy), "{alone:?}");
        }
    }

    #[test]
    fn bases_are_those_of_the_given_anchors_and_are_loaded_as_saved() {
        let mut strip = strip(ElementChoice::Auto);
        let [short, long] = [end(-0.075), end(-0.05)];
        assert!(reduce(&mut strip, &[&short, &long, &short]) && strip.anchored_bases.len() == 2);
        let before = strip.anchored_bases.clone();
        assert!(!reduce(&mut strip, &[&short, &long]) && strip.anchored_bases == before);
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("strip.shatter");
        save(&strip, &file).unwrap();
        let mut loaded = load(&file).unwrap();
        assert!(loaded.anchored_bases == before && loaded.bodies[0].reduced() == strip.bodies[0].reduced());
        loaded.anchor(&long, &CancelToken::default()).unwrap();
        assert_eq!(loaded.basis(0, EffectSet::of([EffectKind::Anchored])), Some(&*before[1].basis));
        assert_eq!(loaded.basis(0, EffectSet::NONE), strip.bodies[0].reduced());
        assert!(loaded.lacks_anchored_basis(&end(-0.025)) && !loaded.lacks_anchored_basis(&long));
        assert!(reduce(&mut strip, &[&long]) && strip.anchored_bases == before[1..]);
    }

    #[test]
    fn bodies_with_linear_elements_need_no_basis() {
        let mut strip = strip(ElementChoice::Linear);
        let anchors = end(-0.075);
        assert!(!reduce(&mut strip, &[&anchors]) && strip.anchored_bases.is_empty());
        strip.anchor(&anchors, &CancelToken::default()).unwrap();
        assert!(!strip.lacks_anchored_basis(&anchors));
    }

    /// A contact on the anchors alone deforms nothing, with a basis as without.
    #[test]
    fn contacts_on_anchors_alone_are_refused() {
        let mut strip = strip(ElementChoice::Auto);
        let anchors = end(0.05);
        reduce(&mut strip, &[&anchors]);
        strip.anchor(&anchors, &CancelToken::default()).unwrap();
        let effects = EffectSet::of([EffectKind::Elastic, EffectKind::Anchored, EffectKind::Gravity]);
        let at = FractureRequest::at(Point3::new(-0.1, 0.0, 0.0), Vector3::x());
        for elastic in [DisplacementMethod::Reduced, DisplacementMethod::Solve] {
            let request = FractureRequest { effects, elastic, ..at.clone() };
            let (token, contacts) = (CancelToken::default(), ContactSet::new(&strip, &request).unwrap());
            let context = RequestContext::new(&strip, &request, &token, &());
            let error = strain_energy(context, &contacts, &mut Workspace::default()).unwrap_err();
            assert!(matches!(error, FractureError::Balanced { body: 0 }), "{error}");
        }
    }
}
