//! The film as an animated `.glb`: one node per actor, visible while its scale is one.
//!
//! Meshes have no normals, so that outer and crack faces share their points; closed meshes are marked (`EXT_mesh_manifold`).

use super::Failure;
use super::film::{Actor, Film, Look, Shell};
use gltf_json::accessor::{Accessor, ComponentType, GenericComponentType, Type};
use gltf_json::animation::{Animation, Channel, Interpolation, Property, Sampler, Target};
use gltf_json::buffer::{self, Buffer, View};
use gltf_json::material::{PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use gltf_json::mesh::{Mesh, Mode, Primitive, Semantic};
use gltf_json::scene::UnitQuaternion;
use gltf_json::validation::{Checked::Valid, USize64};
use gltf_json::{Index, Material, Node, Root, Scene};
use serde_json::{Map, json};
use shatter_export::FragmentView;
use std::borrow::Cow;
use std::collections::HashMap;

/// Extension that marks a closed mesh.
const MANIFOLD: &str = "EXT_mesh_manifold";

/// Linear base colors and roughness: outer faces, crack faces, steel, boards.
const MATERIALS: [(&str, [f32; 4], f32); 4] = [
    ("outer", [0.62, 0.58, 0.52, 1.0], 0.6),
    ("crack", [0.78, 0.64, 0.47, 1.0], 0.95),
    ("steel", [0.20, 0.21, 0.23, 1.0], 0.3),
    ("ground", [0.42, 0.36, 0.30, 1.0], 0.9),
];

/// Bytes of the file.
pub fn bytes(film: &Film) -> Result<Vec<u8>, Failure> {
    let mut writer = Writer::default();
    let materials = MATERIALS.map(|(name, color, roughness)| writer.root.push(material(name, color, roughness)));
    let (mut channels, mut samplers, mut nodes) = (Vec::new(), Vec::new(), Vec::new());
    for actor in &film.actors {
        let node = writer.node(actor, &materials);
        nodes.push(node);
        for (property, interpolation, times, values, shape) in tracks(actor) {
            let input = writer.numbers(&times, Type::Scalar, None, true);
            let output = writer.numbers(&values, shape, None, false);
            let sampler = Index::new(samplers.len() as u32);
            let interpolation = Valid(interpolation);
            samplers.push(Sampler { input, interpolation, output, extensions: None, extras: None });
            let target = Target { node, path: Valid(property), extensions: None, extras: None };
            channels.push(Channel { sampler, target, extensions: None, extras: None });
        }
    }
    if !channels.is_empty() {
        let name = Some("film".to_owned());
        writer.root.animations.push(Animation { channels, samplers, name, extensions: None, extras: None });
    }
    let scene = writer.root.push(Scene { nodes, name: None, extensions: None, extras: None });
    writer.root.scene = Some(scene);
    writer.finish()
}

type Track = (Property, Interpolation, Vec<f32>, Vec<f32>, Type);

/// Animation tracks of an actor; empty if it is always visible and has one key.
fn tracks(actor: &Actor) -> Vec<Track> {
    let mut tracks = Vec::new();
    let times: Vec<f32> = actor.keys.iter().map(|key| key.at_s as f32).collect();
    if actor.keys.len() > 1 {
        let places = actor.keys.iter().flat_map(|key| key.place_m).collect();
        let turns = actor.keys.iter().flat_map(|key| key.turn).collect();
        tracks.push((Property::Translation, Interpolation::Linear, times.clone(), places, Type::Vec3));
        tracks.push((Property::Rotation, Interpolation::Linear, times, turns, Type::Vec4));
    }
    let born = (actor.born_s > 0.0).then_some([(0.0, 0.0), (actor.born_s as f32, 1.0)]);
    let gone = actor.gone_s.map(|gone_s| (gone_s as f32, 0.0));
    let first = if born.is_none() && gone.is_some() { Some((0.0, 1.0)) } else { None };
    let steps: Vec<(f32, f32)> = born.into_iter().flatten().chain(first).chain(gone).collect();
    if !steps.is_empty() {
        let times = steps.iter().map(|(at_s, _)| *at_s).collect();
        let scales = steps.iter().flat_map(|(_, scale)| [*scale; 3]).collect();
        tracks.push((Property::Scale, Interpolation::Step, times, scales, Type::Vec3));
    }
    tracks
}

#[derive(Default)]
struct Writer {
    root: Root,
    binary: Vec<u8>,
    closed: usize,
}

/// Points of a shell without duplicates, and the corners of its triangles, outer ones first.
fn welded(shell: &Shell) -> (Vec<[f32; 3]>, Vec<u32>) {
    let (mut points, mut places) = (Vec::new(), HashMap::new());
    let corners = shell.outer.iter().chain(&shell.cracks).flatten();
    let indices = corners.map(|&corner| {
        let point = shell.positions[corner as usize];
        *places.entry(point.map(f32::to_bits)).or_insert_with(|| {
            points.push(point);
            points.len() as u32 - 1
        })
    });
    let indices = indices.collect();
    (points, indices)
}

/// Whether these triangles form a closed surface.
fn is_closed(positions: &[[f32; 3]], indices: &[u32]) -> bool {
    shatter_export::is_closed(&FragmentView {
        id: 0,
        body: 0,
        positions,
        normals: &[],
        uvs: &[],
        uvs2: &[],
        colors: &[],
        materials: &[],
        indices,
        runs: &[],
        merges: &[],
        center_m: [0.0; 3],
        volume_m3: 0.0,
        mass_kg: 0.0,
        inertia_kg_m2: [0.0; 6],
    })
}

impl Writer {
    fn node(&mut self, actor: &Actor, materials: &[Index<Material>; 4]) -> Index<Node> {
        let [outer, crack, steel, ground] = *materials;
        let outer = match actor.look {
            Look::Piece(_) => outer,
            Look::Steel => steel,
            Look::Ground => ground,
        };
        let (points, triangles) = welded(&actor.shell);
        let positions = self.numbers(points.as_flattened(), Type::Vec3, Some(buffer::Target::ArrayBuffer), true);
        let bytes: Vec<u8> = triangles.iter().flat_map(|index| index.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(buffer::Target::ElementArrayBuffer));
        let edge = 3 * actor.shell.outer.len();
        let mut primitives = Vec::new();
        for (first, count, material) in [(0, edge, outer), (edge, triangles.len() - edge, crack)] {
            if count == 0 {
                continue;
            }
            let indices = self.indices(view, first, count);
            primitives.push(Primitive {
                attributes: [(Valid(Semantic::Positions), positions)].into(),
                indices: Some(indices),
                material: Some(material),
                mode: Valid(Mode::Triangles),
                targets: None,
                extensions: None,
                extras: None,
            });
        }
        let name = Some(actor.name.clone());
        let extensions = is_closed(&points, &triangles).then(|| {
            let indices = self.indices(view, 0, triangles.len()).value();
            let primitive = json!({ "attributes": { "POSITION": positions.value() }, "indices": indices, "mode": 4 });
            let extension = json!({ "manifoldPrimitive": primitive });
            self.closed += 1;
            gltf_json::extensions::mesh::Mesh { others: Map::from_iter([(MANIFOLD.to_owned(), extension)]) }
        });
        let mesh = Mesh { primitives, name: name.clone(), weights: None, extensions, extras: None };
        let mesh = Some(self.root.push(mesh));
        let key = &actor.keys[0];
        let (translation, rotation) = (Some(key.place_m), Some(UnitQuaternion(key.turn)));
        self.root.push(Node { mesh, name, translation, rotation, ..Node::default() })
    }

    fn numbers(
        &mut self,
        values: &[f32],
        shape: Type,
        target: Option<buffer::Target>,
        bounds: bool,
    ) -> Index<Accessor> {
        let width = if shape == Type::Scalar {
            1
        } else if shape == Type::Vec3 {
            3
        } else {
            4
        };
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let view = self.view(&bytes, target);
        let bound = |pick: fn(f32, f32) -> f32, start: f32| {
            let one = |axis: usize| values.iter().skip(axis).step_by(width).fold(start, |a, b| pick(a, *b));
            json!((0..width).map(one).collect::<Vec<f32>>())
        };
        let mut accessor = accessor(view, values.len() / width, ComponentType::F32, shape);
        if bounds {
            accessor.min = Some(bound(f32::min, f32::INFINITY));
            accessor.max = Some(bound(f32::max, f32::NEG_INFINITY));
        }
        self.root.push(accessor)
    }

    fn indices(&mut self, view: Index<View>, first: usize, count: usize) -> Index<Accessor> {
        let mut accessor = accessor(view, count, ComponentType::U32, Type::Scalar);
        accessor.byte_offset = Some(USize64::from(size_of::<u32>() * first));
        self.root.push(accessor)
    }

    fn view(&mut self, bytes: &[u8], target: Option<buffer::Target>) -> Index<View> {
        let view = View {
            buffer: Index::new(0),
            byte_length: USize64::from(bytes.len()),
            byte_offset: Some(USize64::from(self.binary.len())),
            byte_stride: None,
            name: None,
            target: target.map(Valid),
            extensions: None,
            extras: None,
        };
        self.binary.extend_from_slice(bytes);
        self.root.push(view)
    }

    fn finish(mut self) -> Result<Vec<u8>, Failure> {
        if self.closed > 0 {
            self.root.extensions_used.push(MANIFOLD.to_owned());
        }
        let byte_length = USize64::from(self.binary.len());
        self.root.push(Buffer { byte_length, name: None, uri: None, extensions: None, extras: None });
        let (json, bin) = (Cow::Owned(self.root.to_vec()?), Some(Cow::Owned(self.binary)));
        let header = gltf::binary::Header { magic: *b"glTF", version: 2, length: 0 };
        Ok(gltf::binary::Glb { header, json, bin }.to_vec()?)
    }
}

fn accessor(view: Index<View>, count: usize, component: ComponentType, shape: Type) -> Accessor {
    Accessor {
        buffer_view: Some(view),
        byte_offset: None,
        count: USize64::from(count),
        component_type: Valid(GenericComponentType(component)),
        type_: Valid(shape),
        min: None,
        max: None,
        name: None,
        normalized: false,
        sparse: None,
        extensions: None,
        extras: None,
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
        ..Material::default()
    }
}
