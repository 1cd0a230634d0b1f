//! Planes of blockers that cut an emitter: where the blocker is seen edge-on, the slope of the light jumps (D1).
//!
//! On both sides of such a plane a flat blocker hides the emitter the more the farther the plane is away, and a solid
//! hides it with one or the other rim of the face: the hidden part grows linearly, at another rate on each side.
//!
//! ```text
//!      S ────────── the emitter, cut by the plane in a segment S
//!       \    /
//!        \  F       the blocker's face, which lies in the plane
//!         \ │\
//!   ───────lines──  a receiver: lit by some point of S past F
//! ```

mod plane_view;

use self::plane_view::{Cell, Feature, Obstacle, PlaneView, Stretch};
use super::event::Search;
use super::landing::Landing;
use super::wedge::{self, Cut};
use super::{Cause, Discontinuity, DiscontinuityOrder, EventKind};
use crate::budget::Meter;
use crate::direct::{DirectLight, EmitterPolygon};
use crate::geom::Plane;
use crate::scene::{EmitterId, FaceId, FaceSide, Scene};
use crate::visibility::{Region, Scratch, Viewpoint};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use smallvec::SmallVec;
use std::collections::HashMap;

/// The lines of all faces' planes, for all emitters; of those that are left when time is up, none.
pub(super) fn find(search: &Search, meter: &Meter) -> Vec<Discontinuity> {
    let (scene, light) = (search.scene, search.light);
    let faces: Vec<FaceId> = scene.faces.ids().collect();
    let found: Vec<Vec<Discontinuity>> = faces
        .par_iter()
        .filter(|_| !meter.is_late())
        .map(|&face| {
            let mut out = Vec::new();
            let corners = scene.faces[face].loops.iter().flatten();
            let corners: SmallVec<[DVec3; 8]> = corners.map(|&v| scene.vertices[v]).collect();
            for emitter in search.that_reach(&corners) {
                if search.is_within_reach(emitter, &corners)
                    && search.is_plane_worth(emitter, face, &corners)
                {
                    past_face(search, light.polygons_of(emitter), face, &mut out);
                }
            }
            out
        })
        .collect();
    found.into_iter().flatten().collect()
}

/// The lines of the plane of `face`, for the emitter made of `polygons`.
fn past_face(
    search: &Search,
    polygons: &[EmitterPolygon],
    face: FaceId,
    out: &mut Vec<Discontinuity>,
) {
    let (scene, light) = (search.scene, search.light);
    let emitter = polygons[0].emitter;
    if scene.emitters[emitter].face == face {
        return;
    }
    let plane = scene.faces[face].frame.plane();
    let mut stretches = Vec::new();
    for polygon in polygons {
        if let Some(strip) = Strip::new(scene, polygon, face, plane) {
            strip.landings(search, &mut stretches);
        }
    }
    let mut scratch = Scratch::default();
    for l in united(stretches, scene.weld_distance) {
        let jump = jump_at(scene, light, emitter, &l, &mut scratch);
        if jump > 0.0
            && jump >= search.least
            && l.face != face
            && l.ends[0].distance(l.ends[1]) > scene.weld_distance
        {
            out.push(Discontinuity {
                face: l.face,
                side: l.side,
                ends: l.ends,
                order: DiscontinuityOrder::D1,
                kind: EventKind::EdgeOn,
                emitter: Some(emitter),
                cause: Cause::Face(face),
                jump,
            });
        }
    }
}

/// What the whole emitter gives, unoccluded, at the middle of a stretch, W/m².
fn jump_at(
    scene: &Scene,
    light: &DirectLight,
    emitter: EmitterId,
    landing: &Landing,
    scratch: &mut Scratch,
) -> f64 {
    let middle = 0.5 * (landing.ends[0] + landing.ends[1]);
    let view = Viewpoint::new(middle, scene.normal(landing.face, landing.side));
    light.unoccluded_from(emitter, &view, scratch).mean()
}

/// The plane of a face, from the segment in which it cuts an emitter on.
struct Strip<'s> {
    scene: &'s Scene,
    face: FaceId,
    plane: Plane,
    /// The segment.
    cut: [DVec3; 2],
    /// Unit vectors along the segment, and away from the emitter.
    along: DVec3,
    ahead: DVec3,
}

impl<'s> Strip<'s> {
    /// None where the plane misses the emitter or only touches it.
    fn new(scene: &'s Scene, polygon: &EmitterPolygon, face: FaceId, plane: Plane) -> Option<Self> {
        let cut = cut(polygon, &plane, scene.weld_distance)?;
        let along = (cut[1] - cut[0]).normalize();
        let ahead = plane.normal.cross(along);
        Some(Self {
            scene,
            face,
            plane,
            cut,
            along,
            ahead: ahead * ahead.dot(polygon.plane.normal).signum(),
        })
    }

