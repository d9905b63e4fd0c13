//! Ledger of a fracture: the uses of its strain energy.

use super::meshes::FractureMeshes;
use super::release_velocity::{RELEASE_SHARE, ReleaseVelocity};
use super::rows::FragmentRow;
use super::slivers::area;
use crate::pipeline::stages::cells::BodyCells;
use crate::pipeline::stages::energy::BodyEnergy;
use crate::pipeline::workspace::body_meshes::BodyMeshes;
use crate::scene::EffectKind;
use crate::strength::affordable_count;
use nalgebra::{Matrix3, Vector3};

/// Share 1 − η of the strain energy that may become new surface.
pub(in crate::pipeline) const CRACK_SHARE: f64 = 1.0 - RELEASE_SHARE;

/// Share of its energy that a body may use after its number of sites was lowered, since cracks of fewer sites are estimated.
const LOWERED_SHARE: f64 = 0.9;

/// Energies of a fracture, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyLedger {
    /// Toughness times the area of all new cracks, each counted once.
    pub surface_j: f64,
    /// Kinetic energy of the release velocities; `None` without the effect `release`.
    pub released_j: Option<f64>,
    /// By how much surface and release exceed the strain energy: a given number of sites needs that much more.
    pub deficit_j: f64,
}

impl EnergyLedger {
    /// The ledger of `meshes`, of bodies with these strain energies.
    pub(in crate::pipeline) fn new(meshes: &FractureMeshes, energies: &[BodyEnergy], toughness_j_m2: f64) -> Self {
        let surface_j = toughness_j_m2 * meshes.crack_areas_m2().iter().map(|(_, area_m2)| area_m2).sum::<f64>();
        let released_j = meshes.effects.has(EffectKind::Release).then(|| meshes.kinetic_energy_j());
        let strain_j: f64 = energies.iter().filter_map(|energy| energy.strain_j).sum();
        let deficit_j = (surface_j + released_j.unwrap_or(0.0) - strain_j).max(0.0);
        Self { surface_j, released_j, deficit_j }
    }
}

impl FractureMeshes {
    /// Area of the new cracks of every body, m², by index of the body.
    ///
    /// Both fragments of a crack have its triangles; they count once. Cracks of earlier fractures have no neighbor.
    pub(in crate::pipeline) fn crack_areas_m2(&self) -> Vec<(usize, f64)> {
        let square_m2 = self.transform.meters_per_unit.powi(2);
        let of = |body: &BodyMeshes| {
            let cracks = body.tessellation.runs().iter().filter(|run| run.neighbor.is_some());
            let both: f64 = cracks.map(|run| area(&body.tessellation, run)).sum();
            (body.body, 0.5 * both * square_m2)
        };
        self.bodies.iter().map(of).collect()
    }

    /// Kinetic energy of the release velocities, J.
    fn kinetic_energy_j(&self) -> f64 {
        let of = |(row, velocity): (&FragmentRow, &ReleaseVelocity)| {
            let [xx, yy, zz, xy, xz, yz] = row.inertia_kg_m2;
            let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
            let spin: Vector3<f64> = velocity.angular_rad_s;
            0.5 * (row.mass_kg * velocity.linear_m_s.norm_squared() + spin.dot(&(inertia * spin)))
        };
        self.fragments.iter().zip(&self.velocities).map(of).sum()
    }
}

/// Lowers the limits of bodies whose cracks need more energy than they have; returns whether there was one.
///
/// `limits` has one entry per struck body. The first turn lowers a limit to the number of sites whose cracks should need no
/// more. A body whose cracks still need too much stays intact.
pub(in crate::pipeline) fn lower_limits(
    (limits, turn): (&mut [u32], usize),
    cells: &[BodyCells],
    (meshes, energies): (&FractureMeshes, &[BodyEnergy]),
    toughness_j_m2: f64,
) -> bool {
    let areas = meshes.crack_areas_m2();
    let mut is_lowered = false;
    for own in cells {
        let (energy, sites) = (&energies[own.struck], own.diagram.count() as u32);
        // A fragment that is struck again is the only body of its request, but keeps the index of its body in the object.
        let area_m2 =
            areas.iter().find(|(body, _)| *body == energy.body).or(areas.first()).map_or(0.0, |(_, area)| *area);
        let ratio = CRACK_SHARE * energy.strain_j.unwrap_or(0.0) / (toughness_j_m2 * area_m2);
        if ratio >= 1.0 || area_m2 == 0.0 {
            continue;
        }
        is_lowered = true;
        let fewer = affordable_count(sites, LOWERED_SHARE * ratio, 3).max(2).min(sites.saturating_sub(1));
        limits[own.struck] = if turn == 0 { fewer } else { 1 };
    }
    is_lowered
}
