//! Parallel assignment of all points of a level to their nearest sites.
//!
//! Points are split into fixed chunks that are merged in order, so the sums have the same
//! bits for any number of threads.

use super::kernel::{self, CELL_HEAD, Chunk, KernelPath, KernelSites, WIDTH};
use super::level::{PointLevel, TILE};
use super::vector::LANES;

/// Smallest number of groups per chunk, a multiple of [`TILE`].
const CHUNK_MIN: usize = 8 * TILE;

/// Largest number of chunks, because their sums are merged one after the other.
const CHUNKS_MAX: usize = 32;

/// Multiplications, about a twentieth of a millisecond, below which waking another thread costs more than it saves.
const SPLIT_MIN: usize = 1 << 18;

/// Working memory of assignments, reused between calls.
#[derive(Clone, Debug)]
pub(super) struct AssignScratch {
    path: KernelPath,
    rounded: Vec<f32>,
    partial: Vec<f64>,
    values: Vec<f32>,
    rivals: Vec<u32>,
    lined_up: Vec<f64>,
}

impl Default for AssignScratch {
    fn default() -> Self {
        Self::with_path(KernelPath::detect())
    }
}

/// Sites, and the assignment of a level's points to them.
#[derive(Clone, Debug, Default)]
pub(super) struct AssignState {
    /// Entries per site in `sites`: m, padded to a multiple of [`LANES`].
    pub stride: usize,
    /// Sites p_i, site-major, padded with zeros.
    pub sites: Vec<f64>,
    /// Nearest site of each point, in the level's order.
    pub labels: Vec<u32>,
    /// Sums of [`Chunk::cells`] per site.
    pub cells: Vec<f64>,
    /// Energy F: the sum over the cells, and the constant [`PointLevel::base`].
    pub energy: f64,
}

impl AssignState {
    /// Replaces the sites by `sites`, site-major, `dimension` each.
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

    /// Site p_i, padded with zeros.
    pub fn site(&self, site: usize) -> &[f64] {
        &self.sites[site * self.stride..][..self.stride]
    }

    /// Sums of site `site`: mass, energy, and first moment about the site.
    pub fn cell(&self, site: usize) -> (f64, f64, &[f64]) {
        let cell = &self.cells[site * (self.stride + CELL_HEAD)..][..self.stride + CELL_HEAD];
        (cell[0], cell[1], &cell[CELL_HEAD..])
    }
}

impl AssignScratch {
    /// Creates scratch memory for one compilation of the kernel.
    pub fn with_path(path: KernelPath) -> Self {
        Self {
            path,
            rounded: Vec::new(),
            partial: Vec::new(),
            values: Vec::new(),
            rivals: Vec::new(),
            lined_up: Vec::new(),
        }
    }

    /// Computes labels, cells and energy of `state.sites`.
    pub fn assign(&mut self, level: &PointLevel, state: &mut AssignState) {
        let (groups, count) = (level.groups(), state.count());
        let entries = count * (state.stride + CELL_HEAD);
        let chunk = groups.div_ceil(CHUNKS_MAX).next_multiple_of(TILE).max(CHUNK_MIN);
        let chunks = groups.div_ceil(chunk);
        self.partial.clear();
        self.partial.resize(chunks * entries, 0.0);
        self.values.resize(chunks * count * TILE, 0.0);
        self.rivals.resize(chunks * count, 0);
        let padded_length = count.next_multiple_of(WIDTH) * state.stride;
        self.lined_up.resize(chunks * padded_length, 0.0);
        state.labels.resize(level.points(), 0);
        let sites = level.round(&state.sites, &mut self.rounded);
        let sweep = Sweep { path: self.path, level, sites, chunk, entries, count, padded_length };
        let (partial, values) = (&mut self.partial, &mut self.values[..chunks * count * TILE]);
        let (rivals, lined_up) = (&mut self.rivals[..chunks * count], &mut self.lined_up[..chunks * padded_length]);
        let parts = Parts { labels: &mut state.labels, partial, values, rivals, lined_up };
        sweep.run(0, parts);
        merge(&self.partial, entries, state);
        state.energy = level.base + (0..count).map(|site| state.cell(site).1).sum::<f64>();
    }
}

