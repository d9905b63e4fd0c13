//! Kernel that finds nearest sites exactly.
//!
//! Points are in groups. A tiled f32 sweep compares all sites with the centers of the groups. If more than one site
//! can be nearest to a point of a group, the points of that group are labeled in f64.
//!
//! Based on: S. Lloyd, *Least squares quantization in PCM* (1982), the assignment step; C. Elkan, *Using the triangle
//! inequality to accelerate k-means* (ICML 2003), for the pruning. With d the distance of a center from its nearest
//! site and r the group's radius, a site farther from the center than d + 2r is nearest to no point.
//!
//! With f_i(v) = |p_i|² − 2 p_i·X_v, distances are √(f_i + |X_v|²). Coordinates are centered and scaled to the unit
//! ball. There the rounding error of f_i in f32 is at most (m + 4)·u·(|p_i|² + 2|p_i|), u = 2⁻²⁴. Pruning keeps twice
//! that margin. For any groups, the labels are therefore those of f64, with ties to the lowest index. A group with
//! one remaining site is added as a whole.
//!
//! The same code is compiled for the baseline, for AVX2 and for AVX-512, without fused multiply-add. All three
//! compute equal bits.

use super::level::TILE;
use super::vector::{LANES, square_distance};

/// Entries of a cell's sums before its first moment: mass, energy, and two that stay 0.
pub(super) const CELL_HEAD: usize = LANES;

/// Number of sites that are compared in parallel in f64.
pub(super) const WIDTH: usize = 4;

/// Compilation of the kernel that runs. It can be created only if the processor supports it.
#[derive(Clone, Copy, Debug)]
pub(super) struct KernelPath(Instructions);

#[derive(Clone, Copy, Debug)]
enum Instructions {
    Baseline,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl KernelPath {
    /// Instructions that every machine of the target has.
    #[cfg(any(test, not(target_arch = "x86_64")))]
    pub fn baseline() -> Self {
        Self(Instructions::Baseline)
    }

    /// The widest instructions that this machine has.
    pub fn detect() -> Self {
        Self::all().pop().unwrap_or(Self(Instructions::Baseline))
    }

    /// All compilations that this machine can run, the widest last.
    pub fn all() -> Vec<Self> {
        let mut all = vec![Self(Instructions::Baseline)];
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            all.push(Self(Instructions::Avx2));
            if std::arch::is_x86_feature_detected!("avx512f") {
                all.push(Self(Instructions::Avx512));
            }
        }
        all
    }
}

/// Sites in the layout of the kernel.
pub(super) struct KernelSites<'a> {
    /// Dimension m.
    pub dimension: usize,
    /// m, padded to a multiple of [`LANES`].
    pub stride: usize,
    /// Sites p_i, site-major, lifted coordinates; `stride` per site.
    pub exact: &'a [f64],
    /// |p_i|² and −2 p_i, centered and scaled; m + 1 per site.
    pub rounded: &'a [f32],
    /// Twice the largest rounding error of a rounded f_i or |center|².
    pub resolution: f64,
}

/// Consecutive groups, starting with a tile, and their points.
pub(super) struct Chunk<'a> {
    /// Tiles of the centers.
    pub lanes: &'a [f32],
    /// |center|², centered and scaled.
    pub squares: &'a [f32],
    /// Radius of each group: distance of its farthest point from its center, scaled.
    pub radii: &'a [f32],
    /// Centers of the groups; `stride` per group.
    pub centers: &'a [f64],
    /// Mass w of each group.
    pub masses: &'a [f64],
    /// Inner energy Σ w|X − center|² of each group.
    pub inner: &'a [f64],
    /// Start of each group among the points of the level, and the end of the last.
    pub offsets: &'a [u32],
    /// Coordinates X of the points; `stride` per point.
    pub rows: &'a [f64],
    /// Mass w of each point.
    pub mass: &'a [f64],
    /// Output: nearest site of each point.
    pub labels: &'a mut [u32],
    /// Output, added to: per site Σw, Σw|X − p|² and, after [`CELL_HEAD`], Σw(X − p);
    /// [`CELL_HEAD`] + `stride` per site.
    pub cells: &'a mut [f64],
    /// Scratch: f_i of a tile, [`TILE`] per site.
    pub values: &'a mut [f32],
    /// Scratch: sites that may be nearest to a point of one group; one entry per site.
    pub rivals: &'a mut [u32],
    /// Scratch: their coordinates, transposed in blocks of [`WIDTH`]; `stride` per site, padded
    /// by up to [`WIDTH`] − 1 sites.
    pub lined_up: &'a mut [f64],
}

