//! glTF accessors, with every range checked.
//!
//! Only the `gltf` crate's description of an accessor is used. Its readers panic or wrap on empty accessors, on ranges
//! that overflow, on strides below the element size, and on short sparse values.

use super::common::{LIMIT, malformed};
use crate::surface::SurfaceError;
use gltf::accessor::sparse::IndexType;
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::buffer::View;

/// Contents of all buffers of a document.
pub(super) struct BufferBytes(pub Vec<Vec<u8>>);

/// Elements of a buffer view, `stride` bytes apart.
struct Window<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl<'a> Window<'a> {
    fn iter(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let (bytes, stride, size) = (self.bytes, self.stride, self.size);
        (0..self.count).map(move |k| &bytes[k * stride..k * stride + size])
    }
}

/// Numbers that are floats, or unsigned whole numbers that stand for 0 to 1.
struct Shares {
    /// Bytes of a number.
    size: usize,
    /// The number with these bits.
    number: fn(u32) -> f32,
}

impl Shares {
    fn of(accessor: &Accessor) -> Result<Self, SurfaceError> {
        let (size, number): (usize, fn(u32) -> f32) = match (accessor.data_type(), accessor.normalized()) {
            (DataType::F32, _) => (4, f32::from_bits),
            (DataType::U8, true) => (1, |bits| bits as f32 / f32::from(u8::MAX)),
            (DataType::U16, true) => (2, |bits| bits as f32 / f32::from(u16::MAX)),
            _ => return Err(wrong(accessor, "its numbers are neither floats nor normalized bytes or 16-bit numbers")),
        };
        Ok(Self { size, number })
    }
}

impl BufferBytes {
    /// Reads positions: three f32 each.
    pub fn positions(&self, accessor: &Accessor) -> Result<Vec<[f32; 3]>, SurfaceError> {
        if (accessor.data_type(), accessor.dimensions()) != (DataType::F32, Dimensions::Vec3) {
            return Err(wrong(accessor, "positions are not three floats"));
        }
        let number = |bytes: &[u8], k: usize| f32::from_bits(little(&bytes[4 * k..4 * k + 4]));
        self.read(accessor, 12, |bytes| [0, 1, 2].map(|k| number(bytes, k)))
    }

    /// Reads texture coordinates, converted from v down (glTF) to v up: two floats each, or bytes or 16-bit numbers that stand for
    /// 0 to 1.
    pub fn uvs(&self, accessor: &Accessor) -> Result<Vec<[f32; 2]>, SurfaceError> {
        if accessor.dimensions() != Dimensions::Vec2 {
            return Err(wrong(accessor, "texture coordinates are not two numbers"));
        }
        let Shares { size, number } = Shares::of(accessor)?;
        let number = |bytes: &[u8], k: usize| number(little(&bytes[size * k..size * (k + 1)]));
        self.read(accessor, 2 * size, |bytes| [number(bytes, 0), 1.0 - number(bytes, 1)])
    }

    /// Reads colors: three or four floats, or bytes or 16-bit numbers that stand for 0 to 1. Missing alpha is 1.
    pub fn colors(&self, accessor: &Accessor) -> Result<Vec<[f32; 4]>, SurfaceError> {
        let channels = match accessor.dimensions() {
            Dimensions::Vec3 => 3,
            Dimensions::Vec4 => 4,
            _ => return Err(wrong(accessor, "colors have neither three nor four channels")),
        };
        let Shares { size, number } = Shares::of(accessor)?;
        let channel = |bytes: &[u8], k: usize| number(little(&bytes[size * k..size * (k + 1)]));
        self.read(accessor, size * channels, |bytes| {
            [0, 1, 2, 3].map(|k| if k < channels { channel(bytes, k) } else { 1.0 })
        })
    }

    /// Reads vertex indices: unsigned scalars.
    pub fn indices(&self, accessor: &Accessor) -> Result<Vec<u32>, SurfaceError> {
        let size = match (accessor.data_type(), accessor.dimensions()) {
            (DataType::U8, Dimensions::Scalar) => 1,
            (DataType::U16, Dimensions::Scalar) => 2,
            (DataType::U32, Dimensions::Scalar) => 4,
            _ => return Err(wrong(accessor, "indices are not unsigned numbers")),
        };
        self.read(accessor, size, little)
    }

    fn read<T: Clone + Default>(
        &self,
        accessor: &Accessor,
        size: usize,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, SurfaceError> {
        let count = accessor.count();
        let mut values = match accessor.view() {
            Some(view) => {
                let window = self.window(&view, accessor.offset(), count, size);
                window.map_err(|reason| wrong(accessor, reason))?.iter().map(&decode).collect()
            }
            // Zeros by definition. The limit keeps a small file from allocating more zeros than it could replace.
            None if count <= LIMIT.min(self.0.iter().map(Vec::len).sum()) => vec![T::default(); count],
            None => return Err(wrong(accessor, "has no data")),
        };
        if let Some(sparse) = accessor.sparse() {
            let size_of_index = match sparse.indices().index_type() {
                IndexType::U8 => 1,
                IndexType::U16 => 2,
                IndexType::U32 => 4,
            };
            let (indices, replacements) = (sparse.indices(), sparse.values());
            let places = self.window(&indices.view(), indices.offset(), sparse.count(), size_of_index);
            let replaced = self.window(&replacements.view(), replacements.offset(), sparse.count(), size);
            let places = places.map_err(|reason| wrong(accessor, reason))?;
            let replaced = replaced.map_err(|reason| wrong(accessor, reason))?;
            for (place, new) in places.iter().zip(replaced.iter()) {
                let value = values.get_mut(little(place) as usize);
                *value.ok_or_else(|| wrong(accessor, "a sparse index is out of bounds"))? = decode(new);
            }
        }
        Ok(values)
    }

    fn window(&self, view: &View, offset: usize, count: usize, size: usize) -> Result<Window<'_>, &'static str> {
        let stride = view.stride().filter(|&stride| stride > 0).unwrap_or(size);
        if stride < size {
            return Err("its stride is smaller than its elements");
        }
        let buffer = self.0.get(view.buffer().index()).ok_or("its buffer does not exist")?;
        let end = view.offset().checked_add(view.length());
        let bytes = end.and_then(|end| buffer.get(view.offset()..end)).ok_or("its view exceeds the buffer")?;
        let length = match count.checked_sub(1) {
            Some(gaps) => gaps.checked_mul(stride).and_then(|length| length.checked_add(size)),
            None => Some(0),
        };
        let end = length.and_then(|length| offset.checked_add(length));
        let bytes = end.and_then(|end| bytes.get(offset..end)).ok_or("it exceeds its view")?;
        Ok(Window { bytes, stride, size, count })
    }
}

fn wrong(accessor: &Accessor, reason: &str) -> SurfaceError {
    malformed("gltf", format!("accessor {}", accessor.index()), reason)
}

fn little(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |number, &byte| number << 8 | u32::from(byte))
}
