//! References of cells and cracks against which the points are measured; `reference` has those of elasticity.

use super::subject::{LIFTED, energy, rebaked};
use super::{AccuracyPlan, Measure, PointErrors, StudyError};
use rayon::prelude::*;
use shatter_fracture::accuracy::{ExactCells, cvd_gap, exact, size_distance};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::centroidal::{self, Diagram, DiagramOptions, EnergyField};
use shatter_fracture::degree::{CurveOptions, EnergyCurve};
use shatter_fracture::lattice::Locator;
use shatter_fracture::lift::{LiftKind, LiftedLattice};
use shatter_fracture::pipeline::{BodyEnergy, DisplacementMethod, FractureRequest, PreparedObject, Workspace};
use shatter_fracture::tessellation::components;

/// First seed of the references' starts; no request uses one of these seeds.
pub(super) const SEED_FIRST: u64 = 1 << 32;

/// Minimum ratio of a reference's crack nodes to those of the lattice that it judges. Against a lattice as fine as itself, any lattice
/// appears too accurate.
const FINER_MIN: usize = 2;

/// Number of optimizations whose median is the reference of a degree.
const OPTIMIZED: u64 = 3;

/// References of one impact.
pub(super) struct Truth {
    /// Energy of a solve on the object's own lattice.
    pub own: BodyEnergy,
    /// Sites on the finest lattice, site-major.
    pub sites: Vec<f64>,
    /// Exact diagram of these sites there.
    pub exact: ExactCells,
    /// Best known energy of a diagram of the own field, and its fragment volumes.
    pub best: Best,
}

/// Best of several diagrams.
pub(super) struct Best {
    pub energy: f64,
    pub sizes: Vec<f64>,
}

/// Finest lattices, and the references derived from them.
pub(super) struct Truths {
    pub fine: PreparedObject,
    pub locators: Vec<Locator>,
    pub impacts: Vec<Truth>,
}

impl Truths {
    /// Bakes the finest lattices, solves, divides and clips on them.
    pub(super) fn new(
        plan: &AccuracyPlan,
        base: &PreparedObject,
        strikes: &[FractureRequest],
    ) -> Result<Self, StudyError> {
        let finer = plan.finer.powf(-1.0 / 3.0);
        let [elastic, crack] = [base.parameters.elastic_spacing, base.parameters.crack_spacing].map(|h| h * finer);
        let fine = rebaked(plan, base, elastic, crack, LIFTED)?;
        let solved: Vec<FractureRequest> = strikes.iter().map(solve).collect();
        let truth = |workspace: &mut Workspace, strike: &FractureRequest| {
            let (sites, exact) = divided(plan, &fine, strike, workspace)?;
            let own = energy(base, strike, workspace)?;
            let best = best(plan, base, &own, base.lift(own.body, LiftKind::Interior)?)?;
            Ok(Truth { own, sites, exact, best })
        };
        let impacts = solved.par_iter().map_init(Workspace::default, truth).collect::<Result<_, StudyError>>()?;
        let locators = fine.bodies.iter().map(|body| Locator::new(&body.crack)).collect();
        Ok(Self { fine, locators, impacts })
    }
}

/// Whether a reference with that many crack nodes can judge a lattice with `nodes` of them.
pub(super) fn is_finer(reference_nodes: usize, nodes: usize) -> bool {
    reference_nodes >= FINER_MIN.saturating_mul(nodes)
}

impl Truth {
    /// Errors of a diagram of the object's own field.
    pub(super) fn diagram(&self, base: &PreparedObject, found: &Diagram) -> PointErrors {
        let sizes = pieces(base, self.own.body, &found.labels).0;
        PointErrors::default()
            .with(Measure::Gap, cvd_gap(found.energy, self.best.energy))
            .with(Measure::Size, size_distance(&sizes, &self.best.sizes))
    }
}

/// Request that always solves for displacements.
pub(super) fn solve(strike: &FractureRequest) -> FractureRequest {
    FractureRequest { elastic: DisplacementMethod::Solve, ..strike.clone() }
}

