//! Text of `shatterd inspect`: the figures of the bake, and those of the file, with names for people and units.

use super::bake_report;
use super::inspect_memory::memory_lines;
use serde_json::Value;
use shatter_fracture::pipeline::{PreparedObject, SurfaceKind};
use shatter_fracture::scene::rounded;
use shatter_fracture::sparse::Precision;
use shatter_fracture::strength::StrengthConstants;
use shatter_proto::text::counted;
use std::path::Path;

/// Constants of the criterion by strength and energy, with the length that follows from them.
fn fracture_constants(prepared: &PreparedObject) -> String {
    let constants = prepared.strength_constants();
    let StrengthConstants { toughness_j_m2, compressive_strength_pa, weibull_modulus, origin, .. } = constants;
    format!(
        "toughness {toughness_j_m2:.1} J/m², compressive strength {compressive_strength_pa:.3e} Pa, Weibull modulus \
         {weibull_modulus}, characteristic length {} mm ({})",
        rounded(1e3 * constants.characteristic_length_m()),
        origin.explanation()
    )
}

/// Lines about the object of the database `file`; `document` is what `--json` prints.
pub fn screen(prepared: &PreparedObject, file: &Path, document: &Value) -> String {
    let (parameters, material) = (&prepared.parameters, &prepared.parameters.material);
    let mut text = bake_report::screen(prepared, file);
    let mut line = |label: &str, value: String| text += &format!("  {label:<16} {value}\n");
    line(
        "material",
        format!(
            "{}: Young's modulus {:.3e} Pa, Poisson's ratio {}, density {} kg/m³, tensile strength {:.3e} Pa",
            parameters.material_name, material.young_pa, material.poisson, material.density_kg_m3, material.strength_pa
        ),
    );
    line("fracture", fracture_constants(prepared));
    line(
        "bake",
        format!(
            "quality {}, seed {}, {} of {}, stiffness factor {}{}",
            parameters.quality.name(),
            parameters.seed,
            counted(prepared.examples.len() as u64, "example"),
            counted(prepared.impacts, "impact"),
            word(&document["parameters"]["factor"]),
            if parameters.factor == Precision::F32 { ", or f64 where that is too inaccurate" } else { "" }
        ),
    );
    let learned = &document["learned"];
    if learned.is_object() {
        let (median, most) = (percent(&learned["median_relative_error"]), percent(&learned["p90_relative_error"]));
        let (few, count) = (percent(&learned["few_within_one"]), left_out(&learned["holdout"]));
        let errors = format!("median error {median}, 90 % have at most {most} ({count})");
        line("learned degree", format!("{errors}; degrees below 8 are off by at most one in {few}"));
    }
    line(
        "lifts",
        format!("dimensions per body: interior {}, surface {}", lifts(prepared, true), lifts(prepared, false)),
    );
    if let Some(skin) = &prepared.skin {
        let use_of = match prepared.report.surface.kind {
            SurfaceKind::Exact => "; for results with the lattice's surface",
            SurfaceKind::Lattice => "",
        };
        let triangles = counted(skin.triangles.len() as u64, "triangle");
        line("skin", format!("{triangles}: those of the mesh file, long ones divided{use_of}"));
    }
    let materials = &prepared.report.materials;
    if !materials.is_empty() {
        let names = materials.iter().enumerate().map(|(index, name)| format!("{index} {name}"));
        line("mesh materials", names.collect::<Vec<_>>().join(", "));
    }
    let normals = &document["normals_within_10_deg"];
    if normals.is_object() {
        let share = |key: &str| percent(&normals[key]);
        let (faces, smooth, carried) = (share("faces"), share("smooth"), share("carried"));
        line(
            "lattice normals",
            format!("within 10° of the mesh's: faces {faces}, smooth {smooth}, carried {carried} of the area"),
        );
    }
    let provenance = &document["provenance"];
    line(
        "file",
        format!(
            "format {}, {:.1} MB, by {} {}, input {}",
            word(&document["format"]),
            document["bytes"].as_f64().unwrap_or_default() / 1e6,
            word(&provenance["program"]),
            word(&provenance["version"]),
            word(&provenance["input_hash"])
        ),
    );
    for (label, key) in [("page", "page"), ("mesh written", "mesh")] {
        if let Some(path) = document[key].as_str() {
            line(label, path.to_owned());
        }
    }
    text + &anchored_lines(&document["anchored"]) + &time_lines(&document["time"]) + &memory_lines(&document["memory"])
}

/// Bases of displacements for anchors, a line each.
fn anchored_lines(anchored: &Value) -> String {
    let one = |own: &Value| {
        let nodes = counted(own["nodes"].as_u64().unwrap_or_default(), "node");
        format!("  {:<16} basis of body {} with {nodes} held: rank {}\n", "anchored", own["body"], own["rank"])
    };
    anchored.as_array().into_iter().flatten().map(one).collect()
}

/// Expected times of requests on this machine; empty without a measurement.
fn time_lines(time: &Value) -> String {
    let lines = [
        ("reduced_ms", "before the degree, reduced", "ms"),
        ("solve_ms", "before the degree, solved", "ms"),
        ("start_ms", "start of the diagram [constant, per site]", "ms"),
        ("iteration_ms", "one iteration of it [constant, per site]", "ms"),
        ("rest_ms", "after the diagram [constant, per √site]", "ms"),
        ("strikes", "measured requests", ""),
        ("log_error_median", "error of the logarithm, median", ""),
        ("log_error_p90", "error of the logarithm, 90 % of requests", ""),
    ];
    let shown = lines.iter().filter(|(key, ..)| time[*key].is_number() || time[*key].is_array());
    shown
        .map(|(key, label, unit)| format!("time: {label:<44} {} {unit}", time[*key]).trim_end().to_owned() + "\n")
        .collect()
}

/// Number of impacts without which the object learned its degree.
fn left_out(count: &Value) -> String {
    counted(count.as_u64().unwrap_or_default(), "left-out impact")
}

/// Dimensions of a lift, per body.
fn lifts(prepared: &PreparedObject, is_interior: bool) -> String {
    let of = |body: &shatter_fracture::pipeline::PreparedBody| match is_interior {
        true => body.interior.as_ref().map(|lift| lift.dimension),
        false => body.surface_diffusion.as_ref().map(|lift| lift.dimension),
    };
    let all = prepared.bodies.iter().map(|body| of(body).map_or("none".to_owned(), |dimension| dimension.to_string()));
    all.collect::<Vec<_>>().join(", ")
}

fn percent(share: &Value) -> String {
    format!("{:.1} %", 100.0 * share.as_f64().unwrap_or_default())
}

/// A text of the document without its quotes.
fn word(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}
