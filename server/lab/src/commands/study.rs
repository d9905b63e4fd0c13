//! `shatterd study`.

use super::accuracy;
use crate::report::{self, ReportFigure};
use crate::study::mesh_fuzz::{self, FuzzPlan, FuzzTally, FuzzVerdict, Judge, MeshSize, Mutant};
use crate::study::paper::PaperError;
use crate::study::stability::{
    CASES, CaseOutcome, CaseRow, REAL, StabilityFindings, TrialFault, bending_deficits, damaged_statues, judge,
    neck_over_impulses, neck_portraits, real,
};
use crate::study::{effects, gallery, paper};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use shatter_fracture::pipeline::Preset;
use shatter_fracture::surface::shapes::write_obj;
use shatter_fracture::surface::{LengthUnit, UpAxis};
use shatter_server::commands::{CommandError, mesh_file, output};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Arguments of `shatterd study`.
#[derive(clap::Args)]
pub struct StudyArgs {
    #[command(subcommand)]
    study: Study,
}

#[derive(clap::Subcommand)]
enum Study {
    /// Run the catalog of hard cases and bad meshes, and write a table and a page; takes several minutes
    Stability(Stability),
    /// Strike the objects of the shipped scenes with the scene's effects and with all, and draw the cost and the look of every effect
    Effects(Effects),
    /// Reproduce the paper's two figures: a body struck by metal balls, and one dropped on its head at three thresholds
    Paper(Paper),
    /// Vary every solver setting of a request, and draw errors against times of whole requests
    Accuracy(accuracy::AccuracyArgs),
}

/// Arguments of `shatterd study paper`.
#[derive(clap::Args)]
struct Paper {
    /// Mesh file of the body [default: the horse from the folder of meshes, else a generated statue]
    object: Option<PathBuf>,
    /// Folder of real meshes, searched for `horse.ply`
    #[arg(long, value_name = "DIR", env = "SHATTER_MESHES")]
    meshes: Option<PathBuf>,
    /// Axis of the mesh file that points up: y, z
    #[arg(long, default_value = "y")]
    up: UpAxis,
    /// Preset of the lattices and of the requests
    #[arg(long, value_name = "draft|game|film|reference", value_parser = quality, default_value = "film")]
    quality: Preset,
    /// Folder for the page, its pictures and their data
    #[arg(long, value_name = "DIR", default_value = "shatter-study")]
    out: PathBuf,
    /// Print one JSON document on stdout
    #[arg(long)]
    json: bool,
}

/// Arguments of `shatterd study effects`.
#[derive(clap::Args)]
struct Effects {
    /// Folder for the page
    #[arg(long, value_name = "DIR", default_value = "shatter-study")]
    out: PathBuf,
    /// Print one JSON document on stdout
    #[arg(long)]
    json: bool,
}

/// Arguments of `shatterd study stability`.
#[derive(clap::Args)]
struct Stability {
    /// Number of bad meshes
    #[arg(long, value_name = "N", default_value_t = 1000)]
    mutants: usize,
    /// Seed of the bad meshes
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Damage meshes of full size and bake them with the preset game, instead of small ones on coarse lattices; takes several
    /// times as long
    #[arg(long)]
    full_size: bool,
    /// Folder of further real meshes
    #[arg(long, value_name = "DIR", env = "SHATTER_MESHES")]
    meshes: Option<PathBuf>,
    /// Bad mesh to judge alone; if it fails, it is reduced and written into the folder
    #[arg(long, value_name = "MESH/DEFECT/SEED")]
    shrink: Option<Mutant>,
    /// Folder for the page
    #[arg(long, value_name = "DIR", default_value = "shatter-study")]
    out: PathBuf,
    /// Print one JSON document on stdout
    #[arg(long)]
    json: bool,
}

impl Stability {
    fn size(&self) -> MeshSize {
        if self.full_size { MeshSize::Full } else { MeshSize::Small }
    }
}

/// Time limit for a bad mesh. Most take well below a second, so one that takes this long hangs.
const DEADLINE: Duration = Duration::from_secs(60);

/// Time limit for a bad mesh of full size. Lattices are refined until parts are connected, which takes minutes on one thread.
const FULL_SIZE_DEADLINE: Duration = Duration::from_secs(900);

/// One bad mesh of this many is judged a second time, on another number of threads.
const REPEAT_EVERY: usize = 13;

