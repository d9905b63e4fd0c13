//! Page with both figures.

use super::{Panel, PaperFigure, PaperPlan};
use crate::report::{Fact, ReportFigure, ReportTable, Section, Study, significant};
use shatter_proto::text::counted;

/// Builds the page.
pub fn page(plan: &PaperPlan, drawn: &[PaperFigure]) -> Study {
    Study {
        title: format!("The paper's figures: {}", plan.name),
        lead: vec![
            "Two figures of Schvartzman & Otaduy (I3D 2014), reproduced: how cracks follow the impact, and how γ controls the fragments. \
             Impulses, durations and radii of contacts are those of elastic collisions (Hertz; Johnson 1985)."
                .to_owned(),
        ],
        facts: vec![Fact::new("quality", plan.quality.name()), Fact::new("diagonal", format!("{} m", super::DIAGONAL_M))],
        sections: drawn.iter().map(section).collect(),
    }
}

fn section(drawn: &PaperFigure) -> Section {
    let reported: Vec<String> = drawn
        .panels
        .iter()
        .map(|own| format!("{} ({})", own.caption, counted(own.fragments as u64, "piece")))
        .collect();
    let caption = format!("From the left: {}.", reported.join("; "));
    let head = [
        "",
        "kg",
        "radius, mm",
        "m/s",
        "impulse, N·s",
        "contact, µs",
        "contact radius, mm",
        "γ, J·m²",
        "E₁/γ",
        "sites",
        "pieces",
    ];
    Section {
        heading: drawn.caption.to_owned(),
        figures: vec![ReportFigure { png: drawn.png.clone(), caption, scale: None }],
        tables: vec![ReportTable {
            head: head.map(str::to_owned).to_vec(),
            rows: drawn.panels.iter().map(row).collect(),
        }],
        ..Section::default()
    }
}

fn row(own: &Panel) -> (&'static str, Vec<String>) {
    let numbers = [
        own.mass_kg,
        1e3 * own.radius_m,
        own.speed_m_s,
        own.impulse_ns,
        1e6 * own.duration_s,
        1e3 * own.contact_radius_m,
        own.gamma_j_m2,
        own.e1_over_gamma,
    ];
    let counts = [own.sites.to_string(), own.fragments.to_string()];
    let numbers = numbers.map(|number| significant(number, 3));
    ("", [own.caption.clone()].into_iter().chain(numbers).chain(counts).collect())
}
