//! Output files of commands, and their formats.

use super::{CliError, note};
use shatter_cli_common::cli_error::size;
use shatter_client::{
    Deadline, Effect, Error, ErrorKind, FractureResult, FragmentSurface, Impact, Object, SourceMaterials,
    read_materials,
};
use shatter_export::{WriteReport, make_folder};
use shatter_proto::name::nearest;
use shatter_proto::text::counted;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Format of output files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum FileFormat {
    /// One binary glTF file.
    Glb,
    /// A folder of Wavefront OBJ files and a table of masses.
    Obj,
    /// A model for MuJoCo and a folder of meshes beside it.
    Mjcf,
}

/// Output target: the options `--out`, `--format` and `--materials`.
#[derive(Debug, PartialEq, Eq)]
pub struct OutputTarget {
    format: FileFormat,
    /// The file; for OBJ the folder.
    path: PathBuf,
    /// Folder to create if it does not exist.
    folder: Option<PathBuf>,
    /// Materials for the `.glb` file.
    materials: Option<SourceMaterials>,
}

/// Files that a command wrote.
#[derive(Debug, Default)]
pub struct WrittenFiles {
    /// The requested file, for OBJ the folder; `None` if nothing was written.
    pub target: Option<PathBuf>,
    /// Every file, the main one first.
    pub all: Vec<PathBuf>,
}

impl OutputTarget {
    /// Derives the format from the ending of the file. A path that ends neither with `.glb` nor with `.xml` is a folder, for `object.glb`
    /// unless `format` names another format.
    pub fn new(out: &Path, format: Option<FileFormat>, object: &str) -> Result<Self, CliError> {
        let ending = out.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        let target = match ending.as_deref().filter(|_| !out.is_dir()) {
            Some("glb") => Some(FileFormat::Glb),
            Some("xml") => Some(FileFormat::Mjcf),
            Some("obj") => {
                let message = "OBJ files need a folder; use --out DIR --format obj";
                return Err(CliError::Usage(message.to_owned()));
            }
            Some(other @ ("gltf" | "stl" | "ply" | "fbx" | "dae" | "usd" | "usda" | "usdc" | "usdz")) => {
                let message = format!("cannot write .{other} files; use --out FILE.glb, FILE.xml or a folder");
                return Err(CliError::Usage(message));
            }
            Some(other) if !out.is_dir() => {
                if let Some(likely) = nearest(other, &["glb", "xml"]).first() {
                    let message =
                        format!("cannot write .{other} files; did you mean {}?", out.with_extension(likely).display());
                    return Err(CliError::Usage(message));
                }
                None
            }
            _ => None,
        };
        if target.is_none() && out.exists() && !out.is_dir() {
            let message =
                format!("{} is not a folder; give a folder, or a file that ends with .glb or .xml", out.display());
            return Err(CliError::Usage(message));
        }
        if let (Some(target), Some(format)) = (target, format)
            && target != format
        {
            let out = out.display();
            return Err(CliError::Usage(format!("--format contradicts the ending of {out}; change one of them")));
        }
        let in_folder = |name: String| (out.join(name), Some(out.to_owned()));
        let format = target.or(format).unwrap_or(FileFormat::Glb);
        let (path, folder) = match (target, format) {
            (Some(_), _) => {
                (out.to_owned(), out.parent().filter(|parent| !parent.as_os_str().is_empty()).map(Path::to_owned))
            }
            (None, FileFormat::Obj) => (out.to_owned(), None),
            (None, FileFormat::Glb) => in_folder(format!("{object}.glb")),
            (None, FileFormat::Mjcf) => in_folder(format!("{object}.xml")),
        };
        Ok(Self { format, path, folder, materials: None })
    }

