//! Textures from the file to the lit file: what light sees of them, and what comes out.

use glam::{DVec2, DVec3};
use std::sync::Arc;
use umbrage::io::{ReadSettings, read_lit, read_scene, write_glb};
use umbrage::pipeline::{Sensor, World, light, probe_exact};
use umbrage::quantity::{Radiance, Rgb};
use umbrage::radiosity::Bounces;
use umbrage::scene::{Material, RawPolygon, RawScene};
use umbrage::settings::Settings;
use umbrage::texture::{Texture, Wrap};

/// A PNG of 8 × 8 texels, the left half white, the right half black.
fn halves() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 8, 8);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    let data: Vec<u8> = (0..64).map(|i| if i % 8 < 4 { 255 } else { 0 }).collect();
    let mut writer = encoder.write_header().expect("a PNG has a header");
    writer.write_image_data(&data).expect("64 texels");
    drop(writer);
    bytes
}

/// Four floor tiles of 1 m² with texture coordinates `uv` of their own, in m from their corner, below a lamp.
fn tiles(uv: impl Fn(usize, DVec2) -> DVec2) -> RawScene {
    let mut raw = RawScene {
        source: "tiles".to_owned(),
        materials: vec![
            Material {
                name: "tile".to_owned(),
                reflectance: Rgb::new(0.8, 0.4, 0.2),
                texture: Some(0),
                ..Material::default()
            },
            Material {
                name: "lamp".to_owned(),
                emission: Radiance(Rgb::grey(10.0)),
                ..Material::default()
            },
        ],
        textures: vec![Texture::new("halves", halves()).expect("a whole picture")],
        groups: vec!["all".to_owned()],
        ..RawScene::default()
    };
    let square = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(DVec2::from);
    let mut push = |corners: [(DVec3, DVec2); 4], material| {
        let first = u32::try_from(raw.positions.len()).expect("a small scene");
        for (position, uv) in corners {
            raw.positions.push(position);
            raw.uvs.push(uv);
        }
        raw.polygons.push(RawPolygon {
            corners: (first..first + 4).collect(),
            material,
            group: 0,
        });
    };
    for (i, (x, z)) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
        .iter()
        .enumerate()
    {
        push(
            square.map(|p| (DVec3::new(x + p.x, 0.0, z + p.y), uv(i, p))),
            0,
        );
    }
    push(
        square.map(|p| (DVec3::new(0.5 + p.y, 1.5, 0.5 + p.x), DVec2::ZERO)),
        1,
    );
    raw
}

fn world(raw: &RawScene) -> World {
    World::new(raw, &Settings::default()).expect("a sound scene")
}

#[test]
fn tiles_that_repeat_one_texture_are_one_face() {
    let whole = world(&tiles(|i, p| p + DVec2::new(3.0 * i as f64, -2.0)));
    assert_eq!(whole.scene.faces.len(), 2);
    // Mirrored repetitions join at even numbers of them only.
    let mut raw = tiles(|i, p| p + DVec2::new(if i == 0 { 1.0 } else { 0.0 }, 0.0));
    assert_eq!(world(&raw).scene.faces.len(), 2);
    raw.textures[0].wrap = [Wrap::Mirror; 2];
    assert_eq!(world(&raw).scene.faces.len(), 4);
}

#[test]
fn charts_of_their_own_stay_faces_of_their_own() {
    let world = world(&tiles(|i, p| if i == 2 { DVec2::new(p.y, p.x) } else { p }));
    assert_eq!(world.scene.faces.len(), 3);
    let turned = world.scene.faces.iter().filter(|(_, f)| f.uv.is_some());
    for (_, face) in turned {
        // Each corner is at a whole number of texels in its own chart.
        for &v in face.loops.iter().flatten() {
            let uv = face
                .uv_at(world.scene.vertices[v])
                .expect("a textured face");
            assert!((uv - uv.round()).length() < 1e-12, "{uv}");
        }
    }
}

#[test]
fn light_sees_the_mean_of_what_a_face_shows() {
    // The first tile shows the white half only, the second the black one, the third a diagonal cut.
    let shown = [(0.0, 0.5), (1.0, -0.5), (0.25, 0.5), (0.0, 1.0)];
    let raw = tiles(|i, p| DVec2::new(shown[i].0 + shown[i].1 * p.x, p.y));
    let world = world(&raw);
    for (_, face) in world.scene.faces.iter().filter(|(_, f)| f.uv.is_some()) {
        let centre = face
            .triangles
            .iter()
            .flatten()
            .map(|&v| world.scene.vertices[v]);
        let n = 3.0 * face.triangles.len() as f64;
        let centre = centre.sum::<DVec3>() / n + world.scene.origin;
        let white = match (centre.x < 1.0, centre.z < 1.0) {
            (true, true) => 1.0,
            (false, true) => 0.0,
            _ => 0.5,
        };
        let found = face.reflectance.0 / DVec3::new(0.8, 0.4, 0.2);
        assert!(
            (found - DVec3::splat(white)).length() < 1e-6,
            "{found} {white}"
        );
    }
    assert_eq!(world.scene.faces.len(), 5);
}

