//! Settings of the tessellation: spacing of the crack lattice, and node labels or the exact diagram. All use the same sites.

use super::settings::Bench;
use super::subject::{rebaked, timed};
use super::truth::{Truth, Truths};
use super::{Measure, PointErrors, PointTimes, StudyError};
use rayon::prelude::*;
use serde_json::json;
use shatter_fracture::accuracy::{
    ExactCells, LabelErrors, Regions, carried, crack_distance, exact, label_fraction, misplaced, nearest, volume_l1,
};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::centroidal::{DiagramWorkspace, EnergyField, assign};
use shatter_fracture::database::Tables;
use shatter_fracture::lattice::{EnergyTransfer, LatticePoint};
use shatter_fracture::lift::{LiftKind, LiftedLattice};
use shatter_fracture::pipeline::{PreparedBody, PreparedObject};
use std::time::Instant;

/// Number of values of the setting `tessellation`.
pub(super) const MODES: usize = 2;

/// Errors of one crack lattice: against the finest one, and of the labels alone.
pub(super) struct CrackErrors {
    pub finest: PointErrors,
    pub own: PointErrors,
}

impl Bench<'_> {
    /// Spacings of the crack lattice, and for each the node labels against the exact diagram on it.
    pub(super) fn crack_spacings(&mut self) {
        for nodes in self.plan.crack.clone() {
            let spacing = self.base.parameters.crack_spacing * nodes.powf(-1.0 / 3.0);
            let mut alone = None;
            self.point("crack_spacing", json!(spacing), |bench| {
                let (times, pair) = bench.crack_spacing(spacing)?;
                alone = Some((times.clone(), pair.own));
                Ok((times, pair.finest))
            });
            if let Some((times, errors)) = alone {
                let (setting, value) = ("node_labels", json!(spacing));
                self.findings.points.push(super::StudyPoint { setting, value, preset: None, times, errors });
            }
        }
    }

    fn crack_spacing(&mut self, spacing: f64) -> Result<(PointTimes, CrackErrors), StudyError> {
        // The object lends its elasticity, since none is computed on a coarser lattice.
        let tables = Tables { interior: true, ..Tables::NONE };
        let elastic = self.base.parameters.elastic_spacing.max(spacing);
        let mut other = rebaked(self.plan, &self.base, elastic, spacing, tables)?;
        lend(&mut self.base, &mut other);
        let found = timed(&other, &self.strikes, self.plan.runs).map_err(StudyError::from);
        lend(&mut other, &mut self.base);
        Ok((found?, self.same_sites(&other)?))
    }

    /// Errors of another object with the same bodies, for the sites of the finest lattice.
    pub(super) fn same_sites(&self, other: &PreparedObject) -> Result<CrackErrors, StudyError> {
        let truths = &self.truths;
        let lifts = truths.carried(other);
        let pair = |truth: &Truth| {
            let pair = truths.compared(&other.bodies[truth.own.body], &lifts[truth.own.body], truth)?;
            Ok((pair.finest.with(Measure::Surface, other.report.surface_deviation), pair.own))
        };
        let pairs = truths.impacts.par_iter().map(pair).collect::<Result<Vec<_>, StudyError>>()?;
        let (finest, own): (Vec<_>, Vec<_>) = pairs.into_iter().unzip();
        Ok(CrackErrors { finest: PointErrors::medians(&finest), own: PointErrors::medians(&own) })
    }

    /// Node labels and the exact diagram on the object's lattice, both against the finest one; the time of clipping adds to a request's.
    pub(super) fn tessellations(&mut self) {
        self.point("tessellation", json!("nodes"), |bench| {
            let times = timed(&bench.base, &bench.strikes, bench.plan.runs)?;
            Ok((times, bench.same_sites(&bench.base)?.finest))
        });
        self.point("tessellation", json!("exact"), |bench| {
            let mut times = timed(&bench.base, &bench.strikes, bench.plan.runs)?;
            let (lifts, mut all, mut clips) = (bench.truths.carried(&bench.base), Vec::new(), Vec::new());
            for truth in &bench.truths.impacts {
                let (body, lift) = (&bench.base.bodies[truth.own.body], &lifts[truth.own.body]);
                let begin = Instant::now();
                let found = exact(&body.crack, lift, &truth.sites, &CancelToken::default())?;
                clips.push(1e3 * begin.elapsed().as_secs_f64());
                let given = |place: &LatticePoint| nearest(&body.crack, lift, &truth.sites, place).unwrap_or(0);
                all.push(bench.truths.against_finest(body, &given, &found.volumes, &found.triangles, truth)?);
            }
            times.0.iter_mut().zip(clips.iter().cycle()).for_each(|(time, clip)| *time += clip);
            Ok((times, PointErrors::medians(&all)))
        });
    }
}

