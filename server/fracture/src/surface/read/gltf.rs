//! Reader of glTF 2.0 and GLB: triangles, strips and fans of every node of the scene, in scene coordinates.
//!
//! The `gltf` crate parses and validates the document. Buffers and accessors are read with checked ranges.
//! Skins, morph targets and animations are ignored. A required extension that the crate does not know
//! (such as compression) is an error, unless it concerns materials or textures alone.

use super::accessor::BufferBytes;
use super::common::{load, malformed, within_limit};
use crate::scene::brief;
use crate::surface::{DOUBLE, NO_MATERIAL, SINGLE, TriangleAttributes, VertexLists};
use crate::surface::{RawMesh, SurfaceError};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::json::extensions::ENABLED_EXTENSIONS;
use gltf::mesh::{Mode, Primitive, Semantic};
use gltf::{Document, Gltf, Node};
use nalgebra::{Matrix3, Matrix4, Point3};
use std::path::{Component, Path, PathBuf};

/// Parses a glTF or GLB file whose buffers lie in `folder`.
pub(super) fn parse(bytes: &[u8], folder: &Path) -> Result<RawMesh, SurfaceError> {
    // The crate subtracts the header size from the length without a check.
    if bytes.starts_with(b"glTF") && bytes.get(8..12).is_some_and(|length| length[0] < 12 && length[1..] == [0; 3]) {
        return Err(malformed("gltf", "byte 8", "the length does not cover the header"));
    }
    if let Some(announced) = bytes.get(8..12).filter(|_| bytes.starts_with(b"glTF")) {
        let announced = announced.iter().rev().fold(0, |sum, byte| sum << 8 | usize::from(*byte));
        if announced > bytes.len() {
            let reason = format!("the file ends there, but it announces {announced} bytes: copy or export it again");
            return Err(malformed("gltf", format!("byte {}", bytes.len()), reason));
        }
    }
    let Gltf { document, blob } =
        Gltf::from_slice_without_validation(bytes).map_err(|error| malformed("gltf", "document", error))?;
    let document = validated(document)?;
    let buffers = buffers(&document, blob, folder)?;
    let mut builder = Builder { buffers, mesh: RawMesh::new(Vec::new(), Vec::new()), own_max: 0.0, given: [false; 4] };
    let name = |material: gltf::Material<'_>| {
        material.name().map_or_else(|| format!("material {}", material.index().unwrap_or(0)), str::to_owned)
    };
    builder.mesh.attributes.names = document.materials().map(name).collect();
    for (node, placement) in placed_nodes(&document)? {
        for primitive in node.mesh().iter().flat_map(|mesh| mesh.primitives()) {
            builder.push(&primitive, &placement)?;
        }
    }
    Ok(builder.finish())
}

/// Largest difference of the length of a rotation from 1, and of an element of a matrix from its exact value.
const TRANSFORM_ERROR_MAX: f32 = 1e-3;

/// Validates a document.
///
/// The crate's validation uses the accessor of positions before it checks that the accessor exists. It checks neither
/// `minVersion` nor the transforms of nodes.
fn validated(document: Document) -> Result<Document, SurfaceError> {
    let mut json = document.into_json();
    json.extensions_required.retain(|name| !is_of_materials(name));
    if let Some(name) = json.extensions_required.iter().find(|name| !ENABLED_EXTENSIONS.contains(&name.as_str())) {
        return Err(SurfaceError::RequiredExtension { extension: brief(name) });
    }
    let needed = json.asset.min_version.as_ref().map(|version| ("asset.minVersion", version, [2, 0]));
    // Later versions of the major version 2 add only what readers may ignore.
    let stated = Some(("asset.version", &json.asset.version, [2, u32::MAX]));
    for (key, version, most) in [needed, stated].into_iter().flatten() {
        let [major, minor] = numbers(version).unwrap_or([u32::MAX; 2]);
        if [major, minor] > most || (key == "asset.version" && major != 2) {
            let reason = format!("is {}; this reader needs glTF 2.0: export it as that", brief(version));
            return Err(malformed("gltf", key, reason));
        }
    }
    for (number, node) in json.nodes.iter().enumerate() {
        transform(node).map_err(|reason| malformed("gltf", format!("node {number}"), reason))?;
    }
    for (number, mesh) in json.meshes.iter().enumerate() {
        let mut accessors = mesh.primitives.iter().flat_map(|primitive| primitive.attributes.values());
        if accessors.any(|accessor| accessor.value() >= json.accessors.len()) {
            return Err(malformed("gltf", format!("mesh {number}"), "refers to an accessor that does not exist"));
        }
    }
    Document::from_json(json).map_err(|error| malformed("gltf", "document", error))
}

