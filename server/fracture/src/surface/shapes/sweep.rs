//! Swept surfaces: rings along a path, and profiles about an axis.

use super::RawMesh;
use nalgebra::Point3;
use std::f64::consts::TAU;

/// Joins rings of equally many points to a tube and closes both ends with a fan about their middle.
///
/// Each ring runs counter-clockwise as seen from the next one.
pub(super) fn tube(rings: &[Vec<Point3<f64>>]) -> RawMesh {
    let mut mesh = RawMesh::new(rings.concat(), Vec::new());
    let (Some(first), Some(last)) = (rings.first(), rings.last()) else {
        return mesh;
    };
    let size = first.len() as u32;
    let at = |ring: u32, k: u32| ring * size + k % size;
    for ring in 1..rings.len() as u32 {
        for k in 0..size {
            let [a, b, c, d] = [at(ring - 1, k), at(ring - 1, k + 1), at(ring, k + 1), at(ring, k)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    for (ring, points, flip) in [(0, first, true), (rings.len() as u32 - 1, last, false)] {
        let center = mesh.positions_m.len() as u32;
        let sum: nalgebra::Vector3<f64> = points.iter().map(|point| point.coords).sum();
        mesh.positions_m.push(Point3::from(sum / points.len() as f64));
        for k in 0..size {
            let (from, to) = if flip { (at(ring, k + 1), at(ring, k)) } else { (at(ring, k), at(ring, k + 1)) };
            mesh.triangles.push([center, from, to]);
        }
    }
    mesh
}

/// Revolves a profile of (radius, height) about the y axis in `segments` steps.
///
/// The profile starts and ends on the axis. The solid lies on its left, seen with the radius
/// to the right and the height up.
pub(super) fn lathe(profile: &[[f64; 2]], segments: u32) -> RawMesh {
    let mut mesh = RawMesh::new(Vec::new(), Vec::new());
    let [[_, bottom], rim @ .., [_, top]] = profile else {
        return mesh;
    };
    mesh.positions_m.push(Point3::new(0.0, *bottom, 0.0));
    mesh.positions_m.push(Point3::new(0.0, *top, 0.0));
    for [radius, height] in rim {
        for k in 0..segments {
            let angle = TAU * f64::from(k) / f64::from(segments);
            mesh.positions_m.push(Point3::new(radius * angle.cos(), *height, -radius * angle.sin()));
        }
    }
    let at = |ring: u32, k: u32| 2 + ring * segments + k % segments;
    let rings = rim.len() as u32;
    for k in 0..segments {
        mesh.triangles.push([0, at(0, k + 1), at(0, k)]);
        for ring in 1..rings {
            let [a, b, c, d] = [at(ring - 1, k), at(ring - 1, k + 1), at(ring, k + 1), at(ring, k)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
        mesh.triangles.push([1, at(rings - 1, k), at(rings - 1, k + 1)]);
    }
    mesh
}
