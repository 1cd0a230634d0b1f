//! Irradiance at points of the user's own: a sensor grid laid over a scene.
//!
//! A sensor that lies on a face measures what the face receives there: it is moved onto the face's plane and takes the
//! face's normal, so that coordinates rounded by a file do not put it in the shadow of its own face. One that lies on no
//! face hangs freely in space.

use super::{Solution, World};
use crate::adapt::Receiver;
use crate::direct::DirectLight;
use crate::mesh::barycentric;
use crate::quantity::Irradiance;
use crate::radiosity::IndirectField;
use crate::scene::{FaceId, FaceSide};
use crate::visibility::{BoxTree, Region, Scratch, Viewpoint};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Cosine of the angle (2.6°) up to which a sensor's normal is that of a face.
///
/// Normals written with three decimals are off by 0.06°; neighbouring facets of a finely divided curved surface are some
/// 3° apart and more, and where two agree the better one is taken.
const AGREEMENT: f64 = 0.999;

/// Differences of cosine below this are rounding: such faces agree with a sensor equally well.
const SAME_AGREEMENT: f64 = 1e-9;

/// A point with a direction, in world coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    position: DVec3,
    normal: DVec3,
}

impl Sensor {
    /// A sensor at `position` (metres, world) that looks along `normal` (any length).
    ///
    /// None when a number is not finite or the normal has no direction.
    pub fn new(position: DVec3, normal: DVec3) -> Option<Self> {
        // Scaled first: the square of a very long or short normal would leave the range of f64.
        let size = normal.abs().max_element();
        let normal = (normal / size).try_normalize()?;
        position.is_finite().then_some(Self { position, normal })
    }
}

/// What a sensor receives, W/m².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Straight from the emitters.
    pub direct: Irradiance,
    /// By way of other faces.
    pub indirect: Irradiance,
}

impl Reading {
    /// Direct and indirect together.
    pub fn total(&self) -> Irradiance {
        self.direct + self.indirect
    }
}

/// A sensor for which the display mesh has no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("sensor {index} {place}")]
pub struct NoReading {
    /// Its index in the list.
    pub index: usize,
    /// Where it is instead of on a lit surface.
    pub place: OffMesh,
}

/// Where a sensor is that lies on no lit surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OffMesh {
    /// On no face.
    #[error("lies on no face with its normal")]
    InSpace,
    /// On the back of a face whose material has one side only.
    #[error("lies on the back of face {0}, which has no light of its own")]
    OnBack(FaceId),
}

/// Readings of `sensors`, in their order: direct light exactly, indirect light gathered from the solution (none without).
///
/// Nothing is meshed: without `indirect` a reading costs one exact evaluation of the direct light.
///
/// ```
/// use glam::DVec3;
/// use umbrage::direct::DirectLight;
/// use umbrage::io::builtin::cornell_box;
/// use umbrage::pipeline::{Sensor, World, probe_exact};
/// use umbrage::settings::Settings;
///
/// let world = World::new(&cornell_box(), &Settings::default())?;
/// let light = DirectLight::new(&world.scene, &world.blockers);
/// // On the floor below the lamp, and the same place looking at the floor from above.
/// let place = DVec3::new(0.3, 0.0, 0.1);
/// let sensors = [DVec3::Y, DVec3::NEG_Y].map(|n| Sensor::new(place, n).expect("a direction"));
/// let readings = probe_exact(&world, &light, None, &sensors);
/// assert!(readings[0].direct.mean() > 0.1);
/// assert_eq!(readings[1].total().mean(), 0.0);
/// # Ok::<(), umbrage::bad_input::BadInput>(())
/// ```
pub fn probe_exact(
    world: &World,
    direct: &DirectLight,
    indirect: Option<&IndirectField>,
    sensors: &[Sensor],
) -> Vec<Reading> {
    let scene = &world.scene;
    sensors
        .par_iter()
        .map_init(
            || (Scratch::default(), indirect.map(IndirectField::gatherer)),
            |(scratch, gatherer), sensor| {
                let local = sensor.position - scene.origin;
                let view = match faces_at(world, sensor).first() {
                    Some(&(face, side)) => {
                        let frame = &scene.faces[face].frame;
                        let foot = frame.to_space(frame.to_plane(local));
                        let shading = scene.faces[face].shading_normal(foot) * side.sign();
                        Viewpoint::on_curve(foot, scene.normal(face, side), shading)
                    }
                    None => Viewpoint::new(local, sensor.normal),
                };
                Reading {
                    direct: direct.irradiance(&view, scratch),
                    indirect: match (indirect, gatherer) {
                        (Some(field), Some(gatherer)) => field.gather(gatherer, &view),
                        _ => Irradiance::ZERO,
                    },
                }
            },
        )
        .collect()
}

/// Readings of `sensors`, in their order, from the display mesh: what a viewer shows there.
///
/// # Errors
/// [`NoReading`] for the first sensor that lies on no lit surface.
pub fn probe_mesh(solution: &Solution, sensors: &[Sensor]) -> Result<Vec<Reading>, NoReading> {
    let trees: Vec<BoxTree> = solution.receivers.par_iter().map(element_tree).collect();
    let readings: Vec<Result<Reading, OffMesh>> = sensors
        .par_iter()
        .map(|sensor| shown(solution, &trees, sensor))
        .collect();
    readings
        .into_iter()
        .enumerate()
        .map(|(index, reading)| reading.map_err(|place| NoReading { index, place }))
        .collect()
}

