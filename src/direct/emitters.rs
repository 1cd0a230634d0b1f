//! The emitters as convex polygons, and the exact irradiance from all of them.

use super::form_factor_of_directions;
use super::punctual::{irradiance_by, unoccluded_by};
use crate::geom::{Plane, even_point_of};
use crate::quantity::{Exitance, Irradiance};
use crate::scene::{Emitter, EmitterId, FaceId, FaceSide, PunctualLight, Scene};
use crate::visibility::{Blockers, Scratch, Screening, Seen, Target, Viewpoint};
use glam::DVec3;
use smallvec::SmallVec;
use std::sync::atomic::AtomicUsize;

/// A convex piece of an emitting side.
#[derive(Clone, Debug)]
pub struct EmitterPolygon {
    /// The emitter it is a piece of.
    pub emitter: EmitterId,
    /// The face that it is a piece of.
    pub face: FaceId,
    /// Corners, counter-clockwise seen from the side that shines, metres.
    pub corners: Vec<DVec3>,
    /// Its plane, normal towards the side that shines.
    pub plane: Plane,
    /// Power per area that it sends out, W/m².
    pub exitance: Exitance,
}

impl EmitterPolygon {
    /// The mean of its corners.
    pub fn middle(&self) -> DVec3 {
        self.corners.iter().sum::<DVec3>() / self.corners.len() as f64
    }

    /// Point `i` of a sequence that fills it evenly.
    pub fn point(&self, i: u32) -> DVec3 {
        even_point_of(&self.corners, i)
    }

    pub(super) fn target(&self) -> Target<'_> {
        Target {
            corners: &self.corners,
            plane: self.plane,
        }
    }
}

/// The form factor of a piece above the horizon of `view`.
///
/// On a curved surface the cosine is taken from its own normal, and is zero where negative: the piece is clipped to that
/// normal's half-space as well. A point of a tessellated sphere then has the irradiance of the sphere, except where its
/// facet and the sphere do not agree on what is above the horizon; that difference vanishes with the facets' size.
fn weight(view: &Viewpoint, piece: &[DVec3]) -> f64 {
    if view.shading == view.horizon.normal {
        return form_factor_of_directions(view.shading, piece);
    }
    let height = |d: DVec3| view.shading.dot(d);
    let mut above: SmallVec<[DVec3; 8]> = SmallVec::new();
    let Some(&last) = piece.last() else {
        return 0.0;
    };
    let mut a = last;
    for &b in piece {
        let (from, to) = (height(a), height(b));
        if (from < 0.0) != (to < 0.0) {
            above.push(a + (b - a) * (from / (from - to)));
        }
        if to >= 0.0 {
            above.push(b);
        }
        a = b;
    }
    form_factor_of_directions(view.shading, &above)
}

/// The form factor of what `view` sees of a polygon.
fn visible_factor(
    polygon: &EmitterPolygon,
    blockers: &Blockers,
    view: &Viewpoint,
    scratch: &mut Scratch,
) -> f64 {
    let open = unoccluded_factor(polygon, blockers, view, scratch);
    let all = Screening::AtMost(usize::MAX);
    visible_factor_among(all, open, polygon, blockers, view, scratch).unwrap_or(0.0)
}

/// The form factor of what `view` sees of a polygon past the screens that `screening` finds, unless they are too many; `open` is
/// that of all of it.
///
/// What is left of a polygon gives no more than all of it. The pieces may, next to where a blocker touches it: from a distance d
/// the directions of their corners are off by round-off / d, and what is cut off along a line is not what is kept beside it.
pub(super) fn visible_factor_among(
    screening: Screening,
    open: f64,
    polygon: &EmitterPolygon,
    blockers: &Blockers,
    view: &Viewpoint,
    scratch: &mut Scratch,
) -> Option<f64> {
    if matches!(screening, Screening::Known([])) {
        return Some(open);
    }
    let mut f = 0.0;
    let add = |piece: &[DVec3]| f += weight(view, piece);
    Some(
        match scratch.visible_among(screening, blockers, view, polygon.target(), add)? {
            Seen::All => open,
            Seen::Part => f.clamp(0.0, open),
            Seen::Nothing => 0.0,
        },
    )
}

/// The form factor of a polygon as if nothing hid it.
pub(super) fn unoccluded_factor(
    polygon: &EmitterPolygon,
    blockers: &Blockers,
    view: &Viewpoint,
    scratch: &mut Scratch,
) -> f64 {
    let mut f = 0.0;
    let none = std::iter::empty();
    scratch.visible_past(blockers, none, view, polygon.target(), |piece| {
        f += weight(view, piece);
    });
    f.max(0.0)
}

