//! Conversion between wire types and engine types; no other module converts them.

mod bounds;
mod cost;
mod criterion;
mod errors;
mod radius;
mod ray;
mod rows;
mod settings;
mod tables;

pub use self::cost::CostReport;
pub use self::errors::engine_error;
pub(crate) use self::errors::engine_error_in;
pub(crate) use self::settings::preset;

use self::ray::AimResult;
use self::rows::Writer;
use self::settings::EffectiveSettings;
use crate::cost::ObjectCosts;
use crate::object::{EngineResult, Loader, ResultEnergies, ServedObject};
use crate::scene::{ObjectPolicy, Scene};
use bytemuck::Zeroable;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{self, DatabaseError};
use shatter_fracture::lift::LiftKind;
use shatter_fracture::pipeline::{
    self, DEGREE_MAX, FractureMeshes, FractureOutcome, PreparedObject, RequestContext, RequestCost, RetainedFragments,
    StageObserver, SurfaceKind, Workspace,
};
use shatter_fracture::scene::{DEFAULT_DURATION_S, DEFAULT_RADIUS_DIAGONALS, EffectKind, EffectSet};
use shatter_proto::control::{ObjectRow, ObjectState};
use shatter_proto::convention::Convention;
use shatter_proto::effect;
use shatter_proto::layout::{Layout, SectionCounts, SectionsMut};
use shatter_proto::name::OBJECT_NAME_MAX;
use shatter_proto::request::{Lift, Purpose, Quality, Request, RequestedCriterion, RequestedSurface, SEED_DEFAULT};
use shatter_proto::result::{
    EnergySource, FragmentSurface, HULL_FACES_MAX, HitWire, NO_MATERIAL, OUTER, OverrunCause, StageCost, SummaryWire,
    WORLD,
};
use shatter_proto::{Error, ErrorKind};
use std::sync::Arc;
use std::time::Duration;

/// Maximum bytes of a result per crack tetrahedron. Four labels in a tetrahedron make 24 crack triangles, with their share of vertices
/// and merge pairs. The bound also covers boundary triangles, of which there are fewer than tetrahedra. Normals and texture coordinates
/// are less than twice as long as positions, and vertex attributes are as long as both. Debris has one row per four triangles, bonds one
/// per crack and held fragment. A hull has at most 1.2 kB, and there are many more tetrahedra than fragments.
const RESULT_BYTES_PER_TET: usize = 2 * (1024 + 256) + 512;

/// Maximum bytes of a result per triangle of the skin: six parts of it, with their materials and twelve vertices.
const RESULT_BYTES_PER_SKIN_TRIANGLE: usize = 6 * 16 + 12 * 32;

/// More bytes of such results if the object has second texture coordinates or colors: at most 12 per vertex.
const OPTIONAL_BYTES_PER_TET: usize = 512;
const OPTIONAL_BYTES_PER_SKIN_TRIANGLE: usize = 12 * 12;

// Every name that can be baked can be requested, and vice versa.
const _: () = assert!(database::NAME_BYTES_MAX == OBJECT_NAME_MAX);

/// Creates a loader of databases: whole, or the parts that a scene needs.
pub fn loader(scene: Option<Scene>) -> Loader {
    Arc::new(move |path, name| {
        let object = scene.as_ref().map(|scene| scene.objects.get(name?));
        let (terms, material) = match object {
            None => (ObjectPolicy::default(), None),
            Some(Some(object)) => (object.terms.clone(), object.material.as_ref()),
            Some(None) => return Err("it is not in the scene".to_owned()),
        };
        let mut prepared = database::load_tables(path, terms.tables()).map_err(|error| damaged(&error))?;
        let own = &prepared.parameters.material_name;
        if let Some((name, _)) = material.filter(|(name, _)| name != own) {
            return Err(format!(
                "it was baked as {own}, but the scene needs {name}; bake it again with `--material {name}`"
            ));
        }
        if let Some(table) = database::lacking(&prepared, terms.tables()).filter(|_| scene.is_some()) {
            return Err(format!(
                "it was baked without the table `{table}`, which the scene needs; bake it again by `shatterd bake MESH`, or, if it has a \
                 `shape`, by `shatterd bake --scene FILE`"
            ));
        }
        if let Some(name) = name {
            name.clone_into(&mut prepared.name);
        }
        let name = prepared.name.clone();
        let refused = |error: &dyn std::fmt::Display| format!("objects.{name}: {error}");
        let mut prepared =
            prepared.warped(&terms.controls, &CancelToken::default()).map_err(|error| refused(&error))?;
        let lacks_basis = terms.allowed.has(effect::Effect::Anchored) && prepared.lacks_anchored_basis(&terms.anchors);
        terms.anchor(&mut prepared).map_err(|error| refused(&error))?;
        if lacks_basis {
            tracing::warn!(
                object = prepared.name,
                "the database has no basis of displacements for the anchors, so that impacts on the anchored object take many times \
                 as long; add it by `shatterd bake --scene FILE`"
            );
        }
        // Their memory is counted with that of the object.
        if terms.criterion == RequestedCriterion::Strength && terms.allowed.has(effect::Effect::Elastic) {
            prepared.prepare_strength();
        }
        Ok(Arc::new(EngineObject::new(Arc::new(prepared), terms)))
    })
}