/// True for extensions of materials and textures, which do not change the shape.
fn is_of_materials(extension: &str) -> bool {
    ["_materials_", "_texture_"].iter().any(|part| extension.contains(part))
}

/// Major and minor number of a version.
fn numbers(version: &str) -> Option<[u32; 2]> {
    let (major, minor) = version.split_once('.')?;
    Some([major.parse().ok()?, minor.parse().ok()?])
}

/// Checks that a node's rotation has the length 1 and that its matrix is affine (glTF 2.0, section 3.5.3).
fn transform(node: &gltf::json::Node) -> Result<(), String> {
    if let Some(rotation) = &node.rotation {
        let length = rotation.0.iter().map(|x| x * x).sum::<f32>().sqrt();
        if (length - 1.0).abs() > TRANSFORM_ERROR_MAX {
            return Err(format!("its rotation {:?} has the length {length}, not 1: normalize it", rotation.0));
        }
    }
    let has_parts = node.translation.is_some() || node.rotation.is_some() || node.scale.is_some();
    if node.matrix.is_some() && has_parts {
        return Err("has a matrix beside a translation, rotation or scale; keep one of the two".to_owned());
    }
    if let Some(matrix) = &node.matrix {
        let last_row = [3, 7, 11, 15].map(|k| matrix[k]);
        if last_row.iter().zip([0.0, 0.0, 0.0, 1.0]).any(|(found, wanted)| (found - wanted).abs() > TRANSFORM_ERROR_MAX)
        {
            return Err(format!("elements 3, 7, 11 and 15 of its matrix are {last_row:?}, not 0, 0, 0 and 1"));
        }
    }
    Ok(())
}

fn buffers(document: &Document, mut blob: Option<Vec<u8>>, folder: &Path) -> Result<BufferBytes, SurfaceError> {
    let read = |buffer: gltf::Buffer| {
        let refused = |why: &dyn std::fmt::Display| malformed("gltf", format!("buffer {}", buffer.index()), why);
        let bytes = match buffer.source() {
            gltf::buffer::Source::Bin => blob.take().ok_or_else(|| refused(&"has no binary chunk"))?,
            gltf::buffer::Source::Uri(uri) if uri.starts_with("data:") => match uri.split_once(";base64,") {
                Some((_, data)) => STANDARD.decode(data).map_err(|error| refused(&error))?,
                None => return Err(refused(&"is a data URI without base64")),
            },
            gltf::buffer::Source::Uri(uri) => load(&beside(folder, uri).map_err(|why| refused(&why))?)?,
        };
        if buffer.length() > bytes.len() {
            let (wanted, found) = (buffer.length(), bytes.len());
            return Err(refused(&format!(
                "its byteLength is {wanted}, but it has {found} bytes: copy or export it again"
            )));
        }
        Ok(bytes)
    };
    Ok(BufferBytes(document.buffers().map(read).collect::<Result<_, _>>()?))
}

/// Path of the file in or below `folder` that `uri` names.
///
/// Rejects absolute names, other schemes, `..`, and links that lead out of the folder, because a mesh from elsewhere
/// must not read the user's other files.
fn beside(folder: &Path, uri: &str) -> Result<PathBuf, String> {
    let name = percent_decoded(uri).ok_or("its name is not UTF-8")?;
    let plain = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    // On some systems a backslash separates folders, and a colon follows a drive letter.
    let leaves = name.is_empty() || name.contains([':', '\\', '\0']) || !Path::new(&name).components().all(plain);
    let file = folder.join(&name);
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let leads_out = |file: &Path| match (file.canonicalize(), folder.canonicalize()) {
        (Ok(file), Ok(folder)) => !file.starts_with(folder),
        // A missing file cannot be read, so it leads nowhere.
        _ => false,
    };
    if leaves || leads_out(&file) {
        return Err(format!("'{}' leads out of the mesh's folder: put the buffer beside the mesh", brief(&name)));
    }
    Ok(file)
}

/// Decodes percent escapes such as %20.
fn percent_decoded(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        let digit = |k: usize| tail.get(k).and_then(|&digit| (digit as char).to_digit(16));
        match (first, digit(0), digit(1)) {
            (b'%', Some(high), Some(low)) => {
                bytes.push((high * 16 + low) as u8);
                rest = &tail[2..];
            }
            _ => {
                bytes.push(first);
                rest = tail;
            }
        }
    }
    String::from_utf8(bytes).ok()
}

