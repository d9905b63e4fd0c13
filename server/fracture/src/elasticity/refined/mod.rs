//! Bodies on uniformly refined lattices, to see the error of the discretization.
//!
//! The refined lattices have the shape of the coarse one ([`refinements`]), so energies on them differ by the
//! discretization alone. The same load acts on all levels: that of the finest one, whose contacts have the effective radius of the
//! coarse one, restricted to the functions of the coarser ones. Elements are linear or quadratic, and the body is free.
//!
//! Fine levels are never factored: conjugate gradients with a V-cycle over all coarser levels as a preconditioner need
//! tens of steps on any of them. On each level the cycle does a forward Gauss-Seidel sweep before and a backward one
//! after the correction of the coarser level, so it is symmetric. The coarsest level is solved by its factor. All
//! sweeps and sums have a fixed order.
//!
//! Based on: W. L. Briggs, V. E. Henson & S. F. McCormick, *A Multigrid Tutorial* (2000), chapter 3; O. Tatebe, *The
//! multigrid preconditioned conjugate gradient method* (1993).

mod conjugate_gradients;
mod cycle;
mod level;
mod quadratic;
#[cfg(test)]
mod quadratic_tests;
#[cfg(test)]
mod tests;

use super::element::{Element, Lame};
use super::inertia::Inertia;
use super::{
    BoundaryNodes, ContactLoad, DrivingEnergy, ElasticWorkspace, Elasticity, ElasticityError, ElementOrder, NodalLoad,
};
use crate::cancel_token::CancelToken;
use crate::lattice::{CHILD_COUNT, Lattice, refinements};
use crate::simd::SimdLanes;
use conjugate_gradients::Stiffness;
use cycle::{Cycle, NodeRow, WIDTH, ZERO};
use level::RefinedLevel;
use quadratic::QuadraticLevel;
use rayon::prelude::*;

/// A free body and its refinements. Level 0 is the lattice that it was made of.
pub struct RefinedBody {
    lattice: Lattice,
    lame: Lame,
    coarse: Elasticity,
    levels: Vec<RefinedLevel>,
    /// Quadratic elements of all levels, the coarsest included; empty: the elements are linear.
    quadratic: Vec<QuadraticLevel>,
    /// Share of the energy that the last steps of a solve may add.
    accuracy: f64,
}

/// Strain energy of one load on one level, in the units of [`Elasticity`].
#[derive(Clone, Debug, PartialEq)]
pub struct RefinedEnergy {
    /// Energy of the body, ½ f·u.
    pub energy: f64,
    /// Energy in each tetrahedron of level 0; the sum is that of the body.
    pub tets: Vec<f64>,
    /// Number of steps of conjugate gradients; 0 on level 0 with linear elements.
    pub steps: usize,
}

/// Forces of load number k: three per node of the level, then three per edge if elements are quadratic, in equilibrium.
pub type Forces<'a> = dyn Fn(usize, &mut ElasticWorkspace) -> Result<Vec<f64>, ElasticityError> + Sync + 'a;

impl RefinedBody {
    /// Refines `lattice` `count` times, and assembles and factors as [`Elasticity::prepare`] does.
    ///
    /// # Errors
    /// Those of [`Elasticity::prepare`].
    pub fn new(lattice: &Lattice, poisson: f64, count: usize, token: &CancelToken) -> Result<Self, ElasticityError> {
        let coarse = Elasticity::prepare(lattice, poisson, token)?;
        let lame = Lame::new(poisson);
        let level = |refined| RefinedLevel::new(refined, lame, token);
        let levels = refinements(lattice, count).into_iter().map(level).collect::<Result<_, _>>()?;
        Ok(Self {
            lattice: lattice.clone(),
            lame,
            coarse,
            levels,
            quadratic: Vec::new(),
            accuracy: conjugate_gradients::ACCURACY,
        })
    }

    /// The same body with elements of this order on all levels.
    ///
    /// # Errors
    /// [`ElasticityError::DegenerateTet`].
    pub fn of_order(self, order: ElementOrder) -> Result<Self, ElasticityError> {
        let made = |level| QuadraticLevel::new(self.lattice(level), self.lame, self.surface(level).1);
        let (quadratic, accuracy) = match order {
            ElementOrder::Linear => (Vec::new(), conjugate_gradients::ACCURACY),
            ElementOrder::Quadratic => {
                ((0..=self.count()).map(made).collect::<Result<_, _>>()?, conjugate_gradients::ACCURACY_QUADRATIC)
            }
        };
        Ok(Self { quadratic, accuracy, ..self })
    }

