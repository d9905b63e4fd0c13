//! Degree and centroidal: how many sites, and where.

use super::convergence_monitor::ConvergenceMonitor;
use super::search::search;
use super::{
    DegreeRequest, DegreeSource, FractureError, FractureRequest, PreparedObject, Stage, StageObserver, Termination,
    ThresholdResult, Workspace,
};
use crate::cancel_token::CancelToken;
use crate::centroidal::{self, Diagram, DiagramOptions, EnergyField};
use crate::degree::{self, SiteCount};
use crate::lift::LiftKind;
use crate::scene::EffectKind;

/// Trust in a degree from the closed form where no examples are asked: what is said at the edge of their reach, since it errs about
/// as much as they do there.
const CONFIDENCE_CLOSED_FORM: f64 = 0.6;

/// The diagram of one struck body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyCells {
    /// Position among the struck bodies.
    pub struck: usize,
    /// Sites, labels, cell energies.
    pub diagram: Diagram,
}

/// What the degree and centroidal stages decided.
#[derive(Clone, Debug, PartialEq)]
pub struct Division {
    /// Which rule produced the number of sites.
    pub source: DegreeSource,
    /// Fracture degree of the criterion.
    pub degree: u32,
    /// Whether the cap cut it.
    pub capped: bool,
    /// Trust in the degree, 0 to 1.
    pub confidence: f64,
    /// What ended the descents: the last of [`Termination`] of all bodies; `None` without any.
    pub ending: Option<Termination>,
    /// Diagrams of the bodies that break; the others stay whole.
    pub cells: Vec<BodyCells>,
}

/// Chooses the number of sites of each struck body and divides it.
///
/// A number asked for by the caller is shared out by the closed form's degree and breaks the object whatever γ says; the
/// other rules leave a body whole where its E_1 ≤ γ.
pub fn divide(
    prepared: &PreparedObject,
    strike: &FractureRequest,
    verdict: &ThresholdResult,
    fields: &[EnergyField],
    workspace: &mut Workspace,
    token: &CancelToken,
    watch: &mut dyn StageObserver,
) -> Result<Division, FractureError> {
    match strike.degree {
        DegreeRequest::Optimised | DegreeRequest::Verified if may_search(prepared, strike, verdict, fields, watch) => {
            search(prepared, strike, verdict, fields, workspace, token, watch)
        }
        DegreeRequest::ClosedForm | DegreeRequest::Inferred | DegreeRequest::Optimised | DegreeRequest::Verified => {
            watch.enter(Stage::Degree);
            let guesses = guesses(prepared, strike, verdict, fields);
            tell(&guesses, watch);
            watch.leave(Stage::Degree, 0);
            let sites: Vec<u32> = guesses.iter().map(|guess| if guess.sites > 1 { guess.sites } else { 0 }).collect();
            let (cells, ending) = diagrams(strike, &sites, fields, workspace, token, watch)?;
            Ok(Division {
                source: source_of(&guesses),
                degree: guesses.iter().map(|guess| guess.sites).sum(),
                capped: guesses.iter().any(|guess| guess.capped),
                confidence: guesses.iter().map(|guess| guess.confidence).fold(1.0, f64::min),
                ending,
                cells,
            })
        }
        DegreeRequest::Sites(count) => {
            watch.enter(Stage::Degree);
            let wish = |(struck, field): (usize, &EnergyField)| {
                let shape = &prepared.bodies[verdict.bodies[struck]].slenderness;
                degree::closed_form(field, shape, verdict.gammas[struck])
            };
            // One body takes them all, whatever it wishes.
            let wishes: Vec<f64> =
                if fields.len() > 1 { fields.iter().enumerate().map(wish).collect() } else { vec![1.0] };
            let sites = shared_out(count, &wishes);
            watch.leave(Stage::Degree, 0);
            let (cells, ending) = diagrams(strike, &sites, fields, workspace, token, watch)?;
            let source = DegreeSource::Forced;
            Ok(Division { source, degree: count, capped: false, confidence: 1.0, ending, cells })
        }
    }
}

/// Whether there is time to search degrees.
fn may_search(
    prepared: &PreparedObject,
    strike: &FractureRequest,
    verdict: &ThresholdResult,
    fields: &[EnergyField],
    watch: &dyn StageObserver,
) -> bool {
    let remaining_s = watch.remaining_s();
    if remaining_s.is_infinite() {
        return true;
    }
    let guesses = guesses(prepared, strike, verdict, fields);
    strike.may_search(guesses.iter().map(|guess| guess.sites).sum(), remaining_s)
}

/// What is said of one struck body without making a diagram.
pub(super) struct DegreeGuess {
    pub sites: u32,
    pub capped: bool,
    /// Whether the examples say so; where the body stays whole, nobody needs to.
    pub inferred: bool,
    pub confidence: f64,
}

/// Whose guesses they are.
pub(super) fn source_of(guesses: &[DegreeGuess]) -> DegreeSource {
    let inferred = guesses.iter().all(|guess| guess.inferred);
    if inferred { DegreeSource::Inferred } else { DegreeSource::ClosedForm }
}

/// Tells whether examples had a say.
pub(super) fn tell(guesses: &[DegreeGuess], watch: &mut dyn StageObserver) {
    if guesses.iter().any(|guess| guess.inferred && guess.sites > 1) {
        watch.part(EffectKind::Examples, size_of_val(guesses) as u64);
    }
}

