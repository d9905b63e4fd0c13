//! Dials of the tessellation: the crack lattice, and labels of nodes or the exact diagram. All of the same sites.

use super::dials::Bench;
use super::subject::{rebaked, timed};
use super::truth::Truth;
use super::{Errors, Measure, StudyError, Times};
use serde_json::json;
use shatter_fracture::accuracy::{
    Exact, Misplaced, Regions, carried, crack_distance, exact, label_fraction, misplaced, nearest, volume_l1,
};
use shatter_fracture::centroidal::{Field, Workspace, assign};
use shatter_fracture::database::Tables;
use shatter_fracture::lattice::{Place, Transfer};
use shatter_fracture::lift::{Lift, LiftKind};
use shatter_fracture::pipeline::{Body, Prepared};
use shatter_fracture::token::Token;
use std::time::Instant;

/// Settings of the dial `tessellation`.
pub(super) const MODES: usize = 2;

/// Errors of one crack lattice: against the finest one, and of the labels alone.
pub(super) struct Pair {
    pub finest: Errors,
    pub own: Errors,
}

impl Bench<'_> {
    /// Crack lattices; beside each, labels of its nodes against the exact diagram on it.
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
                let (dial, value) = ("node_labels", json!(spacing));
                self.findings.points.push(super::Point { dial, value, preset: None, times, errors });
            }
        }
    }

    fn crack_spacing(&mut self, spacing: f64) -> Result<(Times, Pair), StudyError> {
        // Elasticity is lent by the object; its own is made for no coarser lattice.
        let tables = Tables { interior: true, ..Tables::NONE };
        let elastic = self.base.parameters.elastic_spacing.max(spacing);
        let mut other = rebaked(self.plan, &self.base, elastic, spacing, tables)?;
        lend(&mut self.base, &mut other);
        let found = timed(&other, &self.strikes, self.plan.runs).map_err(StudyError::from);
        lend(&mut other, &mut self.base);
        Ok((found?, self.same_sites(&other)?))
    }

    /// Errors of another object of the same bodies, for the sites of the finest lattice.
    pub(super) fn same_sites(&self, other: &Prepared) -> Result<Pair, StudyError> {
        let lifts = self.carried(other);
        let (mut finest, mut own) = (Vec::new(), Vec::new());
        for truth in &self.truths.impacts {
            let pair = self.compared(&other.bodies[truth.own.body], &lifts[truth.own.body], truth)?;
            finest.push(pair.finest.with(Measure::Surface, other.report.surface_deviation));
            own.push(pair.own);
        }
        Ok(Pair { finest: Errors::medians(&finest), own: Errors::medians(&own) })
    }

    /// The lift of the finest lattices on those of another object.
    fn carried(&self, other: &Prepared) -> Vec<Lift> {
        let fine = self.truths.fine.bodies.iter().zip(&self.truths.locators);
        let pairs = fine.zip(&other.bodies);
        pairs
            .filter_map(|((fine, locator), other)| {
                Some(carried(fine.lift(LiftKind::Interior)?, &fine.crack, locator, &other.crack))
            })
            .collect()
    }

    fn compared(&self, body: &Body, lift: &Lift, truth: &Truth) -> Result<Pair, StudyError> {
        let (token, sites) = (Token::default(), &truth.sites);
        let labels = labels(body, lift, sites)?;
        let regions = Regions::new(&body.crack, &body.topology, lift, sites, &labels)?;
        let clipped = exact(&body.crack, lift, sites, &token)?;
        let found = misplaced(&regions, lift, sites, &token)?;
        let cracks = regions.cracks()?;
        let own = same_lattice(&found, &cracks, &clipped)?;
        let given = |place: &Place| regions.label(place);
        let finest = self.against_finest(body, &given, &found.volumes, &cracks, truth)?;
        Ok(Pair { finest, own })
    }

    /// Errors against the exact diagram on the finest lattice.
    fn against_finest(
        &self,
        body: &Body,
        given: &(dyn Fn(&Place) -> u32 + Sync),
        volumes: &[f64],
        cracks: &[[nalgebra::Point3<f64>; 3]],
        truth: &Truth,
    ) -> Result<Errors, StudyError> {
        let fine = &self.truths.fine;
        let lift = fine.lift(truth.own.body, LiftKind::Interior)?;
        let lattice = &fine.bodies[truth.own.body].crack;
        let label = label_fraction(&body.crack, given, lattice, lift, &truth.sites, &Token::default())?;
        let distance = crack_distance(cracks, &truth.exact.triangles);
        Ok(Errors::default()
            .with(Measure::Label, label)
            .with(Measure::CrackMean, distance.mean)
            .with(Measure::CrackMax, distance.max)
            .with(Measure::Volume, volume_l1(volumes, &truth.exact.volumes)?))
    }

    /// Labels of nodes and the exact diagram on the object's own lattice, both against the finest one; clipping comes on top of a strike.
    pub(super) fn tessellations(&mut self) {
        self.point("tessellation", json!("nodes"), |bench| {
            let times = timed(&bench.base, &bench.strikes, bench.plan.runs)?;
            Ok((times, bench.same_sites(&bench.base)?.finest))
        });
        self.point("tessellation", json!("exact"), |bench| {
            let mut times = timed(&bench.base, &bench.strikes, bench.plan.runs)?;
            let (lifts, mut all, mut clips) = (bench.carried(&bench.base), Vec::new(), Vec::new());
            for truth in &bench.truths.impacts {
                let (body, lift) = (&bench.base.bodies[truth.own.body], &lifts[truth.own.body]);
                let begin = Instant::now();
                let found = exact(&body.crack, lift, &truth.sites, &Token::default())?;
                clips.push(1e3 * begin.elapsed().as_secs_f64());
                let given = |place: &Place| nearest(&body.crack, lift, &truth.sites, place).unwrap_or(0);
                all.push(bench.against_finest(body, &given, &found.volumes, &found.triangles, truth)?);
            }
            times.0.iter_mut().zip(clips.iter().cycle()).for_each(|(time, clip)| *time += clip);
            Ok((times, Errors::medians(&all)))
        });
    }
}

/// Errors of node labels against the exact diagram on the same lattice.
fn same_lattice(
    found: &Misplaced,
    cracks: &[[nalgebra::Point3<f64>; 3]],
    clipped: &Exact,
) -> Result<Errors, StudyError> {
    let distance = crack_distance(cracks, &clipped.triangles);
    Ok(Errors::default()
        .with(Measure::Label, found.fraction)
        .with(Measure::CrackMean, distance.mean)
        .with(Measure::CrackMax, distance.max)
        .with(Measure::Volume, volume_l1(&found.volumes, &clipped.volumes)?))
}

/// The nearest site of every node.
fn labels(body: &Body, lift: &Lift, sites: &[f64]) -> Result<Vec<u32>, StudyError> {
    let mut mass = body.volumes.clone();
    let field = Field::new(lift, &body.volumes, &mut mass)?;
    Ok(assign(&field, sites, &mut Workspace::default()).labels)
}

/// Hands the elasticity of one object to another of the same bodies.
fn lend(from: &mut Prepared, to: &mut Prepared) {
    for (from, to) in from.bodies.iter_mut().zip(&mut to.bodies) {
        to.solid = from.solid.take().map(|mut solid| {
            solid.transfer = Transfer::between(&solid.lattice, &to.crack);
            solid
        });
    }
}
