//! The scene that needs no file: the Cornell box, as measured.
//!
//! Geometry, camera and spectra: Cornell University Program of Computer Graphics, "Cornell Box Data",
//! <https://www.graphics.cornell.edu/online/box/data.html>, in millimetres. Seen from the camera:
//!
//! ```text
//!            ceiling, light in it
//!          +----------------------+        y
//!   red   / |     back wall      | \       |  z (away from the camera)
//!  x≈553 /  +--------------------+  \ x=0  | /
//!       /         floor              \ green
//!                                    x --- +     x grows to the left
//! ```

#[cfg(test)]
mod spectra;

use crate::quantity::{Radiance, Rgb};
use crate::scene::{Camera, Material, RawPolygon, RawScene};
use glam::DVec3;

/// Name of the built-in scene in messages and outputs.
const NAME: &str = "cornell-box";

/// The published surfaces are measured as spectra, 400–700 nm. These are their renditions in linear sRGB: the mean of each
/// spectrum weighted by the matching function of a channel (CIE 1931 observer in the analytic fit of Wyman, Sloan and
/// Shirley, "Simple Analytic Approximations to the CIE XYZ Color Matching Functions", JCGT 2(2), 2013, times the XYZ to
/// sRGB matrix), so that a constant spectrum keeps its value in all channels and no reflectance can leave 0…1 by a
/// change of white point. Rounded to four places; the tests hold the spectra and repeat the sum.
const WHITE: Rgb = Rgb::new(0.7378, 0.7361, 0.7376);
/// The left wall; see [`WHITE`].
const RED: Rgb = Rgb::new(0.4718, 0.0469, 0.0489);
/// The right wall; see [`WHITE`].
const GREEN: Rgb = Rgb::new(0.0874, 0.3985, 0.0842);
/// What the light reflects: 0.78 at all published wavelengths.
const LIGHT_REFLECTANCE: Rgb = Rgb::grey(0.78);
/// Emission of the light, published as 0, 8.0, 15.6, 18.4 at 400, 500, 600, 700 nm without a unit; straight lines between
/// them, weighted as [`WHITE`], and taken as W/(m² sr).
const LIGHT_EMISSION: Rgb = Rgb::new(17.2005, 11.4727, 3.0589);

/// Height and width of the camera's film over its focal length: 25 mm, 35 mm.
const FILM_OVER_FOCAL_LENGTH: f64 = 25.0 / 35.0;

/// One object: its name, its material (index into the list below), and its quads in millimetres.
type Object = (&'static str, u32, &'static [[[f64; 3]; 4]]);

const MATERIALS: [(&str, Rgb, Rgb); 4] = [
    ("white", WHITE, Rgb::BLACK),
    ("red", RED, Rgb::BLACK),
    ("green", GREEN, Rgb::BLACK),
    ("light", LIGHT_REFLECTANCE, LIGHT_EMISSION),
];

/// The quads as published, in the published order of corners: counter-clockwise from inside the room, and from outside
/// the blocks. The left wall is not planar (its foot is 3.2 mm out), the light lies in the plane of the ceiling.
#[rustfmt::skip]
const OBJECTS: [Object; 8] = [
    ("floor", 0, &[
        [[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 559.2], [549.6, 0.0, 559.2]],
    ]),
    ("light", 3, &[
        [[343.0, 548.8, 227.0], [343.0, 548.8, 332.0], [213.0, 548.8, 332.0], [213.0, 548.8, 227.0]],
    ]),
    ("ceiling", 0, &[
        [[556.0, 548.8, 0.0], [556.0, 548.8, 559.2], [0.0, 548.8, 559.2], [0.0, 548.8, 0.0]],
    ]),
    ("back wall", 0, &[
        [[549.6, 0.0, 559.2], [0.0, 0.0, 559.2], [0.0, 548.8, 559.2], [556.0, 548.8, 559.2]],
    ]),
    ("right wall", 2, &[
        [[0.0, 0.0, 559.2], [0.0, 0.0, 0.0], [0.0, 548.8, 0.0], [0.0, 548.8, 559.2]],
    ]),
    ("left wall", 1, &[
        [[552.8, 0.0, 0.0], [549.6, 0.0, 559.2], [556.0, 548.8, 559.2], [556.0, 548.8, 0.0]],
    ]),
    ("short block", 0, &[
        [[130.0, 165.0, 65.0], [82.0, 165.0, 225.0], [240.0, 165.0, 272.0], [290.0, 165.0, 114.0]],
        [[290.0, 0.0, 114.0], [290.0, 165.0, 114.0], [240.0, 165.0, 272.0], [240.0, 0.0, 272.0]],
        [[130.0, 0.0, 65.0], [130.0, 165.0, 65.0], [290.0, 165.0, 114.0], [290.0, 0.0, 114.0]],
        [[82.0, 0.0, 225.0], [82.0, 165.0, 225.0], [130.0, 165.0, 65.0], [130.0, 0.0, 65.0]],
        [[240.0, 0.0, 272.0], [240.0, 165.0, 272.0], [82.0, 165.0, 225.0], [82.0, 0.0, 225.0]],
    ]),
    ("tall block", 0, &[
        [[423.0, 330.0, 247.0], [265.0, 330.0, 296.0], [314.0, 330.0, 456.0], [472.0, 330.0, 406.0]],
        [[423.0, 0.0, 247.0], [423.0, 330.0, 247.0], [472.0, 330.0, 406.0], [472.0, 0.0, 406.0]],
        [[472.0, 0.0, 406.0], [472.0, 330.0, 406.0], [314.0, 330.0, 456.0], [314.0, 0.0, 456.0]],
        [[314.0, 0.0, 456.0], [314.0, 330.0, 456.0], [265.0, 330.0, 296.0], [265.0, 0.0, 296.0]],
        [[265.0, 0.0, 296.0], [265.0, 330.0, 296.0], [423.0, 330.0, 247.0], [423.0, 0.0, 247.0]],
    ]),
];

