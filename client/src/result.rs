//! An answer: fragments borrowed straight from shared memory.

use crate::connection::{LoanCount, LoanedResult};
use shatter_proto::convention::Convention;
use shatter_proto::result::{
    BLOCK_BYTES, BondWire, DebrisWire, EffectWire, FragmentWire, HitWire, OUTER, RunWire, SkinVertexWire, StageWire,
    SummaryWire, VelocityWire, VertexAttributeWire,
};
use shatter_proto::view::{CheckedLayout, ResultView};
use shatter_proto::{Error, ErrorKind};
use std::time::Duration;

/// The answer to a strike. It holds one bucket of the daemon's pool until it is dropped: drop it once the fragments are
/// copied to where they are needed.
///
/// May be sent to another thread; to share it between threads, share its [`FractureResult::view`].
pub struct FractureResult {
    answer: LoanedResult,
    checked: Box<CheckedLayout>,
    convention: Convention,
    round_trip: Duration,
    _held: LoanCount,
}

/// What a view shows if the daemon's memory changed under it.
static NOTHING: SummaryWire = SummaryWire {
    object: [0; 64],
    object_length: 0,
    degree_source: 0,
    sites: 0,
    fracture_degree: 0,
    capped: 0,
    stop_reason: 0,
    elastic: 0,
    quality: 0,
    gamma_j_m2: 0.0,
    e1_over_gamma: 0.0,
    threshold_impulse_factor: 0.0,
    confidence: 0.0,
    seed: 0,
    handle: 0,
    radius_m: 0.0,
    energy_error: 0.0,
    cvd_gap: 0.0,
    tolerance: 0.0,
    time_ns: 0,
    iterations_max: 0,
    iterations: 0,
    rank: 0,
    lift_modes: 0,
    elastic_nodes: 0,
    crack_nodes: 0,
    degree: 0,
    overrun: 0,
    overrun_ns: 0,
    reduced_error_max: 0.0,
    hit: HitWire { point_m: [0.0; 3], normal: [0.0; 3], distance_m: 0.0, body: 0, present: 0 },
};

impl FractureResult {
    /// Checks every offset, count and index of `answer` before anything of it is used. The request has a sequence and a convention.
    pub(crate) fn new(
        answer: LoanedResult,
        (sequence, convention): (u64, Convention),
        round_trip: Duration,
        held: LoanCount,
    ) -> Result<Self, Error> {
        let header = *answer.user_header();
        if header.sequence != sequence {
            let message = format!("the answer is to request {}, not {sequence}", header.sequence);
            return Err(Error::new(ErrorKind::BadAnswer, "sequence", message));
        }
        let checked = Box::new(CheckedLayout::new(&header, answer.payload())?);
        Ok(Self { answer, checked, convention, round_trip, _held: held })
    }

