//! What effects cost: every shipped scene's objects, struck on the scene's terms and with everything on.

use super::bars::{Segment, StackedBar, svg};
use super::gallery;
use super::plot::PlotError;
use crate::picture::PictureError;
use crate::report::{ReportFigure, ReportTable, Section, Study};
use bytemuck::Zeroable;
use nalgebra::{Point3, Vector3};
use serde_json::{Value, json};
use shatter_engine::object::ServedObject;
use shatter_engine::scene::{ObjectPolicy, Scene};
use shatter_engine::stage_profiler::StageProfiler;
use shatter_engine::wire::EngineObject;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeError, bake};
use shatter_fracture::pipeline::{self, AnchorError, ImpactSampler, PreparedObject, WarpError, Workspace};
use shatter_fracture::random::RandomStream;
use shatter_proto::Error;
use shatter_proto::effect::Effect;
use shatter_proto::layout::Layout;
use shatter_proto::request::{Contact, DegreeRule, Request};
use shatter_proto::result::{Block, StageKind};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// The scenes that come with the program.
pub const SHIPPED: [(&str, &str); 3] = [
    ("glass_shop", include_str!("../../../../config/scenes/glass_shop.toml")),
    ("stone_arch", include_str!("../../../../config/scenes/stone_arch.toml")),
    ("hero_statue", include_str!("../../../../config/scenes/hero_statue.toml")),
];

/// Strikes of which the median is shown; one before them warms up.
const STRIKES: u64 = 15;

/// Sites of each: what is compared is effects.
const SITES: u32 = 24;

