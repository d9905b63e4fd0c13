//! One assignment of all nodes, in parallel: fixed chunks, merged in their order, so that the sums have the same bits for
//! any number of threads.

use super::Field;
use super::kernel::{self, CELL_HEAD, Chunk, LANES, Path, Sites};
use super::tiles::{TILE, Tiles};

/// Chunks hold at least this many nodes, a multiple of [`TILE`].
const CHUNK_MIN: usize = 64 * TILE;

/// There are at most this many chunks, for their sums are merged one after the other.
const CHUNKS_MAX: usize = 32;

/// Multiplications, about a twentieth of a millisecond, below which waking another thread costs more than it saves.
const SPLIT_MIN: usize = 1 << 20;

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
    /// Entries per site in `sites`: m filled up with zeros.
    pub stride: usize,
    /// p_i, site-major.
    pub sites: Vec<f64>,
    /// Nearest site per node.
    pub labels: Vec<u32>,
    /// Per site the sums of [`Chunk::cells`].
    pub cells: Vec<f64>,
    /// F = Σ of the cells' energies.
    pub energy: f64,
}

impl State {
    /// Takes up `sites`, site-major, `dimension` each.
    pub fn set_sites(&mut self, sites: &[f64], dimension: usize) {
        self.stride = dimension.next_multiple_of(LANES);
        self.sites.clear();
        for site in sites.chunks_exact(dimension) {
            self.sites.extend_from_slice(site);
            self.sites.resize(self.sites.len().next_multiple_of(self.stride), 0.0);
        }
    }

    /// Number of sites.
    pub fn count(&self) -> usize {
        self.sites.len() / self.stride
    }

    /// p_i with its zeros.
    pub fn site(&self, site: usize) -> &[f64] {
        &self.sites[site * self.stride..][..self.stride]
    }

    /// Sums of site `site`: mass, energy, first moment about the site.
    pub fn cell(&self, site: usize) -> (f64, f64, &[f64]) {
        let cell = &self.cells[site * (self.stride + CELL_HEAD)..][..self.stride + CELL_HEAD];
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
        let nodes = field.nodes();
        let entries = state.count() * (state.stride + CELL_HEAD);
        let chunk = nodes.div_ceil(CHUNKS_MAX).next_multiple_of(TILE).max(CHUNK_MIN);
        self.partial.clear();
        self.partial.resize(nodes.div_ceil(chunk) * entries, 0.0);
        state.labels.resize(nodes, 0);
        let sites = self.tiles.round(&state.sites, &mut self.rounded);
        let sweep = Sweep { path: self.path, field, sites, tiles: &self.tiles, chunk, entries };
        sweep.run(0, &mut state.labels, &mut self.partial);
        merge(&self.partial, entries, state);
        state.energy = (0..state.count()).map(|site| state.cell(site).1).sum();
    }
}

/// One pass over all chunks.
struct Sweep<'a> {
    path: Path,
    field: &'a Field<'a>,
    sites: Sites<'a>,
    tiles: &'a Tiles,
    /// Nodes per chunk.
    chunk: usize,
    /// Sums per chunk.
    entries: usize,
}

impl Sweep<'_> {
    /// Chunks from number `first` on, as many as `partial` has room for; halves of them in parallel while that pays.
    fn run(&self, first: usize, labels: &mut [u32], partial: &mut [f64]) {
        let chunks = partial.len() / self.entries;
        if chunks > 1 && labels.len() * self.entries >= SPLIT_MIN {
            let half = chunks / 2;
            let (labels, labels_rest) = labels.split_at_mut(half * self.chunk);
            let (partial, partial_rest) = partial.split_at_mut(half * self.entries);
            rayon::join(|| self.run(first, labels, partial), || self.run(first + half, labels_rest, partial_rest));
        } else {
            let parts = labels.chunks_mut(self.chunk).zip(partial.chunks_exact_mut(self.entries));
            parts.enumerate().for_each(|(index, (labels, cells))| self.chunk(first + index, labels, cells));
        }
    }

    fn chunk(&self, index: usize, labels: &mut [u32], cells: &mut [f64]) {
        let (m, stride, first, count) = (self.field.dimension(), self.sites.stride, index * self.chunk, labels.len());
        let chunk = Chunk {
            tiles: &self.tiles.lanes()[first * m..][..count.next_multiple_of(TILE) * m],
            rows: &self.tiles.rows()[first * stride..][..count * stride],
            mass: &self.field.mass()[first..][..count],
            labels,
            cells,
        };
        kernel::assign(self.path, &self.sites, chunk);
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
