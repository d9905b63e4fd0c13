//! What can be wrong with a database file.

use crate::elasticity::ElasticityError;
use crate::lattice::NonManifold;
use std::path::{Path, PathBuf};

/// Why a database was not written or not loaded. A refused file harms no other.
#[derive(Debug, thiserror::Error)]
pub enum DatabaseError {
    /// The file or folder cannot be opened, read, written or renamed.
    #[error("{path}: {source}", path = .path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Not a safetensors container, or cut short.
    #[error("not a complete safetensors container: {0}")]
    Container(#[from] safetensors::SafeTensorError),
    /// Written by another version of the format.
    #[error("format {found}, this program reads {known}: bake it again, or use the program that wrote it")]
    Format {
        /// What the file says.
        found: String,
        /// What this program reads.
        known: &'static str,
    },
    /// A share of a bake.
    #[error("a share of a bake, not a whole database: join the shares with `shatterd merge`")]
    Share,
    /// No share of a bake.
    #[error("a whole database, not a share of a bake")]
    Whole,
    /// A metadata key is missing or is not what it should be.
    #[error("metadata key \"{key}\": {reason}")]
    Metadata {
        /// The key.
        key: &'static str,
        /// What is wrong with it.
        reason: String,
    },
    /// A tensor is not in the file.
    #[error("tensor \"{0}\" is missing")]
    MissingTensor(String),
    /// A tensor has another type or shape than its place wants.
    #[error("tensor \"{tensor}\": {found}, wanted {wanted}")]
    Shape {
        /// Which tensor.
        tensor: String,
        /// Type and shape in the file.
        found: String,
        /// Type and shape wanted.
        wanted: String,
    },
    /// The bytes are not those that were written.
    #[error("checksum of \"{0}\" does not match: the file is damaged")]
    Checksum(String),
    /// An entry points outside what it indexes.
    #[error("tensor \"{tensor}\", entry {index}: {value} is not below {limit}")]
    OutOfRange {
        /// Which tensor.
        tensor: String,
        /// Flat position of the entry.
        index: usize,
        /// What it holds.
        value: u64,
        /// What it must stay below.
        limit: u64,
    },
    /// An entry is NaN or infinite.
    #[error("tensor \"{tensor}\", entry {index} is not finite")]
    NonFinite {
        /// Which tensor.
        tensor: String,
        /// Flat position of the entry.
        index: usize,
    },
    /// An entry must be positive and is not.
    #[error("tensor \"{tensor}\", entry {index}: {value} is out of range")]
    NotPositive {
        /// Which tensor.
        tensor: String,
        /// Flat position of the entry.
        index: usize,
        /// What it is.
        value: f64,
    },
    /// An entry that no bake writes.
    #[error("tensor \"{tensor}\", entry {index}: {value:e} is not {wanted}")]
    Implausible {
        /// Which tensor.
        tensor: String,
        /// Flat position of the entry.
        index: usize,
        /// What it is, or the length or sum that it leads to.
        value: f64,
        /// What it should be.
        wanted: &'static str,
    },
    /// Shares of an elastic tetrahedron that do not add up to one.
    #[error("tensor \"{tensor}\": the shares of tetrahedron {tet} add up to {sum:e}, not to 1")]
    Shares {
        /// Which tensor.
        tensor: String,
        /// Which elastic tetrahedron.
        tet: usize,
        /// What they add up to.
        sum: f64,
    },
    /// A tetrahedron has no positive volume.
    #[error("tensor \"{tensor}\": tetrahedron {index} has no positive volume")]
    Folded {
        /// Which tensor.
        tensor: String,
        /// Which tetrahedron.
        index: usize,
    },
    /// The boundary of a lattice is no closed 2-manifold: fragments would not be closed.
    #[error("tensor \"{tensor}\": {source}")]
    Pinched {
        /// Which tensor.
        tensor: String,
        /// Where.
        source: NonManifold,
    },
    /// More bodies or nodes than an object may have.
    #[error("{what}: {found} is beyond the cap of {cap}")]
    TooLarge {
        /// What there is too much of.
        what: &'static str,
        /// How much the file says.
        found: usize,
        /// The cap.
        cap: usize,
    },
    /// The stored lattice cannot be factored.
    #[error("elasticity of body {body}: {source}")]
    Elasticity {
        /// Which body.
        body: usize,
        /// What the factorisation said.
        source: ElasticityError,
    },
}

impl DatabaseError {
    /// What is wrong with the file `path`, which is named once.
    pub fn of(&self, path: &Path) -> String {
        match self {
            Self::Io { .. } => self.to_string(),
            _ => format!("{}: {self}", path.display()),
        }
    }
}
