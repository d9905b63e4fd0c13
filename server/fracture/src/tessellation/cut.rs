//! Simplices of one dimension with crack points, and the points.

use super::index_selection::IndexSet;
use nalgebra::Point3;
use rayon::prelude::*;

/// Marks a simplex without a crack point.
pub(super) const NONE: u32 = u32::MAX;

/// Smallest number of points per parallel task.
pub(super) const GRAIN: usize = 256;

/// Cut simplices of one dimension, in ascending order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct CutSimplices {
    /// Simplices with a crack point, ascending.
    pub simplices: Vec<u32>,
    /// Index into `simplices` by simplex, or [`NONE`].
    pub slots: Vec<u32>,
    /// Crack point of each cut simplex, local.
    pub places: Vec<Point3<f64>>,
}

impl CutSimplices {
    /// Removes all points, for a lattice with `count` simplices.
    fn clear(&mut self, count: usize) {
        if self.slots.len() == count {
            self.simplices.iter().for_each(|simplex| self.slots[*simplex as usize] = NONE);
        } else {
            self.slots.clear();
            self.slots.resize(count, NONE);
        }
        self.simplices.clear();
    }

    /// Marks those of `among`, ascending, that are `wanted` as cut, in a lattice with `count` simplices.
    pub fn choose_of(&mut self, count: usize, among: &[u32], wanted: impl Fn(u32) -> bool) {
        self.clear(count);
        self.simplices.extend(among.iter().filter(|simplex| wanted(**simplex)));
        self.number();
    }

    /// Marks those of `count` simplices that are `wanted` as cut.
    pub fn choose(&mut self, count: usize, chosen: &mut IndexSet, wanted: impl Fn(usize) -> bool + Sync) {
        self.clear(count);
        chosen.choose(count, &mut self.simplices, wanted);
        self.number();
    }

    /// Marks those of `count` simplices whose bits are set in `marks`, 64 per word, as cut.
    pub fn take_marked(&mut self, count: usize, marks: &[u64]) {
        self.clear(count);
        for (word, bits) in marks.iter().enumerate() {
            let mut left = *bits;
            while left != 0 {
                self.simplices.push(64 * word as u32 + left.trailing_zeros());
                left &= left - 1;
            }
        }
        self.number();
    }

    /// Fills `slots` from `simplices`.
    fn number(&mut self) {
        for (slot, simplex) in self.simplices.iter().enumerate() {
            self.slots[*simplex as usize] = slot as u32;
        }
    }

    /// Computes the points.
    pub fn locate(&mut self, place: impl Fn(usize) -> Point3<f64> + Sync) {
        self.locate_in_chunks(&|_, simplices, out| {
            simplices.iter().zip(out).for_each(|(&simplex, point)| *point = place(simplex as usize));
        });
    }

    /// Computes the points in chunks. `place` receives the index of a chunk's first simplex in `simplices`, the chunk,
    /// and its points.
    pub fn locate_in_chunks(&mut self, place: &(impl Fn(usize, &[u32], &mut [Point3<f64>]) + Sync)) {
        self.places.resize(self.simplices.len(), Point3::origin());
        let chunks = self.places.par_chunks_mut(GRAIN).zip(self.simplices.par_chunks(GRAIN)).enumerate();
        chunks.for_each(|(chunk, (out, simplices))| place(chunk * GRAIN, simplices, out));
    }

    /// Replaces points by fixed ones. The error is the index of a simplex out of range or of a point that is not
    /// finite.
    pub fn fix(&mut self, fixed: &[(u32, Point3<f64>)]) -> Result<(), u32> {
        for &(simplex, place) in fixed {
            let slot = *self.slots.get(simplex as usize).ok_or(simplex)?;
            if !place.coords.iter().all(|x| x.is_finite()) {
                return Err(simplex);
            }
            if slot != NONE {
                self.places[slot as usize] = place;
            }
        }
        Ok(())
    }

    /// The points with their simplices.
    pub fn fixed(&self) -> Vec<(u32, Point3<f64>)> {
        self.simplices.iter().copied().zip(self.places.iter().copied()).collect()
    }
}
