//! `shatterd bake`: a mesh file becomes a database.

use super::{Failure, out};
use crate::config::data_folder;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use shatter_fracture::database::{self, BakeRequest, Step};
use shatter_fracture::lattice::SPACING_RANGE;
use shatter_fracture::pipeline::{Learned, Prepared};
use shatter_fracture::scene::Materials;
use shatter_fracture::surface::{self, RawMesh, Surface, Unit, Up};
use shatter_fracture::token::Token;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The materials that come with the program.
pub const MATERIALS: &str = include_str!("../../../config/materials.toml");

/// A larger volume error than this is worth a warning.
const VOLUME_ERROR_TOLD: f64 = 0.03;

/// Flags of `shatterd bake`.
#[derive(Args, Debug)]
pub struct BakeArgs {
    /// Mesh file: .obj, .ply, .stl, .gltf, .glb
    pub mesh: PathBuf,
    /// Name of the object
    #[arg(long)]
    pub name: String,
    /// Material
    #[arg(long, default_value = "glass")]
    pub material: String,
    /// Table of materials to use instead of the built-in one
    #[arg(long, value_name = "FILE")]
    pub materials: Option<PathBuf>,
    /// Reference fragment size in metres [default: a tenth of the diagonal]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub fragment_size: Option<f64>,
    /// Threshold in J·m² [default: from material and fragment size]
    #[arg(long, value_name = "G", allow_negative_numbers = true)]
    pub gamma: Option<f64>,
    /// Unit of the mesh file: m, cm, mm, in
    #[arg(long, default_value = "m")]
    pub unit: Unit,
    /// Axis of the mesh file that points up: y, z
    #[arg(long, default_value = "y")]
    pub up: Up,
    /// Spacing of the elastic lattice over the bounding-box diagonal [default: about 3000 nodes, more where limbs are thin]
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    pub elastic_spacing: Option<f64>,
    /// Spacing of the crack lattice over the bounding-box diagonal [default: about 12000 nodes, more where walls are thin]
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    pub crack_spacing: Option<f64>,
    /// Impacts to learn the fracture degree from; 0: none, the closed form decides
    #[arg(long, value_name = "K", default_value_t = 0)]
    pub examples: u64,
    /// Add this many impacts to the examples of the database that is there; everything else stays as it was baked
    #[arg(long, value_name = "K", conflicts_with_all = [
        "examples", "material", "materials", "fragment_size", "gamma", "elastic_spacing", "crack_spacing", "seed",
    ])]
    pub add: Option<u64>,
    /// Seed of everything random
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    pub seed: u64,
    /// Folder of databases [default: the platform's]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// One JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// Bakes and prints what was found; nothing is written unless everything went well.
pub fn run(args: &BakeArgs) -> Result<(), Failure> {
    let begun = Instant::now();
    let request = request(args)?;
    let folder = args.out.clone().map_or_else(data_folder, Ok)?;
    out::folder(&folder)?;
    let raw = surface::read(&args.mesh, args.unit, args.up)?;
    let bar = bar();
    let mut show = |step| {
        bar.set_message(describe(step));
        match step {
            Step::Examples { done, of } => {
                bar.set_length(of);
                bar.set_position(done);
            }
            _ => bar.inc(1),
        }
    };
    let file = folder.join(format!("{}.{}", args.name, database::EXTENSION));
    let prepared = match args.add {
        None => database::bake(raw, &request, &Token::default(), &mut show)?,
        Some(count) => {
            let mut prepared = same_mesh(raw, &file)?;
            database::add_examples(&mut prepared, count, &Token::default(), &mut show)?;
            prepared
        }
    };
    bar.set_message("write");
    database::save(&prepared, &file)?;
    bar.finish_and_clear();
    let seconds = begun.elapsed().as_secs_f64();
    warn(&prepared);
    let text = if args.json {
        format!("{}\n", document(&prepared, &file, seconds))
    } else {
        screen(&prepared, &file, seconds)
    };
    out::print(&text)
}

/// The database that is there, if it was baked from this mesh.
fn same_mesh(raw: RawMesh, file: &Path) -> Result<Prepared, Failure> {
    let prepared = database::load(file)?;
    if prepared.report.input_hash == database::input_hash(&Surface::repair(raw)?) {
        return Ok(prepared);
    }
    let message = format!("{} was baked from another mesh, or with another unit or axis", file.display());
    Err(Failure::refused("other_mesh", file.display().to_string(), message))
}

fn request(args: &BakeArgs) -> Result<BakeRequest, Failure> {
    let table = match &args.materials {
        None => MATERIALS.to_owned(),
        Some(path) => out::read_text(path).map_err(|error| {
            Failure::refused("unreadable_file", path.display().to_string(), format!("{}: {error}", path.display()))
        })?,
    };
    Ok(BakeRequest {
        name: args.name.clone(),
        material_name: args.material.clone(),
        material: Materials::parse(&table)?.get(&args.material)?.clone(),
        fragment_size_m: args.fragment_size,
        gamma_j_m2: args.gamma,
        elastic_spacing: args.elastic_spacing,
        crack_spacing: args.crack_spacing,
        kappa: None,
        examples: args.examples,
        seed: args.seed,
    })
}