    /// Reads the materials for the file from the mesh file `materials`, if there is one. `disable` are the effects to switch off.
    pub fn with_materials(self, materials: Option<&Path>, disable: &[Effect]) -> Result<Self, CliError> {
        let Some(materials) = materials else { return Ok(self) };
        if self.format != FileFormat::Glb {
            let message = "--materials is for .glb files; use --out FILE.glb";
            return Err(CliError::Usage(message.to_owned()));
        }
        if disable.contains(&Effect::Attributes) {
            let message = "--materials needs the effect `attributes`, which --disable names; leave one of them out";
            return Err(CliError::Usage(message.to_owned()));
        }
        let is_replaced = |own: &PathBuf| {
            own.canonicalize().is_ok_and(|own| materials.canonicalize().is_ok_and(|other| own == other))
        };
        if self.files_of_a_result().iter().any(is_replaced) {
            let message = "--out would replace the file of --materials; use another name";
            return Err(CliError::Usage(message.to_owned()));
        }
        Ok(Self { materials: Some(read_materials(materials)?), ..self })
    }

    /// Strikes `object` with the effects that the format needs: bonds and hulls for a MuJoCo model, skins for a `.glb` file, except those
    /// in `disable`; and attributes for materials. A skin that `enable` does not name is left out if the object has none.
    pub fn strike(
        &self,
        object: &Object,
        impact: &Impact,
        [enable, disable]: [&[Effect]; 2],
        deadline: impl Fn() -> Deadline,
    ) -> Result<FractureResult, CliError> {
        let impact = &match self.materials {
            Some(_) => impact.clone().enable(Effect::Attributes),
            None => impact.clone(),
        };
        let shown: &[Effect] = match self.format {
            FileFormat::Glb => &[Effect::Skin],
            FileFormat::Mjcf => &[Effect::Bonds, Effect::Hulls],
            FileFormat::Obj => &[],
        };
        let shown = shown.iter().filter(|effect| !disable.contains(effect));
        let equipped = shown.clone().fold(impact.clone(), |impact, effect| impact.enable(*effect));
        let strike = |impact: &Impact| object.strike(impact)?.wait(deadline());
        match strike(&equipped) {
            Err(error)
                if self.format == FileFormat::Glb && !enable.contains(&Effect::Skin) && is_skin_error(&error) =>
            {
                let (path, result) = (self.path.display(), strike(impact)?);
                // An exact surface has the triangles of the file without a skin.
                if result.summary().surface == FragmentSurface::Lattice {
                    note(format_args!(
                        "{path} will contain the surface of the lattice instead of the triangles of the mesh file: {error}"
                    ));
                }
                Ok(result)
            }
            Err(error) if shown.clone().any(|effect| error.at == effect.name() && !enable.contains(effect)) => {
                let left_out: Vec<&str> = shown.map(|effect| effect.name()).collect();
                let advice = format!("; or pass --disable {} for files without them", left_out.join(","));
                Err(CliError::from(Error { message: error.message + &advice, ..error }))
            }
            result => Ok(result?),
        }
    }

    /// Writes the fragments and names each file on stderr. Writes nothing for an object that stays whole.
    pub fn write(&self, result: &FractureResult) -> Result<WrittenFiles, CliError> {
        if result.is_whole() {
            note(format_args!("nothing to write: {} stays whole", result.summary().object));
            self.files_of_a_result().iter().for_each(|path| warn_of_earlier_files(path));
            return Ok(WrittenFiles::default());
        }
        if let Some(folder) = &self.folder {
            make_folder(folder).map_err(|error| {
                Error::new(ErrorKind::Output, folder.display().to_string(), format!("{error} (--out)"))
            })?;
        }
        let all = match self.format {
            FileFormat::Glb => glb(&self.path, result, self.materials.as_ref())?,
            FileFormat::Obj => wrote(&self.path, "", result.write_obj(&self.path).map_err(some_stay)?),
            FileFormat::Mjcf => {
                wrote(&self.path, ", with its meshes", result.write_mjcf(&self.path).map_err(some_stay)?)
            }
        };
        Ok(WrittenFiles { target: Some(self.path.clone()), all })
    }

