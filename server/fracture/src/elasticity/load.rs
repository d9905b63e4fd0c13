//! Nodal forces of contacts.

use super::load_patch::BELL_RADII;
use super::near_field::{HalfSpace, NearContact, effective_radius, half_space_share};
use super::{
    BoundaryNodes, ElasticWorkspace, Elasticity, ElasticityError, NearestBoundaryPoint, Support, SurfaceFaces,
};
use nalgebra::{Point3, Vector3};

/// Smallest radius of a load on the lattice, in spacings (mean edge length). Energies of smaller contacts come from the near
/// field (module `near_field`).
///
/// A narrower bell lies between the nodes, and its energy depends on the lattice instead of the body. Measured error of
/// the energy of one contact on a block, against a lattice three times as fine, over five places between the nodes: up
/// to 43 % at 0.5 spacings, 8 % at 0.75, 2.5 % at 1, 1 % at 1.25.
pub const RADIUS_SPACINGS_MIN: f64 = 1.0;

/// Largest distance, in contact radii, to the corners of the face that a contact touches. All of them carry weight.
const CORNER_RADII: f64 = 2.0;

/// Contact of an impact.
///
/// Its peak force is spread over the boundary with weight area · (exp(−ρ²/2r²) − exp(−9/2)), ρ ≤ 3r. ρ is measured
/// along the boundary from the boundary point nearest to `point`. A point deep inside that is equally near to several
/// parts of the boundary touches one of them. Faces more than a right angle off the mean normal of that part carry less,
/// and from 120° on nothing, as the other side of a thin wall.
///
/// The forces have the line of one force through that boundary point: where the weights are off it, as near edges, a
/// couple is added, Σ f_i = F and Σ (x_i − p) × f_i = 0 (equations and source: module `load_patch`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLoad {
    /// Position, local; at most `radius` away from the boundary.
    pub point: Point3<f64>,
    /// Direction and relative magnitude of the peak force.
    pub impulse: Vector3<f64>,
    /// Contact radius r, local, positive.
    pub radius: f64,
}

/// Contact as it was applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AppliedContact {
    /// Boundary point nearest to the contact, local.
    pub place: Point3<f64>,
    /// Distance from the contact to that point, local.
    pub distance: f64,
    /// Effective radius, local: that whose energy is computed.
    ///
    /// It is the requested radius where the body near the contact is a half-space. Near edges and on thin walls it is at
    /// least a part of [`Self::spread`], up to the whole.
    pub radius: f64,
    /// Radius of the load on the lattice, local.
    ///
    /// It is the largest of the requested radius, [`RADIUS_SPACINGS_MIN`] spacings, the distance to the nearest corner
    /// of the touched face, and half that to the farthest.
    pub spread: f64,
    /// Mean outer normal of the loaded part of the boundary, a continuous function of the place; zero without one.
    pub normal: Vector3<f64>,
    /// Direction and relative magnitude of its force.
    pub impulse: Vector3<f64>,
}

/// Nodal forces of an impact.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodalLoad {
    /// As many as [`Elasticity::unknowns`], in equilibrium if the body is free. Empty until [`Elasticity::balance`].
    pub forces: Vec<f64>,
    /// Applied contacts, one per contact of the impact.
    pub touches: Vec<AppliedContact>,
    /// Forces that the contacts apply: (node, force), ordered by node.
    pub applied: Vec<(u32, Vector3<f64>)>,
    /// Energy of the near field, which the lattice does not have: (boundary node, energy), not negative.
    pub near: Vec<(u32, f64)>,
    /// Acceleration, linear and angular, whose inertial forces are subtracted: of a free body its own, of an anchored body
    /// with weight the opposite of gravity, else zero.
    pub acceleration: [Vector3<f64>; 2],
}

impl NodalLoad {
    /// Energy of the near field, which adds to that of the lattice.
    pub fn near_energy(&self) -> f64 {
        self.near.iter().map(|(_, energy)| energy).sum()
    }
}

impl Elasticity {
    /// Writes the nodal forces of all `contacts` together to `load`.
    ///
    /// For a free body these include the inertial forces of the rigid acceleration that the contacts cause, so net
    /// force and torque vanish to rounding.
    ///
    /// # Errors
    /// [`ElasticityError::NoContacts`], [`ElasticityError::NonFinitePoint`], [`ElasticityError::NonFiniteImpulse`],
    /// [`ElasticityError::ZeroImpulse`], [`ElasticityError::RadiusOutOfRange`], [`ElasticityError::TooFar`]; `load` is
    /// then of no use.
    pub fn load(
        &self,
        contacts: &[ContactLoad],
        load: &mut NodalLoad,
        workspace: &mut ElasticWorkspace,
    ) -> Result<(), ElasticityError> {
        self.touch(contacts, 0.0, load, workspace)?;
        self.balance(load);
        Ok(())
    }

