//! The sections of a result: one table says everything that layout, writer, reader and unit conversion know of them.

use crate::convention::Convention;
use crate::effect::Effect;
use crate::in_meters::{InMeters, direction, each, offset, same, triangles};
use crate::result::{
    BondWire, DebrisWire, EffectWire, FragmentVelocity, FragmentWire, HullWire, OuterAttributes, RunWire, SkinVertex,
    SkinWire, StageKind, StageWire, SummaryWire,
};

/// Element counts of the sections that depend on the request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SectionCounts {
    /// Fragments.
    pub fragments: usize,
    /// Runs.
    pub runs: usize,
    /// Merge pairs.
    pub merges: usize,
    /// Vertices.
    pub vertices: usize,
    /// Indices.
    pub indices: usize,
    /// Velocities: one per fragment, or none.
    pub velocities: usize,
    /// Normals: one per vertex, or none.
    pub normals: usize,
    /// Texture coordinates: one per vertex, or none.
    pub uvs: usize,
    /// Bonds.
    pub bonds: usize,
    /// Points of debris.
    pub debris: usize,
    /// Hulls: one per fragment, or none.
    pub hulls: usize,
    /// Vertices of hulls.
    pub hull_vertices: usize,
    /// Indices of hulls.
    pub hull_indices: usize,
    /// Outer attributes: one per vertex, or none.
    pub outer_attributes: usize,
    /// Materials: one per triangle, or none.
    pub materials: usize,
    /// Skins: one per fragment, or none.
    pub skins: usize,
    /// Vertices of skins.
    pub skin_vertices: usize,
    /// Indices of skins.
    pub skin_indices: usize,
    /// Materials of skins: one per triangle, or none.
    pub skin_materials: usize,
    /// Second texture coordinates of the input: one per vertex, or none.
    pub outer_uvs2: usize,
    /// Colors of the input: one per vertex, or none.
    pub outer_colors: usize,
    /// Second texture coordinates of skins: one per vertex of them, or none.
    pub skin_uvs2: usize,
    /// Colors of skins: one per vertex of them, or none.
    pub skin_colors: usize,
}