/// A bar on stderr; silent where that is not a terminal.
fn bar() -> ProgressBar {
    let bar = ProgressBar::new(7);
    if let Ok(style) = ProgressStyle::with_template("{bar:24} {pos}/{len} {msg} ({elapsed}, {eta} left)") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

fn describe(step: Step) -> String {
    match step {
        Step::Surface => "surface: weld, orient, name defects".to_owned(),
        Step::Volume => "volume: winding numbers".to_owned(),
        Step::Lattices => "lattices".to_owned(),
        Step::Lift(body) => format!("lift of body {body}"),
        Step::Elasticity(body) => format!("elasticity of body {body}"),
        Step::Calibration => "calibration of the degree".to_owned(),
        Step::Examples { .. } => "examples".to_owned(),
    }
}

/// Says on stderr when the lattice is too coarse for the shape: parts of about its spacing are lost or thickened.
fn warn(prepared: &Prepared) {
    let error = prepared.report.volume_error();
    if error.abs() > VOLUME_ERROR_TOLD {
        let (percent, spacing) = (100.0 * error, prepared.parameters.crack_spacing);
        let finer = match 0.5 * spacing {
            finer if finer >= SPACING_RANGE[0] => format!("; try --crack-spacing {finer:.4} (now {spacing:.4})"),
            _ => String::new(),
        };
        eprintln!(
            "warning: the lattice's volume is {percent:+.1} % off the input's: parts of about its spacing are lost or \
             thickened{finer}"
        );
    }
}

/// The document of `bake --json`.
fn document(prepared: &Prepared, file: &Path, seconds: f64) -> serde_json::Value {
    let report = &prepared.report;
    json!({
        "object": prepared.name,
        "file": file.display().to_string(),
        "elastic_nodes": prepared.elastic_nodes(),
        "elastic_tets": prepared.elastic_tets(),
        "crack_nodes": prepared.crack_nodes(),
        "crack_tets": prepared.crack_tets(),
        "elastic_spacing": prepared.parameters.elastic_spacing,
        "crack_spacing": prepared.parameters.crack_spacing,
        "lattice_volume_m3": report.lattice_volume_m3,
        "input_volume_m3": report.input_volume_m3,
        "volume_error": report.volume_error(),
        "surface_deviation": report.surface_deviation,
        "gamma_j_m2": prepared.gamma_j_m2,
        "kappa": prepared.kappa,
        "examples": prepared.examples.len(),
        "learned": prepared.learned.as_ref().map(|learned| learned.quality),
        "bodies": prepared.bodies.len(),
        "defects": report.defects,
        "unprepared": report.unprepared,
        "seconds": seconds,
    })
}

fn screen(prepared: &Prepared, file: &Path, seconds: f64) -> String {
    // Writing to a string cannot fail.
    let mut text = String::new();
    let report = &prepared.report;
    let parameters = &prepared.parameters;
    let _ = writeln!(text, "{}  {}", prepared.name, file.display());
    let _ = writeln!(
        text,
        "  elastic lattice  {} nodes, {} tetrahedra, spacing {:.4} of the diagonal",
        prepared.elastic_nodes(),
        prepared.elastic_tets(),
        parameters.elastic_spacing
    );
    let _ = writeln!(
        text,
        "  crack lattice    {} nodes, {} tetrahedra, spacing {:.4} of the diagonal",
        prepared.crack_nodes(),
        prepared.crack_tets(),
        parameters.crack_spacing
    );
    let _ = writeln!(
        text,
        "  volume           {:.6e} m³, {:+.3} % of the input's",
        report.lattice_volume_m3,
        100.0 * report.volume_error()
    );
    let _ = writeln!(text, "  deviation        {:.5} of the diagonal", report.surface_deviation);
    let _ = writeln!(
        text,
        "  threshold        {:.4e} J·m² ({}, fragments of {:.4} m), kappa {:.3}",
        prepared.gamma_j_m2, parameters.material_name, parameters.fragment_size_m, prepared.kappa
    );
    let _ = writeln!(text, "  bodies           {}", prepared.bodies.len());
    if let Some(Learned { quality, .. }) = &prepared.learned {
        let percent = |share: f64| 100.0 * share;
        let _ = writeln!(
            text,
            "  examples         {}; degrees of 8 and more with each left out: {:.1} % off (median), closed form {:.1} %, labels \
             themselves {:.1} %",
            prepared.examples.len(),
            percent(quality.median_relative_error),
            percent(quality.closed_form_median),
            percent(quality.label_noise_median)
        );
    }
    if report.defects.is_empty() {
        let _ = writeln!(text, "  defects          none");
    }
    for defect in &report.defects {
        let _ = writeln!(
            text,
            "  defect           {}: {} (first at {}): {}",
            defect.kind, defect.count, defect.first_index, defect.action
        );
    }
    for absent in &report.unprepared {
        let _ = writeln!(text, "  not prepared     lift {} of body {}: {}", absent.lift, absent.body, absent.reason);
    }
    let _ = writeln!(text, "  {seconds:.1} s");
    text
}
