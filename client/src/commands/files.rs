//! Where commands write fragments, and in which format.

use super::Failure;
use shatter_client::{Broken, Effect, Impact, Kind, Refusal};
use std::path::{Path, PathBuf};

/// A format of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// One binary glTF file.
    Glb,
    /// A folder of Wavefront OBJ files and a table of masses.
    Obj,
    /// A model for MuJoCo and a folder of meshes beside it.
    Mjcf,
}

/// What `--out` and `--format` say.
#[derive(Debug, PartialEq, Eq)]
pub struct Target {
    format: Format,
    /// The file; of OBJ the folder.
    path: PathBuf,
    /// The folder that is made if it is not there.
    folder: Option<PathBuf>,
}

impl Target {
    /// The ending of a file tells its format; what has neither `.glb` nor `.xml` is a folder, for `object.glb` unless `format` says
    /// otherwise.
    pub fn new(out: &Path, format: Option<Format>, object: &str) -> Result<Self, Failure> {
        let ending = out.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        let told = match ending.as_deref().filter(|_| !out.is_dir()) {
            Some("glb") => Some(Format::Glb),
            Some("xml") => Some(Format::Mjcf),
            Some("obj") => {
                let message = "OBJ files are written into a folder: --out DIR --format obj";
                return Err(Failure::Usage(message.to_owned()));
            }
            Some(other @ ("gltf" | "stl" | "ply" | "fbx" | "dae" | "usd" | "usda" | "usdc" | "usdz")) => {
                let message = format!("no .{other} files are written: --out FILE.glb, FILE.xml or a folder");
                return Err(Failure::Usage(message));
            }
            _ => None,
        };
        if let (Some(told), Some(format)) = (told, format)
            && told != format
        {
            let out = out.display();
            return Err(Failure::Usage(format!("--format and the ending of {out} do not go together")));
        }
        let in_folder = |name: String| (out.join(name), Some(out.to_owned()));
        let format = told.or(format).unwrap_or(Format::Glb);
        let (path, folder) = match (told, format) {
            (Some(_), _) | (None, Format::Obj) => (out.to_owned(), None),
            (None, Format::Glb) => in_folder(format!("{object}.glb")),
            (None, Format::Mjcf) => in_folder(format!("{object}.xml")),
        };
        Ok(Self { format, path, folder })
    }

    /// `impact` with what the format cannot do without, unless it is switched off: welds are bonds, and what collides are hulls.
    pub fn equip(&self, impact: Impact, disable: &[Effect]) -> Impact {
        let wanted = [Effect::Bonds, Effect::Hulls].into_iter();
        let wanted = wanted.filter(|effect| self.format == Format::Mjcf && !disable.contains(effect));
        wanted.fold(impact, Impact::enable)
    }

    /// Writes the fragments; the file, or of OBJ the folder. Nothing for an object that stays whole.
    pub fn write(&self, broken: &Broken) -> Result<Option<PathBuf>, Failure> {
        if broken.is_whole() {
            return Ok(None);
        }
        if let Some(folder) = &self.folder {
            std::fs::create_dir_all(folder).map_err(|error| {
                let at = folder.display().to_string();
                Refusal::new(Kind::Output, at.clone(), format!("cannot create the folder {at}: {error}"))
            })?;
        }
        match self.format {
            Format::Glb => glb(&self.path, broken)?,
            Format::Obj => broken.write_obj(&self.path).map(|_| ())?,
            Format::Mjcf => broken.write_mjcf(&self.path).map(|_| ())?,
        }
        Ok(Some(self.path.clone()))
    }
}

/// Fragments, and hulls and skins beside them if there are any.
fn glb(file: &Path, broken: &Broken) -> Result<(), Refusal> {
    broken.write_glb(file)?;
    if broken.fragments().any(|fragment| fragment.hull().is_some()) {
        broken.write_hulls_glb(&file.with_extension("hulls.glb"))?;
    }
    if broken.fragments().any(|fragment| fragment.skin().is_some()) {
        broken.write_skins_glb(&file.with_extension("skin.glb"))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(out: &str, format: Option<Format>, wanted: Option<(Format, &str, Option<&str>)>) {
        let found = Target::new(Path::new(out), format, "vase").ok();
        let wanted = wanted.map(|(format, path, folder)| Target {
            format,
            path: path.into(),
            folder: folder.map(PathBuf::from),
        });
        assert_eq!(found, wanted, "{out}");
    }

    #[test]
    fn endings_and_formats_say_what_is_written() {
        check("a.glb", None, Some((Format::Glb, "a.glb", None)));
        check("a.GLB", Some(Format::Glb), Some((Format::Glb, "a.GLB", None)));
        check("a.xml", None, Some((Format::Mjcf, "a.xml", None)));
        check("pieces", None, Some((Format::Glb, "pieces/vase.glb", Some("pieces"))));
        check("pieces.v2", Some(Format::Mjcf), Some((Format::Mjcf, "pieces.v2/vase.xml", Some("pieces.v2"))));
        check("pieces", Some(Format::Obj), Some((Format::Obj, "pieces", None)));
        check("a.glb", Some(Format::Obj), None);
        check("a.gltf", None, None);
        check("A.STL", Some(Format::Glb), None);
        check("a.xml", Some(Format::Glb), None);
        check("a.obj", Some(Format::Obj), None);
    }
}
