//! Fragments as a folder of OBJ files: `fragment_000.obj`, …, the materials `outer` and `crack` in `fragments.mtl`, hulls as
//! `fragment_000.hull.obj` if there are any, and the data that OBJ cannot express in `fragments.json`.
//!
//! Coordinates are those of the mesh file (meters, +Y up), so that the fragments lie where they broke. Each file is a closed surface by
//! itself.

use super::document::{CRACK_COLOR, OUTER_COLOR, fragment_name};
use super::file::remove_table;
use super::folder_lock::FolderLock;
use super::obj::{Part, Vertices, line, mesh};
use super::{
    ExportError, FragmentView, HullView, ObjectView, WriteReport, check, make_folder, smooth_normals, stale,
    write_whole,
};
use serde_json::{Value, json};
use shatter_proto::result::Bond;
use std::path::Path;

const MATERIALS: &str = "fragments.mtl";
const TABLE: &str = "fragments.json";

/// Writes the fragments into `folder`, which is created if necessary. Each file appears whole or not at all. Files of those names are
/// replaced. Fragments that the replaced table names and the new one does not are removed; all other files stay.
///
/// An earlier table `fragments.json` is removed first, and the new one is written last. A table therefore never lies beside fragments of
/// another result, even if the process is killed.
///
/// # Errors
/// [`ExportError`] by the figure that makes no valid file, or by the file that cannot be written; [`ExportError::FolderInUse`] while
/// another process or thread writes fragments into the folder.
pub fn write_obj(folder: &Path, object: &ObjectView<'_>) -> Result<WriteReport, ExportError> {
    check::object(object)?;
    make_folder(folder)?;
    let _lock = FolderLock::acquire(folder)?;
    let rows: Vec<Value> = (0..object.fragments.len()).map(|place| row(object, place)).collect();
    let table_path = folder.join(TABLE);
    let earlier = stale::in_table(&table_path);
    let table_file = remove_table(&table_path)?;
    let kept = rows.iter().flat_map(|row| [&row["file"], &row["hull"]]).filter_map(Value::as_str);
    stale::remove(folder, &earlier, kept)?;
    let closed = object.fragments.iter().filter(|fragment| super::is_closed(fragment)).count();
    let files = vec![table_path];
    let mut written = WriteReport { fragments: object.fragments.len(), closed, bytes: 0, files };
    let mut put = |name: &str, text: &str| -> Result<(), ExportError> {
        let path = folder.join(name);
        write_whole(&path, text.as_bytes())?;
        written.bytes += text.len();
        written.files.push(path);
        Ok(())
    };
    put(MATERIALS, &materials())?;
    for (place, fragment) in object.fragments.iter().enumerate() {
        let name = fragment_name(fragment.id, object.fragments.len());
        put(&format!("{name}.obj"), &piece(&name, fragment))?;
        if let Some(hull) = hull(object, place) {
            let (name, points) = (format!("{name}.hull"), in_place(fragment, hull.positions));
            put(&format!("{name}.obj"), &text(&name, &points, &[Part { material: None, indices: hull.indices }]))?;
        }
    }
    let table = format!("{:#}\n", table(object, rows));
    write_whole(&table_file, table.as_bytes())?;
    written.bytes += table.len();
    Ok(written)
}

/// Hull of the fragment at `place`, if it has one.
fn hull<'a>(object: &ObjectView<'a>, place: usize) -> Option<HullView<'a>> {
    object.hulls.get(place).copied().flatten()
}

fn in_place(fragment: &FragmentView<'_>, positions: &[[f32; 3]]) -> Vec<[f64; 3]> {
    positions.iter().map(|own| [0, 1, 2].map(|k| fragment.center_m[k] + f64::from(own[k]))).collect()
}

/// First lines of a file.
fn head(name: &str) -> String {
    format!("# {} {}: meters, +Y up\no {name}\n", env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION"))
}

/// Text of points and triangles without attributes.
fn text(name: &str, points: &[[f64; 3]], parts: &[Part<'_>]) -> String {
    let mut text = head(name);
    mesh(&mut text, &Vertices { points, merged: &[], normals: &[], uvs: &[] }, parts);
    text
}

/// Text of a fragment with its attributes and materials.
fn piece(name: &str, fragment: &FragmentView<'_>) -> String {
    let made;
    let normals = match fragment.normals.is_empty() {
        true => {
            made = smooth_normals(fragment.positions, fragment.indices);
            &made
        }
        false => fragment.normals,
    };
    let (points, merged) = (in_place(fragment, fragment.positions), check::merged(fragment));
    let (outer, crack) = fragment.indices.split_at(fragment.outer_indices());
    let part = |material, indices| Part { material: Some(material), indices };
    let mut text = head(name);
    line(&mut text, format_args!("mtllib {MATERIALS}"));
    let vertices = Vertices { points: &points, merged: &merged, normals, uvs: fragment.uvs };
    mesh(&mut text, &vertices, &[part("outer", outer), part("crack", crack)]);
    text
}

fn materials() -> String {
    let mut text = String::new();
    for (name, [r, g, b, _]) in [("outer", OUTER_COLOR), ("crack", CRACK_COLOR)] {
        line(&mut text, format_args!("newmtl {name}\nKd {r} {g} {b}\nKs 0 0 0\nillum 1"));
    }
    text
}

fn row(object: &ObjectView<'_>, place: usize) -> Value {
    let fragment = &object.fragments[place];
    let name = fragment_name(fragment.id, object.fragments.len());
    json!({
        "id": fragment.id,
        "body": fragment.body,
        "file": format!("{name}.obj"),
        "hull": hull(object, place).map(|_| format!("{name}.hull.obj")),
        "center_m": fragment.center_m,
        "volume_m3": fragment.volume_m3,
        "mass_kg": fragment.mass_kg,
        "inertia_kg_m2": fragment.inertia_kg_m2,
    })
}

fn table(object: &ObjectView<'_>, fragments: Vec<Value>) -> Value {
    let bond = |bond: &Bond| {
        let fragments: Vec<u32> = bond.fragments().collect();
        let (area_m2, normal, centroid_m) = (bond.area_m2, bond.normal, bond.centroid_m);
        json!({ "fragments": fragments, "area_m2": area_m2, "normal": normal, "centroid_m": centroid_m })
    };
    json!({
        "object": object.name,
        "up": "y",
        "inertia": "about the center of mass, along the axes of the files: xx, yy, zz, xy, xz, yz",
        "fragments": fragments,
        "bonds": object.bonds.iter().map(bond).collect::<Vec<_>>(),
    })
}
