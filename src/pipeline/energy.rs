//! Where the power goes: what the emitters send out is absorbed or leaves the scene.
//!
//! Emitted is known from the materials and absorbed from the light that the meshes show. What leaves is found by another way
//! than the light was: rays from the emitters and from what the meshes reflect, each standing for the same power, are
//! followed to the first surface. Light that was lost or made on the way shows as imbalance.

use super::Solution;
use crate::adapt::Receiver;
use crate::quantity::Rgb;
use crate::radiosity::Bounces;
use crate::scene::{FaceId, FaceSide};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// So many rays over the relative error asked for, within limits. They are spread evenly, and what they miss is less than one
/// over the root of their number: with an escaping half of the power a tenth of the error asked for.
const RAYS_TIMES_ERROR: f64 = 100.0;
const FEWEST_RAYS: f64 = 4096.0;
const MOST_RAYS: f64 = 262_144.0;

/// Powers of 1/φ, φ⁵ = φ + 1: steps along four axes that fill the cube evenly (Roberts 2018, after Kronecker).
const KRONECKER: [f64; 4] = [
    0.856_674_883_854_502_9,
    0.733_891_856_627_126,
    0.628_706_721_037_808_7,
    0.538_597_257_223_609_8,
];

/// The account of one run, W in three channels.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Energy {
    /// What the emitters send out.
    pub emitted_w: [f64; 3],
    /// What stays: of the light that the meshes show, and what falls on lamps and backs that reflect nothing.
    pub absorbed_w: [f64; 3],
    /// What leaves the scene, by rays.
    pub escaped_w: [f64; 3],
    /// What would have been reflected on, had more bounces been asked for.
    pub unfollowed_w: [f64; 3],
    /// Emitted less all others, over emitted, channels taken together; nothing of nothing.
    pub imbalance: f64,
    /// Whether that is within the error asked for.
    pub is_balanced: bool,
    /// Rays that were followed.
    pub rays: usize,
}

/// A triangle that sends light.
struct Source {
    corners: [DVec3; 3],
    normal: DVec3,
    face: FaceId,
    /// Radiosity at the corners, W/m².
    light: [Rgb; 3],
    /// W, mean of the channels.
    power: f64,
}

impl Source {
    fn new(corners: [DVec3; 3], normal: DVec3, face: FaceId, light: [Rgb; 3]) -> Self {
        let area = 0.5
            * (corners[1] - corners[0])
                .cross(corners[2] - corners[0])
                .length();
        let mean = (light[0] + light[1] + light[2]).mean() / 3.0;
        Self {
            corners,
            normal,
            face,
            light,
            power: area * mean,
        }
    }
}

/// Where a ray ends.
enum End {
    /// Outside.
    Escaped,
    /// On a side whose light no mesh shows: it reflects nothing.
    Black,
    /// On a side that the meshes tell of.
    Told,
}

/// The account of `solution`. None for counted bounces but zero: how much of the light has made the last of them is not
/// known.
pub(super) fn energy(solution: &Solution) -> Option<Energy> {
    let error = solution.settings.error;
    let is_direct = match solution.settings.bounces {
        Bounces::All => false,
        // Light that is never reflected is direct light.
        Bounces::Count(0) => true,
        Bounces::Count(_) => return None,
    };
    let (mut emitted, mut absorbed, mut unfollowed) = (Rgb::BLACK, Rgb::BLACK, Rgb::BLACK);
    let mut sources = emitters(solution);
    for source in &sources {
        emitted += power(source);
    }
    for r in solution.receivers.iter().filter(|r| r.is_lit) {
        let reflectance = solution.world.scene.faces[r.domain.face].reflectance;
        let arriving = r.power().0;
        let reflected = arriving * reflectance;
        absorbed += arriving - reflected;
        if is_direct {
            unfollowed += reflected;
        } else {
            sources.extend(reflecting(solution, r, reflectance));
        }
    }
    let rays = (RAYS_TIMES_ERROR / error).clamp(FEWEST_RAYS, MOST_RAYS) as u32;
    let [escaped, black] = follow(solution, &sources, rays);
    absorbed += black;
    let rest = emitted - absorbed - escaped - unfollowed;
    let imbalance = if emitted.mean() > 0.0 {
        rest.mean() / emitted.mean()
    } else {
        rest.mean()
    };
    Some(Energy {
        emitted_w: emitted.to_array(),
        absorbed_w: absorbed.to_array(),
        escaped_w: escaped.to_array(),
        unfollowed_w: unfollowed.to_array(),
        imbalance,
        is_balanced: imbalance.abs() <= error,
        rays: rays as usize,
    })
}

