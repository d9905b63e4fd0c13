//! Points with masses in the layout of the kernel, in groups.
//!
//! Points are the nodes of a field, or the groups of a finer level, each at its center of mass. A diagram of centers
//! differs from one of the points in that groups are not split. Its energy is that of the points up to a constant
//! (parallel axis theorem).

use super::EnergyField;
use super::clusters::Groups;
use super::kernel::KernelSites;
use super::vector::{LANES, square_distance};

/// Number of groups per tile.
pub(super) const TILE: usize = 16;

/// Points in groups, ordered by group. A point without a group is its own group.
#[derive(Clone, Debug, Default)]
pub(super) struct PointLevel {
    dimension: usize,
    /// Index of each point in the field or the finer level.
    pub order: Vec<u32>,
    /// Coordinates X of each point, [`PointLevel::stride`] entries each, padded with zeros.
    pub rows: Vec<f64>,
    /// Mass w of each point.
    pub mass: Vec<f64>,
    /// Start of each group among the points, and the number of points.
    pub offsets: Vec<u32>,
    /// Center of mass of each group, in the layout of `rows`.
    pub centers: Vec<f64>,
    /// Mass w of each group.
    pub masses: Vec<f64>,
    /// Inner energy Σ w|X − center|² of each group.
    pub inner: Vec<f64>,
    /// Radius of each group, |X − center| of its farthest point, scaled and rounded up.
    pub radii: Vec<f32>,
    /// |center|² of each group, centered and scaled.
    pub squares: Vec<f32>,
    /// Centers in f32, centered and scaled to the unit ball: tile-major, then coordinate, then
    /// lane. The last tile is padded.
    pub lanes: Vec<f32>,
    /// Origin that is subtracted from the coordinates in `lanes`.
    origin: Vec<f64>,
    /// Scale by which they are then multiplied.
    scale: f64,
    /// Energy Σ w|X − p|² within the points of a coarse level, which no site can reduce.
    pub base: f64,
}

/// Factor that rounds up by more than the roundings of a radius.
const UP: f64 = 1.0 + 1e-6;

impl PointLevel {
    /// Refills from the nodes of `field`.
    pub fn load(&mut self, field: &EnergyField, groups: Option<&Groups>) {
        self.dimension = field.dimension();
        self.base = 0.0;
        self.gather(groups, (&field.lift().coordinates, self.dimension), field.mass());
    }

    /// Refills from the groups of `finer`.
    pub fn coarsen(&mut self, finer: &Self, groups: Option<&Groups>) {
        self.dimension = finer.dimension;
        self.base = finer.base + finer.inner.iter().sum::<f64>();
        self.gather(groups, (&finer.centers, finer.stride()), &finer.masses);
    }

    /// Refills from points and masses. `from` holds rows that begin with the coordinates, and the length of a row.
    fn gather(&mut self, groups: Option<&Groups>, from: (&[f64], usize), mass: &[f64]) {
        let points = mass.len();
        let stride = self.stride();
        self.order.clear();
        self.offsets.clear();
        match groups {
            Some(groups) => {
                self.order.extend_from_slice(&groups.members);
                self.offsets.extend_from_slice(&groups.offsets);
            }
            None => {
                self.order.extend(0..points as u32);
                self.offsets.extend(0..=points as u32);
            }
        }
        let count = self.groups();
        self.mass.resize(points, 0.0);
        self.rows.resize(points * stride, 0.0);
        self.centers.resize(count * stride, 0.0);
        self.masses.resize(count, 0.0);
        self.inner.resize(count, 0.0);
        self.radii.resize(count, 0.0);
        let filler = Filler { stride, order: &self.order, offsets: &self.offsets, from, m: self.dimension, mass };
        filler.run(
            0,
            Filled {
                rows: &mut self.rows,
                mass: &mut self.mass,
                centers: &mut self.centers,
                masses: &mut self.masses,
                inner: &mut self.inner,
                radii: &mut self.radii,
            },
        );
        self.round_centers();
    }

    /// Computes the centers in f32.
    fn round_centers(&mut self) {
        let (m, stride, count) = (self.dimension, self.stride(), self.groups());
        self.origin.clear();
        self.origin.resize(m, 0.0);
        for center in self.centers.chunks_exact(stride) {
            self.origin.iter_mut().zip(center).for_each(|(sum, x)| *sum += x);
        }
        self.origin.iter_mut().for_each(|sum| *sum /= count as f64);
        let origin = &self.origin;
        let squares = self.centers.chunks_exact(stride).map(|center| square_distance(&center[..m], origin));
        let radius = squares.fold(0.0, f64::max).sqrt();
        self.scale = if radius.is_normal() { radius.recip() } else { 1.0 };
        self.lanes.resize(count.div_ceil(TILE) * m * TILE, 0.0);
        self.squares.resize(count, 0.0);
        for (tile, centers) in self.lanes.chunks_exact_mut(m * TILE).zip(self.centers.chunks(stride * TILE)) {
            for (lane, center) in centers.chunks_exact(stride).enumerate() {
                for axis in 0..m {
                    tile[axis * TILE + lane] = ((center[axis] - origin[axis]) * self.scale) as f32;
                }
            }
        }
        for (group, center) in self.centers.chunks_exact(stride).enumerate() {
            self.squares[group] = (square_distance(&center[..m], origin) * self.scale * self.scale) as f32;
        }
        let scale = self.scale * UP;
        self.radii.iter_mut().for_each(|radius| *radius = (f64::from(*radius) * scale) as f32);
    }

