//! A mug with rounded rims, as a closed mesh.
//!
//! Rims are rounded on purpose: lattices are cut along smooth surfaces well, and along sharp edges only raggedly.

use nalgebra::{Point3, Vector2};
use shatter_fracture::surface::RawMesh;
use shatter_fracture::surface::shapes::implicit;

/// Side of the cubes that the mesh is cut from, m.
const GRID_M: f64 = 0.0019;

/// The box that is cut, m: a little larger than the mug, and no multiple of its sizes away from them.
const LOW_M: [f64; 3] = [-0.0443, -0.0042, -0.0443];
const HIGH_M: [f64; 3] = [0.0793, 0.1043, 0.0443];

/// A mug, 0.1 m high and 0.08 m wide, with a wall of 9 mm, a round lip and a handle along +x.
pub(super) fn mug() -> RawMesh {
    implicit(LOW_M.into(), HIGH_M.into(), GRID_M, height)
}

/// Negative inside the mug, positive outside, near the distance in metres close to the surface.
fn height(point: &Point3<f64>) -> f64 {
    let profile = Vector2::new(point.x.hypot(point.z), point.y);
    let wall = capsule(profile, [0.0355, 0.0055], [0.0355, 0.0955], 0.0045);
    let base = capsule(profile, [0.0, 0.0055], [0.0345, 0.0055], 0.0055);
    let ring = Vector2::new(point.x - 0.040, point.y - 0.051).norm() - 0.0265;
    let handle = Vector2::new(ring, 0.9 * point.z).norm() - 0.0062;
    let hollow = -smooth_min(0.031 - profile.x, profile.y - 0.011, 0.008);
    smooth_min(smooth_min(wall, base, 0.006), handle, 0.007).max(-hollow)
}

/// Distance to the segment from `a` to `b`, less `radius`.
fn capsule(point: Vector2<f64>, a: [f64; 2], b: [f64; 2], radius: f64) -> f64 {
    let (a, b) = (Vector2::from(a), Vector2::from(b));
    let along = ((point - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
    (point - a - (b - a) * along).norm() - radius
}

/// The smaller of two heights, rounded where they differ by less than `width` (I. Quilez's polynomial minimum).
fn smooth_min(a: f64, b: f64, width: f64) -> f64 {
    let overlap = (width - (a - b).abs()).max(0.0);
    a.min(b) - overlap * overlap / (4.0 * width)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mug_is_one_closed_surface_of_a_mugs_size() {
        let mesh = mug();
        let mut edges: Vec<[u32; 2]> = mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        edges.sort_unstable();
        assert!(edges.windows(2).all(|pair| pair[0] != pair[1]));
        assert!(edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok()));
        let corner = |vertex: u32| mesh.positions_m[vertex as usize].coords;
        let volume_m3: f64 =
            mesh.triangles.iter().map(|t| corner(t[0]).cross(&corner(t[1])).dot(&corner(t[2])) / 6.0).sum();
        assert!((2.0e-4..3.2e-4).contains(&volume_m3), "{volume_m3}");
        // Closed and of genus 1: as many vertices as half as many triangles.
        assert_eq!(mesh.positions_m.len() * 2, mesh.triangles.len());
    }

    #[test]
    fn the_mug_holds_coffee_and_a_finger() {
        let solid = |x: f64, y: f64, z: f64| height(&Point3::new(x, y, z)) < 0.0;
        assert!(!solid(0.0, 0.05, 0.0) && !solid(0.028, 0.09, 0.0), "hollow inside");
        assert!(solid(0.0, 0.005, 0.0) && solid(-0.0355, 0.05, 0.0), "bottom and wall");
        assert!(solid(0.0665, 0.051, 0.0) && !solid(0.05, 0.051, 0.0), "handle with a hole");
    }
}
