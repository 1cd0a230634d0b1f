//! One side of one face flat and to scale, as SVG: elements, discontinuities, and a tint of the light.

use crate::adapt::Receiver;
use crate::discontinuity::DiscontinuityOrder;
use crate::pipeline::{EdgeRole, Solution, mesh_edges};
use crate::scene::FaceSide;
use glam::DVec2;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Longer side of the drawn face, pixels.
const LONGER_SIDE: f64 = 800.0;

/// Room around the face, pixels.
const MARGIN: f64 = 24.0;

/// Room below it for the legend, pixels.
const LEGEND: f64 = 76.0;

/// Least width of the drawing, pixels: the legend has to fit beside a narrow face.
const MIN_WIDTH: f64 = 520.0;

/// Tints of the irradiance: more would not be told apart under the lines.
const TINTS: usize = 48;

/// Grey of black and of the brightest element, 0…255: faint, so that lines stand out on both.
const DARKEST: f64 = 165.0;
const BRIGHTEST: f64 = 255.0;

/// How each kind of edge is drawn, later ones over earlier ones: role, name, colour, width in pixels. The colours are told apart by colour-blind eyes
/// (Okabe and Ito, *Color universal design*, 2008).
const STROKES: [(EdgeRole, &str, &str, f64); 5] = [
    (EdgeRole::Inner, "element", "#8a8a8a", 0.4),
    (
        EdgeRole::Break(DiscontinuityOrder::D2),
        "D2 curvature",
        "#009e73",
        1.2,
    ),
    (
        EdgeRole::Break(DiscontinuityOrder::D1),
        "D1 slope",
        "#0072b2",
        1.6,
    ),
    (
        EdgeRole::Break(DiscontinuityOrder::D0),
        "D0 value",
        "#d55e00",
        2.2,
    ),
    (EdgeRole::Outline, "outline", "#000000", 1.2),
];

/// Metres to pixels: x to the right as seen from the lit side, y down.
struct Drawing {
    low: DVec2,
    size: DVec2,
    scale: f64,
    is_mirrored: bool,
}

impl Drawing {
    fn new(r: &Receiver) -> Self {
        let (low, high) = r.domain.polygon().bounds();
        let size = high - low;
        Self {
            low,
            size,
            scale: LONGER_SIDE / size.max_element(),
            is_mirrored: r.domain.side == FaceSide::Back,
        }
    }

    fn point(&self, p: DVec2) -> DVec2 {
        let q = p - self.low;
        let x = if self.is_mirrored {
            self.size.x - q.x
        } else {
            q.x
        };
        DVec2::new(x, self.size.y - q.y) * self.scale + MARGIN
    }

    fn path(&self, points: &[DVec2]) -> String {
        let mut text = String::new();
        for (i, &p) in points.iter().enumerate() {
            let q = self.point(p);
            let command = if i == 0 { 'M' } else { 'L' };
            put(&mut text, format_args!("{command}{:.2} {:.2}", q.x, q.y));
        }
        text
    }
}

/// Writing to a string cannot fail.
fn put(text: &mut String, what: std::fmt::Arguments) {
    let _ = text.write_fmt(what);
}

/// The drawing of receiver number `receiver` of `solution`, seen from its lit side.
pub fn face_svg(solution: &Solution, receiver: usize) -> String {
    let r = &solution.receivers[receiver];
    let drawing = Drawing::new(r);
    let drawn = drawing.size * drawing.scale;
    let width = (drawn.x + 2.0 * MARGIN).max(MIN_WIDTH);
    let height = drawn.y + 2.0 * MARGIN + LEGEND;
    let mut svg = String::new();
    put(
        &mut svg,
        format_args!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" viewBox=\"0 0 {width:.2} {height:.2}\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
        ),
    );
    fill(&mut svg, r, &drawing);
    strokes(&mut svg, r, &drawing);
    legend(&mut svg, solution, r, &drawing, drawn.y + 2.0 * MARGIN);
    svg.push_str("</svg>\n");
    svg
}

