//! Node coordinates as the kernel reads them: once in f32, centred, scaled to the unit ball, sixteen nodes side by side, to
//! be swept; once in f64 rows of whole vectors, to be summed.

use super::Field;
use super::kernel::{LANES, Sites, square_distance};

/// Nodes per tile.
pub(super) const TILE: usize = 16;

/// Copies of a lift's coordinates.
#[derive(Clone, Debug, Default)]
pub(super) struct Tiles {
    dimension: usize,
    centre: Vec<f64>,
    scale: f64,
    /// Tile-major, then coordinate, then lane; the last tile is filled up with zeros.
    lanes: Vec<f32>,
    /// Node-major, [`Tiles::stride`] each.
    rows: Vec<f64>,
}

impl Tiles {
    /// Refills from `field`'s coordinates; allocates only when they have grown.
    pub fn load(&mut self, field: &Field) {
        let (lift, m) = (field.lift(), field.dimension());
        self.dimension = m;
        self.centre.clear();
        self.centre.resize(m, 0.0);
        for place in lift.coordinates.chunks_exact(m) {
            self.centre.iter_mut().zip(place).for_each(|(sum, x)| *sum += x);
        }
        self.centre.iter_mut().for_each(|sum| *sum /= field.nodes() as f64);
        let square = |place: &[f64]| square_distance(place, &self.centre);
        let radius = lift.coordinates.chunks_exact(m).map(square).fold(0.0, f64::max).sqrt();
        self.scale = if radius.is_normal() { radius.recip() } else { 1.0 };
        self.lanes.clear();
        self.lanes.resize(field.nodes().div_ceil(TILE) * m * TILE, 0.0);
        for (tile, places) in self.lanes.chunks_exact_mut(m * TILE).zip(lift.coordinates.chunks(m * TILE)) {
            for (lane, place) in places.chunks_exact(m).enumerate() {
                for axis in 0..m {
                    tile[axis * TILE + lane] = ((place[axis] - self.centre[axis]) * self.scale) as f32;
                }
            }
        }
        self.rows.clear();
        self.rows.resize(field.nodes() * self.stride(), 0.0);
        for (row, place) in self.rows.chunks_exact_mut(m.next_multiple_of(LANES)).zip(lift.coordinates.chunks_exact(m))
        {
            row[..m].copy_from_slice(place);
        }
    }

    /// m filled up to a multiple of [`LANES`].
    pub fn stride(&self) -> usize {
        self.dimension.next_multiple_of(LANES)
    }

    /// The tiles.
    pub fn lanes(&self) -> &[f32] {
        &self.lanes
    }

    /// The rows.
    pub fn rows(&self) -> &[f64] {
        &self.rows
    }

    /// Rounds `sites` (site-major, [`Tiles::stride`] each) into `rounded` and proves the resolution.
    pub fn round<'a>(&self, sites: &'a [f64], rounded: &'a mut Vec<f32>) -> Sites<'a> {
        let m = self.dimension;
        rounded.clear();
        let mut bound = 0.0f64;
        for site in sites.chunks_exact(self.stride()) {
            let head = rounded.len();
            rounded.push(0.0);
            let mut square = 0.0;
            for (x, centre) in site.iter().zip(&self.centre) {
                let local = (x - centre) * self.scale;
                square += local * local;
                rounded.push((-2.0 * local) as f32);
            }
            rounded[head] = square as f32;
            bound = bound.max(square + 2.0 * square.sqrt());
        }
        let unit = 0.5 * f64::from(f32::EPSILON);
        let error = (m as f64 + 5.0) * (unit * bound + f64::from(f32::MIN_POSITIVE));
        Sites { dimension: m, stride: self.stride(), exact: sites, rounded, resolution: (2.0 * error) as f32 }
    }
}
