//! Where the direct light on a face breaks.
//!
//! The visible outline of a polygonal emitter changes its combinatorics on critical surfaces. This stage finds the planar
//! ones – an emitter vertex past a blocker edge (VE), an emitter edge past a blocker vertex (EV), a blocker vertex past
//! another blocker's edge (NVE) –, the quadrics of three edges (EEE), the emitter's own horizon, the planes of faces that
//! cut an emitter, and the lines where faces touch or pierce a receiver, and follows each to the receivers that light
//! really reaches along it. Of a light without a surface ([`crate::scene::PunctualLight`]) the edges of all shadows are
//! lines of order 0, and the rims of a spot's cone lines of higher order. Vertices look for edges along the cone of their sight lines, and the rays of wedges that touch
//! a further edge lead to the quadrics: what no sight line joins is never compared. An [`Outline`] tells which features a
//! point sees, and [`check_outlines`] by them whether a line was missed.
//!
//! Papers: Heckbert, *Discontinuity meshing for radiosity* (1992); Lischinski, Tampieri & Greenberg, *Discontinuity meshing
//! for accurate radiosity* (1992); Drettakis & Fiume, *A fast shadow algorithm for area light sources using
//! backprojection* (1994); Stewart & Ghali (1994); Durand, Drettakis & Puech, *The visibility skeleton* (1997), for the
//! step from the ends of critical surfaces to the next. Unlike them we never map a point into a wedge's frame and back: a line's
//! ends are parameters along its generating edge, evaluated once.

mod complete;
mod contact;
mod corner;
mod edge_on;
mod eee;
mod event;
mod from_emitter;
mod horizon;
mod landing;
mod merge;
mod nve;
mod outline;
mod punctual;
mod reach;
mod span;
mod strength;
mod trace;
mod triple;
mod wedge;
mod width;
mod worth;

pub use width::penumbra_width;

pub use complete::{OutlineCheck, check_outlines};
pub use outline::Outline;

use self::eee::Arcs;
use self::event::{Found, Search};
use crate::budget::{Budget, Meter};
use crate::direct::DirectLight;
use crate::geom::ConicArc;
use crate::scene::{EdgeId, EmitterId, FaceId, FaceSide, Scene, VertexId};
use crate::visibility::{Blockers, Scratch};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// What may be left out of the lines, and how closely arcs are followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineTolerance {
    /// NVE and EEE lines are left out when their predicted break is below this share of what the whole emitter gives there;
    /// 0 keeps all.
    pub floor: f64,
    /// Lines are left out when their predicted break is below this, W/m²; 0 keeps all. Where an emitter is too far away to
    /// give so much, none are looked for.
    pub least: f64,
    /// Chords depart from their arc by no more than this share of the receiver's size (the root of its area).
    pub chord: f64,
}

impl Default for LineTolerance {
    /// All lines; chords that a picture does not tell from their arcs.
    fn default() -> Self {
        Self {
            floor: 0.0,
            least: 0.0,
            chord: 2.5e-4,
        }
    }
}

/// What jumps across a line: the derivative of this order of the irradiance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DiscontinuityOrder {
    /// The value (contact; the shadow of a light without a surface).
    D0,
    /// The slope (emitter edge and blocker edge in one plane; horizon; blocker seen edge-on).
    D1,
    /// The curvature (every generic VE and EV line).
    D2,
}

/// The kind of critical surface that made a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum EventKind {
    /// Emitter vertex past a blocker edge.
    Ve,
    /// Emitter edge past a blocker vertex.
    Ev,
    /// Blocker vertex past another blocker's edge, with the emitter behind.
    Nve,
    /// Three edges on one sight line: one of the emitter and two of blockers, or three of blockers with the emitter behind.
    Eee,
    /// A face touches or pierces the receiver.
    Contact,
    /// The emitter's own plane.
    Horizon,
    /// The plane of a blocker's face, which cuts the emitter.
    EdgeOn,
}

