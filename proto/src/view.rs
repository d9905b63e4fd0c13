//! From bytes to borrowed sections: every offset, alignment, count and index is checked before one is used.

use crate::layout::{SECTIONS, TABLE_BYTES};
use crate::result::{
    AlignedBlock, BLOCK_BYTES, FragmentWire, OUTER, RESULT_MAGIC, ResultHeader, RunWire, SectionKind, SectionWire,
};
use crate::{Error, ErrorKind, PROTOCOL_VERSION};
use std::ops::Range;

pub use crate::sections::{ResultView, SectionsInMeters};

/// Positions of the sections of a result, after all checks. Cheap to keep beside the payload that it was checked against.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CheckedLayout {
    ranges: [Range<usize>; SECTIONS],
}

impl CheckedLayout {
    /// Checks header, table and contents of a result. Never panics, whatever the bytes.
    ///
    /// # Errors
    /// `bad_result` at the first field that does not fit.
    pub fn new(header: &ResultHeader, payload: &[AlignedBlock]) -> Result<Self, Error> {
        head(header)?;
        let bytes: &[u8] = bytemuck::cast_slice(payload);
        let used = usize::try_from(header.used_bytes).ok().filter(|used| *used <= bytes.len());
        let used = used.ok_or_else(|| bad("used_bytes", format!("{} of {} bytes", header.used_bytes, bytes.len())))?;
        let bytes = &bytes[..used];
        let checked = Self { ranges: ranges(bytes)? };
        let view = checked.view(payload).ok_or_else(|| bad("sections", "a section does not fit its type"))?;
        contents(&view)?;
        Ok(checked)
    }

    /// The sections of `payload`: the one that was checked. `None` for another one in which they do not fit.
    pub fn view<'a>(&self, payload: &'a [AlignedBlock]) -> Option<ResultView<'a>> {
        let bytes: &'a [u8] = bytemuck::cast_slice(payload);
        let section = |kind: SectionKind| bytes.get(self.ranges[kind as usize - 1].clone());
        ResultView::of(section)
    }
}

fn bad(at: impl Into<String>, what: impl std::fmt::Display) -> Error {
    let at = at.into();
    let message = format!("the result is not well formed: {at}: {what}");
    Error::new(ErrorKind::BadResult, at, message)
}

fn head(header: &ResultHeader) -> Result<(), Error> {
    if header.magic != RESULT_MAGIC {
        return Err(bad("magic", format!("{:#010x}", header.magic)));
    }
    if header.version != PROTOCOL_VERSION {
        return Err(bad("version", format!("{} instead of {PROTOCOL_VERSION}", header.version)));
    }
    if header.status != 1 || header.sections as usize != SECTIONS {
        return Err(bad("header", format!("status {}, {} sections", header.status, header.sections)));
    }
    Ok(())
}

/// Checks the section table: the known sections in their order, aligned, disjoint, inside, of whole elements.
fn ranges(bytes: &[u8]) -> Result<[Range<usize>; SECTIONS], Error> {
    let table = bytes.get(..TABLE_BYTES).ok_or_else(|| bad("table", "does not fit"))?;
    let mut end = TABLE_BYTES as u64;
    let mut ranges = [const { 0..0 }; SECTIONS];
    for (i, kind) in SectionKind::ALL.into_iter().enumerate() {
        let entry: SectionWire = bytemuck::pod_read_unaligned(&table[i * size_of::<SectionWire>()..][..24]);
        let element = kind.element_bytes() as u64;
        let last = entry.offset.checked_add(entry.length);
        let inside = entry.offset >= end && last.is_some_and(|last| last <= bytes.len() as u64);
        let whole = entry.length.is_multiple_of(element) && entry.length / element <= u64::from(u32::MAX);
        let aligned = entry.offset.is_multiple_of(BLOCK_BYTES as u64);
        if entry.kind != kind as u32 || u64::from(entry.element_bytes) != element || !inside || !whole || !aligned {
            return Err(bad(format!("section {}", kind.name()), format!("{entry:?}")));
        }
        end = entry.offset + entry.length;
        ranges[i] = entry.offset as usize..end as usize;
    }
    Ok(ranges)
}

/// Whether `count` elements from `first` on lie within `length`.
fn within(first: u32, count: u32, length: usize) -> bool {
    u64::from(first) + u64::from(count) <= length as u64
}

/// Whether these are whole triangles: materials, one per triangle, are found by their places.
fn triangles(index_first: u32, index_count: u32) -> bool {
    index_first.is_multiple_of(3) && index_count.is_multiple_of(3)
}

/// Whether the part lies inside the whole.
fn nested(part: (u32, u32), whole: (u32, u32)) -> bool {
    part.0 >= whole.0 && u64::from(part.0) + u64::from(part.1) <= u64::from(whole.0) + u64::from(whole.1)
}