fn shown(solution: &Solution, trees: &[BoxTree], sensor: &Sensor) -> Result<Reading, OffMesh> {
    let scene = &solution.world.scene;
    let mut place = OffMesh::InSpace;
    let mut is_dark = false;
    for (face, side) in faces_at(solution.world, sensor) {
        let index = solution
            .receivers
            .binary_search_by_key(&(face, side), |r| (r.domain.face, r.domain.side));
        let Ok(index) = index else {
            // Backs that reflect but that no light reaches have no mesh.
            match scene.receives(face, side) {
                true => is_dark = true,
                false => place = OffMesh::OnBack(face),
            }
            continue;
        };
        let receiver = &solution.receivers[index];
        let p = receiver
            .domain
            .frame
            .to_plane(sensor.position - scene.origin);
        // Where another face in the same plane is seen instead, this one has no elements.
        if let Some((element, weights)) = locate(receiver, &trees[index], p, reach(solution.world))
        {
            return Ok(interpolate(receiver, element, weights));
        }
    }
    match is_dark {
        true => Ok(Reading::default()),
        false => Err(place),
    }
}

fn interpolate(r: &Receiver, element: usize, weights: [f64; 3]) -> Reading {
    let at = |values: &[Irradiance]| {
        let [a, b, c] = r.mesh.sites[element].map(|s| values[s as usize]);
        a * weights[0] + b * weights[1] + c * weights[2]
    };
    Reading {
        direct: at(&r.direct),
        indirect: at(&r.indirect),
    }
}

/// How far a sensor may be from a face that it lies on, metres: the weld distance, or how far the face itself may bend.
fn reach(world: &World) -> f64 {
    world.scene.weld_distance.max(world.clean.planarity_m)
}

/// The sides that a sensor lies on, best first: with the point inside rather than on the outline, then the best normal,
/// then the smallest, which is seen where faces overlap in one plane.
fn faces_at(world: &World, sensor: &Sensor) -> Vec<(FaceId, FaceSide)> {
    struct Found {
        face: FaceId,
        side: FaceSide,
        is_outside: bool,
        disagreement: f64,
        area: f64,
    }
    let scene = &world.scene;
    let local = sensor.position - scene.origin;
    let reach = reach(world);
    let mut near = Vec::new();
    world.blockers.query(&around(local, reach), |i| {
        near.push(world.blockers.part(i).face)
    });
    near.sort_unstable();
    near.dedup();
    let mut found: Vec<Found> = near
        .into_iter()
        .filter_map(|face| {
            let f = &scene.faces[face];
            let cosine = f.frame.n.dot(sensor.normal);
            let p = f.frame.to_plane(local);
            let is_outside = !f.outline.contains(p);
            let is_on = f.frame.plane().distance(local).abs() <= reach
                && cosine.abs() > AGREEMENT
                && (!is_outside || f.outline.distance_to_outline(p) <= scene.weld_distance);
            is_on.then_some(Found {
                face,
                side: if cosine > 0.0 {
                    FaceSide::Front
                } else {
                    FaceSide::Back
                },
                is_outside,
                disagreement: ((1.0 - cosine.abs()) / SAME_AGREEMENT).round(),
                area: f.area,
            })
        })
        .collect();
    found.sort_by(|a, b| {
        a.is_outside
            .cmp(&b.is_outside)
            .then(a.disagreement.total_cmp(&b.disagreement))
            .then(a.area.total_cmp(&b.area))
            .then(a.face.cmp(&b.face))
    });
    found.into_iter().map(|f| (f.face, f.side)).collect()
}

fn around(p: DVec3, reach: f64) -> Region {
    Region {
        planes: [].into_iter().collect(),
        bounds: (p - reach, p + reach),
    }
}

/// Boxes around the elements, in the plane's coordinates.
fn element_tree(r: &Receiver) -> BoxTree {
    BoxTree::new((0..r.mesh.elements.len()).map(|e| {
        let [a, b, c] = r.mesh.corners(e);
        (a.min(b).min(c).extend(0.0), a.max(b).max(c).extend(0.0))
    }))
}

/// The element that `p` lies in the deepest, and its barycentric coordinates there; none when all are farther than
/// `reach`, metres.
fn locate(r: &Receiver, tree: &BoxTree, p: DVec2, reach: f64) -> Option<(usize, [f64; 3])> {
    let mut best: Option<(f64, usize)> = None;
    tree.query(&around(p.extend(0.0), reach), |e| {
        let e = e as usize;
        let found = (depth(r.mesh.corners(e), p), e);
        // Of equally deep ones the first, in whatever order the tree comes by them.
        if best.is_none_or(|b| found.0 > b.0 || (found.0 >= b.0 && found.1 < b.1)) {
            best = Some(found);
        }
    });
    let (_, e) = best.filter(|b| b.0 >= -reach)?;
    let weights = barycentric(r.mesh.corners(e), p).map(|w| w.max(0.0));
    let sum: f64 = weights.iter().sum();
    Some((e, weights.map(|w| w / sum)))
}

/// Distance from `p` to the nearest edge's line, metres: positive inside the counter-clockwise triangle.
fn depth(t: [DVec2; 3], p: DVec2) -> f64 {
    (0..3)
        .map(|k| {
            let d = t[(k + 1) % 3] - t[k];
            d.perp_dot(p - t[k]) / d.length()
        })
        .fold(f64::INFINITY, f64::min)
}
