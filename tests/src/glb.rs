//! An independent reader of exported fragments: the `gltf` crate parses the file; closedness, orientation and volume are computed here from
//! the triangles only.

use anyhow::{Context, Result, bail, ensure};
use gltf::accessor::Iter;
use serde_json::Value;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// One fragment as read from the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Fragment {
    /// `extras.fragment` of its node.
    pub id: u32,
    /// `extras.volume_m3`, as the writer states it.
    pub stated_volume_m3: f64,
    /// `extras.mass_kg`.
    pub mass_kg: f64,
    /// `extras.inertia_kg_m2`: xx, yy, zz, xy, xz, yz about the center of mass.
    pub inertia_kg_m2: [f64; 6],
    /// Sum of the translations of the node and its parents, m: the center of mass.
    pub center_m: [f64; 3],
    /// Vertices relative to the center, m.
    pub positions: Vec<[f32; 3]>,
    /// Triangles of the primitive with material `outer`.
    pub outer: Vec<[u32; 3]>,
    /// Triangles of the primitive with material `crack`.
    pub crack: Vec<[u32; 3]>,
    /// Triangles of the manifold primitive of `EXT_mesh_manifold`, merges applied, if the mesh carries it.
    pub manifold: Option<Vec<[u32; 3]>>,
}

/// Reads every fragment of a `.glb` file, in the order of its nodes, with or without a common parent. The `gltf` crate validates the document.
pub fn read(path: &Path) -> Result<Vec<Fragment>> {
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    parse(&bytes)
}

/// Reads every fragment from the bytes of a `.glb` file.
pub fn parse(bytes: &[u8]) -> Result<Vec<Fragment>> {
    let file = gltf::Gltf::from_slice(bytes)?;
    let blob = file.blob.as_deref().context("no binary chunk")?;
    let scene = file.default_scene().context("no default scene")?;
    let mut fragments = Vec::new();
    for node in scene.nodes() {
        subtree(&file.document, blob, &node, [0.0; 3], &mut fragments)?;
    }
    Ok(fragments)
}

/// Reads the fragments of `node` and of the nodes below it. The origin of `node` is at `parent_m`.
fn subtree(
    document: &gltf::Document,
    blob: &[u8],
    node: &gltf::Node,
    parent_m: [f64; 3],
    fragments: &mut Vec<Fragment>,
) -> Result<()> {
    if node.mesh().is_some() {
        ensure!(node.children().len() == 0, "node {} has a mesh and children", node.index());
        fragments.push(fragment(document, blob, node, parent_m)?);
        return Ok(());
    }
    ensure!(node.children().len() > 0, "node {} has neither a mesh nor children", node.index());
    let center_m = place(node, parent_m)?;
    node.children().try_for_each(|child| subtree(document, blob, &child, center_m, fragments))
}

/// Position of a node whose parent is at `parent_m`, m.
fn place(node: &gltf::Node, parent_m: [f64; 3]) -> Result<[f64; 3]> {
    let (translation, rotation, scale) = node.transform().decomposed();
    ensure!(rotation == [0.0, 0.0, 0.0, 1.0] && scale == [1.0; 3], "node {} is turned or scaled", node.index());
    Ok([0, 1, 2].map(|k| parent_m[k] + f64::from(translation[k])))
}

