//! Elastic references: the lattice of an object itself, refined uniformly, and extrapolated.
//!
//! The refined lattices have the shape of the object's, and contacts have one effective radius on all of them. Elements
//! have the order of the object's. So the errors are those of the discretization alone. The error of the shape is separate ([`Measure::Geometry`]): the
//! extrapolated energy of this lattice against that of the finest one.

use super::subject::degree_of;
use super::{AccuracyPlan, Measure, PointErrors, StudyError};
use shatter_fracture::accuracy::{Extrapolation, density_error};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::elasticity::{ContactLoad, ElementOrder, RefinedBody};
use shatter_fracture::lattice::{EnergyTransfer, Lattice, refined_node_count};
use shatter_fracture::pipeline::{BodyEnergy, ContactSet, FractureRequest, PreparedObject};
use std::time::Instant;

/// Largest number of refinements. The last three levels show the order of convergence; with contacts of about one
/// spacing, the lattice itself is often too coarse to be one of them.
const REFINEMENTS_MAX: usize = 3;

/// Factor on the largest number of nodes for the first refinement, without which a subject has no reference. Quadratic
/// elements on `film`'s lattice of the vase, refined once, have 3.5 million nodes and edges.
const ONCE: usize = 3;

/// Share of an energy that solves with quadratic elements miss at most; error bars contain it. At 1e-5, solves need a third
/// more steps, and energies of the mug change by 1.5e-5 to 5e-5.
const ACCURACY_QUADRATIC: f64 = 1e-4;

/// A reference must have more than this many times the unknowns of its subject.
const FINER_MIN: usize = 2;

/// Order of the energy, and of numbers that follow from it, with linear elements on smooth problems.
///
/// Quadratic elements have twice that, but edges of the lattice and contacts of one spacing leave them about as much.
const ENERGY_ORDER: f64 = 2.0;

/// Range of the order of the energy density.
const DENSITY_ORDERS: [f64; 2] = [1.0, 2.0];

/// Energies of one impact on all levels, the coarsest first.
pub(super) struct ImpactLevels {
    body: usize,
    radius_m: f64,
    /// Energies of the body, J.
    energies_j: Vec<f64>,
    /// Error of the energy that stems from the load on the finest level, J.
    load_error_j: f64,
    /// Share of an energy that a solve misses at most.
    solve_accuracy: f64,
    /// Energies of the tetrahedra of the object's own lattice, J.
    tets_j: Vec<Vec<f64>>,
}

impl ImpactLevels {
    /// Extrapolated energy, J.
    pub(super) fn energy(&self) -> Extrapolation {
        let found = extrapolated(&self.energies_j);
        found.widened(self.load_error_j + self.solve_accuracy * found.value.abs())
    }

    /// As [`Self::energy`], and the energy on the object's own lattice, J.
    pub(super) fn judge(&self) -> EnergyJudge {
        EnergyJudge { energy: self.energy(), own_j: self.energies_j.first().copied().unwrap_or(f64::NAN) }
    }
}

/// Reference for the energy of one impact.
#[derive(Clone, Copy, Debug)]
pub(super) struct EnergyJudge {
    /// Extrapolated energy, J.
    pub(super) energy: Extrapolation,
    /// Energy of a solve on the object's own lattice, with the load of the finest level, J.
    pub(super) own_j: f64,
}

fn extrapolated(values: &[f64]) -> Extrapolation {
    match *values {
        [.., a, b, c] => Extrapolation::new([a, b, c], ENERGY_ORDER),
        [a, b] => Extrapolation::of_two([a, b], ENERGY_ORDER),
        _ => Extrapolation { value: values.last().copied().unwrap_or(0.0), bar: f64::INFINITY, order: None },
    }
}

