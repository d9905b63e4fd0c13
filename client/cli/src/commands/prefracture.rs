//! `shatter prefracture`.

use super::files::{FileFormat, OutputTarget};
use super::impact::{RequestEcho, to_json};
use super::parse::{effect, lift, quality, sites};
use super::result_text::screen;
use super::{CliError, RESULT_TIMEOUT, document, note_one_piece, reply};
use shatter_client::{Client, Deadline, Effect, Lift, Quality, SEED_DEFAULT};
use std::path::PathBuf;

/// Arguments of `shatter prefracture`.
#[derive(clap::Args)]
pub struct Args {
    /// Object to divide
    object: String,
    /// Number of fragments; a cell that falls apart adds one, one that is too small (`slivers`) removes one, and every body makes at least one
    #[arg(long, value_name = "N", value_parser = sites, allow_negative_numbers = true)]
    degree: u32,
    /// Lift: `euclidean`, `interior` (the default) or `surface_diffusion`
    #[arg(long, value_name = "euclidean|interior|surface_diffusion", value_parser = lift)]
    lift: Option<Lift>,
    /// Preset that sets how well the cells are centered [default: the object's]
    #[arg(long, value_name = "draft|game|film|reference", value_parser = quality)]
    quality: Option<Quality>,
    /// Effects to switch on, separated by commas
    #[arg(long, value_name = "EFFECT,..", value_delimiter = ',', value_parser = effect)]
    enable: Vec<Effect>,
    /// Effects to switch off, separated by commas
    #[arg(long, value_name = "EFFECT,..", value_delimiter = ',', value_parser = effect)]
    disable: Vec<Effect>,
    /// Seed of all random choices
    #[arg(long, default_value_t = SEED_DEFAULT)]
    seed: u64,
    /// File for the fragments, or folder for OBJECT.glb. FILE.glb contains closed meshes, which end on the triangles of the mesh file if
    /// the surface is exact. If it is the lattice's and the object has a skin, FILE.glb contains that for rendering (`skin` is then on
    /// unless --disable names it), and FILE.closed.glb the closed meshes. Hulls, if they are on, go to FILE.hulls.glb. FILE.xml is a model for MuJoCo, with its meshes in FILE_assets beside it;
    /// `bonds` and `hulls` are then on unless --disable names them
    #[arg(long, value_name = "FILE.glb|FILE.xml|DIR")]
    out: PathBuf,
    /// Format of files in a folder: `glb` (the default), `obj` (one file per fragment, fragments.mtl, fragments.json), or `mjcf`
    #[arg(long, value_enum)]
    format: Option<FileFormat>,
    /// Mesh file (.glb, .gltf) whose materials and textures the written .glb gets; needs the effect `attributes`, which is then on. Give
    /// the file that the object was baked from
    #[arg(long, value_name = "FILE.glb|FILE.gltf")]
    materials: Option<PathBuf>,
    /// Print one JSON document on stdout, as of an impact
    #[arg(long)]
    json: bool,
}

/// Divides an object evenly and prints the result.
pub fn run(service: &str, args: &Args) -> Result<(), CliError> {
    let target = OutputTarget::new(&args.out, args.format, &args.object)?
        .with_materials(args.materials.as_deref(), &args.disable)?;
    let object = Client::connect(service, reply())?.object(&args.object, reply())?;
    let load = object.even(args.degree, Deadline::after(RESULT_TIMEOUT))?.seed(args.seed);
    let load = args.lift.map_or(load.clone(), |lift| load.lift(lift));
    let load = args.quality.map_or(load.clone(), |quality| load.quality(quality));
    let load = args.enable.iter().fold(load, |load, effect| load.enable(*effect));
    let load = args.disable.iter().fold(load, |load, effect| load.disable(*effect));
    let result = target.strike(&object, &load, [&args.enable, &args.disable], || Deadline::after(RESULT_TIMEOUT))?;
    let files = target.write(&result)?;
    note_one_piece(&result);
    let asked = RequestEcho { convention: "gltf", has_impact: false, error_max: None, time_ms_max: None };
    if args.json { document(&to_json(&result, asked, &files)) } else { screen(&result) }
}