/// The features that generate a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// A vertex of the emitter and an edge of a blocker (VE), or a vertex and an edge of two blockers (NVE).
    VertexEdge(VertexId, EdgeId),
    /// An emitter edge (by its ends) and a blocker vertex.
    EdgeVertex([VertexId; 2], VertexId),
    /// Three edges (EEE), sorted.
    Edges([EdgeId; 3]),
    /// The face that touches, pierces or covers the receiver, or is seen edge-on from it.
    Face(FaceId),
    /// The plane of the emitter.
    EmitterPlane,
    /// A light without a surface (its number) and an edge of a blocker.
    LightEdge(u32, EdgeId),
    /// The cone of a spot light (its number).
    Cone(u32),
}

/// A line on one side of a face across which the direct light breaks.
#[derive(Clone, Debug, PartialEq)]
pub struct Discontinuity {
    /// The receiver.
    pub face: FaceId,
    /// Its lit side.
    pub side: FaceSide,
    /// Ends, metres, local.
    pub ends: [DVec3; 2],
    /// What jumps.
    pub order: DiscontinuityOrder,
    /// What made it.
    pub kind: EventKind,
    /// The emitter, where there is one.
    pub emitter: Option<EmitterId>,
    /// Its generators.
    pub cause: Cause,
    /// Predicted break of the irradiance over the width of the penumbra, W/m², mean of the channels: at most what the whole
    /// emitter gives there unoccluded (D1), half of it where only a corner of the emitter is crossed (D2).
    pub jump: f64,
}

/// A line of second order: an arc of a conic. Its chords are among the candidates.
#[derive(Clone, Debug, PartialEq)]
pub struct Arc {
    /// The curve, metres, local.
    pub conic: ConicArc,
    /// What is known of it; `ends` are those of the arc.
    pub line: Discontinuity,
}

/// All lines of one side of one face.
#[derive(Clone, Debug, Default)]
pub struct FaceLines {
    /// D0 lines that the mesh has to hold because the value jumps there: contacts, and shadows of lights without a surface.
    pub contacts: Vec<Discontinuity>,
    /// Candidates of higher order; a line is inserted when its elements need it.
    pub candidates: Vec<Discontinuity>,
    /// The arcs whose chords some of the candidates are.
    pub arcs: Vec<Arc>,
    /// Faces in this face's plane that overlap it and are seen instead of it.
    pub covers: Vec<FaceId>,
}

/// What the search for lines did.
#[derive(Clone, Copy, Debug, Default, serde::Serialize)]
pub struct SearchReport {
    /// VE and EV wedges that passed the culls.
    pub wedges: usize,
    /// Wedges culled before tracing: no silhouette, or behind the emitter.
    pub culled: usize,
    /// Whether there were too many features to look at all: those that rank low draw no lines then.
    pub is_partial: bool,
    /// Whether the budget was used up before all were looked at.
    pub is_cut_short: bool,
    /// Triples of edges that were followed.
    pub triples: usize,
    /// Arcs that landed on receivers.
    pub arcs: usize,
    /// Segments that landed on receivers, before merging.
    pub segments: usize,
    /// Lines after merging collinear overlaps.
    pub lines: usize,
    /// What comparing the outlines from neighbouring points told; filled in by [`check_outlines`].
    pub outlines: OutlineCheck,
}

/// The lines of every receiver side, indexed by `2 · face + (0 front | 1 back)`.
pub struct LineMap {
    lines: Vec<FaceLines>,
    /// Counts of the search.
    pub report: SearchReport,
}

impl LineMap {
    /// Lines on one side of a face.
    pub fn of(&self, face: FaceId, side: FaceSide) -> &FaceLines {
        &self.lines[slot(face, side)]
    }

    /// Moves the lines on one side of a face out.
    pub fn take(&mut self, face: FaceId, side: FaceSide) -> FaceLines {
        std::mem::take(&mut self.lines[slot(face, side)])
    }
}

impl FaceLines {
    /// Adds an arc and its chords.
    fn add_arc(&mut self, scene: &Scene, mut arc: Arc, chord: f64) {
        let tolerance = chord * scene.faces[arc.line.face].area.sqrt();
        let points = arc.conic.chorded(tolerance);
        for ends in points.windows(2) {
            self.candidates.push(Discontinuity {
                ends: [ends[0], ends[1]],
                ..arc.line.clone()
            });
        }
        arc.line.ends = [points[0], points[points.len() - 1]];
        self.arcs.push(arc);
    }
}

