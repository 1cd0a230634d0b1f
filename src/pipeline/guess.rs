//! About how much light there is, before anything is meshed: what the error asked for means in W/m².
//!
//! Paths start at points spread evenly over the lit surfaces and end where light is absorbed (Kajiya 1986); at each of their
//! vertices one ray goes to every emitter. In the mean over thousands of them that is right to a few per cent, whatever the
//! number of faces.

use super::World;
use super::random::Pcg;
use crate::direct::DirectLight;
use crate::geom::even_point_in;
use crate::quantity::Rgb;
use crate::radiosity::{Bounces, loss, met};
use crate::scene::{FaceId, FaceSide};
use crate::visibility::{Scratch, Viewpoint};
use glam::DVec3;
use rayon::prelude::*;

/// Paths: where light varies as much as its mean the mean of so many is right to a hundredth and a half.
const PATHS: u32 = 4096;

/// Reflections at most. What comes after so many is told by the ones before.
const MOST_REFLECTIONS: usize = 32;

/// Each ray is any one of so many of an even set.
const MANY_RAYS: u32 = 1 << 24;

/// Mean irradiance over the lit sides, W/m².
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Guess {
    /// Straight from the emitters.
    pub(super) direct: f64,
    /// By way of other faces.
    pub(super) indirect: f64,
}

/// What paths go through.
struct Paths<'p> {
    world: &'p World,
    direct: &'p DirectLight<'p>,
    /// For each face whether its front and its back are lit.
    lit: Vec<[bool; 2]>,
    bounces: Bounces,
}

/// Guesses how much light there is on those of `sides` that are lit.
pub(super) fn guess(
    world: &World,
    direct: &DirectLight,
    sides: &[(FaceId, FaceSide)],
    is_lit: &[bool],
    bounces: Bounces,
) -> Guess {
    let scene = &world.scene;
    let mut lit = vec![[false; 2]; scene.faces.len()];
    let mut starts = Vec::new();
    let (mut area, mut reflected) = (0.0, 0.0);
    for (&(face, side), _) in sides.iter().zip(is_lit).filter(|(_, lit)| **lit) {
        let f = &scene.faces[face];
        lit[usize::from(face)][usize::from(side == FaceSide::Back)] = true;
        reflected += f.area * f.reflectance.0.max_element();
        for t in &f.triangles {
            let corners = t.map(|v| scene.vertices[v]);
            area += triangle_area(corners);
            starts.push((area, corners, scene.normal(face, side)));
        }
    }
    if starts.is_empty() {
        return Guess::default();
    }
    let paths = Paths {
        world,
        direct,
        lit,
        bounces,
    };
    let found: Vec<Vec<f64>> = (0..PATHS)
        .into_par_iter()
        .map_init(Scratch::default, |scratch, i| {
            let at = area * (f64::from(i) + 0.5) / f64::from(PATHS);
            let k = starts.partition_point(|t| t.0 <= at).min(starts.len() - 1);
            let (_, corners, normal) = starts[k];
            let start = Viewpoint::new(even_point_in(corners, i), normal);
            paths.follow(start, i, scratch)
        })
        .collect();
    // Irradiance that has been reflected so many times.
    let mut means = [0.0; MOST_REFLECTIONS + 1];
    for path in &found {
        for (mean, light) in means.iter_mut().zip(path) {
            *mean += light / f64::from(PATHS);
        }
    }
    let [direct, indirect @ ..] = means;
    let reflectance = reflected / area;
    let ambient = direct * reflectance / loss(reflectance);
    Guess {
        direct,
        indirect: with_rest(&indirect, bounces).unwrap_or(ambient),
    }
}

/// The sum of these and of all that come after them, if the bounces are not counted: none where that is more than they are.
fn with_rest(reflected: &[f64; MOST_REFLECTIONS], bounces: Bounces) -> Option<f64> {
    let sum: f64 = reflected.iter().sum();
    if bounces != Bounces::All {
        return Some(sum);
    }
    // Each quarter is about the same share of the one before.
    let quarter = |i: usize| {
        reflected[i * MOST_REFLECTIONS / 4..][..MOST_REFLECTIONS / 4]
            .iter()
            .sum::<f64>()
    };
    let (before, last) = (quarter(2), quarter(3));
    if last <= 0.0 {
        return Some(sum);
    }
    let rest = last * last / (before - last);
    (before > last && rest <= sum).then_some(sum + rest)
}

