//! Onset stage: where a struck body is closest to breaking, by strength and by energy.
//!
//! Stresses come from the displacement of the elastic lattice; around contacts, from that of a half-space. See
//! [`crate::strength`].

use super::contact_set::ContactSet;
use super::energy::BodyEnergy;
use crate::elasticity::{Elasticity, NodalLoad};
use crate::pipeline::error::FractureError;
use crate::pipeline::prepared::object::{ElasticModel, PreparedObject};
use crate::pipeline::request::context::RequestContext;
use crate::strength::{
    ContactStress, ContactZone, Deformation, HotSpot, Onset, StrengthConstants, SurfaceForce, affordable_count,
    cell_dimension, normals_across, normals_around,
};
use nalgebra::Vector3;

/// Radius in radii of the lattice's load within which the stress is that of a half-space.
const NEAR_RADII: f64 = 2.0;

/// Place of a body with a large stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StressPeak {
    /// Node of the elastic lattice.
    pub node: u32,
    /// Averaged equivalent stress over the tensile strength.
    pub stress_over_strength: f64,
    /// Direction of the largest principal stress; at a contact, the outer normal.
    pub axis: Vector3<f64>,
    /// True if the stress is that of a contact on a half-space.
    pub is_contact: bool,
}

/// A body as its stresses need it.
pub(in crate::pipeline) struct StressedBody<'a> {
    /// Index among the struck bodies.
    pub place: usize,
    pub solid: &'a ElasticModel,
    /// Its elasticity, free or anchored.
    pub elasticity: &'a Elasticity,
    pub deformation: Deformation<'a>,
    pub load: &'a NodalLoad,
}

impl StressedBody<'_> {
    /// The largest stresses outside of all contacts, in descending order, then that of every contact.
    pub fn peaks(
        &self,
        RequestContext { prepared, request, .. }: RequestContext<'_>,
        contacts: &ContactSet,
    ) -> Result<Vec<StressPeak>, FractureError> {
        let Self { solid, elasticity, load, .. } = self;
        let constants = request.strength_constants(prepared);
        let (tables, boundary) = (solid.strength_tables(), elasticity.boundary());
        let unit = contacts.peak_force_n / (prepared.frame.diagonal_m.powi(2) * constants.strength_pa);
        let ratio = constants.strength_pa / constants.compressive_strength_pa;
        let (index, own) = &contacts.bodies[self.place];
        // The lattice has the stress of its own load, which may be wider than the contact.
        let zones = load.touches.iter().map(|touch| ContactZone {
            place: touch.place,
            normal: touch.normal,
            radius: NEAR_RADII * touch.spread,
        });
        let zones: Vec<ContactZone> = zones.collect();
        let (length, _) = averaging_length(prepared, &constants, elasticity);
        let hot = tables.hot_spots((elasticity, &solid.lattice), self.deformation, &zones, (length, ratio));
        let hot = hot.map_err(|source| FractureError::of_body(*index, source))?;
        let of_spot = |own: &HotSpot| StressPeak {
            node: own.node,
            stress_over_strength: own.stress * unit,
            axis: own.direction,
            is_contact: false,
        };
        let mut peaks: Vec<StressPeak> = hot.iter().map(of_spot).collect();
        let forces = own.iter().zip(&load.touches);
        let forces =
            forces.map(|(contact, touch)| SurfaceForce::new(boundary, touch.place, touch.impulse, contact.radius));
        let forces: Vec<SurfaceForce> = forces.collect();
        let around = ContactStress {
            sliding: tables.sliding(),
            poisson: constants.poisson,
            length: constants.characteristic_length_m() / prepared.frame.diagonal_m,
            ratio,
        };
        for (index, force) in forces.iter().enumerate() {
            let nearest = boundary.positions.iter().enumerate();
            let nearest = nearest.min_by(|a, b| (a.1 - force.place).norm().total_cmp(&(b.1 - force.place).norm()));
            let Some((node, _)) = nearest else { continue };
            peaks.push(StressPeak {
                node: boundary.nodes[node],
                stress_over_strength: around.largest(&forces, index) * unit,
                axis: force.normal,
                is_contact: true,
            });
        }
        Ok(peaks)
    }
}

/// Length over which stresses are averaged, local, and whether it is that of a lattice cell.
fn averaging_length(prepared: &PreparedObject, constants: &StrengthConstants, body: &Elasticity) -> (f64, bool) {
    let (own, cell) = (constants.characteristic_length_m() / prepared.frame.diagonal_m, body.spacing());
    (own.max(cell), own < cell)
}

/// The criterion by strength and energy for all struck bodies.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::pipeline) struct ObjectOnset {
    /// Onset of each struck body at the place where it breaks first.
    pub bodies: Vec<Onset>,
    /// Figures for the result.
    pub report: OnsetReport,
}

/// Figures of the criterion by strength and energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnsetReport {
    /// Largest averaged equivalent stress over the tensile strength.
    pub stress_over_strength: f64,
    /// Strain energy over that of the smallest section, of the body that breaks first.
    pub energy_over_section: f64,
    /// Area of that section, m²; 0 without one.
    pub section_m2: f64,
    /// Length over which stresses of the lattice are averaged, m.
    pub averaged_over_m: f64,
    /// True if that is the length of a cell of the elastic lattice, since the characteristic length is smaller.
    pub is_averaged_over_cell: bool,
}

