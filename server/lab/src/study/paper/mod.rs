//! Reproduction of the paper's two application figures: a body struck by metal balls, and one dropped on its head at three
//! thresholds γ.
//!
//! Based on: Schvartzman & Otaduy, *Fracture Animation Based on High-Dimensional Voronoi Diagrams* (I3D 2014), figures 1 and 3; impulses,
//! durations and radii by Hertz theory (`shatter_export::contact`).

mod balls;
mod drop;
mod error;
mod page;
mod scene;

pub use error::PaperError;
pub use page::page;

use crate::picture::Image;
use scene::PaperBody;
use serde_json::{Value, json};
use shatter_fracture::pipeline::Preset;
use shatter_fracture::surface::{RawMesh, shapes};

/// Diagonal to which the body is scaled, m, so that the balls fit.
const DIAGONAL_M: f64 = 0.5;

/// Plan of the figures.
#[derive(Clone, Debug)]
pub struct PaperPlan {
    /// Name of the body.
    pub name: String,
    /// Mesh of the body in any unit; it is scaled.
    pub mesh: RawMesh,
    /// Preset of the lattices and of the requests.
    pub quality: Preset,
    /// Horizontal direction from which balls and camera come.
    pub from: [f64; 3],
}

impl PaperPlan {
    /// Plan for a body of that name, at the preset `film`.
    pub fn new(name: impl Into<String>, mesh: RawMesh) -> Self {
        Self { name: name.into(), mesh, quality: Preset::Film, from: [0.75, 0.25, 1.0] }
    }

    /// Plan for the horse of the usual mesh collection, which faces -Z when upright: seen from its side, a little from ahead.
    pub fn horse(mesh: RawMesh) -> Self {
        Self { from: [1.0, 0.25, -0.55], ..Self::new("horse", mesh) }
    }

    /// Plan for a generated statue.
    pub fn statue() -> Self {
        Self::new("statue", shapes::scanned_statue())
    }

    /// Number of progress steps.
    pub fn steps(&self) -> usize {
        1 + balls::BALLS.len() + drop::GAMMAS.len()
    }
}

/// Panel of a figure: an impact and its result.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Caption of the panel.
    pub caption: String,
    /// Impacting mass, kg: of the ball, or of the falling body.
    pub mass_kg: f64,
    /// Radius of the ball, or of the head, m.
    pub radius_m: f64,
    /// Speed, m/s.
    pub speed_m_s: f64,
    /// Impulse, N·s.
    pub impulse_ns: f64,
    /// Duration of the contact, s.
    pub duration_s: f64,
    /// Radius of the contact, m.
    pub contact_radius_m: f64,
    /// γ, J·m².
    pub gamma_j_m2: f64,
    /// E_1/γ.
    pub e1_over_gamma: f64,
    /// Number of sites.
    pub sites: u32,
    /// Number of fragments.
    pub fragments: usize,
}

/// Figure of several panels.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperFigure {
    /// File name without extension.
    pub file: &'static str,
    /// Caption of the figure.
    pub caption: &'static str,
    /// Panels from the left.
    pub panels: Vec<Panel>,
    /// Bytes of a PNG file.
    pub png: Vec<u8>,
}

impl PaperFigure {
    fn new(file: &'static str, caption: &'static str, all: Vec<(Panel, Image)>) -> Result<Self, PaperError> {
        let (panels, images): (Vec<Panel>, Vec<Image>) = all.into_iter().unzip();
        Ok(Self { file, caption, panels, png: Image::beside(&images).png()? })
    }

    /// Comma-separated values.
    pub fn csv(&self) -> String {
        let head = "mass_kg,radius_m,speed_m_s,impulse_ns,duration_s,contact_radius_m,gamma_j_m2,e1_over_gamma,sites,fragments";
        let row = |own: &Panel| {
            let numbers = [
                own.mass_kg,
                own.radius_m,
                own.speed_m_s,
                own.impulse_ns,
                own.duration_s,
                own.contact_radius_m,
                own.gamma_j_m2,
                own.e1_over_gamma,
            ];
            let numbers = numbers.map(|number| format!("{number:e}")).join(",");
            format!("{numbers},{},{}\n", own.sites, own.fragments)
        };
        format!("{head}\n{}", self.panels.iter().map(row).collect::<String>())
    }

    /// JSON document of the figure.
    fn document(&self) -> Value {
        let panel = |own: &Panel| {
            json!({
                "mass_kg": own.mass_kg, "radius_m": own.radius_m, "speed_m_s": own.speed_m_s, "impulse_ns": own.impulse_ns,
                "duration_s": own.duration_s, "contact_radius_m": own.contact_radius_m, "gamma_j_m2": own.gamma_j_m2,
                "e1_over_gamma": own.e1_over_gamma, "sites": own.sites, "fragments": own.fragments,
            })
        };
        json!({ "figure": self.file, "panels": self.panels.iter().map(panel).collect::<Vec<_>>() })
    }
}

/// Bakes the body, strikes it and draws both figures; calls `progress` with the name of each step.
///
/// # Errors
/// [`PaperError`], by what failed.
pub fn run(plan: &PaperPlan, progress: &mut dyn FnMut(&str)) -> Result<[PaperFigure; 2], PaperError> {
    progress("baking");
    let body = PaperBody::new(plan)?;
    Ok([balls::drawn(&body, progress)?, drop::drawn(&body, progress)?])
}

/// JSON document of both figures.
pub fn document(plan: &PaperPlan, drawn: &[PaperFigure]) -> Value {
    let figures: Vec<Value> = drawn.iter().map(PaperFigure::document).collect();
    json!({ "object": plan.name, "quality": plan.quality.name(), "diagonal_m": DIAGONAL_M, "figures": figures })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stronger_impacts_and_lower_thresholds_give_more_fragments() {
        let plan = PaperPlan { quality: Preset::Draft, ..PaperPlan::new("statue", shapes::statue()) };
        let mut reported = 0;
        let [balls, falls] = run(&plan, &mut |_| reported += 1).unwrap();
        assert_eq!(reported, plan.steps());
        for drawn in [&balls, &falls] {
            assert!(drawn.png.starts_with(&[0x89, b'P', b'N', b'G']));
            let rising = drawn
                .panels
                .windows(2)
                .all(|two| two[0].sites < two[1].sites && two[0].e1_over_gamma < two[1].e1_over_gamma);
            assert!(rising && drawn.panels.iter().all(|own| own.fragments >= own.sites as usize), "{:?}", drawn.panels);
            assert_eq!(drawn.csv().lines().count(), 1 + drawn.panels.len());
        }
        let gammas: Vec<f64> = falls.panels.iter().map(|own| own.gamma_j_m2 / falls.panels[1].gamma_j_m2).collect();
        assert_eq!(gammas, drop::GAMMAS);
        let first = &balls.panels[0];
        // A ball that bounces off a heavier body transfers nearly twice its momentum.
        let momentum = first.mass_kg * first.speed_m_s;
        assert!(first.impulse_ns < 2.0 * momentum && first.impulse_ns > momentum, "{first:?}");
        assert!((first.mass_kg / (4.0 / 3.0 * std::f64::consts::PI * first.radius_m.powi(3)) - 7850.0).abs() < 1e-6);
        let again = PaperBody::new(&plan).and_then(|body| balls::drawn(&body, &mut |_| ())).unwrap();
        assert_eq!(again, balls);
    }
}
