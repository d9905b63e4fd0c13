//! Outer triangles of a fragment, grouped by material.

use super::FragmentView;
use shatter_proto::result::NO_MATERIAL;
use std::borrow::Cow;

/// Consecutive indices of outer triangles with one material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Group {
    /// Index of the material in the mesh file; `None` for no material.
    pub material: Option<u32>,
    /// Number of indices.
    pub index_count: usize,
}

/// The indices of a fragment with its outer triangles stably sorted by material, those without one last, and the groups of them. The
/// crack triangles follow unchanged. The fragment has been checked.
pub(super) fn by_material<'a>(fragment: &FragmentView<'a>) -> (Cow<'a, [u32]>, Vec<Group>) {
    let outer = fragment.outer_indices();
    let unchanged = Cow::Borrowed(fragment.indices);
    if outer == 0 {
        return (unchanged, Vec::new());
    }
    let Some(materials) = fragment.materials.get(..outer / 3) else {
        return (unchanged, vec![Group { material: None, index_count: outer }]);
    };
    let mut order: Vec<usize> = (0..materials.len()).collect();
    // `NO_MATERIAL` is the largest number.
    order.sort_by_key(|triangle| materials[*triangle]);
    let group = |own: &[usize]| {
        let material = Some(materials[own[0]]).filter(|material| *material != NO_MATERIAL);
        Group { material, index_count: 3 * own.len() }
    };
    let groups = order.chunk_by(|a, b| materials[*a] == materials[*b]).map(group).collect();
    if materials.is_sorted() {
        return (unchanged, groups);
    }
    let (triangles, cracks) = fragment.indices.split_at(outer);
    let grouped = order.iter().flat_map(|triangle| &triangles[3 * triangle..3 * triangle + 3]);
    (Cow::Owned(grouped.chain(cracks).copied().collect()), groups)
}

/// True if an outer triangle of the fragment has no material.
pub(super) fn has_plain_triangles(fragment: &FragmentView<'_>) -> bool {
    let outer = fragment.outer_indices() / 3;
    match fragment.materials.get(..outer) {
        Some(materials) => materials.contains(&NO_MATERIAL),
        None => true,
    }
}
