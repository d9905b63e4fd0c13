//! Databases with altered values, tensor by tensor and key by key, and matching checksums.
//!
//! Each must be rejected with the name of the value, or yield closed, finite fragments whose masses add up.

use super::container::metadata_checksum;
use super::*;
use crate::cancel_token::CancelToken;
use crate::fragment::closed;
use crate::pipeline::{
    DegreeRequest, ElementChoice, FractureError, FractureMeshes, FractureOutcome, FractureRequest, PreparedObject,
    RequestContext, SurfaceKind, Workspace, strike,
};
use crate::random::RandomStream;
use crate::scene::{EffectKind, EffectSet, Material};
use crate::surface::{RawMesh, shapes};
use nalgebra::{Point3, Vector3};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// A file in parts: tensors by name, and metadata without checksums.
#[derive(Clone)]
pub(super) struct File {
    tensors: BTreeMap<String, (String, Vec<usize>, Vec<u8>)>,
    metadata: BTreeMap<String, String>,
}

impl File {
    fn read(path: &Path) -> Self {
        let bytes = std::fs::read(path).unwrap();
        let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
        let header: Map<String, Value> = serde_json::from_slice(&bytes[8..8 + length]).unwrap();
        let mut file = Self { tensors: BTreeMap::new(), metadata: BTreeMap::new() };
        for (name, value) in header {
            let list = |key: &str| -> Vec<usize> {
                value[key].as_array().unwrap().iter().map(|own| own.as_u64().unwrap() as usize).collect()
            };
            if name == "__metadata__" {
                let own = value.as_object().unwrap().iter().filter(|(key, _)| *key != "checksums");
                file.metadata = own.map(|(key, text)| (key.clone(), text.as_str().unwrap().to_owned())).collect();
            } else {
                let ends = list("data_offsets");
                let data = bytes[8 + length + ends[0]..8 + length + ends[1]].to_vec();
                file.tensors.insert(name, (value["dtype"].as_str().unwrap().to_owned(), list("shape"), data));
            }
        }
        file
    }

    /// Contents of a tensor.
    pub fn bytes(&self, tensor: &str) -> &[u8] {
        &self.tensors[tensor].2
    }

    /// Writes the file with matching checksums.
    fn write(&self, path: &Path) {
        let mut sums: Map<String, Value> = Map::new();
        let (mut header, mut data) = (Map::new(), Vec::new());
        for (name, (dtype, shape, bytes)) in &self.tensors {
            sums.insert(name.clone(), blake3::hash(bytes).to_hex().to_string().into());
            let ends = [data.len(), data.len() + bytes.len()];
            header.insert(name.clone(), serde_json::json!({"dtype": dtype, "shape": shape, "data_offsets": ends}));
            data.extend_from_slice(bytes);
        }
        sums.insert("__metadata__".into(), metadata_checksum(self.metadata.iter()).into());
        let mut metadata: Map<String, Value> =
            self.metadata.iter().map(|(key, text)| (key.clone(), text.clone().into())).collect();
        metadata.insert("checksums".into(), Value::Object(sums).to_string().into());
        header.insert("__metadata__".into(), metadata.into());
        let mut text = Value::Object(header).to_string().into_bytes();
        text.resize(text.len().next_multiple_of(8), b' ');
        let length = (text.len() as u64).to_le_bytes().to_vec();
        std::fs::write(path, [length, text, data].concat()).unwrap();
    }
}

/// A box with both sets of texture coordinates, colors and two materials.
fn mesh() -> RawMesh {
    let mut mesh = shapes::cuboid([0.5, 0.3, 0.2]);
    let corners = |triangle: &[u32; 3]| triangle.map(|vertex| mesh.positions_m[vertex as usize]);
    mesh.attributes.uvs =
        mesh.triangles.iter().map(|own| corners(own).map(|point| [point.x as f32, point.y as f32])).collect();
    mesh.attributes.uvs2 = mesh.attributes.uvs.iter().map(|own| own.map(|[u, v]| [v, 2.0 * u])).collect();
    mesh.attributes.colors =
        mesh.attributes.uvs.iter().map(|own| own.map(|[u, v]| [u + 0.5, v + 0.5, 0.5, 1.0])).collect();
    mesh.attributes.materials = (0..mesh.triangles.len() as u32).map(|triangle| triangle % 2).collect();
    mesh.attributes.names = vec!["front".into(), "back".into()];
    mesh
}

