//! Report of a bake, as text and as JSON.

use super::{CommandError, output, size};
use serde_json::json;
use shatter_fracture::cutting::{RepairKind, SurfaceRepair};
use shatter_fracture::database::HALF_SPACING_COST;
use shatter_fracture::degree::reference_gamma;
use shatter_fracture::elasticity::ElementOrder;
use shatter_fracture::lattice::SPACING_RANGE;
use shatter_fracture::pipeline::{
    BakeParameters, BakeReport, CELLS_LINEAR_MIN, CELLS_MAX, ElasticReport, ExistingCracks, LearnedModel,
    PreparedObject, ReductionErrors, SurfaceKind, SurfaceReport,
};
use shatter_fracture::surface::{Defect, DefectKind};
use shatter_proto::text::counted;
use std::fmt::Write;
use std::path::Path;
use std::time::Duration;

/// Share of the surface above which films or hidden triangles are warned about.
const REPAIRED_SHARE_REPORTED: f64 = 0.05;

/// Relative volume error above which a bake warns.
const VOLUME_ERROR_REPORTED: f64 = 0.03;

/// Prints warnings on stderr and the report on stdout. `earlier` holds warnings that were printed before; the document repeats them.
pub fn tell(
    prepared: &PreparedObject,
    file: &Path,
    took: Duration,
    earlier: Vec<String>,
    as_json: bool,
) -> Result<(), CommandError> {
    let seconds = took.as_secs_f64();
    warn(prepared);
    let warnings: Vec<String> = earlier.into_iter().chain(warnings(prepared)).collect();
    match as_json {
        true => output::print(&format!("{}\n", document(prepared, file, &warnings, seconds))),
        false => {
            let held = size::rounded(prepared.bytes() as f64 / 1e6);
            let memory = format!("  memory           a daemon will hold {held} MB\n  {seconds:.1} s\n");
            output::lines(&(screen(prepared, file) + &memory))
        }
    }
}

/// Prints the warnings of a bake on stderr.
pub fn warn(prepared: &PreparedObject) {
    warnings(prepared).iter().for_each(|text| warning(text));
}

/// Prints one warning on stderr.
pub fn warning(text: &str) {
    output::note(&format!("warning: {text}"));
}

/// Warnings of a bake: the surface that was not asked for, a lattice too coarse for the shape, which loses or thickens parts of
/// about its spacing, parts that the lattice severs, fragments smaller than its cells, and cracks smaller than their slots.
pub fn warnings(prepared: &PreparedObject) -> Vec<String> {
    let reason = prepared.report.surface.reason.iter();
    let mut warnings: Vec<String> =
        reason.map(|reason| format!("the fragments have the lattice's surface, not the exact one: {reason}")).collect();
    warnings.extend(repaired(prepared));
    warnings.extend(double_precision(prepared));
    let report = &prepared.report;
    let error = report.volume_error();
    if error.abs() > VOLUME_ERROR_REPORTED {
        let (percent, spacing) = (100.0 * error, prepared.parameters.crack_spacing);
        let finer = match 0.5 * spacing {
            finer if finer >= SPACING_RANGE[0] => {
                format!("; try --crack-spacing {finer:.4} (now {spacing:.4}): {HALF_SPACING_COST}")
            }
            _ => String::new(),
        };
        warnings.push(format!(
            "the lattice's volume is {percent:+.1} % off the input's: it loses or thickens parts of about its spacing{finer}"
        ));
    }
    let severed = prepared.report.defects.iter().filter(|defect| defect.kind == DefectKind::SeveredPart);
    warnings.extend(severed.map(|defect| {
        let (bodies, quality) = (prepared.bodies.len(), prepared.parameters.quality.name());
        format!(
            "the lattice (preset `{quality}`) severs {} ({bodies} bodies in all): {}",
            defect.counted(),
            defect.action
        )
    }));
    let BakeParameters { fragment_size_m, crack_spacing, material, .. } = &prepared.parameters;
    // With a threshold of its own, the object has no use for the size.
    if prepared.gamma_j_m2 == reference_gamma(material.young_pa, material.strength_pa, *fragment_size_m) {
        warnings.extend(small_fragments(*fragment_size_m, crack_spacing * prepared.frame.diagonal_m));
    }
    warnings.extend(report.cracks.as_ref().and_then(|cracks| small_cracks(cracks, *crack_spacing)));
    warnings
}

/// Warning about factors that single precision was requested for in vain.
fn double_precision(prepared: &PreparedObject) -> Option<String> {
    let kept = prepared.double_precision_bodies();
    (kept > 0).then(|| {
        format!(
            "single precision is too inaccurate for the stiffness of {kept} of {} bodies: --factor f32 saves no memory there",
            prepared.bodies.len()
        )
    })
}

