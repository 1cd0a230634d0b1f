//! Curves between two logarithmic axes, as SVG.

use std::fmt::Write;

/// A curve: its name, its look, its points.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// Number of its colour.
    pub colour: usize,
    /// Whether it is drawn with dashes.
    pub is_dashed: bool,
    /// Points, in the order in which they are joined; those that are not above zero are left out.
    pub points: Vec<[f64; 2]>,
}

/// A plot of curves.
#[derive(Clone, Debug)]
pub struct Plot {
    /// Heading.
    pub title: String,
    /// Names of the axes, with their units.
    pub axes: [String; 2],
    /// Curves.
    pub curves: Vec<Curve>,
}

/// Colours that colour-blind eyes tell apart (Okabe and Ito 2008), dark enough on white.
const COLOURS: [&str; 6] = [
    "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#56b4e9", "#e69f00",
];

/// The drawing, and the frame of the curves in it: left, top, right, bottom, pixels.
const SIZE: [f64; 2] = [800.0, 400.0];
const FRAME: [f64; 4] = [74.0, 34.0, 500.0, 348.0];

/// Numbers along an axis: at 1, 2 and 5 times powers of ten where these are at most so many, else at the powers alone.
const MOST_NUMBERS: usize = 8;

/// Room around the curves, as a share of a decade.
const ROOM: f64 = 0.06;

impl Plot {
    /// The plot as SVG; empty axes from 1 to 10 without curves.
    pub fn svg(&self) -> String {
        let ranges = [0, 1].map(|k| self.range(k));
        let mut svg = String::new();
        let [width, height] = SIZE;
        put(
            &mut svg,
            format_args!(
                "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
            ),
        );
        let [left, top, right, bottom] = FRAME;
        put(
            &mut svg,
            format_args!(
                "<text x=\"{left}\" y=\"20\" font-size=\"14\" font-weight=\"bold\">{}</text>\n",
                escaped(&self.title)
            ),
        );
        for (k, &range) in ranges.iter().enumerate() {
            axis(&mut svg, k, range);
        }
        put(
            &mut svg,
            format_args!(
                "<rect x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#000000\"/>\n<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n<text transform=\"translate(16 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                right - left,
                bottom - top,
                (left + right) / 2.0,
                bottom + 36.0,
                escaped(&self.axes[0]),
                (top + bottom) / 2.0,
                escaped(&self.axes[1])
            ),
        );
        for (i, curve) in self.curves.iter().enumerate() {
            self.draw(&mut svg, i, curve, ranges);
        }
        svg.push_str("</svg>\n");
        svg
    }

    /// Logarithms between which all points lie along one axis.
    fn range(&self, k: usize) -> [f64; 2] {
        let logs = self.curves.iter().flat_map(drawn).map(|p| p[k].log10());
        let (low, high) = logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
            (l.min(x), h.max(x))
        });
        if low > high {
            return [0.0, 1.0];
        }
        [low - ROOM, high + ROOM.max(0.3 - (high - low))]
    }

    fn draw(&self, svg: &mut String, i: usize, curve: &Curve, ranges: [[f64; 2]; 2]) {
        let colour = COLOURS[curve.colour % COLOURS.len()];
        let dashes = if curve.is_dashed {
            " stroke-dasharray=\"5 4\""
        } else {
            ""
        };
        let places: Vec<[f64; 2]> = drawn(curve)
            .map(|p| [0, 1].map(|k| place(k, ranges[k], p[k].log10())))
            .collect();
        let mut path = String::new();
        for (n, [x, y]) in places.iter().enumerate() {
            let command = if n == 0 { 'M' } else { 'L' };
            put(&mut path, format_args!("{command}{x:.1} {y:.1}"));
        }
        put(
            svg,
            format_args!(
                "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"{dashes}/>\n"
            ),
        );
        for [x, y] in places {
            put(
                svg,
                format_args!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.2\" fill=\"{colour}\"/>\n"),
            );
        }
        let (x, y) = (FRAME[2] + 14.0, FRAME[1] + 14.0 + 20.0 * i as f64);
        put(
            svg,
            format_args!(
                "<path d=\"M{x:.1} {:.1}h26\" stroke=\"{colour}\" stroke-width=\"2\"{dashes}/>\n<text x=\"{:.1}\" y=\"{y:.1}\">{}</text>\n",
                y - 4.0,
                x + 32.0,
                escaped(&curve.name)
            ),
        );
    }
}

/// The points of a curve that have logarithms.
fn drawn(curve: &Curve) -> impl Iterator<Item = &[f64; 2]> {
    let is_drawn = |p: &&[f64; 2]| p.iter().all(|x| *x > 0.0 && x.is_finite());
    curve.points.iter().filter(is_drawn)
}

