//! File container: safetensors with sorted metadata and a checksum per tensor, written atomically.
//!
//! Based on: the safetensors format, version 0.x (little-endian, JSON header, contiguous tensors), through the
//! `safetensors` crate; checksums by BLAKE3.

use super::DatabaseError;
use crate::scene::brief;
use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::Write;
use std::path::Path;

/// Metadata key of the checksums: a JSON object, tensor name → BLAKE3 in hexadecimal.
///
/// The entry [`METADATA_ENTRY`] covers every other metadata key.
pub const CHECKSUMS_KEY: &str = "checksums";

/// Number of columns that marks a tensor with one axis.
pub const FLAT: usize = 0;

/// Entry of the checksums for the metadata.
const METADATA_ENTRY: &str = "__metadata__";

/// Tensors to be written, by name.
#[derive(Default)]
pub struct Tensors(BTreeMap<String, (Dtype, Vec<usize>, Vec<u8>)>);

impl Tensors {
    /// Adds 64-bit floats of the given shape.
    pub fn f64(&mut self, name: String, shape: &[usize], values: &[f64]) {
        self.0.insert(name, (Dtype::F64, shape.to_vec(), little_endian(values, f64::to_le_bytes)));
    }

    /// Adds 32-bit floats of the given shape.
    pub fn f32(&mut self, name: String, shape: &[usize], values: &[f32]) {
        self.0.insert(name, (Dtype::F32, shape.to_vec(), little_endian(values, f32::to_le_bytes)));
    }

    /// Adds 32-bit indices of the given shape.
    pub fn u32(&mut self, name: String, shape: &[usize], values: &[u32]) {
        self.0.insert(name, (Dtype::U32, shape.to_vec(), little_endian(values, u32::to_le_bytes)));
    }
}

fn little_endian<T: Copy, const N: usize>(values: &[T], bytes: fn(T) -> [u8; N]) -> Vec<u8> {
    values.iter().flat_map(|&value| bytes(value)).collect()
}

/// Writes `tensors` and `metadata` to a temporary file and renames it to `path`.
///
/// Readers never see an incomplete file. Equal contents give equal bytes.
pub fn write(path: &Path, tensors: &Tensors, mut metadata: BTreeMap<String, String>) -> Result<(), DatabaseError> {
    let mut checksums: BTreeMap<&str, String> =
        tensors.0.iter().map(|(name, (_, _, bytes))| (name.as_str(), checksum(bytes))).collect();
    checksums.insert(METADATA_ENTRY, metadata_checksum(metadata.iter()));
    metadata.insert(CHECKSUMS_KEY.to_owned(), to_json(&checksums));
    let views = tensors
        .0
        .iter()
        .map(|(name, (dtype, shape, bytes))| Ok((name.as_str(), TensorView::new(*dtype, shape.clone(), bytes)?)))
        .collect::<Result<Vec<_>, safetensors::SafeTensorError>>()?;
    let bytes = sorted_header(safetensors::serialize(views, Some(metadata.into_iter().collect::<HashMap<_, _>>()))?);
    write_aside(path, &bytes).map_err(|source| DatabaseError::Io { path: path.to_owned(), source })
}

/// Sorts the metadata, which the crate writes in the order of a hash map, so that equal objects give equal bytes.
fn sorted_header(bytes: Vec<u8>) -> Vec<u8> {
    let Some((length, rest)) = bytes.split_first_chunk::<8>() else { return bytes };
    let length = u64::from_le_bytes(*length) as usize;
    let Ok(header) = serde_json::from_slice::<BTreeMap<String, serde_json::Value>>(&rest[..length]) else {
        return bytes;
    };
    let mut header = to_json(&header).into_bytes();
    header.resize(header.len().next_multiple_of(8), b' ');
    let mut sorted = (header.len() as u64).to_le_bytes().to_vec();
    sorted.extend(header);
    sorted.extend(&rest[length..]);
    sorted
}

