//! One line where several events draw the same one.
//!
//! Box-like architecture is full of coincidences: an emitter edge parallel to a blocker edge gives four wedges in one
//! plane, two collinear edges throw one shadow line, an edge split at a T-junction throws it in pieces. Lines on one face
//! that run within the weld distance of each other become one, their stretches united, under the lowest order.

use super::{Discontinuity, FaceLines};
use crate::geom::Polygon2;
use crate::scene::Scene;
use glam::{DVec2, DVec3};

/// Merges the lines of one side of one face and drops those that run along its outline.
pub(super) fn merge_all(scene: &Scene, lines: &mut FaceLines) {
    for list in [&mut lines.contacts, &mut lines.candidates] {
        let Some(first) = list.first() else { continue };
        let face = &scene.faces[first.face];
        let taken = std::mem::take(list);
        let flat: Vec<(Discontinuity, [DVec2; 2])> = taken
            .into_iter()
            .map(|d| {
                let ends = d.ends.map(|p| face.frame.to_plane(p));
                (d, ends)
            })
            .filter(|(_, ends)| !runs_along(&face.outline, *ends, scene.weld_distance))
            .collect();
        *list = merge(flat, scene.weld_distance);
    }
}

/// True when one edge of the outline holds both ends within `tol`.
fn runs_along(outline: &Polygon2, ends: [DVec2; 2], tol: f64) -> bool {
    outline.loops.iter().any(|l| {
        (0..l.len()).any(|i| {
            let line = Line::new(l[i], l[(i + 1) % l.len()]);
            ends.iter().all(|&e| {
                let (t, off) = line.locate(e);
                off <= tol && t >= -tol && t <= line.length + tol
            })
        })
    })
}

/// A directed line: the longest member of its class.
struct Line {
    start: DVec2,
    along: DVec2,
    length: f64,
}

impl Line {
    fn new(a: DVec2, b: DVec2) -> Self {
        let length = a.distance(b);
        Self {
            start: a,
            along: (b - a) / length,
            length,
        }
    }

    /// Distance along the line and off it.
    fn locate(&self, p: DVec2) -> (f64, f64) {
        let d = p - self.start;
        (d.dot(self.along), d.perp_dot(self.along).abs())
    }
}

/// A class of collinear lines: stretches along the representative, sorted when finished.
struct Class {
    line: Line,
    from: DVec3,
    to: DVec3,
    stretches: Vec<(f64, f64, Discontinuity)>,
}

fn merge(mut lines: Vec<(Discontinuity, [DVec2; 2])>, tol: f64) -> Vec<Discontinuity> {
    // Longest first: its direction is the best known. Ties fall to the generators, so the order of work does not matter.
    lines.sort_by(|(a, p), (b, q)| {
        let (lp, lq) = (p[0].distance(p[1]), q[0].distance(q[1]));
        lq.total_cmp(&lp)
            .then_with(|| (a.order, a.kind, a.cause).cmp(&(b.order, b.kind, b.cause)))
    });
    let mut classes: Vec<Class> = Vec::new();
    for (d, ends) in lines {
        let home = classes
            .iter_mut()
            .find(|c| ends.iter().all(|&e| c.line.locate(e).1 <= tol));
        match home {
            Some(c) => {
                let (a, b) = (c.line.locate(ends[0]).0, c.line.locate(ends[1]).0);
                c.stretches.push((a.min(b), a.max(b), d));
            }
            None => {
                let line = Line::new(ends[0], ends[1]);
                classes.push(Class {
                    from: d.ends[0],
                    to: d.ends[1],
                    stretches: vec![(0.0, line.length, d)],
                    line,
                });
            }
        }
    }
    classes.into_iter().flat_map(|c| c.united(tol)).collect()
}

impl Class {
    fn united(mut self, tol: f64) -> Vec<Discontinuity> {
        self.stretches.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut out: Vec<(f64, f64, Discontinuity)> = Vec::new();
        for (a, b, d) in std::mem::take(&mut self.stretches) {
            match out.last_mut() {
                Some(last) if a <= last.1 + tol => {
                    last.1 = last.1.max(b);
                    let jump = last.2.jump.max(d.jump);
                    if d.order < last.2.order {
                        last.2 = d;
                    }
                    last.2.jump = jump;
                }
                _ => out.push((a, b, d)),
            }
        }
        // A stretch that nothing was united with keeps its own ends to the last digit.
        out.into_iter()
            .map(|(a, b, mut d)| {
                let own = {
                    let p =
                        |x: DVec3| (x - self.from).dot((self.to - self.from) / self.line.length);
                    let (s, t) = (p(d.ends[0]), p(d.ends[1]));
                    (s.min(t), s.max(t))
                };
                if (own.0 - a).abs() > tol || (own.1 - b).abs() > tol {
                    let at = |t: f64| self.from + (self.to - self.from) * (t / self.line.length);
                    d.ends = [at(a), at(b)];
                }
                d
            })
            .collect()
    }
}
