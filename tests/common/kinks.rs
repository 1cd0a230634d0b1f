//! Finds where a piecewise smooth function of one variable breaks, and whether its value, slope or curvature does.
//!
//! The interval is bisected until Chebyshev interpolation on each piece is good to round-off. Around a break of order
//! k the pieces become as narrow as round-off lets a jump of order k be seen, so every group of pieces narrower than
//! its neighbours is a candidate. A candidate is judged by two polynomials, one fitted to each side of it: their
//! difference D is a jump where D does not vanish (order 0), a kink where it crosses zero (order 1), a change of
//! curvature where it touches zero (order 2), and nothing where it stays within the fits' own uncertainty.
//!
//! ```text
//!       D0            D1            D2
//!       ____            /         \     /   D = right fit - left fit,
//!                    __/__        _\___/_   near the candidate
//!       ____          /
//! ```

use std::f64::consts::PI;

/// A break of a function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Kink {
    /// Where, in the function's own variable.
    pub(crate) t: f64,
    /// How far off `t` may be.
    pub(crate) uncertainty: f64,
    /// 0: the value jumps, 1: the slope, 2: the curvature; `None`: several breaks too close to be told apart.
    pub(crate) order: Option<u8>,
    /// Right less left of value, slope and curvature, for the variable scaled to an interval of length 1 and the
    /// function to a largest magnitude of 1.
    pub(crate) jumps: [f64; 3],
}

/// What to look for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KinkSettings {
    /// Round-off of the function, relative to its largest magnitude.
    pub(crate) noise: f64,
    /// Pieces are not divided below this part of the interval.
    pub(crate) narrowest: f64,
    /// A jump counts when it exceeds its own uncertainty this many times.
    pub(crate) significance: f64,
}

impl Default for KinkSettings {
    fn default() -> Self {
        Self {
            noise: 1e-14,
            narrowest: 1e-4,
            significance: 20.0,
        }
    }
}

/// Not at the middle: breaks often lie there, and one that falls on the end of a piece is invisible.
const SPLIT: f64 = 0.484_375_3;
const LEAF_NODES: usize = 12;
const LONGEST_GROUP: usize = 6;
const SHALLOWEST_FALL: u32 = 2;
const SIDE_NODES: usize = 24;
const SIDE_DEGREE: usize = 6;
/// No more than this part of the interval goes into the fit of one side.
const WIDEST_SIDE: f64 = 0.25;

/// All breaks of `f` between `start` and `end`, from `start` on.
///
/// Breaks closer to each other than ten times `narrowest` are seen as one, with an order that need not be any of
/// theirs; those as close to `start` or `end` are not seen. For a function of magnitude 1 and round-off 1e-14 on an
/// interval of length 1, jumps above 2e-12 of the value, 2e-8 of the slope, 3e-5 of the curvature are found; round-off
/// of 1e-12 raises that to 2e-10, 2e-6, 4e-4 (measured: `references::measure`).
pub(crate) fn find_kinks(
    f: &dyn Fn(f64) -> f64,
    (start, end): (f64, f64),
    settings: &KinkSettings,
) -> Vec<Kink> {
    let length = end - start;
    let samples = (0..=64).map(|i| f(start + length * f64::from(i) / 64.0).abs());
    let scale = samples.fold(0.0, f64::max);
    if scale == 0.0 {
        return Vec::new();
    }
    let unit = |t: f64| f(start + length * t) / scale;
    let mut leaves = Vec::new();
    let whole = Leaf {
        a: 0.0,
        b: 1.0,
        depth: 0,
    };
    divide(&unit, whole, settings, &mut leaves);
    let brackets = brackets(&leaves);
    let mut kinks = Vec::new();
    for (i, &(left, right)) in brackets.iter().enumerate() {
        let before = if i == 0 { 0.0 } else { brackets[i - 1].1 };
        let after = brackets.get(i + 1).map_or(1.0, |b| b.0);
        kinks.extend(judge(&unit, (before, after), (left, right), settings));
    }
    for kink in &mut kinks {
        kink.t = start + length * kink.t;
        kink.uncertainty *= length;
    }
    kinks
}

/// A piece of the interval and how often it was divided out of the whole.
#[derive(Clone, Copy)]
struct Leaf {
    a: f64,
    b: f64,
    depth: u32,
}

