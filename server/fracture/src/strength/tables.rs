//! Tables of an elastic lattice for the criterion by strength and energy.

use super::average::{SurfaceAverage, node_normals};
use super::recovery::PatchRecovery;
use super::section::{SectionLattice, SectionSearch};
use super::sliding::SlidingStress;
use super::stress::equivalent_of;
use crate::elasticity::{Elasticity, ElasticityError, StrainComponents, tension_direction};
use crate::lattice::{Lattice, NodeStars};
use crate::memory::held;
use nalgebra::{Point3, Vector3};

/// Tables that follow from the lattice of a body alone, made on first use.
pub struct StrengthTables {
    recovery: PatchRecovery,
    normals: Vec<Vector3<f64>>,
    volumes: Vec<f64>,
    neighbors: Vec<[u32; 4]>,
    stars: NodeStars,
    sliding: SlidingStress,
}

/// Displacement of a body, in one of the forms in which the stages have it.
#[derive(Clone, Copy, Debug)]
pub enum Deformation<'a> {
    /// Displacement of the unknowns of the elements.
    Displacement(&'a [f64]),
    /// Strains at the nodes, six components each.
    NodeStrains {
        /// The strains. The part of `completion` in them is averaged over the tetrahedra around each node, which is too
        /// low at the surface.
        strains: &'a [f64],
        /// Displacement of linear elements, the factor of its averages in `strains`, and that of its strains recovered at
        /// the surface, which replace them.
        completion: Option<(&'a [f64], [f64; 2])>,
    },
}

/// Place of the largest averaged equivalent stress on a boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HotSpot {
    /// Node of the lattice.
    pub node: u32,
    /// Averaged equivalent stress there, for Young's modulus 1.
    pub stress: f64,
    /// Direction of the largest principal stress.
    pub direction: Vector3<f64>,
}

/// Part of a boundary around a contact, whose stress is not that of the lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactZone {
    /// Middle of the contact, on the boundary.
    pub place: Point3<f64>,
    /// Outer normal there.
    pub normal: Vector3<f64>,
    /// Radius of the zone.
    pub radius: f64,
}

impl ContactZone {
    /// True if a boundary node is in the zone. The other side of a wall, and what is at right angles, is not.
    fn contains(&self, position: &Point3<f64>, normal: &Vector3<f64>) -> bool {
        (position - self.place).norm() <= self.radius && normal.dot(&self.normal) > FACING
    }
}

/// Largest number of hot spots of a body. Later ones count where no section through the earlier ones leaves two pieces.
const SPOTS_MAX: usize = 3;

/// Smallest distance between hot spots, in radii of the averages.
const SPOT_RADII: f64 = 3.0;

/// Least cosine between the normals of a contact and of the nodes in its zone.
pub(super) const FACING: f64 = 0.1;

impl StrengthTables {
    /// The tables of `body` on `lattice`, the lattice that it was made of.
    pub fn new(body: &Elasticity, lattice: &Lattice) -> Self {
        let (stars, boundary) = (lattice.stars(), body.boundary());
        let recovery = PatchRecovery::new(lattice, boundary, &stars);
        let volumes = (0..lattice.tets.len()).map(|tet| lattice.tet_volume(tet)).collect();
        let (normals, neighbors, sliding) = (node_normals(boundary), lattice.neighbors(), SlidingStress::new());
        Self { recovery, normals, volumes, neighbors, stars, sliding }
    }

    /// Stresses under tangential forces of contacts.
    pub fn sliding(&self) -> &SlidingStress {
        &self.sliding
    }