/// A guess per struck body: by the examples where they are asked for, were made for this lift, and reach; else by the closed
/// form.
pub(super) fn guesses(
    prepared: &PreparedObject,
    strike: &FractureRequest,
    verdict: &ThresholdResult,
    fields: &[EnergyField],
) -> Vec<DegreeGuess> {
    // They were labelled with all of the elastic energy of a free body, in the interior lift.
    let strange = [EffectKind::Tensile, EffectKind::Anchored].into_iter().any(|effect| strike.effects.has(effect));
    let alike = strike.effects.has(EffectKind::Elastic) && !strange;
    let asked = strike.effects.has(EffectKind::Examples) && !matches!(strike.degree, DegreeRequest::ClosedForm);
    let asked = asked && alike && strike.lift == LiftKind::Interior;
    let learned = prepared.learned.as_ref().filter(|_| asked);
    let guess = |(struck, field): (usize, &EnergyField)| {
        // Nor do they know of grain and paint.
        let controls = prepared.controls(verdict.bodies[struck], strike);
        let learned = learned.filter(|_| controls.is_none_or(|warped| warped.alike));
        let (first_moment, gamma) = (verdict.first_moments[struck], verdict.gammas[struck]);
        if first_moment <= gamma {
            return DegreeGuess { sites: 1, capped: false, inferred: true, confidence: 1.0 };
        }
        let slenderness = &prepared.bodies[verdict.bodies[struck]].slenderness;
        let [estimate, evenness] = degree::closed_form_and_evenness(field, slenderness, gamma);
        let descriptor = || degree::descriptor(estimate, first_moment, evenness, gamma);
        let told = learned.map(|learned| learned.network.predict(&descriptor()));
        // Beyond their reach the examples decide nothing, but how far it is beyond says how much to trust the closed form.
        let confidence = told.as_ref().map_or(CONFIDENCE_CLOSED_FORM, |told| told.confidence);
        let told = told.filter(|told| told.within_reach);
        let wanted = told.map_or(prepared.kappa * estimate, |told| degree::sites(told.value, estimate));
        // There is room for the sites that stay, at least.
        let wanted = wanted.max(field.pins().len() as f64);
        let SiteCount { sites, capped } = degree::decide(first_moment, gamma, wanted, 1.0, strike.degree_max as usize);
        DegreeGuess { sites: sites as u32, capped, inferred: told.is_some(), confidence }
    };
    fields.iter().enumerate().map(guess).collect()
}

fn diagrams(
    strike: &FractureRequest,
    sites: &[u32],
    fields: &[EnergyField],
    workspace: &mut Workspace,
    token: &CancelToken,
    watch: &mut dyn StageObserver,
) -> Result<(Vec<BodyCells>, Option<Termination>), FractureError> {
    let (mut cells, mut ending) = (Vec::new(), None);
    for (struck, (&count, field)) in sites.iter().zip(fields).enumerate().filter(|(_, (count, _))| **count > 0) {
        watch.enter(Stage::Centroidal);
        let options = DiagramOptions {
            tolerance: strike.tolerance,
            iterations_max: strike.iterations_max,
            ..DiagramOptions::new(count as usize, strike.seed)
        };
        let (mut descent, mut diagram) = (ConvergenceMonitor::new(strike, count, watch), Diagram::default());
        centroidal::diagram_until(field, &options, &mut workspace.centroidal, &mut descent, token, &mut diagram)?;
        ending = ending.max(Some(descent.ending(&diagram)));
        watch.leave(Stage::Centroidal, diagram_bytes(&diagram));
        cells.push(BodyCells { struck, diagram });
    }
    Ok((cells, ending))
}

pub(super) fn diagram_bytes(diagram: &Diagram) -> u64 {
    (size_of_val(diagram.sites.as_slice()) + size_of_val(diagram.labels.as_slice())) as u64
}

/// `count` in whole parts proportional to `wishes` (largest remainders first, ties to the lower index). Where there are
/// fewer sites than bodies the smallest wishes get none.
fn shared_out(count: u32, wishes: &[f64]) -> Vec<u32> {
    let total: f64 = wishes.iter().sum();
    let exact: Vec<f64> = wishes.iter().map(|wish| f64::from(count) * wish / total).collect();
    let mut parts: Vec<u32> = exact.iter().map(|part| part.floor() as u32).collect();
    let mut order: Vec<usize> = (0..wishes.len()).collect();
    order.sort_by(|&a, &b| (exact[b] - exact[b].floor()).total_cmp(&(exact[a] - exact[a].floor())).then(a.cmp(&b)));
    let missing = count.saturating_sub(parts.iter().sum()) as usize;
    order.iter().cycle().take(missing).for_each(|&body| parts[body] += 1);
    parts
}

#[cfg(test)]
mod tests {
    use super::shared_out;

    #[test]
    fn sites_are_shared_out_without_loss() {
        assert_eq!(shared_out(50, &[1.0]), [50]);
        assert_eq!(shared_out(10, &[2.0, 1.0]), [7, 3]);
        assert_eq!(shared_out(1, &[0.2, 5.0]), [0, 1]);
        assert_eq!(shared_out(3, &[1.0, 1.0, 1.0, 1.0]).iter().sum::<u32>(), 3);
    }
}
