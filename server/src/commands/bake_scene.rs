//! `shatterd bake --scene`: bakes the databases of a scene whose shapes are generated.

use super::bake_progress::BakeProgress;
use super::command_error::scene_keys;
use super::expected_file::{self, ExpectedFile};
use super::{CommandError, bake, bake_report, check, interrupt, output};
use serde_json::{Value, json};
use shatter_engine::scene::{BakeRecipe, Scene};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{self, EXTENSION};
use shatter_fracture::pipeline;
use shatter_proto::effect::Effect;
use std::path::Path;
use std::time::Instant;

/// Outcome for one database.
#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    /// The command baked it.
    Baked,
    /// The existing file equals what a bake would write.
    Kept,
    /// The bases of displacements in the existing file are now those for the scene's anchors.
    Extended,
    /// The scene names no shape for it.
    NoShape,
}

/// Bakes every database of the scene whose shape is generated into `folder`, one after the other; keeps files that are up to date.
/// Adds bases of displacements for the scene's anchors to all databases, also to those that were baked from mesh files.
///
/// A failure or an interruption ends the command; finished files stay.
pub fn run(scene: &Path, folder: &Path, as_json: bool) -> Result<(), CommandError> {
    expected_file::check(scene, ExpectedFile::Scene)?;
    let (shown, path) = (scene.display(), scene);
    let scene = Scene::load(path)?;
    let recipes = scene.recipes().map_err(|error| CommandError::from(error).of_scene(path))?;
    let file_of = |name: &str| folder.join(format!("{name}.{EXTENSION}"));
    let has_work = |(name, recipe): (&String, &BakeRecipe)| {
        let mut terms = recipe.objects.iter().map(|object| &scene.objects[object].terms);
        recipe.bake(name).is_some()
            || (terms.any(|terms| terms.allowed.has(Effect::Anchored)) && file_of(name).is_file())
    };
    if !recipes.iter().any(has_work) {
        let missing = recipes.keys().map(|name| file_of(name)).filter(|file| !file.is_file());
        let missing: Vec<String> = missing.map(|file| format!("; {} does not exist", file.display())).collect();
        let message = format!(
            "{shown}: no object has a `shape`, or anchors and a database{}; bake each mesh with `shatterd bake MESH --name NAME`",
            missing.concat()
        );
        return Err(CommandError::refused("no_shape", "shape", message));
    }
    output::folder(folder)?;
    let token = interrupt::token();
    let mut files = Vec::new();
    for (name, recipe) in &recipes {
        let (file, begun) = (file_of(name), Instant::now());
        let state = match provide(name, recipe, &file, &token) {
            Ok(state) => state,
            Err(failure) => return Err(failure.with_files(Value::Array(files))),
        };
        let state = anchored(&scene, (name, recipe), (state, &file), &token)
            .map_err(|failure| failure.of_scene(path).with_files(Value::Array(files.clone())))?;
        let seconds = begun.elapsed().as_secs_f64();
        if !as_json {
            output::print(&line(name, recipe, state, &file, seconds))?;
        }
        files.push(json!({
            "database": name,
            "objects": recipe.objects,
            "file": file.display().to_string(),
            "state": word(state),
            "seconds": seconds,
        }));
    }
    match as_json {
        true => output::print(&format!("{}\n", json!({ "scene": scene.title, "files": files }))),
        false => Ok(()),
    }
}

/// Makes sure that `file` holds the result of `recipe`.
fn provide(name: &str, recipe: &BakeRecipe, file: &Path, token: &CancelToken) -> Result<State, CommandError> {
    let Some((mesh, request)) = recipe.bake(name) else { return Ok(State::NoShape) };
    let bar = BakeProgress::new(name, request.examples);
    let failed = |error| CommandError::from(error).with_scene_keys().of_file(file);
    let stored = database::stored(file, mesh.clone(), &request, token, &mut |step| bar.show(step)).map_err(failed)?;
    if stored.is_some() {
        bar.finish();
        return Ok(State::Kept);
    }
    if let Some(text) = bake::large_fragments(&mesh, &request) {
        bake_report::warning(&scene_keys(&text));
    }
    let prepared = database::bake(mesh, &request, token, &mut |step| bar.show(step)).map_err(failed)?;
    bar.show_step("write");
    let writing = interrupt::writing();
    database::save(&prepared, file).map_err(|error| CommandError::database(file, &error))?;
    drop(writing);
    bar.finish();
    bake_report::warnings(&prepared).iter().for_each(|text| bake_report::warning(&scene_keys(text)));
    Ok(State::Baked)
}

/// Checks the anchors of the objects that use `file`, and makes sure that it has the bases of displacements for them.
fn anchored(
    scene: &Scene,
    (name, recipe): (&str, &BakeRecipe),
    (state, file): (State, &Path),
    token: &CancelToken,
) -> Result<State, CommandError> {
    let mut all = Vec::new();
    for object in &recipe.objects {
        let terms = &scene.objects[object].terms;
        check::anchors(object, &terms.anchors, file)?;
        if terms.allowed.has(Effect::Anchored) {
            all.push(&terms.anchors);
        }
    }
    if all.is_empty() || !file.is_file() {
        return Ok(state);
    }
    let mut prepared = database::load(file).map_err(|error| CommandError::database(file, &error))?;
    let bar = BakeProgress::new(name, 0);
    let made = pipeline::reduce_anchored(&mut prepared, &all, token, &mut |body| {
        bar.show_step(&format!("elasticity of body {body} with its anchors"));
    });
    let is_changed = made.map_err(|error| CommandError::from(error).with_scene_keys().of_file(file))?;
    if is_changed {
        let writing = interrupt::writing();
        database::save(&prepared, file).map_err(|error| CommandError::database(file, &error))?;
        drop(writing);
    }
    bar.finish();
    Ok(match state {
        State::Baked => State::Baked,
        _ if is_changed => State::Extended,
        _ => State::Kept,
    })
}

fn word(state: State) -> &'static str {
    match state {
        State::Baked => "baked",
        State::Kept => "kept",
        State::Extended => "extended",
        State::NoShape => "no_shape",
    }
}

fn line(name: &str, recipe: &BakeRecipe, state: State, file: &Path, seconds: f64) -> String {
    let (is_baked, shown) = (file.is_file(), file.display());
    let own = recipe.objects.iter().eq([name]);
    let objects = if own { String::new() } else { format!(" (for {})", recipe.objects.join(", ")) };
    match state {
        State::Baked => format!("{name}{objects}  baked  {shown}, {seconds:.1} s\n"),
        State::Kept => format!("{name}{objects}  kept   {shown}\n"),
        State::Extended => {
            format!("{name}{objects}  kept   {shown}, with new displacements for its anchors, {seconds:.1} s\n")
        }
        State::NoShape if is_baked => format!("{name}{objects}  has no `shape`; {shown} stays as it is\n"),
        State::NoShape => format!("{name}{objects}  has no `shape`; bake its mesh with --name {name}\n"),
    }
}