/// Message about a database that cannot be loaded, with the remedy for a damaged one.
fn damaged(error: &DatabaseError) -> String {
    error.remedy().map_or_else(|| error.to_string(), |remedy| format!("{error}; {remedy}"))
}

/// Served object of the engine.
pub struct EngineObject {
    prepared: Arc<PreparedObject>,
    terms: ObjectPolicy,
    costs: Arc<ObjectCosts>,
    /// Lowest and highest corner of its surface, m.
    bounds_m: [[f64; 3]; 2],
}

impl EngineObject {
    /// Creates an object without a scene, with the default policy.
    pub fn whole(prepared: PreparedObject) -> Self {
        Self::new(Arc::new(prepared), ObjectPolicy::default())
    }

    /// Creates an object with a policy.
    pub fn new(prepared: Arc<PreparedObject>, terms: ObjectPolicy) -> Self {
        let costs = Arc::new(ObjectCosts::new(RequestCost::typical(&prepared)));
        let bounds_m = bounds::of_mesh(&prepared).map(|corner| corner.coords.into());
        Self { prepared, terms, costs, bounds_m }
    }

    /// The prepared object.
    pub fn prepared(&self) -> &PreparedObject {
        &self.prepared
    }
}

fn surface_kind(requested: RequestedSurface) -> SurfaceKind {
    match requested {
        RequestedSurface::Exact => SurfaceKind::Exact,
        RequestedSurface::Lattice => SurfaceKind::Lattice,
    }
}

impl ServedObject for EngineObject {
    fn row(&self) -> ObjectRow {
        let prepared = &self.prepared;
        let material = &prepared.parameters.material;
        let mut row = ObjectRow {
            state: ObjectState::Ready as u32,
            bodies: prepared.bodies.len() as u32,
            degree_max: self.terms.sites_max.map_or(DEGREE_MAX, |most| most.min(DEGREE_MAX)),
            elastic_nodes: prepared.elastic_nodes() as u32,
            crack_nodes: prepared.crack_nodes() as u32,
            gamma_j_m2: self.terms.gamma(material).unwrap_or(self.terms.strength_scale.powi(2) * prepared.gamma_j_m2),
            young_pa: material.young_pa,
            poisson: material.poisson,
            density_kg_m3: material.density_kg_m3,
            volume_m3: prepared.volume_m3(),
            diagonal_m: prepared.frame.diagonal_m,
            center_m: prepared.frame.center_m.coords.into(),
            bounds_m: self.bounds_m,
            radius_m: DEFAULT_RADIUS_DIAGONALS * prepared.frame.diagonal_m,
            duration_s: DEFAULT_DURATION_S,
            fragments_max: self.terms.fragments_max.map_or(0, u64::from),
            bytes_max: self.terms.bytes_max.unwrap_or(0),
            ..ObjectRow::zeroed()
        };
        row.set_name(&prepared.name);
        row.set_material(&prepared.parameters.material_name);
        row
    }

    fn bytes(&self) -> usize {
        self.prepared.bytes()
    }

    fn finish(&self) -> Result<(), Error> {
        self.prepared.factor().map_err(engine_error)?;
        if self.costs.is_measured() {
            return Ok(());
        }
        match self.timed() {
            Ok(samples) => self.costs.measured(&samples),
            // An object that cannot be struck has no times.
            Err(error) => tracing::debug!("not timed: {error}"),
        }
        Ok(())
    }