pub(super) struct Trial {
    pub file: File,
    folder: tempfile::TempDir,
    refused: usize,
    served: usize,
    /// Impulse that breaks the unaltered object, N·s.
    impulse_ns: Vector3<f64>,
    /// Altered files that were accepted wrongly, or rejected without the name.
    wrong: Vec<String>,
}

impl Trial {
    /// A trial on an object with these elements.
    pub fn of(elements: ElementChoice) -> Self {
        let material = Material { source: String::new(), ..Material::named("glass").unwrap() };
        let request = BakeRequest {
            elastic_spacing: Some(0.2),
            crack_spacing: Some(0.15),
            kappa: Some(2.0),
            examples: 10,
            elements,
            surface: SurfaceKind::Exact,
            ..BakeRequest::new("altered", "glass", material)
        };
        let prepared = bake(mesh(), &request, &CancelToken::default(), &mut |_| ()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("altered.shatter");
        save(&prepared, &path).unwrap();
        let impulse_ns = breaking(&prepared);
        Self { file: File::read(&path), folder, refused: 0, served: 0, impulse_ns, wrong: Vec::new() }
    }

    /// Expects a rejection with `name` in the message, or valid fragments.
    fn check(&mut self, file: &File, name: &str, what: &str) {
        let path = self.folder.path().join("altered.shatter");
        file.write(&path);
        match load(&path) {
            Ok(prepared) => {
                self.served += 1;
                if catch_unwind(AssertUnwindSafe(|| struck(&prepared, self.impulse_ns, what))).is_err() {
                    self.wrong.push(format!("{what}: served"));
                    println!("{what}: served");
                }
            }
            Err(error) => {
                self.refused += 1;
                let text = error.to_string();
                // A moved node is detected by the volume, an indefinite matrix by its factorization, a spacing by the skin's edges.
                let others = [
                    "lattice_volume_m3",
                    "input_volume_m3",
                    "elasticity of body",
                    "tensor \"body",
                    "anchored nodes",
                    "crack spacings",
                ];
                let named = others.into_iter().chain([name]).any(|own| text.contains(own));
                if !named {
                    self.wrong.push(format!("{what}: {text}"));
                }
            }
        }
    }
}

/// A node of the surface, in the middle of the list, which changes of other values do not move, m.
fn middle(prepared: &PreparedObject) -> Point3<f64> {
    let body = &prepared.bodies[0];
    let nodes = &body.topology.boundary_nodes;
    prepared.frame.to_meters(&body.crack.nodes[nodes[nodes.len() / 2] as usize])
}

/// The outcome of `impulse_ns` at [`middle`], with the degree of the closed form.
fn decided(prepared: &PreparedObject, impulse_ns: Vector3<f64>) -> Result<FractureOutcome, FractureError> {
    let own =
        FractureRequest { degree: DegreeRequest::ClosedForm, ..FractureRequest::at(middle(prepared), impulse_ns) };
    strike(RequestContext::new(prepared, &own, &CancelToken::default(), &()), &mut Workspace::default())
}

/// Ten times the smallest tested impulse that breaks the object.
fn breaking(prepared: &PreparedObject) -> Vector3<f64> {
    let unit = Vector3::new(0.3, -1.0, 0.2);
    let sizes = (-10..30).map(|power| 2f64.powi(power));
    let just = sizes.map(|size| size * unit).find(|own| decided(prepared, *own).unwrap().meshes().is_some());
    10.0 * just.unwrap()
}

fn struck(prepared: &PreparedObject, impulse_ns: Vector3<f64>, what: &str) {
    let outcome = decided(prepared, impulse_ns).unwrap_or_else(|error| panic!("{what}: {error}"));
    assert!(outcome.meshes().is_some(), "{what}: stays whole, E_1/γ {}", outcome.threshold().e1_over_gamma);
    let usual = EffectSet::default().without(EffectKind::Slivers);
    let effects = usual.with(EffectKind::Skin).with(EffectKind::Attributes);
    let cut = prepared.bodies.iter().map(|body| body.cutting.as_ref().map_or(&body.crack, |cutting| &cutting.mesh));
    let volume: f64 = cut.map(|mesh| mesh.volume()).sum();
    let whole_kg = volume * prepared.frame.diagonal_m.powi(3) * prepared.parameters.material.density_kg_m3;
    assert!(whole_kg.is_finite() && whole_kg > 0.0, "{what}: {whole_kg} kg");
    let count = prepared.bodies[0].crack.nodes.len();
    let (sites, dynamic) = (DegreeRequest::Sites(6), effects.with(EffectKind::Dynamics));
    let requests = [(sites, 0, effects), (DegreeRequest::Inferred, count / 2, effects), (sites, count / 3, dynamic)];
    for (degree, node, effects) in requests {
        let point = prepared.frame.to_meters(&prepared.bodies[0].crack.nodes[node]);
        let own = FractureRequest { degree, effects, ..FractureRequest::at(point, Vector3::new(0.3, -1.0, 0.2)) };
        let Ok(outcome) =
            strike(RequestContext::new(prepared, &own, &CancelToken::default(), &()), &mut Workspace::default())
        else {
            continue;
        };
        assert!((0.0..=1.0).contains(&outcome.confidence()), "{what}: {}", outcome.confidence());
        assert!(outcome.threshold().e1_over_gamma >= 0.0, "{what}: {}", outcome.threshold().e1_over_gamma);
        if let Some(pieces) = &outcome.meshes() {
            check_pieces(pieces, whole_kg, what);
        }
    }
}

fn check_pieces(pieces: &FractureMeshes, whole_kg: f64, what: &str) {
    let (mut positions, mut indices) = (vec![[0.0; 3]; pieces.counts.vertices], vec![0; pieces.counts.indices]);
    pieces.emit(&mut positions, &mut indices, &mut vec![[0; 2]; pieces.counts.merges]).unwrap();
    let mut mass_kg = 0.0;
    for row in &pieces.fragments {
        let vertices = &positions[row.vertex_first as usize..][..row.vertex_count as usize];
        let triangles = &indices[row.index_first as usize..][..row.index_count as usize];
        closed(vertices, triangles).unwrap_or_else(|open| panic!("{what}: fragment {}: {open}", row.id));
        assert!(vertices.as_flattened().iter().all(|x| x.is_finite()), "{what}");
        assert!(row.mass_kg.is_finite() && row.mass_kg > 0.0, "{what}: {} kg", row.mass_kg);
        mass_kg += row.mass_kg;
    }
    assert!((mass_kg / whole_kg - 1.0).abs() < 1e-6, "{what}: {mass_kg} of {whole_kg} kg");
    for vertex in &pieces.skins.vertices {
        let all = vertex.position_m.iter().chain(&vertex.normal).chain(&vertex.uv);
        assert!(all.clone().all(|x| x.is_finite()), "{what}: skin {vertex:?}");
        let length = vertex.normal.iter().map(|x| x * x).sum::<f32>().sqrt();
        assert!((0.9..1.1).contains(&length), "{what}: a normal of length {length}");
    }
}

fn width(dtype: &str) -> usize {
    match dtype {
        "F64" => 8,
        "U8" => 1,
        _ => 4,
    }
}

/// Altered values of an entry.
fn others(dtype: &str, own: &[u8]) -> Vec<(&'static str, Vec<u8>)> {
    let made = |name, value: f64| {
        (name, if dtype == "F64" { value.to_le_bytes().to_vec() } else { (value as f32).to_le_bytes().to_vec() })
    };
    match dtype {
        // Any color is valid.
        "U8" => vec![("zero", vec![0]), ("one more", vec![own[0].wrapping_add(1)]), ("full", vec![u8::MAX])],
        "U32" => {
            let value = u32::from_le_bytes(own.try_into().unwrap());
            [("zero", 0), ("one more", value.wrapping_add(1)), ("one less", value.wrapping_sub(1)), ("huge", u32::MAX)]
                .map(|(name, value): (_, u32)| (name, value.to_le_bytes().to_vec()))
                .into()
        }
        _ => {
            let value = match dtype {
                "F64" => f64::from_le_bytes(own.try_into().unwrap()),
                _ => f64::from(f32::from_le_bytes(own.try_into().unwrap())),
            };
            let huge = if dtype == "F64" { 1e300 } else { f64::from(f32::MAX) };
            vec![
                made("zero", 0.0),
                made("negated", -value),
                made("not a number", f64::NAN),
                made("huge", huge),
                made("doubled", 2.0 * value),
                made("tiny", 1e-300),
                made("large", 1e30),
                made("one more", value + 1.0),
                made("one less", value - 1.0),
            ]
        }
    }
}

/// Tensors with at most this many entries are altered at each of them.
const FEW: usize = 6;

#[test]
fn altered_tensors_are_rejected_by_name_or_harmless() {
    let mut trial = Trial::of(ElementChoice::default());
    let whole = trial.file.clone();
    trial.check(&whole, "", "untouched");
    assert_eq!(trial.served, 1);
    for part in [
        "skin.uvs",
        "skin.uvs2",
        "skin.colors",
        "skin.materials",
        "body0.cutting.outer.uvs",
        "body0.outer.uvs",
        "body0.outer.uvs2",
        "body0.outer.colors",
        "body0.cutting.outer.uvs2",
        "body0.cutting.outer.colors",
        "reduced0.gram",
        "reduced0.mass",
        "body0.transfer.shares",
        "network.mean",
    ] {
        assert!(whole.tensors.contains_key(part), "{part} is tried");
    }
    let mut stream = RandomStream::new(6, 0);
    for (name, (dtype, shape, bytes)) in &whole.tensors {
        let width = width(dtype);
        let count = bytes.len() / width;
        let at = stream.bits() as usize % count;
        // In short tensors, every entry has its own meaning.
        let places = if count <= FEW { (0..count).collect() } else { vec![at] };
        for at in places {
            for (kind, value) in others(dtype, &bytes[at * width..][..width]) {
                let mut file = whole.clone();
                file.tensors.get_mut(name).unwrap().2[at * width..][..width].copy_from_slice(&value);
                trial.check(&file, name.split('.').next().unwrap(), &format!("{name}[{at}] {kind}"));
            }
        }
        let (mut swapped, other) = (whole.clone(), stream.bits() as usize % count);
        let own = &mut swapped.tensors.get_mut(name).unwrap().2;
        (0..width).for_each(|byte| own.swap(at * width + byte, other * width + byte));
        trial.check(&swapped, name.split('.').next().unwrap(), &format!("{name}: {at} and {other} exchanged"));
        let mut shorter = whole.clone();
        let (_, rows, data) = shorter.tensors.get_mut(name).unwrap();
        data.truncate(bytes.len() - bytes.len() / shape[0]);
        rows[0] -= 1;
        trial.check(&shorter, "", &format!("{name} without its last row"));
        let mut absent = whole.clone();
        absent.tensors.remove(name);
        trial.check(&absent, "", &format!("no {name}"));
    }
    println!("{} refused, {} served", trial.refused, trial.served);
    assert!(trial.wrong.is_empty(), "{:#?}", trial.wrong);
    assert!(trial.refused + trial.served > 250);
}

/// Loads the database `file` after `alter` changed the bytes of `tensor`; the error is the message.
pub(super) fn load_altered(file: &File, tensor: &str, alter: impl FnOnce(&mut Vec<u8>)) -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("block.shatter");
    let mut file = file.clone();
    alter(&mut file.tensors.get_mut(tensor).unwrap().2);
    file.write(&path);
    load(&path).map(drop).map_err(|error| error.to_string())
}

