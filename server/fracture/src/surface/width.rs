//! Wall thickness of a shape, and width of the gaps between its walls.
//!
//! Based on: L. Shapira, A. Shamir, D. Cohen-Or, *Consistent mesh partitioning and skeletonisation using the shape
//! diameter function* (2008), with a single ray along the normal. The winding number separates inside from outside.

use super::InsideTest;
use crate::cancel_token::{CancelToken, Canceled};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Number of sample points on the surface, uniform by area.
const SAMPLES: usize = 1024;

/// Number of shortest steps along a ray, up to the limit.
const STEPS: usize = 64;

/// Longest stride, in shortest steps, for an open surface.
const STEPS_OPEN: f64 = 6.0;
/// Halvings of the step in which the ray changes sides.
const HALVINGS: usize = 12;

/// Offset from the surface, over the limit, at which the side of a point is determined.
const SKIN: f64 = 1e-4;

/// Side of the surface on which a width is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WidthSide {
    /// Wall thickness: from the surface inward to the end of the body.
    Wall,
    /// Gap width: from the surface outward to the next part of the body.
    Gap,
}

/// Width at a point of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Width {
    /// Distance to the opposite side along the normal, local; at most the requested limit.
    pub width: f64,
    /// Point halfway to the opposite side, local.
    pub middle: Point3<f64>,
    /// Face of the input file, counted from 0.
    pub face: u64,
}

/// Widths at points distributed uniformly by area, ascending.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Widths {
    /// One sample per point at which the surface separates inside from outside.
    pub samples: Vec<Width>,
}

impl Widths {
    /// Width below which a `share` (0 ..= 1) of the area lies; infinite without samples.
    pub fn quantile(&self, share: f64) -> f64 {
        let rank = (share * self.samples.len() as f64) as usize;
        self.samples.get(rank.min(self.samples.len().saturating_sub(1))).map_or(f64::INFINITY, |sample| sample.width)
    }
}

impl InsideTest {
    /// Measures widths up to `limit` (local, positive).
    ///
    /// Skips samples where the surface does not separate inside from outside, as on sheets
    /// within a body. Errors: canceled.
    ///
    /// # Errors
    /// Canceled.
    pub fn widths(&self, side: WidthSide, limit: f64, token: &CancelToken) -> Result<Widths, Canceled> {
        let areas: Vec<f64> = self.tree.triangles.iter().map(|corners| normal(corners).norm()).collect();
        let ends: Vec<f64> = areas
            .iter()
            .scan(0.0, |sum, area| {
                *sum += area;
                Some(*sum)
            })
            .collect();
        let total = ends.last().copied().unwrap_or(0.0);
        let measured: Result<Vec<Option<Width>>, Canceled> = (0..SAMPLES)
            .into_par_iter()
            .map(|sample| {
                token.check()?;
                let place = (sample as f64 + 0.5) / SAMPLES as f64 * total;
                let triangle = ends.partition_point(|end| *end < place).min(ends.len().saturating_sub(1));
                let point = self.tree.triangles.get(triangle).map(|corners| spread(corners, sample));
                Ok(point.and_then(|point| self.width(side, limit, triangle, point)))
            })
            .collect();
        let mut samples: Vec<Width> = measured?.into_iter().flatten().collect();
        samples.sort_by(|a, b| a.width.total_cmp(&b.width).then(a.face.cmp(&b.face)));
        Ok(Widths { samples })
    }

    /// Wall thickness, up to `limit` (local, positive), at the center of each triangle whose center `chooses` selects.
    pub fn walls_at_centers(&self, limit: f64, chooses: impl Fn(&Point3<f64>) -> bool + Sync) -> Vec<Width> {
        let wall = |(triangle, [a, b, c]): (usize, &[Point3<f64>; 3])| {
            let center = Point3::from((a.coords + b.coords + c.coords) / 3.0);
            chooses(&center).then(|| self.width(WidthSide::Wall, limit, triangle, center)).flatten()
        };
        self.tree.triangles.par_iter().enumerate().filter_map(wall).collect()
    }

