//! `shatterd bake`: turns a mesh file into a database.

use super::bake_progress::BakeProgress;
use super::{CommandError, bake_report, bake_scene, interrupt, mesh_file, output, shares, size, stdin};
use crate::config::data_folder;
use clap::Args;
use shatter_cli_common::{choice, whole_number};
use shatter_fracture::database::{self, BakeError, BakeRequest, BakeShare, EXAMPLES_MAX, PartialBake, Tables};
use shatter_fracture::pipeline::{DisplacementMethod, ElementChoice, PreparedObject, Preset, SurfaceKind};
use shatter_fracture::scene::{MATERIALS, Materials};
use shatter_fracture::sparse::Precision;
use shatter_fracture::surface::{CrackSheets, LengthUnit, RawMesh, Surface, UpAxis, shapes};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `shatterd bake`.
#[derive(Args, Debug)]
pub struct BakeArgs {
    /// Mesh file: .obj, .ply, .stl, .gltf, .glb, .msh, .vtk, .mesh
    #[arg(required_unless_present_any = ["scene", "shape"])]
    pub mesh: Option<PathBuf>,
    /// Generated shape to bake instead of a mesh file, in meters, +Y up
    #[arg(long, value_name = "SHAPE", value_parser = shapes::NAMES, conflicts_with_all = ["mesh", "scene", "unit", "up"])]
    pub shape: Option<String>,
    /// Mesh file of existing cracks, in the unit and axes of the other mesh: open sheets of triangles without thickness, facing either
    /// way. The object is elastically open there, and no cell crosses a sheet. The lattices have slots there, 1.7 spacings wide
    #[arg(long, value_name = "SHEETS")]
    pub cracks: Option<PathBuf>,
    /// Name of the object [default with --shape: the shape's name]
    #[arg(long, required_unless_present_any = ["scene", "shape"])]
    pub name: Option<String>,
    /// Scene file to bake instead of a mesh: every object with a generated shape; databases that are up to date are kept. Databases of
    /// anchored objects with thin walls, also those of meshes, get displacements for the scene's anchors, and lose those for other anchors
    #[arg(long, value_name = "FILE", conflicts_with_all = [
        "mesh", "shape", "name", "material", "materials", "fragment_size", "gamma", "unit", "up", "elastic_spacing", "crack_spacing",
        "examples", "elastic", "factor", "elements", "quality", "surface", "add", "seed", "cracks", "shard", "resume", "restart",
    ])]
    pub scene: Option<PathBuf>,
    /// Material
    #[arg(long, default_value = "glass")]
    pub material: String,
    /// Table of materials that replaces the built-in one
    #[arg(long, value_name = "FILE")]
    pub materials: Option<PathBuf>,
    /// Reference fragment size in meters [default: a tenth of the diagonal]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub fragment_size: Option<f64>,
    /// Fracture threshold in J·m² [default: from material and fragment size]
    #[arg(long, value_name = "G", allow_negative_numbers = true)]
    pub gamma: Option<f64>,
    /// Unit of the mesh file: m, cm, mm, in [default: m, with a warning if the object is 5 m large or weighs 5 t]
    #[arg(long)]
    pub unit: Option<LengthUnit>,
    /// Axis of the mesh file that points up: y, z
    #[arg(long, default_value = "y")]
    pub up: UpAxis,
    /// Preset of the lattices; explicit spacings override it. A preset that severs parts of the mesh is refused unless it is named
    /// here [default: game]
    #[arg(long, value_name = "draft|game|film|reference", value_parser = quality)]
    pub quality: Option<Preset>,
    /// Spacing of the elastic lattice as a fraction of the bounding-box diagonal [default: the preset's, about 3000 nodes for game,
    /// more where limbs are thin]
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    pub elastic_spacing: Option<f64>,
    /// Spacing of the crack lattice as a fraction of the bounding-box diagonal [default: the preset's, about 9000 nodes for game,
    /// more where walls are thin]
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    pub crack_spacing: Option<f64>,
    /// Surface of the fragments: `exact` is the input surface, after small holes are closed and parts that intersect are united. If
    /// that fails, it is the lattice's, with a warning that gives the reason. `lattice` approximates the input, in less time and memory
    /// [default: exact, or lattice with --cracks]
    #[arg(long, value_name = "exact|lattice", value_parser = surface)]
    pub surface: Option<SurfaceKind>,
    /// Number of impacts from which the object learns its fracture degree; 0: the closed form decides
    #[arg(long, value_name = "K", default_value_t = 0, value_parser = whole_number::<u64>(0..=EXAMPLES_MAX as u64))]
    pub examples: u64,
    /// Source of displacements: `reduced` builds a basis from the examples and uses it where it is accurate enough; `solve` always
    /// solves and builds no basis
    #[arg(long, value_name = "reduced|solve", default_value = "reduced", value_parser = elastic)]
    pub elastic: DisplacementMethod,
    /// Precision of the stored stiffness factor: `f32` halves the memory of `f64`; bodies for which it is too inaccurate keep `f64`
    #[arg(long, value_name = "f64|f32", default_value = "f64", value_parser = factor)]
    pub factor: Precision,
    /// Order of the elements: `quadratic` ones bend where few cells lie across a wall, but a bake takes two to ten times as long; `auto` takes
    /// them in bodies with fewer than five cells across their walls, or where linear ones would miss more than 15 % of the elastic energy
    #[arg(long, value_name = "auto|linear|quadratic", default_value = "auto", value_parser = elements)]
    pub elements: ElementChoice,
    /// Add K impacts to the examples of the existing database; everything else stays as baked
    #[arg(long, value_name = "K", value_parser = whole_number::<u64>(0..=EXAMPLES_MAX as u64), conflicts_with_all = [
        "examples", "elastic", "factor", "elements", "quality", "surface", "material", "materials", "fragment_size", "gamma", "elastic_spacing", "crack_spacing", "seed",
    ])]
    pub add: Option<u64>,
    /// Seed of all random choices
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    pub seed: u64,
    /// Bake only share I of N of the examples, I from 0, into NAME.I-of-N.share, for `shatterd merge` [default: 0/1, or the task's
    /// own share in a Slurm job array or an indexed Kubernetes job]
    #[arg(long, value_name = "I/N")]
    pub shard: Option<BakeShare>,
    /// Continue an interrupted bake with the examples that it kept; start from the beginning if there are none
    #[arg(long)]
    pub resume: bool,
    /// Start again and discard the examples that an earlier bake of this name kept
    #[arg(long, conflicts_with = "resume")]
    pub restart: bool,
    /// Folder of databases [default: the platform's]
    #[arg(long, value_name = "DIR", visible_alias = "databases")]
    pub out: Option<PathBuf>,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
    /// End when standard input ends, as at SIGTERM: for a program that starts a bake and holds the other end of a pipe
    #[arg(long)]
    pub end_with_stdin: bool,
}

