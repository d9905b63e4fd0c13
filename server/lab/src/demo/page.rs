//! Contents of the demonstration's page.

use super::demo_impact::DemoImpact;
use super::energy::SurfaceEnergy;
use super::object::{DemoTarget, MATERIAL, NAME};
use super::progress::DemoProgress;
use super::{DemoError, views};
use crate::picture::ENERGY;
use crate::report::{Fact, ImpactReport, Page, ReportFigure, Scale, bytes, grouped, nanoseconds, share, significant};
use shatter_client::EnergySource;
use shatter_proto::text::counted;
use std::time::Duration;

/// Decades of strain energy density that the colors span, below the largest value of all requests.
const DECADES: f64 = 5.5;

/// Builds the page; `elapsed` is the time until now.
pub(super) fn page(
    target: &DemoTarget,
    pid: u32,
    demo_impacts: &[DemoImpact],
    energies: &[SurfaceEnergy],
    elapsed: Duration,
    progress: &DemoProgress,
) -> Result<Page, DemoError> {
    let scale = scale(energies);
    let mut strikes = Vec::with_capacity(demo_impacts.len());
    for (demo_impact, energy) in demo_impacts.iter().zip(energies) {
        progress.step(&format!("draw strike {}", demo_impact.number));
        strikes.push(strike(target, demo_impact, energy, &scale)?);
    }
    Ok(Page {
        title: "A mug, struck three times".to_owned(),
        opening: demo_impacts.iter().map(opening).collect(),
        lead: lead(target, pid, elapsed),
        strikes,
        facts: facts(target),
        notes: notes(),
    })
}

/// Fragments of one request, for the top of the page.
fn opening(demo_impact: &DemoImpact) -> ReportFigure {
    let pieces = counted(demo_impact.written.fragments as u64, "piece");
    let caption = format!("{} × the breaking impulse: {pieces}", demo_impact.factor);
    ReportFigure { png: demo_impact.picture.clone(), caption, scale: None }
}

fn lead(target: &DemoTarget, pid: u32, elapsed: Duration) -> Vec<String> {
    let database = if target.reused { "found it baked by an earlier run" } else { "baked it into a database" };
    vec![
        format!(
            "The program generated a mug of {MATERIAL}, {database}, and started a daemon (process {pid}), which loaded it. A client then \
             struck the mug at one place, with three multiples of the impulse that just breaks it. Requests and fragments traveled \
             through shared memory."
        ),
        format!("Without the pictures the run took {} s.", significant(elapsed.as_secs_f64(), 2)),
    ]
}

fn facts(target: &DemoTarget) -> Vec<Fact> {
    let prepared = &target.prepared;
    let (report, material) = (&prepared.report, &prepared.parameters.material);
    let nodes =
        |nodes: usize, tets: usize| format!("{} nodes, {} tetrahedra", grouped(nodes as u64), grouped(tets as u64));
    vec![
        Fact::new("Object", NAME),
        Fact::new(
            "Material",
            format!("{MATERIAL}: E {} GPa, ν {}", significant(material.young_pa / 1e9, 2), material.poisson),
        ),
        Fact::new("Diagonal", format!("{} m", significant(prepared.frame.diagonal_m, 3))),
        Fact::new("Volume", format!("{} cm³", significant(report.lattice_volume_m3 * 1e6, 4))),
        Fact::new("Volume error", share(report.volume_error())),
        Fact::new("Elastic lattice", nodes(prepared.elastic_nodes(), prepared.elastic_tets())),
        Fact::new("Crack lattice", nodes(prepared.crack_nodes(), prepared.crack_tets())),
        Fact::new("Threshold γ", format!("{} J·m²", significant(prepared.gamma_j_m2, 3))),
        Fact::new("Examples", prepared.examples.len().to_string()),
        Fact::new("Memory in the daemon", bytes(prepared.bytes() as u64)),
    ]
}