/// Warnings about repairs that changed a large part of the exact surface.
pub fn repaired(prepared: &PreparedObject) -> Vec<String> {
    let SurfaceReport { kind, repairs, .. } = &prepared.report.surface;
    let is_large = |own: &&SurfaceRepair| *kind == SurfaceKind::Exact && own.area_share > REPAIRED_SHARE_REPORTED;
    repairs.iter().filter(is_large).filter_map(|own| repaired_share(own, &prepared.name)).collect()
}

/// Warning about the share of the surface that a repair changed.
fn repaired_share(SurfaceRepair { kind, count, area_share, .. }: &SurfaceRepair, name: &str) -> Option<String> {
    let percent = 100.0 * area_share;
    let look = format!("`shatterd inspect {name} --mesh FILE.glb` writes the surface to look at");
    match kind {
        RepairKind::FilledHoles => Some(format!(
            "{percent:.0} % of the exact surface are films that close {}; where these are not meant, close them in the mesh and bake \
             again. {look}",
            counted(*count, "hole")
        )),
        RepairKind::DuplicateTriangles => Some(format!(
            "{} with the corners of others, {percent:.0} % of the mesh's area, left out; where they are meant to part solids, move \
             these apart in the mesh and bake again. {look}",
            counted(*count, "triangle")
        )),
        RepairKind::HiddenTriangles => Some(format!(
            "{} inside the solid, {percent:.0} % of the mesh's area, left out; where they are meant to bound a hollow, take away what \
             covers them in the mesh, or turn their shell, and bake again. {look}",
            counted(*count, "triangle")
        )),
        _ => None,
    }
}

/// Warning about fragments that are larger than the object; most likely their size was given in another unit than meters. Needs no
/// lattice, so that it can precede the bake.
pub fn large_fragments(size_m: f64, diagonal_m: f64) -> Option<String> {
    (size_m > diagonal_m).then(|| {
        format!(
            "fragments of {size_m} m (--fragment-size, in meters) are larger than the object, whose diagonal is {diagonal_m:.4} m, so that \
             most impacts leave it whole; the default is a tenth of the diagonal, {:.4} m",
            0.1 * diagonal_m
        )
    })
}

/// Warning about fragments that are smaller than a cell of the crack lattice.
fn small_fragments(size_m: f64, cell_m: f64) -> Option<String> {
    (size_m < cell_m).then(|| {
        format!(
            "fragments of {size_m} m (--fragment-size, in meters) are smaller than the spacing of the crack lattice, {cell_m:.4} m, which \
             limits the fragments; lower --crack-spacing"
        )
    })
}

/// Warning about existing cracks that are smaller than the slots they open.
fn small_cracks(cracks: &ExistingCracks, crack_spacing: f64) -> Option<String> {
    let size_m = cracks.area_m2.sqrt();
    (size_m < cracks.width_m).then(|| {
        format!(
            "the cracks are about {size_m:.2e} m large, and the slots that they open are {:.2e} m wide: the slots, not the cracks, weaken \
             the object; lower --crack-spacing (now {crack_spacing:.4}), or leave cracks of this size out",
            cracks.width_m
        )
    })
}

/// JSON document of `bake --json`.
fn document(prepared: &PreparedObject, file: &Path, warnings: &[String], seconds: f64) -> serde_json::Value {
    let report = &prepared.report;
    json!({
        "object": prepared.name,
        "file": file.display().to_string(),
        "elastic_nodes": prepared.elastic_nodes(),
        "elastic_tets": prepared.elastic_tets(),
        "elements_across": report.elements_across(),
        "discretisation_error": report.discretization_error(),
        "elastic": report.elastic,
        "stretch": report.stretch.map(|own| own.factor),
        "crack_nodes": prepared.crack_nodes(),
        "crack_tets": prepared.crack_tets(),
        "quality": prepared.parameters.quality,
        "elastic_spacing": prepared.parameters.elastic_spacing,
        "crack_spacing": prepared.parameters.crack_spacing,
        "lattice_volume_m3": report.lattice_volume_m3,
        "input_volume_m3": report.input_volume_m3,
        "volume_error": report.volume_error(),
        "surface": report.surface,
        "surface_deviation": report.surface_deviation,
        "gamma_j_m2": prepared.gamma_j_m2,
        "kappa": prepared.kappa,
        "examples": prepared.examples.len(),
        "learned": prepared.learned.as_ref().map(|learned| learned.quality),
        "reduced": prepared.reduction,
        "bodies": prepared.bodies.len(),
        "cracks": report.cracks,
        "defects": defects(&report.defects),
        "warnings": warnings,
        "unprepared": report.unprepared,
        "memory_bytes": prepared.bytes(),
        "seconds": seconds,
    })
}

