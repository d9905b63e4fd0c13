//! `shatter impact`.

use super::files::{FileFormat, OutputTarget, WrittenFiles};
use super::parse::{
    NamedConvention, convention, criterion, degree, effect, elastic, iterations, lift, milliseconds, origin, quality,
    ray, surface, vector,
};
use super::result_text::{preset, screen, widened};
use super::{
    CliError, RESULT_TIMEOUT, document, note, note_long_contact, note_one_piece, note_other_surface, out, reply, wait,
    with_options,
};
use serde_json::{Value, json};
use shatter_client::{
    Bond, Contact, ContactPartner, Deadline, DebrisPoint, DegreeRule, DisplacementSource, Effect, EnergySource, Error,
    ErrorKind, FractureResult, Fragment, Hit, HullMesh, Impact, Lift, NO_MATERIAL, Quality, Ray, RequestedCriterion,
    RequestedSurface, RetainedFragment, SEED_DEFAULT, Summary,
};
use shatter_proto::text::number;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Arguments of `shatter impact`.
#[derive(clap::Args)]
pub struct Args {
    /// Object to strike
    object: String,
    /// Contact point in the coordinates of the object, m: those of the mesh file after --unit and --up of `bake`, +Y up. Or in those of
    /// --convention; repeat for several contacts
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, required_unless_present = "ray")]
    point: Vec<[f64; 3]>,
    /// Ray instead of a point, for a single contact: the contact point is the first hit on the object from X,Y,Z along DX,DY,DZ
    #[arg(long, value_name = "X,Y,Z,DX,DY,DZ", value_parser = ray, allow_hyphen_values = true, conflicts_with = "point")]
    ray: Option<Ray>,
    /// Impulse on the object, N·s, one per point in the same order. With --convention: kg times its unit of length per second
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, required_unless_present = "impulse_ns")]
    impulse: Vec<[f64; 3]>,
    /// Magnitude of the impulse along --ray, instead of --impulse, N·s. With --convention: kg times its unit of length per second
    #[arg(long, value_name = "J", requires = "ray", conflicts_with = "impulse", allow_negative_numbers = true)]
    impulse_ns: Option<f64>,
    /// Contact duration, s [default: the object's]
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    duration_s: Option<f64>,
    /// Contact radius, m [default: the object's]
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    radius_m: Option<f64>,
    /// Closing speed of the impactor and the object along the impulses, m/s: the object then stores no more energy than the impact
    /// has. With --convention: its unit of length per second
    #[arg(long, value_name = "V", requires = "impactor_mass", allow_negative_numbers = true)]
    speed: Option<f64>,
    /// Mass of the impactor, kg, or `inf` if it does not move; it strikes at all contacts, without rotating
    #[arg(long, value_name = "KG", requires = "speed", allow_negative_numbers = true)]
    impactor_mass: Option<f64>,
    /// Number of sites, or a rule for it: `inferred` from the object's examples (the closed form where they do not reach), `verified`,
    /// `closed_form`, `optimised` [default: the preset's]
    #[arg(long, value_name = "N|inferred|verified|closed_form|optimised", value_parser = degree, allow_negative_numbers = true)]
    degree: Option<DegreeRule>,
    /// Fracture threshold γ, J·m² [default: the object's]
    #[arg(long, value_name = "G", allow_negative_numbers = true)]
    gamma: Option<f64>,
    /// Rule that decides whether the object breaks: `paper`, by the threshold γ, or `strength`, by strength and energy [default: the object's]
    #[arg(long, value_name = "paper|strength", value_parser = criterion)]
    criterion: Option<RequestedCriterion>,
    /// Lift: `euclidean`, `interior` (the default) or `surface_diffusion`
    #[arg(long, value_name = "euclidean|interior|surface_diffusion", value_parser = lift)]
    lift: Option<Lift>,
    /// Source of the displacements: `reduced`, from the object's examples where that is accurate enough, or `solve` [default: the preset's]
    #[arg(long, value_name = "reduced|solve", value_parser = elastic)]
    elastic: Option<DisplacementSource>,
    /// Outer surface of the fragments: `exact`, the input's own, if the object has a mesh of it (the default), or `lattice`, with fewer
    /// triangles. The fragments of a fragment keep its surface
    #[arg(long, value_name = "exact|lattice", value_parser = surface)]
    surface: Option<RequestedSurface>,
    /// Preset of the options that are not given; the JSON document contains its numbers [default: the object's]
    #[arg(long, value_name = "draft|game|film|reference", value_parser = quality)]
    quality: Option<Quality>,
    /// Largest estimated relative error of the elastic energy and of the diagram, whichever is worse
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    error: Option<f64>,
    /// Time from the admission of the request until the service sends the result, ms; quality falls where that is too short
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    time_ms: Option<f64>,
    /// Largest number of iterations of the diagram; the number of a request that ran out of time repeats its result, if only iterations were left out
    #[arg(long, value_name = "N", value_parser = iterations, allow_negative_numbers = true)]
    iterations: Option<u32>,
    /// Effects to switch on, separated by commas
    #[arg(long, value_name = "EFFECT,..", value_delimiter = ',', value_parser = effect)]
    enable: Vec<Effect>,
    /// Effects to switch off, separated by commas
    #[arg(long, value_name = "EFFECT,..", value_delimiter = ',', value_parser = effect)]
    disable: Vec<Effect>,
    /// Time after admission within which the result is of use, ms: the service serves more urgent requests first, and refuses one that
    /// cannot be in time
    #[arg(long, value_name = "T", value_parser = milliseconds)]
    deadline_ms: Option<u64>,
    /// Longest wait for the service, and for the object while its database is being loaded, s. A daemon that runs without replying is
    /// waited for at least 5 s
    #[arg(long, value_name = "SECONDS", value_parser = wait::seconds)]
    wait: Option<Duration>,
    /// Keep the result for a while, so that its fragments can be struck; the document contains its handle
    #[arg(long)]
    keep: bool,
    /// Fragment of a kept result to strike, instead of the object
    #[arg(long, value_name = "HANDLE/FRAGMENT", value_parser = origin)]
    from: Option<RetainedFragment>,
    /// Coordinates of --point, --impulse and the document: axes, unit of length, winding. Other options keep their units, and files are
    /// glTF's
    #[arg(long, value_name = "gltf|godot|unity|unreal|blender|mujoco", value_parser = convention, default_value = "gltf")]
    convention: NamedConvention,
    /// Seed of all random choices
    #[arg(long, default_value_t = SEED_DEFAULT)]
    seed: u64,
    /// File for the fragments, or folder for OBJECT.glb. FILE.glb contains closed meshes, which end on the triangles of the mesh file if
    /// the surface is exact. If it is the lattice's and the object has a skin, FILE.glb contains that for rendering (`skin` is then on
    /// unless --disable names it), and FILE.closed.glb the closed meshes. Hulls, if they are on, go to FILE.hulls.glb. FILE.xml is a model for MuJoCo, with its meshes in FILE_assets beside it;
    /// `bonds` and `hulls` are then on unless --disable names them
    #[arg(long, value_name = "FILE.glb|FILE.xml|DIR")]
    out: Option<PathBuf>,
    /// Format of files in a folder: `glb` (the default), `obj` (one file per fragment, fragments.mtl, fragments.json), or `mjcf`
    #[arg(long, value_enum, requires = "out")]
    format: Option<FileFormat>,
    /// Mesh file (.glb, .gltf) whose materials and textures the written .glb gets; needs the effect `attributes`, which is then on. Give
    /// the file that the object was baked from
    #[arg(long, value_name = "FILE.glb|FILE.gltf", requires = "out")]
    materials: Option<PathBuf>,
    /// Print one JSON document on stdout
    #[arg(long)]
    json: bool,
}

