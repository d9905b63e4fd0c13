//! Answers as files: always in metres, +Y up, right-handed and counter-clockwise, whatever the convention of the answer.

use crate::export::{
    ExportError, FragmentView, HullView, ObjectView, RunView, Written, smooth, write_glb, write_mjcf, write_obj,
};
use crate::metric::Metric;
use crate::{Broken, Fragment, Hull, Kind, Refusal, Skin};
use shatter_proto::answer::LookWire;
use std::path::Path;

impl Broken {
    /// Writes the fragments to a `.glb` file, whole or not at all.
    ///
    /// Errors: `output` (folder not writable, or the path is a folder), `bad_answer` (the fragments make no valid
    /// file). An object that stayed whole has no fragments to write: `output` as well.
    pub fn write_glb(&self, path: &Path) -> Result<Written, Refusal> {
        self.with_views(|views| write_glb(path, views)).map_err(|error| refusal(path, &error))
    }

    /// Writes the hulls of the fragments to a `.glb` file as [`Self::write_glb`] does the fragments: nodes of the same names at the
    /// same places. Errors as there; without hulls there is nothing to write: `output`.
    pub fn write_hulls_glb(&self, path: &Path) -> Result<Written, Refusal> {
        let metric = self.metric();
        let hulls: Vec<(Fragment<'_>, Hull<'_>, [RunView; 1])> = metric
            .fragments()
            .filter_map(|fragment| {
                let hull = fragment.hull()?;
                let index_count = hull.indices.len() as u32;
                Some((fragment, hull, [RunView { crack: false, index_first: 0, index_count }]))
            })
            .collect();
        let plain = Appearance::default();
        let views: Vec<FragmentView<'_>> = hulls
            .iter()
            .map(|(fragment, hull, runs)| FragmentView {
                positions: hull.positions,
                indices: hull.indices,
                merges: &[],
                ..view(fragment, runs, &plain)
            })
            .collect();
        write_glb(path, &views).map_err(|error| refusal(path, &error))
    }