fn to_json<T: serde::Serialize>(map: &BTreeMap<impl AsRef<str> + Ord + serde::Serialize, T>) -> String {
    let entries: serde_json::Map<String, serde_json::Value> = map
        .iter()
        .map(|(key, value)| (key.as_ref().to_owned(), serde_json::to_value(value).unwrap_or(serde_json::Value::Null)))
        .collect();
    serde_json::Value::Object(entries).to_string()
}

/// Writes a temporary file and renames it. A new file gets the default mode; a replaced file's mode is kept.
fn write_aside(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".shatter-").suffix(".part");
    usual_mode(&mut builder);
    let mut aside = builder.tempfile_in(folder)?;
    if let Ok(replaced) = std::fs::metadata(path) {
        aside.as_file().set_permissions(replaced.permissions())?;
    }
    aside.write_all(bytes)?;
    aside.as_file().sync_all()?;
    aside.persist(path).map_err(|error| error.error)?;
    Ok(())
}

/// Sets the default mode of a new file, reduced by the umask; temporary files are private otherwise.
#[cfg(unix)]
fn usual_mode(builder: &mut tempfile::Builder) {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(std::fs::Permissions::from_mode(0o666));
}

/// Without Unix permissions, a new file inherits the rights of its folder.
#[cfg(not(unix))]
fn usual_mode(_: &mut tempfile::Builder) {}

fn checksum(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

pub(super) fn metadata_checksum<'a>(entries: impl Iterator<Item = (&'a String, &'a String)>) -> String {
    let mut hasher = blake3::Hasher::new();
    for (key, value) in entries {
        for text in [key, value] {
            hasher.update(&(text.len() as u64).to_le_bytes()).update(text.as_bytes());
        }
    }
    hasher.finalize().to_hex().to_string()
}

/// A file mapped into memory, from which verified tensors are read.
pub struct MappedFile(memmap2::Mmap);

impl MappedFile {
    /// Maps `path`.
    pub fn open(path: &Path) -> Result<Self, DatabaseError> {
        let io = |source| DatabaseError::Io { path: path.to_owned(), source };
        // Checked before opening, because opening a pipe waits for a writer.
        if !std::fs::metadata(path).map_err(io)?.is_file() {
            return Err(io(std::io::Error::new(std::io::ErrorKind::InvalidInput, "not a regular file")));
        }
        let file = File::open(path).map_err(io)?;
        // SAFETY: the map is read-only and private to this process. Databases are replaced by rename and never
        // rewritten in place, and the guide declares that everyone with write access to the folder is trusted.
        unsafe { memmap2::Mmap::map(&file) }.map(Self).map_err(io)
    }

    /// Parses the header. Verifies only offsets and sizes against the file.
    pub fn parse(&self) -> Result<ContainerContents<'_>, DatabaseError> {
        let (_, header) = SafeTensors::read_metadata(&self.0)?;
        let metadata: BTreeMap<String, String> = header.metadata().clone().unwrap_or_default().into_iter().collect();
        Ok(ContainerContents { tensors: SafeTensors::deserialize(&self.0)?, metadata })
    }
}

/// Contents of a container.
pub struct ContainerContents<'a> {
    tensors: SafeTensors<'a>,
    /// All metadata.
    pub metadata: BTreeMap<String, String>,
}