/// Time for connecting and for the way back in addition to the deadline of a request, ms.
const SLACK_MS: u64 = 250;

/// Refuses points without impulses, impulses without points, and an invalid magnitude of an impulse along a ray.
fn paired(args: &Args) -> Result<(), CliError> {
    let (points, impulses) = (args.point.len() + usize::from(args.ray.is_some()), args.impulse.len());
    if args.impulse_ns.is_some() && args.ray.is_none() {
        let message = "--impulse-ns is the magnitude of an impulse along --ray; with --point give --impulse X,Y,Z";
        return Err(CliError::Usage(message.to_owned()));
    }
    if let Some(impulse_ns) = args.impulse_ns.filter(|impulse_ns| !(*impulse_ns > 0.0 && impulse_ns.is_finite())) {
        let message = format!(
            "--impulse-ns {}: the magnitude of an impulse along a ray must be positive and finite; turn the ray to strike from \
             the other side",
            number(impulse_ns)
        );
        return Err(Error::new(ErrorKind::Impulse, "--impulse-ns", message).into());
    }
    if args.impulse_ns.is_some() || points == impulses {
        return Ok(());
    }
    let given = if args.ray.is_some() { "--ray" } else { "--point" };
    Err(CliError::Usage(format!(
        "{points} {given} but {impulses} --impulse; every contact needs one of each, in the same order"
    )))
}

