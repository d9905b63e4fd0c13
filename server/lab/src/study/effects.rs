//! Cost of effects: the objects of every shipped scene, struck under the scene's policy and with everything on.

use super::bars::{Segment, StackedBar, svg};
use super::gallery;
use super::plot::PlotError;
use crate::picture::PictureError;
use crate::report::{ReportFigure, ReportTable, Section, Study};
use bytemuck::Zeroable;
use nalgebra::{Point3, Vector3};
use serde_json::{Value, json};
use shatter_engine::object::{ServedObject, write_profiled};
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
use shatter_proto::result::{AlignedBlock, StageKind};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// Shipped scenes: name and text.
pub const SHIPPED: [(&str, &str); 3] = [
    ("glass_shop", include_str!("../../../../config/scenes/glass_shop.toml")),
    ("stone_arch", include_str!("../../../../config/scenes/stone_arch.toml")),
    ("hero_statue", include_str!("../../../../config/scenes/hero_statue.toml")),
];

/// Number of timed requests, whose median is shown; one more before them warms up.
const STRIKES: u64 = 15;

/// Sites of each request, fixed because effects are compared.
const SITES: u32 = 24;

/// Error of the study.
#[derive(Debug, thiserror::Error)]
pub enum EffectsError {
    /// A scene or a request was refused.
    #[error(transparent)]
    Refused(#[from] Error),
    /// An object could not be baked.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// The controls of a scene do not suit its object.
    #[error(transparent)]
    Warp(#[from] WarpError),
    /// The anchors of a scene do not hold its object.
    #[error(transparent)]
    Hold(#[from] AnchorError),
    /// A plot could not be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// A picture could not be drawn.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// The built-in materials are invalid.
    #[error("materials: {0}")]
    Materials(String),
    /// An object that should break stays whole.
    #[error("`{0}` stays whole, so there is nothing to show")]
    Whole(String),
}

/// Medians of the cost of one stage or effect.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MedianCost {
    /// Name of the stage or effect.
    pub name: &'static str,
    /// Whether it ran.
    pub ran: bool,
    /// Time, ns.
    pub ns: u64,
    /// Output, bytes.
    pub bytes: u64,
}

/// Cost of one object under the scene's policy, and with everything on.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneCosts {
    /// Name of the scene.
    pub scene: &'static str,
    /// Name of the object.
    pub object: String,
    /// Costs under the scene's policy.
    pub own: Vec<MedianCost>,
    /// Costs with everything on.
    pub all: Vec<MedianCost>,
    /// Picture of the broken object under the scene's policy; PNG.
    pub portrait: Vec<u8>,
    /// Memory of the tables that the scene needs, and of all tables, bytes.
    pub memory: [usize; 2],
}

/// Total time of stages and effects, ns.
fn total(costs: &[MedianCost]) -> u64 {
    costs.iter().map(|cost| cost.ns).sum()
}

/// Bakes and strikes the objects of all shipped scenes; calls `progress` with the name of each.
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

/// Engine request of the portrait.
fn request_of(prepared: &Arc<PreparedObject>, terms: &ObjectPolicy) -> Result<pipeline::FractureRequest, Error> {
    EngineObject::new(prepared.clone(), terms.clone()).request(&request(prepared, 1))
}

/// Median costs of requests spread over the object.
fn costs(prepared: &Arc<PreparedObject>, terms: ObjectPolicy) -> Result<Vec<MedianCost>, EffectsError> {
    let served = EngineObject::new(prepared.clone(), terms);
    let (mut workspace, mut payload) = (Workspace::default(), Vec::new());
    let mut runs = Vec::new();
    for number in 0..=STRIKES {
        let clock = StageProfiler::default();
        let strike = request(prepared, number);
        let outcome = served.strike(&strike, &mut workspace, &CancelToken::default(), &clock)?;
        let layout = Layout::new(&outcome.counts()).ok_or_else(too_large)?;
        payload.resize(payload.len().max(layout.blocks()), AlignedBlock::zeroed());
        let mut sections = layout.split(&mut payload[..layout.blocks()]).ok_or_else(too_large)?;
        write_profiled(outcome.as_ref(), &mut sections, layout.base_bytes(), &clock)?;
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
    Error::new(shatter_proto::ErrorKind::ResultTooLarge, "results", "the result is too large for 32-bit offsets")
}

/// Impact at a random point of the surface, inward.
fn request(prepared: &PreparedObject, number: u64) -> Request {
    let (point, inward): (Point3<f64>, Vector3<f64>) =
        ImpactSampler::new(prepared).point(&mut RandomStream::new(prepared.parameters.seed, number));
    let point_m = prepared.frame.to_meters(&point).coords.into();
    let contact =
        Contact { point_m, ray: None, impulse_ns: inward.into(), duration_s: None, radius_m: None, partner: None };
    Request {
        object: prepared.name.clone(),
        contacts: vec![contact],
        degree: DegreeRule::Sites(SITES),
        seed: number,
        ..Request::default()
    }
}

/// JSON document of all costs.
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

/// Page with the costs of every object, and pictures.
pub fn page(pairs: &[SceneCosts], gallery: Section) -> Result<Study, EffectsError> {
    let mut sections = pairs.iter().map(section).collect::<Result<Vec<_>, _>>()?;
    sections.push(gallery);
    let lead = format!(
        "Every object of the shipped scenes, struck {STRIKES} times with {SITES} sites, under its scene's policy and with everything \
             on; medians. Hatched parts are off in the scene; their length is their time with everything on, which the scene saves."
    );
    Ok(Study { title: "Cost of effects".to_owned(), lead: vec![lead], facts: Vec::new(), sections })
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
        plots: vec![(svg(&bars, "ms per request")?, "Stages and effects, one after the other.".to_owned())],
        figures: vec![ReportFigure {
            png: pair.portrait.clone(),
            caption: format!("{SITES} sites, under the scene's policy"),
            scale: None,
        }],
        tables: vec![ReportTable { head, rows: pair.own.iter().zip(&pair.all).map(row).collect() }],
    })
}