/// Bakes and prints a report. An existing database stays intact until the new one replaces it.
///
/// # Errors
/// [`CommandError`] by what is wrong with mesh, arguments or files.
pub fn run(args: &BakeArgs) -> Result<(), CommandError> {
    if args.end_with_stdin {
        stdin::at_end(interrupt::terminate)?;
    }
    let folder = args.out.clone().map_or_else(data_folder, Ok)?;
    if let Some(scene) = &args.scene {
        return bake_scene::run(scene, &folder, args.json);
    }
    match args.name.as_ref().or(args.shape.as_ref()) {
        Some(name) => one(args, name, &folder),
        None => Err(nothing_to_bake()),
    }
}

fn nothing_to_bake() -> CommandError {
    CommandError::refused("usage", "", "give a mesh and its --name, a --shape, or a --scene")
}

/// The mesh to bake, read from its file or generated.
fn mesh(args: &BakeArgs) -> Result<RawMesh, CommandError> {
    match (&args.mesh, &args.shape) {
        (Some(file), _) => read(file, args),
        (None, Some(shape)) => shapes::by_name(shape).ok_or_else(nothing_to_bake),
        (None, None) => Err(nothing_to_bake()),
    }
}

/// Bakes one object of a mesh file or of a generated shape.
fn one(args: &BakeArgs, name: &str, folder: &Path) -> Result<(), CommandError> {
    let begun = Instant::now();
    let token = interrupt::token();
    let mut request = request(args, name)?;
    let new = args.add.unwrap_or(args.examples);
    let share = shares::share(args.shard, new)?;
    output::folder(folder)?;
    let file = folder.join(format!("{name}.{}", database::EXTENSION));
    let kept = share.file(folder, name);
    if !args.resume && !args.restart {
        shares::nothing_kept(&kept)?;
    }
    let raw = mesh(args)?;
    let is_file = args.shape.is_none();
    let doubtful = is_file.then(|| size::doubtful(&raw, args.unit, request.material.density_kg_m3)).flatten();
    let earlier: Vec<String> = doubtful.into_iter().chain(large_fragments(&raw, &request)).collect();
    earlier.iter().for_each(|text| bake_report::warning(text));
    request.cracks = args.cracks.as_ref().map(|file| read(file, args)).transpose()?;
    if args.add.is_none() && replaces_another(&file, &raw, &request) {
        bake_report::warning(&format!(
            "the database of `{name}` will be replaced; it was baked from another mesh, another unit or other cracks. To keep it, stop this \
             command (Ctrl-C) and give another --name"
        ));
    }
    let resumed = if args.resume { shares::resume(&kept, &raw, args, &request, share)? } else { None };
    let bar = BakeProgress::new(name, share.size(new));
    let begin = || match args.add {
        None => PartialBake::begin(raw, &request, share, &token, &mut |step| bar.show(step))
            .map_err(|error| mesh_file::bake_error(error, args.mesh.as_deref())),
        Some(count) => Ok(PartialBake::add(same_mesh(raw, &request, &file)?, count, share)?),
    };
    let partial = resumed.map_or_else(begin, Ok)?;
    let partial = shares::work(partial, &kept, &token, &bar)?;
    if share.count > 1 {
        bar.finish();
        return output::print(&shares::resume_message(&partial, &kept, args.json));
    }
    let prepared = partial.learn(&token, &mut |step| bar.show(step))?;
    bar.show_step("write");
    let writing = interrupt::writing();
    database::save(&prepared, &file).map_err(|error| CommandError::database(&file, &error))?;
    drop(writing);
    shares::forget(&kept)?;
    bar.finish();
    bake_report::tell(&prepared, &file, begun.elapsed(), earlier, args.json)
}

