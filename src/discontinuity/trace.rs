//! Follows a wedge past the blockers to the receivers that light really reaches along it.

use super::landing::{Landing, land};
use super::span::LitSpans;
use super::wedge::{Mark, Section, Wedge};
use crate::scene::{FaceId, Scene};
use crate::visibility::Blockers;
use glam::DVec3;
use smallvec::SmallVec;

/// What the rays of a wedge meet.
#[derive(Debug, Default)]
pub(super) struct Traced {
    pub(super) landings: Vec<Landing>,
    /// What rays touch that light passes along: there critical surfaces of second order begin.
    pub(super) touches: Vec<Touch>,
}

/// An edge or a vertex that a ray of a wedge touches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    pub(super) mark: Mark,
    /// The direction of the ray, either way.
    pub(super) along: DVec3,
}

impl Traced {
    /// True when no light passes, or it meets nothing.
    pub(super) fn is_nothing(&self) -> bool {
        self.landings.is_empty() && self.touches.is_empty()
    }
}

/// Parts that together hid one wedge: of the next one from the same place they likely hide much.
#[derive(Debug, Default)]
pub(super) struct Hiders(SmallVec<[u32; MOST_HIDERS]>);

/// More than so many parts that hide a wedge together are not worth remembering.
const MOST_HIDERS: usize = 8;

/// VE: rays from the emitter vertex (apex) graze the blocker edge (rim) and land on the first face behind it.
pub(super) fn past_edge(
    wedge: &Wedge,
    scene: &Scene,
    blockers: &Blockers,
    hiders: &mut Hiders,
) -> Traced {
    // Most wedges end before the rim: what lies behind it need not be known.
    let behind = |lit: &LitSpans| behind_rim(wedge, lit, scene, blockers);
    let ray = |s| (wedge.apex, wedge.rim_at(s));
    let lit = LitSpans::whole();
    from_emitter(wedge, (lit, true), scene, blockers, hiders, behind, ray)
}

/// VE where a light without a surface stands in for the vertex. What lies within the weld distance of it hides nothing.
pub(super) fn past_edge_from_light(
    wedge: &Wedge,
    scene: &Scene,
    blockers: &Blockers,
) -> Vec<Landing> {
    let mut lit = LitSpans::whole();
    hide_before_rim(
        wedge,
        &mut lit,
        true,
        scene,
        blockers,
        &mut Hiders::default(),
    );
    if lit.is_empty() {
        return Vec::new();
    }
    let behind = behind_rim(wedge, &lit, scene, blockers);
    land(scene, &lit, &behind, |s| wedge.ray_past_rim(s))
}

/// EV: rays from the emitter edge (rim) graze the blocker vertex (apex) and land on the first face behind it.
///
/// `lit` is where the faces at the vertex let them pass.
pub(super) fn past_vertex(
    wedge: &Wedge,
    lit: LitSpans,
    scene: &Scene,
    blockers: &Blockers,
    hiders: &mut Hiders,
) -> Traced {
    let behind = |lit: &LitSpans| wedge.sections_beyond(scene, blockers, lit.hull());
    let ray = |s| (wedge.rim_at(s), wedge.apex);
    from_emitter(wedge, (lit, false), scene, blockers, hiders, behind, ray)
}

/// Rays of a wedge that starts on the emitter, at its apex (within the weld distance of which nothing hides) or at its rim: what is
/// `lit` of it goes past the faces between apex and rim, and lands on those
/// `behind`.
fn from_emitter(
    wedge: &Wedge,
    (mut lit, is_source_the_apex): (LitSpans, bool),
    scene: &Scene,
    blockers: &Blockers,
    hiders: &mut Hiders,
    behind: impl FnOnce(&LitSpans) -> Vec<Section>,
    ray: impl Fn(f64) -> (DVec3, DVec3),
) -> Traced {
    let before = hide_before_rim(wedge, &mut lit, is_source_the_apex, scene, blockers, hiders);
    if lit.is_empty() {
        return Traced::default();
    }
    let behind = behind(&lit);
    let mut traced = Traced {
        landings: land(scene, &lit, &behind, ray),
        touches: Vec::new(),
    };
    touch(wedge, &lit, &before, &[], &mut traced.touches);
    touch(wedge, &lit, &behind, &behind, &mut traced.touches);
    traced
}