/// The emitters as triangles.
fn emitters(solution: &Solution) -> Vec<Source> {
    let scene = &solution.world.scene;
    let mut sources = Vec::new();
    for polygon in &solution.direct.polygons {
        let c = &polygon.corners;
        for i in 2..c.len() {
            sources.push(Source::new(
                [c[0], c[i - 1], c[i]],
                polygon.plane.normal,
                scene.emitters[polygon.emitter].face,
                [polygon.exitance.0; 3],
            ));
        }
    }
    sources
}

/// What a receiver reflects, by the elements of its mesh.
fn reflecting<'s>(
    solution: &'s Solution,
    r: &'s Receiver,
    reflectance: Rgb,
) -> impl Iterator<Item = Source> + 's {
    let normal = solution.world.scene.normal(r.domain.face, r.domain.side);
    (0..r.mesh.elements.len()).map(move |e| {
        Source::new(
            r.mesh.corners(e).map(|p| r.domain.frame.to_space(p)),
            normal,
            r.domain.face,
            r.mesh.sites[e].map(|s| reflectance * r.site_total(s as usize).0),
        )
    })
}

/// Exact power of a triangle whose light is linear, W.
fn power(source: &Source) -> Rgb {
    let [a, b, c] = source.corners;
    let [x, y, z] = source.light;
    (x + y + z) * (0.5 * (b - a).cross(c - a).length() / 3.0)
}

/// Power that escapes and power that ends on black sides: `count` rays in all, each from its equal share of the power.
fn follow(solution: &Solution, sources: &[Source], count: u32) -> [Rgb; 2] {
    let mut sums = Vec::with_capacity(sources.len());
    let mut sum = 0.0;
    for source in sources {
        sum += source.power.max(0.0);
        sums.push(sum);
    }
    if sum <= 0.0 {
        return [Rgb::BLACK; 2];
    }
    let share = sum / f64::from(count);
    let ends: Vec<(End, Rgb)> = (0..count)
        .into_par_iter()
        .map(|i| {
            let [a, b, c, d] = KRONECKER.map(|step| (step * f64::from(i + 1)).fract());
            // The middle of each share: rounding cannot move it to a neighbour.
            let at = share * (f64::from(i) + 0.5);
            let source = &sources[sums.partition_point(|&s| s < at).min(sources.len() - 1)];
            let root = a.sqrt();
            let weights = [1.0 - root, root * (1.0 - b), root * b];
            let (mut point, mut light) = (DVec3::ZERO, Rgb::BLACK);
            for ((w, p), l) in weights.iter().zip(source.corners).zip(source.light) {
                point += p * *w;
                light += l * *w;
            }
            let [x, y, z] = source.light;
            // As much power as the light here has of the mean over the triangle.
            let power = light * (3.0 * share / (x + y + z).mean());
            (end(solution, source, point, [c, d]), power)
        })
        .collect();
    let mut found = [Rgb::BLACK; 2];
    for (end, power) in ends {
        match end {
            End::Escaped => found[0] += power,
            End::Black => found[1] += power,
            End::Told => {}
        }
    }
    found
}

/// Where the ray from `point` of `source` ends that `u` (two numbers 0…1) chooses by the cosine law.
fn end(solution: &Solution, source: &Source, point: DVec3, u: [f64; 2]) -> End {
    let world = solution.world;
    let (sin, cos) = (TAU * u[1]).sin_cos();
    let x = source.normal.any_orthonormal_vector();
    let y = source.normal.cross(x);
    let dir = (x * cos + y * sin) * u[0].sqrt() + source.normal * (1.0 - u[0]).sqrt();
    let blockers = &world.blockers;
    let hit = blockers
        .rays()
        .nearest_where(point, dir, 0.0, f64::INFINITY, |h| {
            let face = blockers.ray_owner(h.triangle);
            // A lamp lies in the plane of its ceiling, but for rounding: neither hides the other.
            let plane = world.scene.faces[face].frame.plane();
            face != source.face && plane.distance(point).abs() > world.scene.weld_distance
        });
    let Some(hit) = hit else {
        return End::Escaped;
    };
    let side = if hit.is_front {
        FaceSide::Front
    } else {
        FaceSide::Back
    };
    let face = blockers.ray_owner(hit.triangle);
    let is_told = world.scene.receives(face, side) && !world.scene.faces[face].is_pure_emitter();
    if is_told { End::Told } else { End::Black }
}
