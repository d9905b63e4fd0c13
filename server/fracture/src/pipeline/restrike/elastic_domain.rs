//! The lattice on which a fragment is solved for. It reaches the earlier cracks, where the fragment's whole tetrahedra end
//! half a cell before them on average.
//!
//! Ours. Each tetrahedron with a node of the fragment belongs to it. Its other nodes, which lie beyond a crack, are moved
//! to the middle of the cut edges, where the crack is on average. A node beyond cracks that the fragment meets on several
//! sides gets one copy for each of them, so that no displacement passes through a crack.

use crate::lattice::{EnergyTransfer, FACES, Lattice, NO_INDEX, NO_TET};
use crate::pipeline::prepared::object::{ElasticModel, PreparedBody};
use nalgebra::{Point3, Vector3};

/// Volume of a tetrahedron with moved nodes, over that before, below which it is left out.
const VOLUME_SHARE_MIN: f64 = 0.01;

/// Part of a body up to the cracks around a fragment.
pub(super) struct ElasticDomain {
    /// Nodes and tetrahedra, local.
    pub lattice: Lattice,
    /// Transfer of energies to the nodes of the fragment's own lattice.
    pub transfer: EnergyTransfer,
    /// Share of the volume that is in tetrahedra with moved nodes.
    pub cut_share: f64,
}

impl ElasticDomain {
    /// The domain on the crack lattice of the body `whole`, of the fragment whose nodes have a `representative` in its own
    /// lattice; [`NO_INDEX`] marks other nodes.
    pub fn of_cracks(whole: &PreparedBody, representative: &[u32]) -> Self {
        let is_own = |node: u32| representative[node as usize] != NO_INDEX;
        let topology = &whole.topology;
        let on_surface =
            |edge: [u32; 2]| topology.edges.binary_search(&edge).is_ok_and(|at| topology.boundary_edge[at]);
        let (lattice, tets, cut_share) = up_to_cracks(&whole.crack, |_| true, is_own, on_surface);
        let part = whole.crack.part(&tets);
        let mut used = vec![false; whole.crack.nodes.len()];
        tets.iter().flat_map(|&tet| whole.crack.tets[tet as usize]).for_each(|node| used[node as usize] = true);
        let to_own: Vec<u32> =
            used.iter().zip(representative).filter(|(used, _)| **used).map(|(_, own)| *own).collect();
        let names: Vec<u32> = (0..tets.len() as u32).collect();
        Self { lattice, transfer: EnergyTransfer::identity(&part).part(&to_own, &names), cut_share }
    }

    /// The same on the elastic lattice of the body, which has the nodes around which most of the energy goes to the fragment.
    ///
    /// `None` if it has no such node.
    pub fn of_elastic(whole: &ElasticModel, representative: &[u32]) -> Option<Self> {
        let Lattice { nodes, tets } = &whole.lattice;
        let EnergyTransfer { offsets, tets: from, shares } = &whole.transfer;
        let mut given = vec![0.0; tets.len()];
        for (row, _) in offsets.windows(2).zip(representative).filter(|(_, own)| **own != NO_INDEX) {
            let row = row[0] as usize..row[1] as usize;
            from[row.clone()].iter().zip(&shares[row]).for_each(|(&tet, share)| given[tet as usize] += share);
        }
        // Positive where more than half of the volume around the node does.
        let mut excess = vec![0.0; nodes.len()];
        for (tet, (corners, given)) in tets.iter().zip(&given).enumerate() {
            let own = (given - 0.5) * whole.lattice.tet_volume(tet);
            corners.iter().for_each(|&node| excess[node as usize] += own);
        }
        let boundary = whole.lattice.boundary();
        let mut outer: Vec<[u32; 2]> = boundary
            .iter()
            .flat_map(|face| [[0, 1], [1, 2], [2, 0]].map(|edge: [usize; 2]| edge.map(|corner| face.nodes[corner])))
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        outer.sort_unstable();
        let on_surface = |edge: [u32; 2]| outer.binary_search(&edge).is_ok();
        let is_own = |node: u32| excess[node as usize] > 0.0;
        let (lattice, own, cut_share) = up_to_cracks(&whole.lattice, |tet| given[tet] > 0.0, is_own, on_surface);
        let mut names = vec![NO_INDEX; tets.len()];
        (0..).zip(&own).for_each(|(name, &tet)| names[tet as usize] = name);
        let transfer = whole.transfer.part(representative, &names);
        (!own.is_empty()).then_some(Self { lattice, transfer, cut_share })
    }
}