/// Maximum number of meshes that the shrinker tries.
const TRIES_MAX: usize = 2000;

/// Runs a study; returns whether all checks passed.
pub fn run(args: &StudyArgs) -> Result<bool, CommandError> {
    match &args.study {
        Study::Stability(args) => {
            output::folder(&args.out)?;
            match &args.shrink {
                Some(mutant) => shrink(args, mutant),
                None => stability(args),
            }
        }
        Study::Effects(args) => effects(args).map(|()| true),
        Study::Accuracy(args) => accuracy::run(args).map(|()| true),
        Study::Paper(args) => paper(args).map(|()| true),
    }
}

fn paper(args: &Paper) -> Result<(), CommandError> {
    output::folder(&args.out)?;
    let horse = args.meshes.as_ref().map(|folder| folder.join("horse.ply")).filter(|file| file.is_file());
    let plan = match (&args.object, &horse) {
        (Some(file), _) => {
            let name = file.file_stem().map_or_else(|| "object".into(), std::ffi::OsStr::to_string_lossy);
            paper::PaperPlan::new(name, mesh_file::read(file, LengthUnit::default(), args.up)?)
        }
        (None, Some(file)) => paper::PaperPlan::horse(mesh_file::read(file, LengthUnit::default(), UpAxis::Z)?),
        (None, None) => paper::PaperPlan::statue(),
    };
    let plan = paper::PaperPlan { quality: args.quality, ..plan };
    let bar = bar(plan.steps());
    let drawn = paper::run(&plan, &mut |what| {
        bar.set_message(what.to_owned());
        bar.inc(1);
    });
    bar.finish_and_clear();
    let drawn = drawn.map_err(|error| match (error, args.object.as_deref().or(horse.as_deref())) {
        (PaperError::Bake(error), file) => mesh_file::bake_error(error, file),
        (error @ PaperError::Empty, Some(file)) => CommandError::from(error).of_file(file),
        (error, _) => error.into(),
    })?;
    let write = |name: String, bytes: &[u8]| {
        let path = args.out.join(name);
        output::whole(&path, bytes)
    };
    for own in &drawn {
        write(format!("{}.png", own.file), &own.png)?;
        write(format!("{}.csv", own.file), own.csv().as_bytes())?;
    }
    write("paper.html".to_owned(), report::study(&paper::page(&plan, &drawn)).as_bytes())?;
    if args.json {
        return output::print(&format!("{}\n", paper::document(&plan, &drawn)));
    }
    let line = |own: &paper::Panel| {
        format!(
            "{:26} E1/γ {:>8} {:>4} pieces\n",
            own.caption,
            report::significant(own.e1_over_gamma, 3),
            own.fragments
        )
    };
    let lines: String = drawn.iter().flat_map(|own| &own.panels).map(line).collect();
    output::print(&format!("{lines}Open {} in a browser.\n", args.out.join("paper.html").display()))
}

fn quality(name: &str) -> Result<Preset, String> {
    Preset::by_name(name).ok_or_else(|| "`draft`, `game`, `film` or `reference`".to_owned())
}

fn effects(args: &Effects) -> Result<(), CommandError> {
    output::folder(&args.out)?;
    let bar = bar(effects::SHIPPED.len() + 1 + gallery::effect_examples().len());
    let mut progress = |what: &str| {
        bar.set_message(what.to_owned());
        bar.inc(1);
    };
    let pairs = effects::pairs(&mut progress).map_err(CommandError::from)?;
    let shown = gallery::shown(&mut progress).map_err(CommandError::from)?;
    bar.finish_and_clear();
    let write = |name: &str, bytes: &[u8]| {
        let path = args.out.join(name);
        output::whole(&path, bytes)
    };
    shown.iter().try_for_each(|own| write(&own.file(), &own.png))?;
    write("effects.md", gallery::markdown(&shown).as_bytes())?;
    let page = args.out.join("effects.html");
    let study = effects::page(&pairs, gallery::section(&shown)).map_err(CommandError::from)?;
    output::whole(&page, report::study(&study).as_bytes())?;
    if args.json {
        return output::print(&format!("{}\n", effects::document(&pairs)));
    }
    let lines: String =
        study.sections.iter().map(|part| format!("{:24} {}\n", part.heading, part.lead.join(" "))).collect();
    output::print(&format!("{lines}Open {} in a browser.\n", page.display()))
}

