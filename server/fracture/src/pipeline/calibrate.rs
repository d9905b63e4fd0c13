//! κ: how many more sites the criterion wants than the closed form says, fitted on impacts sampled over the surface.
//!
//! Based on: method of the house (section 1): n = max(2, round(κ·n₀)); n₀ after Gersho (1979) and Zador (1982).

use super::{Body, Impact, Prepared, Strike, StrikeError, Workspace, strain_energy};
use crate::centroidal::Field;
use crate::degree::{self, Curve, CurveOptions};
use crate::random::Stream;
use crate::token::Token;
use nalgebra::{Point3, Vector3};

/// Impacts sampled.
const IMPACTS: u64 = 6;

/// The curves end at this many sites.
const SITES_MAX: usize = 40;

/// κ from the curves E_max(n) of sampled impacts.
pub fn calibrate(prepared: &Prepared, token: &Token) -> Result<f64, StrikeError> {
    let mut workspace = Workspace::default();
    let mut stream = Stream::new(prepared.parameters.seed, 0);
    let mut samples = Vec::new();
    let largest = &prepared.bodies[0];
    for sample in 0..IMPACTS {
        let (point, inward) = surface_sample(largest, &mut stream);
        let impact = Impact::new(prepared, &pressed(prepared, &point, &inward))?;
        for mut energy in strain_energy(prepared, &impact, &mut workspace, token, &mut ())? {
            let body = &prepared.bodies[energy.body];
            let field = Field::new(&body.interior, &body.volumes, &mut energy.shares)
                .map_err(|source| StrikeError::Field { body: energy.body, source })?;
            let options = CurveOptions { sites_max: SITES_MAX, seed: sample, ..CurveOptions::default() };
            let mut curve = Curve::new(&field, options);
            curve.extend(&field, 0.0, &mut workspace.centroidal, token)?;
            samples.extend(degree::samples(&field, &body.slenderness, &curve));
        }
    }
    Ok(degree::fit_kappa(&samples).map_or(degree::KAPPA, |calibration| calibration.kappa))
}

/// A point on the boundary, uniform by area, and the inward normal there; local.
fn surface_sample(body: &Body, stream: &mut Stream) -> (Point3<f64>, Vector3<f64>) {
    let corners = |face: usize| body.topology.boundary[face].nodes.map(|node| body.crack.nodes[node as usize]);
    let normal = |[a, b, c]: [Point3<f64>; 3]| (b - a).cross(&(c - a));
    let areas: Vec<f64> = (0..body.topology.boundary.len()).map(|face| normal(corners(face)).norm()).collect();
    let mut left = stream.uniform() * areas.iter().sum::<f64>();
    let face = areas.iter().position(|area| {
        left -= area;
        left < 0.0
    });
    let face = corners(face.unwrap_or(areas.len() - 1));
    let [a, b, c] = face.map(|corner| corner.coords / 3.0);
    (Point3::from(a + b + c), -normal(face).normalize())
}

fn pressed(prepared: &Prepared, point: &Point3<f64>, inward: &Vector3<f64>) -> Strike {
    Strike { seed: prepared.parameters.seed, ..Strike::at(prepared.frame.to_metres(point), *inward) }
}