/// The largest face-connected part of the tetrahedra of `whole` with energy that `is_given` to the fragment and a node that
/// `is_own`, up to the cracks; the same tetrahedra of `whole`; and the share of the volume in those with moved nodes.
fn up_to_cracks(
    whole: &Lattice,
    is_given: impl Fn(usize) -> bool,
    is_own: impl Fn(u32) -> bool + Copy,
    on_surface: impl Fn([u32; 2]) -> bool,
) -> (Lattice, Vec<u32>, f64) {
    let has_own = |tet: &u32| is_given(*tet as usize) && whole.tets[*tet as usize].into_iter().any(is_own);
    let tets: Vec<u32> = (0..whole.tets.len() as u32).filter(has_own).collect();
    let sides = Sides::of(whole, &tets, is_own);
    let all = Lattice { nodes: sides.moved(is_own, on_surface), tets: sides.lattice.tets };
    let before = |tet: u32| whole.tet_volume(tets[tet as usize] as usize);
    let is_open = |tet: &u32| all.tet_volume(*tet as usize) > VOLUME_SHARE_MIN * before(*tet);
    let open: Vec<u32> = (0..tets.len() as u32).filter(is_open).collect();
    let parts = all.part(&open).components();
    let largest = parts.into_iter().reduce(|best, next| if next.len() > best.len() { next } else { best });
    let own: Vec<u32> = largest.into_iter().flatten().map(|tet| open[tet as usize]).collect();
    let lattice = all.part(&own);
    let origins: Vec<u32> = own.iter().map(|&tet| tets[tet as usize]).collect();
    let is_cut = |tet: &usize| !whole.tets[origins[*tet] as usize].into_iter().all(is_own);
    let cut: f64 = (0..origins.len()).filter(is_cut).map(|tet| lattice.tet_volume(tet)).sum();
    let cut_share = cut / lattice.volume();
    (lattice, origins, cut_share)
}

/// Tetrahedra around a fragment, with one node for each side from which they meet a node beyond the cracks.
struct Sides {
    /// The tetrahedra and nodes, where they are in the body; local.
    lattice: Lattice,
    /// Node of the whole lattice of each node.
    origins: Vec<u32>,
}

impl Sides {
    /// Two of the `tets` meet a node from the same side if a chain of shared faces around it, each with a node of the
    /// fragment, joins them.
    fn of(whole: &Lattice, tets: &[u32], is_own: impl Fn(u32) -> bool) -> Self {
        let own: Vec<[u32; 4]> = tets.iter().map(|&tet| whole.tets[tet as usize]).collect();
        let mut joined: Vec<usize> = (0..4 * own.len()).collect();
        for (tet, around) in whole.part(tets).neighbors().iter().enumerate() {
            for (face, &other) in FACES.iter().zip(around).filter(|(_, other)| **other != NO_TET) {
                let nodes = face.map(|corner| own[tet][corner]);
                if !nodes.iter().any(|&node| is_own(node)) {
                    continue;
                }
                for (corner, node) in face.iter().zip(nodes) {
                    let across = own[other as usize].iter().position(|other| *other == node).unwrap_or_default();
                    let [a, b] = [4 * tet + corner, 4 * other as usize + across].map(|place| root(&mut joined, place));
                    joined[a.max(b)] = a.min(b);
                }
            }
        }
        let mut sides = Self { lattice: Lattice::default(), origins: Vec::new() };
        let mut names = vec![NO_INDEX; joined.len()];
        for (tet, nodes) in own.into_iter().enumerate() {
            sides.lattice.tets.push(std::array::from_fn(|corner| {
                let name = &mut names[root(&mut joined, 4 * tet + corner)];
                if *name == NO_INDEX {
                    *name = sides.origins.len() as u32;
                    sides.origins.push(nodes[corner]);
                    sides.lattice.nodes.push(whole.nodes[nodes[corner] as usize]);
                }
                *name
            }));
        }
        sides
    }