    /// m, padded to a multiple of [`LANES`].
    pub fn stride(&self) -> usize {
        self.dimension.next_multiple_of(LANES)
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.mass.len()
    }

    /// Number of groups.
    pub fn groups(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Coordinates X of the point at index `place`, padded with zeros.
    pub fn row(&self, place: usize) -> &[f64] {
        &self.rows[place * self.stride()..][..self.stride()]
    }

    /// Rounds `sites` (site-major, [`Self::stride`] each) into `rounded`, and bounds the rounding error.
    pub fn round<'a>(&self, sites: &'a [f64], rounded: &'a mut Vec<f32>) -> KernelSites<'a> {
        let m = self.dimension;
        rounded.clear();
        let mut bound = 0.0f64;
        for site in sites.chunks_exact(self.stride()) {
            let head = rounded.len();
            rounded.push(0.0);
            let mut square = 0.0;
            for (x, origin) in site.iter().zip(&self.origin) {
                let local = (x - origin) * self.scale;
                square += local * local;
                rounded.push((-2.0 * local) as f32);
            }
            rounded[head] = square as f32;
            bound = bound.max(square + 2.0 * square.sqrt());
        }
        let unit = 0.5 * f64::from(f32::EPSILON);
        // Centers lie in the unit ball, so their own squares err by at most the last term.
        let error = (m as f64 + 5.0) * (unit * (bound + 1.0) + f64::from(f32::MIN_POSITIVE));
        KernelSites { dimension: m, stride: self.stride(), exact: sites, rounded, resolution: 2.0 * error }
    }
}

/// Groups per parallel task.
const GRAIN: usize = 512;

/// Input from which points and groups are filled.
struct Filler<'a> {
    stride: usize,
    order: &'a [u32],
    offsets: &'a [u32],
    /// Rows, and their length.
    from: (&'a [f64], usize),
    m: usize,
    mass: &'a [f64],
}

/// Output slices of consecutive groups. Radii are not yet scaled.
struct Filled<'a> {
    rows: &'a mut [f64],
    mass: &'a mut [f64],
    centers: &'a mut [f64],
    masses: &'a mut [f64],
    inner: &'a mut [f64],
    radii: &'a mut [f32],
}

impl Filler<'_> {
    /// Fills the groups from `first` on that `out` has memory for, in parallel halves.
    fn run(&self, first: usize, out: Filled<'_>) {
        let count = out.masses.len();
        if count <= GRAIN {
            return self.fill(first, out);
        }
        let (half, stride) = (count / 2, self.stride);
        let points = (self.offsets[first + half] - self.offsets[first]) as usize;
        let (rows, rows_rest) = out.rows.split_at_mut(points * stride);
        let (mass, mass_rest) = out.mass.split_at_mut(points);
        let (centers, centers_rest) = out.centers.split_at_mut(half * stride);
        let (masses, masses_rest) = out.masses.split_at_mut(half);
        let (inner, inner_rest) = out.inner.split_at_mut(half);
        let (radii, radii_rest) = out.radii.split_at_mut(half);
        let left = Filled { rows, mass, centers, masses, inner, radii };
        let right = Filled {
            rows: rows_rest,
            mass: mass_rest,
            centers: centers_rest,
            masses: masses_rest,
            inner: inner_rest,
            radii: radii_rest,
        };
        rayon::join(|| self.run(first, left), || self.run(first + half, right));
    }

    fn fill(&self, first: usize, out: Filled<'_>) {
        let stride = self.stride;
        let (mut rows, mut mass) = (out.rows, out.mass);
        let groups = out.centers.chunks_exact_mut(stride).zip(out.masses).zip(out.inner).zip(out.radii);
        for (index, (((center, total), inner), radius)) in groups.enumerate() {
            let own = self.offsets[first + index] as usize..self.offsets[first + index + 1] as usize;
            let (own_rows, other_rows) = rows.split_at_mut(own.len() * stride);
            let (own_mass, other_mass) = mass.split_at_mut(own.len());
            for ((to, weight), &point) in own_rows.chunks_exact_mut(stride).zip(&mut *own_mass).zip(&self.order[own]) {
                to[..self.m].copy_from_slice(&self.from.0[point as usize * self.from.1..][..self.m]);
                to[self.m..].fill(0.0);
                *weight = self.mass[point as usize];
            }
            (*total, *inner, *radius) = sum_group(own_rows, own_mass, center);
            (rows, mass) = (other_rows, other_mass);
        }
    }
}

/// Mass, inner energy and radius of a group. Writes its center to `center`.
fn sum_group(rows: &[f64], masses: &[f64], center: &mut [f64]) -> (f64, f64, f32) {
    let stride = center.len();
    let (first, points) = (&rows[..stride], masses.len());
    if points == 1 {
        center.copy_from_slice(first);
        return (masses[0], 0.0, 0.0);
    }
    let total: f64 = masses.iter().sum();
    // Relative to the first point, so that points far from the origin lose no digits.
    center.fill(0.0);
    for (row, mass) in rows.chunks_exact(stride).zip(masses).skip(1) {
        let share = if total > 0.0 { mass / total } else { (points as f64).recip() };
        center.iter_mut().zip(row).zip(first).for_each(|((sum, x), first)| *sum += share * (x - first));
    }
    center.iter_mut().zip(first).for_each(|(sum, first)| *sum += first);
    let (mut inner, mut farthest) = (0.0, 0.0f64);
    for (row, mass) in rows.chunks_exact(stride).zip(masses) {
        let square = square_distance(row, center);
        inner += mass * square;
        farthest = farthest.max(square);
    }
    (total, inner, (farthest.sqrt() * UP) as f32)
}
