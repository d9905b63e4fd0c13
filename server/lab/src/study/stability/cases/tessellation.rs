//! Cases: labels and crack points that are hard for marching tetrahedra.

use super::super::trial::TrialFault;
use nalgebra::Point3;
use shatter_fracture::fragment::{closed, properties};
use shatter_fracture::lattice::{Lattice, block};
use shatter_fracture::lift::{LiftKind, LiftedLattice};
use shatter_fracture::random::RandomStream;
use shatter_fracture::reference::perturbed;
use shatter_fracture::tessellation::{
    BisectorSites, FixedPoints, LocalToMeters, TessellationError, Topology, components, crack_points, tessellate,
};

impl From<TessellationError> for TrialFault {
    fn from(error: TessellationError) -> Self {
        Self::ours("tessellation", error.to_string())
    }
}

/// Relative difference between the sum of fragment volumes and the lattice's volume; an error if a fragment is open.
fn cut(lattice: &Lattice, site_labels: &[u32], lift: &LiftedLattice, coordinates: &[f64]) -> Result<f64, TrialFault> {
    let topology = Topology::new(lattice);
    let split = components(&topology, site_labels);
    let sites = BisectorSites { lift, coordinates, of_fragment: &split.sites, of_node: None };
    let points = crack_points(lattice, &topology, &split.labels, Some(sites), &FixedPoints::default())?;
    let cut = tessellate(lattice, &topology, &split.labels, &points)?;
    let mut measured = Vec::new();
    properties(&cut, &mut measured);
    let centers: Vec<Point3<f64>> = measured.iter().map(|fragment| fragment.center).collect();
    let mut positions = vec![[0.0; 3]; cut.vertex_count()];
    let mut indices = vec![0; cut.index_count()];
    let mut merges = vec![[0; 2]; cut.merge_count()];
    cut.emit(&centers, LocalToMeters { meters_per_unit: 1.0 }, &mut positions, &mut indices, &mut merges)?;
    for fragment in cut.fragments().iter().filter(|fragment| !fragment.runs.is_empty()) {
        let triangles = 3 * fragment.triangles.start..3 * fragment.triangles.end;
        closed(&positions[fragment.vertices.clone()], &indices[triangles])
            .map_err(|open| TrialFault::ours("open", open.to_string()))?;
    }
    let sum: f64 = measured.iter().map(|fragment| fragment.volume).sum();
    Ok((sum / lattice.volume() - 1.0).abs())
}

fn random_labels(nodes: usize, labels: u32, seed: u64) -> Vec<u32> {
    let mut stream = RandomStream::new(seed, 0);
    (0..nodes).map(|_| (stream.uniform() * f64::from(labels)) as u32).collect()
}

/// Largest difference over seeds and numbers of labels.
fn random(lattice: &Lattice, most: u32) -> Result<f64, TrialFault> {
    let mut worst = 0.0f64;
    for labels in 2..=most {
        let mut stream = RandomStream::new(u64::from(labels), 1);
        let lift = LiftedLattice::euclidean(lattice);
        let coordinates: Vec<f64> = (0..3 * labels).map(|_| stream.uniform() - 0.5).collect();
        let own = random_labels(lattice.nodes.len(), labels, u64::from(labels));
        worst = worst.max(cut(lattice, &own, &lift, &coordinates)?);
    }
    Ok(worst)
}

pub fn random_labels_on_a_block() -> Result<f64, TrialFault> {
    random(&block([4, 3, 3], 0.2), 20)
}

pub fn random_labels_on_a_perturbed_block() -> Result<f64, TrialFault> {
    random(&perturbed([4, 3, 3], 0.2, 0.1, 5), 12)
}

/// Eight octants of a block, whose bisectors run through whole layers of nodes.
pub fn ties_at_nodes() -> Result<f64, TrialFault> {
    let lattice = block([4, 4, 4], 0.1);
    let side = |bit: u32| if bit == 0 { -0.1 } else { 0.1 };
    let coordinates: Vec<f64> = (0..8u32).flat_map(|corner| [0, 1, 2].map(|bit| side(corner >> bit & 1))).collect();
    let octant = |node: &Point3<f64>| (0..3).map(|bit| u32::from(node[bit] > 1e-9) << bit).sum();
    let labels: Vec<u32> = lattice.nodes.iter().map(octant).collect();
    cut(&lattice, &labels, &LiftedLattice::euclidean(&lattice), &coordinates)
}

/// Sites at the nodes, so that crack points are at the ends of their edges.
pub fn sites_on_nodes() -> Result<f64, TrialFault> {
    let lattice = block([2, 2, 2], 0.2);
    let labels: Vec<u32> = (0..lattice.nodes.len() as u32).collect();
    let coordinates: Vec<f64> = lattice.nodes.iter().flat_map(|node| [node.x, node.y, node.z]).collect();
    cut(&lattice, &labels, &LiftedLattice::euclidean(&lattice), &coordinates)
}

/// Labels of sites at the same place, which have no bisector.
pub fn coincident_sites() -> Result<f64, TrialFault> {
    let lattice = block([3, 3, 3], 0.1);
    cut(&lattice, &random_labels(lattice.nodes.len(), 3, 7), &LiftedLattice::euclidean(&lattice), &[0.0; 9])
}

/// Random lifts of dimension 6, where most triple and quadruple points are outside their simplex.
pub fn exterior_points() -> Result<f64, TrialFault> {
    let lattice = perturbed([3, 3, 3], 0.1, 0.1, 11);
    let mut worst = 0.0f64;
    for seed in 0..10 {
        let mut stream = RandomStream::new(seed, 2);
        let coordinates: Vec<f64> = (0..6 * lattice.nodes.len()).map(|_| stream.uniform()).collect();
        let lift = LiftedLattice::scaled(LiftKind::Interior, &lattice, 6, coordinates);
        let sites: Vec<f64> = (0..36).map(|_| stream.uniform()).collect();
        worst = worst.max(cut(&lattice, &random_labels(lattice.nodes.len(), 6, seed), &lift, &sites)?);
    }
    Ok(worst)
}
