//! Specimens of mechanical testing: nominal stress at which they break, over the strength.

use super::*;
use crate::cancel_token::CancelToken;
use crate::elasticity::{ElasticWorkspace, Elasticity};
use crate::lattice::{Lattice, block};
use crate::reference::traction;
use crate::scene::Material;
use nalgebra::{Matrix3, Point3};

/// A body under a self-balanced traction of unit nominal stress.
struct Specimen {
    lattice: Lattice,
    body: Elasticity,
    /// Extent that the size of the specimen counts, local.
    extent: f64,
    displacement: Vec<f64>,
    /// Strain energy at unit nominal stress, local.
    energy: f64,
}

impl Specimen {
    fn new(cells: [usize; 3], stress: impl Fn(Point3<f64>) -> Matrix3<f64>) -> Self {
        let lattice = block(cells, 1.0);
        let token = CancelToken::default();
        let body = Elasticity::prepare(&lattice, 0.2, &token).unwrap();
        let forces = traction(&lattice, stress);
        let mut displacement = Vec::new();
        body.solve(&forces, &mut displacement, &mut ElasticWorkspace::default(), &token).unwrap();
        let energy = body.elastic_energy(&forces, &displacement);
        Self { lattice, body, extent: cells.into_iter().max().unwrap() as f64, displacement, energy }
    }

    /// Nominal stress at which the specimen breaks over the tensile strength, and the onset at the strength, if its largest
    /// extent is `size_m`.
    fn broken_at(&self, constants: &StrengthConstants, size_m: f64) -> (f64, Onset) {
        let meter = size_m / self.extent;
        let ratio = constants.strength_pa / constants.compressive_strength_pa;
        let radius = (constants.characteristic_length_m() / meter).max(self.body.spacing());
        let tables = StrengthTables::new(&self.body, &self.lattice);
        let deformation = Deformation::Displacement(&self.displacement);
        let hot = tables.hot_spots((&self.body, &self.lattice), deformation, &[], (radius, ratio)).unwrap()[0];
        let mut sections = tables.sections(&self.lattice);
        let section = sections.smallest(hot.node, &normals_around(hot.direction), 1.0).unwrap();
        let strain_j = constants.strength_pa.powi(2) / constants.young_pa * meter.powi(3) * self.energy;
        let section_m2 = section.area * meter * meter;
        let energy_over_section = strain_j / (constants.toughness_j_m2 * section_m2);
        let onset = Onset { stress_over_strength: hot.stress, energy_over_section, section_m2 };
        (onset.load_factor(), onset)
    }
}

fn constants(name: &str) -> StrengthConstants {
    StrengthConstants::of(name, &Material::named(name).unwrap())
}

fn along_x(value: f64) -> Matrix3<f64> {
    Matrix3::new(value, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
}

/// Checks a specimen of glass and of concrete over four decades of size: it breaks at `nominal` times the strength, or by
/// energy.
fn check(specimen: &Specimen, name: &str, nominal: f64) {
    for material in ["glass", "concrete"] {
        let constants = constants(material);
        for size_m in [1e-3, 1e-2, 0.1, 1.0, 10.0] {
            let (found, onset) = specimen.broken_at(&constants, size_m);
            let by_energy = onset.energy_over_section.sqrt().recip();
            eprintln!("{name} of {material}, {size_m} m: breaks at {found:.3} σ_t, by energy at {by_energy:.3}");
            let by_strength = onset.stress_over_strength.recip();
            assert!((0.9..1.1).contains(&(by_strength / nominal)) || by_energy > 3.0, "{name}: {by_strength}");
            assert!((found / by_strength.max(by_energy) - 1.0).abs() < 1e-12);
            // Strength decides where ℓ_c is small against the specimen, energy where it is not.
            let relative = constants.characteristic_length_m() / size_m;
            assert!(relative > 2e-3 || (0.9..1.1).contains(&(found / nominal)), "{name} of {material}: {found}");
            assert!(relative < 2.0 || found > by_strength, "{name} of {material}: {found}");
        }
    }
}

#[test]
fn pulled_specimens_break_at_their_strength() {
    for (cells, name) in [([4, 4, 4], "cube"), ([20, 4, 4], "rod"), ([12, 12, 4], "plate")] {
        let specimen = Specimen::new(cells, |_| along_x(1.0));
        check(&specimen, name, 1.0);
        // Uniform stress: U = σ²V/(2E), so that σ/σ_t = √(2π ℓ_c/H) with the height H = V/A.
        let constants = constants("concrete");
        let (found, _) = specimen.broken_at(&constants, 0.01);
        let height_m = 0.01 * cells[0] as f64 / specimen.extent;
        let exact = (std::f64::consts::TAU * constants.characteristic_length_m() / height_m).sqrt();
        assert!((found / exact - 1.0).abs() < 1e-6, "{name}: {found} for {exact}");
    }
}

#[test]
fn bent_specimens_break_at_their_strength() {
    for cells in [[24, 4, 4], [24, 6, 6]] {
        let half = 0.5 * cells[1] as f64;
        let specimen = Specimen::new(cells, |place| along_x(place.y / half));
        check(&specimen, &format!("bent bar of {} cells", cells[1]), 1.0);
    }
    let specimen = Specimen::new([12, 12, 4], |place| {
        Matrix3::from_diagonal(&nalgebra::Vector3::new(1.0, 1.0, 0.0)) * (place.z / 2.0)
    });
    check(&specimen, "plate bent to a sphere", 1.0);
}

/// Means that hold the strains already count once, and lose what they exceed those of the surface by.
#[test]
fn strains_of_completions_replace_their_means() {
    let Specimen { lattice, body, displacement, .. } = Specimen::new([4, 4, 4], |_| along_x(1.0));
    let tables = StrengthTables::new(&body, &lattice);
    // Of uniaxial tension, ν = 0.2.
    let strains = [1.0, -0.2, -0.2, 0.0, 0.0, 0.0].repeat(lattice.nodes.len());
    for factors in [[1.0, 1.0], [1.0, 1.3], [0.4, 0.5]] {
        let deformation = Deformation::NodeStrains { strains: &strains, completion: Some((&displacement, factors)) };
        let found = tables.hot_spots((&body, &lattice), deformation, &[], (1.0, 0.05)).unwrap()[0].stress;
        let exact = 1.0 + factors[1] - factors[0];
        assert!((found / exact - 1.0).abs() < 1e-6, "{found} for {exact}");
    }
}

#[test]
fn a_pillar_holds_its_compressive_strength_when_pressed_end_on() {
    let pulled = Specimen::new([20, 4, 4], |_| along_x(1.0));
    let pressed = Specimen::new([20, 4, 4], |_| along_x(-1.0));
    for material in ["glass", "concrete", "ice"] {
        let constants = constants(material);
        // Large enough for strength to decide both.
        let [pulled, pressed] = [&pulled, &pressed].map(|specimen| specimen.broken_at(&constants, 30.0).0);
        let ratio = constants.compressive_strength_pa / constants.strength_pa;
        assert!((pressed / pulled / ratio - 1.0).abs() < 0.15, "{material}: {} for {ratio}", pressed / pulled);
    }
}
