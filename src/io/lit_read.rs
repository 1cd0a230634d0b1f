//! A lit glTF back into memory, for pictures and probes.
//!
//! What [`write_glb`](super::write_glb) writes, and what other programs make of it as long as the light stays in `COLOR_0`.

use super::gltf_data::accessor::{self, Numbers};
use super::gltf_data::buffers::{Buffers, Folder};
use super::gltf_data::place::{local_matrix, normal_matrix};
use super::gltf_data::texture::UvSource;
use super::gltf_data::{document, texture};
use crate::bad_input::BadInput;
use crate::quantity::{Exitance, Radiosity, Rgb};
use crate::render::{EmitterSide, LitModel, LitPart};
use crate::scene::Camera;
use glam::{DMat3, DMat4, DVec2, DVec3};
use gltf::Semantic;
use gltf::material::AlphaMode;

/// The lit model in `bytes`, a binary glTF; `source` is its name for messages.
///
/// Anything else than triangles is left out. Refused are files without `COLOR_0`, or with data outside.
pub fn read_lit(source: &str, bytes: &[u8]) -> Result<LitModel, BadInput> {
    if !bytes.starts_with(b"glTF") {
        return Err(BadInput::new(
            source,
            "is not a binary glTF",
            "give the .glb that `umbrage bake` wrote",
        ));
    }
    let (document, blob) = document::parse(bytes, source)?;
    let buffers = Buffers::load(&document, blob, &Folder::None, source)?;
    let textures = document.textures().count();
    let mut reader = Reader {
        source,
        document,
        buffers,
        texture_of: vec![None; textures],
        model: LitModel::default(),
    };
    reader.read()?;
    Ok(reader.model)
}

fn broken(source: &str, what: impl Into<String>) -> BadInput {
    BadInput::new(
        source,
        what,
        "bake it again, or check it with a glTF validator",
    )
}

struct Reader<'a> {
    source: &'a str,
    document: gltf::Document,
    buffers: Buffers,
    /// Index in the model of each texture of the document that a part has used.
    texture_of: Vec<Option<u32>>,
    model: LitModel,
}

