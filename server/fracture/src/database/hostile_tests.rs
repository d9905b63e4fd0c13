//! Damaged files, and manipulated files with hostile values and matching checksums.

use super::*;
use crate::cancel_token::CancelToken;
use crate::fragment::closed;
use crate::pipeline::{
    DegreeRequest, FractureMeshes, FractureRequest, PreparedObject, RequestContext, Workspace, strike,
};
use crate::random::RandomStream;
use crate::scene::Material;
use crate::surface::shapes;
use nalgebra::Vector3;
use serde_json::{Map, Value};

/// The bytes of a small object's file.
fn file() -> Vec<u8> {
    let material = Material { source: String::new(), ..Material::named("glass").unwrap() };
    let request = BakeRequest {
        elastic_spacing: Some(0.2),
        crack_spacing: Some(0.15),
        kappa: Some(2.0),
        examples: 10,
        ..BakeRequest::new("hostile", "glass", material)
    };
    let prepared = bake(shapes::arch(), &request, &CancelToken::default(), &mut |_| ()).unwrap();
    assert!(prepared.learned.is_some());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hostile.shatter");
    save(&prepared, &path).unwrap();
    std::fs::read(&path).unwrap()
}

fn opened(bytes: &[u8]) -> Result<PreparedObject, DatabaseError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hostile.shatter");
    std::fs::write(&path, bytes).unwrap();
    load(&path)
}

/// The header, and the offset of the data.
fn header(bytes: &[u8]) -> (Map<String, Value>, usize) {
    let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
    (serde_json::from_slice(&bytes[8..8 + length]).unwrap(), 8 + length)
}

/// Names of the tensors, with their byte ranges in the file and types.
fn tensors(bytes: &[u8]) -> Vec<(String, std::ops::Range<usize>, String)> {
    let (header, data) = header(bytes);
    let range = |value: &Value| {
        let ends: Vec<usize> =
            value["data_offsets"].as_array().unwrap().iter().map(|end| end.as_u64().unwrap() as usize).collect();
        data + ends[0]..data + ends[1]
    };
    let named = header.iter().filter(|(name, _)| *name != "__metadata__");
    named.map(|(name, value)| (name.clone(), range(value), value["dtype"].as_str().unwrap().to_owned())).collect()
}

/// The file with checksums that match its tensors.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let sums: Vec<(String, String)> = tensors(&bytes)
        .into_iter()
        .map(|(name, range, _)| (name, blake3::hash(&bytes[range]).to_hex().to_string()))
        .collect();
    let (mut header, data) = header(&bytes);
    let metadata = header["__metadata__"].as_object_mut().unwrap();
    let mut checksums: Map<String, Value> = serde_json::from_str(metadata["checksums"].as_str().unwrap()).unwrap();
    sums.into_iter().for_each(|(name, sum)| _ = checksums.insert(name, sum.into()));
    metadata.insert("checksums".into(), Value::Object(checksums).to_string().into());
    let mut text = Value::Object(header).to_string().into_bytes();
    text.resize(text.len().next_multiple_of(8), b' ');
    let rest = bytes.split_off(data);
    [(text.len() as u64).to_le_bytes().to_vec(), text, rest].concat()
}

/// A file of a few kilobytes on the disk that claims a tensor of eight tebibytes.
#[test]
fn a_sparse_file_larger_than_memory_is_refused() {
    const CLAIMED: u64 = 1 << 43;
    let bytes = file();
    let (mut header, data) = header(&bytes);
    let rest = &bytes[data..];
    let ends = [rest.len() as u64, rest.len() as u64 + CLAIMED];
    header.insert("large".to_owned(), serde_json::json!({ "dtype": "U8", "shape": [CLAIMED], "data_offsets": ends }));
    let mut text = Value::Object(header).to_string().into_bytes();
    text.resize(text.len().next_multiple_of(8), b' ');
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hostile.shatter");
    std::fs::write(&path, [&(text.len() as u64).to_le_bytes()[..], &text, rest].concat()).unwrap();
    let length = 8 + text.len() as u64 + ends[1];
    std::fs::File::options().write(true).open(&path).unwrap().set_len(length).unwrap();
    let Err(DatabaseError::Io { source, .. }) = load(&path) else { panic!("loaded, or refused for another reason") };
    assert_eq!(source.kind(), std::io::ErrorKind::OutOfMemory);
}

/// Expects a rejection, or requests with closed, finite fragments or errors.
fn check(bytes: &[u8], what: &str) {
    let Ok(prepared) = opened(bytes) else { return };
    let node = prepared.bodies[0].crack.nodes[0];
    let request = FractureRequest::at(prepared.frame.to_meters(&node), Vector3::new(0.3, -1.0, 0.2)).seeded(1);
    for degree in [DegreeRequest::Sites(6), DegreeRequest::Inferred] {
        let own = FractureRequest { degree, ..request.clone() };
        if let Ok(outcome) =
            strike(RequestContext::new(&prepared, &own, &CancelToken::default(), &()), &mut Workspace::default())
        {
            assert!((0.0..=1.0).contains(&outcome.confidence()), "{what}: {}", outcome.confidence());
            outcome.meshes().iter().for_each(|pieces| check_pieces(pieces, what));
        }
    }
}

fn check_pieces(pieces: &FractureMeshes, what: &str) {
    let (mut positions, mut indices) = (vec![[0.0; 3]; pieces.counts.vertices], vec![0; pieces.counts.indices]);
    pieces.emit(&mut positions, &mut indices, &mut vec![[0; 2]; pieces.counts.merges]).unwrap();
    for row in &pieces.fragments {
        let vertices = &positions[row.vertex_first as usize..][..row.vertex_count as usize];
        let triangles = &indices[row.index_first as usize..][..row.index_count as usize];
        closed(vertices, triangles).unwrap_or_else(|open| panic!("{what}: fragment {}: {open}", row.id));
        assert!(row.mass_kg.is_finite() && row.mass_kg > 0.0, "{what}");
    }
}

