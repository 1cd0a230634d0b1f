//! Follows a wedge past the blockers to the receivers that light really reaches along it.

use super::span::LitSpans;
use super::wedge::{Section, Wedge};
use crate::scene::{FaceId, FaceSide, Scene};
use crate::visibility::Blockers;
use glam::DVec3;

/// A lit piece of a wedge on a receiver.
#[derive(Clone, Copy, Debug)]
pub(super) struct Landing {
    pub(super) face: FaceId,
    pub(super) side: FaceSide,
    pub(super) ends: [DVec3; 2],
}

/// VE: rays from the emitter vertex (apex) graze the blocker edge (rim) and land on the first face behind it.
pub(super) fn past_edge(wedge: &Wedge, scene: &Scene, blockers: &Blockers) -> Vec<Landing> {
    // Most wedges end before the rim: what lies behind it need not be known.
    let mut lit = LitSpans::whole();
    let before = wedge.sections_before_rim(scene, blockers);
    hide(&mut lit, &before, wedge.rim_slack);
    if lit.is_empty() {
        return Vec::new();
    }
    let behind: Vec<Section> = wedge
        .sections_ahead(scene, blockers)
        .into_iter()
        .filter_map(|s| keep_below(s, wedge.rim_slack))
        .collect();
    land(scene, &lit, &behind, |s| (wedge.apex, wedge.rim_at(s)))
}

/// EV: rays from the emitter edge (rim) graze the blocker vertex (apex) and land on the first face behind it.
///
/// `lit` is where the faces at the vertex let them pass.
pub(super) fn past_vertex(
    wedge: &Wedge,
    mut lit: LitSpans,
    scene: &Scene,
    blockers: &Blockers,
) -> Vec<Landing> {
    let before = wedge.sections_before_rim(scene, blockers);
    hide(&mut lit, &before, wedge.rim_slack);
    if lit.is_empty() {
        return Vec::new();
    }
    let behind = wedge.sections_beyond(scene, blockers);
    land(scene, &lit, &behind, |s| (wedge.rim_at(s), wedge.apex))
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
fn hide(lit: &mut LitSpans, sections: &[Section], slack: f64) {
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
    })
}

/// The upper envelope of `sections` over the lit spans, as segments on the faces that form it.
fn land(
    scene: &Scene,
    lit: &LitSpans,
    sections: &[Section],
    ray: impl Fn(f64) -> (DVec3, DVec3),
) -> Vec<Landing> {
    let mut out = Vec::new();
    for (from, to) in lit.iter() {
        let near: Vec<&Section> = sections
            .iter()
            .filter(|s| s.s0 < to && s.s1 > from)
            .collect();
        let mut cuts: Vec<f64> = near
            .iter()
            .flat_map(|s| [s.s0, s.s1])
            .filter(|&s| s > from && s < to)
            .chain([from, to])
            .collect();
        cuts.sort_unstable_by(f64::total_cmp);
        cuts.dedup();
        // One face may form the envelope over many elementary intervals: they are one segment.
        let mut open: Option<(FaceId, f64, f64)> = None;
        let emit = |piece: Option<(FaceId, f64, f64)>, out: &mut Vec<Landing>| {
            if let Some((face, a, b)) = piece {
                out.extend(landing(scene, face, ray(a), ray(b)));
            }
        };
        for pair in cuts.windows(2) {
            envelope(
                &near,
                pair[0],
                pair[1],
                &mut |face, a, b| match (open, face) {
                    (Some((f, start, end)), Some(g)) if f == g && end >= a => {
                        open = Some((f, start, b));
                    }
                    _ => {
                        emit(open.take(), &mut out);
                        open = face.map(|f| (f, a, b));
                    }
                },
            );
        }
        emit(open.take(), &mut out);
    }
    out
}

/// Reports the nearest section over (`from`, `to`), in which no section begins or ends.
fn envelope(
    sections: &[&Section],
    from: f64,
    to: f64,
    report: &mut impl FnMut(Option<FaceId>, f64, f64),
) {
    let covers = |s: &&&Section| s.s0 <= from && s.s1 >= to;
    let middle = 0.5 * (from + to);
    let Some(top) = sections
        .iter()
        .filter(covers)
        .max_by(|a, b| a.w(middle).total_cmp(&b.w(middle)))
    else {
        report(None, from, to);
        return;
    };
    // Another section may be nearer at an end: faces that pierce each other. Split where they cross.
    for &end in &[from, to] {
        let nearer = sections
            .iter()
            .filter(covers)
            .max_by(|a, b| a.w(end).total_cmp(&b.w(end)))
            .expect("top covers the interval");
        if nearer.w(end) > top.w(end) {
            let (gap_end, gap_mid) = (nearer.w(end) - top.w(end), top.w(middle) - nearer.w(middle));
            let cut = end + (middle - end) * (gap_end / (gap_end + gap_mid));
            if cut > from && cut < to {
                envelope(sections, from, cut, report);
                envelope(sections, cut, to, report);
                return;
            }
        }
    }
    report(top.face, from, to);
}

/// Evaluates both ends on the receiver's plane: each is a ray from its origin through the grazed point.
fn landing(
    scene: &Scene,
    face: FaceId,
    from: (DVec3, DVec3),
    to: (DVec3, DVec3),
) -> Option<Landing> {
    let plane = scene.faces[face].frame.plane();
    let hit = |(origin, through): (DVec3, DVec3)| {
        let (d0, d1) = (plane.distance(origin), plane.distance(through));
        let p = origin + (through - origin) * (d0 / (d0 - d1));
        p.is_finite().then_some(p)
    };
    let side = if plane.distance(from.0) > 0.0 {
        FaceSide::Front
    } else {
        FaceSide::Back
    };
    let ends = [hit(from)?, hit(to)?];
    (scene.receives(face, side) && ends[0].distance(ends[1]) > scene.weld_distance)
        .then_some(Landing { face, side, ends })
}