/// Nodes of the default scene with their transforms to scene coordinates.
///
/// Without a default scene it takes the first scene; without any scene, all nodes of the document.
fn placed_nodes(document: &Document) -> Result<Vec<(Node<'_>, Matrix4<f64>)>, SurfaceError> {
    let mut visited = vec![false; document.nodes().len()];
    let mut pending: Vec<(Node, Matrix4<f64>)> = match document.default_scene().or_else(|| document.scenes().next()) {
        Some(scene) => scene.nodes().map(|root| (root, Matrix4::identity())).collect(),
        None => {
            let mut is_child = visited.clone();
            document.nodes().flat_map(|node| node.children()).for_each(|child| is_child[child.index()] = true);
            let roots = document.nodes().filter(|node| !is_child[node.index()]);
            roots.map(|root| (root, Matrix4::identity())).collect()
        }
    };
    pending.reverse();
    let mut placed = Vec::new();
    while let Some((node, parent)) = pending.pop() {
        if std::mem::replace(&mut visited[node.index()], true) {
            return Err(malformed("gltf", format!("node {}", node.index()), "is reached twice"));
        }
        let own = Matrix4::from(node.transform().matrix()).map(f64::from);
        let placement = parent * own;
        pending.extend(node.children().map(|child| (child, placement)).collect::<Vec<_>>().into_iter().rev());
        placed.push((node, placement));
    }
    Ok(placed)
}

/// Attributes that are read beside positions.
const SEMANTICS: [Semantic; 4] =
    [Semantic::Normals, Semantic::TexCoords(0), Semantic::TexCoords(1), Semantic::Colors(0)];

struct Builder {
    buffers: BufferBytes,
    mesh: RawMesh,
    /// Largest coordinate before translation; f32 rounding is relative to it.
    own_max: f64,
    /// Presence of each of [`SEMANTICS`] in any primitive.
    given: [bool; 4],
}

impl Builder {
    fn push(&mut self, primitive: &Primitive, placement: &Matrix4<f64>) -> Result<(), SurfaceError> {
        let (Some(accessor), mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) =
            (primitive.get(&Semantic::Positions), primitive.mode())
        else {
            return Ok(());
        };
        let positions = self.buffers.positions(&accessor)?;
        let count = positions.len();
        let indices = match primitive.indices() {
            Some(accessor) => self.buffers.indices(&accessor)?,
            None => (0..count as u32).collect(),
        };
        if mode == Mode::Triangles && !indices.len().is_multiple_of(3) {
            let reason = format!("has {} indices of triangles, which is no multiple of 3", indices.len());
            return Err(malformed("gltf", format!("primitive {}", primitive.index()), reason));
        }
        let first = self.mesh.positions_m.len();
        within_limit(first + count)?;
        within_limit(self.mesh.triangles.len() + indices.len())?;
        let linear = placement.fixed_view::<3, 3>(0, 0).into_owned();
        let offset = placement.fixed_view::<3, 1>(0, 3).into_owned();
        for position in positions {
            let turned = linear * nalgebra::Vector3::from(position.map(f64::from));
            self.own_max = self.own_max.max(turned.amax());
            self.mesh.positions_m.push(Point3::from(turned + offset));
        }
        let mirrored = linear.determinant() < 0.0;
        let added = self.mesh.triangles.len();
        for mut triangle in triangles(mode, &indices) {
            if let Some(&index) = triangle.iter().find(|&&index| index as usize >= count) {
                let face = self.mesh.triangles.len() as u64;
                return Err(SurfaceError::VertexOutOfBounds { face, index: i64::from(index), vertices: count as u64 });
            }
            if mirrored {
                triangle.swap(1, 2);
            }
            self.mesh.triangles.push(triangle.map(|index| index + first as u32));
        }
        self.look(primitive, first, added, &linear);
        Ok(())
    }

