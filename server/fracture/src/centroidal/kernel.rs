//! Nearest sites, exactly: a tiled f32 sweep over all sites, and f64 wherever f32 cannot tell the nearest two apart.
//!
//! Based on: S. Lloyd, *Least squares quantization in PCM* (1982), the assignment step by brute force. With f_i(v) =
//! |p_i|² − 2 p_i·X_v the nearest site is argmin f_i; coordinates are centred and scaled to the unit ball, where
//! rounding f_i in f32 costs at most (m + 4)·u·(|p_i|² + 2|p_i|), u = 2⁻²⁴. Where the smallest two lie closer than twice
//! that, the node's distances are computed again in f64. So the labels are those of f64, ties to the lowest index.
//!
//! The same code is compiled twice, for the baseline and for AVX2 without fused multiply-add: equal bits from both.

use super::tiles::TILE;

/// Entries of a cell's sums before its first moment: mass, energy and two that stay 0.
pub(super) const CELL_HEAD: usize = LANES;

/// Rows of f64 are filled up with zeros to a multiple of this.
pub(super) const LANES: usize = 4;

/// Which compilation of the kernel runs. The AVX2 one cannot be made where the processor lacks it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path(Instructions);

#[derive(Clone, Copy, Debug)]
enum Instructions {
    Baseline,
    #[cfg(target_arch = "x86_64")]
    Avx2,
}

impl Path {
    /// Instructions that every machine of the target has.
    #[cfg(any(test, not(target_arch = "x86_64")))]
    pub fn baseline() -> Self {
        Self(Instructions::Baseline)
    }

    /// The widest that this machine has.
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            return Self(Instructions::Avx2);
        }
        Self(Instructions::Baseline)
    }
}

/// Sites as the kernel reads them.
pub(super) struct Sites<'a> {
    /// m.
    pub dimension: usize,
    /// m filled up to a multiple of [`LANES`].
    pub stride: usize,
    /// p_i, site-major, lifted coordinates; `stride` per site.
    pub exact: &'a [f64],
    /// |p_i|² and −2 p_i, centred and scaled, m + 1 per site.
    pub rounded: &'a [f32],
    /// Smallest difference of two rounded f_i that proves which is smaller.
    pub resolution: f32,
}

/// Consecutive nodes, starting with a tile.
pub(super) struct Chunk<'a> {
    /// Their tiles.
    pub tiles: &'a [f32],
    /// X_v, node-major; `stride` per node.
    pub rows: &'a [f64],
    /// w_v.
    pub mass: &'a [f64],
    /// Out: nearest site.
    pub labels: &'a mut [u32],
    /// Out, added to: per site Σw, Σw|X − p|² and, after [`CELL_HEAD`], Σw(X − p); [`CELL_HEAD`] + `stride` per site.
    pub cells: &'a mut [f64],
}

