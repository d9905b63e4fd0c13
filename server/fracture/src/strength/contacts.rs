//! Stress around the contacts of a body, of which several may press the same place.

use super::near_field::NearField;
use super::sliding::SlidingStress;
use super::tables::FACING;
use crate::elasticity::BELL_RADII;
use nalgebra::{Point3, Vector3};

/// Difference of two distances, in contact radii, below which contacts lie at one place.
const SAME_PLACE: f64 = 0.1;

/// Force of a contact on a boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceForce {
    /// Middle of the contact, on the boundary.
    pub place: Point3<f64>,
    /// Outer normal there.
    pub normal: Vector3<f64>,
    /// Force on the body.
    pub force: Vector3<f64>,
    /// Contact radius.
    pub radius: f64,
}

/// Constants of the stress around contacts.
#[derive(Clone, Copy, Debug)]
pub struct ContactStress<'a> {
    /// Stresses under tangential forces.
    pub sliding: &'a SlidingStress,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Half length of the lines over which stresses are averaged.
    pub length: f64,
    /// σ_t/σ_c.
    pub ratio: f64,
}

impl ContactStress<'_> {
    /// Largest average of the equivalent stress around contact `own` of `forces`, alone or with others beside it; 0 without
    /// force.
    ///
    /// Contacts within the bell of one another add up to one, whose bell has the second moment of theirs. Of those that
    /// grow with every further contact, the one with the largest stress counts, so that it changes continuously as
    /// contacts part.
    pub fn largest(&self, forces: &[SurfaceForce], own: usize) -> f64 {
        let SurfaceForce { place, normal, radius, .. } = forces[own];
        let beside = |other: &&SurfaceForce| {
            let reach = BELL_RADII * radius.max(other.radius);
            other.normal.dot(&normal) > FACING && (other.place - place).norm() <= reach
        };
        let mut beside: Vec<&SurfaceForce> = forces.iter().filter(beside).collect();
        let distance = |other: &SurfaceForce| (other.place - place).norm();
        beside.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        let (mut sum, mut most) = (ForceSum::default(), None::<f64>);
        for (index, other) in beside.iter().enumerate() {
            sum.add(other, &place);
            let next = beside.get(index + 1).map_or(f64::INFINITY, |next| distance(next));
            if sum.weight > 0.0 && next - distance(other) > SAME_PLACE * radius {
                let stress = self.of(&sum, &normal);
                most = Some(most.map_or(stress, |most| most.max(stress)));
            }
        }
        most.unwrap_or(0.0)
    }

    /// Largest average of the equivalent stress around the sum of contacts on a surface with this outer normal.
    fn of(&self, sum: &ForceSum, normal: &Vector3<f64>) -> f64 {
        let inward = -sum.force.dot(normal);
        let near = NearField {
            force: inward,
            tangential: (sum.force + normal * inward).norm(),
            radius: sum.radius(),
            poisson: self.poisson,
            sliding: self.sliding,
        };
        near.largest(self.length, self.ratio)
    }
}

/// Sums over contacts, of which each counts by the size of its force.
#[derive(Default)]
struct ForceSum {
    force: Vector3<f64>,
    weight: f64,
    moment: Vector3<f64>,
    square: f64,
}

impl ForceSum {
    fn add(&mut self, other: &SurfaceForce, origin: &Point3<f64>) {
        let (weight, offset) = (other.force.norm(), other.place - origin);
        self.force += other.force;
        self.weight += weight;
        self.moment += offset * weight;
        // Of the two axes along the surface, each has half of the squared distance.
        self.square += weight * (other.radius * other.radius + 0.5 * offset.norm_squared());
    }

    /// Radius of a bell with the second moment of the contacts around their middle.
    fn radius(&self) -> f64 {
        let middle = self.moment / self.weight;
        (self.square / self.weight - 0.5 * middle.norm_squared()).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn contact(x: f64, force: [f64; 3]) -> SurfaceForce {
        SurfaceForce { place: Point3::new(x, 0.0, 0.0), normal: Vector3::z(), force: force.into(), radius: 1.0 }
    }

    fn largest(forces: &[SurfaceForce], own: usize) -> f64 {
        let sliding = SlidingStress::new();
        ContactStress { sliding: &sliding, poisson: 0.22, length: 1e-2, ratio: 0.05 }.largest(forces, own)
    }

    #[test]
    fn a_force_in_parts_has_the_stress_of_the_whole() {
        let whole = largest(&[contact(0.0, [0.6, 0.0, -2.0])], 0);
        let parts = [contact(0.0, [0.0, 0.0, -2.0]), contact(0.0, [0.6, 0.0, 0.0])];
        let many = [contact(0.0, [0.075, 0.0, -0.25]); 8];
        for forces in [&parts[..], &many] {
            (0..forces.len()).for_each(|own| assert!((largest(forces, own) / whole - 1.0).abs() < 1e-9));
        }
        // Forces along the surface that cancel leave the pressure.
        let pair = [contact(0.0, [0.3, 0.0, -1.0]), contact(0.0, [-0.3, 0.0, -1.0])];
        let pressed = largest(&[contact(0.0, [0.0, 0.0, -2.0])], 0);
        assert!((largest(&pair, 0) / pressed - 1.0).abs() < 1e-9);
    }

    #[test]
    fn contacts_that_part_stress_the_surface_less_and_less() {
        let force = [0.3, 0.0, -1.0];
        let [one, two] = [1.0, 2.0].map(|factor| largest(&[contact(0.0, force.map(|own| factor * own))], 0));
        let apart: Vec<f64> =
            (0..40).map(|step| largest(&[contact(0.0, force), contact(0.1 * f64::from(step), force)], 0)).collect();
        assert!((apart[0] / two - 1.0).abs() < 1e-9 && (apart[39] / one - 1.0).abs() < 1e-9, "{apart:?}");
        for pair in apart.windows(2) {
            assert!(pair[1] <= pair[0] * (1.0 + 1e-12) && pair[1] > 0.9 * pair[0], "{apart:?}");
        }
        // Those on the other side of a wall do not count.
        let other = SurfaceForce { normal: -Vector3::z(), ..contact(0.0, [0.3, 0.0, 1.0]) };
        assert!((largest(&[contact(0.0, force), other], 0) / one - 1.0).abs() < 1e-12);
    }
}
