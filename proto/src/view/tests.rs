use super::*;
use crate::layout::{Layout, SectionCounts};
use crate::result::WORLD;
use bytemuck::Zeroable;
use proptest::prelude::*;

const COUNTS: SectionCounts = SectionCounts {
    fragments: 2,
    runs: 2,
    merges: 1,
    vertices: 6,
    indices: 6,
    velocities: 2,
    normals: 6,
    uvs: 6,
    bonds: 1,
    debris: 1,
    hulls: 2,
    hull_vertices: 8,
    hull_indices: 24,
    outer_attributes: 6,
    materials: 2,
    skins: 2,
    skin_vertices: 6,
    skin_indices: 6,
    skin_materials: 2,
    outer_uvs2: 6,
    outer_colors: 6,
    skin_uvs2: 6,
    skin_colors: 6,
};

/// Two fragments of one triangle each, one run each, one merge pair.
fn sample_result() -> (ResultHeader, Vec<AlignedBlock>) {
    let counts = COUNTS;
    let layout = Layout::new(&counts).unwrap();
    let mut payload = vec![AlignedBlock::zeroed(); layout.blocks()];
    let sections = layout.split(&mut payload).unwrap();
    for (i, fragment) in sections.fragments.iter_mut().enumerate() {
        let i = i as u32;
        (fragment.id, fragment.vertex_first, fragment.vertex_count) = (i, i * 3, 3);
        (fragment.index_first, fragment.index_count, fragment.run_first, fragment.run_count) = (i * 3, 3, i, 1);
    }
    sections.fragments[1].merge_count = 1;
    for (i, run) in sections.runs.iter_mut().enumerate() {
        let i = i as u32;
        (run.fragment, run.neighbor, run.material) = (i, 1 - i, 1);
        (run.vertex_first, run.vertex_count, run.index_first, run.index_count) = (i * 3, 3, i * 3, 3);
    }
    sections.indices.copy_from_slice(&[0, 1, 2, 2, 1, 0]);
    sections.merges[0] = [2, 1];
    sections.bonds[0].fragments = [0, 1];
    (sections.debris[0].fragment, sections.debris[0].neighbor) = (0, 1);
    for (i, hull) in sections.hulls.iter_mut().enumerate() {
        let i = i as u32;
        (hull.vertex_first, hull.vertex_count, hull.index_first, hull.index_count) = (4 * i, 4, 12 * i, 12);
    }
    sections.hull_indices.copy_from_slice(&[[1, 2, 3, 0, 3, 2, 0, 1, 3, 0, 2, 1]; 2].concat());
    for (i, skin) in sections.skins.iter_mut().enumerate() {
        let i = i as u32;
        (skin.vertex_first, skin.vertex_count, skin.index_first, skin.index_count) = (3 * i, 3, 3 * i, 3);
    }
    sections.skin_indices.copy_from_slice(&[0, 1, 2, 2, 1, 0]);
    sections.summary.set_object("vase");
    (layout.header(5), payload)
}

fn check(change: impl FnOnce(&mut ResultHeader, &mut [AlignedBlock]), at: &str) {
    let (mut header, mut payload) = sample_result();
    change(&mut header, &mut payload);
    let error = CheckedLayout::new(&header, &payload).expect_err(at);
    assert_eq!((error.kind, error.at.as_str()), (ErrorKind::BadResult, at), "{}", error.message);
}

fn table(payload: &mut [AlignedBlock]) -> &mut [SectionWire] {
    bytemuck::cast_slice_mut(&mut bytemuck::cast_slice_mut::<_, u8>(payload)[..TABLE_BYTES])
}