/// Replaces the 64-bit floats from `first` to `last`.
fn replace(bytes: &mut [u8], entries: std::ops::Range<usize>, by: impl Fn(f64) -> f64) {
    for own in &mut bytes.as_chunks_mut::<8>().0[entries] {
        *own = by(f64::from_le_bytes(*own)).to_le_bytes();
    }
}

/// Every tetrahedron stays positive, and the boundary a manifold.
#[test]
fn altered_elastic_lattices_are_refused() {
    // Two lattices; then one for both.
    for spacings in [[0.12, 0.09], [0.1, 0.1]] {
        let [elastic_spacing, crack_spacing] = spacings.map(Some);
        let glass = Material::named("glass").unwrap();
        let request = BakeRequest { elastic_spacing, crack_spacing, ..BakeRequest::new("block", "glass", glass) };
        let block = request.bake(shapes::cuboid([0.3, 0.3, 0.3])).unwrap();
        let folder = tempfile::tempdir().unwrap();
        save(&block, &folder.path().join("block.shatter")).unwrap();
        let file = File::read(&folder.path().join("block.shatter"));
        let [nodes, tets] = ["body0.elastic.nodes", "body0.elastic.tets"];
        assert_eq!(load_altered(&file, nodes, |_| ()), Ok(()));
        let check = |what: &str, loaded: Result<(), String>| {
            assert!(
                loaded.as_ref().is_err_and(|error| error.contains("body0.elastic")),
                "{spacings:?} {what}: {loaded:?}"
            );
        };
        let lattice = &block.bodies[0].solid.as_ref().unwrap().lattice;
        let distance = |node: &usize| lattice.nodes[*node].coords.norm();
        let inner = (0..lattice.nodes.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
        let outer = (0..lattice.nodes.len()).max_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
        check("inner node", load_altered(&file, nodes, |own| replace(own, 3 * inner..3 * inner + 1, |x| x + 1e-3)));
        check("outer node", load_altered(&file, nodes, |own| replace(own, 3 * outer..3 * outer + 3, |x| 1.6 * x)));
        check("all nodes", load_altered(&file, nodes, |own| replace(own, 0..3 * lattice.nodes.len(), |x| 1.3 * x)));
        check("other order", load_altered(&file, tets, |own| own.rotate_left(16 * (lattice.tets.len() / 2))));
    }
}

#[test]
fn second_textures_and_colors_of_a_wrong_length_or_value_are_refused() {
    let trial = Trial::of(ElementChoice::default());
    let path = trial.folder.path().join("altered.shatter");
    let refused = |file: &File, name: &str| {
        file.write(&path);
        let error = load(&path).err().unwrap_or_else(|| panic!("{name} was read")).to_string();
        assert!(error.contains(name), "{name}: {error}");
    };
    for name in ["skin", "body0.outer", "body0.cutting.outer"] {
        for (part, columns) in [("uvs2", 2), ("colors", 4)] {
            let tensor = format!("{name}.{part}");
            let (dtype, shape, bytes) = trial.file.tensors[&tensor].clone();
            assert_eq!((shape.len(), shape[1], bytes.len() % shape[0]), (2, columns, 0), "{tensor}");
            let mut file = trial.file.clone();
            let short = bytes[..bytes.len() - bytes.len() / shape[0]].to_vec();
            file.tensors.insert(tensor.clone(), (dtype.clone(), vec![shape[0] - 1, columns], short));
            refused(&file, &tensor);
            file.tensors.insert(tensor.clone(), (dtype, vec![shape[0] * columns, 1], bytes));
            refused(&file, &tensor);
        }
        for value in [f32::NAN, f32::INFINITY, 1e30] {
            let tensor = format!("{name}.uvs2");
            let mut file = trial.file.clone();
            file.tensors.get_mut(&tensor).unwrap().2[4..8].copy_from_slice(&value.to_le_bytes());
            refused(&file, &tensor);
        }
    }
}

#[test]
fn the_expected_shape_of_a_list_has_one_axis() {
    let trial = Trial::of(ElementChoice::default());
    let path = trial.folder.path().join("altered.shatter");
    let mut file = trial.file.clone();
    file.tensors.get_mut("skin.vertices").unwrap().1.push(1);
    file.write(&path);
    let error = load(&path).err().unwrap().to_string();
    assert!(error.contains("\"skin.vertices\": U32 [") && error.ends_with(", 1] instead of U32 [any]"), "{error}");
}

/// A function that returns the document with another value in one place.
type Put<'a> = dyn Fn(Value) -> Value + 'a;

/// Calls `each` for every number in `value`, with its path and the function that replaces it.
fn numbers(value: &Value, path: &str, each: &mut dyn FnMut(&str, &Put)) {
    match value {
        Value::Number(_) => each(path, &|other| other),
        Value::Array(list) => {
            for (index, own) in list.iter().enumerate() {
                numbers(own, &format!("{path}[{index}]"), &mut |path, put| {
                    each(path, &|other| {
                        let mut list = list.clone();
                        list[index] = put(other);
                        Value::Array(list)
                    });
                });
            }
        }
        Value::Object(map) => {
            for (key, own) in map {
                numbers(own, &format!("{path}.{key}"), &mut |path, put| {
                    each(path, &|other| {
                        let mut map = map.clone();
                        map.insert(key.clone(), put(other));
                        Value::Object(map)
                    });
                });
            }
        }
        _ => {}
    }
}

/// Converts a `path` of [`numbers`] below `key` to a JSON pointer.
fn pointer(path: &str, key: &str) -> String {
    path[key.len()..].replace(['.', '['], "/").replace(']', "")
}

#[test]
fn altered_metadata_is_refused_by_name_or_harmless() {
    let mut trial = Trial::of(ElementChoice::default());
    let whole = trial.file.clone();
    for key in ["shape", "parameters", "report", "learned", "reduction"] {
        let document: Value = serde_json::from_str(&whole.metadata[key]).unwrap();
        let mut all = Vec::new();
        numbers(&document, key, &mut |path, put| {
            let own = document.pointer(&pointer(path, key)).and_then(Value::as_f64).unwrap();
            let others = [
                ("negated", (-own).into()),
                ("1e-300", 1e-300.into()),
                ("1e30", 1e30.into()),
                ("one more", (own + 1.0).into()),
                ("one less", (own - 1.0).into()),
                ("0", 0.0.into()),
                ("-1.5", (-1.5).into()),
                ("1e300", 1e300.into()),
                ("-3", (-3).into()),
                ("null", Value::Null),
            ];
            all.extend(others.map(|(name, other): (_, Value)| (format!("{path} = {name}"), put(other).to_string())));
        });
        assert!(all.len() >= 10, "{key}");
        // Thresholds near the usual one are valid, and the object then stays intact.
        for (what, text) in all.into_iter().filter(|(what, _)| what != "shape.gamma_j_m2 = one more") {
            let mut file = whole.clone();
            file.metadata.insert(key.to_owned(), text);
            trial.check(&file, key, &what);
        }
    }
    for key in whole.metadata.keys() {
        let (mut absent, mut empty) = (whole.clone(), whole.clone());
        absent.metadata.remove(key);
        trial.check(&absent, "", &format!("no {key}"));
        empty.metadata.insert(key.clone(), String::new());
        trial.check(&empty, "", &format!("{key} is empty"));
    }
    println!("{} refused, {} served", trial.refused, trial.served);
    assert!(trial.wrong.is_empty(), "{:#?}", trial.wrong);
    assert!(trial.refused > 100);
}