/// Takes what lies before the rim from `lit`, and returns it unless nothing is left. Most wedges end here: the rest of the faces
/// is not looked at then. Where all rays come from the apex, what lies within the weld distance of it hides nothing.
fn hide_before_rim(
    wedge: &Wedge,
    lit: &mut LitSpans,
    is_source_the_apex: bool,
    scene: &Scene,
    blockers: &Blockers,
    hiders: &mut Hiders,
) -> Vec<Section> {
    // Takes what part `i` hides from `lit`, and returns its section.
    let hide = |i: u32, lit: &mut LitSpans| {
        let section = wedge.section_ahead(scene, blockers, blockers.part(i))?;
        if is_source_the_apex && wedge.is_at_source(&section) {
            return None;
        }
        let hidden = range_above(&section, 1.0 + wedge.rim_slack);
        if let Some((from, to)) = hidden {
            lit.remove(from, to);
        }
        Some((section, hidden.is_some()))
    };
    for &i in &hiders.0 {
        hide(i, lit);
        if lit.is_empty() {
            return Vec::new();
        }
    }
    let mut found: Vec<(u32, Section)> = Vec::new();
    let mut hiding: SmallVec<[u32; MOST_HIDERS]> = SmallVec::new();
    let region = wedge.region_before_rim(blockers.weld_distance());
    blockers.query_while(&region, |i| {
        if let Some((section, is_hiding)) = hide(i, lit) {
            if is_hiding && hiding.len() < MOST_HIDERS {
                hiding.push(i);
            }
            found.push((i, section));
        }
        !lit.is_empty()
    });
    if lit.is_empty() {
        hiders.0 = hiding;
        return Vec::new();
    }
    found.sort_unstable_by_key(|f| f.0);
    found.into_iter().map(|f| f.1).collect()
}

/// What the lit rays meet behind the rim or on it.
fn behind_rim(wedge: &Wedge, lit: &LitSpans, scene: &Scene, blockers: &Blockers) -> Vec<Section> {
    let sections = wedge.sections_behind_rim(scene, blockers, lit.hull());
    below_rim(sections, wedge.rim_slack)
}

/// NVE: rays that graze a vertex (apex) and an edge of another blocker (rim), come from the inside of an emitter, and
/// land on the first face on the other side.
///
/// `lit` is where the faces at the vertex let them pass; `is_emitter_ahead` says whether the emitter stands beyond the
/// rim or beyond the apex.
pub(super) fn past_both(
    wedge: &Wedge,
    mut lit: LitSpans,
    (emitter, is_emitter_ahead): (FaceId, bool),
    scene: &Scene,
    blockers: &Blockers,
    hiders: &mut Hiders,
) -> Traced {
    let before = hide_before_rim(wedge, &mut lit, false, scene, blockers, hiders);
    if lit.is_empty() {
        return Traced::default();
    }
    let ahead = || behind_rim(wedge, &lit, scene, blockers);
    let beyond = || wedge.sections_beyond(scene, blockers, lit.hull());
    let towards = if is_emitter_ahead { ahead() } else { beyond() };
    let (own, nearer) = parted(scene, towards, emitter);
    let mut out = Traced::default();
    let mut landing_sections = None;
    for own in &own {
        let shone = shone_by(&lit, own, &nearer);
        if shone.is_empty() {
            continue;
        }
        let behind = landing_sections
            .get_or_insert_with(|| if is_emitter_ahead { beyond() } else { ahead() });
        let ray = |s: f64| {
            if is_emitter_ahead {
                (wedge.rim_at(s), wedge.apex)
            } else {
                (wedge.apex, wedge.rim_at(s))
            }
        };
        out.landings.extend(land(scene, &shone, behind, ray));
        touch(wedge, &shone, &before, &[], &mut out.touches);
        touch(wedge, &shone, &nearer, &nearer, &mut out.touches);
        touch(
            wedge,
            &shone,
            std::slice::from_ref(own),
            &[],
            &mut out.touches,
        );
        touch(wedge, &shone, behind, behind, &mut out.touches);
    }
    out
}

/// The stretches of the lit rim behind which the apex sees the emitter's face first.
pub(super) fn shone_from(
    scene: &Scene,
    wedge: &Wedge,
    lit: &LitSpans,
    ahead: Vec<Section>,
    emitter: FaceId,
) -> Vec<(f64, f64)> {
    let (own, nearer) = parted(scene, below_rim(ahead, wedge.rim_slack), emitter);
    own.iter()
        .flat_map(|own| shone_by(lit, own, &nearer).iter().collect::<Vec<_>>())
        .collect()
}

/// The sections of an emitter's face, and those of others that may stand before it: not in its plane.
fn parted(scene: &Scene, sections: Vec<Section>, emitter: FaceId) -> (Vec<Section>, Vec<Section>) {
    let plane = scene.faces[emitter].frame.plane();
    let is_flush = |f: FaceId| {
        let points = scene.faces[f].loops.iter().flatten();
        points
            .map(|&v| plane.distance(scene.vertices[v]).abs())
            .all(|d| d <= scene.weld_distance)
    };
    let (own, mut others): (Vec<Section>, Vec<Section>) =
        sections.into_iter().partition(|s| s.face == Some(emitter));
    if !own.is_empty() {
        others.retain(|s| s.face.is_none_or(|f| !is_flush(f)));
    }
    (own, others)
}

