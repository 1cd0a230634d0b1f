use super::*;
use crate::io::read_lit;
use crate::quantity::{Exitance, Irradiance};
use crate::render::{CameraChoice, LitModel, RenderSettings, choose_camera, render};

/// Leaves `bytes` for a look with other tools, when `UMBRAGE_KEEP_GLB` names a folder (see tools/README.md).
pub(crate) fn keep(name: &str, bytes: &[u8]) {
    if let Some(folder) = std::env::var_os("UMBRAGE_KEEP_GLB") {
        std::fs::write(
            std::path::Path::new(&folder).join(format!("{name}.glb")),
            bytes,
        )
        .unwrap();
    }
}

fn material(name: &str, reflectance: Rgb, emission: f64) -> Material {
    Material {
        name: name.to_owned(),
        reflectance,
        emission: Radiance(Rgb::grey(emission)),
        reflects_back: true,
        ..Material::default()
    }
}

/// A unit square spanned by `u` and `v` from `corner`, with one irradiance for each corner.
fn patch(corner: DVec3, u: DVec3, v: DVec3, irradiance: [f64; 4]) -> LitMesh {
    LitMesh {
        normal: u.cross(v).normalize(),
        positions: vec![corner, corner + u, corner + u + v, corner + v],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        irradiance: irradiance.map(|e| Irradiance(Rgb::grey(e))).to_vec(),
        ..Default::default()
    }
}

/// A red wall patch and an emitting one of the same material in one group, a grey floor in another; a group without meshes.
pub(crate) fn two_patches() -> LitScene {
    let wall = LitMesh {
        reflectance: Rgb::new(0.5, 0.25, 0.125),
        ..patch(DVec3::ZERO, DVec3::X, DVec3::Y, [0.0, 1.0, 2.0, 8.0])
    };
    let lamp = LitMesh {
        exitance: Exitance(Rgb::grey(1.5)),
        reflectance: wall.reflectance,
        ..patch(DVec3::X, DVec3::X, DVec3::Y, [1.0; 4])
    };
    let floor = LitMesh {
        group: 2,
        material: 1,
        reflectance: Rgb::grey(0.7),
        ..patch(DVec3::ZERO, DVec3::Z, DVec3::X, [0.1, 0.2, 0.3, 1.0 / 3.0])
    };
    LitScene {
        origin: DVec3::new(1000.25, -3.0, 0.5),
        materials: vec![
            material("red", Rgb::new(0.5, 0.25, 0.125), 1.5 / PI),
            material("grey", Rgb::grey(0.7), 0.0),
        ],
        textures: Vec::new(),
        groups: ["walls", "nothing", "floor"].map(String::from).to_vec(),
        cameras: vec![Camera {
            name: String::from("door"),
            eye: DVec3::new(1001.0, -2.0, 4.5),
            forward: DVec3::new(0.1, -0.2, -1.0).normalize(),
            up: DVec3::new(0.0, 1.0, -0.2).normalize(),
            vertical_fov_rad: 0.7,
            aspect: Some(1.5),
        }],
        meshes: vec![wall, lamp, floor],
        exposure: 1.2,
        extras: json!({ "settings": { "error": 0.01 } }),
    }
}

fn roundtrip(name: &str, lit: &LitScene) -> LitModel {
    let bytes = write_glb(lit);
    keep(name, &bytes);
    read_lit(name, &bytes).unwrap()
}

#[test]
fn what_was_written_is_read_back_to_float_precision() {
    let lit = two_patches();
    let model = roundtrip("two-patches", &lit);
    assert_eq!(model.exposure, Some(1.2));
    assert_eq!(model.extras["settings"]["error"], 0.01);
    assert_eq!(model.extras["units"]["radiosity"], "W/m²");
    let names: Vec<_> = model
        .parts
        .iter()
        .map(|part| (part.node.as_str(), part.material.as_str()))
        .collect();
    assert_eq!(
        names,
        [("walls", "red"), ("walls", "red"), ("floor", "grey")]
    );

    for (part, mesh) in model.parts.iter().zip(&lit.meshes) {
        assert_eq!(part.triangles, mesh.triangles);
        assert!(!part.is_double_sided);
        for i in 0..mesh.positions.len() {
            // The root's translation is exact in f32 here, so a kilometre from the origin costs nothing.
            assert!(part.positions[i].distance(lit.origin + mesh.positions[i]) < 1e-6);
            assert!(part.normals[i].distance(mesh.normal) < 1e-6);
            let radiosity = mesh.radiosity(i);
            assert!(part.radiosities[i].0.0.distance(radiosity.0.0) < 1e-6);
            let seen = (part.colours[i] * part.base_colour).0;
            let eye = radiosity.to_radiance().0.0 * lit.exposure;
            // Only the brightest corner of the wall (E = 8) leaves the range.
            if (i, mesh.face) != (3, 0) || mesh.exitance.mean() > 0.0 || mesh.group == 2 {
                assert!(seen.distance(eye) < 1e-6, "{seen} for {eye}");
            }
        }
    }
}