    /// The boundary nodes with the largest averages of the equivalent stress over discs of `radius`, outside of all `zones`,
    /// in descending order. None if the zones cover the boundary.
    ///
    /// They are at least three radii apart. `ratio` is σ_t/σ_c.
    ///
    /// # Errors
    /// [`ElasticityError::OtherLattice`].
    pub fn hot_spots(
        &self,
        (body, lattice): (&Elasticity, &Lattice),
        deformation: Deformation<'_>,
        zones: &[ContactZone],
        (radius, ratio): (f64, f64),
    ) -> Result<Vec<HotSpot>, ElasticityError> {
        let boundary = body.boundary();
        let strains = self.boundary_strains((body, lattice), deformation)?;
        let values: Vec<f64> =
            strains.iter().map(|strain| equivalent_of(&body.principal_stresses(strain), ratio)).collect();
        let (mut spots, mut nodes): (Vec<HotSpot>, Vec<usize>) = (Vec::new(), Vec::new());
        while spots.len() < SPOTS_MAX {
            let counts = |node: usize| {
                let (position, normal) = (&boundary.positions[node], &self.normals[node]);
                let is_near = |other: &usize| (position - boundary.positions[*other]).norm() < SPOT_RADII * radius;
                !zones.iter().any(|zone| zone.contains(position, normal)) && !nodes.iter().any(is_near)
            };
            let average = SurfaceAverage::new(boundary, &self.normals, radius);
            let Some((node, stress)) = average.largest(&values, counts) else { break };
            nodes.push(node);
            let direction = tension_direction(&strains[node]);
            spots.push(HotSpot { node: boundary.nodes[node], stress, direction });
        }
        Ok(spots)
    }

    /// Strains at the boundary nodes.
    fn boundary_strains(
        &self,
        (body, lattice): (&Elasticity, &Lattice),
        deformation: Deformation<'_>,
    ) -> Result<Vec<StrainComponents>, ElasticityError> {
        let boundary = body.boundary();
        let of_nodes = |strains: &[f64]| {
            let at = |node: &u32| std::array::from_fn(|component| strains[6 * *node as usize + component]);
            boundary.nodes.iter().map(at).collect()
        };
        let displacement = match deformation {
            Deformation::NodeStrains { strains, completion } => {
                let mut strains: Vec<StrainComponents> = of_nodes(strains);
                if let Some((linear, factors)) = completion {
                    let surface = self.surface_strains((body, lattice), linear, factors)?;
                    strains
                        .iter_mut()
                        .flatten()
                        .zip(surface.iter().flatten())
                        .for_each(|(own, surface)| *own += surface);
                }
                return Ok(strains);
            }
            Deformation::Displacement(displacement) => displacement,
        };
        if let Some(strains) = body.corner_strains(displacement) {
            return Ok(of_nodes(&strains));
        }
        let mut strains = Vec::new();
        body.tet_strains(lattice, displacement, &mut strains)?;
        Ok((0..boundary.nodes.len()).map(|node| self.recovery.at(node, &strains)).collect())
    }

    /// Strains recovered at the boundary nodes from a displacement of linear elements, times the factor `surface`, less their
    /// averages over the tetrahedra around each node, times `inside`.
    fn surface_strains(
        &self,
        (body, lattice): (&Elasticity, &Lattice),
        linear: &[f64],
        [inside, surface]: [f64; 2],
    ) -> Result<Vec<StrainComponents>, ElasticityError> {
        let mut strains = Vec::new();
        body.tet_strains(lattice, linear, &mut strains)?;
        let added = |(index, node): (usize, &u32)| {
            let (recovered, star) = (self.recovery.at(index, &strains), self.stars.of(*node));
            let volume: f64 = star.iter().map(|tet| self.volumes[*tet as usize]).sum();
            std::array::from_fn(|component| {
                let of_tet = |tet: &u32| self.volumes[*tet as usize] * strains[*tet as usize][component];
                surface * recovered[component] - inside * star.iter().map(of_tet).sum::<f64>() / volume
            })
        };
        Ok(body.boundary().nodes.iter().enumerate().map(added).collect())
    }

    /// A search for sections of `lattice`, that of these tables.
    pub fn sections<'a>(&'a self, lattice: &'a Lattice) -> SectionSearch<'a> {
        let (volumes, neighbors, stars) = (&self.volumes, &self.neighbors, &self.stars);
        SectionSearch::new(SectionLattice { lattice, volumes, neighbors, stars })
    }

    /// Bytes of memory that they hold.
    pub fn bytes(&self) -> usize {
        let Self { recovery, normals, volumes, neighbors, stars, sliding } = self;
        recovery.bytes() + held(normals) + held(volumes) + held(neighbors) + stars.bytes() + sliding.bytes()
    }
}