/// Where the lit rays meet the section `own` of the emitter, and nothing before it.
fn shone_by(lit: &LitSpans, own: &Section, nearer: &[Section]) -> LitSpans {
    let mut shone = lit.clone();
    shone.remove(f64::NEG_INFINITY, own.s0);
    shone.remove(own.s1, f64::INFINITY);
    hide_before(&mut shone, nearer, own);
    shone
}

/// The parts of sections that lie behind the rim or on it.
fn below_rim(sections: Vec<Section>, slack: f64) -> Vec<Section> {
    sections
        .into_iter()
        .filter_map(|s| keep_below(s, slack))
        .collect()
}

/// Removes what lies before the section `target`.
fn hide_before(lit: &mut LitSpans, sections: &[Section], target: &Section) {
    for s in sections {
        let (from, to) = (s.s0.max(target.s0), s.s1.min(target.s1));
        if from >= to {
            continue;
        }
        let gap = |at: f64| s.w(at) - target.w(at);
        let (a, b) = (gap(from), gap(to));
        // Both run linearly.
        let cut = || from + (to - from) * (a / (a - b));
        match (a > 0.0, b > 0.0) {
            (true, true) => lit.remove(from, to),
            (true, false) => lit.remove(from, cut()),
            (false, true) => lit.remove(cut(), to),
            (false, false) => {}
        }
    }
}

/// Appends what ends the `sections` where light passes: on a lit ray, and not behind any of `occluders`.
fn touch(
    wedge: &Wedge,
    lit: &LitSpans,
    sections: &[Section],
    occluders: &[Section],
    out: &mut Vec<Touch>,
) {
    for section in sections {
        let ends = [(section.s0, section.w0), (section.s1, section.w1)];
        for ((s, w), mark) in ends.into_iter().zip(section.marks) {
            if mark == Mark::Inside || out.iter().any(|t| t.mark == mark) || !lit.holds(s) {
                continue;
            }
            let is_hidden = occluders.iter().any(|o| o.s0 < s && s < o.s1 && o.w(s) > w);
            if !is_hidden {
                out.push(Touch {
                    mark,
                    along: wedge.rim_at(s) - wedge.apex,
                });
            }
        }
    }
}

/// The stretches of the rim that the apex sees.
pub(super) fn lit_on_rim(wedge: &Wedge, scene: &Scene, blockers: &Blockers) -> Vec<(f64, f64)> {
    let mut lit = LitSpans::whole();
    hide(
        &mut lit,
        &wedge.sections_before_rim(scene, blockers),
        wedge.rim_slack,
    );
    lit.iter().collect()
}

/// Removes what lies nearer than the rim.
pub(super) fn hide(lit: &mut LitSpans, sections: &[Section], slack: f64) {
    for s in sections {
        if lit.is_empty() {
            return;
        }
        if let Some((from, to)) = range_above(s, 1.0 + slack) {
            lit.remove(from, to);
        }
    }
}

/// The parameters at which a section is nearer than `limit`.
fn range_above(s: &Section, limit: f64) -> Option<(f64, f64)> {
    match (s.w0 > limit, s.w1 > limit) {
        (true, true) => Some((s.s0, s.s1)),
        (false, false) => None,
        (first, _) => {
            let cut = s.s0 + (s.s1 - s.s0) * ((limit - s.w0) / (s.w1 - s.w0));
            Some(if first { (s.s0, cut) } else { (cut, s.s1) })
        }
    }
}

/// The part of a section that lies behind the rim or on it. What lies on it from end to end stops the light there: the
/// rim itself touches that face.
fn keep_below(s: Section, slack: f64) -> Option<Section> {
    let (from, to) = match range_above(&s, 1.0 + slack) {
        None => (s.s0, s.s1),
        Some((a, b)) if a <= s.s0 && b >= s.s1 => return None,
        Some((a, b)) if a <= s.s0 => (b, s.s1),
        Some((a, _)) => (s.s0, a),
    };
    let (w0, w1) = (s.w(from), s.w(to));
    let is_on_rim = w0.min(w1) >= 1.0 - slack;
    (from < to).then_some(Section {
        s0: from,
        w0,
        s1: to,
        w1,
        face: s.face.filter(|_| !is_on_rim),
        marks: [
            if from > s.s0 {
                Mark::Inside
            } else {
                s.marks[0]
            },
            if to < s.s1 { Mark::Inside } else { s.marks[1] },
        ],
    })
}