/// JSON rows of a defect report, with counts in words.
pub fn defects(all: &[Defect]) -> Vec<serde_json::Value> {
    let line = |own: &Defect| {
        json!({
            "kind": own.kind,
            "count": own.count,
            "counted": own.counted(),
            "first_index": own.first_index,
            "first": own.first(),
            "action": own.action,
        })
    };
    all.iter().map(line).collect()
}

/// Elements of the bodies, those with the fewest cells across their walls of each order.
fn elements(prepared: &PreparedObject) -> Vec<String> {
    let report = &prepared.report;
    let fewest = |order: ElementOrder| {
        let all = report.elastic.iter().filter(|own| own.order == order);
        all.min_by(|a, b| a.elements_across.total_cmp(&b.elements_across))
    };
    let line = |own: &ElasticReport| {
        let order = match own.order {
            ElementOrder::Linear => "linear",
            ElementOrder::Quadratic => "quadratic",
        };
        let or_more = if own.elements_across < CELLS_MAX { "" } else { " or more" };
        let is_stiff = own.order == ElementOrder::Linear && own.elements_across < CELLS_LINEAR_MIN;
        let reason = match &own.reason {
            Some(reason) => format!(": {reason}"),
            None if is_stiff => ": up to 35 % too little energy where they bend, --elements auto mends it".to_owned(),
            None => String::new(),
        };
        let error = own
            .discretization_error
            .map_or(String::new(), |error| format!(", energies about {:.0} % too low", 100.0 * error));
        let stretch = report.stretch.map_or(String::new(), |own| format!(", {} times as long as thick", own.factor));
        format!("{order}, {:.1}{or_more} across the walls{stretch}{error}{reason}", own.elements_across)
    };
    [ElementOrder::Linear, ElementOrder::Quadratic].into_iter().filter_map(fewest).map(line).collect()
}

/// The errors of the reduced bases.
fn reduced(reduction: &ReductionErrors) -> String {
    let mut text = format!(
        "  reduced          rank {}; median error over {}: energy {:.2} %, density {:.1} %; {:.0} % of them were solved\n",
        reduction.rank.iter().map(usize::to_string).collect::<Vec<_>>().join(", "),
        counted(reduction.holdout as u64, "other impact"),
        100.0 * reduction.energy_error_median,
        100.0 * reduction.density_error_median,
        100.0 * reduction.solved
    );
    if let Some(completed) = &reduction.completed {
        let _ = writeln!(
            text,
            "                   completed by a linear solve: energy {:.2} %, density {:.1} %",
            100.0 * completed.energy_error_median,
            100.0 * completed.density_error_median
        );
    }
    text
}

/// Figures of a bake, with names for people and units.
pub fn screen(prepared: &PreparedObject, file: &Path) -> String {
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
    elements(prepared).iter().for_each(|line| text += &format!("  elements         {line}\n"));
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
    let deviation_m = report.surface_deviation * prepared.frame.diagonal_m;
    let _ = writeln!(text, "  deviation        {:.5} of the diagonal, {deviation_m:.2e} m", report.surface_deviation);
    let _ = writeln!(
        text,
        "  threshold        {:.4e} J·m² ({}, fragments of {:.4} m), kappa {:.3}",
        prepared.gamma_j_m2, parameters.material_name, parameters.fragment_size_m, prepared.kappa
    );
    let _ = writeln!(text, "  bodies           {}", prepared.bodies.len());
    text.extend(report.cracks.as_ref().map(cracks_line));
    if let Some(LearnedModel { quality, .. }) = &prepared.learned {
        let percent = |share: f64| 100.0 * share;
        let _ = writeln!(
            text,
            "  examples         {}; median error of left-out degrees of 8 and more: {:.1} %, closed form {:.1} %, labels \
             themselves {:.1} %",
            prepared.examples.len(),
            percent(quality.median_relative_error),
            percent(quality.closed_form_median),
            percent(quality.label_noise_median)
        );
    }
    text.push_str(&prepared.reduction.as_ref().map_or_else(String::new, reduced));
    text.push_str(&surface(report));
    if report.defects.is_empty() {
        let _ = writeln!(text, "  defects          none");
    }
    for defect in &report.defects {
        let _ = writeln!(
            text,
            "  defect           {}: {} (first at {}): {}",
            defect.kind,
            defect.counted(),
            defect.first(),
            one_line(&defect.action)
        );
    }
    for absent in &report.unprepared {
        let _ = writeln!(text, "  not prepared     lift {} of body {}: {}", absent.lift, absent.body, absent.reason);
    }
    text
}