/// The middle value of each element over the brightest corner, as a tint; elements of one tint are one path.
fn fill(svg: &mut String, r: &Receiver, drawing: &Drawing) {
    let brightest = brightest(r);
    let mut tints: BTreeMap<usize, String> = BTreeMap::new();
    for e in 0..r.mesh.elements.len() {
        let share = if brightest > 0.0 {
            (r.shown(e, [1.0 / 3.0; 3]).mean() / brightest).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let tint = (share * (TINTS - 1) as f64).round() as usize;
        let path = tints.entry(tint).or_default();
        path.push_str(&drawing.path(&r.mesh.corners(e)));
        path.push('Z');
    }
    for (tint, path) in tints {
        let share = tint as f64 / (TINTS - 1) as f64;
        let grey = (DARKEST + (BRIGHTEST - DARKEST) * share).round() as u8;
        // Its own stroke closes the seams between neighbours of one tint.
        put(
            svg,
            format_args!(
                "<path d=\"{path}\" fill=\"#{grey:02x}{grey:02x}{grey:02x}\" stroke=\"#{grey:02x}{grey:02x}{grey:02x}\" stroke-width=\"0.5\"/>\n"
            ),
        );
    }
}

fn brightest(r: &Receiver) -> f64 {
    (0..r.mesh.site_vertices.len())
        .map(|s| r.site_total(s).mean())
        .fold(0.0, f64::max)
}

fn strokes(svg: &mut String, r: &Receiver, drawing: &Drawing) {
    let edges = mesh_edges(r);
    for (role, _, colour, width) in STROKES {
        let mut path = String::new();
        for edge in edges.iter().filter(|edge| edge.role == role) {
            path.push_str(&drawing.path(&edge.ends));
        }
        if !path.is_empty() {
            put(
                svg,
                format_args!(
                    "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" stroke-linecap=\"round\"/>\n"
                ),
            );
        }
    }
}

fn legend(svg: &mut String, solution: &Solution, r: &Receiver, drawing: &Drawing, top: f64) {
    let scene = &solution.world.scene;
    let face = &scene.faces[r.domain.face];
    let side = match r.domain.side {
        FaceSide::Front => "front",
        FaceSide::Back => "back",
    };
    put(
        svg,
        format_args!(
            "<g font-family=\"sans-serif\" font-size=\"13\" fill=\"#000000\">\n<text x=\"{MARGIN}\" y=\"{:.2}\">{} (face {}, {side}): {:.4} × {:.4} m, {} elements, white = {:.4} W/m²</text>\n",
            top + 4.0,
            escaped(&scene.groups[face.group as usize]),
            r.domain.face,
            drawing.size.x,
            drawing.size.y,
            r.mesh.elements.len(),
            brightest(r)
        ),
    );
    let mut x = MARGIN;
    for (_, name, colour, width) in STROKES.into_iter().rev() {
        let y = top + 22.0;
        put(
            svg,
            format_args!(
                "<path d=\"M{x:.2} {y:.2}h22\" stroke=\"{colour}\" stroke-width=\"{width}\"/>\n<text x=\"{:.2}\" y=\"{:.2}\">{name}</text>\n",
                x + 27.0,
                y + 4.0
            ),
        );
        // Letters of 13 px are some 7 px wide.
        x += 40.0 + 7.0 * name.len() as f64;
    }
    let (length, y) = (round_length(0.25 * drawing.size.max_element()), top + 46.0);
    put(
        svg,
        format_args!(
            "<path d=\"M{MARGIN} {:.2}v6h{:.2}v-6\" fill=\"none\" stroke=\"#000000\"/>\n<text x=\"{:.2}\" y=\"{:.2}\">{length} m</text>\n</g>\n",
            y - 6.0,
            length * drawing.scale,
            MARGIN + length * drawing.scale + 6.0,
            y + 2.0
        ),
    );
}

/// The largest of 1, 2, 5 times a power of ten that is not above `x`.
fn round_length(x: f64) -> f64 {
    let power = 10.0_f64.powi(x.log10().floor() as i32);
    let digit = [5.0, 2.0, 1.0].into_iter().find(|d| d * power <= x);
    digit.unwrap_or(1.0) * power
}

/// A name as the text of an XML element.
fn escaped(name: &str) -> String {
    name.chars()
        .filter(|c| !c.is_control())
        .map(|c| match c {
            '&' => "&amp;".to_owned(),
            '<' => "&lt;".to_owned(),
            '>' => "&gt;".to_owned(),
            c => c.to_string(),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_bars_have_round_lengths() {
        for (x, bar) in [(0.25, 0.2), (1.5, 1.0), (7.0, 5.0), (2.0e3, 2.0e3)] {
            assert!((round_length(x) / bar - 1.0).abs() < 1e-12, "{x}");
        }
    }

    #[test]
    fn names_cannot_break_the_file() {
        assert_eq!(escaped("a<b>&\u{7}c"), "a&lt;b&gt;&amp;c");
    }
}