    /// All sections, borrowed from shared memory.
    pub fn view(&self) -> ResultView<'_> {
        // The ranges fit: they were checked against this very payload, whose length does not change.
        self.checked.view(self.answer.payload()).unwrap_or(ResultView::empty(&NOTHING))
    }

    /// In whose coordinates it is: that of the connection which struck. Lengths, here named by the meter, are in its unit.
    pub fn convention(&self) -> Convention {
        self.convention
    }

    /// The facts of the strike.
    pub fn summary(&self) -> SummaryWire {
        *self.view().summary
    }

    /// What names this answer to later strikes ([`Impact::from`](crate::Impact::from)), if it was to be kept, and is: not where
    /// the object stayed whole, or the service keeps none. It is kept for as long as the service says (`times.kept_s`), until as
    /// many younger ones are kept as it may (`answers.kept_max`), or [`Client::release`](crate::Client::release).
    pub fn handle(&self) -> Option<u64> {
        Some(self.view().summary.handle).filter(|handle| *handle != 0)
    }

    /// What each stage did.
    pub fn stages(&self) -> &[StageWire] {
        self.view().stages
    }

    /// What each effect did.
    pub fn effects(&self) -> &[EffectWire] {
        self.view().effects
    }

    /// Which fragments touch, by their ids, and which the world holds ([`BondWire::holds_to_world`]); empty unless `bonds` is on.
    pub fn bonds(&self) -> &[BondWire] {
        self.view().bonds
    }

    /// Points on cracks from which dust and chips come; empty unless `debris` is on.
    pub fn debris(&self) -> &[DebrisWire] {
        self.view().debris
    }

    /// Whether the object stayed whole: below its threshold, or nothing but the threshold was asked for.
    pub fn is_whole(&self) -> bool {
        self.view().fragments.is_empty()
    }

    /// The fragments, in the order of their ids.
    pub fn fragments(&self) -> impl ExactSizeIterator<Item = Fragment<'_>> {
        fragments(self.view())
    }

    /// The fragment of that number, if there is one.
    pub fn fragment(&self, id: u32) -> Option<Fragment<'_>> {
        let view = self.view();
        view.fragments.get(id as usize).map(|row| Fragment { row, view })
    }

    /// From sending the strike to finding the answer.
    pub fn round_trip(&self) -> Duration {
        self.round_trip
    }

    /// Bytes of the answer.
    pub fn bytes(&self) -> u64 {
        self.answer.user_header().used_bytes
    }

    /// Addresses of the answer in this process: where shared memory is mapped.
    pub fn address_range(&self) -> std::ops::Range<usize> {
        let payload = self.answer.payload();
        let start = payload.as_ptr() as usize;
        start..start + payload.len() * BLOCK_BYTES
    }
}

/// The fragments of an answer, in the order of their ids.
pub(crate) fn fragments(view: ResultView<'_>) -> impl ExactSizeIterator<Item = Fragment<'_>> {
    view.fragments.iter().map(move |row| Fragment { row, view })
}

/// One fragment, borrowed from shared memory.
#[derive(Clone, Copy)]
pub struct Fragment<'a> {
    row: &'a FragmentWire,
    view: ResultView<'a>,
}

/// Triangles of one fragment that face one neighbor, or the outside, or what was there before an earlier crack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run<'a> {
    /// The fragment on the other side of the crack; `None`: the outside, or a fragment of an earlier answer.
    pub neighbor: Option<u32>,
    /// Whether it is a side of a crack, be it one of an earlier answer.
    pub crack: bool,
    /// First index of the run, counted from the fragment's first.
    pub index_first: u32,
    /// Corners of the run's triangles; values count from the fragment's first vertex.
    pub indices: &'a [u32],
    /// First vertex of the run, counted from the fragment's first.
    pub vertex_first: u32,
    /// Positions of the run's own vertices, m.
    pub positions: &'a [[f32; 3]],
}

/// The convex proxy of a fragment, for collisions: at most 64 triangles, and fewer vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullMesh<'a> {
    /// Corners, m, relative to [`Fragment::center_m`].
    pub positions: &'a [[f32; 3]],
    /// Indices into the corners, three per triangle, counter-clockwise from outside.
    pub indices: &'a [u32],
    /// Volume of the part of the fragment inside the hull over that of the fragment.
    pub coverage: f64,
    /// The deepest that the surface of any other fragment lies below the hull's surface, m.
    pub margin_m: f64,
}

/// The input's own triangles as far as they are a fragment's, for rendering: with the crack faces of its runs they are what is seen
/// of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FragmentSkin<'a> {
    /// Vertices, relative to [`Fragment::center_m`].
    pub vertices: &'a [SkinVertexWire],
    /// Indices into the vertices, three per triangle, counter-clockwise from outside.
    pub indices: &'a [u32],
    /// One per triangle: the place of a material in the mesh file, or
    /// [`NO_MATERIAL`](shatter_proto::result::NO_MATERIAL); empty if the file has none.
    pub materials: &'a [u32],
}

/// The part of a slice that a table names. Checked when the answer came; a part that no longer fits is empty.
fn part<T>(slice: &[T], first: u32, count: u32) -> &[T] {
    let first = first as usize;
    first.checked_add(count as usize).and_then(|end| slice.get(first..end)).unwrap_or(&[])
}

