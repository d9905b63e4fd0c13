//! Labels, tessellation, fragments: cells become closed meshes that know their mass.

use super::cells::Division;
use super::{BodyEnergy, Counts, FragmentRow, OUTER, Prepared, RunRow, Stage, Strike, StrikeError, Watch};
use crate::fragment::{Properties, properties};
use crate::tessellation::{Components, FixedPoints, Points, Sites, Tessellation, Transform, Workspace};
use crate::token::Token;
use nalgebra::Point3;

/// The meshes of one body, whole or broken.
struct BodyPieces {
    body: usize,
    tessellation: Tessellation,
    properties: Vec<Properties>,
    centres: Vec<Point3<f64>>,
    energies_j_m2: Vec<f64>,
}

/// The meshes of all bodies, ready to be emitted: their size is known to the byte.
pub struct Pieces {
    bodies: Vec<BodyPieces>,
    transform: Transform,
    /// One row per fragment, by body, then by site, then by lowest node.
    pub fragments: Vec<FragmentRow>,
    /// One row per run; a fragment's rows follow each other.
    pub runs: Vec<RunRow>,
    /// Lengths of the bulk sections.
    pub counts: Counts,
}

impl Pieces {
    /// Cuts every body of `prepared`: those with cells along them, the others stay whole.
    pub(super) fn new(
        prepared: &Prepared,
        strike: &Strike,
        energies: &[BodyEnergy],
        division: &Division,
        token: &Token,
        watch: &mut dyn Watch,
    ) -> Result<Self, StrikeError> {
        let mut workspace = Workspace::default();
        let mut bodies = Vec::with_capacity(prepared.bodies.len());
        for (index, body) in prepared.bodies.iter().enumerate() {
            token.check()?;
            let cells = division.cells.iter().find(|cells| energies[cells.struck].body == index);
            watch.enter(Stage::Labels);
            let mut components = Components::default();
            let whole = vec![0; body.crack.nodes.len()];
            components.split(&body.topology, cells.map_or(&whole, |cells| &cells.diagram.labels));
            watch.leave(Stage::Labels, size_of_val(components.labels.as_slice()) as u64);
            watch.enter(Stage::Tessellation);
            let lift = prepared.lift(index, strike.lift)?;
            let of_fragment = &components.sites;
            let sites = cells.map(|cells| Sites { lift, coordinates: &cells.diagram.sites, of_fragment });
            let mut points = Points::default();
            points.find(&body.crack, &body.topology, &components.labels, sites, &FixedPoints::default())?;
            let mut tessellation = Tessellation::default();
            tessellation.build(&body.crack, &body.topology, &components.labels, &points, &mut workspace)?;
            watch.leave(Stage::Tessellation, size_of_val(tessellation.runs()) as u64);
            watch.enter(Stage::Fragments);
            let mut measured = Vec::new();
            properties(&tessellation, &mut measured);
            let energies_j_m2 = components
                .sites
                .iter()
                .map(|&site| match cells {
                    Some(cells) => {
                        let unit = energies[cells.struck].unit_j_m2(prepared.frame.diagonal_m);
                        unit * cells.diagram.cell_energy[site as usize]
                    }
                    None => 0.0,
                })
                .collect();
            let centres = measured.iter().map(|measured| measured.centre).collect();
            watch.leave(Stage::Fragments, size_of_val(measured.as_slice()) as u64);
            bodies.push(BodyPieces { body: index, tessellation, properties: measured, centres, energies_j_m2 });
        }
        let transform = Transform { metres_per_unit: prepared.frame.diagonal_m };
        let mut pieces = Self { bodies, transform, fragments: Vec::new(), runs: Vec::new(), counts: Counts::default() };
        pieces.lay_out(prepared);
        Ok(pieces)
    }

    /// Fills the tables; offsets continue from body to body.
    fn lay_out(&mut self, prepared: &Prepared) {
        let density = prepared.parameters.material.density_kg_m3;
        let metre = prepared.frame.diagonal_m;
        for pieces in &self.bodies {
            let base = self.counts;
            let (first_fragment, first_run) = (self.fragments.len() as u32, self.runs.len() as u32);
            for (local, fragment) in pieces.tessellation.fragments().iter().enumerate() {
                let measured = &pieces.properties[local];
                let volume_m3 = measured.volume * metre.powi(3);
                let inertia = measured.inertia * (density * metre.powi(5));
                self.fragments.push(FragmentRow {
                    id: first_fragment + local as u32,
                    body: pieces.body as u32,
                    vertex_first: (base.vertices + fragment.vertices.start) as u32,
                    vertex_count: fragment.vertices.len() as u32,
                    index_first: (base.indices + 3 * fragment.triangles.start) as u32,
                    index_count: 3 * fragment.triangles.len() as u32,
                    run_first: first_run + fragment.runs.start as u32,
                    run_count: fragment.runs.len() as u32,
                    merge_first: (base.merges + fragment.merges.start) as u32,
                    merge_count: fragment.merges.len() as u32,
                    volume_m3,
                    mass_kg: volume_m3 * density,
                    centre_m: prepared.frame.to_metres(&measured.centre).coords.into(),
                    inertia_kg_m2: [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|entry| inertia[entry]),
                    energy_j_m2: pieces.energies_j_m2[local],
                });
            }
            self.runs.extend(pieces.tessellation.runs().iter().map(|run| RunRow {
                fragment: first_fragment + run.fragment,
                neighbour: run.neighbour.map_or(OUTER, |neighbour| first_fragment + neighbour),
                vertex_first: (base.vertices + run.vertices.start) as u32,
                vertex_count: run.vertices.len() as u32,
                index_first: (base.indices + 3 * run.triangles.start) as u32,
                index_count: 3 * run.triangles.len() as u32,
            }));
            self.counts.vertices += pieces.tessellation.vertex_count();
            self.counts.indices += pieces.tessellation.index_count();
            self.counts.merges += pieces.tessellation.merge_count();
        }
    }

    /// Writes positions (relative to each fragment's centre of mass, m), indices and merge pairs (both relative to the
    /// fragment's first vertex) into the caller's memory; lengths exactly [`Self::counts`], or nothing is written.
    pub fn emit(
        &self,
        positions: &mut [[f32; 3]],
        indices: &mut [u32],
        merges: &mut [[u32; 2]],
    ) -> Result<(), StrikeError> {
        let given = Counts { vertices: positions.len(), indices: indices.len(), merges: merges.len() };
        if given != self.counts {
            return Err(StrikeError::SectionLengths { given, needed: self.counts });
        }
        let (mut positions, mut indices, mut merges) = (positions, indices, merges);
        for pieces in &self.bodies {
            let tessellation = &pieces.tessellation;
            let (own_positions, other_positions) = positions.split_at_mut(tessellation.vertex_count());
            let (own_indices, other_indices) = indices.split_at_mut(tessellation.index_count());
            let (own_merges, other_merges) = merges.split_at_mut(tessellation.merge_count());
            tessellation.emit(&pieces.centres, self.transform, own_positions, own_indices, own_merges)?;
            (positions, indices, merges) = (other_positions, other_indices, other_merges);
        }
        Ok(())
    }
}
