//! Points with masses as the kernel reads them, in groups: the nodes of a field, or the groups of a finer level, each at the centre of
//! its mass. A diagram of centres differs from one of the points in that groups are not cut; its energy is then that of the points,
//! but for a constant (the parallel axis theorem).

use super::Field;
use super::clusters::Groups;
use super::kernel::Sites;
use super::vector::{LANES, square_distance};

/// Groups per tile.
pub(super) const TILE: usize = 16;

/// Points in groups; a point without one is its own. Points lie in the order of their groups.
#[derive(Clone, Debug, Default)]
pub(super) struct Level {
    dimension: usize,
    /// The point, of the field or of the finer level, at each place here.
    pub order: Vec<u32>,
    /// X of each point; [`Level::stride`] entries each, the last of which are zeros.
    pub rows: Vec<f64>,
    /// w of each point.
    pub mass: Vec<f64>,
    /// Where each group begins among the points, and their number.
    pub offsets: Vec<u32>,
    /// Centre of mass of each group, as `rows`.
    pub centres: Vec<f64>,
    /// w of each group.
    pub masses: Vec<f64>,
    /// Σ w|X − centre|² of each group.
    pub inner: Vec<f64>,
    /// |X − centre| of each group's farthest point, scaled, rounded up.
    pub radii: Vec<f32>,
    /// |centre|² of each group, centred and scaled.
    pub squares: Vec<f32>,
    /// The centres in f32, centred, scaled to the unit ball: tile-major, then coordinate, then lane; the last tile is filled up.
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

impl Level {
    /// Refills from the nodes of `field`.
    pub fn load(&mut self, field: &Field, groups: Option<&Groups>) {
        self.dimension = field.dimension();
        self.base = 0.0;
        let row = |node: usize| field.lift().at(node);
        self.gather(field.nodes(), groups, row, field.mass());
    }

    /// Refills from the groups of `finer`.
    pub fn coarsen(&mut self, finer: &Self, groups: Option<&Groups>) {
        self.dimension = finer.dimension;
        self.base = finer.base + finer.inner.iter().sum::<f64>();
        let (stride, m) = (finer.stride(), finer.dimension);
        let row = |point: usize| &finer.centres[point * stride..][..m];
        self.gather(finer.groups(), groups, row, &finer.masses);
    }

    fn gather<'a>(&mut self, points: usize, groups: Option<&Groups>, row: impl Fn(usize) -> &'a [f64], mass: &[f64]) {
        let (stride, m) = (self.stride(), self.dimension);
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
        self.mass.clear();
        self.mass.extend(self.order.iter().map(|&point| mass[point as usize]));
        self.rows.resize(points * stride, 0.0);
        for (own, &point) in self.rows.chunks_exact_mut(stride).zip(&self.order) {
            own[..m].copy_from_slice(row(point as usize));
            own[m..].fill(0.0);
        }
        self.sum_groups();
        self.round_centres();
    }

    /// Masses, centres and inner energies of the groups; radii not yet scaled.
    fn sum_groups(&mut self) {
        let (stride, count) = (self.stride(), self.groups());
        self.centres.resize(count * stride, 0.0);
        self.masses.resize(count, 0.0);
        self.inner.resize(count, 0.0);
        self.radii.resize(count, 0.0);
        for (group, centre) in self.centres.chunks_exact_mut(stride).enumerate() {
            let own = self.offsets[group] as usize..self.offsets[group + 1] as usize;
            let rows = &self.rows[own.start * stride..own.end * stride];
            let (masses, points) = (&self.mass[own.clone()], own.len());
            if points == 1 {
                centre.copy_from_slice(rows);
                (self.masses[group], self.inner[group], self.radii[group]) = (masses[0], 0.0, 0.0);
                continue;
            }
            let total: f64 = masses.iter().sum();
            // About the first point: what is far from the origin loses nothing.
            centre.fill(0.0);
            for (row, mass) in rows.chunks_exact(stride).zip(masses).skip(1) {
                let share = if total > 0.0 { mass / total } else { (points as f64).recip() };
                centre
                    .iter_mut()
                    .zip(row)
                    .zip(&rows[..stride])
                    .for_each(|((sum, x), first)| *sum += share * (x - first));
            }
            centre.iter_mut().zip(rows).for_each(|(sum, first)| *sum += first);
            let (mut inner, mut farthest) = (0.0, 0.0f64);
            for (row, mass) in rows.chunks_exact(stride).zip(masses) {
                let square = square_distance(row, centre);
                inner += mass * square;
                farthest = farthest.max(square);
            }
            (self.masses[group], self.inner[group], self.radii[group]) = (total, inner, 0.0);
            // In f64 until the scale is known.
            self.radii[group] = (farthest.sqrt() * UP) as f32;
        }
    }

    /// The centres in f32.
    fn round_centres(&mut self) {
        let (m, stride, count) = (self.dimension, self.stride(), self.groups());
        self.origin.clear();
        self.origin.resize(m, 0.0);
        for centre in self.centres.chunks_exact(stride) {
            self.origin.iter_mut().zip(centre).for_each(|(sum, x)| *sum += x);
        }
        self.origin.iter_mut().for_each(|sum| *sum /= count as f64);
        let origin = &self.origin;
        let squares = self.centres.chunks_exact(stride).map(|centre| square_distance(&centre[..m], origin));
        let radius = squares.fold(0.0, f64::max).sqrt();
        self.scale = if radius.is_normal() { radius.recip() } else { 1.0 };
        self.lanes.resize(count.div_ceil(TILE) * m * TILE, 0.0);
        self.squares.resize(count, 0.0);
        for (tile, centres) in self.lanes.chunks_exact_mut(m * TILE).zip(self.centres.chunks(stride * TILE)) {
            for (lane, centre) in centres.chunks_exact(stride).enumerate() {
                for axis in 0..m {
                    tile[axis * TILE + lane] = ((centre[axis] - origin[axis]) * self.scale) as f32;
                }
            }
        }
        for (group, centre) in self.centres.chunks_exact(stride).enumerate() {
            self.squares[group] = (square_distance(&centre[..m], origin) * self.scale * self.scale) as f32;
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
    pub fn round<'a>(&self, sites: &'a [f64], rounded: &'a mut Vec<f32>) -> Sites<'a> {
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
        // Centres lie in the unit ball: their own squares err by no more than the last term.
        let error = (m as f64 + 5.0) * (unit * (bound + 1.0) + f64::from(f32::MIN_POSITIVE));
        Sites { dimension: m, stride: self.stride(), exact: sites, rounded, resolution: 2.0 * error }
    }
}
