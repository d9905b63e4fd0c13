//! The glTF document: accessors, meshes, nodes, and the buffer that they refer to.

use super::check::{closed, merged};
use super::material_groups::{by_material, has_plain_triangles};
use super::normals::smooth_normals;
use super::placement::{ExactSingles, Placement};
use super::{ExportError, FragmentView, SourceMaterials};
use gltf_json::accessor::{self, Accessor, ComponentType, GenericComponentType, IndexComponentType, Type};
use gltf_json::buffer::{self, Buffer, Stride, Target, View};
use gltf_json::material::{EmissiveFactor, PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use gltf_json::mesh::{Mesh, Mode, Primitive, Semantic};
use gltf_json::validation::{Checked::Valid, USize64};
use gltf_json::{Asset, Extras, Index, Material, Node, Root, Scene, extensions};
use serde::Serialize;
use serde_json::value::to_raw_value;
use serde_json::{Map, Serializer, Value, json};

/// Name of the parent of all nodes, in the file of an object far from the origin.
const PARENT: &str = "object";

const MANIFOLD: &str = "EXT_mesh_manifold";
const VECTOR_BYTES: usize = 12;
const UV_BYTES: usize = 8;
const COLOR_BYTES: usize = 4;
const SCALAR_BYTES: usize = 4;

/// Images start at multiples of this number of bytes in the buffer.
const IMAGE_ALIGNMENT: usize = 4;

/// Base colors, linear: weathered stone outside, paler and warmer on cracks.
pub(super) const OUTER_COLOR: [f32; 4] = [0.36, 0.39, 0.43, 1.0];
pub(super) const CRACK_COLOR: [f32; 4] = [0.78, 0.64, 0.47, 1.0];

/// A document with the contents of its one buffer.
pub(super) struct Document<'a> {
    root: Root,
    pub binary: Vec<u8>,
    /// Number of meshes with the manifold extension.
    pub closed: usize,
    /// True if the nodes have a common parent.
    has_parent: bool,
    /// Lists of the mesh file, if its materials are written.
    source: Option<SourceLists<'a>>,
}

impl Document<'_> {
    /// The document as JSON.
    pub(super) fn json(&self) -> Result<Vec<u8>, serde_json::Error> {
        match &self.source {
            Some(source) => self.serialized(&WithSource { root: &self.root, source }),
            None => self.serialized(&self.root),
        }
    }

    fn serialized(&self, content: &impl Serialize) -> Result<Vec<u8>, serde_json::Error> {
        if !self.has_parent {
            return serde_json::to_vec(content);
        }
        let mut json = Vec::new();
        content.serialize(&mut Serializer::with_formatter(&mut json, ExactSingles))?;
        Ok(json)
    }
}

/// A document whose materials, textures, samplers and images are those of `source`; the lists of `root` are empty.
#[derive(Serialize)]
struct WithSource<'a> {
    #[serde(flatten)]
    root: &'a Root,
    #[serde(flatten)]
    source: &'a SourceLists<'a>,
}

/// Lists of the mesh file, as they are there. glTF allows no empty list.
#[derive(Serialize)]
struct SourceLists<'a> {
    materials: Vec<Slot<'a>>,
    #[serde(skip_serializing_if = "<[Value]>::is_empty")]
    textures: &'a [Value],
    #[serde(skip_serializing_if = "<[Value]>::is_empty")]
    samplers: &'a [Value],
    #[serde(skip_serializing_if = "Vec::is_empty")]
    images: Vec<Value>,
}

/// A material of the file.
#[derive(Serialize)]
#[serde(untagged)]
enum Slot<'a> {
    /// Of the mesh file.
    Source(&'a Value),
    /// Of this module.
    Own(Box<Material>),
}

/// Indices of the materials in the file.
#[derive(Clone, Copy)]
struct Slots {
    /// True if those of the mesh file come first, with their own indices.
    has_source: bool,
    outer: Index<Material>,
    crack: Index<Material>,
}