/// The Cornell box: 16 quads, one light in the plane of the ceiling, one camera in front of the open side.
///
/// The published coordinates are right-handed with y up as they stand: for a camera that looks along +z, +x is on the
/// left. Backs neither reflect nor emit; no light of an open box can come round to them.
pub fn cornell_box() -> RawScene {
    let mut scene = RawScene {
        source: NAME.to_owned(),
        materials: MATERIALS.map(material).to_vec(),
        cameras: vec![published_camera()],
        ..RawScene::default()
    };
    for (group, (name, material, quads)) in (0u32..).zip(OBJECTS) {
        scene.groups.push(name.to_owned());
        for quad in quads {
            let corners = quad.map(|corner| position_index(&mut scene.positions, corner));
            scene.polygons.push(RawPolygon {
                corners: corners.to_vec(),
                material,
                group,
            });
        }
    }
    scene
}

fn material((name, reflectance, emission): (&str, Rgb, Rgb)) -> Material {
    Material {
        name: name.to_owned(),
        reflectance,
        emission: Radiance(emission),
        ..Material::default()
    }
}

/// Index of a corner given in millimetres. Corners that are published with the same numbers share a position.
fn position_index(positions: &mut Vec<DVec3>, millimetres: [f64; 3]) -> u32 {
    let position = DVec3::from_array(millimetres) / 1000.0;
    let found = positions.iter().position(|&known| known == position);
    let index = found.unwrap_or_else(|| {
        positions.push(position);
        positions.len() - 1
    });
    u32::try_from(index).expect("the box has 64 corners")
}

fn published_camera() -> Camera {
    Camera {
        name: "published camera".to_owned(),
        eye: DVec3::new(278.0, 273.0, -800.0) / 1000.0,
        forward: DVec3::Z,
        up: DVec3::Y,
        vertical_fov_rad: 2.0 * (FILM_OVER_FOCAL_LENGTH / 2.0).atan(),
        aspect: Some(1.0),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    /// Twice the vector area of a polygon: along its normal, whether planar or not.
    fn normal(scene: &RawScene, polygon: &RawPolygon) -> DVec3 {
        let at = |i: usize| scene.positions[polygon.corners[i % polygon.corners.len()] as usize];
        (0..polygon.corners.len())
            .map(|i| at(i).cross(at(i + 1)))
            .sum()
    }

    fn centre(scene: &RawScene, polygon: &RawPolygon) -> DVec3 {
        let sum: DVec3 = polygon
            .corners
            .iter()
            .map(|&c| scene.positions[c as usize])
            .sum();
        sum / polygon.corners.len() as f64
    }

    #[test]
    fn the_room_faces_inwards_and_the_blocks_outwards() {
        let scene = cornell_box();
        assert_eq!(scene.polygons.len(), 16);
        let room = DVec3::new(0.278, 0.274, 0.28);
        for polygon in &scene.polygons {
            let name = &scene.groups[polygon.group as usize];
            let inside = if name.ends_with("block") {
                let of_block = scene.polygons.iter().filter(|p| p.group == polygon.group);
                let centres: Vec<_> = of_block.map(|p| centre(&scene, p)).collect();
                centres.iter().sum::<DVec3>() / centres.len() as f64
            } else {
                room
            };
            let towards = (inside - centre(&scene, polygon)).dot(normal(&scene, polygon));
            assert_eq!(towards > 0.0, !name.ends_with("block"), "{name}");
        }
    }

    #[test]
    fn the_light_faces_down_and_alone_emits() {
        let scene = cornell_box();
        let emitting = |p: &&RawPolygon| scene.materials[p.material as usize].is_emitter();
        let lights: Vec<_> = scene.polygons.iter().filter(emitting).collect();
        assert_eq!(lights.len(), 1);
        let n = normal(&scene, lights[0]);
        assert!(n.y < 0.0 && n.x.abs() < 1e-12 && n.z.abs() < 1e-12);
        assert!((n.length() / 2.0 - 0.130 * 0.105).abs() < 1e-12);
    }

    #[test]
    fn the_camera_sees_red_on_the_left_and_green_on_the_right() {
        let scene = cornell_box();
        let camera = &scene.cameras[0];
        let right = camera.forward.cross(camera.up);
        let side = |group: &str| {
            let index = scene.groups.iter().position(|name| name == group).unwrap();
            let wall = scene
                .polygons
                .iter()
                .find(|p| p.group as usize == index)
                .unwrap();
            let colour = scene.materials[wall.material as usize].name.clone();
            (colour, right.dot(centre(&scene, wall) - camera.eye) > 0.0)
        };
        assert_eq!(side("left wall"), ("red".to_owned(), false));
        assert_eq!(side("right wall"), ("green".to_owned(), true));
        assert!((camera.vertical_fov_rad.to_degrees() - 39.3077).abs() < 1e-4);
    }

    #[test]
    fn coordinates_are_metres() {
        let scene = cornell_box();
        let top = scene.positions.iter().fold(DVec3::ZERO, |a, &b| a.max(b));
        assert_eq!(top, DVec3::new(0.556, 0.5488, 0.5592));
    }
}
