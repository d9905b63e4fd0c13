//! Validity checks of fragments before writing, and the test for a closed surface.

use super::{ExportError, FragmentView, ObjectView, SourceMaterials};
use shatter_proto::result::NO_MATERIAL;
use std::collections::BTreeSet;

/// Refuses an object without fragments, or with hulls or bonds that do not fit its fragments.
pub(super) fn object(view: &ObjectView<'_>) -> Result<(), ExportError> {
    all(view.fragments)?;
    let fragments = view.fragments.len();
    for (bond, row) in view.bonds.iter().enumerate() {
        if let Some(fragment) = row.fragments().find(|end| *end as usize >= fragments) {
            return Err(ExportError::BondOutOfRange { bond, fragment, fragments });
        }
        if !row.centroid_m.iter().chain([&row.area_m2]).all(|x| x.is_finite()) {
            return Err(ExportError::NonFinite { fragment: row.fragment, what: "a bond" });
        }
    }
    for (fragment, hull) in view.fragments.iter().zip(view.hulls) {
        let Some(hull) = hull else { continue };
        if hull.indices.iter().any(|corner| *corner as usize >= hull.positions.len()) {
            return Err(ExportError::HullOutOfRange { fragment: fragment.id });
        }
        if !hull.positions.iter().flatten().all(|x| x.is_finite()) {
            return Err(ExportError::NonFinite { fragment: fragment.id, what: "a corner of the hull" });
        }
    }
    Ok(())
}

