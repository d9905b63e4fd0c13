//! Figure of a body struck by steel balls.

use super::scene::{PaperBody, PaperContact, SPREAD, pictures};
use super::{Panel, PaperError, PaperFigure};
use crate::picture::{Color, DrawnMesh};
use crate::study::gallery::ball;
use nalgebra::{Point3, Vector3};
use shatter_export::contact::{ContactBody, ElasticMaterial};
use std::f64::consts::PI;

/// Steel ball and its trajectory.
pub struct Ball {
    radius_m: f64,
    speed_m_s: f64,
    /// Height of the contact over the body's height.
    height: f64,
}

/// Balls from small and slow to large and fast.
pub const BALLS: [Ball; 3] = [
    Ball { radius_m: 0.015, speed_m_s: 8.0, height: 0.55 },
    Ball { radius_m: 0.020, speed_m_s: 14.0, height: 0.55 },
    Ball { radius_m: 0.030, speed_m_s: 20.0, height: 0.55 },
];

/// Density of steel, kg/m³ (EN 1993-1-1, 3.2.6).
const STEEL_KG_M3: f64 = 7850.0;

/// Half the height of the band in which the contact is searched, over the body's height.
const BAND: f64 = 0.05;

const METAL: Color = Color([0.23, 0.25, 0.29]);

/// Draws the figure.
pub fn drawn(body: &PaperBody, progress: &mut dyn FnMut(&str)) -> Result<PaperFigure, PaperError> {
    let (mut panels, mut meshes) = (Vec::<Panel>::new(), Vec::<DrawnMesh>::new());
    for own in &BALLS {
        progress("a ball");
        let out = Vector3::new(body.from.x, 0.0, body.from.z).normalize();
        let point_m = place(&body.vertices_m, own.height, &out).ok_or(PaperError::Empty)?;
        let mass_kg = 4.0 / 3.0 * PI * own.radius_m.powi(3) * STEEL_KG_M3;
        let partner = ContactBody { material: ElasticMaterial::STEEL, mass_kg, radius_m: own.radius_m };
        let paper_contact = PaperContact {
            point_m,
            direction: -out,
            partner,
            speed_m_s: own.speed_m_s,
            own_radius_m: f64::INFINITY,
            gamma_factor: 1.0,
        };
        let caption = format!("{:.0} g, {:.0} mm, {:.0} m/s", 1e3 * mass_kg, 2e3 * own.radius_m, own.speed_m_s);
        let (panel, result) = body.strike(&paper_contact, own.radius_m, caption)?;
        let mut mesh = result.mesh(SPREAD);
        let touched = result.point(&point_m).coords * (1.0 + SPREAD as f32);
        let center = touched + out.cast::<f32>() * (1.4 * own.radius_m as f32);
        mesh.append(ball(Point3::from(center), own.radius_m as f32, METAL));
        panels.push(panel);
        meshes.push(mesh);
    }
    let images = pictures(&meshes, body.from.cast());
    let caption = "A body struck by steel balls, from small and slow to large and fast";
    PaperFigure::new("paper-balls", caption, panels.into_iter().zip(images).collect())
}

/// Vertex that is farthest along `out` at that relative height.
fn place(vertices_m: &[Point3<f64>], height: f64, out: &Vector3<f64>) -> Option<Point3<f64>> {
    let (low, high) = vertices_m
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), point| (low.min(point.y), high.max(point.y)));
    let band = |share: f64| low + share * (high - low);
    let within = |point: &&Point3<f64>| (band(height - BAND)..=band(height + BAND)).contains(&point.y);
    let further = |a: &&Point3<f64>, b: &&Point3<f64>| a.coords.dot(out).total_cmp(&b.coords.dot(out));
    vertices_m.iter().filter(within).max_by(further).copied()
}