/// Changes one section through a fresh layout of the same counts.
fn section(payload: &mut [AlignedBlock], change: impl FnOnce(crate::layout::SectionsMut<'_>)) {
    let counts = COUNTS;
    change(Layout::new(&counts).unwrap().split(payload).unwrap());
}

#[test]
fn a_valid_result_is_borrowed() {
    let (header, payload) = sample_result();
    let checked = CheckedLayout::new(&header, &payload).unwrap();
    let view = checked.view(&payload).unwrap();
    assert_eq!((view.fragments.len(), view.positions.len(), view.summary.object()), (2, 6, "vase".into()));
    let range = payload.as_ptr_range();
    assert!(range.contains(&view.positions.as_ptr().cast()));
}

#[test]
fn every_validation_error_names_the_field() {
    check(|h, _| h.magic = 1, "magic");
    check(|h, _| h.version = 1, "version");
    check(|h, _| h.status = 0, "header");
    check(|h, _| h.sections = 6, "header");
    check(|h, _| h.used_bytes = u64::MAX, "used_bytes");
    check(|h, _| h.used_bytes = 100, "table");
    check(|h, _| h.used_bytes -= 1, "section skin_colors");
    check(|_, p| table(p)[0].kind = 2, "section summary");
    check(|_, p| table(p)[2].element_bytes = 8, "section fragments");
    check(|_, p| table(p)[3].offset += 8, "section runs");
    check(|_, p| table(p)[4].offset = 0, "section merges");
    check(|_, p| table(p)[5].length = u64::MAX, "section positions");
    check(|_, p| table(p)[6].offset = u64::MAX - 63, "section indices");
    check(|_, p| section(p, |s| s.fragments[1].id = 0), "fragments[1]");
    check(|_, p| section(p, |s| s.fragments[0].vertex_count = 7), "fragments[0]");
    check(|_, p| section(p, |s| s.fragments[0].vertex_first = u32::MAX), "fragments[0]");
    check(|_, p| section(p, |s| s.fragments[0].index_count = 2), "fragments[0]");
    // Whole triangles all, but not those that materials count.
    check(|_, p| section(p, |s| (s.fragments[0].index_first, s.runs[0].index_first) = (1, 1)), "fragments[0]");
    check(|_, p| section(p, |s| (s.fragments[0].index_count, s.runs[0].index_first) = (6, 1)), "runs[0]");
    check(|_, p| section(p, |s| s.fragments[1].run_first = 2), "fragments[1]");
    check(|_, p| section(p, |s| s.indices[4] = 3), "fragments[1]");
    check(|_, p| section(p, |s| s.merges[0] = [0, 3]), "fragments[1]");
    check(|_, p| section(p, |s| s.runs[0].fragment = 2), "fragments[0]");
    check(|_, p| section(p, |s| (s.runs[0].fragment, s.fragments[0].run_count) = (2, 0)), "runs[0]");
    check(|_, p| section(p, |s| s.bonds[0].fragments = [1, 0]), "bonds");
    check(|_, p| section(p, |s| s.bonds[0].fragments = [0, 2]), "bonds");
    check(|_, p| section(p, |s| s.bonds[0].fragments = [2, WORLD]), "bonds");
    check(|_, p| section(p, |s| s.bonds[0].fragments = [WORLD, WORLD]), "bonds");
    check(|_, p| section(p, |s| s.debris[0].neighbor = 0), "debris");
    check(|_, p| table(p)[8].length -= 48, "velocities");
    check(|_, p| table(p)[9].length -= 12, "normals");
    check(|_, p| table(p)[10].length = 8, "uvs");
    check(|_, p| table(p)[13].length -= 32, "hulls");
    check(|_, p| section(p, |s| s.hulls[1].vertex_first = 5), "hulls[1]");
    check(|_, p| section(p, |s| s.hulls[0].index_count = 11), "hulls[0]");
    check(|_, p| table(p)[16].length -= 20, "outer_attributes");
    check(|_, p| table(p)[17].length -= 4, "materials");
    check(|_, p| table(p)[18].length -= 16, "skins");
    check(|_, p| section(p, |s| s.skins[1].vertex_count = 4), "skins[1]");
    check(|_, p| section(p, |s| s.skins[0].index_first = 1), "skins[0]");
    check(|_, p| section(p, |s| s.skin_indices[4] = 3), "skins[1]");
    check(|_, p| table(p)[21].length -= 4, "skin_materials");
    check(|_, p| table(p)[22].length -= 8, "outer_uvs2");
    check(|_, p| table(p)[23].length -= 4, "outer_colors");
    check(|_, p| table(p)[24].length -= 8, "skin_uvs2");
    check(|_, p| table(p)[25].length -= 4, "skin_colors");
    check(|_, p| section(p, |s| s.hulls[1].index_first = u32::MAX), "hulls[1]");
    check(|_, p| section(p, |s| s.hull_indices[13] = 4), "hulls[1]");
    check(|_, p| section(p, |s| s.runs[0].neighbor = 2), "runs[0]");
    check(|_, p| section(p, |s| s.runs[1].material = 0), "runs[1]");
    check(|_, p| section(p, |s| s.runs[1].index_first = 0), "runs[1]");
}

#[test]
fn a_bond_may_connect_a_fragment_to_the_world() {
    let (header, mut payload) = sample_result();
    section(&mut payload, |s| s.bonds[0].fragments = [1, WORLD]);
    let view = CheckedLayout::new(&header, &payload).unwrap().view(&payload).unwrap();
    assert!(view.bonds[0].holds_to_world());
}

proptest! {
    #[test]
    fn random_tables_are_never_read_out_of_bounds(
        bytes in proptest::collection::vec(any::<u8>(), 64 * 20),
        used in 0u64..1400,
        words in proptest::collection::vec((0usize..42, 0u32..1500), 0..12),
    ) {
        let (mut header, mut payload) = sample_result();
        header.used_bytes = used;
        for (at, value) in words {
            bytemuck::cast_slice_mut::<_, u32>(&mut payload)[at] = value;
        }
        let _ = CheckedLayout::new(&header, &payload);
        let mut noise = vec![AlignedBlock::zeroed(); 20];
        bytemuck::cast_slice_mut::<_, u8>(&mut noise).copy_from_slice(&bytes);
        prop_assert!(CheckedLayout::new(&header, &noise).is_err());
    }

    /// One changed byte anywhere: whatever still passes can be walked without a panic.
    #[test]
    fn mutated_results_are_never_read_out_of_bounds(at in 0usize..2048, value in any::<u8>()) {
        let (header, mut payload) = sample_result();
        let bytes = bytemuck::cast_slice_mut::<_, u8>(&mut payload);
        let at = at % bytes.len();
        bytes[at] = value;
        if let Ok(checked) = CheckedLayout::new(&header, &payload) {
            let view = checked.view(&payload).unwrap();
            for fragment in view.fragments {
                let vertices = &view.positions[fragment.vertex_first as usize..][..fragment.vertex_count as usize];
                for index in &view.indices[fragment.index_first as usize..][..fragment.index_count as usize] {
                    prop_assert!((*index as usize) < vertices.len());
                }
                let runs = &view.runs[fragment.run_first as usize..][..fragment.run_count as usize];
                prop_assert!(runs.iter().all(|run| (run.fragment as usize) < view.fragments.len()));
            }
            for hull in view.hulls {
                let vertices = &view.hull_positions[hull.vertex_first as usize..][..hull.vertex_count as usize];
                let indices = &view.hull_indices[hull.index_first as usize..][..hull.index_count as usize];
                prop_assert!(indices.iter().all(|index| (*index as usize) < vertices.len()));
            }
        }
    }
}