    /// The same body whose solves miss at most this share of an energy.
    #[must_use]
    pub fn with_accuracy(self, accuracy: f64) -> Self {
        Self { accuracy, ..self }
    }

    /// Boundary and inertia of a level.
    fn surface(&self, level: usize) -> (&BoundaryNodes, &Inertia) {
        match level.checked_sub(1) {
            Some(below) => (&self.levels[below].boundary, &self.levels[below].inertia),
            None => (&self.coarse.boundary, &self.coarse.inertia),
        }
    }

    /// Number of refinements.
    pub fn count(&self) -> usize {
        self.levels.len()
    }

    /// Lattice of a level.
    ///
    /// # Panics
    /// If there is no such level.
    pub fn lattice(&self, level: usize) -> &Lattice {
        level.checked_sub(1).map_or(&self.lattice, |below| &self.levels[below].refined.lattice)
    }

    /// Number of scalar unknowns of a level: three per node, and per edge if elements are quadratic.
    ///
    /// # Panics
    /// If there is no such level.
    pub fn unknowns(&self, level: usize) -> usize {
        3 * self.quadratic.get(level).map_or_else(|| self.lattice(level).nodes.len(), QuadraticLevel::rows)
    }

    /// Share of an energy that a solve misses at most, apart from the error of the discretization.
    pub fn accuracy(&self) -> f64 {
        self.accuracy
    }

    /// Energies under impacts of these contacts on a level. The radii of contacts are the effective ones on all levels.
    ///
    /// The load is that of the finest level on all of them, so that the energies grow with the level.
    ///
    /// # Errors
    /// [`ElasticityError`] of a contact, or of a solve.
    ///
    /// # Panics
    /// If there is no such level.
    pub fn impact_energies(
        &self,
        level: usize,
        impacts: &[Vec<ContactLoad>],
        token: &CancelToken,
    ) -> Result<Vec<RefinedEnergy>, ElasticityError> {
        let forces = |index: usize, workspace: &mut ElasticWorkspace| {
            let finest = self.load(self.count(), &impacts[index], workspace)?;
            Ok((level..self.count()).rev().fold(finest, |forces, below| self.restricted(below, &forces)))
        };
        self.energies(level, impacts.len(), &forces, token)
    }

    /// Estimated errors of the energies of impacts that stem from the load, which the finest level resolves as well as its
    /// boundary allows.
    ///
    /// Loads converge with the square of the spacing. So a third of what the load of the level below the finest changes
    /// there is the error of the finest one. `below` are the results of [`Self::impact_energies`] on that level.
    ///
    /// # Errors
    /// Those of [`Self::impact_energies`].
    pub fn load_errors(
        &self,
        impacts: &[Vec<ContactLoad>],
        below: &[RefinedEnergy],
        token: &CancelToken,
    ) -> Result<Vec<f64>, ElasticityError> {
        let Some(level) = self.count().checked_sub(1) else { return Ok(vec![f64::INFINITY; impacts.len()]) };
        let forces = |index: usize, workspace: &mut ElasticWorkspace| self.load(level, &impacts[index], workspace);
        let own = self.energies(level, impacts.len(), &forces, token)?;
        Ok(own.iter().zip(below).map(|(own, below)| (own.energy - below.energy).abs() / 3.0).collect())
    }

    /// Forces of contacts on a level, as its own boundary resolves them.
    fn load(
        &self,
        level: usize,
        contacts: &[ContactLoad],
        workspace: &mut ElasticWorkspace,
    ) -> Result<Vec<f64>, ElasticityError> {
        let (mut forces, applied) = match level.checked_sub(1) {
            Some(below) => self.levels[below].load(contacts, workspace)?,
            None => {
                let mut load = NodalLoad::default();
                self.coarse.load(contacts, &mut load, workspace)?;
                (load.forces, load.applied)
            }
        };
        if let Some(own) = self.quadratic.get(level) {
            own.extend(&mut forces, &applied, self.surface(level));
        }
        Ok(forces)
    }

    /// The load `forces` of the level above `level`, on the functions of `level`.
    fn restricted(&self, level: usize, forces: &[f64]) -> Vec<f64> {
        let linear = &self.levels[level];
        match &self.quadratic[..] {
            [] => linear.restricted(forces),
            all => all[level].restricted(linear, &all[level + 1], forces),
        }
    }