/// Bisects until each piece is smooth to round-off, or the narrowest.
fn divide(f: &dyn Fn(f64) -> f64, leaf: Leaf, settings: &KinkSettings, leaves: &mut Vec<Leaf>) {
    let Leaf { a, b, depth } = leaf;
    // Reach over the ends: between an end and the outermost node a break would hide.
    let margin = 0.02 * (b - a);
    let (low, high) = ((a - margin).max(0.0), (b + margin).min(1.0));
    let fit = Fit::new(f, low, high, LEAF_NODES, LEAF_NODES - 1);
    let tail = fit.coefficients[LEAF_NODES - 3..]
        .iter()
        .fold(0.0, |m: f64, c| m.max(c.abs()));
    // The widest pieces are divided anyway: their nodes are few for a whole interval.
    let is_smooth = tail <= 4.0 * settings.noise && depth > 2;
    if is_smooth || 0.5_f64.powi(depth as i32) <= settings.narrowest {
        leaves.push(leaf);
        return;
    }
    let middle = a + (b - a) * SPLIT;
    let depth = depth + 1;
    divide(
        f,
        Leaf {
            b: middle,
            depth,
            ..leaf
        },
        settings,
        leaves,
    );
    divide(
        f,
        Leaf {
            a: middle,
            depth,
            ..leaf
        },
        settings,
        leaves,
    );
}

/// Groups of pieces divided clearly more often than those around, each with a margin.
fn brackets(leaves: &[Leaf]) -> Vec<(f64, f64)> {
    let mut brackets: Vec<(f64, f64)> = Vec::new();
    let groups: Vec<&[Leaf]> = leaves.chunk_by(|a, b| a.depth == b.depth).collect();
    let depth = |group: &&[Leaf]| group[0].depth;
    for (i, group) in groups.iter().enumerate() {
        // By how much the depth falls from here until it rises again; beyond the ends there is nothing to see.
        let falls = |beside: &mut dyn Iterator<Item = u32>| {
            let mut last = depth(group);
            for next in beside {
                if next > last {
                    break;
                }
                last = next;
            }
            depth(group) - last
        };
        let left = falls(&mut groups[..i].iter().rev().map(depth));
        let right = falls(&mut groups[i + 1..].iter().map(depth));
        // A smooth function leaves long rows of equal pieces behind, and shallow steps.
        if group.len() <= LONGEST_GROUP && left >= SHALLOWEST_FALL && right >= SHALLOWEST_FALL {
            let margin = 0.25 * (group[0].b - group[0].a);
            let (left, right) = (group[0].a - margin, group[group.len() - 1].b + margin);
            brackets.push((left.max(0.0), right.min(1.0)));
        }
    }
    // Between two brackets there has to be room to see the function without its breaks.
    brackets.dedup_by(|next, last| {
        let is_close = next.0 - last.1 < 2.5 * (next.1 - next.0).max(last.1 - last.0);
        if is_close {
            last.1 = next.1;
        }
        is_close
    });
    brackets
}

/// What the break in a bracket is, if it is one, from the function on its two sides, up to `before` and `after`.
fn judge(
    f: &dyn Fn(f64) -> f64,
    limits: (f64, f64),
    bracket: (f64, f64),
    settings: &KinkSettings,
) -> Option<Kink> {
    let first = judge_once(f, limits, bracket, settings)?;
    // Again from close by: the jumps are then those at the break instead of extrapolations.
    let reach = (4.0 * first.uncertainty).max(1e-7);
    if first.order.is_none() || reach >= bracket.1 - bracket.0 {
        return Some(first);
    }
    let close = (first.t - reach, first.t + reach);
    let mut second = judge_once(f, limits, close, settings).unwrap_or(first);
    if second.order != first.order {
        second = first;
    }
    Some(second)
}