#[test]
fn a_flipped_bit_in_the_header_is_refused() {
    let bytes = file();
    assert!(opened(&bytes).is_ok());
    let (_, data) = header(&bytes);
    let mut stream = RandomStream::new(11, 0);
    for at in (0..data).step_by(data / 400) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (stream.bits() % 8);
        let blank = damaged[at].is_ascii_whitespace() && bytes[at].is_ascii_whitespace();
        assert!(opened(&damaged).is_err() || blank, "byte {at}");
    }
}

#[test]
fn a_thousand_files_with_a_flipped_bit_are_refused_with_the_tensor_named() {
    let bytes = file();
    let tensors = tensors(&bytes);
    assert!(tensors.iter().any(|(name, ..)| name == "reduced0.basis"), "all kinds of tensors are there");
    let mut stream = RandomStream::new(12, 0);
    for index in 0..1000 {
        let (name, range, _) = &tensors[index % tensors.len()];
        let at = range.start + stream.bits() as usize % range.len();
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (stream.bits() % 8);
        match opened(&damaged) {
            Err(DatabaseError::Checksum(found)) => assert_eq!(found, *name),
            Err(other) => panic!("{name}, byte {at}: {other}"),
            Ok(_) => panic!("{name}, byte {at} was not noticed"),
        }
    }
}

#[test]
fn a_truncated_file_is_refused_wherever_it_ends() {
    let bytes = file();
    let (_, data) = header(&bytes);
    let ends = [0, 1, 7, 8, 9, data / 2, data - 1, data, data + 1, bytes.len() / 2, bytes.len() - 1];
    for end in ends {
        assert!(opened(&bytes[..end]).is_err(), "{end}");
    }
    let longer = [bytes.clone(), vec![0]].concat();
    assert!(opened(&longer).is_err());
}

/// Somebody writes to the file instead of replacing it.
#[test]
fn a_file_changed_while_it_is_read_is_rejected_or_unchanged() {
    let bytes = file();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hostile.shatter");
    std::fs::write(&path, &bytes).unwrap();
    let open = || container::ContainerContents::open(&path).unwrap();
    let (mut early, mut late, mut whole) = (open(), open(), open());
    whole.verify(|_| true).unwrap();
    let nodes = |contents: &container::ContainerContents| contents.f64("body0.crack.nodes", None, 3).unwrap();
    let before = nodes(&whole);
    let (_, data) = header(&bytes);
    let zeros = [bytes[..data].to_vec(), vec![0; bytes.len() - data]].concat();
    std::fs::write(&path, zeros).unwrap();
    assert!(matches!(early.verify(|_| true), Err(DatabaseError::Checksum(_))));
    std::fs::write(&path, &bytes[..data + 1]).unwrap();
    assert!(matches!(late.verify(|_| true), Err(DatabaseError::Io { .. })));
    assert_eq!(nodes(&whole), before);
}

#[test]
fn swapped_sections_are_refused() {
    let bytes = file();
    let tensors = tensors(&bytes);
    let mut swapped = 0;
    for (index, (_, one, _)) in tensors.iter().enumerate() {
        for (_, other, _) in tensors[index + 1..].iter().filter(|(_, other, _)| other.len() == one.len()) {
            if bytes[one.clone()] == bytes[other.clone()] {
                continue;
            }
            let mut mixed = bytes.clone();
            mixed[one.clone()].copy_from_slice(&bytes[other.clone()]);
            mixed[other.clone()].copy_from_slice(&bytes[one.clone()]);
            assert!(opened(&mixed).is_err());
            check(&sealed(mixed), "swapped and sealed");
            swapped += 1;
        }
    }
    assert!(swapped > 0);
}

#[test]
fn hostile_numbers_under_fitting_checksums_are_refused_or_harmless() {
    let bytes = file();
    check(&sealed(bytes.clone()), "untouched");
    assert!(opened(&sealed(bytes.clone())).is_ok());
    let mut stream = RandomStream::new(5, 0);
    for (name, range, dtype) in tensors(&bytes) {
        let width = if dtype == "F64" { 8 } else { 4 };
        let values: [[u8; 8]; 6] = [
            f64::NAN.to_le_bytes(),
            f64::INFINITY.to_le_bytes(),
            1e300f64.to_le_bytes(),
            (-1.0f64).to_le_bytes(),
            [0; 8],
            stream.bits().to_le_bytes(),
        ];
        let integers: [[u8; 8]; 6] =
            [[255; 8], [0; 8], [1; 8], [0, 0, 0, 128, 0, 0, 0, 128], [7; 8], stream.bits().to_le_bytes()];
        let floats: [[u8; 8]; 6] = [f32::NAN, f32::INFINITY, f32::MAX, -1.0, 0.0, f32::MIN_POSITIVE]
            .map(|value| [value.to_le_bytes(), [0; 4]].concat().try_into().unwrap());
        for value in match dtype.as_str() {
            "F64" => values,
            "F32" => floats,
            _ => integers,
        } {
            let count = range.len() / width;
            let at = range.start + width * (stream.bits() as usize % count.max(1));
            let mut hostile = bytes.clone();
            hostile[at..at + width].copy_from_slice(&value[..width]);
            check(&sealed(hostile), &format!("{name}: {value:?} at {at}"));
        }
    }
}
