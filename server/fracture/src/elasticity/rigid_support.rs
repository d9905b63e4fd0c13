//! Support of a body while its stiffness is factored.

use super::ElasticityError;
use crate::lattice::Lattice;
use crate::memory::held;
use crate::sparse::SymmetricMatrix;
use nalgebra::{Matrix3, Point3, Vector3};

/// Constraint that removes the rigid motions from the stiffness.
#[derive(Clone, Debug, PartialEq)]
pub enum Support {
    /// Free body: six components are pinned. They carry nothing under a load in equilibrium.
    Free(PinnedNodes),
    /// Anchored body: these nodes do not move and may carry any load.
    Anchored(Vec<u32>),
}

/// Three nodes that are pinned statically determinately.
///
/// The first is held in all directions, the second across the line to the first, the third
/// out of the plane of the three.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinnedNodes {
    nodes: [u32; 3],
    /// Frame of the pins. Columns: along the line, across it in the plane, out of the plane.
    frame: Matrix3<f64>,
}

impl PinnedNodes {
    /// Pins at these three nodes. `None` if they lie on a line.
    pub fn on(lattice: &Lattice, nodes: [u32; 3]) -> Option<Self> {
        let [a, b, c] = nodes.map(|node| lattice.nodes[node as usize]);
        let along = (b - a).try_normalize(0.0)?;
        let reach = (c - a).norm();
        let normal = along.cross(&(c - a)).try_normalize(1e-9 * reach)?;
        Some(Self { nodes, frame: Matrix3::from_columns(&[along, normal.cross(&along), normal]) })
    }

    /// Pins at three nodes far apart. `None` if all nodes lie on a line.
    ///
    /// They are the farthest node from the mean of the nodes, the farthest from that one, and the farthest from the
    /// line of both. Lower indices win ties.
    pub fn far_apart(lattice: &Lattice) -> Option<Self> {
        let sum: Vector3<f64> = lattice.nodes.iter().map(|x| x.coords).sum();
        let mean = Point3::from(sum / lattice.nodes.len() as f64);
        let a = farthest(lattice, |x| (x - mean).norm_squared())?;
        let start = lattice.nodes[a as usize];
        let b = farthest(lattice, |x| (x - start).norm_squared())?;
        let along = lattice.nodes[b as usize] - start;
        let c = farthest(lattice, |x| along.cross(&(x - start)).norm_squared())?;
        Self::on(lattice, [a, b, c])
    }
}

fn farthest(lattice: &Lattice, measure: impl Fn(&Point3<f64>) -> f64) -> Option<u32> {
    let mut best = None;
    for (node, place) in lattice.nodes.iter().enumerate() {
        let value = measure(place);
        if best.is_none_or(|(_, greatest)| value > greatest) {
            best = Some((node as u32, value));
        }
    }
    best.map(|(node, _)| node)
}

/// Largest distance of collinear anchors from their line, over their extent.
const LINE_SHARE: f64 = 1e-9;

/// Rejects anchors that are no node of `count` nodes, an empty list of anchors, and anchors that all lie on a line.
pub(super) fn check_anchors(
    nodes: &[u32],
    count: usize,
    place: impl Fn(usize) -> Vector3<f64>,
) -> Result<(), ElasticityError> {
    if let Some(&node) = nodes.iter().find(|&&node| node as usize >= count) {
        return Err(ElasticityError::UnknownAnchor { node });
    }
    let arms = || nodes.iter().map(|&node| place(node as usize) - place(nodes[0] as usize));
    let longer = |longest: Vector3<f64>, arm: Vector3<f64>| {
        if arm.norm_squared() > longest.norm_squared() { arm } else { longest }
    };
    let along = arms().fold(Vector3::zeros(), longer);
    let across = arms().map(|arm| along.cross(&arm).norm()).fold(0.0, f64::max);
    let holds = across > LINE_SHARE * along.norm_squared();
    if holds { Ok(()) } else { Err(ElasticityError::AnchorsInLine { nodes: nodes.len() }) }
}

impl Support {
    /// Bytes of memory that it holds beyond its own size.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Free(_) => 0,
            Self::Anchored(nodes) => held(nodes),
        }
    }

    /// Rotates the pinned nodes into their frame and fixes the held components.
    pub(super) fn constrain(&self, stiffness: &mut SymmetricMatrix<3>) {
        let diagonal = stiffness.diagonal();
        let mean = diagonal.iter().sum::<f64>() / diagonal.len() as f64;
        if let Self::Free(pins) = self {
            for node in pins.nodes {
                stiffness.rotate(node as usize, &pins.frame);
            }
        }
        self.held(|node, component| stiffness.fix(node, component, mean));
    }

    /// Rotates a vector (three components per node) into the frames of the held nodes and zeroes the held components.
    pub(super) fn enter(&self, vector: &mut [f64]) {
        if let Self::Free(pins) = self {
            pins.turn(vector, &pins.frame.transpose());
        }
        self.held(|node, component| vector[3 * node + component] = 0.0);
    }

    /// Rotates a vector back from the frames of the held nodes.
    pub(super) fn leave(&self, vector: &mut [f64]) {
        if let Self::Free(pins) = self {
            pins.turn(vector, &pins.frame);
        }
    }

    /// Drops from a residual the part that reactions carry: that at anchors. Reactions at
    /// pins must vanish, so they stay.
    pub(super) fn drop_reactions(&self, residual: &mut [f64]) {
        if let Self::Anchored(_) = self {
            self.held(|node, component| residual[3 * node + component] = 0.0);
        }
    }

    /// Calls `fix` with every held (node, component).
    fn held(&self, mut fix: impl FnMut(usize, usize)) {
        match self {
            Self::Free(PinnedNodes { nodes: [a, b, c], .. }) => {
                (0..3).for_each(|component| fix(*a as usize, component));
                (1..3).for_each(|component| fix(*b as usize, component));
                fix(*c as usize, 2);
            }
            Self::Anchored(nodes) => {
                for &node in nodes {
                    (0..3).for_each(|component| fix(node as usize, component));
                }
            }
        }
    }
}

impl PinnedNodes {
    fn turn(&self, vector: &mut [f64], matrix: &Matrix3<f64>) {
        for node in self.nodes {
            let own = &mut vector[3 * node as usize..][..3];
            let turned = matrix * Vector3::from_column_slice(own);
            own.copy_from_slice(turned.as_slice());
        }
    }
}
