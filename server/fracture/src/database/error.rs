//! Errors of a database file.

use crate::elasticity::ElasticityError;
use crate::lattice::NonManifold;
use std::path::{Path, PathBuf};

/// Reason why a database was not written or not loaded. Other databases are not affected.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum DatabaseError {
    /// The file or folder cannot be opened, read, written or renamed.
    #[error("{path}: {source}", path = .path.display())]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file is not a safetensors container, or is truncated.
    #[error("the file is cut off, or no database (safetensors: {0})")]
    Container(#[from] safetensors::SafeTensorError),
    /// The file was written in another version of the format.
    #[error("the file has format {found}, this program reads {known}: bake it again, or use the program that wrote it")]
    Format {
        /// Version in the file.
        found: String,
        /// Version that this program reads.
        known: &'static str,
    },
    /// The file is a share of a bake.
    #[error("a share of a bake, not a whole database: join the shares with `shatterd merge`")]
    Share,
    /// The file is not a share of a bake.
    #[error("a whole database, not a share of a bake")]
    Whole,
    /// A metadata key is missing or invalid.
    #[error("metadata key \"{key}\": {reason}")]
    Metadata {
        /// The key.
        key: &'static str,
        /// Cause.
        reason: String,
    },
    /// A tensor is not in the file.
    #[error("tensor \"{0}\" is missing")]
    MissingTensor(String),
    /// A tensor has another type or shape than expected.
    #[error("tensor \"{tensor}\": {found} instead of {wanted}")]
    Shape {
        /// Name of the tensor.
        tensor: String,
        /// Type and shape in the file.
        found: String,
        /// Expected type and shape.
        wanted: String,
    },
    /// The bytes differ from those that were written.
    #[error("checksum of \"{0}\" does not match: the file is damaged")]
    Checksum(String),
    /// An index is out of range.
    #[error("tensor \"{tensor}\", entry {index}: {value} is not below {limit}")]
    OutOfRange {
        /// Name of the tensor.
        tensor: String,
        /// Flat index of the entry.
        index: usize,
        /// Value of the entry.
        value: u64,
        /// Exclusive upper limit.
        limit: u64,
    },
    /// An entry is NaN or infinite.
    #[error("tensor \"{tensor}\", entry {index} is not finite")]
    NonFinite {
        /// Name of the tensor.
        tensor: String,
        /// Flat index of the entry.
        index: usize,
    },
    /// An entry that must be positive is not.
    #[error("tensor \"{tensor}\", entry {index}: {value} is out of range")]
    NotPositive {
        /// Name of the tensor.
        tensor: String,
        /// Flat index of the entry.
        index: usize,
        /// Value of the entry.
        value: f64,
    },
    /// An entry has a value that no bake writes.
    #[error("tensor \"{tensor}\", entry {index}: {value:e} is not {wanted}")]
    Implausible {
        /// Name of the tensor.
        tensor: String,
        /// Flat index of the entry.
        index: usize,
        /// Value of the entry, or the length or sum computed from it.
        value: f64,
        /// Description of a valid value.
        wanted: &'static str,
    },
    /// The shares of an elastic tetrahedron do not add up to 1.
    #[error("tensor \"{tensor}\": the shares of tetrahedron {tet} add up to {sum:e}, not to 1")]
    Shares {
        /// Name of the tensor.
        tensor: String,
        /// Index of the elastic tetrahedron.
        tet: usize,
        /// Sum of its shares.
        sum: f64,
    },
    /// The volume of a tetrahedron is not positive.
    #[error("tensor \"{tensor}\": tetrahedron {index} has no positive volume")]
    Folded {
        /// Name of the tensor.
        tensor: String,
        /// Index of the tetrahedron.
        index: usize,
    },
    /// The boundary of a lattice is not a closed 2-manifold, so fragments would not be closed.
    #[error("tensor \"{tensor}\": {source}")]
    Pinched {
        /// Name of the tensor.
        tensor: String,
        /// Position of the defect.
        source: NonManifold,
    },
    /// The file exceeds a maximum, such as those of bodies or nodes.
    #[error("{what}: {found} exceeds the maximum of {cap}")]
    TooLarge {
        /// Name of the quantity.
        what: &'static str,
        /// Value in the file.
        found: usize,
        /// Maximum.
        cap: usize,
    },
    /// The stored lattice cannot be factored.
    #[error("elasticity of body {body}: {source}")]
    Elasticity {
        /// Index of the body.
        body: usize,
        /// Cause.
        source: ElasticityError,
    },
}

impl DatabaseError {
    /// Remedy for a damaged file; `None` for an error of another kind, whose message says what to do.
    pub fn remedy(&self) -> Option<&'static str> {
        match self {
            Self::Io { .. } | Self::Format { .. } | Self::Share | Self::Whole => None,
            _ => Some("if the file is a copy, copy it again; else bake the object again"),
        }
    }

    /// Message about the file `path`, which is named exactly once.
    pub fn of(&self, path: &Path) -> String {
        match self {
            Self::Io { .. } => self.to_string(),
            _ => format!("{}: {self}", path.display()),
        }
    }
}
