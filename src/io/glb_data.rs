//! Numbers out of the buffer of a binary glTF, trusting nothing that its JSON says about it.

use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::Source;

/// Float or normalised vectors with `N` components or more; what is beyond the `N`th is dropped. All are finite.
pub(super) fn vectors<const N: usize>(
    accessor: &gltf::Accessor<'_>,
    buffer: &[u8],
) -> Result<Vec<[f64; N]>, String> {
    let found = components(accessor.dimensions());
    if found < N {
        return Err(format!("has {found} components where {N} are needed"));
    }
    let size = accessor.data_type().size();
    let read = match (accessor.data_type(), accessor.normalized()) {
        (DataType::F32, _) => |b: &[u8]| f64::from(f32::from_bits(little_endian(b))),
        (DataType::U8, true) => |b: &[u8]| f64::from(little_endian(b)) / 255.0,
        (DataType::U16, true) => |b: &[u8]| f64::from(little_endian(b)) / 65535.0,
        (other, _) => return Err(format!("is of the type {other:?}, which is not a float")),
    };
    let mut vectors = Vec::new();
    for element in elements(accessor, buffer)? {
        let vector: [f64; N] = std::array::from_fn(|i| read(&element[i * size..][..size]));
        if !vector.iter().all(|x| x.is_finite()) {
            return Err(format!("holds a number that is not finite: {vector:?}"));
        }
        vectors.push(vector);
    }
    Ok(vectors)
}

/// Unsigned integers, all below `limit`.
pub(super) fn indices(
    accessor: &gltf::Accessor<'_>,
    buffer: &[u8],
    limit: usize,
) -> Result<Vec<u32>, String> {
    let is_index = matches!(
        accessor.data_type(),
        DataType::U8 | DataType::U16 | DataType::U32
    );
    if !is_index || accessor.dimensions() != Dimensions::Scalar {
        return Err(String::from("holds no unsigned integers"));
    }
    let size = accessor.data_type().size();
    let mut indices = Vec::new();
    for element in elements(accessor, buffer)? {
        let index = little_endian(&element[..size]);
        if index as usize >= limit {
            return Err(format!("names vertex {index} of {limit}"));
        }
        indices.push(index);
    }
    Ok(indices)
}

/// The bytes of each element, every one as long as type and dimensions ask.
fn elements<'a>(
    accessor: &gltf::Accessor<'_>,
    buffer: &'a [u8],
) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, String> {
    let outside = || String::from("reaches beyond the data of the file");
    let (None, Some(view)) = (accessor.sparse(), accessor.view()) else {
        return Err(String::from("is sparse or has no data"));
    };
    if view.buffer().index() != 0 || !matches!(view.buffer().source(), Source::Bin) {
        return Err(String::from("lies in another file"));
    }
    let view_end = view.offset().checked_add(view.length());
    let data = view_end
        .and_then(|end| buffer.get(view.offset()..end))
        .and_then(|data| data.get(accessor.offset()..))
        .ok_or_else(outside)?;

    let size = components(accessor.dimensions()) * accessor.data_type().size();
    let (count, stride) = (accessor.count(), view.stride().unwrap_or(size));
    if stride < size {
        return Err(format!(
            "puts elements of {size} bytes {stride} bytes apart"
        ));
    }
    let needed = match count {
        0 => Some(0),
        _ => stride
            .checked_mul(count - 1)
            .and_then(|n| n.checked_add(size)),
    };
    if needed.is_none_or(|needed| needed > data.len()) {
        return Err(outside());
    }
    Ok((0..count).map(move |i| &data[i * stride..][..size]))
}

/// The unsigned integer in one to four bytes.
fn little_endian(bytes: &[u8]) -> u32 {
    bytes
        .iter()
        .rev()
        .fold(0, |n, &byte| n << 8 | u32::from(byte))
}

fn components(dimensions: Dimensions) -> usize {
    match dimensions {
        Dimensions::Scalar => 1,
        Dimensions::Vec2 => 2,
        Dimensions::Vec3 => 3,
        // Matrices in glTF pad their columns; none is ever read, so only the order of magnitude matters.
        Dimensions::Vec4 | Dimensions::Mat2 => 4,
        Dimensions::Mat3 => 9,
        Dimensions::Mat4 => 16,
    }
}