impl Paths<'_> {
    /// Irradiance at the start of path `i` that has been reflected 0, 1, 2 … times, as the path tells it, W/m², mean of the
    /// channels.
    fn follow(&self, start: Viewpoint, i: u32, scratch: &mut Scratch) -> Vec<f64> {
        let most = match self.bounces {
            Bounces::All => MOST_REFLECTIONS,
            Bounces::Count(n) => MOST_REFLECTIONS.min(n as usize),
        };
        let (mut view, mut weight) = (start, Rgb::grey(1.0));
        let mut found = Vec::new();
        let mut chance = Pcg::new(u64::from(i));
        loop {
            let ray = chance.next() % MANY_RAYS;
            let light = self.direct.by_rays(&view, ray, || chance.unit(), scratch);
            found.push((weight * light.0).mean());
            if found.len() > most {
                return found;
            }
            let ray = chance.next() % MANY_RAYS;
            let Some((reflectance, next)) = self.reflected(&view, ray) else {
                return found;
            };
            // The path ends here or goes on for all that end.
            let goes_on = reflectance.0.max_element();
            if chance.unit() >= goes_on {
                return found;
            }
            weight = weight * reflectance * goes_on.recip();
            view = next;
        }
    }

    /// Where ray `i` of an even set from `view` meets a side that is lit, and what that reflects.
    fn reflected(&self, view: &Viewpoint, i: u32) -> Option<(Rgb, Viewpoint)> {
        let scene = &self.world.scene;
        let (face, side, point) = met(&self.world.blockers, view, i..i + 1).next()?;
        let is_lit = self.lit[usize::from(face)][usize::from(side == FaceSide::Back)];
        let next = Viewpoint::new(point, scene.normal(face, side));
        is_lit.then(|| (scene.faces[face].reflectance, next))
    }
}

