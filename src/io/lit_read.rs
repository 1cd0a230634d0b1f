//! A lit glTF back into memory, for pictures and probes.
//!
//! What [`write_glb`](super::write_glb) writes, and what other programs make of it as long as the light stays in `COLOR_0`.

use super::glb_data::{indices, vectors};
use crate::bad_input::BadInput;
use crate::quantity::{Radiosity, Rgb};
use crate::render::{LitModel, LitPart};
use crate::scene::Camera;
use glam::{DMat3, DMat4, DQuat, DVec3};
use gltf::scene::Transform;
use gltf::{Gltf, Semantic};
use std::panic::catch_unwind;

/// The lit model in `bytes`, a binary glTF; `source` is its name for messages.
///
/// Anything else than triangles is left out. Refused are files without `COLOR_0`, with textures, or with data outside.
pub fn read_lit(source: &str, bytes: &[u8]) -> Result<LitModel, BadInput> {
    if !bytes.starts_with(b"glTF") {
        return Err(BadInput::new(
            source,
            "is not a binary glTF",
            "give the .glb that `umbrage bake` wrote",
        ));
    }
    // The JSON reader panics on one broken file in a hundred (an accessor that is not there, for example).
    catch_unwind(|| read(source, bytes)).unwrap_or_else(|_| Err(broken(source, "is damaged")))
}

fn broken(source: &str, what: impl Into<String>) -> BadInput {
    BadInput::new(
        source,
        what,
        "bake it again, or check it with a glTF validator",
    )
}

fn read(source: &str, bytes: &[u8]) -> Result<LitModel, BadInput> {
    let file = Gltf::from_slice(bytes)
        .map_err(|error| broken(source, format!("cannot be read as glTF: {error}")))?;
    let buffer = file.blob.as_deref().unwrap_or_default();
    let scene = file.default_scene().or_else(|| file.scenes().next());
    let scene = scene.ok_or_else(|| broken(source, "has no scene"))?;
    let extras = match scene.extras() {
        Some(text) => serde_json::from_str(text.get())
            .map_err(|error| broken(source, format!("has unreadable extras: {error}")))?,
        None => serde_json::Value::Null,
    };
    let mut model = LitModel {
        source: source.to_owned(),
        exposure: extras.get("exposure").and_then(serde_json::Value::as_f64),
        extras,
        ..Default::default()
    };

    // Walk the tree in the order of the file, each node once: a loop of nodes is valid for the JSON reader.
    let mut is_seen = vec![false; file.nodes().count()];
    let mut waiting: Vec<_> = scene.nodes().map(|node| (node, DMat4::IDENTITY)).collect();
    waiting.reverse();
    while let Some((node, parent)) = waiting.pop() {
        if std::mem::replace(&mut is_seen[node.index()], true) {
            return Err(broken(source, format!("shows node {} twice", node.index())));
        }
        let world = parent * local_matrix(&node);
        if !world.is_finite() {
            return Err(broken(
                source,
                format!("node {} is not finite", node.index()),
            ));
        }
        if let Some(mesh) = node.mesh() {
            for primitive in mesh.primitives() {
                let part = read_part(&node, &primitive, world, buffer)
                    .map_err(|(what, remedy)| BadInput::new(source, what, remedy))?;
                model.parts.extend(part);
            }
        }
        model.cameras.extend(read_camera(&node, world));
        let children: Vec<_> = node.children().map(|child| (child, world)).collect();
        waiting.extend(children.into_iter().rev());
    }
    Ok(model)
}