fn judge_once(
    f: &dyn Fn(f64) -> f64,
    (before, after): (f64, f64),
    (left, right): (f64, f64),
    settings: &KinkSettings,
) -> Option<Kink> {
    let gap = right - left;
    let low = Fit::best(
        f,
        left,
        (left - before).min(WIDEST_SIDE),
        gap,
        -1.0,
        settings,
    )?;
    let high = Fit::best(
        f,
        right,
        (after - right).min(WIDEST_SIDE),
        gap,
        1.0,
        settings,
    )?;
    let jumps = |t: f64| {
        let (l, h) = (low.derivatives(t), high.derivatives(t));
        [h[0] - l[0], h[1] - l[1], h[2] - l[2]]
    };
    let doubt = |t: f64| {
        let (l, h) = (low.uncertainty(t, settings), high.uncertainty(t, settings));
        [0, 1, 2].map(|k| settings.significance * l[k].hypot(h[k]))
    };
    let kink = |t: f64, order: Option<u8>, uncertainty: f64| {
        Some(Kink {
            t,
            uncertainty,
            order,
            jumps: jumps(t),
        })
    };
    // Where the sides differ least, and where their slopes do.
    let flattest = least(&|t| jumps(t)[1], left, right);
    let crossing = least(&|t| jumps(t)[0], left, right);
    let is_nearer = jumps(flattest)[0].abs() < jumps(crossing)[0].abs();
    let nearest = if is_nearer { flattest } else { crossing };
    if jumps(nearest)[0].abs() > doubt(nearest)[0] {
        let t = locate_jump(f, &low, &high, left, right);
        // A real jump is there at once; two kinks in the bracket shift the value only from end to end.
        let at_once = f(t + 1e-12) - f(t - 1e-12);
        return if at_once.abs() > 0.5 * jumps(t)[0].abs() {
            kink(t, Some(0), 1e-14)
        } else {
            kink(left + gap / 2.0, None, gap / 2.0)
        };
    }
    let [value, slope, curvature] = jumps(flattest);
    let limit = doubt(flattest);
    let touches = value.abs() <= limit[0] && slope.abs() <= limit[1];
    if touches {
        let is_significant = curvature.abs() > limit[2];
        let uncertainty = (limit[1] / curvature.abs()).min(gap);
        return is_significant
            .then(|| kink(flattest, Some(2), uncertainty))
            .flatten();
    }
    let slope = jumps(nearest)[1].abs();
    let limit = doubt(nearest);
    let uncertainty = (limit[0] / slope).min(gap);
    (slope > limit[1])
        .then(|| kink(nearest, Some(1), uncertainty))
        .flatten()
}

/// Bisects a jump of the value: each side continues its own fit up to the jump.
fn locate_jump(f: &dyn Fn(f64) -> f64, low: &Fit, high: &Fit, left: f64, right: f64) -> f64 {
    let (mut a, mut b) = (left, right);
    for _ in 0..60 {
        let middle = a + (b - a) / 2.0;
        let value = f(middle);
        let from_low = (value - low.derivatives(middle)[0]).abs();
        let from_high = (value - high.derivatives(middle)[0]).abs();
        if from_low <= from_high {
            a = middle;
        } else {
            b = middle;
        }
    }
    a + (b - a) / 2.0
}

/// Where a smooth function is nearest to zero: at a crossing nearest to the middle if there is one.
fn least(d: &dyn Fn(f64) -> f64, left: f64, right: f64) -> f64 {
    const STEPS: u32 = 64;
    let at = |i: u32| left + (right - left) * f64::from(i) / f64::from(STEPS);
    let values: Vec<f64> = (0..=STEPS).map(|i| d(at(i))).collect();
    let from_middle = |i: &u32| (2 * i + 1).abs_diff(STEPS);
    let crossing = (0..STEPS)
        .filter(|&i| values[i as usize] * values[i as usize + 1] <= 0.0)
        .min_by_key(from_middle);
    if let Some(i) = crossing {
        let (mut a, mut b) = (at(i), at(i + 1));
        let rises = values[i as usize] < 0.0;
        for _ in 0..60 {
            let middle = a + (b - a) / 2.0;
            if (d(middle) < 0.0) == rises {
                a = middle;
            } else {
                b = middle;
            }
        }
        return a + (b - a) / 2.0;
    }
    let nearest = (0..=STEPS).min_by(|&i, &j| {
        values[i as usize]
            .abs()
            .total_cmp(&values[j as usize].abs())
    });
    at(nearest.unwrap_or(0))
}

