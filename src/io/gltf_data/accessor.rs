//! Typed arrays out of the buffers of a glTF document.
//!
//! Not by the readers of the `gltf` crate: they take the component type on trust (16-bit positions come back as
//! garbage), stop early without a word where a range wraps around, and ignore sparse values that are out of order.

use super::buffers::Buffers;
use crate::bad_input::BadInput;
use gltf::accessor::sparse::IndexType;
use gltf::accessor::{Accessor, DataType, Dimensions};

/// Elements that an accessor may claim without bytes behind each of them (a sparse one over zeros). More than a mesh of
/// that kind needs, and far from what exhausts the memory.
const MAX_WITHOUT_BYTES: usize = 1 << 22;

/// Which numbers stand for fractions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::io) enum Numbers {
    /// 32-bit floats, and what else the core of glTF allows: unsigned integers of 8 or 16 bits, normalised.
    Core,
    /// Integers of 8 or 16 bits in any form too (`KHR_mesh_quantization`).
    Quantized,
}

/// Vectors with at least `N` components, of which the first `N` are taken; `what` names them for messages.
pub(in crate::io) fn vectors<const N: usize>(
    accessor: &Accessor<'_>,
    buffers: &Buffers,
    place: &str,
    numbers: Numbers,
    what: &str,
) -> Result<Vec<[f64; N]>, BadInput> {
    let (data_type, is_normalized) = (accessor.data_type(), accessor.normalized());
    let is_core = match data_type {
        DataType::F32 => true,
        DataType::U8 | DataType::U16 => is_normalized,
        _ => false,
    };
    let is_small = !matches!(data_type, DataType::F32 | DataType::U32);
    let is_allowed = is_core || (numbers == Numbers::Quantized && is_small);
    let components = components(accessor.dimensions());
    if components < N || !is_allowed {
        let wanted = format!("32-bit floats in VEC{N}");
        return Err(wrong_type(accessor, place, what, &wanted));
    }
    let size = data_type.size();
    let number = |bytes: &[u8]| number(data_type, is_normalized, bytes);
    elements(accessor, buffers, size * components, [0.0; N], &|bytes| {
        std::array::from_fn(|i| number(&bytes[i * size..]))
    })
    .ok_or_else(|| out_of_range(accessor, place))
}

/// A component as a fraction (glTF 2.0, 3.6.2.2: signed ones have two values for −1).
fn number(data_type: DataType, is_normalized: bool, bytes: &[u8]) -> f64 {
    let (value, largest) = match data_type {
        DataType::F32 => return f64::from(float(bytes)),
        DataType::U32 => return f64::from(word(bytes)),
        DataType::U8 => (f64::from(bytes[0]), f64::from(u8::MAX)),
        DataType::U16 => (f64::from(short(bytes)), f64::from(u16::MAX)),
        DataType::I8 => (f64::from(i8::from_le_bytes([bytes[0]])), f64::from(i8::MAX)),
        DataType::I16 => {
            let value = i16::from_le_bytes([bytes[0], bytes[1]]);
            (f64::from(value), f64::from(i16::MAX))
        }
    };
    if is_normalized {
        (value / largest).max(-1.0)
    } else {
        value
    }
}

/// Components of an element; those of smaller matrices are padded, and never read.
fn components(dimensions: Dimensions) -> usize {
    match dimensions {
        Dimensions::Scalar => 1,
        Dimensions::Vec2 => 2,
        Dimensions::Vec3 => 3,
        Dimensions::Vec4 => 4,
        Dimensions::Mat4 => 16,
        Dimensions::Mat2 | Dimensions::Mat3 => 0,
    }
}

/// Indices: unsigned integers of 8, 16 or 32 bits.
pub(in crate::io) fn indices(
    accessor: &Accessor<'_>,
    buffers: &Buffers,
    place: &str,
) -> Result<Vec<u32>, BadInput> {
    let read = match (accessor.data_type(), accessor.dimensions()) {
        (DataType::U8, Dimensions::Scalar) => elements(accessor, buffers, 1, 0, &byte),
        (DataType::U16, Dimensions::Scalar) => elements(accessor, buffers, 2, 0, &short),
        (DataType::U32, Dimensions::Scalar) => elements(accessor, buffers, 4, 0, &word),
        _ => {
            return Err(wrong_type(
                accessor,
                place,
                "indices",
                "unsigned integers in SCALAR",
            ));
        }
    };
    read.ok_or_else(|| out_of_range(accessor, place))
}

/// All elements of `size` bytes, sparse replacements made; `None` when a range leaves its bytes or an index its array.
fn elements<T: Clone>(
    accessor: &Accessor<'_>,
    buffers: &Buffers,
    size: usize,
    zero: T,
    decode: &dyn Fn(&[u8]) -> T,
) -> Option<Vec<T>> {
    let count = accessor.count();
    let mut result: Vec<T> = match accessor.view() {
        Some(view) => {
            let stride = view.stride().unwrap_or(size);
            strided(buffers.view(&view)?, accessor.offset(), stride, count, size)?
                .map(decode)
                .collect()
        }
        None if count <= MAX_WITHOUT_BYTES => vec![zero; count],
        None => return None,
    };
    if let Some(sparse) = accessor.sparse() {
        let (indices, values) = (sparse.indices(), sparse.values());
        let (index_size, index_of): (_, fn(&[u8]) -> u32) = match indices.index_type() {
            IndexType::U8 => (1, byte),
            IndexType::U16 => (2, short),
            IndexType::U32 => (4, word),
        };
        let index_bytes = buffers.view(&indices.view())?;
        let value_bytes = buffers.view(&values.view())?;
        let targets = strided(
            index_bytes,
            indices.offset(),
            index_size,
            sparse.count(),
            index_size,
        )?;
        let replacements = strided(value_bytes, values.offset(), size, sparse.count(), size)?;
        for (target, replacement) in targets.zip(replacements) {
            *result.get_mut(index_of(target) as usize)? = decode(replacement);
        }
    }
    Some(result)
}

/// `count` ≥ 1 pieces of `size` bytes that begin `stride` bytes apart, if all lie within `bytes`.
fn strided(
    bytes: &[u8],
    offset: usize,
    stride: usize,
    count: usize,
    size: usize,
) -> Option<impl Iterator<Item = &[u8]>> {
    if stride < size {
        return None;
    }
    let length = count
        .checked_sub(1)?
        .checked_mul(stride)?
        .checked_add(size)?;
    let bytes = bytes.get(offset..offset.checked_add(length)?)?;
    Some(bytes.chunks(stride).map(move |piece| &piece[..size]))
}

fn byte(bytes: &[u8]) -> u32 {
    u32::from(bytes[0])
}

fn short(bytes: &[u8]) -> u32 {
    u32::from(u16::from_le_bytes([bytes[0], bytes[1]]))
}

fn word(bytes: &[u8]) -> u32 {
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}

fn float(bytes: &[u8]) -> f32 {
    f32::from_bits(word(bytes))
}

fn wrong_type(accessor: &Accessor<'_>, place: &str, what: &str, wanted: &str) -> BadInput {
    BadInput::new(
        format!("{place}: accessor {}", accessor.index()),
        format!(
            "{what} stored as {:?} {:?}, wanted {wanted}",
            accessor.data_type(),
            accessor.dimensions()
        ),
        "export without compression",
    )
}

fn out_of_range(accessor: &Accessor<'_>, place: &str) -> BadInput {
    BadInput::new(
        format!("{place}: accessor {}", accessor.index()),
        format!(
            "its {} elements do not lie within its buffer view",
            accessor.count()
        ),
        "the file is damaged: export it again",
    )
}