/// The line about existing cracks.
fn cracks_line(cracks: &ExistingCracks) -> String {
    format!(
        "  cracks           {}, {:.4e} m²; slots of {:.4} m (elastic lattice {:.4} m) take {:.4e} m³\n",
        counted(cracks.triangles, "triangle"),
        cracks.area_m2,
        cracks.width_m,
        cracks.elastic_width_m,
        cracks.volume_m3
    )
}

/// The line about a repair of the surface, with its places.
fn repair_line(SurfaceRepair { kind, count, area_m2, places_m, .. }: &SurfaceRepair) -> String {
    let several = |one: &str, more: &str| format!("{count} {}", if *count == 1 { one } else { more });
    let done = match kind {
        RepairKind::DuplicateTriangles => {
            format!("{} with the corners of others left out, {area_m2:.3e} m²", several("triangle", "triangles"))
        }
        RepairKind::FilledHoles => format!("{} closed by films of {area_m2:.3e} m²", several("hole", "holes")),
        RepairKind::DividedEdges => {
            format!("{} closed: edges divided at the vertices on them (T-junctions)", several("slit", "slits"))
        }
        RepairKind::UnitedParts => {
            let crossing = several("triangle crosses", "triangles cross");
            format!("parts united where {crossing} others; {area_m2:.3e} m² of these are inside and left out")
        }
        RepairKind::HiddenTriangles => format!("{} inside the solid left out", several("triangle", "triangles")),
        RepairKind::DividedVertices => format!("{} divided, where parts touch", several("vertex", "vertices")),
        RepairKind::CollapsedEdges => format!("{} too short for single precision collapsed", several("edge", "edges")),
    };
    let shown: Vec<String> = places_m.iter().map(|at| format!("({:.4}, {:.4}, {:.4})", at.x, at.y, at.z)).collect();
    let more = if *count > shown.len() as u64 { " and others" } else { "" };
    format!("  repaired         {done}, near {}{more} m\n", shown.join(", "))
}

/// `text` of a file without line breaks, which could pass for lines of the report.
fn one_line(text: &str) -> String {
    text.replace(['\n', '\r'], " ")
}

/// The line about the surface of the fragments.
fn surface(report: &BakeReport) -> String {
    let SurfaceReport { kind, reason, nodes, tets, deviation, anchored_nodes, repairs, .. } = &report.surface;
    match (kind, reason) {
        (SurfaceKind::Exact, _) => {
            let mut line = format!(
                "  surface          exact: {nodes} nodes, {tets} tetrahedra; {:.6e} m³, deviation {deviation:.1e} of the diagonal",
                report.input_volume_m3
            );
            if *anchored_nodes > 0 {
                let (nodes, verb) =
                    (counted(*anchored_nodes, "node"), if *anchored_nodes == 1 { "follows" } else { "follow" });
                let _ = write!(line, "; {nodes} in details that the lattice lacks {verb} its nearest point");
            }
            line.push('\n');
            repairs.iter().for_each(|repair| line.push_str(&repair_line(repair)));
            line
        }
        (SurfaceKind::Lattice, Some(reason)) => {
            let mut line = format!("  surface          that of the lattice: {}\n", one_line(reason));
            repairs.iter().for_each(|repair| line.push_str(&repair_line(repair)));
            line
        }
        (SurfaceKind::Lattice, None) => "  surface          that of the lattice, as asked for\n".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fragment_sizes_that_do_not_fit_the_object_are_warned_of() {
        assert_eq!((small_fragments(0.017, 0.004), large_fragments(0.017, 0.17)), (None, None));
        let large = large_fragments(5.0, 0.17).unwrap();
        for part in ["fragments of 5 m", "diagonal is 0.1700 m", "0.0170 m"] {
            assert!(large.contains(part), "{large}");
        }
        let small = small_fragments(0.002, 0.004).unwrap();
        assert!(small.contains("fragments of 0.002 m") && small.contains("crack lattice, 0.0040 m"), "{small}");
    }

    #[test]
    fn cracks_smaller_than_their_slots_are_warned_of() {
        let cracks =
            |area_m2| ExistingCracks { triangles: 2, area_m2, width_m: 0.0077, elastic_width_m: 0.01, volume_m3: 1e-8 };
        assert_eq!(small_cracks(&cracks(1e-3), 0.02), None);
        let small = small_cracks(&cracks(1e-8), 0.02).unwrap();
        let one = cracks_line(&ExistingCracks { triangles: 1, ..cracks(1e-3) });
        assert!(one.starts_with("  cracks           1 triangle, 1.0000e-3 m²; slots of 0.0077 m"), "{one}");
        assert!(small.contains("1.00e-4 m large") && small.contains("7.70e-3 m wide"), "{small}");
    }
}