    fn result_bytes_max(&self) -> usize {
        let skin_triangle_count = self.prepared.skin.as_ref().map_or(0, |skin| skin.triangles.len());
        let (mut per_tet, mut per_triangle) = (RESULT_BYTES_PER_TET, RESULT_BYTES_PER_SKIN_TRIANGLE);
        if self.prepared.attribute_kinds().is_more_than_first_uvs() {
            per_tet += OPTIONAL_BYTES_PER_TET;
            per_triangle += OPTIONAL_BYTES_PER_SKIN_TRIANGLE;
        }
        let most = self.prepared.cut_tets().saturating_mul(per_tet);
        let most = most.saturating_add(skin_triangle_count.saturating_mul(per_triangle));
        // Longer results are refused before a bucket is loaned.
        self.terms.bytes_max.and_then(|bytes| usize::try_from(bytes).ok()).map_or(most, |bytes| most.min(bytes))
    }

    fn strike(
        &self,
        strike: &Request,
        workspace: &mut Workspace,
        token: &CancelToken,
        observer: &dyn StageObserver,
    ) -> Result<Box<dyn EngineResult>, Error> {
        let hit = ray::first_hit(strike, |ray| pipeline::aim(&self.prepared, surface_kind(strike.surface), ray))?;
        if strike.purpose == Purpose::Aim {
            return Ok(Box::new(AimResult::new(strike, hit)));
        }
        let resolved = self.resolved(&ray::pointed(strike, &hit))?;
        tables::check(&self.prepared, &resolved.request)?;
        let context = RequestContext::new(&self.prepared, &resolved.request, token, observer);
        let result = pipeline::strike(context, workspace);
        let result = result.map_err(|error| of_object(engine_error_in(error, &strike.convention)))?;
        let used = self.used(&resolved, &result);
        self.struck(strike, (used, hit), Some(self.costs.clone()), result)
    }

    fn strike_again(
        &self,
        from: (&RetainedFragments, u32),
        strike: &Request,
        workspace: &mut Workspace,
        token: &CancelToken,
        observer: &dyn StageObserver,
    ) -> Result<Box<dyn EngineResult>, Error> {
        let hit = ray::first_hit(strike, |ray| pipeline::aim_again(&self.prepared, from, ray))?;
        if strike.purpose == Purpose::Aim {
            return Ok(Box::new(AimResult::new(strike, hit)));
        }
        let resolved = self.resolved(&ray::pointed(strike, &hit))?;
        // No check of tables: the lift of a fragment is computed with it, and the stages name what else is missing.
        let context = RequestContext::new(&self.prepared, &resolved.request, token, observer);
        let result = pipeline::strike_again(context, from, workspace);
        let result = result.map_err(|error| of_fragment(engine_error_in(error, &strike.convention), from.1))?;
        let mut used = self.used(&resolved, &result);
        // Fragments have no basis.
        used.is_reducible = false;
        // The times of a fragment tell nothing about the object.
        self.struck(strike, (used, hit), None, result)
    }
}

/// Adds advice to the message of a contact that does not lie on the object: its unit or axes may be wrong.
fn of_object(error: Error) -> Error {
    let advice = "; if the object is misplaced, bake it with another --unit or --up";
    match error.kind {
        ErrorKind::ContactTooFar => Error { message: error.message + advice, ..error },
        _ => error,
    }
}

/// Names the fragment in the message of a contact that does not lie on it.
fn of_fragment(error: Error, fragment: u32) -> Error {
    match error.kind {
        ErrorKind::ContactTooFar => Error { message: format!("fragment {fragment}: {}", error.message), ..error },
        _ => error,
    }
}

impl EngineObject {
    /// Settings by which `result` was computed for the request of `resolved`, on the whole object.
    fn used(&self, resolved: &ResolvedRequest, result: &FractureOutcome) -> EffectiveSettings {
        let ResolvedRequest { request, effects, quality } = resolved;
        // The plan as asked for; the outcome says what a time budget changed: the rank here, the degree in its source.
        EffectiveSettings::of(&self.prepared, *effects, *quality, request, result.threshold().rank_max)
    }

    /// Wraps the result of `strike`, after checking the scene's limits.
    fn struck(
        &self,
        strike: &Request,
        (used, hit): (EffectiveSettings, HitWire),
        costs: Option<Arc<ObjectCosts>>,
        result: FractureOutcome,
    ) -> Result<Box<dyn EngineResult>, Error> {
        let deformed = used.effects.has(effect::Effect::Elastic);
        let (object, seed, convention) = (strike.object.clone(), strike.seed, strike.convention);
        let is_threshold = strike.purpose == Purpose::Threshold;
        let struck = RequestedResult { object, seed, convention, hit, deformed, is_threshold, used, costs, result };
        self.check_scene_limits(&struck.counts())?;
        Ok(Box::new(struck))
    }

