//! Fuzz target for mesh files, read and repaired.

use super::{choice, seed};
use shatter_fracture::surface::{InsideTest, LengthUnit, RawMesh, Surface, UpAxis, read, read_painted};

/// File formats, by the input's first byte.
const FORMATS: [&str; 8] = ["obj", "ply", "stl", "gltf", "glb", "msh", "vtk", "mesh"];

/// Largest number of triangles of a mesh that is repaired: more would spend the time on crossings instead of reading.
const MENDED_MAX: usize = 512;

/// Corners and faces of a tetrahedron, outward.
const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [[u8; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

const OBJ: &str = "mtllib a.mtl\no tetra\nv 0 0 0\nv 1 0 0 1\nv 0 1 0 0.5 0.5 0.5\nv 0 0 1\nvt 0 0\nvt 1 0\nvn 0 0 1\n\
                   usemtl clay\ng a b\ns 1\nf 1/1/1 3/2/1 2/1/1\nf 1//1 2//1 4//1\nusemtl glaze\nf -4 -1 -2\nf 2/1 3/2 4/1\n\
                   # quad\nv 2 0 0\nv 3 0 0\nv 3 1 0\nv 2 1 0\nf 5 6 7 8\nl 1 2\np 1\n";

const MSH: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n\
                   0 0 1\n$EndNodes\n$Elements\n2 2 1 2\n2 1 2 1\n1 1 2 3\n3 1 4 1\n2 1 2 3 4\n$EndElements\n";

const MSH_2: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n\
                     $Elements\n1\n1 4 2 0 1 1 2 3 4\n$EndElements\n";

const VTK: &str = "# vtk DataFile Version 3.0\nseed\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0\n\
                   0 1 0 0 0 1\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n";

const VTK_5: &str = "# vtk DataFile Version 5.1\nseed\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0\n\
                     0 1 0 0 0 1\nCELLS 2 4\nOFFSETS vtktypeint64\n0 4\nCONNECTIVITY vtktypeint64\n0 1 2 3\n\
                     CELL_TYPES 1\n10\n";

const MEDIT: &str = "MeshVersionFormatted 2\nDimension 3\nVertices 4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n\
                     Tetrahedra 1\n1 2 3 4 0 # all\nEnd\n";

pub(super) fn seeds() -> Vec<Vec<u8>> {
    vec![
        seed(0, OBJ),
        seed(1, ascii_ply()),
        seed(1, binary_ply("binary_little_endian", f32::to_le_bytes, i32::to_le_bytes)),
        seed(1, binary_ply("binary_big_endian", f32::to_be_bytes, i32::to_be_bytes)),
        seed(2, ascii_stl()),
        seed(2, binary_stl()),
        seed(3, gltf(Some(&data_uri()))),
        seed(4, glb()),
        seed(5, MSH),
        seed(5, MSH_2),
        seed(6, VTK),
        seed(6, VTK_5),
        seed(7, MEDIT),
    ]
}

fn ascii_ply() -> String {
    let rows: String = CORNERS.iter().map(|[x, y, z]| format!("{x} {y} {z} 7\n")).collect();
    let faces: String = FACES.iter().map(|[a, b, c]| format!("3 {a} {b} {c}\n")).collect();
    format!(
        "ply\nformat ascii 1.0\ncomment seed\nelement vertex 4\nproperty float x\nproperty float y\nproperty double z\n\
         property uchar red\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n{rows}{faces}"
    )
}

fn binary_ply(format: &str, real: fn(f32) -> [u8; 4], integer: fn(i32) -> [u8; 4]) -> Vec<u8> {
    let head = format!(
        "ply\nformat {format} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
         element face 4\nproperty list uchar int vertex_index\nend_header\n"
    );
    let corners = CORNERS.iter().flatten().flat_map(|x| real(*x));
    let faces = FACES.iter().flat_map(|face| [3].into_iter().chain(face.iter().flat_map(|i| integer((*i).into()))));
    head.into_bytes().into_iter().chain(corners).chain(faces).collect()
}

fn ascii_stl() -> String {
    let corner = |index: u8| {
        let [x, y, z] = CORNERS[usize::from(index)];
        format!("vertex {x} {y} {z}\n")
    };
    let facet =
        |face: &[u8; 3]| format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", face.map(corner).concat());
    format!("solid seed\n{}endsolid seed\n", FACES.iter().map(facet).collect::<String>())
}

fn binary_stl() -> Vec<u8> {
    let facet = |face: &[u8; 3]| {
        let corners = face.map(|index| bytemuck::cast::<[f32; 3], [u8; 12]>(CORNERS[usize::from(index)])).concat();
        [vec![0; 12], corners, vec![0; 2]].concat()
    };
    [vec![b' '; 80], 4u32.to_le_bytes().to_vec(), FACES.iter().flat_map(facet).collect()].concat()
}

/// A buffer of positions, then indices of one byte.
fn buffer() -> Vec<u8> {
    [bytemuck::cast_slice(&CORNERS), FACES.as_flattened()].concat()
}

fn data_uri() -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let group = |three: &[u8]| {
        let word = three.iter().fold(0u32, |word, byte| word << 8 | u32::from(*byte));
        [18, 12, 6, 0].map(|shift| char::from(DIGITS[(word >> shift & 63) as usize]))
    };
    let text: String = buffer().chunks(3).flat_map(group).collect();
    format!("data:application/octet-stream;base64,{text}")
}

fn gltf(uri: Option<&str>) -> String {
    let uri = uri.map(|uri| format!(r#","uri":"{uri}""#)).unwrap_or_default();
    let bytes = buffer().len();
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
"nodes":[{{"mesh":0,"children":[1],"scale":[1,1,1]}},{{"mesh":0,"translation":[3,0,0],"rotation":[0,0,0,1]}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"mode":4}}]}}],
"buffers":[{{"byteLength":{bytes}{uri}}}],
"bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":12}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]}},
{{"bufferView":1,"componentType":5121,"count":12,"type":"SCALAR"}}]}}"#
    )
}

