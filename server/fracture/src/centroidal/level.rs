//! Points with masses as the kernel reads them, in groups: the nodes of a field, or the groups of a finer level, each at the center of
//! its mass. A diagram of centers differs from one of the points in that groups are not cut; its energy is then that of the points,
//! but for a constant (the parallel axis theorem).

use super::EnergyField;
use super::clusters::Groups;
use super::kernel::KernelSites;
use super::vector::{LANES, square_distance};

/// Groups per tile.
pub(super) const TILE: usize = 16;

/// Points in groups; a point without one is its own. Points lie in the order of their groups.
#[derive(Clone, Debug, Default)]
pub(super) struct PointLevel {
    dimension: usize,
    /// The point, of the field or of the finer level, at each place here.
    pub order: Vec<u32>,
    /// X of each point; [`Level::stride`] entries each, the last of which are zeros.
    pub rows: Vec<f64>,
    /// w of each point.
    pub mass: Vec<f64>,
    /// Where each group begins among the points, and their number.
    pub offsets: Vec<u32>,
    /// Center of mass of each group, as `rows`.
    pub centers: Vec<f64>,
    /// w of each group.
    pub masses: Vec<f64>,
    /// Σ w|X − center|² of each group.
    pub inner: Vec<f64>,
    /// |X − center| of each group's farthest point, scaled, rounded up.
    pub radii: Vec<f32>,
    /// |center|² of each group, centered and scaled.
    pub squares: Vec<f32>,
    /// The centers in f32, centered, scaled to the unit ball: tile-major, then coordinate, then lane; the last tile is filled up.
    pub lanes: Vec<f32>,
    /// What was taken off the coordinates in `lanes`.
    origin: Vec<f64>,
    /// What they were multiplied with.
    scale: f64,
    /// Σ w|X − p|² that lies within the points of a coarse level, and no site can take away.
    pub base: f64,
}

/// Rounded up: by more than the few roundings that made it.
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

    /// Refills from points: rows of so many entries, of which the first are coordinates, and masses.
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

    /// The centers in f32.
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

    /// m filled up to a multiple of [`LANES`].
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

    /// X of the point at `place`, with its zeros.
    pub fn row(&self, place: usize) -> &[f64] {
        &self.rows[place * self.stride()..][..self.stride()]
    }

    /// Rounds `sites` (site-major, [`Self::stride`] each) into `rounded` and proves the resolution.
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
        // Centers lie in the unit ball: their own squares err by no more than the last term.
        let error = (m as f64 + 5.0) * (unit * (bound + 1.0) + f64::from(f32::MIN_POSITIVE));
        KernelSites { dimension: m, stride: self.stride(), exact: sites, rounded, resolution: 2.0 * error }
    }
}

/// Groups that one task fills.
const GRAIN: usize = 512;

/// What points and groups are filled from.
struct Filler<'a> {
    stride: usize,
    order: &'a [u32],
    offsets: &'a [u32],
    /// Rows, and their length.
    from: (&'a [f64], usize),
    m: usize,
    mass: &'a [f64],
}

/// The parts of a level that belong to some groups; radii are not scaled yet.
struct Filled<'a> {
    rows: &'a mut [f64],
    mass: &'a mut [f64],
    centers: &'a mut [f64],
    masses: &'a mut [f64],
    inner: &'a mut [f64],
    radii: &'a mut [f32],
}

impl Filler<'_> {
    /// Groups from `first` on, as many as `out` has room for; halves of them in parallel.
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

/// Mass, inner energy and radius of a group, whose center is written to `center`.
fn sum_group(rows: &[f64], masses: &[f64], center: &mut [f64]) -> (f64, f64, f32) {
    let stride = center.len();
    let (first, points) = (&rows[..stride], masses.len());
    if points == 1 {
        center.copy_from_slice(first);
        return (masses[0], 0.0, 0.0);
    }
    let total: f64 = masses.iter().sum();
    // About the first point: what is far from the origin loses nothing.
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
