//! Plan of the study: object and values of the settings.

use shatter_fracture::surface::{RawMesh, shapes};

/// Plan of a study: an object, impacts, and the values of every setting.
#[derive(Clone, Debug)]
pub struct AccuracyPlan {
    /// Name of the object.
    pub name: String,
    /// Its mesh.
    pub mesh: RawMesh,
    /// Number of impacts, spread over the surface; errors are medians over them.
    pub impacts: u64,
    /// Number of timed requests per impact, after one that is not timed.
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
    /// Ratio of the reference's nodes to the object's, on both levels.
    pub finer: f64,
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

impl AccuracyPlan {
    /// Full study of an object.
    pub fn new(name: impl Into<String>, mesh: RawMesh) -> Self {
        Self {
            name: name.into(),
            mesh,
            impacts: 6,
            runs: 3,
            sites: 50,
            starts: 6,
            examples: 48,
            snapshots: 960,
            spacings: None,
            finer: 4.0,
            elastic: vec![0.25, 0.5, 1.0, 2.0],
            ranks: vec![8, 16, 32, 64, 128, 256],
            crack: vec![0.125, 0.25, 0.5, 1.0, 2.0],
            modes: vec![0, 3, 6, 10, 20, 40],
            tolerances: vec![1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 0.0],
            seed: 1,
        }
    }

    /// Full study of the generated statue.
    pub fn statue() -> Self {
        Self::new("statue", shapes::statue())
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
        fixed + self.elastic.len() + self.ranks.len() + self.crack.len() + self.modes.len() + self.tolerances.len()
    }
}