    /// Preset of `strike`: its own, else the scene's, else the one for which the object was baked.
    fn quality(&self, strike: &Request) -> Quality {
        let baked = settings::of_lattices(self.prepared.parameters.quality);
        strike.quality.or(self.terms.quality).unwrap_or(baked)
    }

    /// Refuses a result beyond the scene's limits.
    fn check_scene_limits(&self, counts: &SectionCounts) -> Result<(), Error> {
        let exceeded = |key: &str, found: u64, what: &str, cap: u64| {
            Error::new(ErrorKind::CapExceeded, key, format!("{found} {what}, but the scene allows {cap}"))
        };
        if let Some(cap) = self.terms.fragments_max.filter(|cap| counts.fragments > *cap as usize) {
            return Err(exceeded("fragments_max", counts.fragments as u64, "fragments", cap.into()));
        }
        let bytes = Layout::new(counts).map_or(u64::MAX, |layout| layout.used_bytes());
        match self.terms.bytes_max.filter(|cap| bytes > *cap) {
            Some(cap) => Err(exceeded("bytes_max", bytes, "bytes", cap)),
            None => Ok(()),
        }
    }

    /// Engine request for `strike` under the object's policy.
    ///
    /// # Errors
    /// `effect`, as of [`ObjectPolicy::effects`]; `contact_radius` for a contact that is larger than the object.
    pub fn request(&self, strike: &Request) -> Result<pipeline::FractureRequest, Error> {
        Ok(self.resolved(strike)?.request)
    }

    /// `strike` with every default filled in: the object's policy, then the preset, then what the request gives, then its limits of
    /// error and time.
    ///
    /// # Errors
    /// Those of [`Self::request`].
    fn resolved(&self, strike: &Request) -> Result<ResolvedRequest, Error> {
        let (effects, quality) = (self.terms.effects(strike)?, self.quality(strike));
        let preset = settings::preset(quality).solver_settings();
        let both = EffectKind::ALL.into_iter().zip(effect::Effect::ALL);
        let request = pipeline::FractureRequest {
            contacts: strike.contacts.iter().map(|contact| rows::contact(contact, &strike.convention)).collect(),
            degree: preset.degree,
            degree_max: self.terms.sites_max.map_or(DEGREE_MAX, |most| most.min(DEGREE_MAX)),
            gamma_j_m2: strike.gamma_j_m2.or(self.terms.gamma(&self.prepared.parameters.material)),
            strength_scale: self.terms.strength_scale,
            criterion: criterion::of(strike.criterion.unwrap_or(self.terms.criterion)),
            elastic: preset.elastic,
            rank_max: preset.rank_max,
            lift: match strike.lift.unwrap_or(self.terms.lift) {
                Lift::Euclidean => LiftKind::Euclidean,
                Lift::SurfaceDiffusion => LiftKind::SurfaceDiffusion,
                Lift::Interior => LiftKind::Interior,
            },
            surface: surface_kind(strike.surface),
            effects: EffectSet::of(both.filter(|(_, wire)| effects.has(*wire)).map(|(effect, _)| effect)),
            volume_min_m3: self.terms.volume_min_m3,
            tolerance: preset.tolerance,
            iterations_max: preset.iterations_max,
            gap_max: None,
            reduced_error_max: preset.reduced_error_max,
            budget: None,
            seed: strike.seed,
            threshold_only: strike.purpose == Purpose::Threshold,
        };
        radius::check(&self.prepared, &request)?;
        let request = settings::given(request, strike);
        let solved = !settings::is_reducible(&self.prepared, &request);
        let request = settings::timed(request, strike, self.costs.of(effects, solved));
        Ok(ResolvedRequest { request, effects, quality })
    }
}

/// A request with every default filled in.
struct ResolvedRequest {
    /// As the engine takes it.
    request: pipeline::FractureRequest,
    /// Effects that are on.
    effects: effect::Effects,
    quality: Quality,
}

/// Result of the engine, with the data of its request.
struct RequestedResult {
    object: String,
    seed: u64,
    /// Coordinates of the result.
    convention: Convention,
    /// Point at which its ray hit the object.
    hit: HitWire,
    /// Whether its energy is elastic.
    deformed: bool,
    /// Whether it only told the load that breaks the object.
    is_threshold: bool,
    used: EffectiveSettings,
    /// Costs that learn from its times.
    costs: Option<Arc<ObjectCosts>>,
    result: FractureOutcome,
}

