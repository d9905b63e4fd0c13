//! Plan of the study: object and values of the settings.

use nalgebra::{Point3, Vector3};
use shatter_fracture::pipeline::Preset;
use shatter_fracture::surface::{RawMesh, shapes};

/// Number of impacts of a full study. Intervals of medians need a few dozen.
pub const IMPACTS_DEFAULT: u64 = 24;

/// Nodes up to which elastic lattices are refined: two refinements of `film` have 0.8 million, which takes 3 GB.
const REFINED_NODES_MAX: usize = 1_500_000;

/// Spacing of the surface of [`figure`], m.
const FIGURE_SPACING_M: f64 = 0.006;

/// Ends and radii of the rods of [`figure`], m.
const RODS: [([f64; 3], [f64; 3], f64); 8] = [
    ([0.0, 0.42, 0.0], [0.0, 0.66, 0.0], 0.06),
    ([0.0, 0.66, 0.0], [0.0, 0.82, 0.0], 0.035),
    ([0.0, 0.84, 0.0], [0.0, 0.88, 0.0], 0.065),
    ([0.0, 0.66, 0.0], [0.22, 0.58, 0.0], 0.026),
    ([0.22, 0.58, 0.0], [0.36, 0.72, 0.05], 0.022),
    ([0.0, 0.66, 0.0], [-0.34, 0.5, 0.04], 0.024),
    ([0.0, 0.42, 0.0], [0.12, 0.03, 0.02], 0.03),
    ([0.0, 0.42, 0.0], [-0.13, 0.03, -0.03], 0.03),
];

/// Plan of a study: an object, impacts, and the values of every setting.
#[derive(Clone, Debug)]
pub struct AccuracyPlan {
    /// Name of the object.
    pub name: String,
    /// Its mesh.
    pub mesh: RawMesh,
    /// Number of impacts, spread over the surface; errors are medians over them.
    pub impacts: u64,
    /// Number of timed requests per impact.
    pub runs: usize,
    /// Number of sites, except for the setting that varies it.
    pub sites: u32,
    /// Number of starts of a diagram; the best one is the reference.
    pub starts: u32,
    /// Number of examples with which the object is baked.
    pub examples: u64,
    /// Number of impacts from which its reduced basis is built: those of the examples and further ones.
    pub snapshots: u64,
    /// Spacings of the object over the diagonal, elastic and crack; `None`: the defaults.
    pub spacings: Option<[f64; 2]>,
    /// Ratio of the nodes of the reference of cracks to the object's.
    pub finer: f64,
    /// Largest number of nodes of a refined elastic lattice, edges with quadratic functions included. References are refined
    /// up to three times where it allows that. The first refinement may have a few times as many.
    pub refined_nodes_max: usize,
    /// Further objects on which the presets' elastic energies are judged.
    pub bodies: Vec<StudyBody>,
    /// Presets that are judged on them, the finest last; `reference` has the lattices of `film`.
    pub body_presets: Vec<Preset>,
    /// Presets whose whole results are judged, the finest last.
    pub outcome_presets: Vec<Preset>,
    /// Largest number of impacts of which they are judged: the reference takes a hundred times as long as a request.
    pub outcome_impacts: usize,
    /// Ratio of the nodes of their reference to those of the finest preset.
    pub outcome_finer: f64,
    /// Number of results of their reference per impact, with different seeds.
    pub outcome_seeds: u64,
    /// Numbers of elastic nodes, over the object's.
    pub elastic: Vec<f64>,
    /// Ranks of the reduced basis.
    pub ranks: Vec<u32>,
    /// Numbers of crack nodes, over the object's.
    pub crack: Vec<f64>,
    /// Numbers of eigenfunctions of the interior lift; the largest is the reference.
    pub modes: Vec<usize>,
    /// Tolerances of the diagram.
    pub tolerances: Vec<f64>,
    /// Seed of all random choices.
    pub seed: u64,
}

/// Object of a study.
#[derive(Clone, Debug)]
pub struct StudyBody {
    /// Name.
    pub name: String,
    /// Mesh.
    pub mesh: RawMesh,
}

impl StudyBody {
    /// Object of this name.
    pub fn new(name: impl Into<String>, mesh: RawMesh) -> Self {
        Self { name: name.into(), mesh }
    }
}