/// What is wrong with a mesh, and the remedy.
type Refusal = (String, &'static str);

fn read_part(
    node: &gltf::Node<'_>,
    primitive: &gltf::Primitive<'_>,
    world: DMat4,
    buffer: &[u8],
) -> Result<Option<LitPart>, Refusal> {
    if primitive.mode() != gltf::mesh::Mode::Triangles {
        return Ok(None);
    }
    let name = node.name().unwrap_or("unnamed").to_owned();
    let about = |attribute: &str, what: &str| {
        let what = format!("{attribute} of '{name}' {what}");
        (what, "bake it again, or check it with a glTF validator")
    };
    let get = |semantic: &Semantic| match primitive.get(semantic) {
        Some(accessor) => vectors::<3>(&accessor, buffer)
            .map(Some)
            .map_err(|what| about(&semantic.to_string(), &what)),
        None => Ok(None),
    };
    let Some(colours) = get(&Semantic::Colors(0))? else {
        let what = format!("'{name}' has no light in it (no COLOR_0)");
        return Err((what, "light it first: umbrage bake SCENE -o LIT.glb"));
    };
    let material = primitive.material();
    let surface = material.pbr_metallic_roughness();
    if surface.base_color_texture().is_some() {
        let what = format!("'{name}' has a texture, which is not drawn yet");
        return Err((what, "look at it in a glTF viewer"));
    }

    let missing = |attribute| about(attribute, "is missing");
    let positions = get(&Semantic::Positions)?.ok_or_else(|| missing("POSITION"))?;
    let normals = get(&Semantic::Normals)?.ok_or_else(|| missing("NORMAL"))?;
    let radiosities = get(&Semantic::Extras(String::from("RADIOSITY")))?;
    let lengths = [Some(&normals), Some(&colours), radiosities.as_ref()];
    if lengths
        .into_iter()
        .flatten()
        .any(|list| list.len() != positions.len())
    {
        return Err(about("an attribute", "has another length than POSITION"));
    }
    let mut triangles = read_triangles(primitive, positions.len(), buffer)
        .map_err(|what| about("the index list", &what))?;
    // A mirrored node shows its triangles the other way round.
    if DMat3::from_mat4(world).determinant() < 0.0 {
        triangles
            .iter_mut()
            .for_each(|triangle| triangle.swap(1, 2));
    }

    let [r, g, b, _] = surface.base_color_factor().map(f64::from);
    let upright = normal_matrix(world);
    let map = |list: Vec<[f64; 3]>, change: &dyn Fn(DVec3) -> DVec3| {
        list.into_iter()
            .map(|v| change(v.into()))
            .collect::<Vec<_>>()
    };
    let to_radiosities = |list: Vec<[f64; 3]>| list.into_iter().map(|b| Radiosity(Rgb(b.into())));
    Ok(Some(LitPart {
        node: name,
        material: material.name().unwrap_or("unnamed").to_owned(),
        base_colour: Rgb::new(r, g, b),
        is_double_sided: material.double_sided(),
        positions: map(positions, &|p| world.transform_point3(p)),
        normals: map(normals, &|n| (upright * n).normalize_or_zero()),
        colours: colours.into_iter().map(|c| Rgb(c.into())).collect(),
        radiosities: radiosities
            .map(to_radiosities)
            .into_iter()
            .flatten()
            .collect(),
        triangles,
    }))
}

fn read_triangles(
    primitive: &gltf::Primitive<'_>,
    vertices: usize,
    buffer: &[u8],
) -> Result<Vec<[u32; 3]>, String> {
    let corners = match primitive.indices() {
        Some(accessor) => indices(&accessor, buffer, vertices)?,
        None => (0..vertices as u32).collect(),
    };
    Ok(corners
        .chunks_exact(3)
        .map(|t| [t[0], t[1], t[2]])
        .collect())
}

/// Turns normals as `world` turns planes: its cofactors, which also stand for a node that is flattened.
fn normal_matrix(world: DMat4) -> DMat3 {
    let turn = DMat3::from_mat4(world);
    let cofactors = DMat3::from_cols(
        turn.y_axis.cross(turn.z_axis),
        turn.z_axis.cross(turn.x_axis),
        turn.x_axis.cross(turn.y_axis),
    );
    cofactors * turn.determinant().signum()
}

/// The node's own matrix; products of its parts are taken in f64, so that a far root costs no digits.
fn local_matrix(node: &gltf::Node<'_>) -> DMat4 {
    match node.transform() {
        Transform::Matrix { matrix } => {
            DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from)))
        }
        Transform::Decomposed {
            translation,
            rotation,
            scale,
        } => {
            let rotation = DQuat::from_array(rotation.map(f64::from));
            let rotation = if rotation.length_squared() > 0.0 {
                rotation.normalize()
            } else {
                DQuat::IDENTITY
            };
            DMat4::from_scale_rotation_translation(
                DVec3::from_array(scale.map(f64::from)),
                rotation,
                DVec3::from_array(translation.map(f64::from)),
            )
        }
    }
}