fn glb() -> Vec<u8> {
    let chunk = |kind: &[u8; 4], mut content: Vec<u8>, fill: u8| {
        content.resize(content.len().next_multiple_of(4), fill);
        [&(content.len() as u32).to_le_bytes(), kind, &content[..]].concat()
    };
    let chunks = [chunk(b"JSON", gltf(None).into_bytes(), b' '), chunk(b"BIN\0", buffer(), 0)].concat();
    let length = 12 + chunks.len() as u32;
    [&b"glTF"[..], &2u32.to_le_bytes(), &length.to_le_bytes(), &chunks].concat()
}

pub(super) fn run(input: &[u8]) -> bool {
    let Some((format, rest)) = choice(input, FORMATS.len() as u8) else { return false };
    let folder = tempfile::tempdir().expect("a folder for the file");
    let path = folder.path().join(format!("fuzz.{}", FORMATS[usize::from(format)]));
    std::fs::write(&path, rest).expect("a file that can be written");
    if let Ok((points, values)) = read_painted(&path, "red") {
        assert!(points.len() == values.len() && values.iter().all(|value| value.is_finite()));
    }
    match read(&path, LengthUnit::M, UpAxis::Y) {
        Ok(mesh) => {
            mended(mesh);
            true
        }
        Err(error) => {
            assert!(!error.to_string().is_empty());
            false
        }
    }
}

fn mended(mesh: RawMesh) {
    let vertices = mesh.positions_m.len();
    assert!(mesh.positions_m.iter().all(|point| point.iter().all(|x| x.is_finite())));
    assert!(mesh.triangles.as_flattened().iter().all(|index| (*index as usize) < vertices));
    if mesh.triangles.len() > MENDED_MAX {
        return;
    }
    let Ok(surface) = Surface::repair(mesh) else { return };
    assert!(surface.triangles.as_flattened().iter().all(|index| (*index as usize) < surface.positions.len()));
    assert!(surface.positions.iter().all(|point| point.iter().all(|x| x.is_finite())));
    assert!(surface.signed_volume().is_finite());
    let inside = InsideTest::new(&surface);
    assert!(inside.signed_distance(&surface.positions[0]).is_finite());
}