    fn to_plane(&self, p: DVec3) -> DVec2 {
        let d = p - self.cut[0];
        DVec2::new(d.dot(self.along), d.dot(self.ahead))
    }

    fn to_space(&self, q: DVec2) -> DVec3 {
        self.cut[0] + self.along * q.x + self.ahead * q.y
    }

    /// Appends the stretches that the points of the segment light past the face.
    fn landings(&self, search: &Search, out: &mut Vec<Landing>) {
        let Some(view) = self.view(search) else {
            return;
        };
        let own = self.ends_of_faces(&view);
        for cell in view.cells() {
            for stretch in &cell.lit {
                out.extend(self.landing(&view, &own, &cell, stretch));
            }
        }
    }

    /// What each face has of the line in which it meets the plane.
    fn ends_of_faces(&self, view: &PlaneView) -> HashMap<FaceId, [DVec3; 2]> {
        let mut found: HashMap<FaceId, [DVec3; 2]> = HashMap::new();
        for obstacle in &view.obstacles {
            let Some(face) = obstacle.face else { continue };
            let line = self.line(face);
            for p in obstacle.ends.map(|i| view.points[i as usize].1) {
                let [first, last] = found.entry(face).or_insert([p; 2]);
                if line.dot(p) < line.dot(*first) {
                    *first = p;
                }
                if line.dot(p) > line.dot(*last) {
                    *last = p;
                }
            }
        }
        found
    }

    /// Along the line in which a face meets the plane.
    fn line(&self, face: FaceId) -> DVec3 {
        let plane = self.scene.faces[face].frame.plane();
        plane.normal.cross(self.plane.normal)
    }

    /// The plane with the face's corners ahead of the emitter and all that rays past them meet, unless that is too much.
    fn view(&self, search: &Search) -> Option<PlaneView> {
        let (scene, tol) = (self.scene, self.scene.weld_distance);
        let (blockers, most) = (search.light.blockers, search.worth.most_in_the_way());
        let mut view = PlaneView {
            length: self.cut[0].distance(self.cut[1]),
            points: Vec::new(),
            corners: Vec::new(),
            obstacles: Vec::new(),
            tol,
        };
        for &v in scene.faces[self.face].loops.iter().flatten() {
            let p = scene.vertices[v];
            let q = self.to_plane(p);
            if q.y > tol {
                view.corners.push(view.points.len() as u32);
                view.points.push((q, p));
            }
        }
        let region = self.region(&view)?;
        let mut parts = Vec::new();
        blockers.query_while(&region, |i| {
            parts.push(i);
            parts.len() <= most
        });
        if parts.len() > most {
            return None;
        }
        parts.sort_unstable();
        for i in parts {
            let part = blockers.part(i);
            if part.face == self.face {
                continue;
            }
            let cut = wedge::cut_of_part(scene, blockers, part, &self.plane, |_| false);
            if let Some(cut) = cut {
                self.add(&mut view, &cut);
            }
        }
        view.unite_points();
        Some(view)
    }

    /// Adds a segment of the plane as far as it lies ahead of the emitter.
    fn add(&self, view: &mut PlaneView, cut: &Cut) {
        let [(a, _), (b, _)] = cut.ends;
        let (p, q) = (self.to_plane(a), self.to_plane(b));
        if p.y <= view.tol && q.y <= view.tol {
            return;
        }
        let ends = [(p, a), (q, b)].map(|(own, position)| {
            if own.y > view.tol {
                return (own, position);
            }
            let t = (view.tol - p.y) / (q.y - p.y);
            (p.lerp(q, t), a.lerp(b, t))
        });
        let first = view.points.len() as u32;
        view.points.extend(ends);
        view.obstacles.push(Obstacle {
            ends: [first, first + 1],
            face: cut.face,
        });
    }

    /// What rays from the segment past the face can meet; none when there is no way past.
    fn region(&self, view: &PlaneView) -> Option<Region> {
        let slopes = |x: f64| view.points.iter().map(move |(q, _)| (q.x - x) / q.y);
        let leftmost = slopes(view.length).reduce(f64::min)?;
        let rightmost = slopes(0.0).reduce(f64::max)?;
        let tol = self.scene.weld_distance;
        let n = self.plane.normal;
        let [first, last] = self.cut;
        let left = (self.along - self.ahead * leftmost).normalize();
        let right = (self.ahead * rightmost - self.along).normalize();
        Some(Region {
            planes: [
                Plane::new(first - n * tol, n),
                Plane::new(first + n * tol, -n),
                Plane::new(first, self.ahead),
                Plane::new(first - left * tol, left),
                Plane::new(last - right * tol, right),
            ]
            .into_iter()
            .collect(),
            bounds: (DVec3::NEG_INFINITY, DVec3::INFINITY),
        })
    }