impl Slots {
    /// Adds the materials `outer` and `crack` after those of the mesh file. With the latter, `outer` is left out if it is not needed.
    fn new(root: &mut Root, fragments: &[FragmentView<'_>], source: Option<&SourceMaterials>) -> Self {
        let first = source.map_or(0, SourceMaterials::count) as u32;
        if source.is_none() || fragments.iter().any(has_plain_triangles) {
            // Renderers multiply it by the colors of vertices.
            let has_colors = fragments.iter().any(|fragment| !fragment.colors.is_empty());
            root.push(material("outer", if has_colors { [1.0; 4] } else { OUTER_COLOR }, 0.75));
        }
        let crack = root.push(material("crack", CRACK_COLOR, 0.95)).value() as u32;
        Self { has_source: source.is_some(), outer: Index::new(first), crack: Index::new(first + crack) }
    }

    /// The material of outer triangles that have this one in the mesh file.
    fn of_outer(&self, material: Option<u32>) -> Index<Material> {
        material.filter(|_| self.has_source).map_or(self.outer, Index::new)
    }

    /// Extra data of a primitive: the material in the mesh file, if it is not that of the primitive.
    fn extras(&self, material: Option<u32>) -> Result<Extras, ExportError> {
        let unnamed = material.filter(|_| !self.has_source);
        Ok(unnamed.map(|material| to_raw_value(&json!({ "material": material }))).transpose()?)
    }
}

/// The buffer: one view after the other.
#[derive(Default)]
struct Sections {
    positions: Vec<u8>,
    normals: Vec<u8>,
    indices: Vec<u8>,
    uvs: Vec<u8>,
    uvs2: Vec<u8>,
    colors: Vec<u8>,
    merges: Vec<u8>,
}

/// Lengths of the buffer views, in the order of [`Sections`].
#[derive(Clone, Copy)]
struct Views {
    positions: Index<View>,
    normals: Index<View>,
    indices: Index<View>,
    uvs: Index<View>,
    uvs2: Index<View>,
    colors: Index<View>,
    merges: Index<View>,
}

/// Name of fragment `id` of `of` fragments in files.
pub(super) fn fragment_name(id: u32, of: usize) -> String {
    let width = of.saturating_sub(1).to_string().len().max(3);
    format!("fragment_{id:0width$}")
}

/// Builds the document, with the materials of the mesh file if they are given. Both have been checked.
pub(super) fn build<'a>(
    fragments: &[FragmentView<'_>],
    source: Option<&'a SourceMaterials>,
) -> Result<Document<'a>, ExportError> {
    // An empty view is not written.
    let any = |has: &dyn Fn(&FragmentView<'_>) -> bool| u32::from(fragments.iter().any(has));
    let second = 3 + any(&|fragment| !fragment.uvs.is_empty());
    let third = second + any(&|fragment| !fragment.of_outer(fragment.uvs2).is_empty());
    let last = third + any(&|fragment| !fragment.of_outer(fragment.colors).is_empty());
    let [positions, normals, indices, uvs, uvs2, colors, merges] = [0, 1, 2, 3, second, third, last].map(Index::new);
    let mut writer = Writer {
        root: Root::default(),
        sections: Sections::default(),
        views: Views { positions, normals, indices, uvs, uvs2, colors, merges },
        closed: 0,
    };
    let placement = Placement::of(fragments);
    let slots = Slots::new(&mut writer.root, fragments, source);
    let mut nodes = Vec::with_capacity(fragments.len());
    for fragment in fragments {
        let name = fragment_name(fragment.id, fragments.len());
        let mesh = writer.mesh(fragment, &name, slots)?;
        let mesh = writer.root.push(mesh);
        nodes.push(writer.root.push(node(fragment, &placement, name, mesh)?));
    }
    if let Some(origin_m) = placement.origin_m {
        let (children, translation) = (Some(nodes), Some(origin_m));
        nodes =
            vec![writer.root.push(Node { children, name: Some(PARENT.to_owned()), translation, ..Node::default() })];
    }
    let scene = Scene { extensions: None, extras: None, name: Some("fragments".to_owned()), nodes };
    writer.root.scene = Some(writer.root.push(scene));
    Ok(writer.finish(placement.origin_m.is_some(), source))
}

struct Writer {
    root: Root,
    sections: Sections,
    views: Views,
    closed: usize,
}

impl Writer {
    fn mesh(&mut self, fragment: &FragmentView<'_>, name: &str, slots: Slots) -> Result<Mesh, ExportError> {
        let vertices = self.vertices(fragment);
        let outer_vertices = [&vertices[..], &self.outer_vertices(fragment)].concat();
        let base = self.sections.indices.len();
        let (indices, groups) = by_material(fragment);
        self.sections.indices.extend(indices.iter().flat_map(|index| index.to_le_bytes()));
        let mut primitives = Vec::with_capacity(groups.len() + 1);
        let mut first = 0;
        for group in groups {
            let accessor = self.root.push(self.indices(base + first * SCALAR_BYTES, group.index_count));
            let mut outer = primitive(&outer_vertices, accessor, Some(slots.of_outer(group.material)));
            outer.extras = slots.extras(group.material)?;
            primitives.push(outer);
            first += group.index_count;
        }
        if first < indices.len() {
            let accessor = self.root.push(self.indices(base + first * SCALAR_BYTES, indices.len() - first));
            primitives.push(primitive(&vertices, accessor, Some(slots.crack)));
        }
        let extensions = self.manifold(fragment, &indices, &vertices[..1], base);
        Ok(Mesh { extensions, extras: None, name: Some(name.to_owned()), primitives, weights: None })
    }

