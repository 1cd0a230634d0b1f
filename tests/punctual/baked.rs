//! Bakes lit by lights without a surface.

use super::{boxes, on_floor, point, spot, square_over_floor, sun, world};
use crate::common::bake::{bake, settings};
use glam::DVec3;
use serde_json::json;
use umbrage::direct::DirectLight;
use umbrage::io::write_glb;
use umbrage::pipeline::{MEASURE_SLACK, Sensor, light, probe_exact, probe_mesh};
use umbrage::radiosity::Bounces;
use umbrage::scene::FaceSide;

#[test]
fn bakes_keep_the_error_asked_for() {
    let lights = [
        point([0.3, 2.2, -0.2], 1.0),
        spot([-0.9, 2.4, 1.1], [0.4, 0.0, 0.3], [0.5, 0.8], 1.0),
        sun([0.5, -1.0, 0.35], 1.0),
    ];
    for source in lights {
        let kind = source.kind;
        let world = world(&boxes(), vec![source]);
        for bounces in [Bounces::Count(0), Bounces::All] {
            let solution = bake(&world, 0.03, bounces);
            let measured = solution.summary.measured;
            let allowed = (1.0 + MEASURE_SLACK) * 0.03;
            assert!(measured.relative_rms <= allowed, "{kind:?}: {measured:?}");
            assert!(solution.indirect.is_some() == (bounces == Bounces::All));
        }
    }
}

/// Right beside the edge of the shadow the mesh shows all of the light on one side and nothing on the other.
#[test]
fn no_light_leaks_across_the_edge_of_a_shadow() {
    let world = world(&square_over_floor(), vec![point([0.0, 1.5, 0.0], 1.0)]);
    let solution = bake(&world, 0.05, Bounces::Count(0));
    // The shadow is a square of 1.5 m.
    for across in [-0.3, 0.0, 0.4, 0.7] {
        let sensors = [0.7499, 0.7501]
            .map(|x| Sensor::new(DVec3::new(x, 0.0, across), DVec3::Y).expect("a direction"));
        let shown = probe_mesh(&solution, &sensors).expect("the floor has a mesh");
        let exact = on_floor(&world, 0.7501, across);
        assert!(shown[0].direct.mean().abs() < 1e-3 * exact, "{shown:?}");
        assert!(
            (shown[1].direct.mean() - exact).abs() < 0.1 * exact,
            "{shown:?} {exact}"
        );
        let direct = DirectLight::new(&world.scene, &world.blockers);
        let readings = probe_exact(&world, &direct, None, &sensors);
        assert!(readings[0].direct.mean() <= 0.0);
        assert!((readings[1].direct.mean() - exact).abs() < 1e-12);
    }
}

/// A closed room lit by a point: what leaves the light arrives. Without bounces, the flux through all walls is 4π I.
#[test]
fn all_that_a_light_sends_arrives() {
    let mut mesh = crate::common::obj_lite::ObjMesh::default();
    let (a, b) = ([-1.0, 0.0, -1.5], [2.0, 2.5, 1.0]);
    crate::lines::cities::add_box(&mut mesh, a, b, true);
    let world = world(&mesh, vec![point([0.3, 1.7, -0.4], 2.0)]);
    let solution = bake(&world, 0.005, Bounces::Count(0));
    let flux: f64 = solution.receivers.iter().map(|r| r.power().mean()).sum();
    let sent = 4.0 * std::f64::consts::PI * 2.0;
    assert!((flux - sent).abs() < 0.003 * sent, "{flux} {sent}");
    let backs = solution
        .receivers
        .iter()
        .filter(|r| r.domain.side == FaceSide::Front && r.is_lit);
    assert_eq!(
        backs.count(),
        0,
        "the box's faces look outwards: only their backs are lit"
    );
}

/// A file with a point light over a floor, as an exporter writes it.
#[test]
fn a_file_with_a_light_is_baked_and_probed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let corners: [[f32; 3]; 4] = [[-2., 0., 2.], [2., 0., 2.], [2., 0., -2.], [-2., 0., -2.]];
    let mut bytes: Vec<u8> = corners
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    let document = json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": 683.0 }] } },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [
            { "mesh": 0, "name": "floor" },
            { "translation": [0.0, 2.0, 0.0], "extensions": { "KHR_lights_punctual": { "light": 0 } } }
        ],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
              "min": [-2.0, 0.0, -2.0], "max": [2.0, 0.0, 2.0] },
            { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 12 }
        ],
        "buffers": [{ "byteLength": 60, "uri": "scene.bin" }]
    });
    std::fs::write(folder.path().join("scene.bin"), bytes).expect("the folder takes a file");
    let path = folder.path().join("scene.gltf");
    std::fs::write(&path, document.to_string()).expect("the folder takes a file");
    let raw = crate::common::bake::raw_at(&path);
    let is_about_lights = |w: &umbrage::warning::Warning| w.message.contains("light");
    assert!(
        !raw.warnings.iter().any(is_about_lights),
        "{:?}",
        raw.warnings
    );
    let world = crate::common::bake::clean(&raw);
    let solution =
        light(&world, &settings(0.02, Bounces::All), &mut |_| {}).unwrap_or_else(|e| panic!("{e}"));
    // 683 cd are 1 W/sr: E = 1/2² right below.
    let sensor = Sensor::new(DVec3::ZERO, DVec3::Y).expect("a direction");
    let exact = probe_exact(&world, &solution.direct, None, &[sensor])[0];
    assert!((exact.direct.mean() - 0.25).abs() < 1e-12);
    let shown = probe_mesh(&solution, &[sensor]).expect("the floor has a mesh")[0];
    assert!((shown.direct.mean() - 0.25).abs() < 0.02);
    assert!(write_glb(&solution.lit_scene()).starts_with(b"glTF"));
}
