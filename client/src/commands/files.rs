//! Where commands write fragments, and in which format.

use super::Failure;
use shatter_client::{Broken, Effect, Impact, Kind, Refusal};
use shatter_proto::name::nearest;
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
            Some(other) if !out.is_dir() => {
                if let Some(likely) = nearest(other, &["glb", "xml"]).first() {
                    let message = format!(
                        "no .{other} files are written; did you mean {}?",
                        out.with_extension(likely).display()
                    );
                    return Err(Failure::Usage(message));
                }
                None
            }
            _ => None,
        };
        if told.is_none() && out.exists() && !out.is_dir() {
            let message = format!("{} is no folder, and its name ends neither with .glb nor with .xml", out.display());
            return Err(Failure::Usage(message));
        }
        if let (Some(told), Some(format)) = (told, format)
            && told != format
        {
            let out = out.display();
            return Err(Failure::Usage(format!("--format and the ending of {out} do not go together")));
        }
        let in_folder = |name: String| (out.join(name), Some(out.to_owned()));
        let format = told.or(format).unwrap_or(Format::Glb);
        let (path, folder) = match (told, format) {
            (Some(_), _) => {
                (out.to_owned(), out.parent().filter(|parent| !parent.as_os_str().is_empty()).map(Path::to_owned))
            }
            (None, Format::Obj) => (out.to_owned(), None),
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

    /// Writes the fragments; all files, or the folder of many, the main one first. Nothing for an object that stays whole.
    pub fn write(&self, broken: &Broken) -> Result<Vec<PathBuf>, Failure> {
        if broken.is_whole() {
            return Ok(Vec::new());
        }
        if let Some(folder) = &self.folder {
            std::fs::create_dir_all(folder).map_err(|error| {
                let at = folder.display().to_string();
                Refusal::new(Kind::Output, at.clone(), format!("cannot create the folder {at}: {error}"))
            })?;
        }
        match self.format {
            Format::Glb => Ok(glb(&self.path, broken)?),
            Format::Obj => {
                broken.write_obj(&self.path)?;
                Ok(vec![self.path.clone()])
            }
            Format::Mjcf => {
                broken.write_mjcf(&self.path)?;
                let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
                Ok(vec![self.path.clone(), self.path.with_file_name(format!("{stem}_assets"))])
            }
        }
    }
}

/// Fragments, and hulls and skins beside them if there are any.
fn glb(file: &Path, broken: &Broken) -> Result<Vec<PathBuf>, Refusal> {
    let mut files = vec![file.to_owned()];
    broken.write_glb(file)?;
    if broken.fragments().any(|fragment| fragment.hull().is_some()) {
        files.push(file.with_extension("hulls.glb"));
        broken.write_hulls_glb(&file.with_extension("hulls.glb"))?;
    }
    if broken.fragments().any(|fragment| fragment.skin().is_some()) {
        files.push(file.with_extension("skin.glb"));
        broken.write_skins_glb(&file.with_extension("skin.glb"))?;
    }
    Ok(files)
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
        check("new/a.glb", None, Some((Format::Glb, "new/a.glb", Some("new"))));
        check("a.glbb", None, None);
        check("/dev/null", None, None);
        check("a.gltf", None, None);
        check("A.STL", Some(Format::Glb), None);
        check("a.xml", Some(Format::Glb), None);
        check("a.obj", Some(Format::Obj), None);
    }
}