/// Why there is no study.
#[derive(Debug, thiserror::Error)]
pub enum EffectsError {
    /// A scene or a strike was refused.
    #[error(transparent)]
    Refused(#[from] Error),
    /// An object could not be baked.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// A scene's artist wants what an object cannot have.
    #[error(transparent)]
    Warp(#[from] WarpError),
    /// An object could not be held.
    #[error(transparent)]
    Hold(#[from] AnchorError),
    /// No plot.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// No picture.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// The materials that come with the program cannot be read.
    #[error("materials: {0}")]
    Materials(String),
    /// What should be shown broken stays whole.
    #[error("`{0}` stays whole: nothing to show")]
    Whole(String),
}

/// What one stage or effect took and produced: medians.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MedianCost {
    /// Its name.
    pub name: &'static str,
    /// Whether it ran.
    pub ran: bool,
    /// Time, ns.
    pub ns: u64,
    /// Bytes.
    pub bytes: u64,
}

/// What one object costs on the scene's terms, and with everything on.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneCosts {
    /// The scene.
    pub scene: &'static str,
    /// The object.
    pub object: String,
    /// On the scene's terms.
    pub own: Vec<MedianCost>,
    /// With everything on.
    pub all: Vec<MedianCost>,
    /// The object, broken on the scene's terms: bytes of a PNG file.
    pub portrait: Vec<u8>,
    /// Bytes of memory that the tables for the scene's terms hold, and all tables.
    pub memory: [usize; 2],
}

/// Time of all stages and effects, ns.
fn total(costs: &[MedianCost]) -> u64 {
    costs.iter().map(|cost| cost.ns).sum()
}

/// Bakes and strikes the objects of all shipped scenes; `progress` is told of each.
pub fn pairs(progress: &mut dyn FnMut(&str)) -> Result<Vec<SceneCosts>, EffectsError> {
    let mut pairs = Vec::new();
    for (scene, text) in SHIPPED {
        for (name, object) in Scene::parse(text, Path::new(""))?.objects {
            progress(&format!("{scene}: {name}"));
            let Some((mesh, request)) = object.bake(&name) else { continue };
            let (controls, token) = (&object.terms.controls, CancelToken::default());
            let mut lean = bake(mesh.clone(), &request, &token, &mut |_| {})?.warped(controls, &token)?;
            object.terms.anchor(&mut lean)?;
            let everything =
                shatter_fracture::database::BakeRequest { tables: shatter_fracture::database::Tables::ALL, ..request };
            let mut prepared = bake(mesh, &everything, &token, &mut |_| {})?.warped(controls, &token)?;
            object.terms.anchor(&mut prepared)?;
            let prepared = Arc::new(prepared);
            let memory = [lean.bytes(), prepared.bytes()];
            let rich = object.terms.rich();
            let portrait = gallery::portrait(&prepared, &request_of(&prepared, &object.terms)?)?;
            let own = costs(&prepared, object.terms)?;
            pairs.push(SceneCosts { scene, object: name, own, all: costs(&prepared, rich)?, portrait, memory });
        }
    }
    Ok(pairs)
}

/// The strike of the portrait, as the engine wants it.
fn request_of(prepared: &Arc<PreparedObject>, terms: &ObjectPolicy) -> Result<pipeline::FractureRequest, Error> {
    EngineObject::new(prepared.clone(), terms.clone()).request(&strike(prepared, 1))
}

/// Medians over strikes all over the object.
fn costs(prepared: &Arc<PreparedObject>, terms: ObjectPolicy) -> Result<Vec<MedianCost>, EffectsError> {
    let served = EngineObject::new(prepared.clone(), terms);
    let (mut workspace, mut payload) = (Workspace::default(), Vec::new());
    let mut runs = Vec::new();
    for number in 0..=STRIKES {
        let clock = StageProfiler::default();
        let strike = strike(prepared, number);
        let outcome = served.strike(&strike, &mut workspace, &CancelToken::default(), &clock)?;
        let layout = Layout::new(&outcome.counts()).ok_or_else(too_large)?;
        payload.resize(payload.len().max(layout.blocks()), Block::zeroed());
        let mut sections = layout.split(&mut payload[..layout.blocks()]).ok_or_else(too_large)?;
        clock.write(outcome.as_ref(), &mut sections, layout.base_bytes())?;
        runs.push(clock);
    }
    let stages = (0..StageKind::ALL.len()).map(|k| {
        let run = |clock: &StageProfiler| {
            let cost = clock.stages()[k];
            (cost.has_run, cost.time, cost.bytes)
        };
        cost(StageKind::ALL[k].name(), runs[1..].iter().map(run).collect())
    });
    let effects = (0..Effect::ALL.len()).map(|k| {
        let run = |clock: &StageProfiler| {
            let cost = clock.effects()[k];
            (cost.has_run, cost.time, cost.bytes)
        };
        cost(Effect::ALL[k].name(), runs[1..].iter().map(run).collect())
    });
    Ok(stages.chain(effects).collect())
}

fn cost(name: &'static str, runs: Vec<(bool, Duration, u64)>) -> MedianCost {
    let median = |of: fn(&(bool, Duration, u64)) -> u64| {
        let mut values: Vec<u64> = runs.iter().map(of).collect();
        values.sort_unstable();
        values[values.len() / 2]
    };
    let nanoseconds = |run: &(bool, Duration, u64)| u64::try_from(run.1.as_nanos()).unwrap_or(u64::MAX);
    MedianCost { name, ran: runs.iter().any(|run| run.0), ns: median(nanoseconds), bytes: median(|run| run.2) }
}

fn too_large() -> Error {
    Error::new(shatter_proto::ErrorKind::AnswerTooLarge, "answers", "the answer cannot be addressed")
}

/// A blow somewhere on the surface, inwards.
fn strike(prepared: &PreparedObject, number: u64) -> Request {
    let (point, inward): (Point3<f64>, Vector3<f64>) =
        ImpactSampler::new(prepared).point(&mut RandomStream::new(prepared.parameters.seed, number));
    let point_m = prepared.frame.to_meters(&point).coords.into();
    let contact = Contact { point_m, ray: None, impulse_ns: inward.into(), duration_s: None, radius_m: None };
    Request {
        object: prepared.name.clone(),
        contacts: vec![contact],
        degree: DegreeRule::Sites(SITES),
        seed: number,
        ..Request::default()
    }
}

/// One document of everything.
pub fn document(pairs: &[SceneCosts]) -> Value {
    let costs = |costs: &[MedianCost]| -> Vec<Value> {
        costs.iter().map(|own| json!({ "name": own.name, "ran": own.ran, "ns": own.ns, "bytes": own.bytes })).collect()
    };
    let pair = |pair: &SceneCosts| {
        json!({
            "scene": pair.scene,
            "object": pair.object,
            "own": costs(&pair.own),
            "all": costs(&pair.all),
            "own_ns": total(&pair.own),
            "all_ns": total(&pair.all),
            "times_faster": total(&pair.all) as f64 / total(&pair.own) as f64,
            "memory_bytes": { "own": pair.memory[0], "all": pair.memory[1] },
        })
    };
    json!({ "strikes": STRIKES, "sites": SITES, "objects": pairs.iter().map(pair).collect::<Vec<_>>() })
}

/// The page: what every object of the scenes costs, and pictures.
pub fn page(pairs: &[SceneCosts], gallery: Section) -> Result<Study, EffectsError> {
    let mut sections = pairs.iter().map(section).collect::<Result<Vec<_>, _>>()?;
    sections.push(gallery);
    let lead = format!(
        "Every object of the shipped scenes, struck {STRIKES} times with {SITES} sites, on its scene's terms and with everything \
         on; medians. What is off is hatched, as long as it is where everything is on: that much is not paid."
    );
    Ok(Study { title: "What effects cost".to_owned(), lead: vec![lead], facts: Vec::new(), sections })
}

fn section(pair: &SceneCosts) -> Result<Section, PlotError> {
    let ms = |ns: u64| ns as f64 * 1e-6;
    let segments = |costs: &[MedianCost]| -> Vec<Segment> {
        let both = costs.iter().zip(&pair.all);
        let own = both.map(|(own, all)| match own.ran {
            true => Segment { name: own.name, length: ms(own.ns), hatched: false },
            false => Segment { name: own.name, length: ms(all.ns), hatched: true },
        });
        own.collect()
    };
    let bars = [
        StackedBar { name: format!("scene: {:.1} ms", ms(total(&pair.own))), segments: segments(&pair.own) },
        StackedBar { name: format!("all on: {:.1} ms", ms(total(&pair.all))), segments: segments(&pair.all) },
    ];
    let row = |(own, all): (&MedianCost, &MedianCost)| {
        let cell = |cost: &MedianCost| match cost.ran {
            true => [format!("{:.3} ms", ms(cost.ns)), format!("{} bytes", cost.bytes)],
            false => ["off".to_owned(), "0 bytes".to_owned()],
        };
        let class = if own.ran { "passed" } else { "" };
        (class, [vec![own.name.to_owned()], cell(own).to_vec(), cell(all).to_vec()].concat())
    };
    let head = ["stage or effect", "scene", "", "everything on", ""].map(str::to_owned).to_vec();
    let faster = total(&pair.all) as f64 / total(&pair.own) as f64;
    let megabytes = |bytes: usize| format!("{:.1} MB", bytes as f64 * 1e-6);
    Ok(Section {
        heading: format!("{}: {}", pair.scene, pair.object),
        lead: vec![format!(
            "{faster:.1} times faster than with everything on. Prepared for the scene it holds {}, with every table {}.",
            megabytes(pair.memory[0]),
            megabytes(pair.memory[1])
        )],
        plots: vec![(svg(&bars, "ms per strike")?, "Stages and effects, one after the other.".to_owned())],
        figures: vec![ReportFigure {
            png: pair.portrait.clone(),
            caption: format!("{SITES} sites, on the scene's terms"),
            scale: None,
        }],
        tables: vec![ReportTable { head, rows: pair.own.iter().zip(&pair.all).map(row).collect() }],
    })
}