impl Reader<'_> {
    fn read(&mut self) -> Result<(), BadInput> {
        let (source, document) = (self.source, self.document.clone());
        let scene = document
            .default_scene()
            .or_else(|| document.scenes().next());
        let scene = scene.ok_or_else(|| broken(source, "has no scene"))?;
        let extras = match scene.extras() {
            Some(text) => serde_json::from_str(text.get())
                .map_err(|error| broken(source, format!("has unreadable extras: {error}")))?,
            None => serde_json::Value::Null,
        };
        self.model.source = source.to_owned();
        self.model.exposure = extras.get("exposure").and_then(serde_json::Value::as_f64);
        self.model.extras = extras;

        // Walk the tree in the order of the file, each node once: a loop of nodes is valid for the JSON reader.
        let mut is_seen = vec![false; document.nodes().count()];
        let mut waiting: Vec<_> = scene.nodes().map(|node| (node, DMat4::IDENTITY)).collect();
        waiting.reverse();
        while let Some((node, parent)) = waiting.pop() {
            if std::mem::replace(&mut is_seen[node.index()], true) {
                return Err(broken(source, format!("shows node {} twice", node.index())));
            }
            let world = local_matrix(&node).map(|local| parent * local);
            let world = world
                .filter(DMat4::is_finite)
                .ok_or_else(|| broken(source, format!("node {} is not finite", node.index())))?;
            for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
                let part = self.part(&node, &primitive, world)?;
                self.model.parts.extend(part);
            }
            self.model.cameras.extend(read_camera(&node, world));
            let children: Vec<_> = node.children().map(|child| (child, world)).collect();
            waiting.extend(children.into_iter().rev());
        }
        Ok(())
    }

    fn attribute<const N: usize>(
        &self,
        primitive: &gltf::Primitive<'_>,
        semantic: &Semantic,
    ) -> Result<Option<Vec<[f64; N]>>, BadInput> {
        let Some(found) = primitive.get(semantic) else {
            return Ok(None);
        };
        let (name, core) = (semantic.to_string(), Numbers::Core);
        let list = accessor::vectors::<N>(&found, &self.buffers, self.source, core, &name)?;
        match list.iter().flatten().all(|x| x.is_finite()) {
            true => Ok(Some(list)),
            false => Err(broken(
                self.source,
                format!("{name} holds a number that is not finite"),
            )),
        }
    }

    fn part(
        &mut self,
        node: &gltf::Node<'_>,
        primitive: &gltf::Primitive<'_>,
        world: DMat4,
    ) -> Result<Option<LitPart>, BadInput> {
        if primitive.mode() != gltf::mesh::Mode::Triangles {
            return Ok(None);
        }
        let name = node.name().unwrap_or("unnamed").to_owned();
        let get = |semantic| self.attribute::<3>(primitive, &semantic);
        let Some(colours) = get(Semantic::Colors(0))? else {
            return Err(BadInput::new(
                self.source,
                format!("'{name}' has no light in it (no COLOR_0)"),
                "light it first: umbrage bake SCENE -o LIT.glb",
            ));
        };
        let missing = |what| broken(self.source, format!("{what} of '{name}' is missing"));
        let positions = get(Semantic::Positions)?.ok_or_else(|| missing("POSITION"))?;
        let normals = get(Semantic::Normals)?.ok_or_else(|| missing("NORMAL"))?;
        let radiosities = get(Semantic::Extras(String::from("RADIOSITY")))?;
        let (texture, uvs) = self.look(primitive)?.unzip();
        let lengths = [
            Some(normals.len()),
            Some(colours.len()),
            radiosities.as_ref().map(Vec::len),
            uvs.as_ref().map(Vec::len),
        ];
        if lengths.into_iter().flatten().any(|n| n != positions.len()) {
            let what = format!("an attribute of '{name}' has another length than POSITION");
            return Err(broken(self.source, what));
        }
        let mut triangles = self.triangles(primitive, positions.len())?;
        // A mirrored node shows its triangles the other way round.
        if DMat3::from_mat4(world).determinant() < 0.0 {
            triangles
                .iter_mut()
                .for_each(|triangle| triangle.swap(1, 2));
        }

        let material = primitive.material();
        let [r, g, b, alpha] = material.pbr_metallic_roughness().base_color_factor();
        let emitter = read_emitter(primitive)
            .map_err(|what| broken(self.source, format!("the extras of '{name}' {what}")))?;
        let upright = normal_matrix(world);
        let map = |list: Vec<[f64; 3]>, change: &dyn Fn(DVec3) -> DVec3| {
            list.into_iter()
                .map(|v| change(v.into()))
                .collect::<Vec<_>>()
        };
        let to_radiosities =
            |list: Vec<[f64; 3]>| list.into_iter().map(|b| Radiosity(Rgb(b.into())));
        Ok(Some(LitPart {
            node: name,
            material: material.name().unwrap_or("unnamed").to_owned(),
            base_colour: Rgb::new(f64::from(r), f64::from(g), f64::from(b)),
            texture,
            cut_off: (material.alpha_mode() == AlphaMode::Mask).then(|| {
                f64::from(material.alpha_cutoff().unwrap_or(0.5) / alpha.max(f32::EPSILON))
            }),
            is_double_sided: material.double_sided(),
            positions: map(positions, &|p| world.transform_point3(p)),
            normals: map(normals, &|n| (upright * n).normalize_or_zero()),
            uvs: uvs.unwrap_or_default(),
            colours: colours.into_iter().map(|c| Rgb(c.into())).collect(),
            radiosities: radiosities
                .map(to_radiosities)
                .into_iter()
                .flatten()
                .collect(),
            triangles,
            emitter,
        }))
    }

    /// Texture and coordinates of a primitive whose material has a texture.
    fn look(
        &mut self,
        primitive: &gltf::Primitive<'_>,
    ) -> Result<Option<(u32, Vec<DVec2>)>, BadInput> {
        let material = primitive.material();
        let Some(info) = material.pbr_metallic_roughness().base_color_texture() else {
            return Ok(None);
        };
        let from = UvSource::of(&info);
        let Some(uvs) = self.attribute::<2>(primitive, &Semantic::TexCoords(from.set))? else {
            return Ok(None);
        };
        let found = info.texture();
        let index = match self.texture_of[found.index()] {
            Some(known) => known,
            None => {
                let texture = texture::load(&found, &self.document, &self.buffers, &Folder::None);
                let name = material.name().unwrap_or("unnamed");
                let texture = texture
                    .map_err(|why| broken(self.source, format!("the texture of '{name}' {why}")))?;
                self.model.textures.push(texture);
                self.model.textures.len() as u32 - 1
            }
        };
        self.texture_of[found.index()] = Some(index);
        Ok(Some((
            index,
            uvs.into_iter().map(|uv| from.apply(uv)).collect(),
        )))
    }

    fn triangles(
        &self,
        primitive: &gltf::Primitive<'_>,
        vertices: usize,
    ) -> Result<Vec<[u32; 3]>, BadInput> {
        let corners = match primitive.indices() {
            Some(list) => accessor::indices(&list, &self.buffers, self.source)?,
            None => (0..vertices as u32).collect(),
        };
        if let Some(index) = corners.iter().find(|&&i| i as usize >= vertices) {
            let what = format!("an index list names vertex {index} of {vertices}");
            return Err(broken(self.source, what));
        }
        Ok(corners
            .chunks_exact(3)
            .map(|t| [t[0], t[1], t[2]])
            .collect())
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

/// What the file says of a side that emits.
fn read_emitter(primitive: &gltf::Primitive<'_>) -> Result<Option<EmitterSide>, String> {
    let Some(text) = primitive.extras() else {
        return Ok(None);
    };
    let extras: serde_json::Value =
        serde_json::from_str(text.get()).map_err(|error| format!("are no JSON: {error}"))?;
    let channels = |name: &str| {
        let list: [f64; 3] = serde_json::from_value(extras.get(name)?.clone()).ok()?;
        Some(Rgb(list.into()))
    };
    Ok(channels("exitance")
        .zip(channels("reflectance"))
        .map(|(exitance, reflectance)| EmitterSide {
            exitance: Exitance(exitance),
            reflectance,
        }))
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
        assert!(refused("\"count\":4,", "\"count\":4000,").contains("do not lie within"));
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
