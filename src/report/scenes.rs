//! Scenes that need no file: what the report measures when it is given none, and how cost and stability are tried.

use crate::io::builtin::cornell_box;
use crate::quantity::{Radiance, Rgb};
use crate::radiosity::Bounces;
use crate::scene::{Camera, Material, RawPolygon, RawScene};
use glam::DVec3;
use std::f64::consts::PI;

/// A scene of the report, and how much of its light is measured.
pub struct ReportScene {
    /// Name in tables.
    pub name: String,
    /// The scene.
    pub raw: RawScene,
    /// Direct light alone, or all of it.
    pub bounces: Bounces,
}

/// The built-in scenes: a room with all of its light, a soft shadow, and one with a contact.
pub fn default_scenes() -> Vec<ReportScene> {
    let of = |raw: RawScene, bounces| ReportScene {
        name: raw.source.clone(),
        raw,
        bounces,
    };
    vec![
        of(cornell_box(), Bounces::All),
        of(square_over_square(), Bounces::Count(0)),
        of(box_on_floor(), Bounces::Count(0)),
    ]
}

/// A square lamp over a parallel square over a floor: the penumbra's outer half side is 1.5 m, the umbra's 0.5 m.
pub fn square_over_square() -> RawScene {
    let mut scene = Builder::new("square over square");
    scene.floor(3.0);
    scene.lamp([-0.5, 2.0, -0.5], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    scene.rectangle(
        "blocker",
        MATTE,
        [-0.5, 1.0, 0.5],
        [1.0, 0.0, 0.0],
        [0.0, 0.0, -1.0],
    );
    scene.raw
}

/// A box that stands on a floor, turned against the lamp: the light jumps where it stands, and nothing is parallel.
pub fn box_on_floor() -> RawScene {
    let mut scene = Builder::new("box on floor");
    scene.floor(3.0);
    scene.lamp([-1.0, 3.0, -1.0], [0.8, 0.0, 0.0], [0.0, 0.0, 0.8]);
    scene.cuboid("box", [0.3, 0.0, -0.2], [0.6, 0.8, 0.7], 0.5);
    scene.raw
}

/// A floor under a lamp behind `n` slats that stand like a blind: narrow penumbrae, many parallel edges.
pub fn blinds(n: usize) -> RawScene {
    let mut scene = Builder::new(&format!("blinds {n}"));
    scene.floor(2.0);
    scene.lamp([-1.0, 3.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]);
    let pitch = 2.4 / n as f64;
    for i in 0..n {
        let x = -1.2 + (i as f64 + 0.5) * pitch;
        scene.rectangle(
            "slats",
            MATTE,
            [x, 1.0, 1.2],
            [0.4 * pitch, 0.2 * pitch, 0.0],
            [0.0, 0.0, -2.4],
        );
    }
    scene.raw
}

/// `n × n` boxes of uneven height on a floor, turned against each other and against the lamp.
pub fn city(n: usize) -> RawScene {
    let mut scene = Builder::new(&format!("city {n} × {n}"));
    scene.floor(2.0);
    scene.lamp([-0.7, 4.0, -0.7], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let pitch = 3.6 / n as f64;
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let at = |k: usize| -1.8 + (k as f64 + 0.5) * pitch;
        // Heights and turns that no two neighbours share, without a random number.
        let uneven = ((7 * i + 11 * j) % 13) as f64 / 13.0;
        let size = [0.4 * pitch, (0.4 + 0.8 * uneven) * pitch, 0.5 * pitch];
        scene.cuboid("boxes", [at(i), 0.0, at(j)], size, PI * uneven);
    }
    scene.raw
}

/// A closed cube whose walls shine with `M = 1 − ρ` W/m² and reflect ρ: everywhere `E = B = 1` (W/m²), for every ρ < 1.
pub fn furnace(reflectance: f64) -> RawScene {
    let mut scene = Builder::new(&format!("furnace ρ = {reflectance}"));
    scene.raw.materials[MATTE as usize] = Material {
        name: "wall".to_owned(),
        reflectance: Rgb::grey(reflectance),
        emission: Radiance(Rgb::grey((1.0 - reflectance) / PI)),
        ..Material::default()
    };
    scene.room([0.0; 3], [1.0; 3]);
    scene.raw
}

/// A room of 4 × 3 × 3 m with a lamp behind a wall that leaves a gap of `gap` metres: nearly all light is indirect.
pub fn door_ajar(gap: f64) -> RawScene {
    let mut scene = Builder::new(&format!("door ajar {gap} m"));
    scene.room([0.0; 3], [4.0, 3.0, 3.0]);
    scene.lamp([0.3, 2.99, 1.0], [0.8, 0.0, 0.0], [0.0, 0.0, 0.8]);
    scene.rectangle(
        "door",
        MATTE,
        [1.5, 0.0, 0.0],
        [0.0, 3.0, 0.0],
        [0.0, 0.0, 3.0 - gap],
    );
    scene.raw
}

/// `raw` with every position `scale` times as far out and moved by `shift` metres along all axes.
pub fn moved(mut raw: RawScene, name: &str, scale: f64, shift: f64) -> RawScene {
    raw.source = name.to_owned();
    for p in &mut raw.positions {
        *p = *p * scale + shift;
    }
    for camera in &mut raw.cameras {
        camera.eye = camera.eye * scale + shift;
    }
    raw
}

/// A view of what lies around the origin.
fn from_above() -> Camera {
    let eye = DVec3::new(3.5, 5.0, 6.0);
    let forward = -eye.normalize();
    Camera {
        name: "from above".to_owned(),
        eye,
        forward,
        up: forward.cross(DVec3::Y).cross(forward).normalize(),
        vertical_fov_rad: 0.7,
        aspect: None,
    }
}

/// The materials of a builder: what blocks and is lit, and what shines.
const MATTE: u32 = 0;
const LAMP: u32 = 1;

/// Radiance of the lamps, W/(m² sr).
const LAMP_RADIANCE: f64 = 10.0;

pub(super) struct Builder {
    pub(super) raw: RawScene,
}

impl Builder {
    pub(super) fn new(name: &str) -> Self {
        let matte = Material {
            name: "matte".to_owned(),
            reflectance: Rgb::grey(0.5),
            reflects_back: true,
            ..Material::default()
        };
        let lamp = Material {
            name: "lamp".to_owned(),
            emission: Radiance(Rgb::grey(LAMP_RADIANCE)),
            ..Material::default()
        };
        Self {
            raw: RawScene {
                source: name.to_owned(),
                materials: vec![matte, lamp],
                cameras: vec![from_above()],
                ..RawScene::default()
            },
        }
    }

    /// A matte square in the plane y = 0 about the origin, `half` metres to each side.
    fn floor(&mut self, half: f64) {
        let [corner, u, v] = [
            [-half, 0.0, half],
            [2.0 * half, 0.0, 0.0],
            [0.0, 0.0, -2.0 * half],
        ];
        self.rectangle("floor", MATTE, corner, u, v);
    }

    /// The parallelogram at `corner` along `u` and `v`; `u × v` is its front.
    pub(super) fn rectangle(
        &mut self,
        group: &str,
        material: u32,
        corner: [f64; 3],
        u: [f64; 3],
        v: [f64; 3],
    ) {
        let [p, u, v] = [corner, u, v].map(DVec3::from_array);
        self.polygon(group, material, &[p, p + u, p + u + v, p + v]);
    }

    /// A material that reflects and shines alike in all channels; exitance in W/m².
    pub(super) fn material(&mut self, reflectance: f64, exitance: f64) -> u32 {
        let materials = &mut self.raw.materials;
        materials.push(Material {
            name: format!("material {}", materials.len()),
            reflectance: Rgb::grey(reflectance),
            emission: Radiance(Rgb::grey(exitance / PI)),
            ..Material::default()
        });
        materials.len() as u32 - 1
    }

    fn lamp(&mut self, corner: [f64; 3], u: [f64; 3], v: [f64; 3]) {
        self.rectangle("lamp", LAMP, corner, u, v);
    }

    fn polygon(&mut self, group: &str, material: u32, corners: &[DVec3]) {
        let raw = &mut self.raw;
        let known = raw.groups.iter().position(|g| g == group);
        let group = known.unwrap_or_else(|| {
            raw.groups.push(group.to_owned());
            raw.groups.len() - 1
        });
        let first = raw.positions.len() as u32;
        raw.positions.extend_from_slice(corners);
        raw.polygons.push(RawPolygon {
            corners: (first..first + corners.len() as u32).collect(),
            material,
            group: group as u32,
        });
    }

    /// A box with its foot's middle at `foot`, turned about y, without its bottom.
    fn cuboid(&mut self, group: &str, foot: [f64; 3], [x, y, z]: [f64; 3], turn_rad: f64) {
        let foot = DVec3::from_array(foot);
        let (sin, cos) = turn_rad.sin_cos();
        let at = |i: f64, j: f64, k: f64| {
            let (a, b) = (i * x / 2.0, k * z / 2.0);
            foot + DVec3::new(a * cos + b * sin, j * y, b * cos - a * sin)
        };
        let ring = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
        let top = ring.map(|(i, k)| at(i, 1.0, k));
        self.polygon(group, MATTE, &top);
        for s in 0..4 {
            let ((i, k), (l, m)) = (ring[s], ring[(s + 1) % 4]);
            let side = [at(i, 0.0, k), at(l, 0.0, m), at(l, 1.0, m), at(i, 1.0, k)];
            self.polygon(group, MATTE, &side);
        }
    }

    /// The inside of a box.
    pub(super) fn room(&mut self, low: [f64; 3], high: [f64; 3]) {
        let [[a, b, c], [x, y, z]] = [low, high];
        let p = |x, y, z| DVec3::new(x, y, z);
        let walls = [
            ("floor", [p(a, b, z), p(x, b, z), p(x, b, c), p(a, b, c)]),
            ("ceiling", [p(a, y, c), p(x, y, c), p(x, y, z), p(a, y, z)]),
            ("wall 1", [p(a, b, c), p(x, b, c), p(x, y, c), p(a, y, c)]),
            ("wall 2", [p(x, b, z), p(a, b, z), p(a, y, z), p(x, y, z)]),
            ("wall 3", [p(a, b, z), p(a, b, c), p(a, y, c), p(a, y, z)]),
            ("wall 4", [p(x, b, c), p(x, b, z), p(x, y, z), p(x, y, c)]),
        ];
        for (name, corners) in walls {
            self.polygon(name, MATTE, &corners);
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;
    use crate::pipeline::World;
    use crate::settings::Settings;

    #[test]
    fn all_scenes_are_clean_as_they_stand() {
        let all = default_scenes().into_iter().map(|s| s.raw).skip(1);
        let more = [blinds(5), city(3), furnace(0.5)];
        for raw in all.chain(more) {
            let world = World::new(&raw, &Settings::default()).unwrap();
            assert!(
                world.warnings.is_empty(),
                "{}: {:?}",
                raw.source,
                world.warnings
            );
            assert_eq!(world.clean.faces, raw.polygons.len(), "{}", raw.source);
        }
    }

    #[test]
    fn boxes_and_rooms_show_their_fronts_to_the_light() {
        // Volume by the divergence theorem: a box with its (missing) bottom at y = 0 counts positive, a room negative.
        let volume = |raw: &RawScene, group: &str| -> f64 {
            let of = |p: &&RawPolygon| raw.groups[p.group as usize].starts_with(group);
            let fan = |p: &RawPolygon| {
                let at = |i: usize| raw.positions[p.corners[i] as usize];
                (1..p.corners.len() - 1)
                    .map(|i| at(0).dot(at(i).cross(at(i + 1))) / 6.0)
                    .sum::<f64>()
            };
            raw.polygons.iter().filter(of).map(fan).sum()
        };
        assert!((volume(&box_on_floor(), "box") - 0.6 * 0.8 * 0.7).abs() < 1e-12);
        assert!((volume(&furnace(0.5), "") + 1.0).abs() < 1e-12);
    }
}
