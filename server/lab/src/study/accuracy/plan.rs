//! What is tried, and on what.

use shatter_fracture::surface::{RawMesh, shapes};

/// One study: an object, impacts, and the values of every dial.
#[derive(Clone, Debug)]
pub struct AccuracyPlan {
    /// Name of the object.
    pub name: String,
    /// Its mesh.
    pub mesh: RawMesh,
    /// Impacts, spread over the surface; errors are medians over them.
    pub impacts: u64,
    /// Strikes of each impact that are timed, after one that is not.
    pub runs: usize,
    /// Sites of every strike but those of the dial that chooses their number.
    pub sites: u32,
    /// Starts of a diagram of which the best is the reference.
    pub starts: u32,
    /// Examples that the object is baked with.
    pub examples: u64,
    /// Impacts that its reduced basis is of: those of the examples and further ones.
    pub snapshots: u64,
    /// Spacings of the object itself over the diagonal, elastic and crack; `None`: the default's.
    pub spacings: Option<[f64; 2]>,
    /// The reference has so many times the nodes, on both levels.
    pub finer: f64,
    /// Nodes of the elastic lattices over those of the object's.
    pub elastic: Vec<f64>,
    /// Displacements of the reduced basis.
    pub ranks: Vec<u32>,
    /// Nodes of the crack lattices over those of the object's.
    pub crack: Vec<f64>,
    /// Eigenfunctions of the interior lift; the most are the reference.
    pub modes: Vec<usize>,
    /// Tolerances of the diagram.
    pub tolerances: Vec<f64>,
    /// Everything random follows from it.
    pub seed: u64,
}

impl AccuracyPlan {
    /// The whole study of an object.
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

    /// Of the generated statue.
    pub fn statue() -> Self {
        Self::new("statue", shapes::statue())
    }

    /// The least of everything: whether it runs, not what comes of it.
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

    /// Steps that progress is told of.
    pub fn steps(&self) -> usize {
        let fixed = 3 + super::dials::FIXED;
        fixed + self.elastic.len() + self.ranks.len() + self.crack.len() + self.modes.len() + self.tolerances.len()
    }
}
