//! From the elastic lattice to the crack lattice: who gets which share of each elastic tetrahedron's energy.

use super::{Lattice, Locator};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Shares of elastic tetrahedra, by crack node (compressed rows).
///
/// Conservative by construction: the shares of every elastic tetrahedron sum to 1 over all crack nodes, so that the
/// nodes' energies sum to the tetrahedra's whatever those are. A crack node gets the tetrahedra that its barycentric
/// cell covers, in proportion to the volume covered; what the crack lattice does not cover goes to the nearest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Transfer {
    /// Row starts; length crack nodes + 1.
    pub offsets: Vec<u32>,
    /// Elastic tetrahedra, increasing within a row.
    pub tets: Vec<u32>,
    /// What share of each goes to the row's node, 0 … 1.
    pub shares: Vec<f64>,
}

/// One entry before it is normalised: crack node, elastic tetrahedron, volume.
type Entry = (u32, u32, f64);

impl Transfer {
    /// The operator between two lattices of one body; both not empty.
    ///
    /// Every crack tetrahedron is sampled at the centroids of the 24 small tetrahedra (corner, edge midpoint, face
    /// centroid, centroid) that make up its nodes' barycentric cells, 6 for each node.
    pub fn between(elastic: &Lattice, crack: &Lattice) -> Self {
        let locator = Locator::new(elastic);
        let mut entries: Vec<Entry> =
            (0..crack.tets.len()).into_par_iter().flat_map_iter(|tet| sampled(&locator, crack, tet)).collect();
        entries.extend(unsampled(elastic, crack, &entries));
        // Stable: entries of one pair are summed in the order of the crack tetrahedra.
        entries.par_sort_by_key(|&(node, tet, _)| (node, tet));
        entries.dedup_by(|next, kept| {
            let same = (next.0, next.1) == (kept.0, kept.1);
            if same {
                kept.2 += next.2;
            }
            same
        });
        Self::normalised(&entries, elastic.tets.len(), crack.nodes.len())
    }

    /// Every elastic tetrahedron to the nodes of a lattice that is the same: a quarter each.
    pub fn identity(lattice: &Lattice) -> Self {
        let mut entries: Vec<Entry> = Vec::with_capacity(lattice.tets.len() * 4);
        for (tet, nodes) in lattice.tets.iter().enumerate() {
            entries.extend(nodes.map(|node| (node, tet as u32, 0.25)));
        }
        entries.sort_by_key(|&(node, tet, _)| (node, tet));
        Self::normalised(&entries, lattice.tets.len(), lattice.nodes.len())
    }

    /// From sorted entries without repetition.
    fn normalised(entries: &[Entry], tet_count: usize, node_count: usize) -> Self {
        let mut totals = vec![0.0; tet_count];
        for &(_, tet, volume) in entries {
            totals[tet as usize] += volume;
        }
        let mut offsets = vec![0u32; node_count + 1];
        for &(node, ..) in entries {
            offsets[node as usize + 1] += 1;
        }
        for node in 0..node_count {
            offsets[node + 1] += offsets[node];
        }
        let shares = entries.iter().map(|&(_, tet, volume)| volume / totals[tet as usize]).collect();
        Self { offsets, tets: entries.iter().map(|&(_, tet, _)| tet).collect(), shares }
    }

    /// Energies of the crack nodes from those of the elastic tetrahedra (both integrals, not densities); any unit.
    /// `node_energy` is overwritten, length crack nodes. The sums agree to rounding.
    pub fn apply(&self, tet_energy: &[f64], node_energy: &mut Vec<f64>) {
        node_energy.clear();
        node_energy.extend(self.offsets.windows(2).map(|row| {
            let row = row[0] as usize..row[1] as usize;
            let shares = self.tets[row.clone()].iter().zip(&self.shares[row]);
            shares.map(|(&tet, share)| share * tet_energy[tet as usize]).sum::<f64>()
        }));
    }
}

/// The sample points of tetrahedron `tet` of the crack lattice, each in an elastic tetrahedron or nearest to it.
fn sampled(locator: &Locator, crack: &Lattice, tet: usize) -> impl Iterator<Item = Entry> {
    const ORDERS: [[usize; 3]; 6] = [[1, 2, 3], [1, 3, 2], [2, 1, 3], [2, 3, 1], [3, 1, 2], [3, 2, 1]];
    let corners = crack.corners(tet).map(|corner| corner.coords);
    let centroid: Vector3<f64> = corners.iter().sum::<Vector3<f64>>() / 4.0;
    let volume = crack.tet_volume(tet) / 24.0;
    let mut hint = None;
    let mut entries: Vec<Entry> = Vec::with_capacity(24);
    for (own, &node) in crack.tets[tet].iter().enumerate() {
        let corner = |step: usize| corners[(own + step) % 4];
        for [first, second, _] in ORDERS {
            let edge = (corner(0) + corner(first)) / 2.0;
            let face = (corner(0) + corner(first) + corner(second)) / 3.0;
            let point = Point3::from((corner(0) + edge + face + centroid) / 4.0);
            if let Some(place) = locator.place(&point, hint) {
                hint = Some(place.tet);
                match entries.iter_mut().find(|entry| (entry.0, entry.1) == (node, place.tet)) {
                    Some(entry) => entry.2 += volume,
                    None => entries.push((node, place.tet, volume)),
                }
            }
        }
    }
    entries.into_iter()
}

/// Entries for the elastic tetrahedra that no sample fell into: the corners of the crack tetrahedron that holds their
/// centroid or is nearest to it.
fn unsampled(elastic: &Lattice, crack: &Lattice, entries: &[Entry]) -> Vec<Entry> {
    let mut missing = vec![true; elastic.tets.len()];
    entries.iter().for_each(|&(_, tet, _)| missing[tet as usize] = false);
    let missing: Vec<usize> = (0..missing.len()).filter(|&tet| missing[tet]).collect();
    if missing.is_empty() {
        return Vec::new();
    }
    let locator = Locator::new(crack);
    let shared = |tet: usize| {
        let corners = elastic.corners(tet);
        let centroid = corners.iter().map(|corner| corner.coords).sum::<Vector3<f64>>() / 4.0;
        let place = locator.place(&Point3::from(centroid), None);
        place.into_iter().flat_map(move |place| {
            let nodes = crack.tets[place.tet as usize].into_iter().zip(place.barycentric);
            nodes.filter(|(_, weight)| *weight > 0.0).map(move |(node, weight)| (node, tet as u32, weight))
        })
    };
    missing.into_iter().flat_map(shared).collect()
}
