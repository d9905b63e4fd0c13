//! Fuzz target for database files: raw bytes, and a valid file with changes under matching checksums.

use super::{choice, seed};
use nalgebra::Vector3;
use serde_json::{Map, Value};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, bake, load, load_parameters, load_partial, save};
use shatter_fracture::fragment::closed;
use shatter_fracture::pipeline::{
    DegreeRequest, FractureMeshes, FractureRequest, PreparedObject, RequestContext, Workspace, strike,
};
use shatter_fracture::scene::Material;
use shatter_fracture::surface::shapes;
use std::ops::Range;
use std::sync::LazyLock;

/// Bytes of one change: tensor, element and value.
const CHANGE_BYTES: usize = 12;

/// File of a small object, and the positions of its tensors.
static FILE: LazyLock<(Vec<u8>, Vec<Tensor>)> = LazyLock::new(|| {
    let material = Material { source: String::new(), ..Material::named("glass").expect("it is in the table") };
    let request = BakeRequest {
        elastic_spacing: Some(0.25),
        crack_spacing: Some(0.2),
        kappa: Some(2.0),
        examples: 10,
        ..BakeRequest::new("fuzz", "glass", material)
    };
    let prepared = bake(shapes::cuboid([1.0, 0.6, 0.4]), &request, &CancelToken::default(), &mut |_| ());
    let folder = tempfile::tempdir().expect("a folder for the file");
    let path = folder.path().join("fuzz.shatter");
    save(&prepared.expect("a box can be baked"), &path).expect("a file that can be written");
    let bytes = std::fs::read(&path).expect("the file just written");
    let tensors = tensors(&bytes);
    (bytes, tensors)
});

struct Tensor {
    name: String,
    range: Range<usize>,
    width: usize,
}

/// Header of a file, and the offset of its data.
fn header(bytes: &[u8]) -> (Map<String, Value>, usize) {
    let length = u64::from_le_bytes(*bytes.first_chunk().expect("a length")) as usize;
    (serde_json::from_slice(&bytes[8..8 + length]).expect("a header"), 8 + length)
}

fn tensors(bytes: &[u8]) -> Vec<Tensor> {
    let (header, data) = header(bytes);
    let end = |value: &Value, index: usize| data + value["data_offsets"][index].as_u64().expect("an offset") as usize;
    let named = header.iter().filter(|(name, _)| *name != "__metadata__");
    named
        .map(|(name, value)| {
            let width = if value["dtype"] == "F64" { 8 } else { 4 };
            Tensor { name: name.clone(), range: end(value, 0)..end(value, 1), width }
        })
        .filter(|tensor| tensor.range.len() >= tensor.width)
        .collect()
}

/// The file with the changes, and matching checksums.
fn changed(changes: &[u8]) -> Vec<u8> {
    let (file, tensors) = &*FILE;
    let mut bytes = file.clone();
    let mut touched = Vec::new();
    for change in changes.as_chunks::<CHANGE_BYTES>().0 {
        let tensor = &tensors[usize::from(u16::from_le_bytes([change[0], change[1]])) % tensors.len()];
        let element = usize::from(u16::from_le_bytes([change[2], change[3]])) % (tensor.range.len() / tensor.width);
        let at = tensor.range.start + element * tensor.width;
        bytes[at..at + tensor.width].copy_from_slice(&change[4..4 + tensor.width]);
        touched.push(tensor);
    }
    sealed(bytes, &touched)
}

fn sealed(mut bytes: Vec<u8>, touched: &[&Tensor]) -> Vec<u8> {
    let (mut header, data) = header(&bytes);
    let metadata = header["__metadata__"].as_object_mut().expect("metadata");
    let sums = metadata["checksums"].as_str().expect("checksums");
    let mut sums: Map<String, Value> = serde_json::from_str(sums).expect("checksums by name");
    for tensor in touched {
        let sum = blake3::hash(&bytes[tensor.range.clone()]).to_hex().to_string();
        sums.insert(tensor.name.clone(), sum.into());
    }
    metadata.insert("checksums".into(), Value::Object(sums).to_string().into());
    let mut text = Value::Object(header).to_string().into_bytes();
    text.resize(text.len().next_multiple_of(8), b' ');
    let rest = bytes.split_off(data);
    [(text.len() as u64).to_le_bytes().to_vec(), text, rest].concat()
}

pub(super) fn seeds() -> Vec<Vec<u8>> {
    let (file, tensors) = &*FILE;
    let change = |tensor: usize, value: f64| {
        let number = match tensors[tensor].width {
            4 => [(value as f32).to_le_bytes(), [0; 4]].concat(),
            _ => value.to_le_bytes().to_vec(),
        };
        seed(1, [&(tensor as u16).to_le_bytes()[..], &[0, 0], &number].concat())
    };
    let (_, data) = header(file);
    let mut seeds = vec![seed(0, &file[..data]), seed(1, [])];
    seeds.extend((0..tensors.len()).map(|tensor| change(tensor, 1.0)));
    seeds
}

pub(super) fn run(input: &[u8]) -> bool {
    let Some((kind, rest)) = choice(input, 2) else { return false };
    let bytes = if kind == 0 { rest.to_vec() } else { changed(rest) };
    let folder = tempfile::tempdir().expect("a folder for the file");
    let path = folder.path().join("fuzz.shatter");
    std::fs::write(&path, bytes).expect("a file that can be written");
    let other = [load_partial(&path).is_ok(), load_parameters(&path).is_ok()];
    match load(&path) {
        Ok(prepared) => {
            struck(&prepared);
            true
        }
        Err(error) => {
            assert!(!error.to_string().is_empty());
            other.contains(&true)
        }
    }
}

/// Checks that the object is refused, or struck with closed fragments that have a mass.
fn struck(prepared: &PreparedObject) {
    let node = prepared.bodies[0].crack.nodes[0];
    let at = FractureRequest::at(prepared.frame.to_meters(&node), Vector3::new(0.3, -1.0, 0.2));
    for degree in [DegreeRequest::Sites(4), DegreeRequest::Inferred] {
        let own = FractureRequest { degree, ..at.clone() };
        if let Ok(outcome) =
            strike(RequestContext::new(prepared, &own, &CancelToken::default(), &()), &mut Workspace::default())
        {
            assert!((0.0..=1.0).contains(&outcome.confidence()), "{}", outcome.confidence());
            outcome.meshes().into_iter().for_each(check);
        }
    }
}

fn check(pieces: &FractureMeshes) {
    let (mut positions, mut indices) = (vec![[0.0; 3]; pieces.counts.vertices], vec![0; pieces.counts.indices]);
    let mut merges = vec![[0; 2]; pieces.counts.merges];
    pieces.emit(&mut positions, &mut indices, &mut merges).expect("the counts are its own");
    for row in &pieces.fragments {
        let vertices = &positions[row.vertex_first as usize..][..row.vertex_count as usize];
        let triangles = &indices[row.index_first as usize..][..row.index_count as usize];
        closed(vertices, triangles).unwrap_or_else(|open| panic!("fragment {}: {open}", row.id));
        assert!(row.mass_kg.is_finite() && row.mass_kg > 0.0, "fragment {}: {} kg", row.id, row.mass_kg);
    }
}