    /// Adds accessors of positions and normals, and of texture coordinates if there are any.
    fn vertices(&mut self, fragment: &FragmentView<'_>) -> Vec<(Semantic, Index<Accessor>)> {
        let bytes =
            |vectors: &[[f32; 3]]| -> Vec<u8> { vectors.iter().flatten().flat_map(|x| x.to_le_bytes()).collect() };
        let (low, high) = bounds(fragment.positions);
        let mut positions = vectors(self.views.positions, self.sections.positions.len(), fragment.positions.len());
        positions.min = Some(json!(low));
        positions.max = Some(json!(high));
        let normals = vectors(self.views.normals, self.sections.normals.len(), fragment.positions.len());
        self.sections.positions.extend(bytes(fragment.positions));
        match fragment.normals.is_empty() {
            true => self.sections.normals.extend(bytes(&smooth_normals(fragment.positions, fragment.indices))),
            false => self.sections.normals.extend(bytes(fragment.normals)),
        }
        let mut all =
            vec![(Semantic::Positions, self.root.push(positions)), (Semantic::Normals, self.root.push(normals))];
        if !fragment.uvs.is_empty() {
            let (first, count) = (self.sections.uvs.len(), fragment.uvs.len());
            let uvs = accessor(self.views.uvs, first, count, ComponentType::F32, Type::Vec2);
            let down = fragment.uvs.iter().flat_map(|[u, v]| [*u, 1.0 - v]);
            self.sections.uvs.extend(down.flat_map(|x| x.to_le_bytes()));
            all.push((Semantic::TexCoords(0), self.root.push(uvs)));
        }
        all
    }

    /// Adds accessors of what outer faces alone have: second texture coordinates and colors, if there are any.
    fn outer_vertices(&mut self, fragment: &FragmentView<'_>) -> Vec<(Semantic, Index<Accessor>)> {
        let mut all = Vec::new();
        let (uvs, colors) = (fragment.of_outer(fragment.uvs2), fragment.of_outer(fragment.colors));
        if !uvs.is_empty() {
            let (view, first) = (self.views.uvs2, self.sections.uvs2.len());
            let down = uvs.iter().flat_map(|[u, v]| [*u, 1.0 - v]);
            self.sections.uvs2.extend(down.flat_map(|x| x.to_le_bytes()));
            let uvs = accessor(view, first, uvs.len(), ComponentType::F32, Type::Vec2);
            all.push((Semantic::TexCoords(1), self.root.push(uvs)));
        }
        if !colors.is_empty() {
            let (view, first) = (self.views.colors, self.sections.colors.len());
            self.sections.colors.extend_from_slice(colors.as_flattened());
            let colors = accessor(view, first, colors.len(), ComponentType::U8, Type::Vec4);
            all.push((Semantic::Colors(0), self.root.push(Accessor { normalized: true, ..colors })));
        }
        all
    }

    fn indices(&self, offset: usize, count: usize) -> Accessor {
        accessor(self.views.indices, offset, count, ComponentType::U32, Type::Scalar)
    }