/// The target of the files, with the materials for them.
fn output(out: &Path, args: &Args) -> Result<OutputTarget, CliError> {
    OutputTarget::new(out, args.format, &args.object)?.with_materials(args.materials.as_deref(), &args.disable)
}

/// Strikes an object and prints the result.
pub fn run(service: &str, args: &Args) -> Result<(), CliError> {
    paired(args)?;
    // A deadline bounds the whole command, whatever the daemon does.
    let within =
        |usual: Deadline| args.deadline_ms.map_or(usual, |ms| usual.min(Deadline::ms(ms.saturating_add(SLACK_MS))));
    let target = args.out.as_ref().map(|out| output(out, args)).transpose()?;
    let impact = impact(args);
    let object = wait::object(service, &args.object, args.convention.convention, args.wait, || within(reply()))?;
    let deadline = || within(Deadline::after(RESULT_TIMEOUT));
    let result = match &target {
        Some(target) => target.strike(&object, &impact, [&args.enable, &args.disable], deadline)?,
        None => object.strike(&impact)?.wait(deadline())?,
    };
    let files = target.map_or(Ok(WrittenFiles::default()), |target| target.write(&result))?;
    if let (Some(asked), Some(missed)) = (args.time_ms, result.summary().missed_time) {
        let (by_ms, reason) = (missed.by.as_secs_f64() * 1e3, missed.explanation());
        note(format_args!("the request exceeded its time of {} ms by {by_ms:.1} ms: {reason}", number(asked)));
    }
    note_one_piece(&result);
    note_long_contact(args.duration_s, &result);
    note_other_surface(args.surface, args.from.is_some(), &result);
    if args.json {
        let Args { error: error_max, time_ms: time_ms_max, .. } = *args;
        let asked = RequestEcho { convention: &args.convention.name, has_impact: true, error_max, time_ms_max };
        document(&to_json(&result, asked, &files))
    } else {
        screen(&result)?;
        let summary = result.summary();
        if let Some(note) = widened(args.radius_m, summary.radius_m) {
            out(format_args!("  {note}\n"))?;
        }
        if args.elastic == Some(DisplacementSource::Reduced) && summary.energy_source == EnergySource::Solve {
            out(format_args!("  {}\n", solved_instead(&summary)))?;
        }
        Ok(())
    }
}

/// Options of the request that the result does not contain.
pub(super) struct RequestEcho<'a> {
    /// Name of the convention.
    pub convention: &'a str,
    /// Whether an impact was sent; without one, its keys are `null`.
    pub has_impact: bool,
    /// `--error`.
    pub error_max: Option<f64>,
    /// `--time-ms`.
    pub time_ms_max: Option<f64>,
}

/// Note for a request for reduced displacements that was solved for instead.
fn solved_instead(summary: &Summary) -> String {
    let limit = 100.0 * summary.reduced_error_max;
    format!(
        "no reduced displacements within an estimated error of {limit:.0} %, the limit of this preset; they were solved for instead"
    )
}

fn impact(args: &Args) -> Impact {
    let radius = args.radius_m.map(|meters| args.convention.convention.length(meters));
    let partner = args.impactor_mass.zip(args.speed).map(|(mass_kg, speed)| ContactPartner::new(0, mass_kg, speed));
    let describe = |contact: Contact, impulse: &[f64; 3]| Contact {
        partner,
        ..with_options(contact.impulse(*impulse), args.duration_s, radius)
    };
    let given = args.point.iter().zip(&args.impulse).map(|(point, impulse)| describe(Contact::new(*point), impulse));
    let mut contacts: Vec<Contact> = given.collect();
    if contacts.is_empty() {
        contacts.push(aimed(args, describe));
    }
    let impact = Impact::new(contacts);
    let impact = impact.seed(args.seed);
    let impact = args.degree.map_or(impact.clone(), |degree| impact.degree(degree));
    let impact = args.elastic.map_or(impact.clone(), |elastic| impact.elastic(elastic));
    let impact = args.criterion.map_or(impact.clone(), |criterion| impact.criterion(criterion));
    let impact = args.surface.map_or(impact.clone(), |surface| impact.surface(surface));
    let impact = args.quality.map_or(impact.clone(), |quality| impact.quality(quality));
    let impact = args.error.map_or(impact.clone(), |error_max| impact.error(error_max));
    let impact = args.time_ms.map_or(impact.clone(), |time_ms| impact.time_ms(time_ms));
    let impact = args.iterations.map_or(impact.clone(), |count| impact.iterations(count));
    let impact = args.enable.iter().fold(impact, |impact, effect| impact.enable(*effect));
    let impact = args.disable.iter().fold(impact, |impact, effect| impact.disable(*effect));
    let impact = args.gamma.map_or(impact.clone(), |gamma| impact.gamma(gamma));
    let impact = args.lift.map_or(impact.clone(), |lift| impact.lift(lift));
    let impact = if args.keep { impact.keep() } else { impact };
    let impact = args.from.map_or(impact.clone(), |from| impact.from(from.handle, from.fragment));
    args.deadline_ms.map_or(impact.clone(), |ms| impact.deadline(Duration::from_millis(ms)))
}

