//! A glTF document whose references lead somewhere.
//!
//! The `gltf` crate checks most of a document itself, but its own checks and accessors index out of range on some broken
//! ones. What they rely on is checked here, before and after.

use crate::bad_input::BadInput;
use gltf::json;
use json::accessor::ComponentType;
use json::validation::Checked;

/// Extensions that a file may require: those whose data are used, and materials' whose loss leaves a diffuse surface.
const READ_EXTENSIONS: [&str; 19] = [
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
];

/// Length of the header of a GLB, bytes.
const HEADER_LENGTH: usize = 12;

/// The document in a `.gltf` or `.glb` file, and the binary chunk.
pub(in crate::io) fn parse(
    bytes: &[u8],
    place: &str,
) -> Result<(gltf::Document, Option<Vec<u8>>), BadInput> {
    check_header(bytes, place)?;
    let gltf = gltf::Gltf::from_slice_without_validation(bytes).map_err(|e| invalid(place, &e))?;
    let mut root = gltf.document.into_json();
    // Ahead of the crate's checks, which would name the extension last among the consequences of not knowing it.
    let unknown: Vec<&str> = root
        .extensions_required
        .iter()
        .map(String::as_str)
        .filter(|name| !READ_EXTENSIONS.contains(name))
        .collect();
    if !unknown.is_empty() {
        return Err(BadInput::new(
            place,
            format!("requires {}, which is not supported", unknown.join(", ")),
            "export without compression and other required extensions",
        ));
    }
    root.extensions_required.clear();
    if let Some(mistake) = first_mistake(&root) {
        return Err(BadInput::new(
            place,
            format!("invalid glTF: {mistake}"),
            "export the file again",
        ));
    }
    let document = gltf::Document::from_json(root).map_err(|e| invalid(place, &e))?;
    Ok((document, gltf.blob))
}

/// Refuses a GLB header that promises less than itself or more than there is.
fn check_header(bytes: &[u8], place: &str) -> Result<(), BadInput> {
    if !bytes.starts_with(b"glTF") {
        return Ok(());
    }
    let length = bytes.get(8..HEADER_LENGTH).map(|b| {
        let bytes = [b[0], b[1], b[2], b[3]];
        u32::from_le_bytes(bytes) as usize
    });
    match length {
        Some(length) if (HEADER_LENGTH..=bytes.len()).contains(&length) => Ok(()),
        _ => Err(BadInput::new(
            place,
            format!(
                "its header promises {} bytes, and there are {}",
                length.unwrap_or(HEADER_LENGTH),
                bytes.len()
            ),
            "the file was cut off: copy or export it again",
        )),
    }
}

fn invalid(place: &str, error: &gltf::Error) -> BadInput {
    let what = match error {
        gltf::Error::Validation(mistakes) => match &mistakes[..] {
            [(path, first)] => format!("invalid glTF: {path}: {first}"),
            [(path, first), others @ ..] => {
                format!("invalid glTF: {path}: {first} (and {} more)", others.len())
            }
            [] => "invalid glTF".to_owned(),
        },
        other => format!("cannot be read as glTF 2.0: {other}"),
    };
    BadInput::new(place, what, "export the file again")
}

/// The first thing that the `gltf` crate would stumble over, as a JSON path and what is wrong there.
fn first_mistake(root: &json::Root) -> Option<String> {
    positions(root)
        .or_else(|| sparse_indices(root))
        .or_else(|| cameras(root))
        .or_else(|| lights(root))
        .or_else(|| images(root))
}

fn positions(root: &json::Root) -> Option<String> {
    let semantic = Checked::Valid(json::mesh::Semantic::Positions);
    let primitives = root.meshes.iter().enumerate().flat_map(|(m, mesh)| {
        let numbered = mesh.primitives.iter().enumerate();
        numbered.map(move |(p, primitive)| (m, p, primitive))
    });
    for (m, p, primitive) in primitives {
        let index = primitive.attributes.get(&semantic).map(json::Index::value);
        if let Some(index) = index.filter(|&i| i >= root.accessors.len()) {
            return Some(format!(
                "meshes[{m}].primitives[{p}].attributes.POSITION: accessor {index} is not there"
            ));
        }
    }
    None
}

fn sparse_indices(root: &json::Root) -> Option<String> {
    let is_index = |component: &Checked<json::accessor::IndexComponentType>| {
        let Checked::Valid(found) = component else {
            return false;
        };
        matches!(
            found.0,
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32
        )
    };
    let mut accessors = root.accessors.iter().enumerate();
    accessors.find_map(|(i, accessor)| {
        let sparse = accessor.sparse.as_ref()?;
        (!is_index(&sparse.indices.component_type)).then(|| {
            format!("accessors[{i}].sparse.indices.componentType: no unsigned integer type")
        })
    })
}

fn cameras(root: &json::Root) -> Option<String> {
    let is_whole = |camera: &json::Camera| match camera.type_ {
        Checked::Valid(json::camera::Type::Perspective) => camera.perspective.is_some(),
        Checked::Valid(json::camera::Type::Orthographic) => camera.orthographic.is_some(),
        Checked::Invalid => true, // the crate's own checks name it
    };
    let i = root.cameras.iter().position(|camera| !is_whole(camera))?;
    Some(format!("cameras[{i}]: it lacks what its type says"))
}

fn lights(root: &json::Root) -> Option<String> {
    use json::extensions::scene::khr_lights_punctual::Type;
    let list = root
        .extensions
        .as_ref()
        .and_then(|e| e.khr_lights_punctual.as_ref());
    let lights = list.map_or(&[][..], |list| &list.lights);
    let is_whole = |light: &json::extensions::scene::khr_lights_punctual::Light| {
        !matches!(light.type_, Checked::Valid(Type::Spot)) || light.spot.is_some()
    };
    if let Some(i) = lights.iter().position(|light| !is_whole(light)) {
        return Some(format!("lights[{i}]: it lacks what its type says"));
    }
    let mut nodes = root.nodes.iter().enumerate();
    nodes.find_map(|(n, node)| {
        let light = node.extensions.as_ref()?.khr_lights_punctual.as_ref()?;
        let index = light.light.value();
        (index >= lights.len()).then(|| format!("nodes[{n}]: light {index} is not there"))
    })
}

fn images(root: &json::Root) -> Option<String> {
    let mut images = root.images.iter().enumerate();
    images.find_map(|(i, image)| {
        let view = image.buffer_view.as_ref()?.value();
        (view >= root.buffer_views.len())
            .then(|| format!("images[{i}].bufferView: view {view} is not there"))
    })
}
