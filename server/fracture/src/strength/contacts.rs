//! Stress around the contacts of a body, of which several may press the same place.

use super::near_field::NearField;
use super::sliding::SlidingStress;
use super::tables::FACING;
use crate::elasticity::{BELL_CUT, BELL_RADII, BoundaryNodes, bell};
use crate::triangle::closest_point;
use nalgebra::{Point3, Vector3};

/// Second moment of the bell along one axis, over its squared radius: less than 1, since it ends at three radii.
const MOMENT: f64 = {
    let square = BELL_RADII * BELL_RADII;
    0.5 * (2.0 - BELL_CUT * (2.0 + square + 0.25 * square * square)) / (1.0 - BELL_CUT * (1.0 + 0.5 * square))
};

/// Cosine of the angle of two normals that count as one.
const EQUAL_NORMALS: f64 = 0.999;

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

impl SurfaceForce {
    /// Force of a contact of `radius` at a boundary point. Its normal is the mean of those of the faces that its bell
    /// reaches, so that it is continuous at edges; zero on a boundary without faces.
    pub fn new(boundary: &BoundaryNodes, place: Point3<f64>, force: Vector3<f64>, radius: f64) -> Self {
        let mut normals: Vec<(Vector3<f64>, f64)> = Vec::new();
        for nodes in &boundary.faces {
            let corners = nodes.map(|node| boundary.positions[node as usize]);
            let [a, b, c] = corners;
            let longest = (b - a).norm().max((c - a).norm());
            if (a - place).norm() > BELL_RADII * radius + longest {
                continue;
            }
            let weight = bell((closest_point(&corners, &place) - place).norm() / radius);
            let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0).filter(|_| weight > 0.0) else { continue };
            match normals.iter_mut().find(|(known, _)| known.dot(&normal) > EQUAL_NORMALS) {
                Some((_, known)) => *known = known.max(weight),
                None => normals.push((normal, weight)),
            }
        }
        let sum: Vector3<f64> = normals.iter().map(|(normal, weight)| normal * *weight).sum();
        Self { place, normal: sum.try_normalize(0.0).unwrap_or_default(), force, radius }
    }

    /// Force into the surface, and along it.
    fn parts(&self) -> (f64, Vector3<f64>) {
        let inward = -self.force.dot(&self.normal);
        (inward, self.force + self.normal * inward)
    }
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
    /// force or normal.
    ///
    /// The nearest contacts within the bell add up to one, whose bell has the second moment of theirs: the nearest one, two
    /// and so on, of which the largest stress counts. Fewer count in proportion to the gap to the next, up to a radius, so
    /// that the stress changes continuously as contacts part.
    pub fn largest(&self, forces: &[SurfaceForce], own: usize) -> f64 {
        let SurfaceForce { place, normal, radius, .. } = forces[own];
        let distance = |other: &SurfaceForce| (other.place - place).norm();
        let beside = |other: &&SurfaceForce| {
            let reach = BELL_RADII * radius.max(other.radius);
            other.normal.dot(&normal) > FACING && distance(other) <= reach
        };
        let mut beside: Vec<&SurfaceForce> = forces.iter().filter(beside).collect();
        beside.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        let sums = beside.iter().scan(ForceSum::default(), |sum, other| {
            sum.add(other, &place);
            Some(*sum)
        });
        let sums: Vec<ForceSum> = sums.collect();
        let Some(whole) = sums.last() else { return 0.0 };
        let mut joint = self.of(whole, &normal);
        let mut most = joint;
        for (index, sum) in sums.iter().enumerate().rev().skip(1) {
            let gap = ((distance(beside[index + 1]) - distance(beside[index])) / radius).min(1.0);
            if gap > 0.0 {
                joint += (self.of(sum, &normal) - joint) * gap;
                most = most.max(joint);
            }
        }
        most
    }

    /// Largest average of the equivalent stress around the sum of contacts on a surface with this outer normal.
    fn of(&self, sum: &ForceSum, normal: &Vector3<f64>) -> f64 {
        if sum.weight == 0.0 {
            return 0.0;
        }
        let near = NearField {
            force: sum.inward,
            tangential: (sum.along - normal * sum.along.dot(normal)).norm(),
            radius: sum.radius(),
            poisson: self.poisson,
            sliding: self.sliding,
        };
        near.largest(self.length, self.ratio)
    }
}

