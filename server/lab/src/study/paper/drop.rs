//! Figure of a body dropped on its head at three thresholds.

use super::scene::{PaperBody, PaperContact, SPREAD, pictures};
use super::{Panel, PaperError, PaperFigure};
use crate::picture::DrawnMesh;
use nalgebra::{Point3, Rotation3, Unit, Vector3};
use shatter_export::contact::{ContactBody, ElasticMaterial};

/// γ over the body's own γ, in descending order.
pub const GAMMAS: [f64; 3] = [4.0, 1.0, 0.25];

/// Height of the fall, m.
const FALL_M: f64 = 1.0;

/// Standard gravity, m/s².
const GRAVITY_M_S2: f64 = 9.806_65;

/// Radius of the head at its contact with the floor, m.
const HEAD_RADIUS_M: f64 = 0.02;

/// Draws the figure.
pub fn drawn(body: &PaperBody, progress: &mut dyn FnMut(&str)) -> Result<PaperFigure, PaperError> {
    let higher = |a: &&Point3<f64>, b: &&Point3<f64>| a.y.total_cmp(&b.y);
    let head_m = *body.vertices_m.iter().max_by(higher).ok_or(PaperError::Empty)?;
    // The floor pushes through the center, so the body does not rotate.
    let inward = body.prepared.frame.center_m - head_m;
    let upright = upright(&inward);
    let (mut panels, mut meshes) = (Vec::<Panel>::new(), Vec::<DrawnMesh>::new());
    for gamma_factor in GAMMAS {
        progress("a fall");
        let paper_contact = PaperContact {
            point_m: head_m,
            direction: inward,
            partner: ContactBody::ground(ElasticMaterial::CONCRETE),
            speed_m_s: (2.0 * GRAVITY_M_S2 * FALL_M).sqrt(),
            own_radius_m: HEAD_RADIUS_M,
            gamma_factor,
        };
        let (panel, result) = body.strike(&paper_contact, HEAD_RADIUS_M, format!("γ times {gamma_factor}"))?;
        let mut mesh = result.mesh(SPREAD);
        mesh.positions.iter_mut().for_each(|point| *point = upright * *point);
        mesh.corners.iter_mut().flatten().for_each(|corner| corner.normal = upright * corner.normal);
        panels.push(panel);
        meshes.push(mesh);
    }
    let images = pictures(&meshes, body.from.cast());
    let caption = "The same body dropped on its head from a meter, on concrete; γ falls from left to right";
    PaperFigure::new("paper-drop", caption, panels.into_iter().zip(images).collect())
}

/// Rotation that turns `inward`, from the head to the center, upwards.
fn upright(inward: &Vector3<f64>) -> Rotation3<f32> {
    let half_turn = || Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let inward = Unit::try_new(*inward, 0.0).unwrap_or(Vector3::y_axis());
    Rotation3::rotation_between(&inward, &Vector3::y()).unwrap_or_else(half_turn).cast()
}