/// The only contact, which a ray finds.
fn aimed(args: &Args, describe: impl Fn(Contact, &[f64; 3]) -> Contact) -> Contact {
    let Some(ray) = args.ray else { return Contact::new([0.0; 3]) };
    let contact = describe(ray.into(), args.impulse.first().unwrap_or(&[0.0; 3]));
    args.impulse_ns.map_or(contact, |impulse_ns| contact.impulse_along_ray(impulse_ns))
}

/// Document of a ray's first hit on the object.
pub(super) fn hit(hit: Hit) -> Value {
    json!({
        "point_m": hit.point_m,
        "normal": hit.normal,
        "distance_m": hit.distance_m,
        "body": hit.body,
        "surface": hit.surface.name(),
    })
}

/// Document of a hull.
fn hull(hull: HullMesh<'_>) -> Value {
    json!({
        "vertices": hull.positions.len(),
        "triangles": hull.indices.len() / 3,
        "coverage": hull.coverage,
        "margin_m": hull.margin_m,
    })
}

/// Number of triangles of each of the input's materials.
fn materials(of: &[u32]) -> Value {
    let mut counts = BTreeMap::new();
    of.iter()
        .filter(|material| **material != NO_MATERIAL)
        .for_each(|material| *counts.entry(*material).or_insert(0) += 1);
    counts.into_iter().map(|(material, triangles)| json!({ "material": material, "triangles": triangles })).collect()
}

/// Document of a point of debris.
fn debris(point: DebrisPoint) -> Value {
    json!({
        "fragment": point.fragment,
        "neighbor": point.neighbor,
        "position_m": point.position_m,
        "normal": point.normal,
        "size_m": point.size_m,
    })
}

/// Summary of all hulls: the least coverage, the coverage of all fragments together, the largest margin. `None` unless `hulls` ran.
fn hulls(result: &FractureResult) -> Option<Value> {
    let has_run = result.effects().any(|cost| cost.effect == Effect::Hulls && cost.has_run);
    if !has_run || result.is_whole() {
        return None;
    }
    // A fragment too flat for a hull counts as not covered.
    let coverage = |fragment: &Fragment<'_>| fragment.hull().map_or(0.0, |hull| hull.coverage);
    let (volume, held) = result.fragments().fold((0.0, 0.0), |(volume, held), fragment| {
        let own = fragment.volume_m3();
        (volume + own, held + own * coverage(&fragment))
    });
    let margins = result.fragments().filter_map(|fragment| fragment.hull()).map(|hull| hull.margin_m);
    Some(json!({
        "coverage_min": result.fragments().map(|fragment| coverage(&fragment)).fold(1.0, f64::min),
        "coverage": held / volume,
        "margin_max_m": margins.fold(0.0, f64::max),
    }))
}

/// Estimated error of the elastic energy; `None` where no energy was computed from displacements.
pub(super) fn energy_error(summary: &Summary) -> Option<f64> {
    let is_elastic = ![EnergySource::Falloff, EnergySource::Bounded].contains(&summary.energy_source);
    is_elastic.then_some(summary.energy_error)
}

/// Length over which stresses are averaged; `null` with the paper's criterion.
fn averaged_over(summary: &Summary) -> Value {
    let of = |length_m| json!({ "length_m": length_m, "is_lattice_cell": summary.is_averaged_over_cell });
    summary.averaged_over_m.map_or(Value::Null, of)
}

/// Energies of a result, J, and its largest stress.
fn ledger(summary: &Summary) -> Value {
    json!({
        "strain_j": summary.strain_j,
        "surface_j": summary.surface_j,
        "released_j": summary.released_j,
        "deficit_j": summary.deficit_j,
        "impactor_j": summary.impactor_j,
        "remainder_j": summary.remainder_j,
        "load_factor": summary.load_factor,
        "stress_over_strength": summary.stress_over_strength,
    })
}