impl ContainerContents<'_> {
    /// True if there is a tensor of the given name.
    pub fn holds(&self, name: &str) -> bool {
        self.tensors.tensor(name).is_ok()
    }

    /// Rows of the tensor `name`; 0 if there is no such tensor.
    pub fn rows(&self, name: &str) -> usize {
        self.tensors.tensor(name).ok().and_then(|view| view.shape().first().copied()).unwrap_or(0)
    }

    /// Name and length in bytes of every tensor.
    pub fn lengths(&self) -> Vec<(String, u64)> {
        self.tensors.tensors().into_iter().map(|(name, view)| (name, view.data().len() as u64)).collect()
    }

    /// A metadata value.
    pub fn text(&self, key: &'static str) -> Result<&str, DatabaseError> {
        let missing = || DatabaseError::Metadata { key, reason: "missing".to_owned() };
        self.metadata.get(key).map(String::as_str).ok_or_else(missing)
    }

    /// A metadata value in JSON.
    pub fn json<T: serde::de::DeserializeOwned>(&self, key: &'static str) -> Result<T, DatabaseError> {
        serde_json::from_str(self.text(key)?)
            .map_err(|error| DatabaseError::Metadata { key, reason: brief(&error.to_string()) })
    }

    /// The stored checksum of every tensor.
    pub fn checksums(&self) -> Result<BTreeMap<String, String>, DatabaseError> {
        self.json(CHECKSUMS_KEY)
    }

    /// Compares the metadata, and every tensor that is wanted, with its checksum.
    pub fn verify(&self, want: impl Fn(&str) -> bool) -> Result<(), DatabaseError> {
        let stored = self.checksums()?;
        let expect = |name: &str, found: String| match stored.get(name) {
            Some(wanted) if *wanted == found => Ok(()),
            _ => Err(DatabaseError::Checksum(name.to_owned())),
        };
        expect(METADATA_ENTRY, metadata_checksum(self.metadata.iter().filter(|(key, _)| *key != CHECKSUMS_KEY)))?;
        for (name, view) in self.tensors.tensors().into_iter().filter(|(name, _)| want(name)) {
            expect(&name, checksum(view.data()))?;
        }
        Ok(())
    }

    /// Finite 64-bit floats with `columns` columns, or [`FLAT`]. The number of rows must be `rows` if given.
    pub fn f64(&self, name: &str, rows: Option<usize>, columns: usize) -> Result<Vec<f64>, DatabaseError> {
        let values = self.typed(name, Dtype::F64, rows, columns, f64::from_le_bytes)?;
        match values.iter().position(|value| !value.is_finite()) {
            Some(index) => Err(DatabaseError::NonFinite { tensor: name.to_owned(), index }),
            None => Ok(values),
        }
    }

    /// Number of columns, and finite 32-bit floats in `rows` rows.
    pub fn f32(&self, name: &str, rows: usize) -> Result<(usize, Vec<f32>), DatabaseError> {
        let columns = self.tensors.tensor(name).ok().and_then(|view| view.shape().get(1).copied()).unwrap_or(1);
        let values = self.typed(name, Dtype::F32, Some(rows), columns.max(1), f32::from_le_bytes)?;
        match values.iter().position(|value| !value.is_finite()) {
            Some(index) => Err(DatabaseError::NonFinite { tensor: name.to_owned(), index }),
            None => Ok((columns, values)),
        }
    }

    /// 32-bit indices below `limit`, with `columns` columns, or [`FLAT`].
    pub fn u32(&self, name: &str, rows: Option<usize>, columns: usize, limit: u64) -> Result<Vec<u32>, DatabaseError> {
        let values = self.typed(name, Dtype::U32, rows, columns, u32::from_le_bytes)?;
        match values.iter().position(|&value| u64::from(value) >= limit) {
            Some(index) => Err(DatabaseError::OutOfRange {
                tensor: name.to_owned(),
                index,
                value: u64::from(values[index]),
                limit,
            }),
            None => Ok(values),
        }
    }

    fn typed<T, const N: usize>(
        &self,
        name: &str,
        dtype: Dtype,
        rows: Option<usize>,
        columns: usize,
        read: fn([u8; N]) -> T,
    ) -> Result<Vec<T>, DatabaseError> {
        let view = self.tensors.tensor(name).map_err(|_| DatabaseError::MissingTensor(name.to_owned()))?;
        let shape = view.shape();
        let fits = view.dtype() == dtype
            && match columns {
                FLAT => shape.len() == 1,
                _ => shape.len() == 2 && shape[1] == columns,
            }
            && rows.is_none_or(|rows| shape[0] == rows);
        if !fits {
            return Err(DatabaseError::Shape {
                tensor: name.to_owned(),
                found: format!("{:?} {shape:?}", view.dtype()),
                wanted: format!("{dtype:?} [{}, {columns}]", rows.map_or("any".to_owned(), |rows| rows.to_string())),
            });
        }
        let (chunks, _) = view.data().as_chunks::<N>();
        Ok(chunks.iter().map(|bytes| read(*bytes)).collect())
    }
}