    /// Files of this target whose names do not depend on the fragments.
    fn files_of_a_result(&self) -> Vec<PathBuf> {
        match self.format {
            FileFormat::Glb => {
                let beside = ["closed.glb", "hulls.glb"].map(|ending| self.path.with_extension(ending));
                [vec![self.path.clone()], beside.to_vec()].concat()
            }
            FileFormat::Obj => vec![self.path.join("fragments.json")],
            FileFormat::Mjcf => vec![self.path.clone()],
        }
    }
}

/// The error of a format with several files, which says that those written before it stay.
fn some_stay(error: Error) -> Error {
    let message = format!("{}; files of this result that were written before it stay beside it", error.message);
    Error { message, ..error }
}

/// True if the skin caused the error: the object has none, or the result would be too long with it.
fn is_skin_error(error: &Error) -> bool {
    let (kind, at) = (error.kind, error.at.as_str());
    (kind, at) == (ErrorKind::Effect, Effect::Skin.name()) || (kind, at) == (ErrorKind::CapExceeded, "bytes_max")
}

/// Writes the visible surfaces of the fragments, or without skins the fragments themselves. Beside them it writes the closed meshes, if
/// these are others, and the hulls, if there are any. `materials` are for `file` alone. Returns the files.
///
/// With files beside it, an earlier `file` is removed first, and the new one is written last. It therefore never lies beside files of
/// another result, even if the process is killed.
fn glb(file: &Path, result: &FractureResult, materials: Option<&SourceMaterials>) -> Result<Vec<PathBuf>, Error> {
    let (closed, hulls) = (file.with_extension("closed.glb"), file.with_extension("hulls.glb"));
    let has_skins = result.fragments().any(|fragment| fragment.skin().is_some());
    let has_hulls = result.fragments().any(|fragment| fragment.hull().is_some());
    // The skins of an exact surface are the outer faces of the closed meshes.
    let has_closed = has_skins && result.summary().surface != FragmentSurface::Exact;
    if has_closed || has_hulls {
        remove_earlier_file(file)?;
    }
    let mut beside = Vec::new();
    match has_closed {
        true => beside.extend(wrote(&closed, ", closed meshes of the lattice", result.write_glb(&closed)?)),
        false => warn_of_earlier_files(&closed),
    }
    match has_hulls {
        true => beside.extend(wrote(&hulls, ", hulls", result.write_hulls_glb(&hulls)?)),
        false => warn_of_earlier_files(&hulls),
    }
    let report = match (has_skins, materials) {
        (true, Some(materials)) => result.write_skins_glb_with(file, materials)?,
        (true, None) => result.write_skins_glb(file)?,
        (false, Some(materials)) => result.write_glb_with(file, materials)?,
        (false, None) => result.write_glb(file)?,
    };
    let mut files = wrote(file, if has_closed { ", skin for rendering" } else { "" }, report);
    files.append(&mut beside);
    Ok(files)
}

/// Removes a file of an earlier command. A link stays, and so does its file: a file is written through a link only if both exist.
fn remove_earlier_file(file: &Path) -> Result<(), Error> {
    if file.is_symlink() || !file.is_file() {
        return Ok(());
    }
    std::fs::remove_file(file).map_err(|error| {
        let shown = file.display().to_string();
        let message = format!("cannot replace {shown}: {error}; choose another path");
        Error::new(ErrorKind::Output, shown, message)
    })
}

/// Names a file of an earlier command on stderr, which could be mistaken for a file of this one.
fn warn_of_earlier_files(path: &Path) {
    if path.is_file() {
        note(format_args!(
            "{} existed before and was not written: it has no fragments of this request",
            path.display()
        ));
    }
}