/// Follows the triples of edges that the wedges' ends lead to, and those that their own ends lead to, until none is new.
fn arcs(search: &Search, found: &[Found], meter: &Meter, report: &mut SearchReport) -> Vec<Arc> {
    let mut known = BTreeSet::new();
    let mut next = Vec::new();
    for touched in found.iter().flat_map(|f| &f.touches) {
        triple::start(search, touched, &mut next);
    }
    let mut out = Vec::new();
    loop {
        next.sort_unstable();
        next.dedup();
        next.retain(|t| !known.contains(t));
        report.is_partial |= worth::keep_longest(search.scene, &mut next, known.len());
        known.extend(next.iter().copied());
        if next.is_empty() {
            report.triples = known.len();
            report.arcs = out.len();
            return out;
        }
        let traced: Vec<Arcs> = next
            .par_iter()
            .filter(|_| !meter.is_late())
            .map(|&t| eee::trace(search, t))
            .collect();
        next.clear();
        for t in traced {
            out.extend(t.arcs);
            next.extend(t.next);
        }
    }
}

fn slot(face: FaceId, side: FaceSide) -> usize {
    2 * face.0 as usize + usize::from(side == FaceSide::Back)
}

/// Finds the lines of `scene`.
pub fn find_lines(scene: &Scene, light: &DirectLight, tolerance: LineTolerance) -> LineMap {
    find_lines_within(&Meter::new(Budget::default()), scene, light, tolerance)
}

/// Finds the lines of `scene` for which there is time; contacts always.
pub fn find_lines_within(
    meter: &Meter,
    scene: &Scene,
    light: &DirectLight,
    tolerance: LineTolerance,
) -> LineMap {
    let blockers: &Blockers = light.blockers;
    let jobs = event::jobs(scene);
    let search = event::Search::new(scene, light, tolerance);
    let mut found: Vec<Found> = jobs
        .par_iter()
        .filter(|_| !meter.is_late())
        .map(|job| search.run(job))
        .collect();
    let vertices: Vec<VertexId> = scene.vertices.ids().collect();
    found.par_extend(
        vertices
            .par_iter()
            .filter(|_| !meter.is_late())
            .map_init(Scratch::default, |scratch, &v| {
                nve::through_vertex(&search, v, scratch)
            }),
    );
    let mut report = SearchReport {
        is_partial: search.worth.is_partial(),
        ..SearchReport::default()
    };
    let mut lines = vec![FaceLines::default(); 2 * scene.faces.len()];
    for arc in arcs(&search, &found, meter, &mut report) {
        lines[slot(arc.line.face, arc.line.side)].add_arc(scene, arc, tolerance.chord);
    }
    for f in found {
        report.wedges += f.wedges;
        report.culled += f.culled;
        for s in f.lines {
            lines[slot(s.face, s.side)].candidates.push(s);
        }
    }
    for s in horizon::find(&search) {
        lines[slot(s.face, s.side)].candidates.push(s);
    }
    for s in edge_on::find(&search, meter) {
        lines[slot(s.face, s.side)].candidates.push(s);
    }
    for s in contact::find(&search) {
        lines[slot(s.face, s.side)].contacts.push(s);
    }
    let shadows = punctual::shadows(scene, light);
    for s in shadows.into_iter().filter(|s| s.jump >= tolerance.least) {
        lines[slot(s.face, s.side)].contacts.push(s);
    }
    for s in punctual::cones(scene, light, tolerance.chord) {
        lines[slot(s.face, s.side)].candidates.push(s);
    }
    for (below, above) in contact::covers(scene, blockers) {
        for side in [FaceSide::Front, FaceSide::Back] {
            lines[slot(below, side)].covers.push(above);
        }
    }
    report.is_cut_short = meter.is_late();
    report.segments = lines.iter().map(|l| l.candidates.len()).sum();
    lines
        .par_iter_mut()
        .for_each(|l| merge::merge_all(scene, l));
    report.lines = lines
        .iter()
        .map(|l| l.candidates.len() + l.contacts.len())
        .sum();
    LineMap { lines, report }
}