impl Truths {
    /// Lift of the finest lattices, carried to those of another object.
    fn carried(&self, other: &PreparedObject) -> Vec<LiftedLattice> {
        let fine = self.fine.bodies.iter().zip(&self.locators);
        let pairs = fine.zip(&other.bodies);
        pairs
            .filter_map(|((fine, locator), other)| {
                Some(carried(fine.lift(LiftKind::Interior)?, &fine.crack, locator, &other.crack))
            })
            .collect()
    }

    fn compared(&self, body: &PreparedBody, lift: &LiftedLattice, truth: &Truth) -> Result<CrackErrors, StudyError> {
        let (token, sites) = (CancelToken::default(), &truth.sites);
        let labels = labels(body, lift, sites)?;
        let regions = Regions::new(&body.crack, &body.topology, lift, sites, &labels)?;
        let clipped = exact(&body.crack, lift, sites, &token)?;
        let found = misplaced(&regions, lift, sites, &token)?;
        let cracks = regions.cracks()?;
        let own = same_lattice(&found, &cracks, &clipped)?;
        let given = |place: &LatticePoint| regions.label(place);
        let finest = self.against_finest(body, &given, &found.volumes, &cracks, truth)?;
        Ok(CrackErrors { finest, own })
    }

    /// Errors against the exact diagram on the finest lattice.
    fn against_finest(
        &self,
        body: &PreparedBody,
        given: &(dyn Fn(&LatticePoint) -> u32 + Sync),
        volumes: &[f64],
        cracks: &[[nalgebra::Point3<f64>; 3]],
        truth: &Truth,
    ) -> Result<PointErrors, StudyError> {
        let fine = &self.fine;
        let lift = fine.lift(truth.own.body, LiftKind::Interior)?;
        let lattice = &fine.bodies[truth.own.body].crack;
        let label = label_fraction(&body.crack, given, lattice, lift, &truth.sites, &CancelToken::default())?;
        let distance = crack_distance(cracks, &truth.exact.triangles);
        Ok(PointErrors::default()
            .with(Measure::Label, label)
            .with(Measure::CrackMean, distance.mean)
            .with(Measure::CrackMax, distance.max)
            .with(Measure::Volume, volume_l1(volumes, &truth.exact.volumes)?))
    }
}

/// Errors of node labels against the exact diagram on the same lattice.
fn same_lattice(
    found: &LabelErrors,
    cracks: &[[nalgebra::Point3<f64>; 3]],
    clipped: &ExactCells,
) -> Result<PointErrors, StudyError> {
    let distance = crack_distance(cracks, &clipped.triangles);
    Ok(PointErrors::default()
        .with(Measure::Label, found.fraction)
        .with(Measure::CrackMean, distance.mean)
        .with(Measure::CrackMax, distance.max)
        .with(Measure::Volume, volume_l1(&found.volumes, &clipped.volumes)?))
}

/// Nearest site of every node.
fn labels(body: &PreparedBody, lift: &LiftedLattice, sites: &[f64]) -> Result<Vec<u32>, StudyError> {
    let mut mass = body.volumes.clone();
    let field = EnergyField::new(lift, &body.volumes, &mut mass)?;
    Ok(assign(&field, sites, &mut DiagramWorkspace::default()).labels)
}

/// Moves the elasticity of one object to another with the same bodies.
fn lend(from: &mut PreparedObject, to: &mut PreparedObject) {
    for (from, to) in from.bodies.iter_mut().zip(&mut to.bodies) {
        to.solid = from.solid.take().map(|mut solid| {
            solid.transfer = EnergyTransfer::between(&solid.lattice, &to.crack);
            solid
        });
    }
}