/// Labels the points of a chunk and adds up their cells.
pub(super) fn assign(path: KernelPath, sites: &KernelSites, chunk: Chunk) {
    match path.0 {
        Instructions::Baseline => assign_portable(sites, chunk),
        // SAFETY: `Instructions::Avx2` is made by `KernelPath::all` alone, after the processor said that it has AVX2.
        #[cfg(target_arch = "x86_64")]
        Instructions::Avx2 => unsafe { assign_avx2(sites, chunk) },
        // SAFETY: `Instructions::Avx512` is made by `KernelPath::all` alone, after the processor said that it has AVX2 and AVX-512F.
        #[cfg(target_arch = "x86_64")]
        Instructions::Avx512 => unsafe { assign_avx512(sites, chunk) },
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn assign_avx2(sites: &KernelSites, chunk: Chunk) {
    assign_portable(sites, chunk);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,avx512f")]
fn assign_avx512(sites: &KernelSites, chunk: Chunk) {
    assign_portable(sites, chunk);
}

#[inline(always)]
fn assign_portable(sites: &KernelSites, chunk: Chunk) {
    let (m, stride) = (sites.dimension, sites.stride);
    let Chunk {
        lanes,
        squares,
        radii,
        centers,
        masses,
        inner,
        offsets,
        rows,
        mass,
        labels,
        cells,
        values,
        rivals: rivals_found,
        lined_up,
    } = chunk;
    for (tile, lanes) in lanes.chunks_exact(m * TILE).enumerate() {
        let nearest = sweep(sites, lanes, values);
        let groups = tile * TILE..(tile * TILE + TILE).min(squares.len());
        let mut reach = [f32::NEG_INFINITY; TILE];
        for group in groups.clone() {
            let lane = group % TILE;
            reach[lane] = farthest_rival(nearest.best[lane], squares[group], radii[group], sites.resolution);
        }
        let rivals = count(values, &reach);
        for group in groups {
            let lane = group % TILE;
            let own = (offsets[group] - offsets[0]) as usize..(offsets[group + 1] - offsets[0]) as usize;
            if rivals[lane] <= 1 {
                let label = nearest.site[lane];
                labels[own].fill(label);
                let (site, cell) = of_label(sites, label, cells);
                let center = &centers[group * stride..][..stride];
                add(center, site, masses[group], square_distance(center, site), cell);
                cell[1] += inner[group];
                continue;
            }
            let rivals = list(values, lane, reach[lane], rivals_found);
            line_up(sites, rivals, lined_up);
            for point in own {
                let row = &rows[point * stride..][..stride];
                let (label, square) = nearest_exact(row, rivals, lined_up);
                labels[point] = label;
                let (site, cell) = of_label(sites, label, cells);
                add(row, site, mass[point], square, cell);
            }
        }
    }
}

/// Smallest f_i at a tile's centers, and their sites.
struct Nearest {
    best: [f32; TILE],
    site: [u32; TILE],
}

/// Fills `values` with the f_i of a tile.
#[inline(always)]
fn sweep(sites: &KernelSites, lanes: &[f32], values: &mut [f32]) -> Nearest {
    let mut nearest = Nearest { best: [f32::INFINITY; TILE], site: [0; TILE] };
    let (rows, _) = lanes.as_chunks::<TILE>();
    let (values, _) = values.as_chunks_mut::<TILE>();
    for ((site, terms), out) in sites.rounded.chunks_exact(sites.dimension + 1).enumerate().zip(values) {
        let mut value = [terms[0]; TILE];
        for (row, &factor) in rows.iter().zip(&terms[1..]) {
            for (value, x) in value.iter_mut().zip(row) {
                *value += factor * x;
            }
        }
        *out = value;
        nearest = nearest.with(site as u32, &value);
    }
    nearest
}

impl Nearest {
    /// Result after one more site.
    ///
    /// Every lane is computed and written, with values selected, because branches would become slow masked stores.
    #[inline(always)]
    fn with(&self, site: u32, value: &[f32; TILE]) -> Self {
        let mut next = Self { best: [0.0; TILE], site: [0; TILE] };
        for (lane, &new) in value.iter().enumerate() {
            let best = self.best[lane];
            next.best[lane] = if new < best { new } else { best };
            next.site[lane] = if new < best { site } else { self.site[lane] };
        }
        next
    }
}

/// Largest f_i at which a site can still be nearest to a point of a group. `best` is the f_i of
/// the site nearest to its center.
#[inline(always)]
fn farthest_rival(best: f32, square: f32, radius: f32, resolution: f64) -> f32 {
    let (best, square) = (f64::from(best), f64::from(square));
    let distance = (best + square + resolution).max(0.0).sqrt() + 2.0 * f64::from(radius);
    let value = (distance * distance * (1.0 + 1e-9) + resolution) - square;
    (value as f32).next_up()
}

/// Number of sites of a tile whose f_i is at most `reach`, per lane.
#[inline(always)]
fn count(values: &[f32], reach: &[f32; TILE]) -> [u32; TILE] {
    let mut rivals = [0; TILE];
    for value in values.as_chunks::<TILE>().0 {
        for lane in 0..TILE {
            rivals[lane] += u32::from(value[lane] <= reach[lane]);
        }
    }
    rivals
}

/// Sites whose f_i at lane `lane` is at most `reach`, ascending, listed in `found`.
#[inline(always)]
fn list<'a>(values: &[f32], lane: usize, reach: f32, found: &'a mut [u32]) -> &'a [u32] {
    let mut count = 0;
    for (site, value) in values.as_chunks::<TILE>().0.iter().enumerate() {
        // Always written, and kept if it counts; a branch would be unpredictable.
        found[count.min(found.len() - 1)] = site as u32;
        count += usize::from(value[lane] <= reach);
    }
    &found[..count]
}

/// Transposes the coordinates of `rivals` in blocks of [`WIDTH`]. Missing sites are infinite.
#[inline(always)]
fn line_up(sites: &KernelSites, rivals: &[u32], lined_up: &mut [f64]) {
    let blocks = lined_up.as_chunks_mut::<WIDTH>().0.chunks_exact_mut(sites.stride);
    for (rivals, block) in rivals.chunks(WIDTH).zip(blocks) {
        block.fill([f64::INFINITY; WIDTH]);
        for (place, &site) in rivals.iter().enumerate() {
            let position = &sites.exact[site as usize * sites.stride..][..sites.stride];
            block.iter_mut().zip(position).for_each(|(side, x)| side[place] = *x);
        }
    }
}

/// Site with the least |X − p_i|² in f64 among `rivals` (ascending), and the least square. Ties go to the first.
///
/// Sums are those of [`square_distance`], term by term.
#[inline(always)]
fn nearest_exact(row: &[f64], rivals: &[u32], lined_up: &[f64]) -> (u32, f64) {
    let (mut best, mut label) = (f64::INFINITY, 0);
    let blocks = lined_up.as_chunks::<WIDTH>().0.chunks_exact(row.len());
    for (rivals, block) in rivals.chunks(WIDTH).zip(blocks) {
        let mut parts = [[0.0; WIDTH]; LANES];
        for (xs, sides) in row.as_chunks::<LANES>().0.iter().zip(block.as_chunks::<LANES>().0) {
            for lane in 0..LANES {
                for place in 0..WIDTH {
                    let offset = xs[lane] - sides[lane][place];
                    parts[lane][place] += offset * offset;
                }
            }
        }
        for (place, &site) in rivals.iter().enumerate() {
            let square = (parts[0][place] + parts[1][place]) + (parts[2][place] + parts[3][place]);
            if square < best {
                (best, label) = (square, site);
            }
        }
    }
    (label, best)
}

/// Site `label` and the sums of its cell.
#[inline(always)]
fn of_label<'a>(sites: &'a KernelSites, label: u32, cells: &'a mut [f64]) -> (&'a [f64], &'a mut [f64]) {
    let (stride, entries, label) = (sites.stride, sites.stride + CELL_HEAD, label as usize);
    (&sites.exact[label * stride..][..stride], &mut cells[label * entries..][..entries])
}

/// Adds a point, with its squared distance from its site, to the site's cell.
#[inline(always)]
fn add(row: &[f64], site: &[f64], mass: f64, square: f64, cell: &mut [f64]) {
    let (head, moments) = cell.split_at_mut(CELL_HEAD);
    for ((x, p), moment) in row.iter().zip(site).zip(moments) {
        *moment += mass * (x - p);
    }
    head[0] += mass;
    head[1] += mass * square;
}
