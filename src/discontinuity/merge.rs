//! One line where several events draw the same one.
//!
//! Box-like architecture is full of coincidences: an emitter edge parallel to a blocker edge gives four wedges in one
//! plane, two collinear edges throw one shadow line, an edge split at a T-junction throws it in pieces. Lines on one face
//! that run within the weld distance of each other become one, their stretches united, under the lowest order.

use super::{Discontinuity, DiscontinuityOrder, EventKind, FaceLines};
use crate::geom::Polygon2;
use crate::scene::Scene;
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Merges the lines of one side of one face and drops those that run along its outline.
pub(super) fn merge_all(scene: &Scene, lines: &mut FaceLines) {
    for list in [&mut lines.contacts, &mut lines.candidates] {
        let Some(first) = list.first() else { continue };
        let face = &scene.faces[first.face];
        let taken = std::mem::take(list);
        let (low, high) = face.outline.bounds();
        let bounds = [low - scene.weld_distance, high + scene.weld_distance];
        let flat: Vec<(Discontinuity, [DVec2; 2])> = taken
            .into_iter()
            .map(|d| {
                let ends = d.ends.map(|p| face.frame.to_plane(p));
                (d, ends)
            })
            .filter_map(|(d, ends)| within(bounds, d, ends))
            .filter_map(|(d, ends)| inside(&face.outline, scene.weld_distance, d, ends))
            .filter(|(_, ends)| !runs_along(&face.outline, *ends, scene.weld_distance))
            .collect();
        *list = merge(flat, scene.weld_distance);
    }
}

/// The part of a line in a box around its face: a ray that all but grazes the face rounds to anywhere on its plane.
fn within(
    [low, high]: [DVec2; 2],
    line: Discontinuity,
    ends: [DVec2; 2],
) -> Option<(Discontinuity, [DVec2; 2])> {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    let d = ends[1] - ends[0];
    for k in 0..2 {
        let (a, b) = ((low[k] - ends[0][k]) / d[k], (high[k] - ends[0][k]) / d[k]);
        let is_inside = low[k] <= ends[0][k] && ends[0][k] <= high[k];
        if d[k].abs() > 0.0 {
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        } else if !is_inside {
            return None;
        }
    }
    if !(ends[0].is_finite() && ends[1].is_finite() && from < to) {
        return None;
    }
    if from <= 0.0 && to >= 1.0 {
        return Some((line, ends));
    }
    Some(shortened(line, ends, [from, to]))
}

/// The part of a line on its face, where it leaves that by more than `tol`: the same ray may round to beyond the outline.
fn inside(
    outline: &Polygon2,
    tol: f64,
    line: Discontinuity,
    ends: [DVec2; 2],
) -> Option<(Discontinuity, [DVec2; 2])> {
    let leaves = |&e: &DVec2| !outline.contains(e) && outline.distance_to_outline(e) > tol;
    if !ends.iter().any(leaves) {
        return Some((line, ends));
    }
    let part = outline.longest_inside(ends[0], ends[1])?;
    Some(shortened(line, ends, part))
}

/// A line between two shares of its length.
fn shortened(
    mut line: Discontinuity,
    ends: [DVec2; 2],
    cut: [f64; 2],
) -> (Discontinuity, [DVec2; 2]) {
    line.ends = cut.map(|t| line.ends[0].lerp(line.ends[1], t));
    (line, cut.map(|t| ends[0].lerp(ends[1], t)))
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
    let mut index = LineIndex::new(&lines, tol);
    for (d, ends) in lines {
        let home = index
            .near(ends)
            .filter(|&i| ends.iter().all(|&e| classes[i].line.locate(e).1 <= tol))
            .min();
        match home {
            Some(i) => {
                let c = &mut classes[i];
                let (a, b) = (c.line.locate(ends[0]).0, c.line.locate(ends[1]).0);
                c.stretches.push((a.min(b), a.max(b), d));
            }
            None => {
                let line = Line::new(ends[0], ends[1]);
                index.add(ends, classes.len());
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

/// Lines by their direction (an angle from 0 to π) and their distance from the middle of the face.
struct LineIndex {
    centre: DVec2,
    /// How far a line may run from there, metres.
    radius: f64,
    tol: f64,
    sectors: Vec<Vec<(f64, usize)>>,
}

/// Sectors of direction: as many as make those of a busy face short.
const SECTORS: usize = 1024;

impl LineIndex {
    fn new(lines: &[(Discontinuity, [DVec2; 2])], tol: f64) -> Self {
        let points = || lines.iter().flat_map(|l| l.1);
        let low = points().fold(DVec2::INFINITY, DVec2::min);
        let high = points().fold(DVec2::NEG_INFINITY, DVec2::max);
        Self {
            centre: low.midpoint(high),
            radius: low.distance(high),
            tol,
            sectors: vec![Vec::new(); SECTORS],
        }
    }

    /// Direction and distance of the line through a segment.
    fn place(&self, [a, b]: [DVec2; 2]) -> (f64, f64) {
        let d = (b - a).normalize_or(DVec2::X);
        let d = if d.y < 0.0 || (d.y == 0.0 && d.x < 0.0) {
            -d
        } else {
            d
        };
        let angle = d.to_angle();
        // What rounds to half a turn is none, seen from the line's other side.
        let (angle, d) = if sector_of(angle) >= SECTORS as i64 {
            (0.0, -d)
        } else {
            (angle, d)
        };
        (angle, d.perp_dot(a.midpoint(b) - self.centre))
    }

    fn add(&mut self, ends: [DVec2; 2], class: usize) {
        let (angle, distance) = self.place(ends);
        let sector = &mut self.sectors[sector_of(angle) as usize];
        let at = sector.partition_point(|s| s.0 < distance);
        sector.insert(at, (distance, class));
    }

    /// The classes whose line may pass within the tolerance of both ends.
    fn near(&self, ends: [DVec2; 2]) -> impl Iterator<Item = usize> + '_ {
        let (angle, distance) = self.place(ends);
        // Twice the tolerance over the segment's length is what the directions may differ by; half as much again for
        // the arc over its sine and for round-off.
        let turn = (3.0 * self.tol / ends[0].distance(ends[1])).min(FRAC_PI_2);
        let shift = 2.0 * (self.tol + turn * self.radius);
        (sector_of(angle - turn)..=sector_of(angle + turn)).flat_map(move |k| {
            // Past half a turn the same line is seen from its other side.
            let count = SECTORS as i64;
            let sign = if k.div_euclid(count) % 2 == 0 {
                1.0
            } else {
                -1.0
            };
            let sector = &self.sectors[k.rem_euclid(count) as usize];
            let middle = sign * distance;
            let from = sector.partition_point(|s| s.0 < middle - shift);
            sector[from..]
                .iter()
                .take_while(move |s| s.0 <= middle + shift)
                .map(|s| s.1)
        })
    }
}

/// The number of the sector of an angle, counted on beyond half a turn.
fn sector_of(angle: f64) -> i64 {
    (angle / PI * SECTORS as f64).floor() as i64
}

/// What a line made of several is named after: the lowest order, and contacts before shadows.
fn rank(line: &Discontinuity) -> (DiscontinuityOrder, bool) {
    (line.order, line.kind != EventKind::Contact)
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
                    if rank(&d) < rank(&last.2) {
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

#[cfg(test)]
mod tests;
