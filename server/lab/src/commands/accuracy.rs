//! `shatterd study accuracy`.

use super::study::bar;
use crate::report;
use crate::study::accuracy::{self, StudyError};
use shatter_fracture::surface::{LengthUnit, UpAxis};
use shatter_server::commands::{CommandError, mesh_file, output};
use std::path::PathBuf;

/// Arguments of `shatterd study accuracy`.
#[derive(clap::Args)]
pub struct AccuracyArgs {
    /// Mesh file of the object, in meters [default: a generated statue]
    pub object: Option<PathBuf>,
    /// Mesh file of a further body on which the elastic energies of presets are judged, in meters
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
    /// Number of impacts on each body
    #[arg(long, value_name = "N", default_value_t = accuracy::IMPACTS_DEFAULT, value_parser = clap::value_parser!(u64).range(1..))]
    pub impacts: u64,
    /// Folder for the page, its diagrams and their data
    #[arg(long, value_name = "DIR", default_value = "shatter-study")]
    pub out: PathBuf,
    /// Print one JSON document on stdout
    #[arg(long)]
    pub json: bool,
}

/// Runs the study, and writes its page, diagrams and data.
pub fn run(args: &AccuracyArgs) -> Result<(), CommandError> {
    output::folder(&args.out)?;
    let read = |file: &PathBuf| {
        let name = file.file_stem().map_or_else(|| "object".into(), std::ffi::OsStr::to_string_lossy);
        let mesh = mesh_file::read(file, LengthUnit::default(), UpAxis::default())?;
        Ok::<_, CommandError>(accuracy::StudyBody::new(name, mesh))
    };
    let mut plan = match &args.object {
        None => accuracy::AccuracyPlan::statue(),
        Some(file) => {
            let accuracy::StudyBody { name, mesh } = read(file)?;
            accuracy::AccuracyPlan::new(name, mesh)
        }
    };
    plan.impacts = args.impacts;
    plan.bodies.extend(args.mesh.as_ref().map(read).transpose()?);
    let bar = bar(plan.steps());
    let findings = accuracy::run(&plan, &mut |what| {
        bar.set_message(what.to_owned());
        bar.inc(1);
    });
    bar.finish_and_clear();
    let findings = findings.map_err(|error| match error {
        StudyError::Bake(error) => mesh_file::bake_error(error, args.object.as_deref()),
        error => error.into(),
    })?;
    let drawn = accuracy::drawn(&findings).map_err(CommandError::from)?;
    let write = |name: &str, text: &str| {
        let path = args.out.join(name);
        output::whole(&path, text.as_bytes())
    };
    for own in &drawn {
        write(&format!("{}.svg", own.file), &own.svg)?;
        write(&format!("{}.csv", own.file), &own.csv)?;
    }
    let close_up = findings.close_up.png().map_err(CommandError::from)?;
    if let Some(png) = &close_up {
        let path = args.out.join("accuracy-close-up.png");
        output::whole(&path, png)?;
    }
    write("accuracy.html", &report::study(&accuracy::page(&findings, &drawn, close_up)))?;
    if args.json {
        return output::print(&format!("{}\n", findings.document()));
    }
    let lines = findings.points.iter().map(report_point).chain(findings.bodies.iter().map(report_body));
    let over_all = accuracy::AllBodiesPoint::all(&findings.bodies);
    let lines: String = lines.chain(over_all.iter().map(report_all_bodies)).collect();
    output::print(&format!("{lines}Open {} in a browser.\n", args.out.join("accuracy.html").display()))
}

/// Line of one setting: its time and its errors.
fn report_point(point: &accuracy::StudyPoint) -> String {
    let error = |measure: accuracy::Measure| Some(format!("{} {}", measure.name(), point.errors.text(measure)?));
    let errors: Vec<String> = accuracy::Measure::ALL.into_iter().filter_map(error).collect();
    let time = report::significant(point.times.at(0.5), 3);
    format!("{:18} {:18} {time:>8} ms   {}\n", point.setting, point.label(), errors.join(", "))
}

/// Line of one preset on one body: its elastic errors.
fn report_body(point: &accuracy::BodyPoint) -> String {
    let text = |errors: &accuracy::PointErrors, measure| errors.text(measure).unwrap_or_else(|| "–".to_owned());
    let [energy, geometry] =
        [accuracy::Measure::Energy, accuracy::Measure::Geometry].map(|measure| text(&point.errors, measure));
    let [reduced, solved] = point.by_method.each_ref().map(|errors| text(errors, accuracy::Measure::Energy));
    let share = report::significant(100.0 * point.solved, 3);
    let parts = format!("reduced {reduced}, solved {solved} ({share} %)");
    let place = format!("{:18} {:18} {:9}", point.body, point.preset, point.elements());
    format!("{place} energy_error {energy}: {parts}; geometry_error {geometry}\n")
}

/// Line of one preset over all bodies.
fn report_all_bodies(point: &accuracy::AllBodiesPoint) -> String {
    let reduced = point.reduced.text(accuracy::Measure::Energy).unwrap_or_else(|| "–".to_owned());
    format!("{:18} {:18} energy_error, reduced {reduced}, of {} bodies\n", "all bodies", point.preset, point.bodies)
}
