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
        let mut near = Near::new(sections, from, to);
        let mut cuts: Vec<f64> = near
            .sections
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
            near.advance_to(pair[0]);
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

/// Sections over a span, of which those are at hand that cover where the sweep along it is.
struct Near<'s> {
    sections: Vec<&'s Section>,
    /// Their numbers in the order in which they begin, and how many have begun.
    beginnings: Vec<u32>,
    begun: usize,
    /// Numbers of those that have begun and not ended, ascending: of sections that are equally near the last one counts.
    open: Vec<u32>,
}

impl<'s> Near<'s> {
    /// Those of `sections` that reach into the span.
    fn new(sections: &'s [Section], from: f64, to: f64) -> Self {
        let near = sections.iter().filter(|s| s.s0 < to && s.s1 > from);
        let sections: Vec<&Section> = near.collect();
        let mut beginnings: Vec<u32> = (0..sections.len() as u32).collect();
        let start = |&i: &u32| sections[i as usize].s0;
        beginnings.sort_unstable_by(|a, b| start(a).total_cmp(&start(b)));
        Self {
            sections,
            beginnings,
            begun: 0,
            open: Vec::new(),
        }
    }

    /// Moves on to an interval that starts at `s` and in which no section begins or ends.
    fn advance_to(&mut self, s: f64) {
        let sections = &self.sections;
        self.open.retain(|&i| sections[i as usize].s1 > s);
        while let Some(&i) = self.beginnings.get(self.begun) {
            if sections[i as usize].s0 > s {
                break;
            }
            self.begun += 1;
            if sections[i as usize].s1 > s {
                let place = self.open.partition_point(|&other| other < i);
                self.open.insert(place, i);
            }
        }
    }

    /// The open section that is nearest at `s`.
    fn nearest_at(&self, s: f64) -> Option<&'s Section> {
        let open = self.open.iter().map(|&i| self.sections[i as usize]);
        open.max_by(|a, b| a.w(s).total_cmp(&b.w(s)))
    }
}

/// Reports the nearest section over (`from`, `to`), a part of the interval that `near` has come to.
fn envelope(near: &Near, from: f64, to: f64, report: &mut impl FnMut(Option<FaceId>, f64, f64)) {
    let middle = 0.5 * (from + to);
    let Some(top) = near.nearest_at(middle) else {
        report(None, from, to);
        return;
    };
    // Another section may be nearer at an end: faces that pierce each other. Split where they cross.
    for end in [from, to] {
        let Some(nearer) = near.nearest_at(end) else {
            continue;
        };
        if nearer.w(end) > top.w(end) {
            let (gap_end, gap_mid) = (nearer.w(end) - top.w(end), top.w(middle) - nearer.w(middle));
            let cut = end + (middle - end) * (gap_end / (gap_end + gap_mid));
            if cut > from && cut < to {
                envelope(near, from, cut, report);
                envelope(near, cut, to, report);
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