impl EngineResult for RequestedResult {
    fn counts(&self) -> SectionCounts {
        self.result.meshes().map_or(SectionCounts::default(), rows::counts)
    }

    fn keep(&self) -> Option<RetainedFragments> {
        self.result.meshes().map(FractureMeshes::keep)
    }

    fn solved(&self) -> Option<OverrunCause> {
        let threshold = self.result.threshold();
        let solved = self.deformed && !threshold.is_bound && threshold.reduced_error.is_none();
        solved.then_some(if self.used.is_reducible { OverrunCause::ReducedError } else { OverrunCause::NoReducedBasis })
    }

    fn energies(&self) -> Option<ResultEnergies> {
        let source = self.source_of_energy();
        if self.is_threshold {
            return Some(ResultEnergies::unknown(source));
        }
        let SummaryWire { impactor_j, strain_j, surface_j, released_j, deficit_j, stress_over_strength, .. } =
            self.summary();
        Some(ResultEnergies { source, impactor_j, strain_j, surface_j, released_j, deficit_j, stress_over_strength })
    }

    fn took(&self, time: Duration, stages: &[StageCost]) {
        let (Some(costs), Some(fracture)) = (&self.costs, self.result.fracture()) else { return };
        let solved = fracture.threshold.reduced_error.is_none();
        costs.learn(self.used.effects, &cost::sample(fracture.sites, solved, fracture.iterations, time, stages));
    }

    fn write(&self, sections: &mut SectionsMut<'_>, observer: &dyn StageObserver) -> Result<(), Error> {
        *sections.summary = self.summary();
        let Some(pieces) = self.result.meshes() else { return Ok(()) };
        Writer { pieces, to: &self.convention }.write(sections, observer)
    }
}

impl RequestedResult {
    fn source_of_energy(&self) -> EnergySource {
        let threshold = self.result.threshold();
        match (self.deformed, threshold.reduced_error) {
            _ if threshold.is_bound => EnergySource::Bounded,
            (false, _) => EnergySource::Falloff,
            (true, Some(_)) => EnergySource::Reduced,
            (true, None) => EnergySource::Solve,
        }
    }

    fn summary(&self) -> SummaryWire {
        let (result, threshold) = (&self.result, self.result.threshold());
        let exact = result.meshes().is_some_and(FractureMeshes::has_exact_surface);
        let surface = if exact { FragmentSurface::Exact } else { FragmentSurface::Lattice };
        let mut summary = SummaryWire {
            surface: surface.code(),
            degree_source: criterion::degree_origin(result.degree_source()).code(),
            sites: result.sites(),
            fracture_degree: result.fracture_degree(),
            capped: u32::from(result.capped()),
            gamma_j_m2: threshold.gamma_j_m2,
            e1_over_gamma: threshold.e1_over_gamma,
            threshold_impulse_factor: threshold.impulse_factor,
            strain_j: threshold.strain_j.unwrap_or(0.0),
            confidence: result.confidence(),
            seed: self.seed,
            radius_m: self.convention.length(threshold.radius_m),
            elastic: self.source_of_energy().code(),
            energy_error: threshold.reduced_error.unwrap_or(0.0),
            hit: self.hit,
            ..SummaryWire::zeroed()
        };
        criterion::write_summary(result, &self.convention, &mut summary);
        criterion::write_impactor(result, &mut summary);
        summary.set_object(&self.object);
        self.used.write_summary(result, &mut summary);
        summary
    }
}

const _: () = assert!(OUTER == pipeline::OUTER && WORLD == pipeline::WORLD);
const _: () = assert!(NO_MATERIAL == shatter_fracture::surface::NO_MATERIAL);
const _: () = assert!(SEED_DEFAULT == pipeline::SEED_DEFAULT && HULL_FACES_MAX == shatter_fracture::hull::FACES_MAX);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn engine_and_client_have_the_same_default_seed() {
        let engine = pipeline::FractureRequest::at(nalgebra::Point3::origin(), nalgebra::Vector3::x());
        assert_eq!((engine.seed, Request::default().seed), (SEED_DEFAULT, SEED_DEFAULT));
    }

    #[test]
    fn engine_and_client_refuse_the_same_characters_in_names() {
        for character in '\0'..=char::MAX {
            let both =
                [shatter_proto::text::is_invisible, shatter_fracture::scene::is_invisible].map(|is| is(character));
            assert_eq!(both[0], both[1], "{character:?}");
        }
    }
}