/// Pixel along axis `k` of the logarithm `x`.
fn place(k: usize, [low, high]: [f64; 2], x: f64) -> f64 {
    let t = (x - low) / (high - low);
    let [left, top, right, bottom] = FRAME;
    match k {
        0 => left + (right - left) * t,
        _ => bottom - (bottom - top) * t,
    }
}

/// Grid lines and numbers.
fn axis(svg: &mut String, k: usize, range: [f64; 2]) {
    let [left, top, right, bottom] = FRAME;
    let decades = range[0].floor() as i32..=range[1].ceil() as i32;
    let of = |digits: &[f64]| -> Vec<f64> {
        let all = decades
            .clone()
            .flat_map(|d| digits.iter().map(move |m| m * 10.0_f64.powi(d)));
        all.filter(|v| (range[0]..=range[1]).contains(&v.log10()))
            .collect()
    };
    let fine = of(&[1.0, 2.0, 5.0]);
    let values = if fine.len() <= MOST_NUMBERS {
        fine
    } else {
        of(&[1.0])
    };
    for value in values {
        let at = place(k, range, value.log10());
        let text = number(value);
        match k {
            0 => put(
                svg,
                format_args!(
                    "<path d=\"M{at:.1} {top}V{bottom}\" stroke=\"#e0e0e0\"/>\n<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{text}</text>\n",
                    bottom + 17.0
                ),
            ),
            _ => put(
                svg,
                format_args!(
                    "<path d=\"M{left} {at:.1}H{right}\" stroke=\"#e0e0e0\"/>\n<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{text}</text>\n",
                    left - 6.0,
                    at + 4.0
                ),
            ),
        }
    }
}

/// Numbers in this range are written without an exponent: they fit beside an axis.
const PLAIN: std::ops::Range<f64> = 1e-4..1e7;

/// A round number without the noise of its last digits; thousands parted by thin spaces.
fn number(x: f64) -> String {
    let x: f64 = format!("{x:.3e}").parse().unwrap_or(x);
    if !PLAIN.contains(&x) {
        return format!("{x:e}");
    }
    let text = x.to_string();
    if x < 1e4 {
        return text;
    }
    let mut parted = String::new();
    for (i, c) in text.chars().enumerate() {
        if i > 0 && (text.len() - i).is_multiple_of(3) {
            parted.push('\u{2009}');
        }
        parted.push(c);
    }
    parted
}

/// Writing to a string cannot fail.
fn put(text: &mut String, what: std::fmt::Arguments) {
    let _ = text.write_fmt(what);
}

/// Text as XML.
pub(super) fn escaped(text: &str) -> String {
    text.chars()
        .filter(|c| !c.is_control())
        .map(|c| match c {
            '&' => "&amp;".to_owned(),
            '<' => "&lt;".to_owned(),
            '>' => "&gt;".to_owned(),
            '"' => "&quot;".to_owned(),
            c => c.to_string(),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(points: Vec<[f64; 2]>) -> Plot {
        Plot {
            title: "a < b".to_owned(),
            axes: ["x".to_owned(), "y".to_owned()],
            curves: vec![Curve {
                name: "c".to_owned(),
                colour: 0,
                is_dashed: false,
                points,
            }],
        }
    }

    #[test]
    fn powers_are_straight_and_all_points_lie_in_the_frame() {
        let svg = plot(
            [1.0, 10.0, 100.0, 1e4]
                .map(|x: f64| [x, x.powi(-2)])
                .to_vec(),
        )
        .svg();
        let circles: Vec<[f64; 2]> = svg
            .lines()
            .filter(|l| l.starts_with("<circle"))
            .map(|l| {
                let words: Vec<f64> = l.split('"').filter_map(|w| w.parse().ok()).collect();
                [words[0], words[1]]
            })
            .collect();
        assert_eq!(circles.len(), 4);
        let slope =
            |i: usize, j: usize| (circles[j][1] - circles[i][1]) / (circles[j][0] - circles[i][0]);
        assert!(
            (slope(0, 1) / slope(2, 3) - 1.0).abs() < 0.01,
            "{circles:?}"
        );
        for [x, y] in circles {
            assert!(FRAME[0] < x && x < FRAME[2] && FRAME[1] < y && y < FRAME[3]);
        }
        assert!(svg.contains("a &lt; b"));
    }

    #[test]
    fn nothing_to_draw_is_still_a_plot() {
        for points in [vec![], vec![[0.0, 1.0], [1.0, f64::NAN]], vec![[5.0, 5.0]]] {
            let svg = plot(points).svg();
            assert!(
                svg.ends_with("</svg>\n") && !svg.contains("NaN") && !svg.contains("inf"),
                "{svg}"
            );
        }
        assert_eq!(number(0.3000000001), "0.3");
        assert_eq!(number(20000.0), "20\u{2009}000");
    }
}
