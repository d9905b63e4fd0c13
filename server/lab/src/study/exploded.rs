//! Mesh of the fragments of a result, moved apart.

use crate::picture::{DrawnMesh, Spread, pieces};
use shatter_export::{FragmentView, RunView};
use shatter_fracture::pipeline::{FragmentRow, RunRow};

/// Mesh of the fragments in a result's tables; vertices keep their numbers.
pub fn exploded(
    rows: &[FragmentRow],
    runs: &[RunRow],
    positions: &[[f32; 3]],
    indices: &[u32],
    spread: Spread,
) -> DrawnMesh {
    let runs: Vec<RunView> = runs
        .iter()
        .map(|run| RunView { crack: run.crack, index_first: run.index_first, index_count: run.index_count })
        .collect();
    let view = |row: &FragmentRow| FragmentView {
        normals: &[],
        uvs: &[],
        uvs2: &[],
        colors: &[],
        materials: &[],
        id: row.id,
        body: row.body,
        positions: &positions[row.vertex_first as usize..][..row.vertex_count as usize],
        indices: &indices[row.index_first as usize..][..row.index_count as usize],
        runs: &runs[row.run_first as usize..][..row.run_count as usize],
        merges: &[],
        center_m: row.center_m,
        volume_m3: row.volume_m3,
        mass_kg: row.mass_kg,
        inertia_kg_m2: row.inertia_kg_m2,
    };
    let views: Vec<FragmentView> = rows.iter().map(view).collect();
    pieces(&views, spread)
}
