//! OBJ and MTL files, whole and broken.

use super::*;
use crate::quantity::Radiance;
use glam::DVec3;

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";

fn read(obj: &str, mtl: &str) -> Result<RawScene, BadInput> {
    read_with(obj.as_bytes(), mtl, &ReadSettings::default())
}

fn read_with(obj: &[u8], mtl: &str, settings: &ReadSettings) -> Result<RawScene, BadInput> {
    read_files(
        "a.obj",
        &[("a.obj", obj), ("a.mtl", mtl.as_bytes())],
        settings,
    )
}

fn material(mtl: &str) -> Material {
    let scene = read(&format!("mtllib a.mtl\n{TRIANGLE}"), mtl).unwrap();
    scene.materials[scene.polygons[0].material as usize].clone()
}

#[test]
fn polygons_stay_whole_and_in_order() {
    let scene = read(
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 2 0\n\
         o first\nf 1 2 3 4 5\nf 1 2 3\no second\nf 1 2 3 4\ng first\nf 2 3 4\n",
        "",
    )
    .unwrap();
    let shape: Vec<_> = scene
        .polygons
        .iter()
        .map(|p| (p.corners.len(), p.group))
        .collect();
    assert_eq!(shape, [(5, 0), (3, 0), (4, 1), (3, 0)]);
    assert_eq!(scene.groups, ["first", "second"]);
    let corners: Vec<_> = scene.polygons[2]
        .corners
        .iter()
        .map(|&c| scene.positions[c as usize])
        .collect();
    assert_eq!(
        corners,
        [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y]
    );
}

#[test]
fn positions_keep_all_their_digits() {
    let scene = read(
        "v 0.1 1234567.123456789 -1e-300\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "",
    )
    .unwrap();
    assert_eq!(
        scene.positions[0],
        DVec3::new(0.1, 1_234_567.123_456_789, -1e-300)
    );
}

#[test]
fn units_become_metres() {
    for (unit, metres) in [
        (None, 2.0),
        (Some(Unit::Centimetre), 0.02),
        (Some(Unit::Millimetre), 0.002),
        (Some(Unit::Inch), 2.0 * 0.0254),
        (Some(Unit::Foot), 2.0 * 0.3048),
    ] {
        let settings = ReadSettings {
            unit,
            up: UpAxis::Y,
        };
        let scene = read_with(b"v 2 0 0\nv 0 2 0\nv 0 0 2\nf 1 2 3\n", "", &settings).unwrap();
        assert_eq!(scene.positions[0], DVec3::new(metres, 0.0, 0.0), "{unit:?}");
    }
}

#[test]
fn z_up_turns_to_y_up_without_mirroring() {
    let settings = ReadSettings {
        unit: None,
        up: UpAxis::Z,
    };
    let scene = read_with(b"v 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n", "", &settings).unwrap();
    assert_eq!(scene.positions, [DVec3::X, DVec3::NEG_Z, DVec3::Y]);
    assert_eq!(scene.polygons[0].corners, [0, 1, 2]);
    let [a, b, c] = [0, 1, 2].map(|i| scene.positions[i]);
    assert_eq!(a.cross(b).dot(c), 1.0);
}

#[test]
fn relative_indices_count_back() {
    let scene = read(
        "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 5 5\n",
        "",
    )
    .unwrap();
    assert_eq!(scene.positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
}

#[test]
fn materials_state_light() {
    let a = material("newmtl a\nKd 0.1 0.2 0.3\nKe 4 5 6\nd 1\n");
    assert_eq!(a.reflectance, Rgb::new(0.1, 0.2, 0.3));
    assert_eq!(a.emission, Radiance(Rgb::new(4.0, 5.0, 6.0)));
    assert!(!a.is_see_through && a.reflects_back && !a.emits_back);
    assert_eq!(
        material("newmtl a\nKd 0.4 # grey\n").reflectance,
        Rgb::grey(0.4)
    );
}

#[test]
fn glass_is_see_through() {
    for (lines, is_see_through) in [
        ("d 0.05", true),
        ("d -halo 0.05", true),
        ("d 0.5", false),
        ("Tr 0.9", true),
        ("Tr 0.1", false),
        ("d 1\nTr 1", false),
        ("Tr 1\nd 1", false),
    ] {
        let mtl = format!("newmtl a\nKd 1 1 1\n{lines}\n");
        assert_eq!(material(&mtl).is_see_through, is_see_through, "{lines}");
    }
}

#[test]
fn a_library_named_after_its_use_is_found() {
    let scene = read(
        &format!("{TRIANGLE}mtllib a.mtl\n"),
        "newmtl a\nKd 0.1 0.1 0.1\n",
    )
    .unwrap();
    assert_eq!(scene.materials[0].reflectance, Rgb::grey(0.1));
    assert_eq!(scene.warnings, []);
}

#[test]
fn a_missing_library_is_a_warning_and_grey() {
    let scene = read(&format!("mtllib gone.mtl\n{TRIANGLE}"), "").unwrap();
    let texts: Vec<_> = scene.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        texts,
        [
            "a.obj:1: material library gone.mtl not found",
            "a.obj:5: material \"a\" is not defined: reflectance 0.5 grey is used"
        ]
    );
    assert_eq!(scene.materials[0].reflectance, Rgb::grey(0.5));
    assert_eq!(scene.materials[0].name, "a");
}