    /// Adds the extension if its claim holds: all triangles in the written order, with the indices of merged vertices replaced sparsely.
    fn manifold(
        &mut self,
        fragment: &FragmentView<'_>,
        written: &[u32],
        position: &[(Semantic, Index<Accessor>)],
        base: usize,
    ) -> Option<extensions::mesh::Mesh> {
        let point = merged(fragment);
        if !closed(written, &point) {
            return None;
        }
        self.closed += 1;
        let moved: Vec<(u32, u32)> = (0_u32..)
            .zip(written)
            .map(|(place, &vertex)| (place, vertex, point[vertex as usize]))
            .filter(|&(_, vertex, merged)| vertex != merged)
            .map(|(place, _, merged)| (place, merged))
            .collect();
        let mut indices = self.indices(base, written.len());
        let mut extension = Map::new();
        if !moved.is_empty() {
            let offsets = self.merges(&moved);
            indices.sparse = Some(sparse(self.views.merges, moved.len(), offsets));
            for (key, offset) in ["mergeIndices", "mergeValues"].into_iter().zip(offsets) {
                let list = accessor(self.views.merges, offset, moved.len(), ComponentType::U32, Type::Scalar);
                extension.insert(key.to_owned(), json!(self.root.push(list).value()));
            }
        }
        let indices = self.root.push(indices);
        let attributes = json!({ "POSITION": position[0].1.value() });
        let manifold = json!({ "attributes": attributes, "indices": indices.value(), "mode": 4 });
        extension.insert("manifoldPrimitive".to_owned(), manifold);
        let others = Map::from_iter([(MANIFOLD.to_owned(), extension.into())]);
        Some(extensions::mesh::Mesh { others })
    }

    /// Appends the positions and the values of the replaced indices; returns the offset of each list.
    fn merges(&mut self, moved: &[(u32, u32)]) -> [usize; 2] {
        let bytes = &mut self.sections.merges;
        let places = bytes.len();
        bytes.extend(moved.iter().flat_map(|(place, _)| place.to_le_bytes()));
        let values = bytes.len();
        bytes.extend(moved.iter().flat_map(|(_, value)| value.to_le_bytes()));
        [places, values]
    }

    fn finish<'a>(mut self, has_parent: bool, source: Option<&'a SourceMaterials>) -> Document<'a> {
        let sections = self.sections;
        let vertices = |stride: usize| (Some(Target::ArrayBuffer), Some(Stride(stride)));
        let mut binary = Vec::new();
        let buffer = Index::new(0);
        for (bytes, (target, stride)) in [
            (sections.positions, vertices(VECTOR_BYTES)),
            (sections.normals, vertices(VECTOR_BYTES)),
            (sections.indices, (Some(Target::ElementArrayBuffer), None)),
            (sections.uvs, vertices(UV_BYTES)),
            (sections.uvs2, vertices(UV_BYTES)),
            (sections.colors, vertices(COLOR_BYTES)),
            (sections.merges, (None, None)),
        ] {
            if !bytes.is_empty() {
                self.root.push(view(buffer, binary.len(), bytes.len(), target, stride));
                binary.extend_from_slice(&bytes);
            }
        }
        let source = source.map(|source| embedded(&mut self.root, &mut binary, source));
        self.root.push(Buffer {
            byte_length: USize64::from(binary.len()),
            name: None,
            uri: None,
            extensions: None,
            extras: None,
        });
        let generator = format!("{} {}", env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION"));
        self.root.asset = Asset { generator: Some(generator), ..Asset::default() };
        if self.closed > 0 {
            self.root.extensions_used.push(MANIFOLD.to_owned());
        }
        Document { root: self.root, binary, closed: self.closed, has_parent, source }
    }
}