    /// Writes what is seen of the fragments to a `.glb` file: their skins, and their crack faces; nodes of the same names at the same
    /// places. Errors as of [`Self::write_glb`]; without skins there is nothing to write: `output`.
    pub fn write_skins_glb(&self, path: &Path) -> Result<Written, Refusal> {
        let metric = self.metric();
        let dressed: Vec<(Fragment<'_>, Dressed)> = metric
            .fragments()
            .filter_map(|fragment| Some((fragment, Dressed::new(&fragment, &fragment.skin()?))))
            .collect();
        let views: Vec<FragmentView<'_>> = dressed
            .iter()
            .filter(|(_, dressed)| !dressed.indices.is_empty())
            .map(|(fragment, dressed)| FragmentView {
                positions: &dressed.positions,
                indices: &dressed.indices,
                merges: &[],
                ..view(fragment, &dressed.runs, &dressed.appearance)
            })
            .collect();
        write_glb(path, &views).map_err(|error| refusal(path, &error))
    }

    /// Writes the fragments as OBJ files into `folder`, which is made if it is not there: see [`write_obj`].
    /// Errors as of [`Self::write_glb`].
    pub fn write_obj(&self, folder: &Path) -> Result<Written, Refusal> {
        self.with_object(|object| write_obj(folder, object)).map_err(|error| refusal(folder, &error))
    }

    /// Writes the fragments as a model for MuJoCo, with the hulls and bonds that the answer has: see [`write_mjcf`].
    /// Errors as of [`Self::write_glb`].
    pub fn write_mjcf(&self, path: &Path) -> Result<Written, Refusal> {
        self.with_object(|object| write_mjcf(path, object)).map_err(|error| refusal(path, &error))
    }

    /// Shows the whole answer to `look`, as models want it; the meshes stay where they are, but for those of an answer in another
    /// convention.
    pub fn with_object<R>(&self, look: impl FnOnce(&ObjectView<'_>) -> R) -> R {
        let metric = self.metric();
        let (name, ran) = (self.summary().object(), !metric.view().hulls.is_empty());
        let hulls: Vec<Option<HullView<'_>>> = metric
            .fragments()
            .filter(|_| ran)
            .map(|fragment| fragment.hull().map(|hull| HullView { positions: hull.positions, indices: hull.indices }))
            .collect();
        let (name, hulls, bonds) = (name.as_str(), hulls.as_slice(), metric.view().bonds);
        with_views(&metric, |fragments| look(&ObjectView { name, fragments, hulls, bonds }))
    }

    /// Shows all fragments to `look`, as files and pictures want them; the meshes stay where they are, but for those of an answer in
    /// another convention.
    pub fn with_views<R>(&self, look: impl FnOnce(&[FragmentView<'_>]) -> R) -> R {
        with_views(&self.metric(), look)
    }
}

fn with_views<R>(metric: &Metric<'_>, look: impl FnOnce(&[FragmentView<'_>]) -> R) -> R {
    let fragments: Vec<Fragment<'_>> = metric.fragments().collect();
    let parts: Vec<(Vec<RunView>, Appearance)> =
        fragments.iter().map(|fragment| (runs(fragment), Appearance::of(fragment))).collect();
    let views: Vec<FragmentView<'_>> =
        fragments.iter().zip(&parts).map(|(fragment, (runs, looks))| view(fragment, runs, looks)).collect();
    look(&views)
}

fn runs(fragment: &Fragment<'_>) -> Vec<RunView> {
    let run = |run: crate::Run<'_>| RunView {
        crack: run.crack,
        index_first: run.index_first,
        index_count: run.indices.len() as u32,
    };
    fragment.runs().map(run).collect()
}

/// Normals and texture coordinates of vertices; none if the answer does not tell them.
#[derive(Default)]
struct Appearance {
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
}

impl Appearance {
    /// Of a fragment's own vertices: the input's looks outside, and on cracks what the answer has, or smooth normals.
    fn of(fragment: &Fragment<'_>) -> Self {
        let looks = fragment.looks();
        if looks.is_empty() {
            return Self::default();
        }
        let own = fragment.normals();
        let smooth = if own.is_empty() { smooth(fragment.positions(), fragment.indices()) } else { own.to_vec() };
        let is_told = |look: &LookWire| look.normal != [0.0; 3];
        let normal = |(look, smooth): (&LookWire, [f32; 3])| if is_told(look) { look.normal } else { smooth };
        let normals = looks.iter().zip(smooth).map(normal).collect();
        let cracks = fragment.uvs();
        let uv = |(vertex, look): (usize, &LookWire)| match is_told(look) {
            true => look.uv,
            false => cracks.get(vertex).copied().unwrap_or_default(),
        };
        let uvs: Vec<[f32; 2]> = looks.iter().enumerate().map(uv).collect();
        let textured = uvs.iter().any(|uv| *uv != [0.0; 2]);
        Self { normals, uvs: if textured { uvs } else { Vec::new() } }
    }
}

/// The skin of a fragment and its crack faces, in one mesh.
struct Dressed {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    runs: Vec<RunView>,
    appearance: Appearance,
}

impl Dressed {
    fn new(fragment: &Fragment<'_>, skin: &Skin<'_>) -> Self {
        let mut positions: Vec<[f32; 3]> = skin.vertices.iter().map(|vertex| vertex.position_m).collect();
        let mut normals: Vec<[f32; 3]> = skin.vertices.iter().map(|vertex| vertex.normal).collect();
        let mut uvs: Vec<[f32; 2]> = skin.vertices.iter().map(|vertex| vertex.uv).collect();
        let mut indices = skin.indices.to_vec();
        let outer = indices.len() as u32;
        let cracks = Appearance::of(fragment);
        let smooth = match cracks.normals.is_empty() {
            true => smooth(fragment.positions(), fragment.indices()),
            false => cracks.normals,
        };
        for run in fragment.runs().filter(|run| run.crack) {
            let (first, own) = (positions.len() as u32, run.vertex_first as usize..);
            positions.extend_from_slice(run.positions);
            normals.extend(&smooth[own.clone()][..run.positions.len()]);
            let told = fragment.uvs().get(own).map_or(&[][..], |uvs| &uvs[..run.positions.len()]);
            uvs.extend_from_slice(told);
            uvs.resize(positions.len(), [0.0; 2]);
            // What names no vertex of its run names none here, either: it is refused when it is written.
            indices.extend(run.indices.iter().map(|index| index.wrapping_sub(run.vertex_first).wrapping_add(first)));
        }
        let run = |crack, index_first, index_count| RunView { crack, index_first, index_count };
        let runs = vec![run(false, 0, outer), run(true, outer, indices.len() as u32 - outer)];
        let textured = uvs.iter().any(|uv| *uv != [0.0; 2]);
        let appearance = Appearance { normals, uvs: if textured { uvs } else { Vec::new() } };
        Self { positions, indices, runs, appearance }
    }
}

fn view<'a>(fragment: &Fragment<'a>, runs: &'a [RunView], looks: &'a Appearance) -> FragmentView<'a> {
    let row = fragment.row();
    FragmentView {
        id: row.id,
        body: row.body,
        positions: fragment.positions(),
        normals: &looks.normals,
        uvs: &looks.uvs,
        indices: fragment.indices(),
        runs,
        merges: fragment.merges(),
        centre_m: row.centre_m,
        volume_m3: row.volume_m3,
        mass_kg: row.mass_kg,
        inertia_kg_m2: row.inertia_kg_m2,
    }
}

fn refusal(path: &Path, error: &ExportError) -> Refusal {
    let kind = match error {
        ExportError::NoFragments
        | ExportError::IsFolder(_)
        | ExportError::NoFile(_)
        | ExportError::Folder { .. }
        | ExportError::Write { .. } => Kind::Output,
        _ => Kind::BadAnswer,
    };
    Refusal::new(kind, path.display().to_string(), error.to_string())
}