fn contents(view: &ResultView<'_>) -> Result<(), Error> {
    let (fragments, vertices) = (view.fragments.len(), view.positions.len());
    for (name, length, whole) in [
        ("velocities", view.velocities.len(), fragments),
        ("normals", view.normals.len(), vertices),
        ("uvs", view.uvs.len(), vertices),
        ("hulls", view.hulls.len(), fragments),
        ("outer_attributes", view.outer_attributes.len(), vertices),
        ("materials", view.materials.len(), view.indices.len() / 3),
        ("outer_uvs2", view.outer_uvs2.len(), vertices),
        ("outer_colors", view.outer_colors.len(), vertices),
        ("skins", view.skins.len(), fragments),
        ("skin_materials", view.skin_materials.len(), view.skin_indices.len() / 3),
        ("skin_uvs2", view.skin_uvs2.len(), view.skin_vertices.len()),
        ("skin_colors", view.skin_colors.len(), view.skin_vertices.len()),
    ] {
        if length != 0 && length != whole {
            return Err(bad(name, format!("{length} of {whole}")));
        }
    }
    let pairs = view.bonds.iter().map(|bond| ("bonds", bond.fragments, bond.holds_to_world()));
    let points = view.debris.iter().map(|point| ("debris", [point.fragment, point.neighbor], false));
    for (name, [lower, upper], to_world) in pairs.chain(points) {
        let known = if to_world { lower } else { upper };
        if lower >= upper || known as usize >= fragments {
            return Err(bad(name, format!("fragments {lower} and {upper} of {fragments}")));
        }
    }
    for (i, fragment) in view.fragments.iter().enumerate() {
        self::fragment(view, i, fragment).map_err(|what| bad(format!("fragments[{i}]"), what))?;
    }
    for (i, run) in view.runs.iter().enumerate() {
        self::run(view, run).map_err(|what| bad(format!("runs[{i}]"), what))?;
    }
    for (i, hull) in view.hulls.iter().enumerate() {
        let [vertices, indices] = [(hull.vertex_first, hull.vertex_count), (hull.index_first, hull.index_count)];
        mesh(vertices, view.hull_positions.len(), indices, view.hull_indices)
            .map_err(|what| bad(format!("hulls[{i}]"), what))?;
    }
    for (i, skin) in view.skins.iter().enumerate() {
        let [vertices, indices] = [(skin.vertex_first, skin.vertex_count), (skin.index_first, skin.index_count)];
        mesh(vertices, view.skin_vertices.len(), indices, view.skin_indices)
            .map_err(|what| bad(format!("skins[{i}]"), what))?;
    }
    Ok(())
}

fn fragment(view: &ResultView<'_>, i: usize, fragment: &FragmentWire) -> Result<(), &'static str> {
    let f = fragment;
    if f.id as usize != i {
        return Err("id is not its position");
    }
    if !within(f.vertex_first, f.vertex_count, view.positions.len()) {
        return Err("vertices out of range");
    }
    if !within(f.index_first, f.index_count, view.indices.len()) || !triangles(f.index_first, f.index_count) {
        return Err("indices out of range, or not whole triangles");
    }
    if !within(f.run_first, f.run_count, view.runs.len()) || !within(f.merge_first, f.merge_count, view.merges.len()) {
        return Err("runs or merges out of range");
    }
    if view.runs[f.run_first as usize..][..f.run_count as usize].iter().any(|run| run.fragment != f.id) {
        return Err("a run belongs to another fragment");
    }
    let indices = &view.indices[f.index_first as usize..][..f.index_count as usize];
    if indices.iter().copied().max().is_some_and(|index| index >= f.vertex_count) {
        return Err("an index points beyond the fragment");
    }
    let merges = &view.merges[f.merge_first as usize..][..f.merge_count as usize];
    if merges.iter().flatten().any(|vertex| *vertex >= f.vertex_count) {
        return Err("a merge pair points beyond the fragment");
    }
    Ok(())
}

fn run(view: &ResultView<'_>, run: &RunWire) -> Result<(), &'static str> {
    let fragment = view.fragments.get(run.fragment as usize).ok_or("belongs to no fragment")?;
    if run.neighbor != OUTER && run.neighbor as usize >= view.fragments.len() {
        return Err("neighbor is no fragment");
    }
    if run.material > 1 || (run.neighbor != OUTER && run.material != 1) {
        return Err("material is neither outer nor crack");
    }
    let vertices = (fragment.vertex_first, fragment.vertex_count);
    let indices = (fragment.index_first, fragment.index_count);
    let inside = nested((run.vertex_first, run.vertex_count), vertices)
        && nested((run.index_first, run.index_count), indices)
        && triangles(run.index_first, run.index_count);
    if inside { Ok(()) } else { Err("reaches beyond its fragment") }
}

/// A mesh of its own beside a fragment: which of so many vertices, which of the indices.
fn mesh(vertices: (u32, u32), of: usize, indices: (u32, u32), all: &[u32]) -> Result<(), &'static str> {
    if !within(vertices.0, vertices.1, of) {
        return Err("vertices out of range");
    }
    if !within(indices.0, indices.1, all.len()) || !triangles(indices.0, indices.1) {
        return Err("indices out of range, or not whole triangles");
    }
    let own = &all[indices.0 as usize..][..indices.1 as usize];
    match own.iter().max().is_some_and(|index| *index >= vertices.1) {
        true => Err("an index points beyond its mesh"),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests;