/// Refuses fragments that make no valid file.
pub(super) fn all(fragments: &[FragmentView<'_>]) -> Result<(), ExportError> {
    if fragments.is_empty() {
        return Err(ExportError::NoFragments);
    }
    fragments.iter().try_for_each(valid)
}

/// Refuses fragments whose outer triangles have materials that the mesh file does not have, or lack texture coordinates of theirs. The
/// fragments have been checked.
pub(super) fn source(fragments: &[FragmentView<'_>], source: &SourceMaterials) -> Result<(), ExportError> {
    let materials = source.count();
    if materials > 0 && fragments.iter().all(|fragment| fragment.materials.is_empty()) {
        return Err(ExportError::NoMaterials { path: source.path().to_owned() });
    }
    for fragment in fragments {
        let mut outer = fragment.materials.iter().take(fragment.outer_indices() / 3);
        let is_unknown = |material: &&u32| **material != NO_MATERIAL && **material as usize >= materials;
        if let Some(&material) = outer.find(is_unknown) {
            let path = source.path().to_owned();
            return Err(ExportError::MaterialOutOfRange { fragment: fragment.id, material, path, materials });
        }
        let has = [!fragment.uvs.is_empty(), !fragment.uvs2.is_empty()];
        let used = BTreeSet::from_iter(fragment.materials.iter().take(fragment.outer_indices() / 3));
        for &material in used.into_iter().filter(|material| **material != NO_MATERIAL) {
            let sets = source.texture_sets(material as usize);
            if let Some(set) = sets.into_iter().find(|set| !has.get(*set).is_some_and(|has| *has)) {
                return Err(ExportError::NoTextureCoordinates { path: source.path().to_owned(), material, set });
            }
        }
    }
    Ok(())
}

/// Refuses a fragment that would make a file that readers reject.
fn valid(view: &FragmentView<'_>) -> Result<(), ExportError> {
    finite(view)?;
    let vertices = view.positions.len();
    if let Some(position) = view.indices.iter().position(|&vertex| vertex as usize >= vertices) {
        let vertex = view.indices[position];
        return Err(ExportError::IndexOutOfRange { fragment: view.id, position, vertex, vertices });
    }
    runs(view)?;
    let (materials, triangles) = (view.materials.len(), view.indices.len() / 3);
    if materials > 0 && materials != triangles {
        return Err(ExportError::MaterialCount { fragment: view.id, materials, triangles });
    }
    merges(view)
}

fn finite(view: &FragmentView<'_>) -> Result<(), ExportError> {
    let figures = [
        ("a coordinate", view.positions.iter().flatten().all(|x| x.is_finite())),
        ("the center", view.center_m.iter().all(|&x| (x as f32).is_finite())),
        ("the volume", view.volume_m3.is_finite()),
        ("the mass", view.mass_kg.is_finite()),
        ("the inertia", view.inertia_kg_m2.iter().all(|x| x.is_finite())),
    ];
    match figures.iter().find(|(_, fine)| !fine) {
        Some((what, _)) => Err(ExportError::NonFinite { fragment: view.id, what }),
        None => Ok(()),
    }
}

/// Checks the runs: without gaps, outer before crack, whole triangles, up to the end of the indices.
fn runs(view: &FragmentView<'_>) -> Result<(), ExportError> {
    let out_of_order = |run| Err(ExportError::RunOutOfOrder { fragment: view.id, run });
    let mut end = 0_usize;
    let mut cracks = false;
    for (k, run) in view.runs.iter().enumerate() {
        let fits = run.index_first as usize == end && run.index_count.is_multiple_of(3);
        if !fits || (cracks && !run.crack) {
            return out_of_order(k);
        }
        cracks |= run.crack;
        end += run.index_count as usize;
    }
    if end != view.indices.len() || end == 0 { out_of_order(view.runs.len()) } else { Ok(()) }
}

fn merges(view: &FragmentView<'_>) -> Result<(), ExportError> {
    let place = |vertex: u32| view.positions.get(vertex as usize);
    let apart = |pair: &[u32; 2]| match (place(pair[0]), place(pair[1])) {
        (Some(from), Some(to)) => from != to,
        _ => true,
    };
    match view.merges.iter().position(apart) {
        Some(pair) => Err(ExportError::MergeMoves { fragment: view.id, pair }),
        None => Ok(()),
    }
}

/// The lowest vertex that the merge pairs join each vertex with; chains and any order of pairs are allowed.
pub(super) fn merged(view: &FragmentView<'_>) -> Vec<u32> {
    let mut root: Vec<u32> = (0..view.positions.len() as u32).collect();
    for &[from, to] in view.merges {
        let (a, b) = (find(&mut root, from), find(&mut root, to));
        root[a.max(b) as usize] = a.min(b);
    }
    (0..root.len() as u32).map(|vertex| find(&mut root, vertex)).collect()
}

/// Root of `vertex`; halves the path on the way.
fn find(root: &mut [u32], mut vertex: u32) -> u32 {
    while root[vertex as usize] != vertex {
        let above = root[root[vertex as usize] as usize];
        root[vertex as usize] = above;
        vertex = above;
    }
    vertex
}

/// True if the fragment's surface is closed and consistently oriented once its merge pairs are applied: every half-edge occurs once and has
/// exactly one opposite. False as well if an index or a pair names no vertex.
pub fn is_closed(view: &FragmentView<'_>) -> bool {
    let vertices = view.positions.len();
    let named = |vertex: &u32| (*vertex as usize) < vertices;
    if view.indices.is_empty() || !view.indices.len().is_multiple_of(3) {
        return false;
    }
    if !view.indices.iter().all(named) || !view.merges.iter().flatten().all(named) {
        return false;
    }
    let point = merged(view);
    closed(view.indices, &point)
}

/// Tests the half-edge condition on merged indices.
pub(super) fn closed(indices: &[u32], point: &[u32]) -> bool {
    let mut half_edges = Vec::with_capacity(indices.len());
    for triangle in indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|k| point[triangle[k] as usize]);
        half_edges.extend([[a, b], [b, c], [c, a]]);
    }
    half_edges.sort_unstable();
    let once = half_edges.windows(2).all(|pair| pair[0] != pair[1]);
    once && half_edges.iter().all(|&[a, b]| a != b && half_edges.binary_search(&[b, a]).is_ok())
}
