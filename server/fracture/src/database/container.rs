//! File container: safetensors with sorted metadata and a checksum per tensor, written atomically.
//!
//! Based on: the safetensors format, version 0.x (little-endian, JSON header, contiguous tensors), through the
//! `safetensors` crate; checksums by BLAKE3.

use super::DatabaseError;
use crate::scene::brief;
use safetensors::tensor::{Metadata, TensorInfo, TensorView};
use safetensors::{Dtype, SafeTensorError};
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Metadata key of the checksums: a JSON object, tensor name → BLAKE3 in hexadecimal.
///
/// The entry [`METADATA_ENTRY`] covers every other metadata key.
pub const CHECKSUMS_KEY: &str = "checksums";

/// Number of columns that marks a tensor with one axis.
pub const FLAT: usize = 0;

/// Bytes of the length of the header, at the beginning of a file.
const LENGTH_BYTES: usize = 8;

/// Longest header, bytes: the limit of the `safetensors` crate.
const HEADER_BYTES_MAX: u64 = 100_000_000;

/// Copies of the tensors that fit into memory while a file is read: the verified bytes, the values, and one to spare.
const COPIES: u64 = 3;

/// Entry of the checksums that covers the metadata.
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

    /// Adds bytes of the given shape.
    pub fn u8(&mut self, name: String, shape: &[usize], values: &[u8]) {
        self.0.insert(name, (Dtype::U8, shape.to_vec(), values.to_vec()));
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

/// Memory that the system can give to a program, bytes; `None` if it does not report that.
fn available_bytes() -> Option<u64> {
    let report = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = report.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(line.trim().strip_suffix(" kB")?.parse::<u64>().ok()? << 10)
}

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

/// Contents of a container.
///
/// Verification copies the tensors, so later reads return verified bytes. A file that is truncated or rewritten meanwhile is an
/// error; with a memory map it would end the process with SIGBUS.
pub struct ContainerContents {
    path: PathBuf,
    file: File,
    /// Offset of the tensors in the file, bytes.
    data: u64,
    header: Metadata,
    /// The bytes of the verified tensors.
    verified: BTreeMap<String, Vec<u8>>,
    /// All metadata.
    pub metadata: BTreeMap<String, String>,
}

impl ContainerContents {
    /// Reads the header of `path`. Verifies only offsets and sizes against the file.
    pub fn open(path: &Path) -> Result<Self, DatabaseError> {
        let io = |source| DatabaseError::Io { path: path.to_owned(), source };
        // Checked before opening, because opening a pipe waits for a writer.
        if !std::fs::metadata(path).map_err(io)?.is_file() {
            return Err(io(std::io::Error::new(std::io::ErrorKind::InvalidInput, "not a regular file")));
        }
        let mut file = File::open(path).map_err(io)?;
        let file_bytes = file.metadata().map_err(io)?.len();
        let mut length = [0; LENGTH_BYTES];
        file.read_exact(&mut length).map_err(|_| SafeTensorError::HeaderTooSmall)?;
        let length = u64::from_le_bytes(length);
        if length > HEADER_BYTES_MAX {
            return Err(SafeTensorError::HeaderTooLarge.into());
        }
        let data = LENGTH_BYTES as u64 + length;
        if data > file_bytes {
            return Err(SafeTensorError::InvalidHeaderLength.into());
        }
        let mut text = vec![0; length as usize];
        file.read_exact(&mut text).map_err(io)?;
        let header: Metadata = serde_json::from_slice(&text).map_err(SafeTensorError::InvalidHeaderDeserialization)?;
        if data.checked_add(header.data_len() as u64) != Some(file_bytes) {
            return Err(SafeTensorError::MetadataIncompleteBuffer.into());
        }
        let metadata = header.metadata().clone().unwrap_or_default().into_iter().collect();
        Ok(Self { path: path.to_owned(), file, data, header, verified: BTreeMap::new(), metadata })
    }

    /// True if there is a tensor of the given name.
    pub fn holds(&self, name: &str) -> bool {
        self.header.info(name).is_some()
    }

    /// Rows of the tensor `name`; 0 if there is no such tensor.
    pub fn rows(&self, name: &str) -> usize {
        self.header.info(name).and_then(|info| info.shape.first().copied()).unwrap_or(0)
    }

    /// Name and length in bytes of every tensor.
    pub fn lengths(&self) -> Vec<(String, u64)> {
        let bytes = |info: &TensorInfo| (info.data_offsets.1 - info.data_offsets.0) as u64;
        self.header.tensors().into_iter().map(|(name, info)| (name, bytes(info))).collect()
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

    /// Compares the metadata, and every tensor that is wanted, with its checksum. Other tensors cannot be read afterwards.
    pub fn verify(&mut self, want: impl Fn(&str) -> bool) -> Result<(), DatabaseError> {
        let stored = self.checksums()?;
        let expect = |name: &str, found: String| match stored.get(name) {
            Some(wanted) if *wanted == found => Ok(()),
            _ => Err(DatabaseError::Checksum(name.to_owned())),
        };
        expect(METADATA_ENTRY, metadata_checksum(self.metadata.iter().filter(|(key, _)| *key != CHECKSUMS_KEY)))?;
        let wanted: Vec<String> = self.header.offset_keys().into_iter().filter(|name| want(name)).collect();
        let length: u64 = wanted.iter().map(|name| self.range(name).1 as u64).sum();
        if available_bytes().is_some_and(|available| available / COPIES < length) {
            return Err(self.io(io::ErrorKind::OutOfMemory.into()));
        }
        for name in wanted {
            // Before memory is reserved: a sparse file may claim any length.
            expect(&name, self.checksum_in_file(&name).map_err(|source| self.io(source))?)?;
            let bytes = self.bytes(&name).map_err(|source| self.io(source))?;
            expect(&name, checksum(&bytes))?;
            self.verified.insert(name, bytes);
        }
        Ok(())
    }

    fn io(&self, source: io::Error) -> DatabaseError {
        DatabaseError::Io { path: self.path.clone(), source }
    }

    /// First byte in the file and length of the tensor `name`.
    fn range(&self, name: &str) -> (u64, usize) {
        let (first, end) = self.header.info(name).map_or((0, 0), |info| info.data_offsets);
        (self.data + first as u64, end - first)
    }

    /// Checksum of the tensor `name`, computed in parts.
    fn checksum_in_file(&mut self, name: &str) -> io::Result<String> {
        let (first, length) = self.range(name);
        self.file.seek(SeekFrom::Start(first))?;
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader((&mut self.file).take(length as u64))?;
        if hasher.count() < length as u64 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        Ok(hasher.finalize().to_hex().to_string())
    }

    /// Reads the tensor `name` from the file.
    fn bytes(&mut self, name: &str) -> io::Result<Vec<u8>> {
        let (first, length) = self.range(name);
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(length).map_err(|_| io::ErrorKind::OutOfMemory)?;
        self.file.seek(SeekFrom::Start(first))?;
        bytes.resize(length, 0);
        self.file.read_exact(&mut bytes)?;
        Ok(bytes)
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
        let columns = self.header.info(name).and_then(|info| info.shape.get(1).copied()).unwrap_or(1);
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

    /// Bytes in `rows` rows of `columns` columns.
    pub fn u8(&self, name: &str, rows: usize, columns: usize) -> Result<Vec<u8>, DatabaseError> {
        self.typed(name, Dtype::U8, Some(rows), columns, u8::from_le_bytes)
    }

    fn typed<T, const N: usize>(
        &self,
        name: &str,
        dtype: Dtype,
        rows: Option<usize>,
        columns: usize,
        read: fn([u8; N]) -> T,
    ) -> Result<Vec<T>, DatabaseError> {
        let found = self.header.info(name).zip(self.verified.get(name));
        let (info, bytes) = found.ok_or_else(|| DatabaseError::MissingTensor(name.to_owned()))?;
        let shape = &info.shape;
        let fits = info.dtype == dtype
            && match columns {
                FLAT => shape.len() == 1,
                _ => shape.len() == 2 && shape[1] == columns,
            }
            && rows.is_none_or(|rows| shape[0] == rows);
        if !fits {
            let rows = rows.map_or("any".to_owned(), |rows| rows.to_string());
            let wanted = if columns == FLAT { rows } else { format!("{rows}, {columns}") };
            return Err(DatabaseError::Shape {
                tensor: name.to_owned(),
                found: format!("{:?} {shape:?}", info.dtype),
                wanted: format!("{dtype:?} [{wanted}]"),
            });
        }
        let (chunks, _) = bytes.as_chunks::<N>();
        Ok(chunks.iter().map(|bytes| read(*bytes)).collect())
    }
}