/// One pass over all chunks.
struct Sweep<'a> {
    path: KernelPath,
    level: &'a PointLevel,
    sites: KernelSites<'a>,
    /// Groups per chunk.
    chunk: usize,
    /// Sums per chunk.
    entries: usize,
    /// Number of sites.
    count: usize,
    /// Entries of the transposed sites of a chunk.
    padded_length: usize,
}

/// Output slices of consecutive chunks.
struct Parts<'a> {
    labels: &'a mut [u32],
    partial: &'a mut [f64],
    values: &'a mut [f32],
    rivals: &'a mut [u32],
    lined_up: &'a mut [f64],
}

impl Sweep<'_> {
    /// Runs the chunks from number `first` on that `parts` has memory for, in parallel halves while that pays.
    fn run(&self, first: usize, parts: Parts<'_>) {
        let chunks = parts.partial.len() / self.entries;
        if chunks <= 1 {
            return self.chunk(first, parts);
        }
        let half = chunks / 2;
        let (labels, labels_rest) = parts.labels.split_at_mut(self.first_node(first + half) - self.first_node(first));
        let (partial, partial_rest) = parts.partial.split_at_mut(half * self.entries);
        let (values, values_rest) = parts.values.split_at_mut(half * self.count * TILE);
        let (rivals, rivals_rest) = parts.rivals.split_at_mut(half * self.count);
        let (lined_up, lined_up_rest) = parts.lined_up.split_at_mut(half * self.padded_length);
        let left = Parts { labels, partial, values, rivals, lined_up };
        let right = Parts {
            labels: labels_rest,
            partial: partial_rest,
            values: values_rest,
            rivals: rivals_rest,
            lined_up: lined_up_rest,
        };
        if chunks * self.chunk * self.entries >= SPLIT_MIN {
            rayon::join(|| self.run(first, left), || self.run(first + half, right));
        } else {
            self.run(first, left);
            self.run(first + half, right);
        }
    }

    /// Index of the first point of chunk `index`.
    fn first_node(&self, index: usize) -> usize {
        self.level.offsets[(index * self.chunk).min(self.level.groups())] as usize
    }

    fn chunk(&self, index: usize, parts: Parts<'_>) {
        let (level, stride) = (self.level, self.sites.stride);
        let groups = index * self.chunk..((index + 1) * self.chunk).min(level.groups());
        let points = self.first_node(index)..self.first_node(index + 1);
        let lane = |group: usize| group * self.sites.dimension;
        let chunk = Chunk {
            lanes: &level.lanes[lane(groups.start)..lane(groups.end.next_multiple_of(TILE))],
            squares: &level.squares[groups.clone()],
            radii: &level.radii[groups.clone()],
            centers: &level.centers[groups.start * stride..groups.end * stride],
            masses: &level.masses[groups.clone()],
            inner: &level.inner[groups.clone()],
            offsets: &level.offsets[groups.start..=groups.end],
            rows: &level.rows[points.start * stride..points.end * stride],
            mass: &level.mass[points],
            labels: parts.labels,
            cells: parts.partial,
            values: parts.values,
            rivals: parts.rivals,
            lined_up: parts.lined_up,
        };
        kernel::assign(self.path, &self.sites, chunk);
    }
}

/// Adds the chunks' cells in order.
fn merge(partial: &[f64], entries: usize, state: &mut AssignState) {
    state.cells.clear();
    state.cells.resize(entries, 0.0);
    for chunk in partial.chunks_exact(entries) {
        state.cells.iter_mut().zip(chunk).for_each(|(sum, part)| *sum += part);
    }
}