impl AccuracyPlan {
    /// Full study of an object.
    pub fn new(name: impl Into<String>, mesh: RawMesh) -> Self {
        Self {
            name: name.into(),
            mesh,
            impacts: IMPACTS_DEFAULT,
            runs: 1,
            sites: 50,
            starts: 6,
            examples: 48,
            snapshots: 96,
            spacings: None,
            finer: 4.0,
            refined_nodes_max: REFINED_NODES_MAX,
            bodies: Vec::new(),
            body_presets: vec![Preset::Draft, Preset::Game, Preset::Film],
            outcome_presets: vec![Preset::Draft, Preset::Game, Preset::Film],
            outcome_impacts: 6,
            outcome_finer: 2.0,
            outcome_seeds: 3,
            elastic: vec![0.5, 1.0, 2.0],
            ranks: vec![8, 16, 32, 64, 128, 256],
            crack: vec![0.125, 0.25, 0.5, 1.0, 2.0],
            modes: vec![0, 3, 6, 10, 20, 40],
            tolerances: vec![1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 0.0],
            seed: 1,
        }
    }

    /// Full study of the generated statue.
    pub fn statue() -> Self {
        let bodies = vec![
            StudyBody::new("vase", shapes::vase()),
            StudyBody::new("pane", shapes::cuboid([0.4, 0.3, 0.01])),
            StudyBody::new("mug", shapes::mug()),
            StudyBody::new("figure", figure()),
            StudyBody::new("sphere", shapes::sphere(0.1, 5)),
        ];
        Self { bodies, ..Self::new("statue", shapes::statue()) }
    }

    /// Smallest possible study, for tests that it runs.
    pub fn quick(name: impl Into<String>, mesh: RawMesh) -> Self {
        Self {
            impacts: 2,
            runs: 1,
            sites: 6,
            starts: 2,
            examples: 8,
            snapshots: 24,
            spacings: Some([0.1, 0.08]),
            finer: 2.0,
            refined_nodes_max: 120_000,
            bodies: vec![StudyBody::new("ball", shapes::sphere(0.1, 3))],
            body_presets: vec![Preset::Draft, Preset::Game],
            outcome_presets: vec![Preset::Draft, Preset::Game],
            outcome_seeds: 2,
            elastic: vec![1.0],
            ranks: vec![8],
            crack: vec![0.5],
            modes: vec![0, 6],
            tolerances: vec![1e-1, 1e-3],
            ..Self::new(name, mesh)
        }
    }

    /// Number of progress steps.
    pub fn steps(&self) -> usize {
        let fixed = 3 + super::settings::FIXED;
        let fixed = fixed + self.bodies.len() + self.outcome_presets.len() + 1;
        fixed + self.elastic.len() + self.ranks.len() + self.crack.len() + self.modes.len() + self.tolerances.len()
    }
}

/// Figure of rods: body, head, two arms, one of them bent, and two legs.
fn figure() -> RawMesh {
    let distance =
        |p: &Point3<f64>| RODS.iter().map(|(from, to, radius)| rod(p, from, to) - radius).fold(f64::INFINITY, f64::min);
    shapes::implicit(Point3::new(-0.41, -0.03, -0.1), Point3::new(0.42, 0.98, 0.12), FIGURE_SPACING_M, distance)
}

/// Distance of a point from the line between two others.
fn rod(p: &Point3<f64>, from: &[f64; 3], to: &[f64; 3]) -> f64 {
    let [own, whole] = [p.coords, Vector3::from(*to)].map(|end| end - Vector3::from(*from));
    let share = (own.dot(&whole) / whole.norm_squared()).clamp(0.0, 1.0);
    (own - whole * share).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_figure_is_one_closed_body() {
        let mesh = figure();
        let mut edges = std::collections::HashMap::new();
        for [a, b, c] in &mesh.triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *edges.entry((from.min(to), from.max(to))).or_insert(0) += if from < to { 1 } else { -1 };
            }
        }
        assert!(mesh.triangles.len() > 5_000 && edges.values().all(|sum| *sum == 0));
        let high = mesh.positions_m.iter().map(|place| place.y).fold(0.0, f64::max);
        assert!((high - 0.945).abs() < 0.01, "{high}");
    }
}