#[test]
fn faces_without_material_and_textures_are_warned_of() {
    let scene = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "").unwrap();
    assert!(
        scene.warnings[0]
            .message
            .starts_with("1 faces have no material")
    );
    let scene = read(
        &format!("mtllib a.mtl\n{TRIANGLE}"),
        "newmtl a\nKd 1 1 1\nmap_Kd a.png\n",
    )
    .unwrap();
    assert!(
        scene.warnings[0]
            .message
            .contains("map_Kd a.png is not there")
    );
}

/// A PNG of one white texel.
fn white() -> Vec<u8> {
    let picture = crate::render::Picture {
        width: 1,
        height: 1,
        pixels: vec![[255; 3]],
    };
    crate::io::write_png(&picture)
}

#[test]
fn textures_lie_where_their_options_put_them() {
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 0.25\nvn 0 0 2\nusemtl a\n\
               f 1/1/1 2/2/1 3/3/1\nusemtl b\nf 1/1 2/2 3/3\n";
    let mtl = "newmtl a\nKd 0.5 0.5 0.5\nmap_Kd -clamp on -s 2 4 -o 0.5 0 1 C:\\old\\my white.png\n\
               map_d -clamp on -s 2 4 -o 0.5 0 1 C:\\old\\my white.png\nnewmtl b\nKd 1 1 1\n";
    let picture = white();
    let files: [(&str, &[u8]); 3] = [
        ("a.obj", obj.as_bytes()),
        ("a.mtl", mtl.as_bytes()),
        ("my white.png", &picture),
    ];
    let scene = read_files("a.obj", &files, &ReadSettings::default()).unwrap();
    assert_eq!(scene.warnings, []);
    // v of the file points up.
    let uv = |i: usize| scene.uvs[scene.polygons[0].corners[i] as usize].to_array();
    assert_eq!([uv(0), uv(1), uv(2)], [[0.5, 1.0], [2.5, 1.0], [0.5, 0.0]]);
    assert_eq!(scene.normals[0], DVec3::Z);
    assert_eq!(scene.materials[0].texture, Some(0));
    assert_eq!(scene.materials[0].cut_off, Some(0.5));
    assert_eq!(scene.materials[1].texture, None);
    assert_eq!(scene.textures[0].wrap, [crate::texture::Wrap::Clamp; 2]);
    assert_eq!(scene.textures[0].encoded.to_vec(), picture);
}

#[test]
fn lines_points_and_corners_too_few_are_counted() {
    let scene = read(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3\np 1\nf 1 2\nf\nf 1 2 3\no b\nf\n",
        "",
    )
    .unwrap();
    assert_eq!(scene.polygons.len(), 1);
    let texts: Vec<_> = scene.warnings.iter().map(|w| w.message.as_str()).collect();
    assert!(texts[0].starts_with("2 point, line and curve"), "{texts:?}");
    assert!(
        texts[1].starts_with("3 faces with fewer than 3 corners"),
        "{texts:?}"
    );
}