impl<'a> Fragment<'a> {
    /// Everything the table says about it.
    pub fn row(&self) -> FragmentWire {
        *self.row
    }

    /// Its number in the answer.
    pub fn id(&self) -> u32 {
        self.row.id
    }

    /// Positions, m, relative to [`Self::center_m`].
    pub fn positions(&self) -> &'a [[f32; 3]] {
        part(self.view.positions, self.row.vertex_first, self.row.vertex_count)
    }

    /// Normals, one per position; empty unless `normals` is on.
    pub fn normals(&self) -> &'a [[f32; 3]] {
        part(self.view.normals, self.row.vertex_first, self.row.vertex_count)
    }

    /// Texture coordinates, m, one per position; zero on the outside; empty unless `uv` is on.
    pub fn uvs(&self) -> &'a [[f32; 2]] {
        part(self.view.uvs, self.row.vertex_first, self.row.vertex_count)
    }

    /// How it moves once it is free, on top of how the object moved; `None` unless `release` is on.
    pub fn velocity(&self) -> Option<VelocityWire> {
        self.view.velocities.get(self.row.id as usize).copied()
    }

    /// Its convex proxy; `None` unless `hulls` is on, and for a fragment too flat for one.
    pub fn hull(&self) -> Option<HullMesh<'a>> {
        let row = self.view.hulls.get(self.row.id as usize).filter(|row| row.vertex_count > 0)?;
        let positions = part(self.view.hull_positions, row.vertex_first, row.vertex_count);
        let indices = part(self.view.hull_indices, row.index_first, row.index_count);
        Some(HullMesh { positions, indices, coverage: row.coverage, margin_m: row.margin_m })
    }

    /// How the outer faces look where the input does so, one per position, zero on cracks; empty unless `attributes` is on.
    pub fn vertex_attributes(&self) -> &'a [VertexAttributeWire] {
        part(self.view.looks, self.row.vertex_first, self.row.vertex_count)
    }

    /// The input's materials, one per triangle, [`NO_MATERIAL`](shatter_proto::result::NO_MATERIAL) on cracks; empty unless
    /// `attributes` is on and the input has any.
    pub fn materials(&self) -> &'a [u32] {
        part(self.view.materials, self.row.index_first / 3, self.row.index_count / 3)
    }

    /// Its part of the input's surface; `None` unless `skin` is on.
    pub fn skin(&self) -> Option<FragmentSkin<'a>> {
        let row = self.view.skins.get(self.row.id as usize)?;
        Some(FragmentSkin {
            vertices: part(self.view.skin_vertices, row.vertex_first, row.vertex_count),
            indices: part(self.view.skin_indices, row.index_first, row.index_count),
            materials: part(self.view.skin_materials, row.index_first / 3, row.index_count / 3),
        })
    }

    /// Indices into [`Self::positions`], three per triangle, counter-clockwise from outside.
    pub fn indices(&self) -> &'a [u32] {
        part(self.view.indices, self.row.index_first, self.row.index_count)
    }

    /// Pairs (from, to) of vertices that are the same point.
    pub fn merges(&self) -> &'a [[u32; 2]] {
        part(self.view.merges, self.row.merge_first, self.row.merge_count)
    }

    /// The runs: the outer one first, if there is one, then one per neighbor, then those on cracks of earlier answers.
    pub fn runs(&self) -> impl ExactSizeIterator<Item = Run<'a>> {
        let (view, fragment) = (self.view, self.row);
        let rows: &'a [RunWire] = part(view.runs, fragment.run_first, fragment.run_count);
        rows.iter().map(move |run| Run {
            neighbor: (run.neighbor != OUTER).then_some(run.neighbor),
            crack: run.material != 0,
            index_first: run.index_first.saturating_sub(fragment.index_first),
            indices: part(view.indices, run.index_first, run.index_count),
            vertex_first: run.vertex_first.saturating_sub(fragment.vertex_first),
            positions: part(view.positions, run.vertex_first, run.vertex_count),
        })
    }

    /// Volume, m³.
    pub fn volume_m3(&self) -> f64 {
        self.row.volume_m3
    }

    /// Mass, kg.
    pub fn mass_kg(&self) -> f64 {
        self.row.mass_kg
    }

    /// Center of mass in the coordinates of the mesh file, m.
    pub fn center_m(&self) -> [f64; 3] {
        self.row.center_m
    }

    /// Inertia tensor about the center, kg·m²: xx, yy, zz, xy, xz, yz.
    pub fn inertia_kg_m2(&self) -> [f64; 6] {
        self.row.inertia_kg_m2
    }

    /// Whether its surface is closed and oriented: after welding bitwise equal positions, every edge has exactly two
    /// opposite half-edges.
    pub fn is_closed(&self) -> bool {
        is_closed(self.positions(), self.indices())
    }
}