    /// Positions of the nodes: those beyond the cracks are moved to the middle of the edges to nodes of the fragment; where
    /// there are such edges on the surface of the body, to the middle of those.
    fn moved(&self, is_own: impl Fn(u32) -> bool, on_surface: impl Fn([u32; 2]) -> bool) -> Vec<Point3<f64>> {
        let mut sums = vec![[(Vector3::zeros(), 0.0); 2]; self.origins.len()];
        for [a, b] in self.lattice.edges() {
            let [from, to] = [a, b].map(|node| self.origins[node as usize]);
            let (beyond, own) = match [from, to].map(&is_own) {
                [false, true] => (a, b),
                [true, false] => (b, a),
                _ => continue,
            };
            let sum: &mut (Vector3<f64>, f64) =
                &mut sums[beyond as usize][usize::from(!on_surface([from.min(to), from.max(to)]))];
            *sum = (sum.0 + self.lattice.nodes[own as usize].coords, sum.1 + 1.0);
        }
        let moved = |(place, sums): (&Point3<f64>, &[(Vector3<f64>, f64); 2])| {
            let cut = sums.iter().find(|(_, count)| *count > 0.0);
            cut.map_or(*place, |(sum, count)| nalgebra::center(place, &Point3::from(sum / *count)))
        };
        self.lattice.nodes.iter().zip(&sums).map(moved).collect()
    }
}

/// The first of the corners that are joined with corner `place`, after shortening the way to it.
fn root(joined: &mut [usize], mut place: usize) -> usize {
    while joined[place] != place {
        joined[place] = joined[joined[place]];
        place = joined[place];
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::block;

    /// The domain of the nodes that are `own` on their place, and its lattice.
    fn domain(whole: Lattice, own: impl Fn(&Point3<f64>) -> bool) -> ElasticDomain {
        let mut next = 0..;
        let representative: Vec<u32> =
            whole.nodes.iter().map(|node| if own(node) { next.next().unwrap() } else { NO_INDEX }).collect();
        ElasticDomain::of_cracks(&PreparedBody::new(whole), &representative)
    }

    #[test]
    fn a_flat_crack_is_where_it_cuts_the_edges() {
        let whole = block([8, 4, 3], 0.1);
        let volumes = whole.node_volumes();
        for layers in 1..8 {
            let last = -0.4 + 0.1 * f64::from(layers);
            let is_own = |node: &Point3<f64>| node.x < last + 1e-9;
            let domain = domain(whole.clone(), is_own);
            let most = domain.lattice.nodes.iter().map(|node| node.x).fold(f64::NEG_INFINITY, f64::max);
            assert!((0.025..=0.050001).contains(&(most - last)), "{most} after {last}");
            let own = whole.nodes.iter().zip(&volumes).filter(|(node, _)| is_own(node));
            let expected: f64 = own.map(|(_, volume)| volume).sum();
            let volume = domain.lattice.volume();
            println!("{layers}: {volume} of {expected}, cut {}", domain.cut_share);
            assert!((volume / expected - 1.0).abs() < 0.04 / f64::from(layers), "{volume} {expected}");
            assert!(domain.cut_share < 0.5 / f64::from(layers) && domain.cut_share > 0.1 / f64::from(layers));
            // Every tetrahedron passes all of its energy.
            let mut energies = Vec::new();
            domain.transfer.apply(&vec![1.0; domain.lattice.tets.len()], &mut energies);
            assert!((energies.iter().sum::<f64>() / domain.lattice.tets.len() as f64 - 1.0).abs() < 1e-12);
        }
    }

    /// A crack beyond the centers of cells, which lie inside the body and have edges to nodes of its surface.
    #[test]
    fn moved_nodes_stay_on_the_surface() {
        let domain = domain(block([8, 4, 3], 0.1), |node| node.x < 0.051);
        let is_off = |node: &Point3<f64>| (1e-9..0.02).contains(&(node.y + 0.2)) && node.z.abs() < 0.12;
        assert!(!domain.lattice.nodes.iter().any(is_off));
    }

    /// The two arms of a U, one layer of nodes apart.
    #[test]
    fn nothing_passes_a_crack_of_one_node() {
        let whole = block([6, 6, 2], 0.1);
        let domain = domain(whole, |node| node.x.abs() > 0.04 || node.y < -0.04);
        assert!(!domain.lattice.nodes.iter().any(|node| node.x.abs() < 0.02 && node.y > 0.04));
        let upper = |tet: &u32| domain.lattice.corners(*tet as usize).iter().all(|at| at.y > 0.04);
        let arms: Vec<u32> = (0..domain.lattice.tets.len() as u32).filter(upper).collect();
        assert_eq!(domain.lattice.part(&arms).components().len(), 2);
        assert!((0..domain.lattice.tets.len()).all(|tet| domain.lattice.tet_volume(tet) > 0.0));
    }
}