/// Labels the nodes of a chunk and adds up their cells.
pub(super) fn assign(path: Path, sites: &Sites, chunk: Chunk) {
    match path.0 {
        Instructions::Baseline => assign_portable(sites, chunk),
        // SAFETY: `Instructions::Avx2` is made by `Path::detect` alone, after the processor said that it has AVX2.
        #[cfg(target_arch = "x86_64")]
        Instructions::Avx2 => unsafe { assign_avx2(sites, chunk) },
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn assign_avx2(sites: &Sites, chunk: Chunk) {
    assign_portable(sites, chunk);
}

#[inline(always)]
fn assign_portable(sites: &Sites, chunk: Chunk) {
    let (m, stride) = (sites.dimension, sites.stride);
    for (tile, lanes) in chunk.tiles.chunks_exact(m * TILE).enumerate() {
        let nearest = nearest(sites, lanes);
        let first = tile * TILE;
        for node in first..(first + TILE).min(chunk.labels.len()) {
            let row = &chunk.rows[node * stride..][..stride];
            let lane = node - first;
            let clear = nearest.second[lane] - nearest.best[lane] > sites.resolution;
            let label = if clear { nearest.site[lane] } else { nearest_exact(sites, row) };
            chunk.labels[node] = label;
            let site = &sites.exact[label as usize * stride..][..stride];
            let cell = &mut chunk.cells[label as usize * (stride + CELL_HEAD)..][..stride + CELL_HEAD];
            accumulate(row, site, chunk.mass[node], cell);
        }
    }
}

/// The smallest and second smallest f_i of a tile's nodes, and the site of the smallest.
struct Nearest {
    best: [f32; TILE],
    second: [f32; TILE],
    site: [u32; TILE],
}

#[inline(always)]
fn nearest(sites: &Sites, lanes: &[f32]) -> Nearest {
    let mut nearest = Nearest { best: [f32::INFINITY; TILE], second: [f32::INFINITY; TILE], site: [0; TILE] };
    let (rows, _) = lanes.as_chunks::<TILE>();
    for (site, terms) in sites.rounded.chunks_exact(sites.dimension + 1).enumerate() {
        let mut value = [terms[0]; TILE];
        for (row, &factor) in rows.iter().zip(&terms[1..]) {
            for (value, x) in value.iter_mut().zip(row) {
                *value += factor * x;
            }
        }
        nearest = nearest.with(site as u32, &value);
    }
    nearest
}

impl Nearest {
    /// After one more site. Every lane is computed and written, chosen by value: branches here would become masked
    /// stores, which are slow.
    #[inline(always)]
    fn with(&self, site: u32, value: &[f32; TILE]) -> Self {
        let mut next = Self { best: [0.0; TILE], second: [0.0; TILE], site: [0; TILE] };
        for (lane, &new) in value.iter().enumerate() {
            let (best, second) = (self.best[lane], self.second[lane]);
            let loser = if new < best { best } else { new };
            next.second[lane] = if loser < second { loser } else { second };
            next.best[lane] = if new < best { new } else { best };
            next.site[lane] = if new < best { site } else { self.site[lane] };
        }
        next
    }
}

/// argmin |X − p_i|² in f64, ties to the lowest index.
#[inline(always)]
fn nearest_exact(sites: &Sites, row: &[f64]) -> u32 {
    let (mut best, mut label) = (f64::INFINITY, 0);
    for (site, position) in sites.exact.chunks_exact(sites.stride).enumerate() {
        let distance = square_distance(row, position);
        if distance < best {
            (best, label) = (distance, site as u32);
        }
    }
    label
}

/// |a − b|², summed in [`LANES`] interleaved parts so that it vectorises in a fixed order; zeros at the end of both do not
/// change a bit.
#[inline(always)]
pub(super) fn square_distance(a: &[f64], b: &[f64]) -> f64 {
    let mut parts = [0.0; LANES];
    let (a, a_rest) = a.as_chunks::<LANES>();
    let (b, b_rest) = b.as_chunks::<LANES>();
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            let offset = a[lane] - b[lane];
            parts[lane] += offset * offset;
        }
    }
    for ((part, a), b) in parts.iter_mut().zip(a_rest).zip(b_rest) {
        *part += (a - b) * (a - b);
    }
    (parts[0] + parts[1]) + (parts[2] + parts[3])
}

/// Adds a node to its cell.
#[inline(always)]
fn accumulate(row: &[f64], site: &[f64], mass: f64, cell: &mut [f64]) {
    let (cell, _) = cell.as_chunks_mut::<LANES>();
    let Some((head, moments)) = cell.split_first_mut() else { return };
    let mut parts = [0.0; LANES];
    let (rows, _) = row.as_chunks::<LANES>();
    let (sites, _) = site.as_chunks::<LANES>();
    for ((row, site), moment) in rows.iter().zip(sites).zip(moments) {
        let mut sum = *moment;
        for lane in 0..LANES {
            let offset = row[lane] - site[lane];
            sum[lane] += mass * offset;
            parts[lane] += offset * offset;
        }
        *moment = sum;
    }
    head[0] += mass;
    head[1] += mass * ((parts[0] + parts[1]) + (parts[2] + parts[3]));
}
