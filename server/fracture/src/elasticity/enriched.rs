//! Completion of reduced displacements with quadratic elements by one solve with linear elements.
//!
//! A basis misses what is local to a contact, which linear elements hold about as well as quadratic ones; they are too
//! stiff in bending, which the basis holds. With the residual r = f − K B q of the reduced displacement, z solves the
//! linear elements under the part of r on the functions of the nodes. The completed displacement is the best one in the
//! span of B and z, a Galerkin projection: B(q − α s) + α z, with s = B'K z and α = z'r / (z'K z − s's). Its energy is
//! ½|q|² + ½ α z'r, never below that of the basis and never above the true one.
//!
//! The products with z need the part of K B on the functions of the nodes alone, because z vanishes on those of edges,
//! and there the stiffness is that of the linear elements.
//!
//! Based on: R. E. Bank & R. K. Smith, *A posteriori error estimates based on hierarchical bases* (SIAM Journal on
//! Numerical Analysis 30, 1993): the residual, solved for in another space of functions, approximates the error. Its use
//! with a reduced basis is ours.

use super::residual::dot;
use super::row_products;
use super::{ElasticWorkspace, Elasticity, ElasticityError, ErrorEstimate, NodalLoad, ReducedBasis};
use crate::cancel_token::CancelToken;
use crate::memory::held;
use nalgebra::Vector3;

/// Energy of z outside the span of the basis, over that of z, below which it is rounding.
const ROUNDING: f64 = 1e-9;

/// Data of a basis of quadratic displacements that complete a displacement by a solve with linear elements.
#[derive(Clone, Debug, PartialEq)]
pub struct CompletionTables {
    /// KB on the functions of the nodes: one row of the rank per component of a node.
    pub forces: Vec<f32>,
    /// Model of the relative energy error of completed displacements, by their [`CompletedEnergy::gain`].
    pub estimate: ErrorEstimate,
}

impl CompletionTables {
    pub(super) fn bytes(&self) -> usize {
        held(&self.forces)
    }
}

/// Energy of a completed displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompletedEnergy {
    /// Elastic energy, ½ u'K u.
    pub energy: f64,
    /// Share of it that the completion added.
    pub gain: f64,
    /// Estimated relative error of the energy.
    pub error: f64,
    /// Factor α of the displacement of linear elements, which [`ElasticWorkspace::completion`] holds.
    pub share: f64,
}

impl CompletedEnergy {
    /// Factors of the displacement of linear elements: α, as a part of the completed one, and that of its strains at the
    /// surface.
    ///
    /// The completed displacement lacks the share `error` of the energy, since linear elements are too stiff. These strains
    /// count as if all of it were theirs, by the square root, and at most twice their energy, since the error is an estimate.
    pub fn shares(&self) -> [f64; 2] {
        let lacks = if self.gain > 0.0 { (self.error / self.gain).min(1.0) } else { 0.0 };
        [self.share, self.share * (1.0 + lacks).sqrt()]
    }
}

impl ReducedBasis {
    /// Completes the displacement under `load` from all its `coordinates`, by [`Self::project`].
    ///
    /// Writes strains at the nodes to `expanded`, as [`Self::expand`] does. `None`: the basis has no data for it.
    ///
    /// # Errors
    /// [`ElasticityError::Canceled`], those of [`Elasticity::factor`].
    pub fn complete(
        &self,
        body: &Elasticity,
        load: &mut NodalLoad,
        coordinates: &mut [f64],
        expanded: &mut Vec<f64>,
        workspace: &mut ElasticWorkspace,
        token: &CancelToken,
    ) -> Result<Option<CompletedEnergy>, ElasticityError> {
        let tables = self.quadratic.as_ref().and_then(|tables| tables.completion.as_ref());
        let Some(CompletionTables { forces, estimate }) = tables else { return Ok(None) };
        let (size, factor) = (body.size(), body.factor()?);
        body.balance(load);
        let mut residual = std::mem::take(&mut workspace.residual);
        row_products::products((self.rank, forces), coordinates, &mut residual, &mut workspace.narrow);
        residual.iter_mut().zip(&load.forces[..size]).for_each(|(own, force)| *own = force - *own);
        let mut linear = std::mem::take(&mut workspace.linear);
        linear.clone_from(&residual);
        body.back_substitute(factor, &mut linear, workspace);
        token.check()?;
        let image = &mut workspace.image;
        image.resize(size, 0.0);
        body.stiffness.multiply(&linear, image);
        let (work, square) = (dot(&linear, &residual), dot(&linear, image));
        let shared = &mut workspace.gathered;
        shared.clear();
        shared.resize(self.rank, 0.0);
        let nodes = linear.chunks_exact(3).map(Vector3::from_column_slice);
        self.gather_rows(forces, nodes.enumerate(), shared);
        let rest = square - dot(shared, shared);
        let share = if rest > ROUNDING * square { work / rest } else { 0.0 };
        let (before, added) = (Self::energy(coordinates), 0.5 * share * work);
        coordinates.iter_mut().zip(shared).for_each(|(own, shared)| *own -= share * *shared);
        self.expand(coordinates, expanded, workspace);
        body.add_node_strains(&linear, share, expanded, &mut workspace.strains);
        (workspace.residual, workspace.linear) = (residual, linear);
        let energy = before + added;
        let gain = if added > 0.0 { added / energy } else { 0.0 };
        Ok(Some(CompletedEnergy { energy, gain, error: estimate.error(gain), share }))
    }
}

impl Elasticity {
    /// Adds `factor` times the strains at the nodes of a `displacement` of linear elements to `strains`, six components
    /// each: the mean of those in the tetrahedra around, by volume.
    fn add_node_strains(&self, displacement: &[f64], factor: f64, strains: &mut [f64], sums: &mut Vec<f64>) {
        let Some(edges) = &self.edges else { return };
        sums.clear();
        sums.resize(strains.len(), 0.0);
        edges.add_linear_strains(&self.elements.blocks, displacement, sums);
        for (node, (own, sums)) in strains.chunks_exact_mut(6).zip(sums.chunks_exact(6)).enumerate() {
            // A node has a quarter of the volume of the tetrahedra around it.
            let scale = factor / (4.0 * self.inertia.mass(node));
            own.iter_mut().zip(sums).for_each(|(own, sum)| *own += scale * sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surface_strains_grow_by_the_energy_that_is_missing() {
        let shares = |gain, error| CompletedEnergy { energy: 1.0, gain, error, share: 2.0 }.shares();
        assert_eq!(shares(0.1, 0.0), [2.0, 2.0]);
        assert_eq!(shares(0.04, 0.0225), [2.0, 2.0 * 1.25]);
        // The estimate is no better than a factor of two, and without a gain there are no strains.
        assert_eq!(shares(1e-6, 0.01), [2.0, 2.0 * 2f64.sqrt()]);
        assert_eq!(shares(0.0, 0.01), [2.0, 2.0]);
    }
}
