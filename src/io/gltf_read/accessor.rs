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

/// Positions: three 32-bit floats each.
pub(super) fn positions(
    accessor: &Accessor<'_>,
    buffers: &Buffers,
    place: &str,
) -> Result<Vec<[f32; 3]>, BadInput> {
    if (accessor.data_type(), accessor.dimensions()) != (DataType::F32, Dimensions::Vec3) {
        return Err(wrong_type(
            accessor,
            place,
            "positions",
            "32-bit floats in VEC3",
        ));
    }
    elements(accessor, buffers, 12, &|b| {
        [float(b), float(&b[4..]), float(&b[8..])]
    })
    .ok_or_else(|| out_of_range(accessor, place))
}

/// Indices: unsigned integers of 8, 16 or 32 bits.
pub(super) fn indices(
    accessor: &Accessor<'_>,
    buffers: &Buffers,
    place: &str,
) -> Result<Vec<u32>, BadInput> {
    let read = match (accessor.data_type(), accessor.dimensions()) {
        (DataType::U8, Dimensions::Scalar) => elements(accessor, buffers, 1, &byte),
        (DataType::U16, Dimensions::Scalar) => elements(accessor, buffers, 2, &short),
        (DataType::U32, Dimensions::Scalar) => elements(accessor, buffers, 4, &word),
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
fn elements<T: Clone + Default>(
    accessor: &Accessor<'_>,
    buffers: &Buffers,
    size: usize,
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
        None if count <= MAX_WITHOUT_BYTES => vec![T::default(); count],
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
        "export without quantization or compression",
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