#[test]
fn a_half_white_floor_lights_what_is_on_its_white_half() {
    // One face with a picture of two halves, and two faces of one colour each.
    let place = |i: usize, p: DVec2| 0.5 * (p + DVec2::new((i % 2) as f64, (i / 2) as f64));
    let picture = world(&tiles(place));
    let plain = world(&tiles(|i, _| DVec2::new([0.1, 0.9][i % 2], 0.5)));
    assert_eq!((picture.scene.faces.len(), plain.scene.faces.len()), (2, 3));
    let settings = Settings {
        error: 0.02,
        bounces: Bounces::Count(1),
        ..Settings::default()
    };
    // Towards the white half, the black half, and from places over either.
    let sensors = [
        (DVec3::new(1.0, 0.3, 1.0), DVec3::NEG_X),
        (DVec3::new(0.5, 0.2, 0.8), DVec3::NEG_Y),
        (DVec3::new(1.5, 0.2, 0.8), DVec3::NEG_Y),
        (DVec3::new(1.0, 0.3, 1.0), DVec3::X),
    ]
    .map(|(at, normal)| Sensor::new(at, normal).expect("a direction"));
    let readings = [&picture, &plain].map(|world| {
        let lit = light(world, &settings, &mut |_| {}).expect("a bake");
        let found = probe_exact(world, &lit.direct, lit.indirect.as_ref(), &sensors);
        found.iter().map(|r| r.indirect.0.0.x).collect::<Vec<f64>>()
    });
    let brightest = readings[1][0].max(readings[1][1]);
    assert!(brightest > 0.05 && readings[1][3] < 1e-3 * brightest);
    for (found, wanted) in readings[0].iter().zip(&readings[1]) {
        assert!((found - wanted).abs() < 0.04 * brightest, "{readings:?}");
    }
}

#[test]
fn the_lit_file_holds_the_picture_unchanged_and_the_coordinates() {
    let raw = tiles(|i, p| DVec2::new(p.x, 0.5 * (p.y + (i / 2) as f64)));
    let settings = Settings {
        error: 0.05,
        ..Settings::default()
    };
    let world = world(&raw);
    let solution = light(&world, &settings, &mut |_| {}).expect("a bake");
    let bytes = write_glb(&solution.lit_scene());
    let picture = halves();
    assert!(bytes.windows(picture.len()).any(|part| part == picture));
    let model = read_lit("tiles.glb", &bytes).expect("its own file");
    assert_eq!(model.textures.len(), 1);
    assert_eq!(
        model.textures[0].texels,
        Arc::clone(&raw.textures[0].texels)
    );
    let floor = model
        .parts
        .iter()
        .find(|p| p.texture.is_some())
        .expect("a floor");
    assert_eq!(
        floor.base_colour.0.as_vec3(),
        DVec3::new(0.8, 0.4, 0.2).as_vec3()
    );
    for (p, uv) in floor.positions.iter().zip(&floor.uvs) {
        let wanted = DVec2::new(p.x, 0.5 * p.z);
        let apart = *uv - wanted;
        assert!((apart - apart.round()).length() < 1e-6, "{p} {uv}");
    }
    let lamp = model
        .parts
        .iter()
        .find(|p| p.material == "lamp")
        .expect("a lamp");
    assert_eq!((lamp.texture, lamp.uvs.len()), (None, 0));
    // Read as a scene again, the surfaces are what they were.
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("tiles.glb");
    std::fs::write(&path, &bytes).expect("a file");
    let again = read_scene(&path, &ReadSettings::default()).expect("a scene");
    assert_eq!(again.textures[0].encoded, raw.textures[0].encoded);
}

#[test]
fn leaves_that_are_mostly_air_block_no_light() {
    let mut raw = tiles(|_, p| p);
    let texels = umbrage::texture::Texels {
        width: 4,
        height: 1,
        rgba: [255, 0, 0, 0].map(|opacity| [9, 9, 9, opacity]).to_vec(),
    };
    raw.textures[0].texels = Arc::new(texels);
    raw.materials[0].cut_off = Some(0.5);
    let world = World::new(&raw, &Settings::default()).expect("the lamp is left");
    assert_eq!((world.scene.faces.len(), world.clean.see_through), (1, 4));
    raw.materials[0].cut_off = None;
    assert_eq!(
        World::new(&raw, &Settings::default())
            .expect("all")
            .scene
            .faces
            .len(),
        2
    );
}

#[test]
fn lists_that_do_not_belong_together_are_refused() {
    let refused = |change: fn(&mut RawScene)| {
        let mut raw = tiles(|_, p| p);
        change(&mut raw);
        let error = World::new(&raw, &Settings::default())
            .err()
            .expect("a refusal");
        error.to_string()
    };
    assert!(refused(|raw| raw.uvs.truncate(19)).contains("texture coordinates for 20"));
    assert!(refused(|raw| raw.normals.push(DVec3::X)).contains("1 normals for 20"));
    assert!(refused(|raw| raw.uvs[3].x = f64::NAN).contains("not finite"));
    assert!(refused(|raw| raw.textures.clear()).contains("\"tile\" refers to a texture"));
}

#[test]
fn emission_follows_its_texture_and_dark_parts_are_no_emitters() {
    // Tiles that show the white half, the black half, a half of either, and all.
    let shown = [(0.0, 0.5), (1.0, -0.5), (0.25, 0.5), (0.0, 1.0)];
    let mut raw = tiles(|i, p| DVec2::new(shown[i].0 + shown[i].1 * p.x, p.y));
    raw.materials[0].texture = None;
    raw.materials[0].emission_texture = Some(0);
    raw.materials[0].emission = Radiance(Rgb::new(4.0, 2.0, 1.0));
    let world = world(&raw);
    let mut found: Vec<f64> = world
        .scene
        .faces
        .iter()
        .filter(|(_, f)| f.uv.is_some())
        .map(|(_, f)| f.emission.0.0.x)
        .collect();
    found.sort_by(f64::total_cmp);
    for (found, wanted) in found.iter().zip([0.0, 2.0, 2.0, 4.0]) {
        assert!((found - wanted).abs() < 1e-6, "{found} {wanted}");
    }
    // The lamp, and all tiles but the black one.
    assert_eq!((found.len(), world.scene.emitters.len()), (4, 4));
}