/// Warning about a requested fragment size that is larger than the mesh.
pub fn large_fragments(raw: &RawMesh, request: &BakeRequest) -> Option<String> {
    let size_m = request.fragment_size_m.filter(|_| request.gamma_j_m2.is_none())?;
    bake_report::large_fragments(size_m, size::diagonal_m(raw))
}

fn factor(text: &str) -> Result<Precision, String> {
    choice(text, &[("f64", Precision::F64), ("f32", Precision::F32)])
}

fn elements(text: &str) -> Result<ElementChoice, String> {
    choice(text, &ElementChoice::ALL.map(|kind| (kind.name(), kind)))
}

fn surface(text: &str) -> Result<SurfaceKind, String> {
    choice(text, &SurfaceKind::ALL.map(|kind| (kind.name(), kind)))
}

fn elastic(text: &str) -> Result<DisplacementMethod, String> {
    choice(text, &[("reduced", DisplacementMethod::Reduced), ("solve", DisplacementMethod::Solve)])
}

fn quality(text: &str) -> Result<Preset, String> {
    let names = ["draft", "game", "film", "reference"];
    Preset::by_name(text).ok_or_else(|| choice(text, &names.map(|name| (name, ()))).err().unwrap_or_default())
}

/// True if `file` is a database of another mesh, or of the same one with another unit or other cracks. A mesh that cannot be baked
/// replaces nothing.
fn replaces_another(file: &Path, raw: &RawMesh, request: &BakeRequest) -> bool {
    let differs = |earlier: String| input_hash(raw.clone(), request).is_ok_and(|hash| hash != earlier);
    database::load_input_hash(file).is_ok_and(differs)
}

/// Reads a mesh file in its unit and axes.
fn read(file: &Path, args: &BakeArgs) -> Result<RawMesh, CommandError> {
    mesh_file::read(file, args.unit.unwrap_or(LengthUnit::M), args.up)
}

/// Hash of mesh and cracks.
///
/// # Errors
/// [`CommandError`] for a mesh that cannot be repaired, or cracks that do not fit it.
pub fn input_hash(raw: RawMesh, request: &BakeRequest) -> Result<String, CommandError> {
    let surface = Surface::repair(raw)?;
    let sheets = request.cracks.as_ref().map(|cracks| CrackSheets::new(cracks, &surface.frame)).transpose();
    Ok(database::input_hash(&surface, sheets.map_err(BakeError::Cracks)?.as_ref()))
}

/// Loads the existing database, if it was baked from this mesh and these cracks.
fn same_mesh(raw: RawMesh, request: &BakeRequest, file: &Path) -> Result<PreparedObject, CommandError> {
    if !file.exists() {
        let message = format!("there is no {} to add examples to; bake it without --add first", file.display());
        return Err(CommandError::refused("database_file", file.display().to_string(), message));
    }
    let prepared = database::load(file).map_err(|error| CommandError::database(file, &error))?;
    if prepared.report.input_hash == input_hash(raw, request)? {
        return Ok(prepared);
    }
    let message = format!(
        "{} was baked from another mesh, other cracks, another unit or another axis; pass the original ones",
        file.display()
    );
    Err(CommandError::refused("other_mesh", file.display().to_string(), message))
}

fn request(args: &BakeArgs, name: &str) -> Result<BakeRequest, CommandError> {
    let table = match &args.materials {
        None => MATERIALS.to_owned(),
        Some(path) => shatter_engine::scene::read_text(path).map_err(|error| {
            CommandError::refused("unreadable_file", path.display().to_string(), format!("{}: {error}", path.display()))
        })?,
    };
    let material = Materials::parse(&table).and_then(|materials| materials.get(&args.material).cloned());
    let material = material.map_err(|error| match &args.materials {
        Some(file) => CommandError::from(error).of_file(file),
        None => error.into(),
    })?;
    Ok(BakeRequest {
        name: name.to_owned(),
        material_name: args.material.clone(),
        material,
        fragment_size_m: args.fragment_size,
        gamma_j_m2: args.gamma,
        quality: args.quality.unwrap_or_default(),
        allows_severed: args.quality.is_some(),
        elastic_spacing: args.elastic_spacing,
        crack_spacing: args.crack_spacing,
        kappa: None,
        examples: args.examples,
        elastic: args.elastic,
        factor: args.factor,
        surface: args.surface.unwrap_or(if args.cracks.is_some() { SurfaceKind::Lattice } else { SurfaceKind::Exact }),
        elements: args.elements,
        tables: Tables::ALL,
        seed: args.seed,
        cracks: None,
    })
}