/// Solves impacts of one contact each on an object's own lattice and its refinements.
///
/// # Errors
/// [`StudyError::CoarseReference`] where the plan allows too few nodes.
pub(super) fn levels(
    plan: &AccuracyPlan,
    prepared: &PreparedObject,
    strikes: &[FractureRequest],
) -> Result<Vec<ImpactLevels>, StudyError> {
    let sets = strikes.iter().map(|strike| ContactSet::new(prepared, strike)).collect::<Result<Vec<_>, _>>()?;
    let mut found: Vec<Option<ImpactLevels>> = strikes.iter().map(|_| None).collect();
    for body in 0..prepared.bodies.len() {
        let own = |set: &ContactSet| set.bodies.first().is_some_and(|(struck, _)| *struck == body);
        let struck: Vec<usize> = (0..sets.len()).filter(|index| own(&sets[*index])).collect();
        if struck.is_empty() {
            continue;
        }
        let contacts = struck.iter().map(|index| sets[*index].bodies[0].1.clone()).collect();
        for (index, mut levels) in struck.into_iter().zip(body_levels(plan, prepared, body, contacts)?) {
            let unit_j = sets[index].unit_j(prepared);
            let tets = levels.tets_j.iter_mut().flatten();
            let load = std::iter::once(&mut levels.load_error_j);
            levels.energies_j.iter_mut().chain(tets).chain(load).for_each(|energy| *energy *= unit_j);
            found[index] = Some(levels);
        }
    }
    found.into_iter().collect::<Option<_>>().ok_or(StudyError::Whole)
}

/// As [`levels`], of the impacts on one body, in local units.
fn body_levels(
    plan: &AccuracyPlan,
    prepared: &PreparedObject,
    body: usize,
    contacts: Vec<Vec<ContactLoad>>,
) -> Result<Vec<ImpactLevels>, StudyError> {
    let solid = prepared.bodies[body].solid.as_ref().ok_or(StudyError::Unprepared)?;
    let order = solid.elasticity.order();
    // An edge with a quadratic function counts as the node that a further refinement puts there.
    let further = usize::from(order == ElementOrder::Quadratic);
    let nodes = |count: &usize| refined_node_count(&solid.lattice, count + further);
    let nodes_max = |count: &usize| if *count == 1 { ONCE * plan.refined_nodes_max } else { plan.refined_nodes_max };
    let count = (1..=REFINEMENTS_MAX).take_while(|count| nodes(count) <= nodes_max(count)).last().unwrap_or(0);
    check_finer(3 * nodes(&count), solid.elasticity.unknowns())?;
    let token = CancelToken::default();
    let refined = RefinedBody::new(&solid.lattice, prepared.parameters.material.poisson, count, &token)?;
    let refined = refined.of_order(order)?;
    let refined = if order == ElementOrder::Quadratic { refined.with_accuracy(ACCURACY_QUADRATIC) } else { refined };
    let radius = |contacts: &Vec<ContactLoad>| contacts.iter().map(|contact| contact.radius).fold(0.0, f64::max);
    let radius_m = |contacts| radius(contacts) * prepared.frame.diagonal_m;
    let own = |contacts| ImpactLevels {
        body,
        radius_m: radius_m(contacts),
        energies_j: Vec::new(),
        load_error_j: f64::INFINITY,
        solve_accuracy: refined.accuracy(),
        tets_j: Vec::new(),
    };
    let mut all: Vec<ImpactLevels> = contacts.iter().map(own).collect();
    for level in 0..=count {
        let energies = refined.impact_energies(level, &contacts, &token)?;
        if level + 1 == count {
            let load_errors = refined.load_errors(&contacts, &energies, &token)?;
            all.iter_mut().zip(load_errors).for_each(|(own, error)| own.load_error_j = error);
        }
        for (own, energy) in all.iter_mut().zip(energies) {
            own.energies_j.push(energy.energy);
            own.tets_j.push(energy.tets);
        }
    }
    Ok(all)
}

/// Rejects a reference with too few unknowns.
pub(super) fn check_finer(reference: usize, subject: usize) -> Result<(), StudyError> {
    match reference > FINER_MIN.saturating_mul(subject) {
        true => Ok(()),
        false => Err(StudyError::CoarseReference { reference, subject }),
    }
}

/// Reference of one impact.
pub(super) struct ImpactReference {
    /// Energy.
    pub(super) judge: EnergyJudge,
    degree: Extrapolation,
    /// Energies of the nodes of the common crack lattice on the finest level, J.
    nodes_j: Vec<f64>,
    /// Error bar of their distribution.
    density_bar: f64,
}

/// References of all impacts for objects with one elastic lattice.
pub(super) struct ElasticReference {
    lattices: Vec<Lattice>,
    pub(super) impacts: Vec<ImpactReference>,
    /// Time of making it, s.
    pub(super) took_s: f64,
}