impl ObjectOnset {
    /// Judges every struck body, of which no piece may be smaller than `volume_min` (local).
    pub fn new(
        RequestContext { prepared, request, .. }: RequestContext<'_>,
        energies: &[BodyEnergy],
        volume_min: f64,
    ) -> Result<Self, FractureError> {
        let constants = request.strength_constants(prepared);
        let mut bodies = Vec::with_capacity(energies.len());
        let (mut stress_over_strength, mut averaged, mut is_cell) = (0.0_f64, 0.0_f64, false);
        for energy in energies {
            let solid = prepared.solid(energy.body)?;
            let (length, cell) = averaging_length(prepared, &constants, &solid.elasticity);
            (averaged, is_cell) = (averaged.max(length), is_cell || cell);
            let largest = energy.peaks.iter().map(|peak| peak.stress_over_strength).fold(0.0, f64::max);
            stress_over_strength = stress_over_strength.max(largest);
            bodies.push(of_body((prepared, solid), energy, &constants, volume_min));
        }
        let first = bodies.iter().copied().reduce(|a, b| if b.load_factor() < a.load_factor() { b } else { a });
        let report = OnsetReport {
            stress_over_strength,
            energy_over_section: first.map_or(0.0, |onset| onset.energy_over_section),
            section_m2: first.map_or(0.0, |onset| onset.section_m2),
            averaged_over_m: averaged * prepared.frame.diagonal_m,
            is_averaged_over_cell: is_cell,
        };
        Ok(Self { bodies, report })
    }

    /// Multiplies all loads by `factor`.
    pub fn scale(&mut self, factor: f64) {
        let of_bodies = self.bodies.iter_mut().map(|own| (&mut own.stress_over_strength, &mut own.energy_over_section));
        let report = (&mut self.report.stress_over_strength, &mut self.report.energy_over_section);
        for (stress, energy) in of_bodies.chain(std::iter::once(report)) {
            *stress *= factor;
            *energy *= factor * factor;
        }
    }

    /// True if a body breaks.
    pub fn breaks(&self) -> bool {
        self.bodies.iter().any(Onset::breaks)
    }

    /// Factor on all loads at which the object just breaks.
    pub fn load_factor(&self) -> f64 {
        self.bodies.iter().map(Onset::load_factor).fold(f64::INFINITY, f64::min)
    }

    /// Largest numbers of sites of the bodies that they have the energy for: 1 for those that stay intact.
    ///
    /// `crack_share` of the energy may become new surface. The cracks of two pieces are taken for the smallest section,
    /// since the true area is known after the cut only.
    pub fn site_limits(&self, prepared: &PreparedObject, energies: &[BodyEnergy], crack_share: f64) -> Vec<u32> {
        let limit = |(onset, energy): (&Onset, &BodyEnergy)| {
            let body = &prepared.bodies[energy.body];
            let dimension = cell_dimension(&body.slenderness, body.volumes.iter().sum());
            let ratio = crack_share * onset.energy_over_section;
            if onset.breaks() { affordable_count(2, ratio, dimension) } else { 1 }
        };
        self.bodies.iter().zip(energies).map(limit).collect()
    }
}

/// Onset of one body at the peak where it breaks first.
fn of_body(
    (prepared, solid): (&PreparedObject, &ElasticModel),
    energy: &BodyEnergy,
    constants: &StrengthConstants,
    volume_min: f64,
) -> Onset {
    let square_m2 = prepared.frame.diagonal_m.powi(2);
    let mut sections = solid.strength_tables().sections(&solid.lattice);
    let mut at = |peak: &StressPeak| {
        let normals = if peak.is_contact { normals_across(peak.axis) } else { normals_around(peak.axis) };
        let section = sections.smallest(peak.node, &normals, volume_min);
        let section_m2 = section.map_or(0.0, |section| section.area * square_m2);
        let needed_j = constants.toughness_j_m2 * section_m2;
        let energy_over_section = if needed_j > 0.0 { energy.strain_j.unwrap_or(0.0) / needed_j } else { 0.0 };
        Onset { stress_over_strength: peak.stress_over_strength, energy_over_section, section_m2 }
    };
    let none = Onset { stress_over_strength: 0.0, energy_over_section: 0.0, section_m2: 0.0 };
    let peaks = energy.peaks.iter().filter(|peak| peak.stress_over_strength > 0.0);
    let (contacts, others): (Vec<&StressPeak>, Vec<&StressPeak>) = peaks.partition(|peak| peak.is_contact);
    // The largest stress counts at a place through which a crack leaves two pieces.
    let mut best = others.into_iter().map(&mut at).find(|onset| onset.section_m2 > 0.0).unwrap_or(none);
    for peak in contacts {
        // Whatever the section, a body breaks here under no lower load than one that reaches the strength.
        if peak.stress_over_strength.recip() < best.load_factor() {
            let own = at(peak);
            best = if own.load_factor() < best.load_factor() { own } else { best };
        }
    }
    best
}
