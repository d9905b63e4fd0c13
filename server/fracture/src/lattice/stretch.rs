//! Stretched lattices of thin sheets: cells that are longer along the sheet than across it.

use super::{Lattice, LatticeLevels};
use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

/// Stretch of the space in which a lattice is regular: lengths along an axis are multiplied by a factor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LatticeStretch {
    /// Direction across the sheet, of unit length.
    pub axis: [f64; 3],
    /// Factor, above 1: length of a cell along the sheet over its length across it.
    pub factor: f64,
}

impl LatticeStretch {
    /// Moves a point of the object to where its lattice is regular.
    pub fn apply(&self, point: &mut Point3<f64>) {
        self.scale(self.factor, point);
    }

    /// Moves a point of the regular lattice to where it lies in the object.
    fn revert(&self, point: &mut Point3<f64>) {
        self.scale(1.0 / self.factor, point);
    }

    fn scale(&self, factor: f64, point: &mut Point3<f64>) {
        let axis = Vector3::from(self.axis);
        *point += axis * (axis.dot(&point.coords) * (factor - 1.0));
    }

    /// Returns the lattice as it is where it is regular.
    #[must_use]
    pub fn regular(&self, lattice: &Lattice) -> Lattice {
        let mut regular = lattice.clone();
        regular.nodes.iter_mut().for_each(|node| self.apply(node));
        regular
    }

    /// Moves regular lattices, and all that is reported of them, to where they lie in the object.
    ///
    /// Volumes shrink by the factor. Energy transfers remain, because shares of volumes do.
    pub fn revert_levels(&self, levels: &mut LatticeLevels) {
        for body in &mut levels.bodies {
            let nodes = body.elastic.nodes.iter_mut().chain(&mut body.crack.nodes);
            nodes.for_each(|node| self.revert(node));
        }
        levels.far.iter_mut().for_each(|node| self.revert(node));
        levels.unmatched_volume /= self.factor;
        for report in levels.elastic.iter_mut().chain([&mut levels.crack]) {
            report.volume /= self.factor;
            report.mended_volume /= self.factor;
        }
    }
}
