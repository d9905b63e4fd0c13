//! Cells of the elastic lattice across walls, and the order of the elements that follows.
//!
//! Linear tetrahedra store too little energy where a wall bends: 35 % with 1.5 cells across it, 5 to 9 % with 3, 3 to 6 % with
//! 4.1.

use crate::cancel_token::{CancelToken, Canceled};
use crate::elasticity::ElementOrder;
use crate::lattice::{LatticeLevels, Locator};
use crate::pipeline::{CELLS_LINEAR_MIN, CELLS_MAX, ElasticReport, ElementChoice};
use crate::surface::{InsideTest, Width, WidthSide, Widths};

/// Share of a body's surface with the walls that count: those of a quarter of it are no thicker.
const SHARE: f64 = 0.25;

/// Thickness of an object's walls, up to [`CELLS_MAX`] elastic spacings.
pub(super) struct Cells {
    walls: Widths,
    /// Largest measured thickness, local.
    limit: f64,
}

impl Cells {
    /// Measures the walls for an elastic lattice of this spacing (local).
    ///
    /// # Errors
    /// Canceled.
    pub(super) fn measure(inside: &InsideTest, spacing: f64, token: &CancelToken) -> Result<Self, Canceled> {
        let limit = CELLS_MAX * spacing;
        Ok(Self { walls: inside.widths(WidthSide::Wall, limit, token)?, limit })
    }

    /// True if elements on a lattice of this spacing will be quadratic, by the object as a whole.
    pub(super) fn are_few(&self, choice: ElementChoice, spacing: f64) -> bool {
        match choice {
            ElementChoice::Auto => self.walls.quantile(SHARE) < CELLS_LINEAR_MIN * spacing,
            ElementChoice::Linear => false,
            ElementChoice::Quadratic => true,
        }
    }

    /// The elements of every body.
    pub(super) fn elastic(&self, choice: ElementChoice, levels: &LatticeLevels) -> Vec<ElasticReport> {
        let locators: Vec<Locator> = levels.bodies.iter().map(|body| Locator::new(&body.crack)).collect();
        let owner =
            |sample: &Width| locators.iter().position(|locator| locator.containing(&sample.middle, None).is_some());
        let owners: Vec<Option<usize>> = self.walls.samples.iter().map(owner).collect();
        let one = |body: usize| {
            let is_replaced = levels.replaced.iter().any(|replaced| replaced.body == body);
            let elastic = levels.elastic.as_ref().filter(|_| !is_replaced).map(|level| level.spacing);
            let samples = self.walls.samples.iter().zip(&owners).filter(|(_, owner)| **owner == Some(body));
            let walls = Widths { samples: samples.map(|(sample, _)| *sample).collect() };
            let width = walls.quantile(SHARE).min(self.limit);
            let cells = (width / elastic.unwrap_or(levels.crack.spacing)).min(CELLS_MAX);
            elements(choice, cells)
        };
        (0..levels.bodies.len()).map(one).collect()
    }
}

/// The elements of a body with this number of cells across its walls.
fn elements(choice: ElementChoice, elements_across: f64) -> ElasticReport {
    let (order, reason) = match choice {
        ElementChoice::Linear => (ElementOrder::Linear, None),
        ElementChoice::Auto if elements_across >= CELLS_LINEAR_MIN => (ElementOrder::Linear, None),
        ElementChoice::Quadratic => (ElementOrder::Quadratic, Some("asked for".to_owned())),
        ElementChoice::Auto => {
            let reason = format!("fewer than {CELLS_LINEAR_MIN} cells across the walls");
            (ElementOrder::Quadratic, Some(reason))
        }
    };
    ElasticReport { order, elements_across, reason, discretization_error: None, linear_error: None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_cells_across_walls_make_quadratic_elements() {
        let order = |choice, cells| {
            let own = elements(choice, cells);
            (own.order, own.reason.is_some())
        };
        let (linear, quadratic) = (ElementOrder::Linear, ElementOrder::Quadratic);
        assert_eq!(order(ElementChoice::Auto, 4.99), (quadratic, true));
        assert_eq!(order(ElementChoice::Auto, 5.0), (linear, false));
        assert_eq!(order(ElementChoice::Linear, 1.5), (linear, false));
        assert_eq!(order(ElementChoice::Linear, 8.0), (linear, false));
        assert_eq!(order(ElementChoice::Quadratic, 8.0), (quadratic, true));
    }
}