/// See [`Fragment::is_closed`]; the merge pairs are not consulted.
fn is_closed(positions: &[[f32; 3]], indices: &[u32]) -> bool {
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    let key = |vertex: &u32| positions[*vertex as usize].map(f32::to_bits);
    order.sort_unstable_by_key(key);
    let mut welded = vec![0u32; positions.len()];
    for same in order.chunk_by(|a, b| key(a) == key(b)) {
        for vertex in same {
            welded[*vertex as usize] = same[0];
        }
    }
    let mut edges = Vec::with_capacity(indices.len());
    for triangle in indices.chunks_exact(3) {
        let Some(corners) = corners(triangle, &welded) else { return false };
        for k in 0..3 {
            edges.push((corners[k], corners[(k + 1) % 3]));
        }
    }
    edges.sort_unstable();
    let unique = edges.windows(2).all(|pair| pair[0] != pair[1]);
    let paired = |&(a, b): &(u32, u32)| a != b && edges.binary_search(&(b, a)).is_ok();
    !indices.is_empty() && indices.len().is_multiple_of(3) && unique && edges.iter().all(paired)
}

fn corners(triangle: &[u32], welded: &[u32]) -> Option<[u32; 3]> {
    let corner = |k: usize| welded.get(triangle[k] as usize).copied();
    Some([corner(0)?, corner(1)?, corner(2)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    const CORNERS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    const FACES: [u32; 12] = [1, 2, 3, 0, 3, 2, 0, 1, 3, 0, 2, 1];

    #[test]
    fn a_tetrahedron_is_closed_shared_or_split() {
        assert!(is_closed(&CORNERS, &FACES));
        let split: Vec<[f32; 3]> = FACES.iter().map(|corner| CORNERS[*corner as usize]).collect();
        let indices: Vec<u32> = (0..12).collect();
        assert!(is_closed(&split, &indices));
    }

    #[test]
    fn holes_flips_duplicates_and_nothing_are_not_closed() {
        assert!(!is_closed(&CORNERS, &FACES[3..]));
        let mut flipped = FACES;
        flipped.swap(0, 1);
        assert!(!is_closed(&CORNERS, &flipped));
        assert!(!is_closed(&CORNERS, &[FACES, FACES].concat()));
        assert!(!is_closed(&CORNERS, &[]));
        assert!(!is_closed(&CORNERS, &[0, 1, 9]));
        let mut moved = FACES.map(|corner| CORNERS[corner as usize]);
        moved[0][0] += f32::EPSILON;
        assert!(!is_closed(&moved, &(0..12).collect::<Vec<u32>>()));
    }

    #[test]
    fn parts_that_do_not_fit_are_empty() {
        assert_eq!(part(&[1, 2, 3], 1, 2), [2, 3]);
        assert!(part(&[1, 2, 3], 2, 2).is_empty() && part(&[1], u32::MAX, u32::MAX).is_empty());
    }

    #[test]
    fn nothing_is_all_zero() {
        assert_eq!(NOTHING, SummaryWire::zeroed());
    }
}
