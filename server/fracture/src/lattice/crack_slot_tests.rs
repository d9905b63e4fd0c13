use super::*;
use crate::lattice::shapes::ball;
use crate::lattice::{EDGES, Lattice, check_manifold};
use crate::random::RandomStream;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

/// Radius of the cracked ball.
const RADIUS: f64 = 0.4;

/// Random rotation, and offset of up to half a spacing.
fn placed(seed: u64, spacing: f64) -> Isometry3<f64> {
    let mut random = RandomStream::new(seed, 5);
    let mut vector = || Vector3::new(random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5);
    let (axis, angle) = (vector() * 6.0, vector() * spacing);
    Isometry3::from_parts((vector() * 0.1 + angle).into(), UnitQuaternion::from_scaled_axis(axis))
}

/// Half plane z = 0, x < `end`, transformed by `place`.
#[derive(Clone, Copy)]
struct Sheet {
    place: Isometry3<f64>,
    end: f64,
}

impl Sheet {
    fn distance(&self, point: &Point3<f64>) -> f64 {
        let own = self.place.inverse_transform_point(point);
        own.z.hypot((own.x - self.end).max(0.0))
    }

    /// Number of lattice edges that pass through the sheet.
    fn crossings(&self, lattice: &Lattice) -> usize {
        let crosses = |tet: &[u32; 4], [i, j]: [usize; 2]| {
            let [a, b] = [i, j].map(|k| self.place.inverse_transform_point(&lattice.nodes[tet[k] as usize]));
            a.z * b.z < 0.0 && a.x + (b.x - a.x) * (a.z / (a.z - b.z)) < self.end
        };
        lattice.tets.iter().map(|tet| EDGES.iter().filter(|edge| crosses(tet, **edge)).count()).sum()
    }
}

/// Ball with a slot of half width `half` spacings along a sheet that ends at `end`.
fn slotted(seed: u64, spacing: f64, half: f64, end: f64) -> (Sheet, LatticeLevel) {
    let sheet = Sheet { place: placed(seed, spacing), end };
    let (shape, depth) = (ball(RADIUS), move |point: &Point3<f64>, half: f64| half - sheet.distance(point));
    let shape = Slotted { shape: &shape, depth: &depth, offset: 0.0, half: half * spacing };
    (sheet, stuff(&shape, spacing, None, &CancelToken::default()).unwrap())
}

/// Edges across randomly placed sheets, in lattices with slots of half width `half` spacings.
fn crossings(half: f64, end: f64, count: u64) -> usize {
    let across = |seed: u64| {
        let (sheet, level) = slotted(seed, 0.05 + 0.002 * (seed % 10) as f64, half, end);
        level.bodies.iter().for_each(|body| check_manifold(body).unwrap());
        level.bodies.iter().map(|body| sheet.crossings(body)).sum::<usize>()
    };
    (0..count).map(across).sum()
}

#[test]
fn no_edge_leads_across_a_sheet_wherever_it_lies() {
    assert_eq!([1.0, 0.0].map(|end| crossings(SLOT_HALF, end, 30)), [0, 0]);
    // Narrow slots do not suffice: at half a spacing, edges cross.
    assert!([1.0, 0.0].iter().all(|end| crossings(0.5, *end, 10) > 0));
}

#[test]
fn a_sheet_through_a_ball_makes_two_and_one_that_ends_in_it_does_not() {
    for seed in 0..6 {
        assert_eq!(slotted(seed, 0.05, SLOT_HALF, 1.0).1.bodies.len(), 2, "{seed}");
        assert_eq!(slotted(seed, 0.05, SLOT_HALF, 0.0).1.bodies.len(), 1, "{seed}");
    }
}

#[test]
fn away_from_its_slots_the_lattice_is_the_one_without() {
    let (shape, spacing, token) = (ball(RADIUS), 0.05, CancelToken::default());
    let sheet = Sheet { place: placed(3, spacing), end: 0.0 };
    let volume = 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3);
    let depth = |point: &Point3<f64>, half: f64| half - sheet.distance(point);
    let whole = stuff(&shape, spacing, Some(volume), &token).unwrap();
    let with = stuff_slotted(&shape, &depth, spacing, volume, &token).unwrap();
    let far = |node: &&Point3<f64>| sheet.distance(node) > 3.0 * spacing;
    let [mut one, mut other] =
        [&whole, &with].map(|level| level.bodies[0].nodes.iter().filter(far).copied().collect::<Vec<_>>());
    let order = |a: &Point3<f64>, b: &Point3<f64>| {
        let key = |p: &Point3<f64>| p.coords.map(|x| (x * 1e4).round() as i64);
        key(a).as_slice().cmp(key(b).as_slice())
    };
    one.sort_by(order);
    other.sort_by(order);
    assert!(one.len() > 500 && one.len() == other.len(), "{} {}", one.len(), other.len());
    assert!(one.iter().zip(&other).all(|(a, b)| (a - b).norm() < 0.01 * spacing));
    // Half a disc, and the half cylinder around its end.
    let slot = std::f64::consts::PI * RADIUS * RADIUS / 2.0 * 2.0 * SLOT_HALF * spacing;
    let lost = whole.volume() - with.volume();
    assert!(lost > 0.9 * slot && lost < 1.4 * slot, "{lost} {slot}");
}
