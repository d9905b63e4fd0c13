//! E_max(n), the largest cell energy of the best diagram of n sites, and the degree that follows from it.
//!
//! The smallest n whose diagram passes γ is noisy: one start passes and the next fails. The degree is therefore the
//! first n at which the running minimum of E_max passes. The numbers of sites and the starts do not depend on γ, so the
//! degree never decreases when γ does.

use super::criterion::{self, SiteCount};
use crate::cancel_token::{CancelToken, Canceled};
use crate::centroidal::{
    self, Diagram, DiagramOptions, DiagramWorkspace, EnergyField, ITERATIONS_MAX, StopCondition, TOLERANCE,
};

/// Sampling of a curve, independent of γ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveOptions {
    /// Largest number of sites; clamped to 1 ..= nodes.
    pub sites_max: usize,
    /// Starts per number of sites, of which the best counts; at least 1.
    pub starts: u32,
    /// Seed of all starts.
    pub seed: u64,
    /// Tolerance of the diagrams, as in [`DiagramOptions`].
    pub tolerance: f64,
    /// Largest number of iterations of the diagrams.
    pub iterations_max: usize,
}

impl Default for CurveOptions {
    fn default() -> Self {
        Self { sites_max: 512, starts: 2, seed: 0, tolerance: TOLERANCE, iterations_max: ITERATIONS_MAX }
    }
}

/// One point of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// Number of sites n.
    pub sites: usize,
    /// E_max(n), the smallest of its starts.
    pub energy_max: f64,
    /// E_max(n), the largest of its starts, which shows the scatter between starts.
    pub energy_max_worst: f64,
    /// Start with the smallest `energy_max`.
    pub start: u32,
    /// Smallest `energy_max` of all points up to this one.
    pub running_minimum: f64,
}

/// E_max(n) of one field, evaluated lazily by ascending n.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergyCurve {
    options: CurveOptions,
    sites_max: usize,
    points: Vec<CurvePoint>,
}

impl EnergyCurve {
    /// The curve of `field` with its first point, n = 1, whose energy is the first moment.
    pub fn new(field: &EnergyField, options: CurveOptions) -> Self {
        let energy = criterion::first_moment(field);
        let whole =
            CurvePoint { sites: 1, energy_max: energy, energy_max_worst: energy, start: 0, running_minimum: energy };
        Self { options, sites_max: options.sites_max.clamp(1, field.nodes()), points: vec![whole] }
    }

    /// The points so far, by ascending number of sites.
    pub fn points(&self) -> &[CurvePoint] {
        &self.points
    }

    /// Evaluates points until the running minimum passes `gamma` or the number of sites its maximum; with γ = 0, all
    /// points.
    ///
    /// `field` must be that of [`Self::new`].
    ///
    /// # Errors
    /// [`Canceled`] once the token is; the points so far stay.
    pub fn extend(
        &mut self,
        field: &EnergyField,
        gamma: f64,
        workspace: &mut DiagramWorkspace,
        token: &CancelToken,
    ) -> Result<(), Canceled> {
        self.extend_until(field, gamma, &mut &*token, workspace, &mut |_, _| ())
    }

    /// As [`Self::extend`], with callbacks.
    ///
    /// `show` receives the diagram of every start that is the best so far of its number of sites. `stop` observes every
    /// descent; once it has no time for another one, the points so far remain.
    ///
    /// # Errors
    /// As [`Self::extend`].
    pub fn extend_until(
        &mut self,
        field: &EnergyField,
        gamma: f64,
        stop: &mut dyn StopCondition,
        workspace: &mut DiagramWorkspace,
        show: &mut dyn FnMut(usize, &Diagram),
    ) -> Result<(), Canceled> {
        let mut diagram = Diagram::default();
        while let Some(last) = self.points.last().copied().filter(|last| last.running_minimum > gamma) {
            let Some(sites) = next_sites(last.sites, self.sites_max) else { break };
            let mut point = CurvePoint {
                sites,
                energy_max: f64::INFINITY,
                energy_max_worst: 0.0,
                start: 0,
                running_minimum: last.running_minimum,
            };
            for start in 0..self.options.starts.max(1) {
                let options = self.options.diagram(sites, start);
                centroidal::diagram_until(field, &options, workspace, stop, &mut diagram)?;
                if stop.is_out_of_time() {
                    return Ok(());
                }
                if point.record(start, diagram.energy_max()) {
                    show(sites, &diagram);
                }
            }
            self.points.push(point);
        }
        Ok(())
    }

    /// The degree at `gamma` from the points so far, and the start of its best diagram; the maximum if they do not
    /// pass.
    pub fn degree(&self, gamma: f64) -> (SiteCount, u32) {
        match self.points.iter().find(|point| point.running_minimum <= gamma) {
            Some(point) => (SiteCount { sites: point.sites, capped: false }, point.start),
            None => {
                let start = self.points.last().filter(|point| point.sites == self.sites_max).map_or(0, |p| p.start);
                (SiteCount { sites: self.sites_max, capped: true }, start)
            }
        }
    }
}

impl CurvePoint {
    /// Adds a start; returns true if it is the best so far.
    fn record(&mut self, start: u32, energy_max: f64) -> bool {
        let best = energy_max < self.energy_max;
        if best {
            (self.energy_max, self.start) = (energy_max, start);
        }
        self.energy_max_worst = self.energy_max_worst.max(energy_max);
        self.running_minimum = self.running_minimum.min(energy_max);
        best
    }
}

impl CurveOptions {
    /// The options of the diagram for one start and number of sites.
    pub(crate) fn diagram(&self, sites: usize, start: u32) -> DiagramOptions {
        let Self { seed, tolerance, iterations_max, .. } = *self;
        DiagramOptions { sites, seed, start, tolerance, iterations_max }
    }
}

/// The numbers of sites at which a curve is evaluated.
pub(super) fn grid(sites_max: usize) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(1), move |sites| next_sites(*sites, sites_max))
}

/// The number of sites after `sites`: every integer up to 16, then steps of a tenth, the maximum last.
fn next_sites(sites: usize, sites_max: usize) -> Option<usize> {
    let next = if sites < 16 { sites + 1 } else { sites + sites.div_ceil(10) };
    (sites < sites_max).then(|| next.min(sites_max))
}

/// Result of the full optimization.
#[derive(Clone, Debug, PartialEq)]
pub struct OptimizedDegree {
    /// The degree, from a grid of every integer up to 16 and steps of a tenth beyond.
    pub degree: SiteCount,
    /// The curve as far as it was evaluated.
    pub curve: EnergyCurve,
    /// The best diagram of that many sites.
    pub diagram: Diagram,
}

/// The fracture degree of `field` at γ = `gamma`, by evaluating diagrams until one passes; `None` if `stop` runs out of
/// time.
///
/// # Errors
/// [`Canceled`] once the token is.
pub fn optimize(
    field: &EnergyField,
    gamma: f64,
    options: CurveOptions,
    stop: &mut dyn StopCondition,
    workspace: &mut DiagramWorkspace,
) -> Result<Option<OptimizedDegree>, Canceled> {
    let mut curve = EnergyCurve::new(field, options);
    curve.extend_until(field, gamma, stop, workspace, &mut |_, _| ())?;
    if stop.is_out_of_time() {
        return Ok(None);
    }
    let ((degree, start), mut diagram) = (curve.degree(gamma), Diagram::default());
    centroidal::diagram_until(field, &options.diagram(degree.sites, start), workspace, stop, &mut diagram)?;
    Ok(Some(OptimizedDegree { degree, curve, diagram }))
}