    /// Width at a point of a stored triangle.
    fn width(&self, side: WidthSide, limit: f64, triangle: usize, point: Point3<f64>) -> Option<Width> {
        let corners = self.tree.triangles.get(triangle)?;
        let outward = normal(corners).try_normalize(0.0)?;
        let inside = |offset: f64| self.winding(&(point + outward * offset)) > 0.5;
        let skin = SKIN * limit;
        let direction = match (inside(-skin), inside(skin), side) {
            (true, false, WidthSide::Wall) | (false, true, WidthSide::Gap) => -1.0,
            (true, false, WidthSide::Gap) | (false, true, WidthSide::Wall) => 1.0,
            _ => return None,
        };
        let within = |width: f64| inside(direction * width) == (side == WidthSide::Wall);
        let face = self.faces.get(self.tree.order[triangle] as usize).copied().unwrap_or(0);
        let width = |width: f64| Width { width, middle: point + outward * (0.5 * direction * width), face };
        let step = limit / STEPS as f64;
        let mut below = skin;
        let mut above = loop {
            // The side cannot change within the distance of the nearest surface, but films over holes may be nearer.
            let free = self.distance(&(point + outward * (direction * below)));
            let free = if self.closed { free } else { free.min(STEPS_OPEN * step) };
            let next = below + free.max(step);
            if !(self.closed && free >= step || within(next)) {
                break next;
            }
            if next >= limit {
                return Some(width(limit));
            }
            below = next;
        };
        for _ in 0..HALVINGS {
            let middle = 0.5 * (below + above);
            *(if within(middle) { &mut below } else { &mut above }) = middle;
        }
        Some(width(above))
    }
}

/// Twice the area vector of a triangle.
fn normal([a, b, c]: &[Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

/// Sample point of a triangle. Many samples spread evenly (R2 sequence, M. Roberts, 2018).
fn spread([a, b, c]: &[Point3<f64>; 3], sample: usize) -> Point3<f64> {
    let [u, v] = [0.754_877_666_246_693, 0.569_840_290_998_053].map(|step| (0.5 + step * sample as f64).fract());
    let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
    a + (b - a) * u + (c - a) * v
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{RawMesh, Surface, shapes};

    /// Checks a quantile of the widths on one side of a mesh, in m.
    fn check(mesh: RawMesh, side: WidthSide, share: f64, expected_m: f64) {
        let surface = Surface::repair(mesh).unwrap();
        let meters = surface.frame.diagonal_m;
        let widths = InsideTest::new(&surface).widths(side, 0.1, &CancelToken::default()).unwrap();
        let found_m = widths.quantile(share) * meters;
        let expected_m = expected_m.min(0.1 * meters);
        assert!((found_m / expected_m - 1.0).abs() < 0.02, "{found_m} instead of {expected_m}");
    }

    #[test]
    fn plates_are_as_thick_as_they_are() {
        check(shapes::cuboid([1.0, 1.0, 0.01]), WidthSide::Wall, 0.05, 0.01);
        check(shapes::cuboid([1.0, 1.0, 0.001]), WidthSide::Wall, 0.5, 0.001);
        check(shapes::cuboid([1.0, 0.02, 0.02]), WidthSide::Wall, 0.05, 0.02);
    }

    #[test]
    fn solid_bodies_are_thick_and_stand_alone() {
        for mesh in [shapes::cuboid([1.0; 3]), shapes::sphere(1.0, 4)] {
            check(mesh.clone(), WidthSide::Wall, 0.01, f64::INFINITY);
            check(mesh, WidthSide::Gap, 0.01, f64::INFINITY);
        }
    }

    #[test]
    fn gaps_and_cavities_are_as_wide_as_they_are() {
        let mut two = shapes::cuboid([1.0; 3]);
        let other = shapes::cuboid([1.0; 3]);
        let first = two.positions_m.len() as u32;
        two.positions_m.extend(other.positions_m.iter().map(|p| p + Vector3::new(1.03, 0.0, 0.0)));
        two.triangles.extend(other.triangles.iter().map(|corners| corners.map(|vertex| vertex + first)));
        // One face in six faces the other cube.
        check(two.clone(), WidthSide::Gap, 0.15, 0.03);
        check(two, WidthSide::Gap, 0.2, f64::INFINITY);
    }
}
