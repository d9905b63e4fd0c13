//! Boundary of a lattice as a triangle mesh of its own, for contacts and rays.

use super::face_search::{FaceBoxes, FaceSearch, NearestBoundaryPoint, SurfaceFaces};
use crate::lattice::Lattice;
use crate::memory::held;
use nalgebra::{Point3, Vector3};

/// Boundary nodes, numbered consecutively, and their faces.
#[derive(Clone, Debug)]
pub struct BoundaryNodes {
    /// Lattice node of each boundary node, ascending.
    pub nodes: Vec<u32>,
    /// Position of each boundary node, local.
    pub positions: Vec<Point3<f64>>,
    /// Area of each boundary node: a third of that of the faces around it; local.
    pub areas: Vec<f64>,
    /// Boundary nodes of each face.
    pub faces: Vec<[u32; 3]>,
    /// Tetrahedron of each face.
    pub tets: Vec<u32>,
    /// Start of each node's faces in `incident`; length nodes + 1.
    starts: Vec<u32>,
    /// Faces around each node, node after node.
    incident: Vec<u32>,
    /// Boxes of the faces.
    boxes: FaceBoxes,
}

impl BoundaryNodes {
    /// Extracts the boundary of `lattice`.
    pub fn new(lattice: &Lattice) -> Self {
        let outer = lattice.boundary();
        let mut nodes: Vec<u32> = outer.iter().flat_map(|face| face.nodes).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let positions: Vec<_> = nodes.iter().map(|&node| lattice.nodes[node as usize]).collect();
        let dense = |node: u32| nodes.partition_point(|&other| other < node) as u32;
        let faces: Vec<[u32; 3]> = outer.iter().map(|face| face.nodes.map(dense)).collect();
        let tets = outer.iter().map(|face| face.tet).collect();
        let (starts, incident) = around(nodes.len(), &faces);
        let mut areas = vec![0.0; nodes.len()];
        for face in &faces {
            let [a, b, c] = face.map(|node| positions[node as usize]);
            let third = (b - a).cross(&(c - a)).norm() / 6.0;
            face.iter().for_each(|&node| areas[node as usize] += third);
        }
        let boxes = FaceBoxes::new(faces.len(), |face| faces[face].map(|node| positions[node as usize]));
        Self { nodes, positions, areas, faces, tets, starts, incident, boxes }
    }

    /// Bytes of memory that it holds.
    pub fn bytes(&self) -> usize {
        let Self { nodes, positions, areas, faces, tets, starts, incident, boxes } = self;
        let around = held(starts) + held(incident) + boxes.bytes();
        held(nodes) + held(positions) + held(areas) + held(faces) + held(tets) + around
    }

    /// Area of face `face`, local.
    pub fn area(&self, face: usize) -> f64 {
        0.5 * self.doubled_area(face).norm()
    }

    /// Outward vector of face `face` whose length is twice its area, local.
    pub fn doubled_area(&self, face: usize) -> Vector3<f64> {
        let [a, b, c] = self.corners(face);
        (b - a).cross(&(c - a))
    }

    /// Faces around boundary node `node`.
    pub fn around(&self, node: u32) -> &[u32] {
        &self.incident[self.starts[node as usize] as usize..self.starts[node as usize + 1] as usize]
    }

    /// The faces, to be searched.
    pub fn search(&self) -> FaceSearch<'_> {
        FaceSearch { faces: self, boxes: &self.boxes }
    }

    /// Nearest boundary point to `point`; the lowest face wins ties. `None` if there are no faces.
    pub fn nearest(&self, point: &Point3<f64>) -> Option<NearestBoundaryPoint> {
        self.search().nearest(point)
    }
}

impl SurfaceFaces for BoundaryNodes {
    fn count(&self) -> usize {
        self.faces.len()
    }

    fn corners(&self, face: usize) -> [Point3<f64>; 3] {
        self.faces[face].map(|node| self.positions[node as usize])
    }
}

fn around(nodes: usize, faces: &[[u32; 3]]) -> (Vec<u32>, Vec<u32>) {
    let mut pairs: Vec<(u32, u32)> =
        faces.iter().enumerate().flat_map(|(face, nodes)| nodes.map(|node| (node, face as u32))).collect();
    pairs.sort_unstable();
    let starts = (0..=nodes as u32).map(|node| pairs.partition_point(|pair| pair.0 < node) as u32).collect();
    (starts, pairs.into_iter().map(|pair| pair.1).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::triangle::closest_point;

    /// Compares with a search of every face.
    fn check(boundary: &BoundaryNodes, point: Point3<f64>) {
        let mut plain: Option<NearestBoundaryPoint> = None;
        for face in 0..boundary.faces.len() {
            let place = closest_point(&boundary.corners(face), &point);
            let distance = (place - point).norm();
            if plain.is_none_or(|plain| distance < plain.distance) {
                plain = Some(NearestBoundaryPoint { face, place, distance });
            }
        }
        assert_eq!(boundary.nearest(&point), plain, "{point}");
    }

    #[test]
    fn the_tree_finds_the_same_face_as_brute_force() {
        let boundary = BoundaryNodes::new(&crate::lattice::block([5, 4, 6], 0.1));
        assert!(boundary.faces.len() > 200);
        boundary.positions.iter().for_each(|corner| check(&boundary, *corner));
        for scale in [0.1, 1.0, 30.0] {
            let mut stream = crate::random::RandomStream::new(8, 0);
            (0..200).for_each(|_| check(&boundary, Point3::from([(); 3].map(|()| scale * (stream.uniform() - 0.5)))));
        }
        let nowhere = boundary.nearest(&Point3::new(1e300, 0.0, 0.0)).unwrap();
        assert_eq!((nowhere.face, nowhere.distance), (0, f64::INFINITY));
    }
}
