//! Results in meters, glTF's axes and winding, whatever their convention: the contents of files.

use crate::FractureResult;
use crate::fragment::{Fragment, fragments};
use shatter_proto::convention::Convention;
use shatter_proto::result::{
    BondWire, DebrisWire, FragmentVelocity, FragmentWire, HullWire, OuterAttributes, SkinVertex, SummaryWire,
};
use shatter_proto::view::ResultView;

/// A result in glTF's convention ([`Convention::GLTF`]). A result in that convention is borrowed, any other is copied once.
#[must_use]
pub struct ResultInMeters<'a> {
    given: ResultView<'a>,
    copied: Option<Box<Sections>>,
}

/// The sections of a result that depend on its convention.
struct Sections {
    summary: SummaryWire,
    fragments: Vec<FragmentWire>,
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    velocities: Vec<FragmentVelocity>,
    normals: Vec<[f32; 3]>,
    bonds: Vec<BondWire>,
    debris: Vec<DebrisWire>,
    hulls: Vec<HullWire>,
    hull_positions: Vec<[f32; 3]>,
    hull_indices: Vec<u32>,
    looks: Vec<OuterAttributes>,
    skin_vertices: Vec<SkinVertex>,
    skin_indices: Vec<u32>,
}

impl FractureResult {
    /// The result in meters, along the axes of the mesh file, counter-clockwise.
    pub fn metric(&self) -> ResultInMeters<'_> {
        let (given, convention) = (self.raw_view(), self.convention());
        let copied = (!convention.is_default()).then(|| Box::new(Sections::back(&given, &convention)));
        ResultInMeters { given, copied }
    }
}

impl ResultInMeters<'_> {
    /// The rows of memory, as [`FractureResult::raw_view`].
    #[doc(hidden)]
    pub fn raw_view(&self) -> ResultView<'_> {
        let Some(own) = &self.copied else { return self.given };
        ResultView {
            summary: &own.summary,
            fragments: &own.fragments,
            positions: &own.positions,
            indices: &own.indices,
            velocities: &own.velocities,
            normals: &own.normals,
            bonds: &own.bonds,
            debris: &own.debris,
            hulls: &own.hulls,
            hull_positions: &own.hull_positions,
            hull_indices: &own.hull_indices,
            looks: &own.looks,
            skin_vertices: &own.skin_vertices,
            skin_indices: &own.skin_indices,
            ..self.given
        }
    }

    /// The fragments, in the order of their ids.
    pub fn fragments(&self) -> impl ExactSizeIterator<Item = Fragment<'_>> {
        fragments(self.raw_view())
    }
}

impl Sections {
    fn back(view: &ResultView<'_>, from: &Convention) -> Self {
        let offsets = |own: &[[f32; 3]]| own.iter().map(|offset| from.our_vector_f32(*offset)).collect();
        Self {
            summary: SummaryWire { radius_m: from.meters(view.summary.radius_m), ..*view.summary },
            fragments: rows(view.fragments, |row| FragmentWire {
                volume_m3: from.meters3(row.volume_m3),
                center_m: from.our_vector(row.center_m),
                inertia_kg_m2: from.our_inertia(row.inertia_kg_m2),
                ..*row
            }),
            positions: offsets(view.positions),
            indices: triangles(view.indices, from),
            velocities: rows(view.velocities, |row| FragmentVelocity {
                linear_m_s: from.our_vector(row.linear_m_s),
                angular_rad_s: from.our_axial(row.angular_rad_s),
            }),
            normals: rows(view.normals, |normal| from.our_direction(*normal)),
            bonds: rows(view.bonds, |row| BondWire {
                area_m2: from.meters2(row.area_m2),
                normal: from.our_direction(row.normal),
                centroid_m: from.our_vector(row.centroid_m),
                ..*row
            }),
            debris: rows(view.debris, |row| DebrisWire {
                position_m: from.our_vector_f32(row.position_m),
                normal: from.our_direction(row.normal),
                size_m: from.meters(row.size_m.into()) as f32,
                ..*row
            }),
            hulls: rows(view.hulls, |row| HullWire { margin_m: from.meters(row.margin_m), ..*row }),
            hull_positions: offsets(view.hull_positions),
            hull_indices: triangles(view.hull_indices, from),
            looks: rows(view.looks, |row| OuterAttributes { normal: from.our_direction(row.normal), ..*row }),
            skin_vertices: rows(view.skin_vertices, |row| SkinVertex {
                position_m: from.our_vector_f32(row.position_m),
                normal: from.our_direction(row.normal),
                ..*row
            }),
            skin_indices: triangles(view.skin_indices, from),
        }
    }
}

fn rows<T>(own: &[T], back: impl Fn(&T) -> T) -> Vec<T> {
    own.iter().map(back).collect()
}

/// Corners of triangles, counter-clockwise. Every part of them that a table names is of whole triangles, one after another.
fn triangles(own: &[u32], from: &Convention) -> Vec<u32> {
    let mut corners = own.to_vec();
    if from.is_clockwise() {
        corners.as_chunks_mut::<3>().0.iter_mut().for_each(|[_, b, c]| std::mem::swap(b, c));
    }
    corners
}
