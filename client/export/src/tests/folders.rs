//! Sets of files in a folder: OBJ files with their table, and a model with its meshes.

use super::{sample, view};
use crate::{ExportError, FragmentView, ObjectView, WriteReport, write_mjcf, write_obj};
use std::fs::{self, File};
use std::path::Path;

/// Folder of the pieces of the model `m.xml`.
const MESHES: &str = "m_assets";

/// Writes an object of so many fragments as OBJ files into `folder`.
fn obj(folder: &Path, count: u32) -> Result<WriteReport, ExportError> {
    write(count, |object| write_obj(folder, object))
}

/// Writes an object of so many fragments as the model `m.xml` into `folder`.
fn model(folder: &Path, count: u32) -> Result<WriteReport, ExportError> {
    write(count, |object| write_mjcf(&folder.join("m.xml"), object))
}

fn write<R>(count: u32, write: impl FnOnce(&ObjectView<'_>) -> R) -> R {
    let sample = sample();
    let fragments: Vec<FragmentView<'_>> = (0..count).map(|id| view(&sample, id)).collect();
    write(&ObjectView { name: "thing", fragments: &fragments, hulls: &[], bonds: &[] })
}

/// Replaces the file `blocked` by a folder, so that writing ends before it, and returns the error.
fn interrupted(blocked: &Path, write: impl FnOnce() -> Result<WriteReport, ExportError>) -> ExportError {
    let _ = fs::remove_file(blocked);
    fs::create_dir_all(blocked).unwrap();
    let error = write().unwrap_err();
    fs::remove_dir(blocked).unwrap();
    error
}

#[test]
fn an_interrupted_export_leaves_no_table_of_an_earlier_one() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    obj(folder, 3).unwrap();
    let error = interrupted(&folder.join("fragment_001.obj"), || obj(folder, 2));
    assert!(matches!(error, ExportError::IsFolder(_)), "{error}");
    assert!(folder.join("fragment_000.obj").is_file() && !folder.join("fragments.json").exists());
    model(folder, 3).unwrap();
    let error = interrupted(&folder.join(MESHES).join("fragment_001_outer.obj"), || model(folder, 2));
    assert!(matches!(error, ExportError::IsFolder(_)), "{error}");
    assert!(folder.join(MESHES).join("fragment_000_outer.obj").is_file() && !folder.join("m.xml").exists());
    obj(folder, 2).unwrap();
    model(folder, 2).unwrap();
    assert!(folder.join("fragments.json").is_file() && folder.join("m.xml").is_file());
}

#[test]
fn a_folder_has_one_writer_at_a_time() {
    let temporary = tempfile::tempdir().unwrap();
    let (pieces, meshes) = (temporary.path().join("pieces"), temporary.path().join(MESHES));
    obj(&pieces, 3).unwrap();
    model(temporary.path(), 3).unwrap();
    let before = [pieces.join("fragments.json"), temporary.path().join("m.xml")].map(|path| fs::read(path).unwrap());
    let locks = [&pieces, &meshes].map(|folder| File::open(folder).unwrap());
    locks.iter().for_each(|lock| lock.try_lock().unwrap());
    for (folder, result) in [(&pieces, obj(&pieces, 2)), (&meshes, model(temporary.path(), 2))] {
        let error = result.unwrap_err();
        assert!(matches!(&error, ExportError::FolderInUse(own) if own == folder), "{error}");
        assert_eq!(error.path(), Some(folder.as_path()));
        let wanted = format!("another command is writing to the folder {}; wait for it", folder.display());
        assert!(error.to_string().starts_with(&wanted), "{error}");
    }
    let after = [pieces.join("fragments.json"), temporary.path().join("m.xml")].map(|path| fs::read(path).unwrap());
    assert_eq!(after, before);
    drop(locks);
    obj(&pieces, 2).unwrap();
    model(temporary.path(), 2).unwrap();
    let names: Vec<_> = fs::read_dir(&pieces).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names.len(), 4, "two fragments, the materials and the table, and no file of the lock: {names:?}");
}

#[test]
fn a_model_that_is_no_valid_xml_removes_no_meshes() {
    let temporary = tempfile::tempdir().unwrap();
    let (path, stale) = (temporary.path().join("m.xml"), temporary.path().join(MESHES).join("fragment_002_outer.obj"));
    model(temporary.path(), 3).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    let end = text.find("<worldbody").unwrap();
    for damaged in [text[..end].to_owned(), format!("{}</wrong>", &text[..end])] {
        fs::write(&path, damaged).unwrap();
        model(temporary.path(), 2).unwrap();
        assert!(stale.is_file());
    }
    fs::write(&path, text).unwrap();
    model(temporary.path(), 2).unwrap();
    assert!(!stale.exists());
}

#[test]
fn a_damaged_table_removes_no_fragments() {
    let temporary = tempfile::tempdir().unwrap();
    let (folder, table) = (temporary.path(), temporary.path().join("fragments.json"));
    obj(folder, 3).unwrap();
    let text = fs::read(&table).unwrap();
    fs::write(&table, &text[..text.len() - 4]).unwrap();
    obj(folder, 2).unwrap();
    assert!(folder.join("fragment_002.obj").is_file());
    fs::write(&table, &text).unwrap();
    obj(folder, 2).unwrap();
    assert!(!folder.join("fragment_002.obj").exists());
}

#[test]
fn a_linked_table_is_replaced_behind_its_link() {
    let temporary = tempfile::tempdir().unwrap();
    let (folder, link) = (temporary.path(), temporary.path().join("pieces/fragments.json"));
    obj(&folder.join("pieces"), 2).unwrap();
    fs::rename(&link, folder.join("table.json")).unwrap();
    std::os::unix::fs::symlink("../table.json", &link).unwrap();
    let written = obj(&folder.join("pieces"), 3).unwrap();
    assert_eq!(written.files[0], link);
    assert!(link.is_symlink() && fs::read_to_string(folder.join("table.json")).unwrap().contains("fragment_002.obj"));
}