fn stability(args: &Stability) -> Result<bool, CommandError> {
    let files = real_files(args);
    let mut progress = StudyProgress::new(CASES.len() + files.len() + FURTHER_PARTS);
    let (mut rows, real_portraits) = rows(&files, &mut progress);
    let findings = StabilityFindings {
        real_portraits,
        bending_deficits: found(bending_deficits, "error against Poisson's ratio", &mut rows, &mut progress),
        necks: found(neck_over_impulses, "a neck over a range of impulses", &mut rows, &mut progress),
        neck_portraits: found(neck_portraits, "pictures of the neck", &mut rows, &mut progress),
        damaged: found(damaged_statues, "pictures of damaged statues", &mut rows, &mut progress),
        mutants: {
            progress.next(&format!("{} bad meshes", args.mutants));
            tally(args)?
        },
        rows,
    };
    let page = args.out.join("stability.html");
    let study = findings.page().map_err(|error| CommandError::ours("study", error.to_string()))?;
    output::whole(&page, report::study(&study).as_bytes())?;
    if args.json {
        output::print(&format!("{}\n", findings.document()))?;
    } else {
        let lines: String = findings.rows.iter().map(line).collect();
        output::print(&format!("{lines}\n{}\nOpen {} in a browser.\n", findings.mutants, page.display()))?;
    }
    Ok(!findings.failed())
}

/// Result of a part of the study, or nothing and a failed row, so that one fault does not end the study.
fn found<T>(
    find: impl FnOnce() -> Result<Vec<T>, TrialFault>,
    name: &str,
    rows: &mut Vec<CaseRow>,
    progress: &mut StudyProgress,
) -> Vec<T> {
    progress.next(name);
    find().unwrap_or_else(|fault| {
        rows.push(CaseRow::failed(name, &fault));
        Vec::new()
    })
}

fn line(row: &CaseRow) -> String {
    let figure = row.figure.map_or_else(|| "–".to_owned(), |figure| report::significant(figure, 3));
    let outcome = match row.outcome {
        CaseOutcome::Passed => "passed",
        CaseOutcome::Refused => "refused",
        CaseOutcome::Failed => "FAILED",
    };
    format!("{outcome:8} {:38} {figure:>14}   {}\n", row.name, row.expected)
}

/// Progress bar of a study with this number of steps.
pub(super) fn bar(length: usize) -> ProgressBar {
    let bar = ProgressBar::new(length as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:24} {pos}/{len} {msg} ({elapsed}, {eta} left)") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// Number of parts of the stability study after the cases and the real meshes.
const FURTHER_PARTS: usize = 5;

/// Progress of a study: one line on stderr per part.
struct StudyProgress {
    number: usize,
    total: usize,
}

impl StudyProgress {
    fn new(total: usize) -> Self {
        Self { number: 0, total }
    }

    /// Begins the next part.
    fn next(&mut self, name: &str) {
        self.number += 1;
        // Without a reader of stderr the study continues.
        let _ = writeln!(std::io::stderr(), "{} of {}: {name}", self.number, self.total);
    }
}

/// Real meshes that exist, with their folder.
fn real_files(args: &Stability) -> Vec<(&Path, &'static str)> {
    let folder = args.meshes.as_deref();
    let files = folder.into_iter().flat_map(|folder| REAL.iter().map(move |file| (folder, *file)));
    files.filter(|(folder, file)| folder.join(file).is_file()).collect()
}

/// Runs the catalog, then the real meshes with their pictures.
fn rows(files: &[(&Path, &str)], progress: &mut StudyProgress) -> (Vec<CaseRow>, Vec<ReportFigure>) {
    let (mut rows, mut pictures) = (Vec::new(), Vec::new());
    for case in CASES {
        progress.next(case.name);
        rows.push(judge(case));
    }
    for (folder, file) in files {
        progress.next(file);
        let (row, picture) = real(folder, file, true);
        rows.push(row);
        pictures.extend(picture);
    }
    (rows, pictures)
}

fn meshes(args: &Stability) -> Result<Vec<mesh_fuzz::BaseMesh>, CommandError> {
    let mut meshes = mesh_fuzz::generated(args.size());
    if let Some(folder) = &args.meshes {
        let refused = |error: mesh_fuzz::FolderError| {
            CommandError::refused("unreadable_file", folder.display().to_string(), error.to_string())
        };
        meshes.extend(mesh_fuzz::from_folder(folder, args.size()).map_err(refused)?);
    }
    Ok(meshes)
}

fn judge_of(args: &Stability) -> Result<Judge, CommandError> {
    Judge::new(args.size(), if args.full_size { FULL_SIZE_DEADLINE } else { DEADLINE }).map_err(CommandError::from)
}

fn tally(args: &Stability) -> Result<FuzzTally, CommandError> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let plan = FuzzPlan {
        count: args.mutants,
        seed: args.seed,
        meshes: meshes(args)?,
        judge: judge_of(args)?,
        repeat_every: REPEAT_EVERY,
        threads,
    };
    let bar = bar(plan.count);
    let tally = mesh_fuzz::run(&plan, &mut |mutant, verdict| {
        if let FuzzVerdict::Failed(fault) = verdict {
            bar.suspend(|| output::note(&format!("failed: {mutant}: {fault}")));
        }
        bar.set_message(mutant.to_string());
        bar.inc(1);
    });
    bar.finish_and_clear();
    Ok(tally)
}

