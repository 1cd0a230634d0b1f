//! Copies of a node's mesh (`EXT_mesh_gpu_instancing`).

use crate::bad_input::BadInput;
use crate::io::gltf_data::accessor::{self, Numbers};
use crate::io::gltf_data::buffers::Buffers;
use glam::{DMat4, DQuat, DVec3};

/// The matrix of each copy, relative to the node; one identity where the node asks for none.
pub(super) fn instances(
    node: &gltf::Node<'_>,
    document: &gltf::Document,
    buffers: &Buffers,
    place: &str,
) -> Result<Vec<DMat4>, BadInput> {
    let Some(extension) = node.extension_value("EXT_mesh_gpu_instancing") else {
        return Ok(vec![DMat4::IDENTITY]);
    };
    let error = |what: String| {
        let at = format!("{place}: node {}", node.index());
        BadInput::new(at, what, "the file is damaged: export it again")
    };
    let attribute = |name: &str| {
        let Some(index) = extension.pointer(&format!("/attributes/{name}")) else {
            return Ok(None);
        };
        let index = index.as_u64().and_then(|i| usize::try_from(i).ok());
        let found = index.and_then(|i| document.accessors().nth(i));
        let missing = || error(format!("{name} of its instances is not there"));
        found.ok_or_else(missing).map(Some)
    };
    // Rotations may be normalised integers by this extension's own word.
    let read3 = |name| -> Result<Option<Vec<[f64; 3]>>, BadInput> {
        let read = |a| accessor::vectors::<3>(&a, buffers, place, Numbers::Core, "instances");
        attribute(name)?.map(read).transpose()
    };
    let read4 = |a| accessor::vectors::<4>(&a, buffers, place, Numbers::Quantized, "instances");
    let (moves, scales) = (read3("TRANSLATION")?, read3("SCALE")?);
    let turns = attribute("ROTATION")?.map(read4).transpose()?;
    let lengths = [
        moves.as_ref().map(Vec::len),
        scales.as_ref().map(Vec::len),
        turns.as_ref().map(Vec::len),
    ];
    let count = lengths.into_iter().flatten().max().unwrap_or(0);
    if lengths.into_iter().flatten().any(|length| length != count) {
        return Err(error(
            "lists of different lengths place its instances".to_owned(),
        ));
    }
    let matrix = |i: usize| {
        let vector = |list: &Option<Vec<[f64; 3]>>, otherwise: DVec3| {
            list.as_ref().map_or(otherwise, |list| DVec3::from(list[i]))
        };
        let turn = turns
            .as_ref()
            .map(|list| DQuat::from_array(list[i]).normalize());
        let matrix = DMat4::from_scale_rotation_translation(
            vector(&scales, DVec3::ONE),
            turn.unwrap_or(DQuat::IDENTITY),
            vector(&moves, DVec3::ZERO),
        );
        let what = || {
            error(format!(
                "instance {i} is not finite, or its rotation is zero"
            ))
        };
        matrix.is_finite().then_some(matrix).ok_or_else(what)
    };
    (0..count).map(matrix).collect()
}
