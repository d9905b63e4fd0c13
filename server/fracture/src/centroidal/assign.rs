//! One assignment of all nodes, in parallel: fixed chunks, merged in their order, so that the sums have the same bits for
//! any number of threads.

use super::Field;
use super::kernel::{self, CELL_HEAD, Chunk, Path};
use super::tiles::{TILE, Tiles};
use rayon::prelude::*;

/// Chunks hold at least this many nodes, a multiple of [`TILE`].
const CHUNK_MIN: usize = 64 * TILE;

/// There are at most this many chunks, for their sums are merged one after the other.
const CHUNKS_MAX: usize = 32;

/// What an assignment needs beside the field; reused from call to call.
#[derive(Clone, Debug)]
pub(super) struct Scratch {
    path: Path,
    tiles: Tiles,
    rounded: Vec<f32>,
    partial: Vec<f64>,
}

impl Default for Scratch {
    fn default() -> Self {
        Self::with_path(Path::detect())
    }
}

/// Sites, and what the nodes make of them.
#[derive(Clone, Debug, Default)]
pub(super) struct State {
    /// p_i, site-major, m each.
    pub sites: Vec<f64>,
    /// Nearest site per node.
    pub labels: Vec<u32>,
    /// Per site Σw, Σw|X − p|², Σw(X − p); m + 2 each.
    pub cells: Vec<f64>,
    /// F = Σ of the cells' energies.
    pub energy: f64,
}

impl State {
    /// Sums of site `site`: mass, energy, first moment about the site.
    pub fn cell(&self, site: usize, dimension: usize) -> (f64, f64, &[f64]) {
        let cell = &self.cells[site * (dimension + CELL_HEAD)..][..dimension + CELL_HEAD];
        (cell[0], cell[1], &cell[CELL_HEAD..])
    }
}

impl Scratch {
    /// Scratch for one compilation of the kernel.
    pub fn with_path(path: Path) -> Self {
        Self { path, tiles: Tiles::default(), rounded: Vec::new(), partial: Vec::new() }
    }

    /// Takes up the coordinates of `field`; before the first [`Self::assign`] on it.
    pub fn load(&mut self, field: &Field) {
        self.tiles.load(field);
    }

    /// Labels, cells and energy of `state.sites`.
    pub fn assign(&mut self, field: &Field, state: &mut State) {
        let (m, nodes) = (field.dimension(), field.nodes());
        let entries = state.sites.len() / m * (m + CELL_HEAD);
        let chunk = nodes.div_ceil(CHUNKS_MAX).next_multiple_of(TILE).max(CHUNK_MIN);
        self.partial.clear();
        self.partial.resize(nodes.div_ceil(chunk) * entries, 0.0);
        state.labels.resize(nodes, 0);
        let sites = self.tiles.round(&state.sites, &mut self.rounded);
        let path = self.path;
        (state.labels.par_chunks_mut(chunk), self.partial.par_chunks_mut(entries))
            .into_par_iter()
            .zip(self.tiles.lanes().par_chunks(chunk * m))
            .zip(field.lift().coordinates.par_chunks(chunk * m))
            .zip(field.mass().par_chunks(chunk))
            .for_each(|((((labels, cells), tiles), coordinates), mass)| {
                kernel::assign(path, &sites, Chunk { tiles, coordinates, mass, labels, cells });
            });
        merge(&self.partial, entries, state);
        state.energy = state.cells.chunks_exact(m + CELL_HEAD).map(|cell| cell[1]).sum();
    }
}

/// Adds the chunks' cells in their order.
fn merge(partial: &[f64], entries: usize, state: &mut State) {
    state.cells.clear();
    state.cells.resize(entries, 0.0);
    for chunk in partial.chunks_exact(entries) {
        state.cells.iter_mut().zip(chunk).for_each(|(sum, part)| *sum += part);
    }
}
