//! Boundary of a lattice as a triangle surface of its own, and its shells.

use super::laplacian::root;
use crate::lattice::Lattice;
use nalgebra::Point3;

/// Boundary surface of a lattice: closed and oriented outward.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundarySurface {
    /// Lattice node of each surface node, ascending.
    pub nodes: Vec<u32>,
    /// Positions of the surface nodes, local.
    pub positions: Vec<Point3<f64>>,
    /// Three surface nodes per triangle, counter-clockwise seen from outside the body.
    pub triangles: Vec<[u32; 3]>,
}

/// Connected component of a boundary: the outer one, or that of a cavity.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundaryShell {
    /// Surface node of each of the shell's nodes, ascending.
    pub nodes: Vec<u32>,
    /// Positions of the shell's nodes, local.
    pub positions: Vec<Point3<f64>>,
    /// Three of the shell's nodes per triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl BoundarySurface {
    /// Extracts the boundary of `lattice`.
    pub fn new(lattice: &Lattice) -> Self {
        let mut triangles: Vec<[u32; 3]> = lattice.boundary().iter().map(|face| face.nodes).collect();
        let nodes = renumber(&mut triangles, lattice.nodes.len());
        let positions = nodes.iter().map(|&node| lattice.nodes[node as usize]).collect();
        Self { nodes, positions, triangles }
    }

    /// Connected components, ordered by their lowest node.
    pub fn shells(&self) -> Vec<BoundaryShell> {
        let mut parents: Vec<u32> = (0..self.nodes.len() as u32).collect();
        for [a, b, c] in &self.triangles {
            for node in [b, c] {
                let (a, b) = (root(&mut parents, *a), root(&mut parents, *node));
                parents[a.max(b) as usize] = a.min(b);
            }
        }
        let mut roots: Vec<u32> = (0..self.nodes.len() as u32).map(|node| root(&mut parents, node)).collect();
        let names: Vec<u32> = (0..roots.len() as u32).filter(|&node| roots[node as usize] == node).collect();
        roots.iter_mut().for_each(|root| *root = names.partition_point(|name| *name < *root) as u32);
        let mut triangles = vec![Vec::new(); names.len()];
        for triangle in &self.triangles {
            triangles[roots[triangle[0] as usize] as usize].push(*triangle);
        }
        triangles.into_iter().map(|triangles| self.shell(triangles)).collect()
    }

    fn shell(&self, mut triangles: Vec<[u32; 3]>) -> BoundaryShell {
        let nodes = renumber(&mut triangles, self.nodes.len());
        let positions = nodes.iter().map(|&node| self.positions[node as usize]).collect();
        BoundaryShell { nodes, positions, triangles }
    }
}

impl BoundaryShell {
    /// Area of the shell, local.
    pub fn area(&self) -> f64 {
        let area = |[a, b, c]: [Point3<f64>; 3]| 0.5 * (b - a).cross(&(c - a)).norm();
        self.triangles.iter().map(|corners| area(corners.map(|node| self.positions[node as usize]))).sum()
    }
}

/// Renumbers the corners consecutively in their old order. Returns the old number of each new one.
fn renumber(triangles: &mut [[u32; 3]], count: usize) -> Vec<u32> {
    let mut used = vec![false; count];
    triangles.iter().flatten().for_each(|&node| used[node as usize] = true);
    let nodes: Vec<u32> = (0..count as u32).filter(|&node| used[node as usize]).collect();
    let mut renamed = vec![0; count];
    nodes.iter().enumerate().for_each(|(new, &old)| renamed[old as usize] = new as u32);
    triangles.iter_mut().flatten().for_each(|node| *node = renamed[*node as usize]);
    nodes
}