    /// As [`Self::load`], but without the nodal forces.
    ///
    /// A reduced displacement does not need them; [`Self::balance`] adds them for a solve. Loads of contacts in a half-space
    /// get at least the radius `spread_min`: their near field has the rest.
    ///
    /// # Errors
    /// Those of [`Self::load`].
    pub fn touch(
        &self,
        contacts: &[ContactLoad],
        spread_min: f64,
        load: &mut NodalLoad,
        workspace: &mut ElasticWorkspace,
    ) -> Result<(), ElasticityError> {
        contacts.iter().enumerate().try_for_each(|(index, contact)| check(index, contact))?;
        self.touch_checked(contacts, spread_min, load, workspace)
    }

    /// As [`Self::touch`], for contacts that it accepts with other impulses, which may be zero.
    ///
    /// # Errors
    /// Those of [`Self::touch`] except for impulses.
    pub fn touch_checked(
        &self,
        contacts: &[ContactLoad],
        spread_min: f64,
        load: &mut NodalLoad,
        workspace: &mut ElasticWorkspace,
    ) -> Result<(), ElasticityError> {
        if contacts.is_empty() {
            return Err(ElasticityError::NoContacts);
        }
        load.forces.clear();
        load.touches.clear();
        load.applied.clear();
        load.near.clear();
        workspace.near.clear();
        load.acceleration = [Vector3::zeros(); 2];
        for (index, contact) in contacts.iter().enumerate() {
            let touch = self.reach(index, contact, spread_min, workspace)?;
            load.applied.extend(workspace.patch.forces(contact.impulse));
            load.touches.push(touch);
            let first = load.near.len();
            if touch.radius < touch.spread {
                load.near.extend(workspace.patch.shares());
            }
            workspace.near.push(NearContact {
                place: touch.place,
                normal: workspace.patch.normal,
                force: contact.impulse,
                radii: [touch.radius, touch.spread],
                shares: first..load.near.len(),
            });
        }
        self.near_energies(load, workspace);
        // Sorted by node, so that opposite forces cancel exactly.
        load.applied.sort_by_key(|(node, _)| *node);
        load.applied.dedup_by(|next, own| {
            let same = next.0 == own.0;
            own.1 += if same { next.1 } else { Vector3::zeros() };
            same
        });
        if let Support::Free(_) = self.support {
            load.acceleration = self.inertia.acceleration_of(&load.applied);
        }
        Ok(())
    }

    /// Turns the shares of the near field into energies.
    fn near_energies(&self, load: &mut NodalLoad, workspace: &mut ElasticWorkspace) {
        if load.near.is_empty() {
            return;
        }
        let ElasticWorkspace { near, works, .. } = workspace;
        HalfSpace { poisson: self.lame.poisson() }.works(near, works);
        let whole: f64 = works.iter().sum();
        let gains = near
            .iter()
            .zip(works.iter())
            .filter(|own| !own.0.shares.is_empty())
            .map(|(own, work)| (own, work.max(0.0)));
        let gained: f64 = gains.clone().map(|(_, work)| work).sum();
        // Contacts on which the others do negative work take no energy, and neither does a whole that shrinks.
        let factor = if gained > 0.0 { whole.max(0.0) / gained } else { 0.0 };
        for (own, work) in gains {
            load.near[own.shares.clone()].iter_mut().for_each(|(_, energy)| *energy *= work * factor);
        }
    }

    /// Writes the nodal forces of the applied contacts, unless they are already present.
    pub fn balance(&self, load: &mut NodalLoad) {
        if !load.forces.is_empty() {
            return;
        }
        load.forces.resize(self.size(), 0.0);
        for (node, force) in &load.applied {
            let own = &mut load.forces[3 * *node as usize..][..3];
            own.iter_mut().zip(force.iter()).for_each(|(own, force)| *own += force);
        }
        match self.support {
            Support::Free(_) => self.inertia.balance(&load.acceleration, &mut load.forces),
            Support::Anchored(_) => self.inertia.subtract_from(&mut load.forces, &load.acceleration),
        }
        let Some(edges) = &self.edges else { return };
        let nodes = load.forces.len();
        load.forces.resize(self.unknowns(), 0.0);
        edges.add_applied(&self.boundary, &load.applied, &mut load.forces[nodes..]);
        edges.subtract_inertia(&load.acceleration, &mut load.forces[nodes..]);
    }

