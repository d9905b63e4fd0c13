//! Tests of thin plates and rods: the part that a lattice keeps, by thickness over spacing.

use super::*;
use crate::cancel_token::CancelToken;
use crate::random::RandomStream;
use nalgebra::{Isometry3, Vector3};

/// Rotated box.
struct Turned {
    half: Vector3<f64>,
    place: Isometry3<f64>,
}

impl SignedDistance for Turned {
    fn signed_distance(&self, point: &Point3<f64>) -> f64 {
        let offset = self.place.inverse_transform_point(point).coords.abs() - self.half;
        offset.sup(&Vector3::zeros()).norm() + offset.max().min(0.0)
    }

    fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        let reach = Vector3::repeat(self.half.norm());
        (Point3::from(self.place.translation.vector - reach), Point3::from(self.place.translation.vector + reach))
    }
}

/// Smallest share of the mid-surface kept, and largest number of bodies, over rotated and
/// shifted boxes of this thickness.
fn kept(half: Vector3<f64>, spacing: f64) -> (f64, usize) {
    let mut stream = RandomStream::new(1, 0);
    let thick = half.min();
    let (mut kept, mut bodies) = (1.0f64, 0);
    for _ in 0..12 {
        let angle = Vector3::from_fn(|_, _| 6.0 * stream.uniform());
        let shift = Vector3::from_fn(|_, _| stream.uniform());
        let shape = Turned { half, place: Isometry3::new(shift, angle) };
        let Ok(level) = stuff(&shape, spacing, Some(8.0 * half.product()), &CancelToken::default()) else {
            return (0.0, 0);
        };
        bodies = bodies.max(level.bodies.len());
        let locator = Locator::new(&level.bodies[0]);
        let mut uniform = |reach: f64| if reach == thick { 0.0 } else { (1.8 * stream.uniform() - 0.9) * reach };
        let middle: Vec<Point3<f64>> = (0..500).map(|_| shape.place * Point3::from(half.map(&mut uniform))).collect();
        let inside = middle.iter().filter(|point| locator.containing(point, None).is_some()).count();
        kept = kept.min(inside as f64 / 500.0);
    }
    (kept, bodies)
}

#[test]
fn plates_and_rods_thicker_than_the_spacing_stay_whole() {
    let spacing = 0.04;
    for (ratio, plate_whole, rod_whole) in
        [(0.6, false, false), (1.0, false, false), (1.25, true, false), (1.5, true, true), (2.0, true, true)]
    {
        let thick = ratio * spacing / 2.0;
        let bodies = [(Vector3::new(0.35, 0.35, thick), plate_whole), (Vector3::new(0.5, thick, thick), rod_whole)];
        for (half, whole) in bodies {
            let (kept, bodies) = kept(half, spacing);
            println!("{half:?} at {spacing}: mid-surface kept {kept:.3}, at most {bodies} bodies");
            assert_eq!(kept == 1.0 && bodies == 1, whole, "{ratio}");
        }
    }
}