/// Number, kind, name, element, the effect that a section belongs to, how many elements it has, and how its elements are converted from a
/// host's convention to the default one.
macro_rules! sections {
    ($(
        $(#[doc = $doc:literal])*
        $number:literal $kind:ident $name:ident: $row:ty, $effect:expr, $count:expr, $in_meters:expr;
    )*) => {
        /// The sections of a result.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u32)]
        pub enum SectionKind {
            /// One [`SummaryWire`].
            Summary = 1,
            $($(#[doc = $doc])* $kind = $number,)*
        }

        impl SectionKind {
            /// All sections, in the order in which they lie in the payload.
            pub const ALL: [Self; 1 + [$($number),*].len()] = [Self::Summary, $(Self::$kind),*];

            /// The effect that it belongs to; `None`: every result has it.
            pub fn effect(self) -> Option<Effect> {
                match self {
                    Self::Summary => None,
                    $(Self::$kind => $effect,)*
                }
            }

            /// The name used in JSON.
            pub fn name(self) -> &'static str {
                match self {
                    Self::Summary => "summary",
                    $(Self::$kind => stringify!($name),)*
                }
            }

            /// Bytes per element.
            pub fn element_bytes(self) -> usize {
                match self {
                    Self::Summary => size_of::<SummaryWire>(),
                    $(Self::$kind => size_of::<$row>(),)*
                }
            }
        }

        impl SectionCounts {
            /// Elements of a section.
            pub fn elements(&self, kind: SectionKind) -> usize {
                fn of(counts: &SectionCounts, count: impl Fn(&SectionCounts) -> usize) -> usize {
                    count(counts)
                }
                match kind {
                    SectionKind::Summary => 1,
                    $(SectionKind::$kind => of(self, $count),)*
                }
            }
        }

        /// The sections of a payload, to be written.
        pub struct SectionsMut<'a> {
            /// The facts.
            pub summary: &'a mut SummaryWire,
            $($(#[doc = $doc])* pub $name: &'a mut [$row],)*
        }

        impl<'a> SectionsMut<'a> {
            /// Of the bytes of all sections, in their order; `None` if one is missing or does not fit its type.
            pub(crate) fn of(mut next: impl FnMut() -> Option<&'a mut [u8]>) -> Option<Self> {
                Some(Self {
                    summary: bytemuck::try_from_bytes_mut(next()?).ok()?,
                    $($name: bytemuck::try_cast_slice_mut(next()?).ok()?,)*
                })
            }
        }

        /// The sections of a checked result, borrowed.
        #[derive(Clone, Copy, Debug)]
        pub struct ResultView<'a> {
            /// The facts.
            pub summary: &'a SummaryWire,
            $($(#[doc = $doc])* pub $name: &'a [$row],)*
        }

        impl<'a> ResultView<'a> {
            /// Of the bytes of each section; `None` if one is missing or does not fit its type.
            pub(crate) fn of(section: impl Fn(SectionKind) -> Option<&'a [u8]>) -> Option<Self> {
                Some(Self {
                    summary: bytemuck::try_from_bytes(section(SectionKind::Summary)?).ok()?,
                    $($name: bytemuck::try_cast_slice(section(SectionKind::$kind)?).ok()?,)*
                })
            }

            /// A summary only.
            pub fn empty(summary: &'a SummaryWire) -> Self {
                Self { summary, $($name: &[],)* }
            }

            /// A copy of the sections that depend on the convention, from `from` to the default one.
            #[must_use]
            pub fn in_meters(&self, from: &Convention) -> SectionsInMeters {
                fn of<T>(rows: &[T], from: &Convention, convert: impl Fn(&[T], &Convention) -> Option<Vec<T>>) -> Option<Vec<T>> {
                    convert(rows, from)
                }
                SectionsInMeters {
                    summary: self.summary.in_meters(from),
                    $($name: of(self.$name, from, $in_meters),)*
                }
            }

            /// The bytes of a section.
            pub fn bytes(&self, kind: SectionKind) -> &'a [u8] {
                match kind {
                    SectionKind::Summary => bytemuck::bytes_of(self.summary),
                    $(SectionKind::$kind => bytemuck::cast_slice(self.$name),)*
                }
            }
        }

        /// The sections of a result that depend on its convention, in the default one.
        #[derive(Clone, Debug)]
        pub struct SectionsInMeters {
            summary: SummaryWire,
            $($name: Option<Vec<$row>>,)*
        }

        impl SectionsInMeters {
            /// These sections, and those of `given` that do not depend on the convention.
            #[must_use]
            pub fn view<'a>(&'a self, given: &ResultView<'a>) -> ResultView<'a> {
                ResultView {
                    summary: &self.summary,
                    $($name: self.$name.as_deref().unwrap_or(given.$name),)*
                }
            }
        }
    };
}

sections! {
    /// One [`StageWire`] per stage.
    2 Stages stages: StageWire, None, |_| StageKind::ALL.len(), same;
    /// One [`FragmentWire`] per fragment.
    3 Fragments fragments: FragmentWire, None, |counts| counts.fragments, each(InMeters::in_meters);
    /// One [`RunWire`] per run.
    4 Runs runs: RunWire, None, |counts| counts.runs, same;
    /// Pairs of u32: (from, to) vertices of one fragment that are the same point.
    5 Merges merges: [u32; 2], None, |counts| counts.merges, same;
    /// Three f32 per vertex, m, relative to the fragment's center of mass.
    6 Positions positions: [f32; 3], None, |counts| counts.vertices, each(offset);
    /// One u32 per corner, three per triangle, counter-clockwise from outside.
    7 Indices indices: u32, None, |counts| counts.indices, triangles;
    /// One [`EffectWire`] per effect.
    8 Effects effects: EffectWire, None, |_| Effect::ALL.len(), same;
    /// One [`FragmentVelocity`] per fragment, or none.
    9 Velocities velocities: FragmentVelocity, Some(Effect::Release), |counts| counts.velocities, each(InMeters::in_meters);
    /// Three f32 per vertex, of length one; or none.
    10 Normals normals: [f32; 3], Some(Effect::Normals), |counts| counts.normals, each(direction);
    /// Two f32 per vertex, m; or none.
    11 Uvs uvs: [f32; 2], Some(Effect::Uv), |counts| counts.uvs, same;
    /// One [`BondWire`] per pair of fragments that touch, and per fragment that the world holds; or none.
    12 Bonds bonds: BondWire, Some(Effect::Bonds), |counts| counts.bonds, each(InMeters::in_meters);
    /// One [`DebrisWire`] per point, or none.
    13 Debris debris: DebrisWire, Some(Effect::Debris), |counts| counts.debris, each(InMeters::in_meters);
    /// One [`HullWire`] per fragment, or none.
    14 Hulls hulls: HullWire, Some(Effect::Hulls), |counts| counts.hulls, each(InMeters::in_meters);
    /// Three f32 per vertex of a hull, m, relative to the center of mass of the hull's fragment.
    15 HullPositions hull_positions: [f32; 3], Some(Effect::Hulls), |counts| counts.hull_vertices, each(offset);
    /// One u32 per corner of a hull's triangles, counter-clockwise from outside, relative to the first vertex of the hull.
    16 HullIndices hull_indices: u32, Some(Effect::Hulls), |counts| counts.hull_indices, triangles;
    /// One [`OuterAttributes`] per vertex, or none.
    17 OuterAttributes outer_attributes: OuterAttributes, Some(Effect::Attributes), |counts| counts.outer_attributes, each(InMeters::in_meters);
    /// One u32 per triangle, a material of the input or [`NO_MATERIAL`](crate::result::NO_MATERIAL); none if it has no materials.
    18 Materials materials: u32, Some(Effect::Attributes), |counts| counts.materials, same;
    /// One [`SkinWire`] per fragment, or none.
    19 Skins skins: SkinWire, Some(Effect::Skin), |counts| counts.skins, same;
    /// One [`SkinVertex`] per vertex of a skin.
    20 SkinVertices skin_vertices: SkinVertex, Some(Effect::Skin), |counts| counts.skin_vertices, each(InMeters::in_meters);
    /// One u32 per corner of a skin's triangles, counter-clockwise from outside, relative to the first vertex of the skin.
    21 SkinIndices skin_indices: u32, Some(Effect::Skin), |counts| counts.skin_indices, triangles;
    /// One u32 per triangle of all skins, as `materials`; none if the input has no materials.
    22 SkinMaterials skin_materials: u32, Some(Effect::Skin), |counts| counts.skin_materials, same;
    /// Two f32 per vertex, the second texture coordinates of the input, v upwards, zero on cracks; none if it has none.
    23 OuterUvs2 outer_uvs2: [f32; 2], Some(Effect::Attributes), |counts| counts.outer_uvs2, same;
    /// Four bytes per vertex: red, green, blue and alpha of the input, white on cracks; none if it has no colors.
    24 OuterColors outer_colors: [u8; 4], Some(Effect::Attributes), |counts| counts.outer_colors, same;
    /// Two f32 per vertex of a skin, as `outer_uvs2`; or none.
    25 SkinUvs2 skin_uvs2: [f32; 2], Some(Effect::Skin), |counts| counts.skin_uvs2, same;
    /// Four bytes per vertex of a skin, as `outer_colors`; or none.
    26 SkinColors skin_colors: [u8; 4], Some(Effect::Skin), |counts| counts.skin_colors, same;
}