/// Judges one bad mesh; reduces it if it fails.
fn shrink(args: &Stability, mutant: &Mutant) -> Result<bool, CommandError> {
    let (meshes, judge) = (meshes(args)?, judge_of(args)?);
    let base = meshes.iter().find(|base| base.name == mutant.mesh).ok_or_else(|| {
        let names: Vec<&str> = meshes.iter().map(|base| base.name.as_str()).collect();
        CommandError::refused(
            "unknown_mesh",
            mutant.mesh.clone(),
            format!("unknown mesh '{}'; use one of {}", mutant.mesh, names.join(", ")),
        )
    })?;
    let fault = match judge.mutant(&base.mesh, mutant) {
        FuzzVerdict::Failed(fault) => fault,
        FuzzVerdict::Checked { .. } => return report(args, &json!({ "mutant": mutant, "outcome": "checked" }), true),
        FuzzVerdict::Refused { kind, message, justified } => {
            let document = json!({
                "mutant": mutant, "outcome": "refused", "kind": kind, "message": message, "justified": justified,
            });
            return report(args, &document, true);
        }
    };
    let damaged = mutant.defect.apply(&base.mesh, mutant.seed);
    let bar = bar(TRIES_MAX);
    let must_accept = mutant.defect.must_accept();
    let shrunk = mesh_fuzz::shrink(&damaged, TRIES_MAX, &mut |mesh| {
        bar.inc(1);
        judge.fails_like(mesh, must_accept, mutant.seed, &fault)
    });
    bar.finish_and_clear();
    let file = args.out.join(format!("{}.obj", mutant.to_string().replace('/', "-")));
    write_obj(&shrunk.mesh, &file).map_err(|error| CommandError::output(&file, &error))?;
    let document = json!({
        "mutant": mutant, "outcome": "failed", "message": fault.to_string(),
        "triangles": shrunk.mesh.triangles.len(), "file": file.display().to_string(),
    });
    report(args, &document, false)
}

/// Prints the outcome for one bad mesh, as a document or line by line.
fn report(args: &Stability, document: &Value, held: bool) -> Result<bool, CommandError> {
    let lines = document.as_object().into_iter().flatten();
    let text: String = if args.json {
        format!("{document}\n")
    } else {
        lines
            .map(|(key, value)| format!("{key}: {}\n", value.as_str().map_or(value.to_string(), str::to_owned)))
            .collect()
    };
    output::print(&text)?;
    Ok(held)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_a_mesh_name_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        for (name, first) in [("nan.obj", "v nan 0 0"), ("flat.obj", "v 0 0 0")] {
            let file = folder.path().join(name);
            std::fs::write(&file, format!("{first}\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n")).unwrap();
            let object = Some(file.clone());
            let paper = paper(&Paper {
                object: object.clone(),
                meshes: None,
                up: UpAxis::Y,
                quality: Preset::Draft,
                out: out.clone(),
                json: false,
            });
            let args = accuracy::AccuracyArgs { object, mesh: None, impacts: 2, out: out.clone(), json: false };
            let accuracy = accuracy::run(&args);
            for result in [paper, accuracy] {
                let message = result.unwrap_err().message().to_owned();
                assert_eq!(message.matches(&file.display().to_string()).count(), 1, "{message}");
            }
        }
    }
}
