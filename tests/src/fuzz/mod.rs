//! Fuzz targets: every reader of foreign bytes. An input may be refused; it must cause neither a panic nor an incomplete object.
//!
//! `tests/tests/fuzz.rs` runs the seeds, the inputs that once failed and a few mutations of both in every test run; `tests/fuzz/run`
//! mutates for minutes, guided by coverage.

mod database;
mod mesh;
mod mutate;
mod request;
mod text;

pub use mutate::mutated;

use std::path::{Path, PathBuf};

/// A reader of foreign bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FuzzTarget {
    /// Mesh files, up to the mended surface. The first byte chooses the format.
    Mesh,
    /// Database files, up to the fragments. The first byte chooses between bytes of a file and changes of a valid one.
    Database,
    /// Messages in shared memory: requests, questions, replies and results. The first byte chooses.
    Request,
    /// The daemon's configuration and the materials. The first byte chooses.
    Toml,
    /// Scene files.
    Scene,
}

impl FuzzTarget {
    /// All targets.
    pub const ALL: [Self; 5] = [Self::Mesh, Self::Database, Self::Request, Self::Toml, Self::Scene];

    /// Name in folders and commands.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mesh => "mesh",
            Self::Database => "database",
            Self::Request => "request",
            Self::Toml => "toml",
            Self::Scene => "scene",
        }
    }

    /// Valid inputs to start from, one for each kind of content.
    pub fn seeds(self) -> Vec<Vec<u8>> {
        match self {
            Self::Mesh => mesh::seeds(),
            Self::Database => database::seeds(),
            Self::Request => request::seeds(),
            Self::Toml => text::toml_seeds(),
            Self::Scene => text::scene_seeds(),
        }
    }

    /// Reads the input, and returns true if there was no error.
    ///
    /// # Panics
    /// If the result of the input violates an invariant: a defect.
    pub fn run(self, input: &[u8]) -> bool {
        match self {
            Self::Mesh => mesh::run(input),
            Self::Database => database::run(input),
            Self::Request => request::run(input),
            Self::Toml => text::toml(input),
            Self::Scene => text::scene(input),
        }
    }

    /// Inputs that once failed, by file name.
    ///
    /// # Errors
    /// A folder or file that cannot be read.
    pub fn regressions(self) -> std::io::Result<Vec<(PathBuf, Vec<u8>)>> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/regressions").join(self.name());
        let Ok(entries) = std::fs::read_dir(folder) else { return Ok(Vec::new()) };
        let mut paths = entries.map(|entry| Ok(entry?.path())).collect::<std::io::Result<Vec<_>>>()?;
        paths.sort();
        paths.into_iter().map(|path| std::fs::read(&path).map(|bytes| (path, bytes))).collect()
    }

    /// Writes the seeds and the regressions into `folder`, the corpus at the start of a long run.
    ///
    /// # Errors
    /// A folder or file that cannot be written.
    pub fn write_corpus(self, folder: &Path) -> std::io::Result<()> {
        std::fs::create_dir_all(folder)?;
        let known = self.regressions()?.into_iter().map(|(_, bytes)| bytes);
        for (index, bytes) in self.seeds().into_iter().chain(known).enumerate() {
            std::fs::write(folder.join(format!("seed-{index}")), bytes)?;
        }
        Ok(())
    }
}

/// Writes the corpus of a long run into the folder that `SHATTER_FUZZ_CORPUS` names, if it is set.
///
/// # Panics
/// If a file cannot be read or written.
pub fn prepare(target: FuzzTarget) {
    if let Some(folder) = std::env::var_os("SHATTER_FUZZ_CORPUS") {
        target.write_corpus(Path::new(&folder)).expect("a corpus that can be written");
    }
}

/// The first byte, modulo `count`, and the rest.
fn choice(input: &[u8], count: u8) -> Option<(u8, &[u8])> {
    input.split_first().map(|(first, rest)| (first % count, rest))
}

/// A seed: the byte that chooses, then the content.
fn seed(choice: u8, content: impl AsRef<[u8]>) -> Vec<u8> {
    [&[choice], content.as_ref()].concat()
}
