//! Settings of the lift.
//!
//! Energies in different lifts are not comparable, so all diagrams are judged in the finest lift: energy of the same node labels there,
//! with sites in their centroids, relative to the energy of the best diagram in that lift.

use super::settings::Bench;
use super::subject::timed;
use super::truth::{Truth, best, diagram, pieces};
use super::{Measure, PointErrors, PointTimes, StudyError};
use rayon::prelude::*;
use serde_json::json;
use shatter_fracture::accuracy::cvd_gap;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::centroidal::DiagramOptions;
use shatter_fracture::lift::{LiftKind, LiftedLattice, interior};
use shatter_fracture::pipeline::FractureRequest;

/// Lifts that a request can name.
pub(super) const KINDS: [LiftKind; 3] = [LiftKind::Euclidean, LiftKind::Interior, LiftKind::SurfaceDiffusion];

/// Finest lift of every body, and the best energy of every impact in it.
struct Finest {
    lifts: Vec<LiftedLattice>,
    energies: Vec<f64>,
}

impl Bench<'_> {
    /// Numbers of eigenfunctions of the interior lift, and the kinds of lift.
    pub(super) fn lifts(&mut self) {
        let finest = match self.finest() {
            Ok(finest) => finest,
            Err(error) => return self.findings.left_out.push(["lift".to_owned(), error.to_string()]),
        };
        self.dimensions(&finest);
        for kind in KINDS {
            self.point("lift", json!(kind.to_string()), |bench| {
                let strikes = bench.with(|strike| strike.lift = kind);
                bench.lifted(&strikes, &finest)
            });
        }
    }

    fn finest(&self) -> Result<Finest, StudyError> {
        let modes = self.plan.modes.iter().copied().max().unwrap_or(0);
        let lifts = self.interior(modes)?;
        let (plan, base) = (self.plan, &self.base);
        let energy = |truth: &Truth| Ok(best(plan, base, &truth.own, &lifts[truth.own.body])?.energy);
        let energies = self.truths.impacts.par_iter().map(energy).collect::<Result<_, StudyError>>()?;
        Ok(Finest { lifts, energies })
    }

    fn interior(&self, modes: usize) -> Result<Vec<LiftedLattice>, StudyError> {
        let alpha = self.base.parameters.alpha;
        let lifts = self.base.bodies.iter().map(|body| interior(&body.crack, modes, alpha, &CancelToken::default()));
        Ok(lifts.collect::<Result<_, _>>()?)
    }

    /// Numbers of eigenfunctions. The spectrum is cut at gaps, so several numbers may give the same lift; it is measured
    /// once, under the number of eigenfunctions that it has.
    fn dimensions(&mut self, finest: &Finest) {
        let mut tried = Vec::new();
        for modes in self.plan.modes.clone() {
            let lifts = match self.interior(modes) {
                Ok(lifts) => lifts,
                Err(error) => {
                    self.skip("lift_dimension", modes, error.to_string());
                    continue;
                }
            };
            let kept = lifts.iter().map(|lift| lift.dimension - 3).max().unwrap_or(0);
            if tried.contains(&kept) {
                self.skip(
                    "lift_dimension",
                    modes,
                    format!("the spectrum is cut at the same gap as for a previous value, after {kept}"),
                );
                continue;
            }
            tried.push(kept);
            self.point("lift_dimension", json!(kept), |bench| bench.dimension(lifts, finest));
        }
    }

    fn dimension(
        &mut self,
        lifts: Vec<LiftedLattice>,
        finest: &Finest,
    ) -> Result<(PointTimes, PointErrors), StudyError> {
        let own: Vec<Option<LiftedLattice>> =
            self.base.bodies.iter_mut().zip(lifts).map(|(body, lift)| body.interior.replace(lift)).collect();
        let found = self.lifted(&self.strikes.clone(), finest);
        self.base.bodies.iter_mut().zip(own).for_each(|(body, lift)| body.interior = lift);
        found
    }

    /// Times and errors of requests in the lifts that they name.
    fn lifted(&self, strikes: &[FractureRequest], finest: &Finest) -> Result<(PointTimes, PointErrors), StudyError> {
        let (plan, base) = (self.plan, &self.base);
        let errors = |((truth, strike), reference): ((&Truth, &FractureRequest), &f64)| {
            let body = truth.own.body;
            let options = DiagramOptions::new(plan.sites as usize, strike.seed);
            let found = diagram(base, &truth.own, base.lift(body, strike.lift)?, &options)?;
            let energy = energy_in(&finest.lifts[body], &truth.own.shares, &found.labels, found.count());
            Ok(PointErrors::default()
                .with(Measure::Gap, cvd_gap(energy, *reference))
                .with(Measure::Stray, pieces(base, body, &found.labels).1))
        };
        let each = self.truths.impacts.par_iter().zip(strikes).zip(&finest.energies);
        let all: Vec<PointErrors> = each.map(errors).collect::<Result<_, StudyError>>()?;
        Ok((timed(&self.base, strikes, self.plan.runs)?, PointErrors::medians(&all)))
    }
}

/// Energy of the cells of `labels` about their centroids in `lift`.
fn energy_in(lift: &LiftedLattice, mass: &[f64], labels: &[u32], cells: usize) -> f64 {
    let m = lift.dimension;
    let (mut masses, mut moments, mut squares) = (vec![0.0; cells], vec![0.0; cells * m], 0.0);
    for (node, (&label, w)) in labels.iter().zip(mass).enumerate() {
        let cell = label as usize;
        masses[cell] += w;
        for (sum, x) in moments[cell * m..][..m].iter_mut().zip(lift.at(node)) {
            *sum += w * x;
            squares += w * x * x;
        }
    }
    let of_centroid = |(cell, mass): (usize, &f64)| {
        let square: f64 = moments[cell * m..][..m].iter().map(|x| x * x).sum();
        if *mass > 0.0 { square / mass } else { 0.0 }
    };
    squares - masses.iter().enumerate().map(of_centroid).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::energy_in;
    use shatter_fracture::lattice::block;
    use shatter_fracture::lift::LiftedLattice;

    #[test]
    fn energies_about_centroids_are_sums_of_squares() {
        let lattice = block([2; 3], 1.0);
        let lift = LiftedLattice::euclidean(&lattice);
        let mut mass = vec![0.0; lattice.nodes.len()];
        (mass[0], mass[1], mass[2]) = (1.0, 3.0, 2.0);
        let labels: Vec<u32> = (0..lattice.nodes.len()).map(|node| u32::from(node == 2)).collect();
        let square: f64 = lift.at(0).iter().zip(lift.at(1)).map(|(a, b)| (a - b) * (a - b)).sum();
        // Two masses about their centroid, and a single one.
        assert!((energy_in(&lift, &mass, &labels, 2) - square * 3.0 / 4.0).abs() < 1e-12);
    }
}
