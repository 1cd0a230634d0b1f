//! Coloured lines over faint faces as a binary glTF: what the mesher saw, for any viewer.

use super::glb::{GlbBuilder, Unlit};
use super::gltf_write::{root_node, to_f32};
use crate::lit_scene::LitMesh;
use glam::DVec3;
use gltf_json as gj;
use gltf_json::mesh::{Mode, Semantic};
use gltf_json::validation::Checked::Valid;
use std::collections::BTreeMap;

/// Linear grey of the faces: light enough for dark and coloured lines to stand out.
const FACE_GREY: f32 = 0.75;

/// How far faces stand back behind their lines, as a fraction of the diagonal of the whole.
///
/// Viewers draw a line and the face that it lies on at the same depth, and the line comes out dotted. A 24-bit depth buffer
/// resolves some 1e-5 of a scene that fills the view; a twentieth of a per cent is safely more and still too small to see.
const STAND_BACK: f64 = 5e-4;

/// Lines of one kind.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LineSet {
    /// Name of the node, so that a viewer can show and hide the set.
    pub name: String,
    /// Linear RGB, 0…1.
    pub colour: [f64; 3],
    /// Both ends of each line, metres, local.
    pub segments: Vec<[DVec3; 2]>,
}

/// `lines` over `faces` as a binary glTF; sets without segments are left out.
///
/// `origin` is the place of the local coordinates in the world, metres. Of each face only position, normal and triangles
/// are read; it stands back a little behind its lines and is seen from its lit side only.
///
/// # Panics
/// When the file would pass the 4 GiB of its format.
pub fn write_lines_glb(origin: DVec3, faces: &[LitMesh], lines: &[LineSet]) -> Vec<u8> {
    let mut glb = GlbBuilder::new();
    let mut children: Vec<_> = write_faces(&mut glb, faces).into_iter().collect();
    for set in lines.iter().filter(|set| !set.segments.is_empty()) {
        children.push(write_set(&mut glb, set));
    }
    let root = root_node(&mut glb, origin, children);
    glb.finish(root, None)
}

fn write_faces(glb: &mut GlbBuilder, faces: &[LitMesh]) -> Option<gj::Index<gj::Node>> {
    let corners = || faces.iter().flat_map(|face| &face.positions);
    let low = corners().copied().reduce(DVec3::min)?;
    let high = corners().copied().reduce(DVec3::max)?;
    let stand_back = low.distance(high) * STAND_BACK;

    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for face in faces.iter().filter(|face| !face.triangles.is_empty()) {
        let first =
            u32::try_from(positions.len()).expect("a glTF mesh has fewer than 2³² vertices");
        let moved = face
            .positions
            .iter()
            .map(|&p| to_f32(p - face.normal * stand_back));
        positions.extend(moved);
        indices.extend(face.triangles.as_flattened().iter().map(|i| first + i));
    }
    if indices.is_empty() {
        return None;
    }
    let material = glb.material(Unlit {
        name: String::from("faces"),
        texture: None,
        cut_off: None,
        base_colour: [FACE_GREY, FACE_GREY, FACE_GREY, 1.0],
    });
    let mut primitive = plain(glb, &positions, Mode::Triangles, material);
    primitive.indices = Some(glb.indices(&indices, positions.len()));
    Some(glb.mesh_node("faces", vec![primitive]))
}

fn write_set(glb: &mut GlbBuilder, set: &LineSet) -> gj::Index<gj::Node> {
    let [r, g, b] = to_f32(DVec3::from_array(set.colour).clamp(DVec3::ZERO, DVec3::ONE));
    let material = glb.material(Unlit {
        name: set.name.clone(),
        texture: None,
        cut_off: None,
        base_colour: [r, g, b, 1.0],
    });
    let ends: Vec<_> = set
        .segments
        .as_flattened()
        .iter()
        .map(|&p| to_f32(p))
        .collect();
    let primitive = plain(glb, &ends, Mode::Lines, material);
    glb.mesh_node(&set.name, vec![primitive])
}

/// Positions and a material, nothing else.
fn plain(
    glb: &mut GlbBuilder,
    positions: &[[f32; 3]],
    mode: Mode,
    material: gj::Index<gj::Material>,
) -> gj::mesh::Primitive {
    gj::mesh::Primitive {
        attributes: BTreeMap::from([(Valid(Semantic::Positions), glb.positions(positions))]),
        indices: None,
        material: Some(material),
        mode: Valid(mode),
        targets: None,
        extensions: None,
        extras: None,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;
    use crate::io::gltf_write::tests::{keep, two_patches};

    #[test]
    fn faces_and_lines_become_named_nodes() {
        let red = LineSet {
            name: String::from("d0"),
            colour: [1.0, 0.0, 0.0],
            segments: vec![[DVec3::ZERO, DVec3::X], [DVec3::X, DVec3::ONE]],
        };
        let empty = LineSet {
            name: String::from("d2"),
            ..Default::default()
        };
        let lit = two_patches();
        let bytes = write_lines_glb(DVec3::X, &lit.meshes, &[red, empty]);
        keep("lines", &bytes);
        let file = gltf::Gltf::from_slice(&bytes).unwrap();
        let names: Vec<_> = file.nodes().filter_map(|node| node.name()).collect();
        assert_eq!(names, ["faces", "d0", "scene"]);
        let lines = file.meshes().nth(1).unwrap();
        let primitive = lines.primitives().next().unwrap();
        assert_eq!(primitive.mode(), gltf::mesh::Mode::Lines);
        assert_eq!(
            primitive.get(&gltf::Semantic::Positions).unwrap().count(),
            4
        );
    }

    #[test]
    fn nothing_is_a_file_too() {
        let bytes = write_lines_glb(DVec3::ZERO, &[], &[]);
        keep("lines-empty", &bytes);
        assert!(gltf::Gltf::from_slice(&bytes).is_ok());
    }
}