    /// Reads the attributes of the triangles from `added` on, whose vertices start at index
    /// `first`. Drops unreadable attributes.
    fn look(&mut self, primitive: &Primitive, first: usize, added: usize, linear: &Matrix3<f64>) {
        let [normals, uvs, uvs2, colors] = SEMANTICS.map(|semantic| primitive.get(&semantic));
        let given = [&normals, &uvs, &uvs2, &colors].map(Option::is_some);
        self.given = [0, 1, 2, 3].map(|k| self.given[k] || given[k]);
        let turn = linear.try_inverse().unwrap_or_else(Matrix3::identity).transpose();
        let turned =
            |normal: [f32; 3]| (turn * nalgebra::Vector3::from(normal.map(f64::from))).map(|x| x as f32).into();
        let normals = normals.and_then(|accessor| self.buffers.positions(&accessor).ok()).unwrap_or_default();
        let [uvs, uvs2] =
            [uvs, uvs2].map(|set| set.and_then(|accessor| self.buffers.uvs(&accessor).ok()).unwrap_or_default());
        let colors = colors.and_then(|accessor| self.buffers.colors(&accessor).ok()).unwrap_or_default();
        let lists = VertexLists { normals: normals.into_iter().map(turned).collect(), uvs, uvs2, colors };
        let own: Vec<[u32; 3]> =
            self.mesh.triangles[added..].iter().map(|triangle| triangle.map(|index| index - first as u32)).collect();
        let attributes = TriangleAttributes::of_vertices(&own, &lists);
        let all = &mut self.mesh.attributes;
        extend(&mut all.normals, attributes.normals, own.len());
        extend(&mut all.uvs, attributes.uvs, own.len());
        extend(&mut all.uvs2, attributes.uvs2, own.len());
        extend(&mut all.colors, attributes.colors, own.len());
        let material = primitive.material().index().map_or(NO_MATERIAL, |index| index as u32);
        self.mesh.attributes.materials.extend(own.iter().map(|_| material));
    }

    fn finish(mut self) -> RawMesh {
        let placed_max = self.mesh.positions_m.iter().map(|point| point.coords.amax()).fold(0.0, f64::max);
        let rounding = SINGLE * self.own_max / placed_max;
        let mut attributes = std::mem::take(&mut self.mesh.attributes);
        let [normals, uvs, uvs2, colors] = self.given;
        // An attribute that no primitive has is not reported as lost.
        clear_unless(normals, &mut attributes.normals);
        clear_unless(uvs, &mut attributes.uvs);
        clear_unless(uvs2, &mut attributes.uvs2);
        clear_unless(colors, &mut attributes.colors);
        if attributes.names.is_empty() {
            attributes.materials.clear();
        }
        self.mesh.attributes = attributes.fitting(self.mesh.triangles.len());
        self.mesh.rounding = if rounding.is_finite() { rounding.clamp(DOUBLE, SINGLE) } else { SINGLE };
        self.mesh
    }
}

/// Empties a list that is not given.
fn clear_unless<T>(is_given: bool, list: &mut Vec<T>) {
    if !is_given {
        list.clear();
    }
}

/// Appends the values of a primitive's triangles; not a number, which is dropped later, if it has none.
fn extend<const N: usize>(all: &mut Vec<[[f32; N]; 3]>, own: Vec<[[f32; N]; 3]>, triangles: usize) {
    let filled = if own.is_empty() { triangles } else { 0 };
    all.extend(own);
    all.resize(all.len() + filled, [[f32::NAN; N]; 3]);
}