/// Sites of an impact on the finest lattice, and their exact diagram.
fn divided(
    plan: &AccuracyPlan,
    fine: &PreparedObject,
    strike: &FractureRequest,
    workspace: &mut Workspace,
) -> Result<(Vec<f64>, ExactCells), StudyError> {
    let energy = energy(fine, strike, workspace)?;
    let lift = fine.lift(energy.body, LiftKind::Interior)?;
    let options = DiagramOptions::new(plan.sites as usize, strike.seed);
    let diagram = diagram(fine, &energy, lift, &options)?;
    let exact = exact(&fine.bodies[energy.body].crack, lift, &diagram.sites, &CancelToken::default())?;
    Ok((diagram.sites, exact))
}

/// Diagram of an energy in a lift.
pub(super) fn diagram(
    prepared: &PreparedObject,
    energy: &BodyEnergy,
    lift: &LiftedLattice,
    options: &DiagramOptions,
) -> Result<Diagram, StudyError> {
    let mut mass = energy.shares.clone();
    let field = EnergyField::new(lift, &prepared.bodies[energy.body].volumes, &mut mass)?;
    Ok(centroidal::diagram(&field, options, &mut centroidal::DiagramWorkspace::default(), &CancelToken::default())?)
}

/// Best of the plan's starts, run to convergence.
pub(super) fn best(
    plan: &AccuracyPlan,
    prepared: &PreparedObject,
    energy: &BodyEnergy,
    lift: &LiftedLattice,
) -> Result<Best, StudyError> {
    let mut best = Best { energy: f64::INFINITY, sizes: Vec::new() };
    for start in 0..plan.starts {
        let options = DiagramOptions { start, tolerance: 0.0, ..DiagramOptions::new(plan.sites as usize, SEED_FIRST) };
        let found = diagram(prepared, energy, lift, &options)?;
        if found.energy < best.energy {
            best = Best { energy: found.energy, sizes: pieces(prepared, energy.body, &found.labels).0 };
        }
    }
    Ok(best)
}

/// Volumes of the connected pieces of labels, and the share of the volume outside the largest piece of its cell.
pub(super) fn pieces(prepared: &PreparedObject, body: usize, labels: &[u32]) -> (Vec<f64>, f64) {
    let body = &prepared.bodies[body];
    let split = components(&body.topology, labels);
    let mut sizes = vec![0.0; split.sites.len()];
    split.labels.iter().zip(&body.volumes).for_each(|(piece, volume)| sizes[*piece as usize] += volume);
    let (mut first, mut stray) = (0, 0.0);
    // The pieces of a cell are consecutive.
    for same in split.sites.chunk_by(|a, b| a == b) {
        let cell = &sizes[first..first + same.len()];
        stray += cell.iter().sum::<f64>() - cell.iter().copied().fold(0.0, f64::max);
        first += same.len();
    }
    let whole: f64 = sizes.iter().sum();
    (sizes, stray / whole)
}

/// Fracture degree of an impact: median of several full optimizations with seeds that no request uses. `factor` scales its impulse.
pub(super) fn optimized(base: &PreparedObject, truth: &Truth, factor: f64) -> Result<f64, StudyError> {
    let own = &truth.own;
    let body = &base.bodies[own.body];
    let gamma = base.gamma_j_m2 / own.unit_j_m2(base.frame.diagonal_m) / (factor * factor);
    let mut degrees = Vec::new();
    for number in 0..OPTIMIZED {
        let mut mass = own.shares.clone();
        let field = EnergyField::new(base.lift(own.body, LiftKind::Interior)?, &body.volumes, &mut mass)?;
        let options = CurveOptions { seed: SEED_FIRST + number, ..CurveOptions::default() };
        let mut curve = EnergyCurve::new(&field, options);
        curve.extend(&field, gamma, &mut centroidal::DiagramWorkspace::default(), &CancelToken::default())?;
        degrees.push(curve.degree(gamma).0.sites as f64);
    }
    degrees.sort_by(f64::total_cmp);
    Ok(degrees[degrees.len() / 2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_judges_only_lattices_with_half_its_nodes() {
        assert!(is_finer(12_000, 3_000) && is_finer(12_000, 6_000));
        assert!(!is_finer(12_000, 6_001) && !is_finer(12_000, 12_000) && !is_finer(9_000, 12_000));
    }
}
