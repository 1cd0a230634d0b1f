//! Which candidate lines the mesh takes: those whose break shows in the elements they cross.

use super::receiver::rounded;
use super::{Illumination, Receiver};
use crate::discontinuity::{Discontinuity, DiscontinuityOrder, penumbra_width};
use crate::mesh::ReceiverMesh;
use crate::scene::Scene;
use glam::DVec2;

/// A line is tried when its predicted break exceeds this share of the error asked for: smaller ones cannot matter.
const JUMP_SHARE: f64 = 0.25;

/// A line is inserted when its measured break inside an element is as large as the element's error: below that, curvature
/// and not the break is what is wrong.
const BREAK_SHARE: f64 = 1.0;

/// The slope must jump by this share of what the curvature beside the line amounts to: what is merely curved is as well
/// divided anywhere else, and without a crowd of vertices where lines cross.
const KINK_SHARE: f64 = 1.0;

/// A change of curvature looks like a kink in elements that reach over at least this share of the penumbra.
const SHARP_SHARE: f64 = 0.5;

/// So many of the strongest lines that cross an element are tried; others have their turn in its parts.
const LINES_TRIED: usize = 2;

/// What is known of a candidate before any light is evaluated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rank {
    order: DiscontinuityOrder,
    /// Predicted break over the whole penumbra, W/m².
    jump: f64,
    /// Widths of the penumbra at both ends, metres; none: as sharp as can be.
    widths: Option<[f64; 2]>,
}

impl Rank {
    pub(super) fn new(scene: &Scene, line: &Discontinuity) -> Self {
        Self {
            order: line.order,
            jump: line.jump,
            widths: penumbra_width(scene, line),
        }
    }

    /// Predicted break (W/m²) within a reach of `h` metres, at parameter `t` of the line: the jump itself, slope times h, or
    /// curvature times h², never more than over the whole penumbra.
    pub(super) fn predicted(&self, t: f64, h: f64) -> f64 {
        let share = self.widths.map_or(1.0, |[a, b]| {
            let width = a + (b - a) * t;
            if width > h { h / width } else { 1.0 }
        });
        self.jump
            * match self.order {
                DiscontinuityOrder::D0 => 1.0,
                DiscontinuityOrder::D1 => share,
                DiscontinuityOrder::D2 => share * share,
            }
    }

    /// Whether the break can look like a kink within a reach of `h` metres.
    fn is_sharp(&self, t: f64, h: f64) -> bool {
        self.order != DiscontinuityOrder::D2
            || self
                .widths
                .is_none_or(|[a, b]| h >= SHARP_SHARE * (a + (b - a) * t))
    }
}

/// The part of a line inside a triangle.
pub(super) struct Stretch {
    ends: [DVec2; 2],
    /// Predicted break within the triangle, W/m².
    predicted: f64,
}

impl Stretch {
    pub(super) fn middle(&self) -> DVec2 {
        self.ends[0].midpoint(self.ends[1])
    }
}

impl Receiver {
    /// The candidates that cross triangle `p` and could matter to errors of `target`: at most `most`, the strongest first.
    pub(super) fn open_lines_in(
        &self,
        p: [DVec2; 3],
        target: f64,
        most: usize,
    ) -> Vec<(usize, Stretch)> {
        let mut lines: Vec<(usize, Stretch)> = (0..self.kept.len())
            .filter_map(|i| Some((i, self.open_line_in(i, p, target)?)))
            .collect();
        lines.sort_by(|a, b| rounded(b.1.predicted).total_cmp(&rounded(a.1.predicted)));
        lines.truncate(most);
        lines
    }

    /// The stretch inside triangle `p` of a candidate that is not yet kept and could matter to errors of `target`.
    fn open_line_in(&self, i: usize, p: [DVec2; 3], target: f64) -> Option<Stretch> {
        let rank = &self.ranks[i];
        if self.kept[i] || rank.jump < JUMP_SHARE * target {
            return None;
        }
        let line = self.domain.line(i);
        let (t0, t1) = clip_to_triangle(line, p)?;
        let ends = [t0, t1].map(|t| line[0].lerp(line[1], t));
        let across = (line[1] - line[0]).perp().normalize_or_zero();
        let far = p.map(|q| across.dot(q - ends[0]));
        let reach = far.into_iter().fold(0.0, f64::max) - far.into_iter().fold(0.0, f64::min);
        let t = 0.5 * (t0 + t1);
        let predicted = rank.predicted(t, reach);
        (rank.is_sharp(t, reach) && predicted >= JUMP_SHARE * target)
            .then_some(Stretch { ends, predicted })
    }

