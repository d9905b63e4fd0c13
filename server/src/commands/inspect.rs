//! `shatterd inspect`: contents of a database.

use super::expected_file::{self, ExpectedFile};
use super::inspect_memory::memory_table;
use super::{CommandError, bake_report, inspect_text, intact_mesh, lookup, output};
use crate::memory::{LoadGuard, ResidentMemory};
use clap::Args;
use serde_json::{Value, json};
use shatter_cli_common::lab;
use shatter_engine::wire::{CostReport, EngineObject};
use shatter_fracture::accuracy::{NORMAL_DEG, NormalShares};
use shatter_fracture::database;
use shatter_fracture::pipeline::{AnchoredBasis, PreparedObject};
use std::path::{Path, PathBuf};
use std::process::Stdio;

/// Arguments of `shatterd inspect`.
#[derive(Args, Debug)]
pub struct InspectArgs {
    /// Database file, or the name of an object in the folder of databases
    #[arg(value_name = "FILE|NAME")]
    pub file: PathBuf,
    /// Folder of databases, to find NAME in [default: the platform's]
    #[arg(long, value_name = "DIR")]
    pub databases: Option<PathBuf>,
    /// Folder for NAME.html, a page that shows what the object has learned
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Mesh file to write: the intact object (its exact surface if the database has one, else the boundary of its lattice; rays hit the same), coordinates of the object: meters, +Y up
    #[arg(long, value_name = "FILE.obj|FILE.glb")]
    pub mesh: Option<PathBuf>,
    /// Strike the object a few dozen times, and report the expected time per number of sites and its error
    #[arg(long)]
    pub time: bool,
    /// Report the memory that a daemon holds for the object, next to the resident memory of this process
    #[arg(long, conflicts_with = "time")]
    pub memory: bool,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// Loads and verifies the file as the daemon does, and prints its contents.
///
/// # Errors
/// [`CommandError`] for a database or mesh that cannot be read, or an output that cannot be written.
pub fn run(args: &InspectArgs) -> Result<(), CommandError> {
    let file = lookup::database(&args.file, args.databases.as_deref())?;
    expected_file::check(&file, ExpectedFile::Database)?;
    let damaged = |error| CommandError::database(&file, &error);
    let before = ResidentMemory::now();
    let loading = LoadGuard::begin();
    let served = EngineObject::whole(database::load(&file).map_err(damaged)?);
    drop(loading);
    let prepared = served.prepared();
    let memory = args.memory.then(|| memory_table(&served, before)).transpose()?;
    let provenance = database::load_provenance(&file).map_err(damaged)?;
    args.out.as_deref().map_or(Ok(()), |folder| page_folder(prepared, folder))?;
    let page = args.out.as_ref().map(|folder| folder.join(format!("{}.html", prepared.name)));
    if let Some(folder) = &args.out {
        draw_examples(&file, folder)?;
    }
    args.mesh.as_ref().map_or(Ok(()), |mesh| intact_mesh::write(prepared, mesh))?;
    let warnings = bake_report::repaired(prepared);
    warnings.iter().for_each(|text| bake_report::warning(text));
    let bytes = std::fs::metadata(&file).map_or(0, |metadata| metadata.len());
    let document = json!({
        "object": prepared.name,
        "file": file.display().to_string(),
        "format": database::FORMAT,
        "bytes": bytes,
        "bodies": prepared.bodies.len(),
        "elastic_nodes": prepared.elastic_nodes(),
        "crack_nodes": prepared.crack_nodes(),
        "elements_across": prepared.report.elements_across(),
        "discretisation_error": prepared.report.discretization_error(),
        "elastic": prepared.report.elastic,
        "stretch": prepared.report.stretch.map(|own| own.factor),
        "lattice_volume_m3": prepared.report.lattice_volume_m3,
        "gamma_j_m2": prepared.gamma_j_m2,
        "kappa": prepared.kappa,
        "examples": prepared.examples.len(),
        "impacts": prepared.impacts,
        "learned": prepared.learned.as_ref().map(|learned| learned.quality),
        "reduced": prepared.reduction,
        "anchored": prepared.anchored_bases.iter().map(anchored).collect::<Vec<_>>(),
        "lift_dimensions": prepared.bodies.iter().map(|body| body.interior.as_ref().map(|lift| lift.dimension)).collect::<Vec<_>>(),
        "surface_diffusion_dimensions": prepared
            .bodies
            .iter()
            .map(|body| body.surface_diffusion.as_ref().map(|lift| lift.dimension))
            .collect::<Vec<_>>(),
        "provenance": {
            "program": provenance.program,
            "version": provenance.version,
            "input_hash": prepared.report.input_hash,
        },
        "input_volume_m3": prepared.report.input_volume_m3,
        "surface": prepared.report.surface,
        "surface_deviation": prepared.report.surface_deviation,
        "normals_within_10_deg": normals(prepared),
        "parameters": prepared.parameters,
        "characteristic_length_m": prepared.strength_constants().characteristic_length_m(),
        "materials": prepared.report.materials,
        "skin_triangles": prepared.skin.as_ref().map(|skin| skin.triangles.len()),
        "cracks": prepared.report.cracks,
        "defects": bake_report::defects(&prepared.report.defects),
        "warnings": warnings,
        "unprepared": prepared.report.unprepared,
        "time": timing(&served, args.time)?,
        "memory": memory,
        "page": page.map(|path| path.display().to_string()),
        "mesh": args.mesh.as_ref().map(|path| path.display().to_string()),
    });
    if args.json {
        return output::print(&format!("{document}\n"));
    }
    output::lines(&inspect_text::screen(prepared, &file, &document))
}

/// A basis for anchors: its body, the number of nodes that do not move, and the number of displacements.
fn anchored(own: &AnchoredBasis) -> Value {
    json!({ "body": own.body, "nodes": own.nodes.len(), "rank": own.basis.rank() })
}

/// Shares of the outer area with accurate normals; `null` for an object without a skin.
fn normals(prepared: &PreparedObject) -> Value {
    NormalShares::of(prepared, NORMAL_DEG).map_or(
        Value::Null,
        |shares| json!({ "faces": shares.faces, "smooth": shares.smooth, "carried": shares.carried }),
    )
}

/// Expected times of requests; `null` if `asked` is false or no fit is possible.
fn timing(served: &EngineObject, asked: bool) -> Result<Value, CommandError> {
    let timing = if asked { served.timing()? } else { None };
    let Some(CostReport { cost, strikes, error_median, error_p90 }) = timing else {
        if asked {
            output::note(
                "no times (--time): those of the trial requests vary too much; try again when the machine is idle",
            );
        }
        return Ok(Value::Null);
    };
    Ok(json!({
        "reduced_ms": 1e3 * cost.reduced_s,
        "solve_ms": 1e3 * cost.solve_s,
        "start_ms": cost.start_s.map(|value| 1e3 * value),
        "iteration_ms": cost.iteration_s.map(|value| 1e3 * value),
        "rest_ms": cost.rest_s.map(|value| 1e3 * value),
        "strikes": strikes,
        "log_error_median": error_median,
        "log_error_p90": error_p90,
    }))
}

/// Creates the folder of the page, if there is something to show.
fn page_folder(prepared: &PreparedObject, folder: &Path) -> Result<(), CommandError> {
    if prepared.learned.is_none() {
        let message = "the database has no examples or too few to learn from; bake it with --examples 64";
        return Err(CommandError::refused("no_examples", "", message));
    }
    output::folder(folder)
}

/// Runs the lab to draw the page of what the object has learned.
fn draw_examples(file: &Path, folder: &Path) -> Result<(), CommandError> {
    let output = lab::program().arg("examples").arg(file).arg("--out").arg(folder).stdin(Stdio::null()).output();
    let output = output.map_err(|error| CommandError::from(lab::absent(&error)))?;
    let report = String::from_utf8_lossy(&output.stderr);
    report.lines().for_each(output::note);
    match output.status.success() {
        true => Ok(()),
        false => Err(CommandError::ours("page", format!("{} drew no page: {}", lab::PROGRAM, report.trim()))),
    }
}