#[test]
fn odd_but_valid_text_is_read() {
    let obj =
        b"\xEF\xBB\xBF# caf\xe9 C:\\models\\\r\nv 0 0 0 1.0\r\nv 1 0 0 1 0 0\r\nv 0 1 \\\r\n 0\r\n\
        vt 0 nonsense\r\nusemtl\ta\r\nf 1/1 2/99/7 \\\r\n3 # a comment\r\n";
    let scene = read_with(obj, "", &ReadSettings::default()).unwrap();
    assert_eq!(scene.positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
    assert_eq!(scene.materials[0].name, "a");
}

#[test]
fn mistakes_name_their_line() {
    for (obj, place, what) in [
        (
            "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n",
            "a.obj:2",
            "not finite",
        ),
        (
            "v 0 0 0\nv 1e999 0 0\nv 0 1 0\nf 1 2 3\n",
            "a.obj:2",
            "not finite",
        ),
        (
            "v 0 0 0\nv 1 0,5 0\nv 0 1 0\nf 1 2 3\n",
            "a.obj:2",
            "\"0,5\" is not a number",
        ),
        (
            "v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3\n",
            "a.obj:2",
            "2 coordinates",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
            "a.obj:4",
            "4 is out of range (3 vertices)",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 \\\n1 0\nf 0 2 3\n",
            "a.obj:5",
            "0 is out of range",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 2 3\n",
            "a.obj:4",
            "-4 is out of range",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 b 3\n",
            "a.obj:4",
            "\"b\" is not an index",
        ),
        ("f 1 2 99999999999999999999\n", "a.obj:1", "out of range"),
        ("v 0 0 0\nusemtl\n", "a.obj:2", "without a name"),
    ] {
        let error = read(obj, "").unwrap_err();
        assert_eq!(error.place, place, "{obj}: {error}");
        assert!(error.what.contains(what), "{obj}: {error}");
    }
}

#[test]
fn impossible_materials_name_material_and_file() {
    for (mtl, place, what) in [
        (
            "\nnewmtl a\nKd 1.2 0 0\n",
            "a.mtl:2",
            "\"a\" has reflectance [1.2, 0.0, 0.0]",
        ),
        ("newmtl a\nKd -0.1 0 0\n", "a.mtl:1", "outside 0…1"),
        ("newmtl a\nKd nan 0 0\n", "a.mtl:1", "outside 0…1"),
        (
            "newmtl a\nKd 0 0 0\nKe -1 0 0\n",
            "a.mtl:1",
            "negative or not finite",
        ),
        (
            "newmtl a\nKd 0 0 0\nKe inf 0 0\n",
            "a.mtl:1",
            "negative or not finite",
        ),
        (
            "newmtl a\nKd spectral paint.rfl\n",
            "a.mtl:2",
            "\"spectral paint.rfl\"",
        ),
        ("newmtl a\nKd 1 1\n", "a.mtl:2", "\"1 1\""),
    ] {
        let error = read(&format!("mtllib a.mtl\n{TRIANGLE}"), mtl).unwrap_err();
        assert_eq!(error.place, place, "{error}");
        assert!(error.what.contains(what), "{error}");
    }
}

#[test]
fn an_unused_impossible_material_does_no_harm() {
    let mtl = "newmtl a\nKd 1 1 1\nnewmtl b\nKd 9 9 9\n";
    assert!(read(&format!("mtllib a.mtl\n{TRIANGLE}"), mtl).is_ok());
}

#[test]
fn files_without_faces_are_refused() {
    for obj in ["", "v 0 0 0\n", "v 0 0 0\nv 1 0 0\nf 1 2\n", "# nothing"] {
        let error = read(obj, "").unwrap_err();
        assert_eq!(
            (error.place.as_str(), error.what.as_str()),
            ("a.obj", "no faces")
        );
    }
}

#[test]
fn mutated_text_never_panics() {
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0 1\nv 0 1 -1e3\no b\nusemtl a\nf 1 2 3\nf -3/1 -2//7 -1/2/3 1\n";
    let mtl = "newmtl a\nKd 0.5 0.5 0.5\nKe 1\nd 1\nTr 0\nmap_Kd a.png\n";
    let directory = TempDir::new().unwrap();
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    for _ in 0..3000 {
        for (name, text) in [("a.obj", obj), ("a.mtl", mtl)] {
            let mut bytes = text.as_bytes().to_vec();
            for _ in 0..random.below(4) {
                let at = random.below(bytes.len());
                match random.below(3) {
                    0 => bytes[at] = random.below(256) as u8,
                    1 => bytes[at] = b"0123456789-/\\# \n"[random.below(16)],
                    _ => bytes.truncate(at.max(1)),
                }
            }
            replace_file(&directory.path().join(name), &bytes);
        }
        if let Ok(scene) = read_scene(&directory.path().join("a.obj"), &ReadSettings::default()) {
            check_indices(&scene);
        }
    }
}