    /// Load of the weight of the body of unit density under the acceleration `gravity`.
    pub fn weight_load(&self, gravity: &Vector3<f64>) -> NodalLoad {
        let acceleration = [-gravity, Vector3::zeros()];
        NodalLoad { forces: self.weight(gravity), acceleration, ..NodalLoad::default() }
    }

    /// Subtracts from `forces` (length [`Self::unknowns`]) the inertial forces of the rigid acceleration that they cause.
    ///
    /// # Panics
    /// If the length does not fit the body.
    pub fn relieve(&self, forces: &mut [f64]) {
        assert_eq!(forces.len(), self.unknowns(), "forces fits the elements");
        let (nodes, edge_part) = forces.split_at_mut(self.size());
        let acceleration = self.inertia.acceleration(self.inertia.net(nodes));
        self.inertia.balance(&acceleration, nodes);
        if let Some(edges) = &self.edges {
            edges.subtract_inertia(&acceleration, edge_part);
        }
    }

    /// Distance from `point` to the boundary, local, inside or outside. It selects the body that a contact belongs to.
    pub fn distance(&self, point: &Point3<f64>) -> f64 {
        self.boundary.nearest(point).map_or(f64::INFINITY, |nearest| nearest.distance)
    }

    /// Finds the boundary point that `contact` touches, and fills the workspace's patch with the nodes that it loads.
    fn reach(
        &self,
        index: usize,
        contact: &ContactLoad,
        spread_min: f64,
        workspace: &mut ElasticWorkspace,
    ) -> Result<AppliedContact, ElasticityError> {
        let nearest = self.boundary.nearest(&contact.point).ok_or(ElasticityError::EmptyLattice)?;
        if nearest.distance > contact.radius {
            let (distance, radius) = (nearest.distance, contact.radius);
            return Err(ElasticityError::TooFar { contact: index, distance, radius });
        }
        // On imported lattices a face may be larger than the spacing. One of its corners must carry the load, and all must
        // have a share, because three nodes that are not in line keep the line of the force.
        let corners = self.boundary.corners(nearest.face).map(|corner| (corner - nearest.place).norm());
        let [near, far] =
            [corners.iter().fold(f64::INFINITY, |a, b| a.min(*b)), corners.iter().fold(0.0, |a, b| b.max(a))];
        let least = contact.radius.max(RADIUS_SPACINGS_MIN * self.spacing).max(near).max(far / CORNER_RADII);
        let mut wide = least.max(spread_min);
        let mut share = self.spread(&nearest, contact.radius, wide, workspace);
        if wide > least && share < 1.0 {
            wide = least;
            share = self.spread(&nearest, contact.radius, wide, workspace);
        }
        let radius = effective_radius(contact.radius, wide, share);
        let (place, distance, impulse) = (nearest.place, nearest.distance, contact.impulse);
        Ok(AppliedContact { place, distance, radius, spread: wide, normal: workspace.patch.normal, impulse })
    }

    /// Fills the workspace's patch, and returns the share to which the body there is a half-space; 1 for a contact as wide as
    /// its load.
    fn spread(&self, nearest: &NearestBoundaryPoint, asked: f64, wide: f64, workspace: &mut ElasticWorkspace) -> f64 {
        spread(&self.boundary, nearest, wide, workspace);
        if asked < wide { half_space_share(&self.boundary, nearest, &workspace.patch, wide) } else { 1.0 }
    }
}

/// Fills the workspace's patch with the nodes that a contact of effective radius `radius` at a boundary point loads.
pub(super) fn spread(
    boundary: &BoundaryNodes,
    nearest: &NearestBoundaryPoint,
    radius: f64,
    workspace: &mut ElasticWorkspace,
) {
    let reached = workspace.front.run(boundary, nearest, BELL_RADII * radius);
    workspace.patch.fill(boundary, nearest.place, radius, reached);
}

/// Rejects a contact with numbers that no load can be made of.
pub(super) fn check(index: usize, contact: &ContactLoad) -> Result<(), ElasticityError> {
    if !contact.point.iter().all(|x| x.is_finite()) {
        return Err(ElasticityError::NonFinitePoint { contact: index });
    }
    if !contact.impulse.iter().all(|j| j.is_finite()) {
        return Err(ElasticityError::NonFiniteImpulse { contact: index });
    }
    if contact.impulse == Vector3::zeros() {
        return Err(ElasticityError::ZeroImpulse { contact: index });
    }
    if !(contact.radius > 0.0 && contact.radius.is_finite()) {
        return Err(ElasticityError::RadiusOutOfRange { contact: index, radius: contact.radius });
    }
    Ok(())
}