/// Appends the images of the mesh file to the buffer. Returns the lists of the document that come from that file; the materials of `root`
/// move there.
fn embedded<'a>(root: &mut Root, binary: &mut Vec<u8>, source: &'a SourceMaterials) -> SourceLists<'a> {
    let images = source.images.iter().map(|image| {
        binary.resize(binary.len().next_multiple_of(IMAGE_ALIGNMENT), 0);
        let bytes = root.push(view(Index::new(0), binary.len(), image.bytes.len(), None, None));
        binary.extend_from_slice(&image.bytes);
        let mut members = image.members.clone();
        members.insert("bufferView".to_owned(), json!(bytes.value()));
        Value::Object(members)
    });
    let images = images.collect();
    root.extensions_used.clone_from(&source.extensions_used);
    root.extensions_required.clone_from(&source.extensions_required);
    let own = std::mem::take(&mut root.materials).into_iter().map(|own| Slot::Own(Box::new(own)));
    let materials = source.materials.iter().map(Slot::Source).chain(own).collect();
    SourceLists { materials, textures: &source.textures, samplers: &source.samplers, images }
}

fn view(
    buffer: Index<Buffer>,
    offset: usize,
    length: usize,
    target: Option<Target>,
    byte_stride: Option<Stride>,
) -> buffer::View {
    View {
        buffer,
        byte_length: USize64::from(length),
        byte_offset: Some(USize64::from(offset)),
        byte_stride,
        name: None,
        target: target.map(Valid),
        extensions: None,
        extras: None,
    }
}

fn accessor(view: Index<View>, offset: usize, count: usize, component: ComponentType, shape: Type) -> Accessor {
    Accessor {
        buffer_view: Some(view),
        byte_offset: Some(USize64::from(offset)),
        count: USize64::from(count),
        component_type: Valid(GenericComponentType(component)),
        extensions: None,
        extras: None,
        type_: Valid(shape),
        min: None,
        max: None,
        name: None,
        normalized: false,
        sparse: None,
    }
}

fn vectors(view: Index<View>, offset: usize, count: usize) -> Accessor {
    accessor(view, offset, count, ComponentType::F32, Type::Vec3)
}

fn sparse(view: Index<View>, count: usize, [places, values]: [usize; 2]) -> accessor::sparse::Sparse {
    accessor::sparse::Sparse {
        count: USize64::from(count),
        indices: accessor::sparse::Indices {
            buffer_view: view,
            byte_offset: USize64::from(places),
            component_type: Valid(IndexComponentType(ComponentType::U32)),
            extensions: None,
            extras: None,
        },
        values: accessor::sparse::Values {
            buffer_view: view,
            byte_offset: USize64::from(values),
            extensions: None,
            extras: None,
        },
        extensions: None,
        extras: None,
    }
}

fn primitive(
    vertices: &[(Semantic, Index<Accessor>)],
    indices: Index<Accessor>,
    material: Option<Index<Material>>,
) -> Primitive {
    Primitive {
        attributes: vertices.iter().map(|(semantic, index)| (Valid(semantic.clone()), *index)).collect(),
        extensions: None,
        extras: None,
        indices: Some(indices),
        material,
        mode: Valid(Mode::Triangles),
        targets: None,
    }
}

fn material(name: &str, color: [f32; 4], roughness: f32) -> Material {
    Material {
        name: Some(name.to_owned()),
        pbr_metallic_roughness: PbrMetallicRoughness {
            base_color_factor: PbrBaseColorFactor(color),
            metallic_factor: StrengthFactor(0.0),
            roughness_factor: StrengthFactor(roughness),
            ..PbrMetallicRoughness::default()
        },
        emissive_factor: EmissiveFactor([0.0; 3]),
        ..Material::default()
    }
}

fn node(
    fragment: &FragmentView<'_>,
    placement: &Placement,
    name: String,
    mesh: Index<Mesh>,
) -> Result<Node, ExportError> {
    let extras = json!({
        "fragment": fragment.id,
        "body": fragment.body,
        "volume_m3": fragment.volume_m3,
        "mass_kg": fragment.mass_kg,
        "center_m": fragment.center_m,
        "inertia_kg_m2": fragment.inertia_kg_m2,
    });
    Ok(Node {
        mesh: Some(mesh),
        name: Some(name),
        translation: Some(placement.translation(fragment.center_m)),
        extras: Some(to_raw_value(&extras)?),
        ..Node::default()
    })
}

/// Smallest and largest coordinate per axis.
fn bounds(positions: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    let start = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    positions.iter().fold(start, |(low, high), point| {
        ([0, 1, 2].map(|k| low[k].min(point[k])), [0, 1, 2].map(|k| high[k].max(point[k])))
    })
}