/// Sums over contacts, of which each counts by the size of its force.
#[derive(Clone, Copy, Default)]
struct ForceSum {
    /// Force into the surface, each along its own normal.
    inward: f64,
    /// Force along the surface.
    along: Vector3<f64>,
    weight: f64,
    moment: Vector3<f64>,
    square: f64,
}

impl ForceSum {
    fn add(&mut self, other: &SurfaceForce, origin: &Point3<f64>) {
        let (weight, offset, (inward, along)) = (other.force.norm(), other.place - origin, other.parts());
        self.inward += inward;
        self.along += along;
        self.weight += weight;
        self.moment += offset * weight;
        // Of the two axes along the surface, each has half of the squared distance.
        self.square += weight * (MOMENT * other.radius * other.radius + 0.5 * offset.norm_squared());
    }

    /// Radius of a bell with the second moment of the contacts around their middle.
    fn radius(&self) -> f64 {
        let middle = self.moment / self.weight;
        ((self.square / self.weight - 0.5 * middle.norm_squared()) / MOMENT).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::kuhn;

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
        let sliding = SlidingStress::new();
        let near = NearField { force: 2.0, tangential: 0.6, radius: 1.0, poisson: 0.22, sliding: &sliding };
        assert!((whole / near.largest(1e-2, 0.05) - 1.0).abs() < 1e-9);
        // A contact without force changes none, and has no stress.
        let none = contact(0.0, [0.0; 3]);
        assert_eq!((largest(&[none], 0), largest(&[contact(0.0, [0.6, 0.0, -2.0]), none], 1)), (0.0, whole));
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
        // Tangential forces that cancel do so the more, the closer they are.
        let [own, other] = [0.3, -0.3].map(|along| [along, 0.0, -1.0]);
        let apart: Vec<f64> =
            (0..40).map(|step| largest(&[contact(0.0, own), contact(0.05 * f64::from(step), other)], 0)).collect();
        assert!(apart.windows(2).all(|pair| (pair[1] / pair[0] - 1.0).abs() < 0.1), "{apart:?}");
        // Those on the other side of a wall do not count.
        let other = SurfaceForce { normal: -Vector3::z(), ..contact(0.0, [0.3, 0.0, 1.0]) };
        assert!((largest(&[contact(0.0, force), other], 0) / one - 1.0).abs() < 1e-12);
    }

    #[test]
    fn straight_presses_on_faces_of_several_directions_stay_straight() {
        let press = |angle: f64| {
            let normal = Vector3::new(angle.sin(), 0.0, angle.cos());
            SurfaceForce { place: Point3::from(normal), normal, force: -normal, radius: 1.0 }
        };
        let one = largest(&[press(0.0)], 0);
        let pair = largest(&[press(0.0), press(0.7)], 0);
        assert!(pair > one && pair < 2.0 * one, "{pair}, {one}");
    }

    #[test]
    fn normals_are_those_of_the_faces_that_the_bell_reaches() {
        let boundary = BoundaryNodes::new(&crate::lattice::block([4, 4, 4], 0.25));
        let normal =
            |x: f64, radius: f64| SurfaceForce::new(&boundary, [x, 0.1, 0.5].into(), Vector3::z(), radius).normal;
        let edge = (Vector3::x() + Vector3::z()).normalize();
        assert!((normal(0.5, 0.01) - edge).norm() < 1e-12);
        assert!((normal(0.5 - 1e-6, 0.01) - edge).norm() < 1e-3);
        assert_eq!(normal(0.46, 0.01), Vector3::z());
        // However many triangles each face has there: one or two.
        let boundary = BoundaryNodes::new(&kuhn([4, 4, 4], 0.25));
        for corner in 0..8 {
            let place = Vector3::from_fn(|axis, _| if corner >> axis & 1 == 0 { -0.5 } else { 0.5 });
            let normal = SurfaceForce::new(&boundary, place.into(), Vector3::z(), 0.01).normal;
            assert!((normal - place.normalize()).norm() < 1e-12, "{place}: {normal}");
        }
        let between = normal(0.48, 0.01);
        assert!(between.x > 0.05 && between.z > 0.9, "{between}");
    }
}
