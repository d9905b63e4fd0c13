//! Slivers: fragments too small for a body of their own, merged into the neighbor with the largest common area.

use crate::fragment::RigidProperties;
use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::request::context::RequestContext;
use crate::tessellation::{Components, RunRange, Tessellation, Topology};
use std::collections::BTreeMap;

/// Volume below which a fragment is a sliver, in cubed spacings of the crack lattice.
///
/// Such a fragment has about four nodes, so the lattice determines its shape rather than the diagram. A share of the
/// mean volume would also remove small fragments around a contact, which are intended.
pub const SLIVER_CUBES: f64 = 2.0;

/// Volume below which a fragment of an exact surface is flat up to rounding, in cubed spacings of the crack lattice.
///
/// Pieces of pieces can be: a crack between two nodes that are as near the earlier crack as rounding allows. Without mass
/// nothing can be simulated, so they are merged without the effect, too.
const FLAT_CUBES: f64 = 1e-9;

/// The volume below which a fragment is flat, local.
pub(in crate::pipeline) fn flat_volume(prepared: &PreparedObject) -> f64 {
    FLAT_CUBES * prepared.parameters.crack_spacing.powi(3)
}

/// The volume below which a fragment is a sliver, local: [`SLIVER_CUBES`] or that of the request, whichever is larger.
pub(in crate::pipeline) fn least_volume(context: RequestContext<'_>) -> f64 {
    let RequestContext { prepared, request, .. } = context;
    let asked = request.volume_min_m3.map_or(0.0, |volume_m3| volume_m3 / prepared.frame.diagonal_m.powi(3));
    asked.max(SLIVER_CUBES * prepared.parameters.crack_spacing.powi(3))
}

/// Merges every fragment smaller than `least` into the neighbor with the largest common area, in ascending order of
/// volume.
///
/// Ends when no sliver with a neighbor is left. Fragments without an entry in `measured` take no part. Returns true if
/// there was a sliver. `components` then has the merged fragments in their old order, with the sites of the absorbing
/// ones.
pub(in crate::pipeline) fn merge(
    components: &mut Components,
    tessellation: &Tessellation,
    measured: &[RigidProperties],
    least: f64,
) -> bool {
    let volumes: Vec<f64> = measured.iter().map(|piece| piece.volume).collect();
    // Common areas are needed only if a fragment is small.
    if volumes.iter().all(|volume| *volume >= least) {
        return false;
    }
    join(components, volumes, shared_areas(tessellation), least)
}

/// Fragment volumes by the lumped volumes of their nodes, local, if one of them is less than `least`.
pub(in crate::pipeline) fn small_by_nodes(
    components: &Components,
    node_volumes: &[f64],
    least: f64,
) -> Option<Vec<f64>> {
    let mut volumes = vec![0.0; components.sites.len()];
    components.labels.iter().zip(node_volumes).for_each(|(label, volume)| volumes[*label as usize] += volume);
    volumes.iter().any(|volume| *volume < least).then_some(volumes)
}

/// As [`merge`], before the body is cut: by these volumes, and by the number of lattice edges between fragments.
///
/// This leaves little for [`merge`], after which the body must be cut again.
pub(in crate::pipeline) fn merge_by_nodes(
    components: &mut Components,
    topology: &Topology,
    volumes: Vec<f64>,
    least: f64,
) {
    let mut shared = vec![BTreeMap::new(); volumes.len()];
    for [a, b] in topology.edges.iter().map(|edge| edge.map(|node| components.labels[node as usize] as usize)) {
        // Only neighbors of small fragments matter.
        if a != b && (volumes[a] < least || volumes[b] < least) {
            *shared[a].entry(b).or_default() += 1.0;
            *shared[b].entry(a).or_default() += 1.0;
        }
    }
    join(components, volumes, shared, least);
}

/// Merges fragments as in [`merge`]; `shared[piece]` maps each neighbor to the common area or edge count.
fn join(components: &mut Components, mut volumes: Vec<f64>, mut shared: Vec<BTreeMap<usize, f64>>, least: f64) -> bool {
    let mut became: Vec<usize> = (0..volumes.len()).collect();
    let mut any = false;
    while let Some((sliver, host)) = next(&became, &volumes, &shared, least) {
        any = true;
        became.iter_mut().filter(|piece| **piece == sliver).for_each(|piece| *piece = host);
        volumes[host] += std::mem::take(&mut volumes[sliver]);
        for (other, area) in std::mem::take(&mut shared[sliver]) {
            shared[other].remove(&sliver);
            if other != host {
                *shared[host].entry(other).or_default() += area;
                *shared[other].entry(host).or_default() += area;
            }
        }
    }
    if any {
        renumber(components, &became);
    }
    any
}

/// The smallest sliver with a neighbor, and the neighbor with the most in common.
fn next(became: &[usize], volumes: &[f64], shared: &[BTreeMap<usize, f64>], least: f64) -> Option<(usize, usize)> {
    let pieces = (0..volumes.len()).filter(|&piece| became[piece] == piece && volumes[piece] < least);
    let slivers = pieces.filter(|&piece| !shared[piece].is_empty());
    let sliver = slivers.min_by(|&a, &b| volumes[a].total_cmp(&volumes[b]).then(a.cmp(&b)))?;
    let host = shared[sliver].iter().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(a.0)))?;
    Some((sliver, *host.0))
}

/// Neighbors of each fragment, with the common area, local.
fn shared_areas(tessellation: &Tessellation) -> Vec<BTreeMap<usize, f64>> {
    let mut shared = vec![BTreeMap::new(); tessellation.fragments().len()];
    for run in tessellation.runs() {
        if let Some(neighbor) = run.neighbor {
            *shared[run.fragment as usize].entry(neighbor as usize).or_default() += area(tessellation, run);
        }
    }
    shared
}

/// Area of the triangles of `run`, local.
pub(super) fn area(tessellation: &Tessellation, run: &RunRange) -> f64 {
    let points = tessellation.run_vertices(run);
    let corners = |triangle: [u32; 3]| triangle.map(|vertex| points[vertex as usize]);
    tessellation.run_triangles(run).map(corners).map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm()).sum()
}

fn renumber(components: &mut Components, became: &[usize]) {
    let kept: Vec<usize> = (0..became.len()).filter(|&piece| became[piece] == piece).collect();
    let mut place = vec![0u32; became.len()];
    kept.iter().enumerate().for_each(|(number, &piece)| place[piece] = number as u32);
    let (measured, gone) = (became.len(), (became.len() - kept.len()) as u32);
    let renamed = |label: u32| became.get(label as usize).map_or_else(|| label - gone, |&piece| place[piece]);
    components.labels.iter_mut().for_each(|label| *label = renamed(*label));
    let others = components.sites.split_off(measured);
    components.sites = kept.iter().map(|&piece| components.sites[piece]).chain(others).collect();
}
