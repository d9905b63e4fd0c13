//! Answers as files.

use crate::export::{ExportError, FragmentView, RunView, Written, write_glb};
use crate::{Broken, Fragment, Hull, Kind, Refusal};
use std::path::Path;

impl Broken {
    /// Writes the fragments to a `.glb` file, whole or not at all.
    ///
    /// Errors: `output` (folder missing, not writable, or the path is a folder), `bad_answer` (the fragments make no valid
    /// file). An object that stayed whole has no fragments to write: `output` as well.
    pub fn write_glb(&self, path: &Path) -> Result<Written, Refusal> {
        self.with_views(|views| write_glb(path, views)).map_err(|error| refusal(path, &error))
    }

    /// Writes the hulls of the fragments to a `.glb` file as [`Self::write_glb`] does the fragments: nodes of the same names at the
    /// same places. Errors as there; without hulls there is nothing to write: `output`.
    pub fn write_hulls_glb(&self, path: &Path) -> Result<Written, Refusal> {
        let hulls: Vec<(Fragment<'_>, Hull<'_>, [RunView; 1])> = self
            .fragments()
            .filter_map(|fragment| {
                let hull = fragment.hull()?;
                let index_count = hull.indices.len() as u32;
                Some((fragment, hull, [RunView { crack: false, index_first: 0, index_count }]))
            })
            .collect();
        let views: Vec<FragmentView<'_>> = hulls
            .iter()
            .map(|(fragment, hull, runs)| FragmentView {
                positions: hull.positions,
                indices: hull.indices,
                merges: &[],
                ..view(fragment, runs)
            })
            .collect();
        write_glb(path, &views).map_err(|error| refusal(path, &error))
    }

    /// Shows all fragments to `look`, as files and pictures want them; the meshes stay where they are.
    pub fn with_views<R>(&self, look: impl FnOnce(&[FragmentView<'_>]) -> R) -> R {
        let fragments: Vec<Fragment<'_>> = self.fragments().collect();
        let runs: Vec<Vec<RunView>> = fragments.iter().map(runs).collect();
        let views: Vec<FragmentView<'_>> =
            fragments.iter().zip(&runs).map(|(fragment, runs)| view(fragment, runs)).collect();
        look(&views)
    }
}

fn runs(fragment: &Fragment<'_>) -> Vec<RunView> {
    let run = |run: crate::Run<'_>| RunView {
        crack: run.crack,
        index_first: run.index_first,
        index_count: run.indices.len() as u32,
    };
    fragment.runs().map(run).collect()
}

fn view<'a>(fragment: &Fragment<'a>, runs: &'a [RunView]) -> FragmentView<'a> {
    let row = fragment.row();
    FragmentView {
        id: row.id,
        body: row.body,
        positions: fragment.positions(),
        indices: fragment.indices(),
        runs,
        merges: fragment.merges(),
        centre_m: row.centre_m,
        volume_m3: row.volume_m3,
        mass_kg: row.mass_kg,
    }
}

fn refusal(path: &Path, error: &ExportError) -> Refusal {
    let kind = match error {
        ExportError::NoFragments
        | ExportError::MissingFolder(_)
        | ExportError::IsFolder(_)
        | ExportError::Folder { .. }
        | ExportError::Write { .. } => Kind::Output,
        _ => Kind::BadAnswer,
    };
    Refusal::new(kind, path.display().to_string(), error.to_string())
}