/// A Chebyshev series fitted to a function on an interval.
struct Fit {
    a: f64,
    b: f64,
    coefficients: Vec<f64>,
    nodes: usize,
    residual: f64,
}

impl Fit {
    fn new(f: &dyn Fn(f64) -> f64, a: f64, b: f64, nodes: usize, degree: usize) -> Self {
        let angle = |j: usize| PI * (j as f64 + 0.5) / nodes as f64;
        let values: Vec<f64> = (0..nodes)
            .map(|j| f(a + (b - a) * (0.5 + 0.5 * angle(j).cos())))
            .collect();
        // The Chebyshev polynomials are orthogonal over these nodes, so least squares needs no matrix.
        let coefficients: Vec<f64> = (0..=degree)
            .map(|k| {
                let sum: f64 = (0..nodes)
                    .map(|j| values[j] * (k as f64 * angle(j)).cos())
                    .sum();
                sum * if k == 0 { 1.0 } else { 2.0 } / nodes as f64
            })
            .collect();
        let mut fit = Self {
            a,
            b,
            coefficients,
            nodes,
            residual: 0.0,
        };
        let squares: f64 = (0..nodes)
            .map(|j| (fit.series(angle(j).cos())[0] - values[j]).powi(2))
            .sum();
        fit.residual = (squares / (nodes - degree).max(1) as f64).sqrt();
        fit
    }

    /// The fit beside a bracket (on the side `sign` of `end`) that knows the curvature best: a wider one averages more
    /// round-off away, until the polynomial can no longer follow the function. `None` where there is no room.
    fn best(
        f: &dyn Fn(f64) -> f64,
        end: f64,
        room: f64,
        gap: f64,
        sign: f64,
        settings: &KinkSettings,
    ) -> Option<Self> {
        let mut width = room;
        let mut best: Option<(f64, Self)> = None;
        while width >= 2.0 * gap && width > 1e-6 {
            let (a, b) = if sign < 0.0 {
                (end - width, end)
            } else {
                (end, end + width)
            };
            let fit = Self::new(f, a, b, SIDE_NODES, SIDE_DEGREE);
            let doubt = fit.uncertainty(end - sign * gap / 2.0, settings)[2];
            if best.as_ref().is_none_or(|(least, _)| doubt < *least) {
                best = Some((doubt, fit));
            }
            width *= 0.6;
        }
        best.map(|(_, fit)| fit)
    }

    /// Value, first and second derivative in the variable of [-1, 1].
    fn series(&self, s: f64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (t, c) in chebyshev(s).zip(&self.coefficients) {
            for (sum, t) in sum.iter_mut().zip(t) {
                *sum += c * t;
            }
        }
        sum
    }

    fn slope_of_variable(&self) -> f64 {
        2.0 / (self.b - self.a)
    }

    fn derivatives(&self, t: f64) -> [f64; 3] {
        let d = self.slope_of_variable();
        let [v, s, c] = self.series((t - self.a) * d - 1.0);
        [v, s * d, c * d * d]
    }

    /// Standard deviation of value, slope and curvature at `t`, from the residual (at least the round-off).
    fn uncertainty(&self, t: f64, settings: &KinkSettings) -> [f64; 3] {
        let d = self.slope_of_variable();
        let mut squares = [0.0; 3];
        for t in chebyshev((t - self.a) * d - 1.0).take(self.coefficients.len()) {
            for (sum, t) in squares.iter_mut().zip(t) {
                *sum += t * t * 2.0 / self.nodes as f64;
            }
        }
        let sigma = self.residual.max(settings.noise);
        [0, 1, 2].map(|k| sigma * squares[k as usize].sqrt() * d.powi(k))
    }
}

/// Each Chebyshev polynomial at `s`, with its first two derivatives.
fn chebyshev(s: f64) -> impl Iterator<Item = [f64; 3]> {
    let (mut now, mut next) = ([1.0, 0.0, 0.0], [s, 1.0, 0.0]);
    std::iter::from_fn(move || {
        let out = now;
        let after = [
            2.0 * s * next[0] - now[0],
            2.0 * (next[0] + s * next[1]) - now[1],
            2.0 * (2.0 * next[1] + s * next[2]) - now[2],
        ];
        (now, next) = (next, after);
        Some(out)
    })
}
