//! `shatterd check`: the plan of a scene, before anything runs.

use super::expected_file::{self, ExpectedFile};
use super::{CommandError, bake_report, lookup, output};
use crate::config::data_folder;
use clap::Args;
use serde_json::{Value, json};
use shatter_engine::scene::{Scene, SceneObject, tables};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{self, EXTENSION, Tables};
use shatter_fracture::scene::{Anchors, WarpControls};
use shatter_proto::effect::{Class, Effect};
use shatter_proto::name::nearest;
use shatter_proto::text::counted;
use shatter_proto::{Error, ErrorKind};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Number of anchors of an object that have a line.
const ANCHORS_SHOWN: usize = 8;

/// Arguments of `shatterd check`.
#[derive(Args, Debug)]
pub struct CheckArgs {
    /// Scene file
    pub scene: PathBuf,
    /// Folder of databases [default: the platform's]
    #[arg(long, value_name = "DIR")]
    pub databases: Option<PathBuf>,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// Reads the scene and prints its plan, with table sizes from the databases that exist.
///
/// # Errors
/// [`CommandError`] by what is wrong with the scene or a database.
pub fn run(args: &CheckArgs) -> Result<(), CommandError> {
    let folder = args.databases.clone().map_or_else(data_folder, Ok)?;
    no_object(&args.scene, &folder)?;
    expected_file::check(&args.scene, ExpectedFile::Scene)?;
    let scene = Scene::load(&args.scene)?;
    let of_scene = |error: CommandError| error.of_scene(&args.scene);
    scene.recipes().map_err(|error| of_scene(error.into()))?;
    let baked = lookup::names(&folder);
    let objects = scene.objects.iter().map(|(name, object)| plan(name, object, &folder, &baked));
    let objects = objects.collect::<Result<Vec<_>, CommandError>>().map_err(of_scene)?;
    unbaked(&objects);
    if args.json {
        return output::print(&format!("{}\n", json!({ "scene": scene.title, "objects": objects })));
    }
    output::print(&(screen(&scene.title, &objects) + &missing(args, &objects)))
}

/// Refuses the name of an object in `folder` where a scene file is wanted.
fn no_object(scene: &Path, folder: &Path) -> Result<(), CommandError> {
    let name = scene.to_string_lossy();
    if scene.exists() || !lookup::names(folder).iter().any(|own| *own == name) {
        return Ok(());
    }
    let message = format!(
        "`{name}` is the name of an object, and this command takes a scene (a TOML file with a table [objects.NAME] for each object); \
         show the object by `shatterd inspect {name}`"
    );
    Err(Error::new(ErrorKind::Configuration, &*name, message).into())
}

/// Warns of objects without a database that no shape of the scene can be baked into.
fn unbaked(objects: &[Value]) {
    for object in objects.iter().filter(|object| object["baked"] == false && object["shape"].is_null()) {
        let word = |key: &str| object[key].as_str().unwrap_or_default();
        let (name, file) = (word("object"), word("database"));
        bake_report::warning(&format!("object `{name}` has no database: {file} does not exist{}", likely(object)));
    }
}

/// Suggestion of databases with a similar name.
fn likely(object: &Value) -> String {
    let names = object["nearest"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let names: Vec<String> = names.map(|name| format!("`{name}`")).collect();
    if names.is_empty() { String::new() } else { format!("; did you mean the database {}?", names.join(" or ")) }
}

/// Commands that bake the missing databases.
fn missing(args: &CheckArgs, objects: &[Value]) -> String {
    let shaped = objects.iter().filter(|own| !own["shape"].is_null()).filter_map(|own| own["database"].as_str());
    let shaped: BTreeSet<&str> = shaped.collect();
    let absent = objects.iter().filter(|object| object["baked"] == false);
    let (scene, mesh): (Vec<_>, Vec<_>) =
        absent.partition(|object| object["database"].as_str().is_some_and(|own| shaped.contains(own)));
    let folder = args.databases.as_ref().map_or(String::new(), |folder| format!(" --databases {}", folder.display()));
    let scene = (!scene.is_empty()).then(|| format!("shatterd bake --scene {}{folder}", args.scene.display()));
    let mesh = (!mesh.is_empty()).then(|| format!("shatterd bake MESH --name NAME{folder}"));
    let ways: Vec<String> = scene.into_iter().chain(mesh).collect();
    if ways.is_empty() { String::new() } else { format!("\nto bake the missing databases: {}\n", ways.join(", ")) }
}

fn plan(name: &str, object: &SceneObject, folder: &Path, baked: &[String]) -> Result<Value, CommandError> {
    let terms = &object.terms;
    let file = folder.join(format!("{}.{EXTENSION}", object.database));
    material(name, object, &file)?;
    warp(name, &terms.controls, &file)?;
    let sizes = match file.exists() {
        true => Some(database::tensor_bytes(&file).map_err(|error| CommandError::database(&file, &error))?),
        false => None,
    };
    let effect = |effect: Effect| {
        let state = match (terms.on.has(effect), terms.allowed.has(effect)) {
            (true, _) => "on",
            (false, true) => "allowed",
            (false, false) => "off",
        };
        json!({
            "name": effect.name(),
            "class": if effect.class() == Class::Physics { "physics" } else { "output" },
            "state": state,
            "needs": effect.needs().map(Effect::name),
            "paid": effect.cost(),
        })
    };
    let table = |table: shatter_engine::scene::OptionalDatabaseTable| {
        let own = |tensor: &str| table.tensors.iter().any(|part| tensor.contains(part));
        let bytes =
            sizes.as_ref().map(|sizes| sizes.iter().filter(|(tensor, _)| own(tensor)).map(|(_, n)| n).sum::<u64>());
        let is_left_out = bytes == Some(0) && OPTIONAL.contains(&table.name);
        json!({ "name": table.name, "loaded": table.wanted && !is_left_out, "bytes": bytes })
    };
    let tables = tables(terms.tables()).map(table);
    let absent = |row: &&Value| row["loaded"] == true && row["bytes"] == 0;
    if let Some(row) = tables.iter().find(absent) {
        let (key, table) = (format!("objects.{name}"), row["name"].as_str().unwrap_or_default());
        let message = format!("{key}: {} was baked without the table `{table}`; bake it again", file.display());
        return Err(Error::new(ErrorKind::Configuration, key, message).into());
    }
    let on = |effect: Effect| terms.on.has(effect);
    let stages = [
        ("load", true),
        ("elasticity", on(Effect::Elastic)),
        ("threshold", true),
        ("degree", true),
        ("centroidal", true),
        ("labels", true),
        ("tessellation", true),
        ("fragments", true),
    ];
    let nearest = match sizes.is_none() && object.shape.is_none() {
        true => suggested(&object.database, baked),
        false => None,
    };
    let (anchors, lacks_basis) = anchors(name, &terms.anchors, &file)?;
    if lacks_basis && terms.allowed.has(Effect::Anchored) {
        bake_report::warning(&format!(
            "object `{name}`: {} has no displacements for its anchors, so that impacts on the anchored object take many times as long; \
             add them by `shatterd bake --scene FILE`",
            file.display()
        ));
    }
    Ok(json!({
        "object": name,
        "database": file.display().to_string(),
        "baked": sizes.is_some(),
        "nearest": nearest,
        "shape": object.shape,
        "material": object.material.as_ref().map(|(name, _)| name),
        "stages": stages.map(|(name, runs)| json!({ "name": name, "runs": runs })),
        "effects": Effect::ALL.map(effect),
        "tables": tables,
        "criterion": terms.criterion.name(),
        "strength_scale": terms.strength_scale,
        "anchors": anchors,
        "gravity_m_s2": terms.anchors.gravity_m_s2.map(|gravity| [gravity.x, gravity.y, gravity.z]),
        "sites_max": terms.sites_max,
        "fragments_max": terms.fragments_max,
        "bytes_max": terms.bytes_max,
    }))
}

/// Those databases of `baked` with names similar to `name`.
fn suggested(name: &str, baked: &[String]) -> Option<Vec<String>> {
    let all: Vec<&str> = baked.iter().map(String::as_str).collect();
    let likely = nearest(name, &all);
    (!likely.is_empty()).then(|| likely.into_iter().map(str::to_owned).collect())
}

/// Tables that an object may be served without: the scene asked for no examples, or the bake could not make the lift.
const OPTIONAL: [&str; 2] = ["examples", "surface_diffusion"];

/// Refuses a database whose material differs from the scene's.
fn material(name: &str, object: &SceneObject, file: &Path) -> Result<(), CommandError> {
    let Some((wanted, _)) = object.material.as_ref().filter(|_| file.exists()) else { return Ok(()) };
    let found = database::load_parameters(file).map_err(|error| CommandError::database(file, &error))?.material_name;
    if found == *wanted {
        return Ok(());
    }
    let (key, at) = (format!("objects.{name}.material"), file.display());
    let message = format!(
        "{key}: {at} was baked as {found}, but the scene needs {wanted}; bake it again with `--material {wanted}`"
    );
    Err(Error::new(ErrorKind::Configuration, key, message).into())
}

/// Applies the artist's controls to the database, if it exists.
fn warp(name: &str, controls: &WarpControls, file: &Path) -> Result<(), CommandError> {
    if controls.is_silent() || !file.exists() {
        return Ok(());
    }
    let prepared = database::load_tables(file, Tables::NONE).map_err(|error| CommandError::database(file, &error))?;
    prepared.warped(controls, &CancelToken::default()).map(drop).map_err(|error| {
        let (key, message) = (format!("objects.{name}.warp"), format!("objects.{name}: {error}"));
        Error::new(ErrorKind::Configuration, key, message).into()
    })
}

/// Anchors of the object, with the number of nodes that each holds if the database exists, and whether that lacks displacements for
/// them. Refuses anchors that do not hold the object.
pub(super) fn anchors(name: &str, anchors: &Anchors, file: &Path) -> Result<(Vec<Value>, bool), CommandError> {
    let (mut nodes, mut lacks_basis) = (vec![None; anchors.regions.len()], false);
    if !anchors.regions.is_empty() && file.exists() {
        let elastic = Tables { elastic: true, ..Tables::NONE };
        let prepared = database::load_tables(file, elastic).map_err(|error| CommandError::database(file, &error))?;
        let anchored_nodes = prepared.anchor_nodes(anchors).map_err(|error| {
            Error::new(ErrorKind::Configuration, format!("objects.{name}.anchors"), format!("objects.{name}: {error}"))
        })?;
        nodes = anchored_nodes.counts.into_iter().map(Some).collect();
        lacks_basis = prepared.lacks_anchored_basis(anchors);
    }
    let rows = anchors.regions.iter().zip(nodes);
    Ok((rows.map(|(region, nodes)| json!({ "region": region.to_string(), "nodes": nodes })).collect(), lacks_basis))
}

fn screen(title: &str, objects: &[Value]) -> String {
    let mut text = if title.is_empty() { String::new() } else { format!("{title}\n") };
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let word = |value: &Value, key: &str| value[key].as_str().unwrap_or("").to_owned();
    for object in objects {
        let mut baked = if object["baked"] == true { String::new() } else { ": not baked yet".to_owned() };
        baked += &likely(object);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "\n{} ({}{baked})", word(object, "object"), word(object, "database"));
        let stages = list(&object["stages"]);
        let runs = stages.iter().filter(|stage| stage["runs"] == true).map(|stage| word(stage, "name"));
        let _ = writeln!(text, "  stages    {}", runs.collect::<Vec<_>>().join(", "));
        for table in list(&object["tables"]) {
            let state = match (table["loaded"] == true, table["bytes"].as_u64()) {
                (_, Some(0)) => "not in the file",
                (true, Some(_)) => "loaded",
                (false, Some(_)) => "left on disk",
                (true, None) => "needed",
                (false, None) => "not needed",
            };
            let size =
                table["bytes"].as_u64().map_or(String::new(), |bytes| format!(", {:.2} MB", bytes as f64 * 1e-6));
            let _ = writeln!(text, "  table     {:<18} {state}{size}", word(&table, "name"));
        }
        let scale = object["strength_scale"].as_f64().filter(|scale| *scale != 1.0);
        let scale = scale.map_or(String::new(), |scale| format!(", impulses that break it times {scale}"));
        let _ = writeln!(text, "  criterion {}{scale}", word(object, "criterion"));
        let anchors = list(&object["anchors"]);
        for anchor in anchors.iter().take(ANCHORS_SHOWN) {
            let nodes = anchor["nodes"].as_u64().map_or(String::new(), |nodes| format!(", {}", counted(nodes, "node")));
            let _ = writeln!(text, "  anchor    {}{nodes}", word(anchor, "region"));
        }
        if let Some(more @ 1..) = anchors.len().checked_sub(ANCHORS_SHOWN) {
            let _ = writeln!(text, "  anchor    and {more} more, which --json lists");
        }
        for effect in list(&object["effects"]) {
            let (name, state, paid) = (word(&effect, "name"), word(&effect, "state"), word(&effect, "paid"));
            let _ = writeln!(text, "  effect    {name:<18} {state:<8} {}", if state == "off" { "" } else { &paid });
        }
    }
    text.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}