/// The camera of a node; none without one, for a parallel one, or when its node is flattened.
fn read_camera(node: &gltf::Node<'_>, world: DMat4) -> Option<Camera> {
    let camera = node.camera()?;
    let gltf::camera::Projection::Perspective(lens) = camera.projection() else {
        return None;
    };
    let forward = world.transform_vector3(DVec3::NEG_Z).try_normalize()?;
    let up = world.transform_vector3(DVec3::Y);
    let name = node.name().or(camera.name());
    Some(Camera {
        name: name.unwrap_or("unnamed").to_owned(),
        eye: world.transform_point3(DVec3::ZERO),
        forward,
        up: (up - forward * up.dot(forward)).try_normalize()?,
        vertical_fov_rad: f64::from(lens.yfov()),
        aspect: lens.aspect_ratio().map(f64::from),
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;
    use crate::io::gltf_write::tests::two_patches;
    use crate::io::write_glb;

    /// `bytes` with its JSON changed by `edit`.
    fn edited(bytes: &[u8], edit: impl Fn(String) -> String) -> Vec<u8> {
        let glb = gltf::binary::Glb::from_slice(bytes).unwrap();
        let json = edit(String::from_utf8(glb.json.to_vec()).unwrap());
        let json = std::borrow::Cow::Owned(json.into_bytes());
        gltf::binary::Glb { json, ..glb }.to_vec().unwrap()
    }

    #[test]
    fn what_is_not_a_lit_file_is_refused_with_a_remedy() {
        let bytes = write_glb(&two_patches());
        let refused = |from: &str, to: &str| {
            let changed = edited(&bytes, |json| {
                assert!(json.contains(from), "{json}");
                json.replace(from, to)
            });
            read_lit("lit.glb", &changed).unwrap_err().to_string()
        };
        assert!(refused("COLOR_0", "_COLOUR").contains("umbrage bake"));
        assert!(refused("\"NORMAL\"", "\"_NORMAL\"").contains("NORMAL of 'walls' is missing"));
        assert!(refused("\"count\":4,", "\"count\":4000,").contains("beyond the data"));
        assert!(refused("\"children\":[", "\"children\":[3,").contains("shows node 3 twice"));
        assert!(
            read_lit("a.obj", b"v 0 0 0")
                .unwrap_err()
                .what
                .contains("not a binary")
        );
        assert!(read_lit("cut.glb", &bytes[..bytes.len() / 2]).is_err());
    }

    #[test]
    fn mirrored_nodes_keep_their_fronts() {
        let bytes = edited(&write_glb(&two_patches()), |json| {
            json.replace(
                "\"translation\":[1000.25,-3.0,0.5]",
                "\"scale\":[-1.0,1.0,2.0]",
            )
        });
        let model = read_lit("mirrored.glb", &bytes).unwrap();
        for part in &model.parts {
            let [a, b, c] = part.triangles[0].map(|i| part.positions[i as usize]);
            let front = (b - a).cross(c - a).normalize();
            assert!(front.distance(part.normals[0]) < 1e-6, "{}", part.node);
        }
        assert_eq!(model.parts[0].positions[1], DVec3::NEG_X);
    }

    #[test]
    fn damaged_bytes_never_get_out_as_a_panic() {
        let bytes = write_glb(&two_patches());
        for i in 0..2000usize {
            let mut damaged = bytes.clone();
            let at = i.wrapping_mul(7919) % damaged.len();
            damaged[at] ^= 1 << (i % 8);
            // Light and geometry may change unnoticed, lengths may not.
            if let Ok(model) = read_lit("damaged.glb", &damaged) {
                for part in &model.parts {
                    assert_eq!(part.positions.len(), part.colours.len());
                }
            }
        }
    }
}
