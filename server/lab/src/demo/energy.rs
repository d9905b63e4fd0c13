//! Strain energy on the surface of the intact object, for its picture: computed in this process with the daemon's engine and
//! database.

use super::DemoError;
use super::demo_impact::DemoImpact;
use super::object::{DemoTarget, RADIUS_M};
use nalgebra::Point3;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::lift::LiftKind;
use shatter_fracture::pipeline::{
    ContactSet, DEGREE_MAX, DegreeRequest, DisplacementMethod, FractureRequest, ImpactContact, PreparedObject,
    RequestContext, SurfaceKind, Workspace, strain_energy,
};
use shatter_fracture::scene::EffectSet;
use shatter_fracture::strength::Criterion;

/// Number of smoothing passes: the elastic lattice, on which densities are constant per tetrahedron, is coarser than the surface that
/// shows them.
const AVERAGES: usize = 3;

/// Boundary of the crack lattices with the strain energy density on it.
pub(super) struct SurfaceEnergy {
    /// Vertices relative to the center of the object's box, m.
    pub positions: Vec<Point3<f32>>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Strain energy density W per vertex, J/m³: energy of the node's share of the lattice over its volume, averaged over neighbors
    /// on the surface.
    pub density_j_m3: Vec<f64>,
    /// Strain energy of the whole object, J.
    pub energy_j: f64,
}

impl SurfaceEnergy {
    /// Solves the impact of `demo_impact` again.
    pub fn new(target: &DemoTarget, demo_impact: &DemoImpact) -> Result<Self, DemoError> {
        let contact = ImpactContact {
            point_m: target.point_m,
            impulse_ns: demo_impact.impulse_ns,
            duration_s: None,
            radius_m: Some(RADIUS_M),
            partner: None,
        };
        let strike = FractureRequest {
            contacts: vec![contact],
            degree: DegreeRequest::Inferred,
            degree_max: DEGREE_MAX,
            gamma_j_m2: None,
            strength_scale: 1.0,
            criterion: Criterion::Paper,
            elastic: DisplacementMethod::Solve,
            rank_max: None,
            lift: LiftKind::Interior,
            surface: SurfaceKind::Exact,
            effects: EffectSet::default(),
            volume_min_m3: None,
            tolerance: shatter_fracture::centroidal::TOLERANCE,
            iterations_max: shatter_fracture::centroidal::ITERATIONS_MAX,
            gap_max: None,
            reduced_error_max: 0.0,
            budget: None,
            seed: 0,
            threshold_only: true,
        };
        let prepared = &target.prepared;
        let impact = ContactSet::new(prepared, &strike)?;
        let energies = strain_energy(
            RequestContext::new(prepared, &strike, &CancelToken::default(), &()),
            &impact,
            &mut Workspace::default(),
        )?;
        let mut surface = Self { positions: vec![], triangles: vec![], density_j_m3: vec![], energy_j: 0.0 };
        for body in 0..prepared.bodies.len() {
            let struck = energies.iter().find(|energy| energy.body == body);
            surface.add(
                prepared,
                body,
                struck.map_or(&[], |energy| &energy.shares),
                struck.map_or(0.0, |e| e.energy_j),
            );
        }
        for _ in 0..AVERAGES {
            surface.average();
        }
        Ok(surface)
    }

    /// Replaces every density by a weighted mean: its vertex, and with half the weight the corners of the triangles around it.
    fn average(&mut self) {
        let mut sums = self.density_j_m3.clone();
        let mut weights = vec![1.0; sums.len()];
        for triangle in &self.triangles {
            let sum: f64 = triangle.iter().map(|&vertex| self.density_j_m3[vertex as usize]).sum();
            for &vertex in triangle {
                sums[vertex as usize] += 0.5 * sum;
                weights[vertex as usize] += 1.5;
            }
        }
        self.density_j_m3 = sums.iter().zip(&weights).map(|(sum, weight)| sum / weight).collect();
    }

    /// Adds the boundary of one body; a body without a contact has no shares and no energy.
    fn add(&mut self, prepared: &PreparedObject, body: usize, shares: &[f64], energy_j: f64) {
        let (body, meter) = (&prepared.bodies[body], prepared.frame.diagonal_m);
        let mut vertex = vec![u32::MAX; body.crack.nodes.len()];
        for face in body.crack.boundary() {
            let corners = face.nodes.map(|node| {
                let node = node as usize;
                if vertex[node] == u32::MAX {
                    vertex[node] = self.positions.len() as u32;
                    self.positions.push((body.crack.nodes[node] * meter).cast());
                    let volume_m3 = body.volumes[node] * meter.powi(3);
                    self.density_j_m3.push(shares.get(node).map_or(0.0, |share| share * energy_j / volume_m3));
                }
                vertex[node]
            });
            self.triangles.push(corners);
        }
        self.energy_j += energy_j;
    }
}