/// Triangles of a primitive (glTF 2.0, section 3.7.2.1): strips flip every other triangle,
/// fans share their first vertex.
fn triangles(mode: Mode, indices: &[u32]) -> Box<dyn Iterator<Item = [u32; 3]> + '_> {
    match mode {
        Mode::TriangleStrip => Box::new(indices.windows(3).enumerate().map(|(k, window)| match k % 2 {
            0 => [window[0], window[1], window[2]],
            _ => [window[1], window[0], window[2]],
        })),
        Mode::TriangleFan => {
            let rim = indices.get(1..).unwrap_or_default();
            Box::new(rim.windows(2).map(|pair| [indices[0], pair[0], pair[1]]))
        }
        _ => Box::new(indices.chunks_exact(3).map(|chunk| [chunk[0], chunk[1], chunk[2]])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Result of reading a mesh in `folder/mesh` whose buffer is at `uri`.
    fn read(folder: &Path, uri: &str) -> Result<RawMesh, SurfaceError> {
        let document = format!(r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"uri":"{uri}","byteLength":4}}]}}"#);
        parse(document.as_bytes(), &folder.join("mesh"))
    }

    #[test]
    fn transforms_and_versions_that_gltf_rules_out_are_refused() {
        let read = |asset: &str, node: &str| {
            let document = format!(r#"{{"asset":{{"version":"2.0"{asset}}},"nodes":[{{}},{{{node}}}]}}"#);
            parse(document.as_bytes(), Path::new("."))
        };
        for (asset, node, wanted) in [
            ("", r#""rotation":[0,0,0,0]"#, "node 1: its rotation [0.0, 0.0, 0.0, 0.0] has the length 0, not 1"),
            ("", r#""rotation":[0,0,1,1]"#, "node 1: its rotation"),
            ("", r#""matrix":[1,0,0,0,0,1,0,0,0,0,1,0,5,0,0,2]"#, "node 1: elements 3, 7, 11 and 15 of its matrix"),
            ("", r#""matrix":[1,0,0,0.5,0,1,0,0,0,0,1,0,0,0,0,1]"#, "[0.5, 0.0, 0.0, 1.0]"),
            ("", r#""matrix":[1,0,0,0,0,1,0,0,0,0,1,0,5,0,0,1],"scale":[1,1,1]"#, "node 1: has a matrix beside"),
            (r#","minVersion":"3.0""#, "", "asset.minVersion: is 3.0; this reader needs glTF 2.0"),
            (r#","minVersion":"2.1""#, "", "asset.minVersion: is 2.1"),
            (r#","minVersion":"two""#, "", "asset.minVersion: is two"),
        ] {
            let error = read(asset, node).map(drop).unwrap_err().to_string();
            assert!(error.contains(wanted), "{error}");
        }
        for version in ["1.0", "3.0", "2", "2.0.1", "abc"] {
            let document = format!(r#"{{"asset":{{"version":"{version}"}}}}"#);
            let error = parse(document.as_bytes(), Path::new(".")).map(drop).unwrap_err().to_string();
            assert!(error.contains(&format!("asset.version: is {version}")), "{error}");
        }
        for (asset, node) in [
            (r#","minVersion":"1.0""#, ""),
            (r#","minVersion":"2.0""#, r#""rotation":[0,0,0.70710677,0.70710677]"#),
            ("", r#""matrix":[2,0,0,0,0,3,0,0,0,0,-1,0,5,6,7,1]"#),
        ] {
            assert!(read(asset, node).is_ok(), "{node}");
        }
    }

    #[test]
    fn buffers_shorter_than_their_length_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("mesh")).unwrap();
        std::fs::write(folder.path().join("mesh/own.bin"), [0; 3]).unwrap();
        for uri in ["own.bin", "data:;base64,AAAA"] {
            let error = read(folder.path(), uri).unwrap_err().to_string();
            let wanted = "malformed gltf, buffer 0: its byteLength is 4, but it has 3 bytes";
            assert!(error.starts_with(wanted), "{uri}: {error}");
        }
        assert!(read(folder.path(), "data:;base64,AAAAAAAA").is_ok(), "more bytes than the length are padding");
    }

    #[test]
    fn buffers_are_read_from_the_folder_of_the_mesh_alone() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(at("mesh/parts")).unwrap();
        for file in ["secret.bin", "mesh/own.bin", "mesh/parts/own bin", "mesh/parts/own..bin"] {
            std::fs::write(at(file), [0; 4]).unwrap();
        }
        for uri in ["own.bin", "./own.bin", "parts/own%20bin", "parts/own..bin"] {
            read(folder.path(), uri).unwrap_or_else(|error| panic!("{uri}: {error}"));
        }
        let absolute = at("secret.bin");
        let absolute = absolute.to_str().unwrap();
        for uri in [
            "../secret.bin",
            "parts/../../secret.bin",
            "parts/../own.bin",
            "%2e%2e/secret.bin",
            "%2E%2E%2Fsecret.bin",
            "..%5Csecret.bin",
            absolute,
            &format!("file://{absolute}"),
            &format!("file%3A//{absolute}"),
            "%2Fetc/passwd",
            "C:/secret.bin",
            "http://127.0.0.1/own.bin",
            "own.bin%00",
            "",
        ] {
            let error = read(folder.path(), uri).err().unwrap_or_else(|| panic!("{uri} was read"));
            let given = error.to_string();
            assert!(given.contains("buffer 0") && given.contains("leads out"), "{uri}: {given}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_that_lead_out_of_the_folder_are_refused_and_others_are_followed() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("mesh")).unwrap();
        std::fs::write(at("secret.bin"), [0; 4]).unwrap();
        std::fs::write(at("mesh/own.bin"), [0; 4]).unwrap();
        std::os::unix::fs::symlink("../secret.bin", at("mesh/out.bin")).unwrap();
        std::os::unix::fs::symlink("own.bin", at("mesh/in.bin")).unwrap();
        assert!(read(folder.path(), "in.bin").is_ok());
        assert!(read(folder.path(), "out.bin").unwrap_err().to_string().contains("leads out"));
    }
}