/// The corners of the convex parts of an emitter, counter-clockwise seen from where it shines to.
pub(super) fn convex_polygons(scene: &Scene, emitter: Emitter) -> Vec<Vec<DVec3>> {
    let parts = scene.faces[emitter.face].convex_parts.iter();
    let corners = parts.map(|part| part.iter().map(|&v| scene.vertices[v]));
    match emitter.side {
        FaceSide::Front => corners.map(Iterator::collect).collect(),
        FaceSide::Back => corners.map(|c| c.rev().collect()).collect(),
    }
}

/// Everything needed to evaluate light straight from the emitters.
pub struct DirectLight<'a> {
    /// The opaque world.
    pub blockers: &'a Blockers,
    /// Convex pieces of all emitters.
    pub polygons: Vec<EmitterPolygon>,
    /// Lights without a surface, local.
    pub lights: Vec<PunctualLight>,
    pub(super) looks_by_rays: AtomicUsize,
    pub(super) hidden_sights: AtomicUsize,
}

impl<'a> DirectLight<'a> {
    /// Splits every emitter of `scene` into convex polygons.
    pub fn new(scene: &Scene, blockers: &'a Blockers) -> Self {
        let mut polygons = Vec::new();
        for (id, emitter) in scene.emitters.iter() {
            let face = &scene.faces[emitter.face];
            let exitance = Exitance::from_radiance(face.emission);
            let normal = scene.normal(emitter.face, emitter.side);
            for corners in convex_polygons(scene, *emitter) {
                polygons.push(EmitterPolygon {
                    emitter: id,
                    face: emitter.face,
                    corners,
                    plane: Plane::new(face.frame.origin, normal),
                    exitance,
                });
            }
        }
        Self {
            blockers,
            polygons,
            lights: scene.lights.clone(),
            looks_by_rays: AtomicUsize::new(0),
            hidden_sights: AtomicUsize::new(0),
        }
    }

    /// One light without a surface alone.
    pub(crate) fn of_light(light: PunctualLight, blockers: &'a Blockers) -> Self {
        Self {
            blockers,
            polygons: Vec::new(),
            lights: vec![light],
            looks_by_rays: AtomicUsize::new(0),
            hidden_sights: AtomicUsize::new(0),
        }
    }

    /// The convex pieces of one emitter.
    pub fn polygons_of(&self, emitter: EmitterId) -> &[EmitterPolygon] {
        // They are made emitter by emitter.
        let first = self.polygons.partition_point(|p| p.emitter < emitter);
        let count = self.polygons[first..].partition_point(|p| p.emitter == emitter);
        &self.polygons[first..first + count]
    }

    /// Irradiance at `view` from one emitter as if nothing hid it, W/m².
    pub fn unoccluded_from(
        &self,
        emitter: EmitterId,
        view: &Viewpoint,
        scratch: &mut Scratch,
    ) -> Irradiance {
        let mut sum = Irradiance::ZERO;
        for polygon in self.polygons_of(emitter) {
            let f = unoccluded_factor(polygon, self.blockers, view, scratch);
            sum += Irradiance(polygon.exitance.0 * f);
        }
        sum
    }

    /// Irradiance at `view` from all emitters as if nothing hid them, W/m².
    pub fn unoccluded(&self, view: &Viewpoint, scratch: &mut Scratch) -> Irradiance {
        let mut emitters: Vec<EmitterId> = self.polygons.iter().map(|p| p.emitter).collect();
        emitters.dedup();
        let mut sum = Irradiance::ZERO;
        for e in emitters {
            sum += self.unoccluded_from(e, view, scratch);
        }
        for light in &self.lights {
            sum += unoccluded_by(light, view);
        }
        sum
    }

    /// Whether some emitter is above the horizon of `view` by more than round-off.
    pub fn rises(&self, view: &Viewpoint) -> bool {
        let height = |p: &DVec3| view.horizon.normal.dot(*p - view.position);
        let mut corners = self.polygons.iter().flat_map(|p| &p.corners);
        !self.lights.is_empty() || corners.any(|p| height(p) > self.blockers.roundoff())
    }

    /// Irradiance at `view` straight from all emitters, W/m²; exact up to round-off for diffuse polygons
    /// (backprojection, then Lambert's formula on what is visible).
    pub fn irradiance(&self, view: &Viewpoint, scratch: &mut Scratch) -> Irradiance {
        let mut sum = Irradiance::ZERO;
        for polygon in &self.polygons {
            let f = visible_factor(polygon, self.blockers, view, scratch);
            sum += Irradiance(polygon.exitance.0 * f);
        }
        for light in &self.lights {
            sum += irradiance_by(light, self.blockers, view);
        }
        sum
    }
}