fn triangle_area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adapt::Receiver;
    use crate::pipeline::{light, receiver_sides};
    use crate::quantity::{Irradiance, Radiance};
    use crate::scene::{Material, RawPolygon, RawScene};
    use crate::settings::Settings;
    use glam::DVec2;
    use std::f64::consts::TAU;

    const GREY: u32 = 0;
    const LAMP: u32 = 1;

    /// Quads, each with its material, counter-clockwise seen from their fronts.
    fn scene_of(quads: &[([DVec3; 4], u32)]) -> RawScene {
        let corners = |i: usize| (0..4).map(|k| 4 * i as u32 + k).collect();
        let polygon = |i: usize| RawPolygon {
            corners: corners(i),
            material: quads[i].1,
            group: 0,
        };
        let grey = Material {
            reflectance: Rgb::grey(0.6),
            ..Material::default()
        };
        let lamp = Material {
            emission: Radiance(Rgb::grey(10.0)),
            ..Material::default()
        };
        RawScene {
            source: "test".to_owned(),
            positions: quads.iter().flat_map(|q| q.0).collect(),
            polygons: (0..quads.len()).map(polygon).collect(),
            materials: vec![grey, lamp],
            groups: vec!["quads".to_owned()],
            ..RawScene::default()
        }
    }

    /// A parallelogram with its front where `u × v` points.
    fn quad(origin: [f64; 3], u: [f64; 3], v: [f64; 3]) -> [DVec3; 4] {
        let [o, u, v] = [origin, u, v].map(DVec3::from);
        [o, o + u, o + u + v, o + v]
    }

    /// A cube of two metres seen from inside.
    fn room() -> Vec<([DVec3; 4], u32)> {
        let [x, y, z] = [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]];
        let walls = [
            quad([0.0; 3], z, x),
            quad(y, x, z),
            quad([0.0; 3], y, z),
            quad(x, z, y),
            quad([0.0; 3], x, y),
            quad(z, y, x),
        ];
        walls.map(|w| (w, GREY)).into()
    }

    fn is_right(raw: &RawScene) {
        let settings = Settings {
            error: 0.05,
            ..Settings::default()
        };
        let world = World::new(raw, &settings).expect("a scene");
        let solution = light(&world, &settings, &mut |_| ()).expect("it can be lit");
        let lit = solution.receivers.iter().filter(|r| r.is_lit);
        let lit: Vec<_> = lit.map(|r| (r.domain.face, r.domain.side)).collect();
        let sides = receiver_sides(&world.scene);
        let is_lit: Vec<bool> = sides.iter().map(|s| lit.contains(s)).collect();
        let found = guess(&world, &solution.direct, &sides, &is_lit, Bounces::All);
        let known = |part: fn(&Receiver) -> &[Irradiance]| {
            let (mut power, mut area) = (0.0, 0.0);
            for r in solution.receivers.iter().filter(|r| r.is_lit) {
                for (e, sites) in r.mesh.sites.iter().enumerate() {
                    let corners = sites.map(|s| part(r)[s as usize].mean());
                    power += r.mesh.area(e) * corners.iter().sum::<f64>() / 3.0;
                    area += r.mesh.area(e);
                }
            }
            power / area
        };
        // A standard deviation is a hundredth and a half of the mean where light varies as much as that.
        let pairs = [
            (found.direct, known(|r| &r.direct)),
            (found.indirect, known(|r| &r.indirect)),
        ];
        for (guessed, known) in pairs {
            let off = guessed / known - 1.0;
            assert!(off.abs() < 0.06, "{guessed} for {known}");
        }
    }

    /// The room with a lamp at this height, metres; its ceiling is at 2.
    fn room_with_lamp(height: f64) -> RawScene {
        let mut quads = room();
        let lamp = quad([0.7, height, 0.8], [0.5, 0.0, 0.0], [0.0, 0.0, 0.6]);
        quads.push((lamp, LAMP));
        scene_of(&quads)
    }

    /// Rays to it end on the ceiling as well.
    #[test]
    fn a_lamp_in_the_plane_of_a_ceiling_is_seen() {
        is_right(&room_with_lamp(2.0));
    }

    /// Not every vertex of a path asks each facet: a tube of 96, behind a board.
    #[test]
    fn a_lamp_of_many_facets_is_seen_as_one() {
        let mut quads = room();
        let around = |k: u32| DVec2::from_angle(TAU * f64::from(k) / 32.0) * 0.1;
        for k in 0..32 {
            let [a, b] = [around(k), around(k + 1)];
            for ring in 0..3 {
                let [z, end] = [ring, ring + 1].map(|r| 0.4 + 0.4 * f64::from(r));
                let at = |p: DVec2, z: f64| DVec3::new(1.0 + p.x, 1.5 + p.y, z);
                quads.push(([at(a, z), at(b, z), at(b, end), at(a, end)], LAMP));
            }
        }
        let board = quad([0.5, 1.0, 0.5], [0.0, 0.0, 1.0], [0.6, 0.0, 0.0]);
        quads.push((board, GREY));
        is_right(&scene_of(&quads));
    }

    /// All light comes back for ever: the guess is finite, and it is the solver that says so.
    #[test]
    fn a_room_that_absorbs_nothing_has_a_finite_guess() {
        let mut raw = room_with_lamp(1.9);
        for material in &mut raw.materials {
            material.reflectance = Rgb::grey(1.0);
        }
        let world = World::new(&raw, &Settings::default()).expect("a scene");
        let direct = DirectLight::new(&world.scene, &world.blockers);
        let sides = receiver_sides(&world.scene);
        let is_lit = vec![true; sides.len()];
        let found = guess(&world, &direct, &sides, &is_lit, Bounces::All);
        // As often reflected as links take into account, and far more often than the paths follow it.
        let most = found.direct / loss(1.0);
        assert!(found.indirect > 10.0 * found.direct && found.indirect < 1.01 * most);
    }

    /// Most of the window is hidden from a slat, but not what is next to it.
    #[test]
    fn slats_are_lit_by_what_is_next_to_them() {
        let mut quads = room();
        let window = quad([0.5, 0.5, 0.001], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        quads.push((window, LAMP));
        for i in 0..16 {
            let y = 0.5 + f64::from(i) / 16.0;
            let slat = quad([0.5, y, 0.05], [0.0, 0.02, 0.06], [1.0, 0.0, 0.0]);
            quads.push((slat, GREY));
        }
        is_right(&scene_of(&quads));
    }
}