    /// Energies of `count` loads on a level.
    ///
    /// # Errors
    /// [`ElasticityError::Residual`] for forces out of equilibrium, [`ElasticityError::Canceled`], those of `forces`.
    ///
    /// # Panics
    /// If there is no such level, or forces do not fit it.
    pub fn energies(
        &self,
        level: usize,
        count: usize,
        forces: &Forces<'_>,
        token: &CancelToken,
    ) -> Result<Vec<RefinedEnergy>, ElasticityError> {
        if level == 0 && self.quadratic.is_empty() {
            return (0..count).map(|index| self.coarse_energy(index, forces, token)).collect();
        }
        let firsts: Vec<usize> = (0..count).step_by(WIDTH).collect();
        let groups: Vec<Vec<RefinedEnergy>> = firsts
            .into_par_iter()
            .map(|first| self.group(level, first..count.min(first + WIDTH), forces, token))
            .collect::<Result<_, _>>()?;
        Ok(groups.into_iter().flatten().collect())
    }

    fn coarse_energy(
        &self,
        index: usize,
        forces: &Forces<'_>,
        token: &CancelToken,
    ) -> Result<RefinedEnergy, ElasticityError> {
        let (mut workspace, mut displacement, mut tets) = (ElasticWorkspace::default(), Vec::new(), Vec::new());
        let forces = forces(index, &mut workspace)?;
        self.coarse.solve(&forces, &mut displacement, &mut workspace, token)?;
        self.coarse.tet_energy(&self.lattice, &displacement, DrivingEnergy::Total, &mut tets, token)?;
        Ok(RefinedEnergy { energy: self.coarse.elastic_energy(&forces, &displacement), tets, steps: 0 })
    }

    /// Energies of the loads `range`, at most [`WIDTH`].
    fn group(
        &self,
        level: usize,
        range: std::ops::Range<usize>,
        forces: &Forces<'_>,
        token: &CancelToken,
    ) -> Result<Vec<RefinedEnergy>, ElasticityError> {
        let mut workspace = ElasticWorkspace::default();
        let mut rows = vec![ZERO; self.unknowns(level) / 3];
        for (lane, index) in range.clone().enumerate() {
            let own = forces(index, &mut workspace)?;
            assert_eq!(own.len(), 3 * rows.len(), "forces fit the level");
            for (row, own) in rows.iter_mut().zip(own.chunks_exact(3)) {
                row.iter_mut().zip(own).for_each(|(lanes, own)| lanes.0[lane] = *own);
            }
        }
        let levels = &self.levels[..level];
        let mut cycle = Cycle::new(&self.coarse, self.coarse.factor()?, levels);
        let stiffness = match self.quadratic.get(level) {
            Some(own) => Stiffness::Quadratic(own),
            None => Stiffness::Linear(&self.levels[level - 1]),
        };
        let found = conjugate_gradients::solve(stiffness, &mut cycle, (rows, self.accuracy), token)?;
        let capacity = self.lattice.tets.len();
        let own = |lane: usize| RefinedEnergy {
            energy: found.energies[lane],
            tets: Vec::with_capacity(capacity),
            steps: found.steps,
        };
        let mut all: Vec<RefinedEnergy> = (0..range.len()).map(own).collect();
        for tet in 0..self.lattice.tets.len() {
            let energies = self.tet_energy(level, tet, &found.displacement);
            all.iter_mut().zip(energies.0).for_each(|(own, energy)| own.tets.push(energy));
        }
        Ok(all)
    }

    /// Energies of tetrahedron `tet` of level 0: the sums of those of its descendants.
    fn tet_energy(&self, level: usize, tet: usize, displacement: &[NodeRow]) -> SimdLanes<WIDTH> {
        let (lattice, count) = (self.lattice(level), CHILD_COUNT.pow(level as u32));
        let children = count * tet..count * (tet + 1);
        if let Some(own) = self.quadratic.get(level) {
            return own.energy(children, displacement);
        }
        let mut sum = SimdLanes::all(0.0);
        for child in children {
            let Some(element) = Element::new(lattice, child) else { continue };
            let mut gradient = [[SimdLanes::all(0.0); 3]; 3];
            for (node, own) in lattice.tets[child].iter().zip(&element.gradients) {
                for (row, u) in gradient.iter_mut().zip(&displacement[*node as usize]) {
                    row.iter_mut().zip(own.iter()).for_each(|(entry, g)| *entry = *entry + *u * *g);
                }
            }
            let sheared = |i: usize, j: usize| (gradient[i][j] + gradient[j][i]) * 0.5;
            let strain = [gradient[0][0], gradient[1][1], gradient[2][2], sheared(0, 1), sheared(1, 2), sheared(0, 2)];
            sum = sum + self.lame.energy_densities(&strain) * element.volume;
        }
        sum
    }
}