/// Document of a result.
pub(super) fn to_json(result: &FractureResult, asked: RequestEcho<'_>, files: &WrittenFiles) -> Value {
    let file = |file: &PathBuf| file.display().to_string();
    let summary = result.summary();
    let digest = result.digest();
    let fragments: Vec<Value> = result.fragments().map(|fragment| fragment_json(&fragment)).collect();
    let cost = |name: &str, has_run: bool, time: Duration, bytes: u64| json!({ "name": name, "ran": has_run, "ns": nanoseconds(time), "bytes": bytes });
    let stages = result.stages().map(|own| cost(own.stage.name(), own.has_run, own.time, own.bytes));
    let effects = result.effects().map(|own| cost(own.effect.name(), own.has_run, own.time, own.bytes));
    let section = |section: &shatter_client::SectionDigest| json!({ "name": section.name, "bytes": section.bytes, "hash": section.hash });
    let bond = |bond: Bond| {
        json!({
            "fragments": bond.fragments().collect::<Vec<u32>>(),
            "world": bond.is_with_world(),
            "area_m2": bond.area_m2,
            "normal": bond.normal,
            "centroid_m": bond.centroid_m,
        })
    };
    json!({
        "status": "ok",
        "object": summary.object,
        "handle": result.handle(),
        "convention": asked.convention,
        "gamma_j_m2": summary.gamma_j_m2,
        "e1_over_gamma": asked.has_impact.then_some(summary.e1_over_gamma),
        "sites": summary.sites,
        "fracture_degree": summary.fracture_degree,
        "degree_source": summary.degree_origin.name(),
        "confidence": summary.confidence,
        "elastic": summary.energy_source.name(),
        "criterion": summary.criterion.name(),
        "averaged_over": averaged_over(&summary),
        "ledger": ledger(&summary),
        "error_estimate": {
            "energy": energy_error(&summary),
            "discretisation_error": summary.discretization_error,
            "cvd_gap": (summary.sites > 0).then_some(summary.cvd_gap),
        },
        "iterations": summary.iterations,
        "time_ns": nanoseconds(summary.time),
        "quality": {
            "name": preset(&summary),
            "elastic": summary.energy_source.name(),
            "rank": summary.rank,
            "tolerance": summary.tolerance,
            "iterations": summary.iterations_max,
            "lift_modes": summary.lift_modes,
            "crack_nodes": summary.crack_nodes,
            "elastic_nodes": summary.elastic_nodes,
            "elements_across": summary.elements_across,
            "degree": summary.degree_method.name(),
            "reduced_error_max": summary.reduced_error_max,
            "error_max": asked.error_max,
            "time_ms_max": asked.time_ms_max,
        },
        "missed_time": summary.missed_time.map(|missed| json!({
            "by_ms": missed.by.as_secs_f64() * 1e3,
            "reason": missed.cause.name(),
            "message": missed.explanation(),
        })),
        "capped": summary.is_capped,
        "radius_m": asked.has_impact.then_some(summary.radius_m),
        "fragments": fragments,
        "bonds": result.bonds().map(bond).collect::<Vec<_>>(),
        "debris": result.debris().map(debris).collect::<Vec<_>>(),
        "hulls": hulls(result),
        "stages": stages.chain(effects).collect::<Vec<_>>(),
        "sections": digest.sections.iter().map(section).collect::<Vec<_>>(),
        "stop_reason": summary.stop_criterion.name(),
        "surface": summary.surface.name(),
        "round_trip_ns": nanoseconds(result.round_trip()),
        "response_bytes": result.bytes(),
        "output_hash": digest.output_hash,
        "hit": result.hit().map(hit),
        "file": files.target.as_ref().map(file),
        "files": files.all.iter().map(file).collect::<Vec<_>>(),
    })
}

fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

fn fragment_json(fragment: &Fragment<'_>) -> Value {
    json!({
        "id": fragment.id(),
        "body": fragment.body(),
        "volume_m3": fragment.volume_m3(),
        "mass_kg": fragment.mass_kg(),
        "center_m": fragment.center_m(),
        "vertices": fragment.positions().len(),
        "triangles": fragment.indices().len() / 3,
        "energy_j_m2": fragment.energy_j_m2(),
        "closed": fragment.is_closed(),
        "velocity": fragment.velocity().map(|own| json!({ "linear_m_s": own.linear_m_s, "angular_rad_s": own.angular_rad_s })),
        "materials": materials(fragment.materials()),
        "hull": fragment.hull().map(hull),
        "skin": fragment.skin().map(|skin| json!({ "vertices": skin.vertices.len(), "triangles": skin.indices.len() / 3, "materials": materials(skin.materials) })),
    })
}