impl ElasticReference {
    /// Solves on refinements of the lattice of `prepared`; fields are compared on the crack lattice of `base`.
    pub(super) fn new(
        plan: &AccuracyPlan,
        base: &PreparedObject,
        prepared: &PreparedObject,
        strikes: &[FractureRequest],
    ) -> Result<Self, StudyError> {
        let (lattices, start) = (lattices(prepared), Instant::now());
        let bodies = lattices.iter().zip(&base.bodies);
        let transfers: Vec<EnergyTransfer> =
            bodies.map(|(own, body)| EnergyTransfer::between(own, &body.crack)).collect();
        let impacts = levels(plan, prepared, strikes)?;
        let impacts = impacts.iter().map(|own| ImpactReference::new(base, &transfers[own.body], own));
        let impacts = impacts.collect::<Result<_, _>>()?;
        Ok(Self { lattices, impacts, took_s: start.elapsed().as_secs_f64() })
    }

    /// Whether the reference is that of the lattice of `prepared`.
    pub(super) fn is_of(&self, prepared: &PreparedObject) -> bool {
        self.lattices == lattices(prepared)
    }
}

/// Elastic lattices of all bodies.
fn lattices(prepared: &PreparedObject) -> Vec<Lattice> {
    prepared.bodies.iter().filter_map(|body| body.solid.as_ref()).map(|solid| solid.lattice.clone()).collect()
}

impl ImpactReference {
    fn new(base: &PreparedObject, transfer: &EnergyTransfer, own: &ImpactLevels) -> Result<Self, StudyError> {
        let (mut degrees, mut fields): (Vec<f64>, Vec<Vec<f64>>) = Default::default();
        for tets in &own.tets_j {
            let mut nodes = Vec::new();
            transfer.apply(tets, &mut nodes);
            let energy_j: f64 = nodes.iter().sum();
            let shares = nodes.iter().map(|node| node / energy_j).collect();
            let energy = BodyEnergy {
                body: own.body,
                shares,
                energy_j,
                strain_j: None,
                indentation: Default::default(),
                peaks: Vec::new(),
                reduced_error: None,
                radius_m: own.radius_m,
            };
            degrees.push(degree_of(base, &energy)?);
            fields.push(nodes);
        }
        let steps: Vec<f64> =
            fields.windows(2).map(|pair| density_error(&pair[0], &pair[1])).collect::<Result<_, _>>()?;
        let [slow, fast] = DENSITY_ORDERS;
        let (order, last) = match *steps {
            [.., first, last] => ((first / last).log2().clamp(slow, fast), last),
            _ => (slow, steps.last().copied().unwrap_or(f64::INFINITY)),
        };
        let density_bar = last / (order.exp2() - 1.0);
        let nodes_j = fields.pop().unwrap_or_default();
        Ok(Self { judge: own.judge(), degree: extrapolated(&degrees), nodes_j, density_bar })
    }

    /// Errors of an elastic energy on the crack lattice of `base`.
    pub(super) fn errors(&self, base: &PreparedObject, found: &BodyEnergy) -> Result<PointErrors, StudyError> {
        let nodes_j: Vec<f64> = found.shares.iter().map(|share| share * found.energy_j).collect();
        let errors = PointErrors::default()
            .with_bar(Measure::Energy, self.judge.energy.error(found.energy_j))
            .with_bar(Measure::Density, [density_error(&nodes_j, &self.nodes_j)?, self.density_bar])
            .with_bar(Measure::Degree, self.degree.error(degree_of(base, found)?));
        Ok(match found.reduced_error {
            Some(estimate) => errors.with(Measure::Estimate, estimate),
            None => errors,
        })
    }

    /// Error of the lattice's shape: this extrapolated energy against that of the finest lattice.
    pub(super) fn geometry(&self, finest: &Self) -> PointErrors {
        geometry(&self.judge.energy, &finest.judge.energy)
    }
}

/// Error of the shape of a lattice with the extrapolated energy `own`; both bars count.
pub(super) fn geometry(own: &Extrapolation, finest: &Extrapolation) -> PointErrors {
    let [error, bar] = finest.error(own.value);
    PointErrors::default().with_bar(Measure::Geometry, [error, bar + (own.bar / finest.value).abs()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_needs_more_than_twice_the_unknowns_of_its_subject() {
        assert!(check_finer(24_001, 12_000).is_ok());
        let message = check_finer(36_000, 36_000).unwrap_err().to_string();
        assert!(message.contains("36000 unknowns"), "{message}");
        assert!(check_finer(72_000, 36_000).is_err());
    }
}