    /// Keeps the candidate that breaks most inside element `e`; false when none does.
    pub(super) fn keep_line(
        &mut self,
        light: &Illumination,
        mesh: &ReceiverMesh,
        e: usize,
        target: f64,
    ) -> bool {
        let p = mesh.corners(e);
        let least = BREAK_SHARE * (self.errors[e].square / mesh.area(e)).sqrt();
        let mut best: Option<(f64, usize)> = None;
        for (i, stretch) in self.open_lines_in(p, target, LINES_TRIED) {
            // The others are predicted to break less.
            if stretch.predicted < best.map_or(least, |b| b.0) {
                break;
            }
            let measured = self.measure_break(light, p, &stretch, least);
            if measured >= least && best.is_none_or(|b| rounded(measured) > rounded(b.0)) {
                best = Some((measured, i));
            }
        }
        if let Some((measured, i)) = best {
            self.kept[i] = true;
            self.breaks[i] = measured;
        }
        best.is_some()
    }

    /// How much the irradiance departs, across the stretch, from one smooth function: the jump of its slope over the
    /// triangle's reach to both sides, W/m²; nothing where the light is more curved than kinked, or where it is below `least`.
    fn measure_break(
        &mut self,
        light: &Illumination,
        p: [DVec2; 3],
        stretch: &Stretch,
        least: f64,
    ) -> f64 {
        let middle = stretch.middle();
        let normal = (stretch.ends[1] - stretch.ends[0])
            .perp()
            .normalize_or_zero();
        let longest = (0..3)
            .map(|k| p[k].distance(p[(k + 1) % 3]))
            .fold(0.0, f64::max);
        let reach = |n: DVec2| {
            let far = clip_to_triangle([middle, middle + n * longest], p);
            far.map_or(0.0, |(_, t)| t * longest)
        };
        let (left, right) = (reach(normal), reach(-normal));
        // Both sides as far as the nearer border allows, and not onto the border itself.
        let h = 0.9 * left.min(right).max(0.25 * left.max(right));
        if h <= 0.0 {
            return 0.0;
        }
        // What rays tell past a crowd is rougher than any kink.
        let look = self.look(light, middle);
        if !look.is_exact {
            return 0.0;
        }
        let mut at = |t: f64| self.look(light, middle + normal * (t * h)).light;
        let (e0, near) = (look.light, [at(0.5), at(-0.5)]);
        // Half the jump S of the slope and an eighth of both curvatures; of a kink these are at most S / KINK_SHARE each.
        let bend = (near[0] + near[1] - e0 * 2.0).0.mean_square().sqrt();
        if bend < (1.0 - 0.5 / KINK_SHARE) * least {
            return 0.0;
        }
        let far = [at(1.0), at(-1.0)];
        // One-sided parabolas through 0, ½, 1: slope and curvature at the line in units of h.
        let fit = |k: usize| {
            let slope = near[k] * 4.0 - far[k] - e0 * 3.0;
            let curvature = (far[k] - near[k] * 2.0 + e0) * 4.0;
            (slope, curvature.0.mean_square().sqrt())
        };
        let ((s0, c0), (s1, c1)) = (fit(0), fit(1));
        let slope = (s0 + s1).0.mean_square().sqrt();
        if slope < KINK_SHARE * c0.max(c1) {
            return 0.0;
        }
        0.5 * slope
    }
}

/// Parameters of the stretch of a segment inside a counter-clockwise triangle; none when it has no length.
fn clip_to_triangle(ends: [DVec2; 2], p: [DVec2; 3]) -> Option<(f64, f64)> {
    let (mut t0, mut t1) = (0.0_f64, 1.0_f64);
    for k in 0..3 {
        let d = p[(k + 1) % 3] - p[k];
        let (da, db) = (d.perp_dot(ends[0] - p[k]), d.perp_dot(ends[1] - p[k]));
        if da <= 0.0 && db <= 0.0 {
            return None;
        } else if da < 0.0 {
            t0 = t0.max(da / (da - db));
        } else if db < 0.0 {
            t1 = t1.min(da / (da - db));
        }
    }
    (t0 < t1).then_some((t0, t1))
}
