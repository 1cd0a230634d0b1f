//! Where the lit rays of a wedge land: the nearest of the sections that it cuts out of the faces behind.
//!
//! Over the rim's parameter each section runs linearly in one over the distance, so that what the rays meet first is the upper
//! envelope of segments.

use super::span::LitSpans;
use super::wedge::Section;
use crate::scene::{FaceId, FaceSide, Scene};
use glam::DVec3;

/// A lit piece of a wedge on a receiver.
#[derive(Clone, Copy, Debug)]
pub(super) struct Landing {
    pub(super) face: FaceId,
    pub(super) side: FaceSide,
    pub(super) ends: [DVec3; 2],
    /// Where on the rim its middle ray passes.
    pub(super) middle: f64,
}

/// The upper envelope of `sections` over the lit spans, as segments on the faces that form it.
pub(super) fn land(
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
                let ends = landing(scene, face, ray(a), ray(b));
                out.extend(ends.map(|(side, ends)| Landing {
                    face,
                    side,
                    ends,
                    middle: 0.5 * (a + b),
                }));
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
) -> Option<(FaceSide, [DVec3; 2])> {
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
        .then_some((side, ends))
}