/// Names a file that was written, or for OBJ a folder, and every file that belongs to it: a line per folder. Returns the files.
fn wrote(path: &Path, what: &str, written: WriteReport) -> Vec<PathBuf> {
    let size = size(written.bytes as u64);
    let fragments = counted(written.fragments as u64, "fragment");
    note(format_args!("wrote {} ({fragments}{what}, {size})", path.display()));
    let mut others: BTreeMap<&Path, Vec<Cow<'_, str>>> = BTreeMap::new();
    for file in written.files.iter().filter(|file| *file != path) {
        if let (Some(folder), Some(name)) = (file.parent(), file.file_name()) {
            others.entry(folder).or_default().push(name.to_string_lossy());
        }
    }
    for (folder, names) in others {
        note(format_args!("wrote in {}: {}", folder.display(), names.join(", ")));
    }
    written.files
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(out: &str, format: Option<FileFormat>, wanted: Option<(FileFormat, &str, Option<&str>)>) {
        let found = OutputTarget::new(Path::new(out), format, "vase").ok();
        let wanted = wanted.map(|(format, path, folder)| OutputTarget {
            format,
            path: path.into(),
            folder: folder.map(PathBuf::from),
            materials: None,
        });
        assert_eq!(found, wanted, "{out}");
    }

    #[test]
    fn all_files_of_an_earlier_request_are_detected() {
        let files = |out: &str| OutputTarget::new(Path::new(out), None, "vase").ok().unwrap().files_of_a_result();
        assert_eq!(files("j.glb"), ["j.glb", "j.closed.glb", "j.hulls.glb"].map(PathBuf::from));
        assert_eq!(files("j.GLB"), ["j.GLB", "j.closed.glb", "j.hulls.glb"].map(PathBuf::from));
        assert_eq!(files("j.xml"), ["j.xml"].map(PathBuf::from));
    }

    #[test]
    fn materials_need_a_glb_file_the_effect_and_a_readable_file() {
        let folder = tempfile::tempdir().unwrap();
        let mesh = folder.path().join("mug.gltf");
        std::fs::write(&mesh, r#"{"asset":{"version":"2.0"}}"#).unwrap();
        let with = |out: &str, mesh: &Path, disable: &[Effect]| {
            OutputTarget::new(Path::new(out), None, "vase")
                .and_then(|target| target.with_materials(Some(mesh), disable))
        };
        assert!(with("a.glb", &mesh, &[Effect::Skin]).is_ok_and(|target| target.materials.is_some()));
        assert!(with("pieces", &mesh, &[]).is_ok());
        let usage = |found: Result<OutputTarget, CliError>| matches!(found, Err(CliError::Usage(_)));
        assert!(usage(with("a.xml", &mesh, &[])));
        assert!(usage(with("a.glb", &mesh, &[Effect::Attributes])));
        // The user's model stays.
        let model = folder.path().join("model.glb");
        std::fs::copy(&mesh, &model).unwrap();
        assert!(usage(with(model.to_str().unwrap(), &model, &[])));
        std::fs::rename(&model, folder.path().join("new.closed.glb")).unwrap();
        let out = folder.path().join("new.glb");
        assert!(usage(with(out.to_str().unwrap(), &out.with_extension("closed.glb"), &[])));
        let missing = with("a.glb", &folder.path().join("none.glb"), &[]);
        assert!(matches!(missing, Err(CliError::Refused(error)) if error.kind == ErrorKind::Output));
    }

    #[test]
    fn extension_and_format_select_the_output() {
        check("a.glb", None, Some((FileFormat::Glb, "a.glb", None)));
        check("a.GLB", Some(FileFormat::Glb), Some((FileFormat::Glb, "a.GLB", None)));
        check("a.xml", None, Some((FileFormat::Mjcf, "a.xml", None)));
        check("pieces", None, Some((FileFormat::Glb, "pieces/vase.glb", Some("pieces"))));
        check("pieces.v2", Some(FileFormat::Mjcf), Some((FileFormat::Mjcf, "pieces.v2/vase.xml", Some("pieces.v2"))));
        check("pieces", Some(FileFormat::Obj), Some((FileFormat::Obj, "pieces", None)));
        check("a.glb", Some(FileFormat::Obj), None);
        check("new/a.glb", None, Some((FileFormat::Glb, "new/a.glb", Some("new"))));
        check("a.glbb", None, None);
        check("/dev/null", None, None);
        check("a.gltf", None, None);
        check("A.STL", Some(FileFormat::Glb), None);
        check("a.xml", Some(FileFormat::Glb), None);
        check("a.obj", Some(FileFormat::Obj), None);
    }
}