    /// All that the points of a cell light of a stretch.
    fn landing(
        &self,
        view: &PlaneView,
        own: &HashMap<FaceId, [DVec3; 2]>,
        cell: &Cell,
        stretch: &Stretch,
    ) -> Option<Landing> {
        let scene = self.scene;
        let plane = scene.faces[stretch.face].frame.plane();
        let line = self.line(stretch.face);
        let along = |p: DVec3| line.dot(p);
        // Rays to the ends of a cell may graze the face, and meet its plane anywhere.
        let [first, last] = *own.get(&stretch.face)?;
        let hit = |share: f64, feature: Feature| {
            let apex = self.cut[0].lerp(self.cut[1], share);
            let through = match view.position(feature) {
                Ok(p) if plane.distance(p).abs() <= view.tol => return Some(p),
                Ok(p) => p,
                Err(q) => self.to_space(q),
            };
            let (d0, d1) = (plane.distance(apex), plane.distance(through));
            let t = d0 / (d0 - d1);
            let p = apex + (through - apex) * t;
            if !(t >= 0.0 && p.is_finite()) {
                None
            } else if along(p) < along(first) {
                Some(first)
            } else if along(p) > along(last) {
                Some(last)
            } else {
                Some(p)
            }
        };
        let shares = [cell.from, cell.to];
        let hits = || {
            shares
                .into_iter()
                .flat_map(|c| stretch.ends.map(|f| hit(c, f)))
        };
        let from = hits()
            .flatten()
            .min_by(|p, q| along(*p).total_cmp(&along(*q)))?;
        let to = hits()
            .flatten()
            .max_by(|p, q| along(*p).total_cmp(&along(*q)))?;
        let middle = 0.5 * (cell.from + cell.to);
        let side = if plane.distance(self.cut[0].lerp(self.cut[1], middle)) > 0.0 {
            FaceSide::Front
        } else {
            FaceSide::Back
        };
        scene.receives(stretch.face, side).then_some(Landing {
            face: stretch.face,
            side,
            // A point that stands for several at one place may be off the face by the weld distance.
            ends: [from, to].map(|p| p - plane.normal * plane.distance(p)),
            middle,
        })
    }
}

/// The segment in which `plane` cuts a convex piece of an emitter; none when it only touches it.
fn cut(polygon: &EmitterPolygon, plane: &Plane, tol: f64) -> Option<[DVec3; 2]> {
    let corners = &polygon.corners;
    let heights = || corners.iter().map(|&c| plane.distance(c));
    if !(heights().any(|h| h > tol) && heights().any(|h| h < -tol)) {
        return None;
    }
    let mut ends = (0..corners.len()).filter_map(|i| {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        let (ha, hb) = (plane.distance(a), plane.distance(b));
        ((ha > 0.0) != (hb > 0.0)).then(|| a + (b - a) * (ha / (ha - hb)))
    });
    let ends = [ends.next()?, ends.next()?];
    (ends[0].distance(ends[1]) > tol).then_some(ends)
}

/// Stretches on one side of one face – all of them collinear – with those that touch made one.
fn united(mut stretches: Vec<Landing>, tol: f64) -> Vec<Landing> {
    stretches.sort_by_key(|l| (l.face, l.side));
    let mut out: Vec<Landing> = Vec::new();
    for group in stretches.chunk_by_mut(|a, b| (a.face, a.side) == (b.face, b.side)) {
        let along = (group[0].ends[1] - group[0].ends[0]).normalize_or_zero();
        for l in group.iter_mut() {
            if along.dot(l.ends[1] - l.ends[0]) < 0.0 {
                l.ends.swap(0, 1);
            }
        }
        group.sort_by(|a, b| along.dot(a.ends[0]).total_cmp(&along.dot(b.ends[0])));
        let first = out.len();
        for l in group.iter() {
            match out[first..].last_mut() {
                Some(last) if along.dot(l.ends[0] - last.ends[1]) <= tol => {
                    if along.dot(l.ends[1] - last.ends[1]) > 0.0 {
                        last.ends[1] = l.ends[1];
                    }
                }
                _ => out.push(*l),
            }
        }
    }
    out
}