fn strike(
    target: &DemoTarget,
    demo_impact: &DemoImpact,
    energy: &SurfaceEnergy,
    scale: &Scale,
) -> Result<ImpactReport, DemoError> {
    let intact = ReportFigure {
        png: views::intact(energy, scale, target)?,
        caption:
            "The intact mug at the peak of the blow: strain energy density on its surface, logarithmic; the arrow \
                  ends where it is struck."
                .to_owned(),
        scale: Some(scale.clone()),
    };
    let fragments = counted(demo_impact.written.fragments as u64, "fragment");
    let fragments_figure = ReportFigure {
        png: demo_impact.picture.clone(),
        caption: format!("The {fragments}, moved apart. Outer faces have a color per fragment, cracks are pale."),
        scale: None,
    };
    let impulse = significant(demo_impact.impulse_ns.norm(), 3);
    Ok(ImpactReport {
        heading: format!("{} × the breaking impulse: {fragments}", demo_impact.factor),
        lead: format!("{impulse} N·s at the outer wall; {} of strain energy at the peak.", joules(energy.energy_j)),
        figures: vec![fragments_figure, intact],
        facts: impact_facts(target, demo_impact, &impulse),
        stages: demo_impact.stages.clone(),
        file: Some(demo_impact.file.clone()),
    })
}

fn impact_facts(target: &DemoTarget, demo_impact: &DemoImpact, impulse: &str) -> Vec<Fact> {
    let summary = &demo_impact.summary;
    let whole = target.prepared.report.lattice_volume_m3;
    let source = summary.degree_origin.name().replace('_', " ");
    let capped = if summary.is_capped { ", capped" } else { "" };
    let [lightest, heaviest] = demo_impact.masses_kg.map(|mass| significant(mass * 1e3, 3));
    vec![
        Fact::new("Impulse", format!("{impulse} N·s")),
        Fact::new("E₁ / γ", significant(summary.e1_over_gamma, 3)),
        Fact::new("Contact radius in effect", format!("{} mm", significant(summary.radius_m * 1e3, 3))),
        Fact::new("Displacements", displacements(demo_impact)),
        Fact::new("Sites", summary.sites.to_string()),
        Fact::new("Fracture degree", format!("{} ({source}{capped})", summary.fracture_degree)),
        Fact::new("Fragments", demo_impact.written.fragments.to_string()),
        Fact::new("Closed surfaces", format!("{} of {}", demo_impact.closed, demo_impact.written.fragments)),
        Fact::new("Sum of volumes against the lattice", format!("{:+.1e}", demo_impact.volume_m3 / whole - 1.0)),
        Fact::new("Mass of a fragment", format!("{lightest} to {heaviest} g")),
        Fact::new("Time in the daemon", nanoseconds(u64::try_from(summary.time.as_nanos()).unwrap_or(u64::MAX))),
        Fact::new("Round trip", nanoseconds(demo_impact.round_trip_ns)),
        Fact::new("Result size", bytes(demo_impact.bytes)),
    ]
}

/// Source of the displacements, and the error of their energy.
fn displacements(demo_impact: &DemoImpact) -> String {
    match demo_impact.summary.energy_source {
        EnergySource::Reduced => {
            format!("from examples, energy off by {} (estimated)", share(demo_impact.summary.energy_error))
        }
        source => source.name().to_owned(),
    }
}

fn joules(energy_j: f64) -> String {
    if energy_j < 1.0 {
        format!("{} mJ", significant(energy_j * 1e3, 3))
    } else {
        format!("{} J", significant(energy_j, 3))
    }
}

/// Common scale of all requests, so that their colors are comparable.
fn scale(energies: &[SurfaceEnergy]) -> Scale {
    let largest = energies.iter().flat_map(|energy| &energy.density_j_m3).copied().fold(f64::MIN_POSITIVE, f64::max);
    let low = largest * 10_f64.powf(-DECADES);
    Scale { ramp: ENERGY, low, high: largest, label: "Strain energy density W, J/m³".to_owned() }
}

fn notes() -> Vec<String> {
    [
        "E₁ is the distance-weighted strain energy of the whole mug, γ the largest that one fragment may hold. Where E₁ is \
         not above γ the object stays whole; the fracture degree is the number of fragments that brings every one of them \
         below γ, here inferred from the examples of the bake. Sites are asked of the Voronoi diagram; cells \
         that fall apart become several fragments.",
        "Times are those of the daemon, in the order of the stages, of the last of five equal strikes: the first one allocates memory. The \
         bars of all strikes share one scale. The client measures the round trip.",
        "The colors of the intact mug are computed by the program that wrote this page, with the daemon's engine and from \
         the daemon's database, and averaged over neighboring vertices; the fragments are the daemon's own.",
        "The .glb files beside this page hold one node per fragment in meters, +Y up. They open in any glTF viewer and \
         carry EXT_mesh_manifold, which says how their vertices join into closed surfaces.",
    ]
    .map(str::to_owned)
    .to_vec()
}