fn fragment(document: &gltf::Document, blob: &[u8], node: &gltf::Node, parent_m: [f64; 3]) -> Result<Fragment> {
    let name = node.name().context("a node without a name")?;
    let extras: Value = serde_json::from_str(node.extras().as_ref().context("a node without extras")?.get())?;
    let number = |key: &str| extras[key].as_f64().with_context(|| format!("{name}: no extras.{key}"));
    let id = number("fragment")? as u32;
    ensure!(name == format!("fragment_{id:03}"), "{name} holds fragment {id}");
    let mesh = node.mesh().context("a node without a mesh")?;
    let mut read = Fragment {
        id,
        stated_volume_m3: number("volume_m3")?,
        mass_kg: number("mass_kg")?,
        inertia_kg_m2: serde_json::from_value(extras["inertia_kg_m2"].clone()).context("no extras.inertia_kg_m2")?,
        center_m: place(node, parent_m)?,
        positions: Vec::new(),
        outer: Vec::new(),
        crack: Vec::new(),
        manifold: manifold(document, blob, &mesh)?,
    };
    let shared: Vec<usize> =
        mesh.primitives().flat_map(|p| p.get(&gltf::Semantic::Positions)).map(|a| a.index()).collect();
    ensure!(shared.windows(2).all(|pair| pair[0] == pair[1]), "{name}: primitives do not share their vertices");
    for primitive in mesh.primitives() {
        let reader = primitive.reader(|_| Some(blob));
        read.positions = reader.read_positions().context("no positions")?.collect();
        let normals: Vec<[f32; 3]> = reader.read_normals().context("no normals")?.collect();
        let unit = |n: &[f32; 3]| (n.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-5;
        ensure!(normals.len() == read.positions.len() && normals.iter().all(unit), "{name}: normals are not unit");
        let indices: Vec<u32> = reader.read_indices().context("no indices")?.into_u32().collect();
        let triangles = triples(&indices)?;
        match primitive.material().name() {
            Some("outer") => read.outer.extend(triangles),
            Some("crack") => read.crack.extend(triangles),
            other => bail!("{name}: material {other:?}"),
        }
    }
    Ok(read)
}

/// The manifold primitive of a mesh, read through the sparse accessor that the extension prescribes.
fn manifold(document: &gltf::Document, blob: &[u8], mesh: &gltf::Mesh) -> Result<Option<Vec<[u32; 3]>>> {
    let extensions = &document.as_json().meshes[mesh.index()].extensions;
    let Some(extension) = extensions.as_ref().and_then(|found| found.others.get("EXT_mesh_manifold")) else {
        return Ok(None);
    };
    let index = extension["manifoldPrimitive"]["indices"].as_u64().context("no manifold indices")?;
    let accessor = document.accessors().nth(index as usize).context("no such accessor")?;
    let indices: Vec<u32> = Iter::new(accessor, |_| Some(blob)).context("unreadable manifold indices")?.collect();
    triples(&indices).map(Some)
}

fn triples(indices: &[u32]) -> Result<Vec<[u32; 3]>> {
    ensure!(indices.len().is_multiple_of(3), "{} indices are no triangles", indices.len());
    Ok(indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect())
}

/// The file of closed meshes: the one beside `file`, or `file` itself if the skins are closed.
pub fn closed_file(file: &Path) -> PathBuf {
    let beside = file.with_extension("closed.glb");
    if beside.exists() { beside } else { file.to_owned() }
}

impl Fragment {
    /// All triangles, outer ones first.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        [self.outer.as_slice(), &self.crack].concat()
    }

    /// Checks that the surface is closed and consistently oriented: after welding bitwise equal positions, every edge has exactly two
    /// opposite half-edges. The manifold primitive, if present, must agree.
    pub fn check_closed(&self) -> Result<()> {
        let mut places = HashMap::new();
        let welded: Vec<u32> = self
            .positions
            .iter()
            .map(|position| {
                let next = places.len() as u32;
                *places.entry(position.map(f32::to_bits)).or_insert(next)
            })
            .collect();
        half_edges_pair(self.triangles().iter().map(|t| t.map(|vertex| welded[vertex as usize])))
            .with_context(|| format!("fragment {}", self.id))?;
        if let Some(manifold) = &self.manifold {
            half_edges_pair(manifold.iter().copied()).with_context(|| format!("manifold {}", self.id))?;
            let place = |t: &[u32; 3]| t.map(|vertex| self.positions[vertex as usize].map(f32::to_bits));
            let same = manifold.iter().map(place).eq(self.triangles().iter().map(place));
            ensure!(same, "fragment {}: merging moved a vertex", self.id);
        }
        Ok(())
    }

    /// Volume inside the triangles, m³, by the divergence theorem.
    pub fn volume_m3(&self) -> f64 {
        let corner = |vertex: u32| self.positions[vertex as usize].map(f64::from);
        let six: f64 = self.triangles().iter().map(|t| determinant(t.map(corner))).sum();
        six / 6.0
    }
}

fn determinant([a, b, c]: [[f64; 3]; 3]) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
}

fn half_edges_pair(triangles: impl Iterator<Item = [u32; 3]>) -> Result<()> {
    let mut counts: HashMap<[u32; 2], u32> = HashMap::new();
    for [a, b, c] in triangles {
        for edge in [[a, b], [b, c], [c, a]] {
            ensure!(edge[0] != edge[1], "a triangle with a doubled corner {}", edge[0]);
            *counts.entry(edge).or_default() += 1;
        }
    }
    for (edge, count) in &counts {
        let opposite = counts.get(&[edge[1], edge[0]]).copied().unwrap_or(0);
        ensure!(*count == 1 && opposite == 1, "edge {edge:?} has {count} half-edges and {opposite} opposite ones");
    }
    Ok(())
}
