//! One refined level of a body.

use crate::cancel_token::CancelToken;
use crate::elasticity::boundary::BoundaryNodes;
use crate::elasticity::element::{Element, Lame};
use crate::elasticity::inertia::Inertia;
use crate::elasticity::load::{check, spread};
use crate::elasticity::{ContactLoad, ElasticWorkspace, ElasticityError};
use crate::lattice::RefinedLattice;
use crate::sparse::SymmetricMatrix;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

/// Forces on nodes.
pub(super) type AppliedForces = Vec<(u32, Vector3<f64>)>;

/// Stiffness, boundary and inertia of a free body on a refined lattice.
pub(super) struct RefinedLevel {
    pub(super) refined: RefinedLattice,
    pub(super) stiffness: SymmetricMatrix<3>,
    /// Inverse of each diagonal block of the stiffness.
    pub(super) inverse_diagonal: Vec<Matrix3<f64>>,
    pub(super) boundary: BoundaryNodes,
    pub(super) inertia: Inertia,
}

impl RefinedLevel {
    pub(super) fn new(refined: RefinedLattice, lame: Lame, token: &CancelToken) -> Result<Self, ElasticityError> {
        let lattice = &refined.lattice;
        let element = |tet| Element::new(lattice, tet).ok_or(ElasticityError::DegenerateTet { tet });
        let elements: Vec<Element> = (0..lattice.tets.len()).into_par_iter().map(element).collect::<Result<_, _>>()?;
        token.check()?;
        let stiffness = SymmetricMatrix::assemble(lattice.nodes.len(), &lattice.tets, |tet, i, j| {
            elements[tet].stiffness(i, j, lame)
        })?;
        token.check()?;
        let inverse_diagonal = inverse_diagonal(&stiffness).ok_or(ElasticityError::EmptyLattice)?;
        let inertia = Inertia::new(lattice).ok_or(ElasticityError::EmptyLattice)?;
        let boundary = BoundaryNodes::new(lattice);
        Ok(Self { refined, stiffness, inverse_diagonal, boundary, inertia })
    }

    /// Nodal forces of `contacts`, whose radii are the effective ones, in equilibrium, and what they apply, by node.
    pub(super) fn load(
        &self,
        contacts: &[ContactLoad],
        workspace: &mut ElasticWorkspace,
    ) -> Result<(Vec<f64>, AppliedForces), ElasticityError> {
        let (mut forces, mut applied) = (vec![0.0; self.stiffness.size()], AppliedForces::new());
        for (index, contact) in contacts.iter().enumerate() {
            check(index, contact)?;
            let nearest = self.boundary.nearest(&contact.point).ok_or(ElasticityError::EmptyLattice)?;
            spread(&self.boundary, &nearest, contact.radius, workspace);
            applied.extend(workspace.patch.forces(contact.impulse));
        }
        for (node, force) in &applied {
            let own = &mut forces[3 * *node as usize..][..3];
            own.iter_mut().zip(force.iter()).for_each(|(own, force)| *own += force);
        }
        self.inertia.relieve(&mut forces);
        applied.sort_by_key(|(node, _)| *node);
        Ok((forces, applied))
    }

    /// The same load on the functions of the coarser level.
    pub(super) fn restricted(&self, forces: &[f64]) -> Vec<f64> {
        let (own, midpoints) = forces.split_at(forces.len() - 3 * self.refined.parents.len());
        let mut coarse = own.to_vec();
        for (ends, force) in self.refined.parents.iter().zip(midpoints.chunks_exact(3)) {
            for &end in ends {
                let sums = &mut coarse[3 * end as usize..][..3];
                sums.iter_mut().zip(force).for_each(|(sum, force)| *sum += 0.5 * force);
            }
        }
        coarse
    }
}

fn inverse_diagonal(stiffness: &SymmetricMatrix<3>) -> Option<Vec<Matrix3<f64>>> {
    let inverse = |node: usize| {
        let (columns, blocks) = stiffness.row(node);
        blocks[columns.binary_search(&(node as u32)).ok()?].try_inverse()
    };
    (0..stiffness.nodes()).map(inverse).collect()
}