#[test]
fn colours_are_clamped_to_one_and_radiosity_is_not() {
    let model = roundtrip("clamped", &two_patches());
    let wall = &model.parts[0];
    assert_eq!(wall.colours[3], Rgb::grey(1.0));
    assert_eq!(wall.radiosities[3].0, Rgb::new(4.0, 2.0, 1.0));
    assert_eq!(wall.colours[0], Rgb::BLACK);
}

#[test]
fn a_side_that_emits_is_white_and_shows_its_own_light() {
    let model = roundtrip("emitter", &two_patches());
    let [wall, lamp] = &model.parts[..2] else {
        panic!("one part for each material variant")
    };
    assert_eq!(wall.base_colour, Rgb::new(0.5, 0.25, 0.125));
    assert_eq!(lamp.base_colour, Rgb::grey(1.0));
    let expected = (DVec3::splat(1.5) + DVec3::new(0.5, 0.25, 0.125)) * (1.2 / PI);
    assert!(lamp.colours[0].0.distance(expected) < 1e-6);
}

#[test]
fn meshes_of_one_group_and_material_share_a_primitive() {
    let mut lit = two_patches();
    lit.meshes[1].exitance = Exitance::ZERO;
    let model = roundtrip("merged", &lit);
    assert_eq!(model.parts.len(), 2);
    assert_eq!(model.parts[0].triangles[2..], [[4, 5, 6], [4, 6, 7]]);
}

#[test]
fn cameras_come_back_where_they_stood() {
    let lit = two_patches();
    let (there, back) = (&lit.cameras[0], &roundtrip("camera", &lit).cameras[0]);
    assert_eq!(back.name, "door");
    assert!(back.eye.distance(there.eye) < 1e-6);
    assert!(back.forward.distance(there.forward) < 1e-6);
    assert!(back.up.distance(there.up) < 1e-6);
    assert!((back.vertical_fov_rad - 0.7).abs() < 1e-6);
    assert_eq!(back.aspect, Some(1.5));
}

#[test]
fn the_same_scene_gives_the_same_bytes() {
    assert_eq!(write_glb(&two_patches()), write_glb(&two_patches()));
}

#[test]
fn a_scene_without_meshes_is_a_file_too() {
    let mut lit = LitScene::default();
    assert_eq!(roundtrip("empty", &lit).parts, []);
    lit.cameras = two_patches().cameras;
    lit.meshes = vec![LitMesh::default()];
    let model = roundtrip("camera-only", &lit);
    assert_eq!((model.parts.len(), model.cameras.len()), (0, 1));
}

#[test]
fn triangles_that_f32_flattens_and_light_beyond_f32_are_still_a_file() {
    let mut lit = two_patches();
    let far = DVec3::splat(1e6);
    lit.meshes[0].positions = vec![far, far + DVec3::X * 1e-6, far + DVec3::Y * 1e-6, far];
    lit.meshes[0].irradiance = vec![Irradiance(Rgb::grey(1e300)); 4];
    let model = roundtrip("degenerate", &lit);
    assert_eq!(model.parts[0].colours[0], Rgb::grey(1.0));
    let camera = choose_camera(&CameraChoice::Auto, &model, 1.0).unwrap();
    assert!(render(&model, &RenderSettings::new(8, 8, camera)).is_ok());
}

#[test]
fn more_vertices_than_16_bits_can_name_get_32_bit_indices() {
    let mut lit = two_patches();
    for count in [65535, 65536] {
        let mesh = &mut lit.meshes[2];
        mesh.positions.resize(count, DVec3::ONE);
        mesh.irradiance.resize(count, Irradiance::ZERO);
        let last = count as u32 - 1;
        mesh.triangles = vec![[0, 1, last]];
        let model = roundtrip(&format!("vertices-{count}"), &lit);
        assert_eq!(model.parts[2].triangles, [[0, 1, last]]);
    }
}
