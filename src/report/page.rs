//! The report as one page: pictures, plots and tables in one file.

use super::convergence::SceneReport;
use super::fit::{crossing, exponent};
use super::growth::GrowthRow;
use super::methods::{BASES, MESH_METHODS};
use super::plot::{Curve, Plot, escaped};
use super::record::Record;
use super::stability::StabilityRow;
use crate::viewer::base64;
use std::fmt::Write;

/// Everything that was measured.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// One for each scene.
    pub scenes: Vec<SceneReport>,
    /// Cost as the scene grows.
    pub growth: Vec<GrowthRow>,
    /// Stiff and extreme scenes.
    pub stability: Vec<StabilityRow>,
}

/// A quantity of a record to draw it by.
type Quantity = fn(&Record) -> f64;

/// Against what the error is drawn: name of the file, name of the axis, and the number.
const COSTS: [(&str, &str, Quantity); 2] = [
    ("elements", "elements", |r| r.work.elements as f64),
    ("seconds", "seconds", |r| r.seconds),
];

impl Report {
    /// Every plot with the name of its file, without its ending.
    pub fn plots(&self) -> Vec<(String, Plot)> {
        let mut plots = Vec::new();
        for scene in &self.scenes {
            for (cost, axis, of) in COSTS {
                plots.push((
                    format!("{}-{cost}", file_name(&scene.name)),
                    scene.plot(axis, of),
                ));
            }
        }
        if !self.growth.is_empty() {
            plots.push(("growth-seconds".to_owned(), self.growth_plot()));
        }
        plots
    }

    fn families(&self) -> Vec<(&'static str, Vec<&GrowthRow>)> {
        let mut families: Vec<(&str, Vec<&GrowthRow>)> = Vec::new();
        for row in &self.growth {
            match families.iter_mut().find(|f| f.0 == row.family) {
                Some(family) => family.1.push(row),
                None => families.push((row.family, vec![row])),
            }
        }
        families
    }

    fn growth_plot(&self) -> Plot {
        let curves = self
            .families()
            .into_iter()
            .enumerate()
            .map(|(i, (name, rows))| {
                let points: Vec<[f64; 2]> =
                    rows.iter().map(|r| [r.faces as f64, r.seconds]).collect();
                Curve {
                    name: with_slope(name, &points),
                    colour: i,
                    is_dashed: false,
                    points,
                }
            });
        Plot {
            title: "cost as the scene grows (direct light, 5 %)".to_owned(),
            axes: ["faces".to_owned(), "seconds".to_owned()],
            curves: curves.collect(),
        }
    }
}

impl SceneReport {
    /// Runs of one way to mesh and one basis with the solver that comes first, from coarse to fine.
    fn curve(&self, mesh: &str, basis: &str, of: Quantity) -> Vec<[f64; 2]> {
        let first = self.records.first().map(|r| r.solver.clone());
        self.records
            .iter()
            .filter(|r| r.mesh == mesh && r.basis == basis && Some(&r.solver) == first.as_ref())
            .map(|r| [of(r), 100.0 * r.rms])
            .collect()
    }

    fn plot(&self, axis: &str, of: Quantity) -> Plot {
        let mut curves = Vec::new();
        for (i, mesh) in MESH_METHODS.iter().enumerate() {
            for (k, (basis, _)) in BASES.iter().enumerate() {
                let points = self.curve(mesh.name, basis, of);
                curves.push(Curve {
                    name: with_slope(&format!("{}, {basis}", mesh.name), &points),
                    colour: i,
                    is_dashed: k == 0,
                    points,
                });
            }
        }
        // Other solvers on the program's own mesh.
        let mut others: Vec<&str> = self.records.iter().map(|r| r.solver.as_str()).collect();
        others.dedup();
        let own = MESH_METHODS[MESH_METHODS.len() - 1].name;
        for (i, solver) in others.into_iter().skip(1).enumerate() {
            let rows = self
                .records
                .iter()
                .filter(|r| r.solver == solver && r.mesh == own && r.basis == "linear");
            let points: Vec<[f64; 2]> = rows.map(|r| [of(r), 100.0 * r.rms]).collect();
            curves.push(Curve {
                name: with_slope(solver, &points),
                colour: MESH_METHODS.len() + i,
                is_dashed: false,
                points,
            });
        }
        Plot {
            title: format!("{}: error against {axis}", self.name),
            axes: [axis.to_owned(), "RMS error, % of the mean".to_owned()],
            curves,
        }
    }

    /// How many times the cost of the program's own mesh another way takes for the error of its finest run.
    fn ratio(&self, mesh: &str, of: Quantity) -> Option<f64> {
        let own = self.curve(MESH_METHODS[MESH_METHODS.len() - 1].name, "linear", of);
        let other = self.curve(mesh, "linear", of);
        // The finest error that both have come down to.
        let least = |c: &[[f64; 2]]| c.iter().map(|p| p[1]).fold(f64::INFINITY, f64::min);
        let error = least(&own).max(least(&other));
        Some(crossing(&other, error)? / crossing(&own, error)?)
    }
}

fn with_slope(name: &str, points: &[[f64; 2]]) -> String {
    match exponent(points) {
        Some(p) => format!("{name} (slope {p:.2})").replace('-', "\u{2212}"),
        None => name.to_owned(),
    }
}

/// A name of a scene as the name of a file.
pub(super) fn file_name(name: &str) -> String {
    let name = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() || ".-_".contains(c) {
            c
        } else {
            '-'
        }
    };
    name.chars().map(plain).collect()
}

/// Cells of a table.
type Row = Vec<String>;

fn table(html: &mut String, header: &[&str], rows: impl IntoIterator<Item = Row>) {
    html.push_str("<table><thead><tr>");
    for name in header {
        put(html, format_args!("<th>{}</th>", escaped(name)));
    }
    html.push_str("</tr></thead><tbody>\n");
    for row in rows {
        html.push_str("<tr>");
        for cell in row {
            put(html, format_args!("<td>{}</td>", escaped(&cell)));
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody></table>\n");
}

/// Writing to a string cannot fail.
fn put(text: &mut String, what: std::fmt::Arguments) {
    let _ = text.write_fmt(what);
}

const HEAD: &str = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>umbrage report</title>\n<style>
body { font: 14px/1.5 sans-serif; max-width: 1060px; margin: 24px auto; padding: 0 16px; color: #222; background: #fff; }
h1 { font-size: 22px; } h2 { font-size: 18px; border-top: 1px solid #ccc; padding-top: 16px; } h3 { font-size: 15px; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: 13px; margin: 8px 0; }
th, td { text-align: right; padding: 2px 8px; border-bottom: 1px solid #e4e4e4; } th:first-child, td:first-child { text-align: left; }
figure { display: inline-block; margin: 0 12px 8px 0; } img { max-width: 320px; } figcaption { color: #666; }
svg { max-width: 100%; height: auto; } details { margin: 8px 0; } summary { cursor: pointer; }
</style></head><body>
";

/// The page: `pictures` are PNG files with their captions for each scene.
pub fn page(report: &Report, pictures: &[Vec<(String, Vec<u8>)>]) -> String {
    let mut html = HEAD.to_owned();
    put(
        &mut html,
        format_args!(
            "<h1>umbrage {}: what it costs to be right</h1>\n<p>Errors are RMS over the lit surfaces against exact direct light and, where light between surfaces is part of it, against a solution that was asked for less than half of the finest error; relative to the mean irradiance. Times are wall clock on this machine; all other numbers are the same everywhere.</p>\n",
            env!("CARGO_PKG_VERSION")
        ),
    );
    for (i, scene) in report.scenes.iter().enumerate() {
        of_scene(&mut html, scene, pictures.get(i).map_or(&[], Vec::as_slice));
    }
    if !report.growth.is_empty() {
        of_growth(&mut html, report);
    }
    if !report.stability.is_empty() {
        of_stability(&mut html, &report.stability);
    }
    html.push_str("</body></html>\n");
    html
}

fn of_scene(html: &mut String, scene: &SceneReport, pictures: &[(String, Vec<u8>)]) {
    put(
        html,
        format_args!(
            "<h2>{}</h2>\n<p>{} faces, mean irradiance {:.4} W/m², {}.</p>\n",
            escaped(&scene.name),
            scene.faces,
            scene.mean,
            if scene.has_indirect {
                "direct and indirect light"
            } else {
                "direct light"
            }
        ),
    );
    for (caption, png) in pictures {
        put(
            html,
            format_args!(
                "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption>{0}</figcaption></figure>\n",
                escaped(caption),
                base64::encode(png)
            ),
        );
    }
    for (_, axis, of) in COSTS {
        html.push_str(&scene.plot(axis, of).svg());
    }
    html.push_str("<h3>what the lines save</h3>\n");
    let others = MESH_METHODS.iter().take(MESH_METHODS.len() - 1);
    table(
        html,
        &[
            "for the same error",
            "times the elements",
            "times the seconds",
        ],
        others.map(|m| {
            let text = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.2}"));
            let mut row = vec![m.name.to_owned()];
            row.extend(COSTS.iter().map(|c| text(scene.ratio(m.name, c.2))));
            row
        }),
    );
    let lines = scene.lines.iter();
    table(
        html,
        &["lines", "found", "in the mesh"],
        lines.map(|l| {
            vec![
                format!("D{} {}", l.order, l.kind),
                l.found.to_string(),
                l.kept.to_string(),
            ]
        }),
    );
    let left = scene.left_out.iter();
    table(
        html,
        &["left out", "why"],
        left.map(|l| vec![l.what.clone(), l.why.clone()]),
    );
    html.push_str("<h3>stages at the finest error</h3>\n<p>Memory is that of the whole process, what earlier runs left behind included.</p>\n");
    let stages = scene.stages.iter();
    table(
        html,
        &["stage", "seconds", "memory, at most"],
        stages.map(|s| {
            let memory = s.peak_bytes.map_or_else(|| "-".to_owned(), megabytes);
            vec![
                s.stage.name.to_owned(),
                format!("{:.3}", s.stage.seconds),
                memory,
            ]
        }),
    );
    html.push_str("<details><summary>all runs</summary>\n");
    of_records(html, &scene.records);
    html.push_str("</details>\n");
}

fn megabytes(bytes: u64) -> String {
    format!("{:.1} MB", bytes as f64 / 1e6)
}

fn of_records(html: &mut String, records: &[Record]) {
    let header = [
        "mesh",
        "elements show",
        "solver",
        "asked",
        "rms",
        "max",
        "elements",
        "evaluations",
        "gathers",
        "links",
        "sweeps",
        "seconds",
        "memory",
    ];
    table(
        html,
        &header,
        records.iter().map(|r| {
            let percent = |x: f64| format!("{:.2} %", 100.0 * x);
            vec![
                r.mesh.clone(),
                r.basis.clone(),
                r.solver.clone(),
                percent(r.asked),
                percent(r.rms),
                percent(r.max),
                r.work.elements.to_string(),
                r.work.evaluations.to_string(),
                r.work.gathers.to_string(),
                r.work.links.to_string(),
                r.work.sweeps.to_string(),
                format!("{:.3}", r.seconds),
                r.peak_bytes.map_or_else(|| "-".to_owned(), megabytes),
            ]
        }),
    );
}

fn of_growth(html: &mut String, report: &Report) {
    html.push_str("<h2>cost as the scene grows</h2>\n");
    html.push_str(&report.growth_plot().svg());
    let header = [
        "scene",
        "faces",
        "edges",
        "lines",
        "wedges",
        "elements",
        "evaluations",
        "rms",
        "seconds",
    ];
    table(
        html,
        &header,
        report.growth.iter().map(|r| {
            vec![
                format!("{} {}", r.family, r.n),
                r.faces.to_string(),
                r.edges.to_string(),
                r.lines.to_string(),
                r.work.wedges.to_string(),
                r.work.elements.to_string(),
                r.work.evaluations.to_string(),
                format!("{:.2} %", 100.0 * r.rms),
                format!("{:.3}", r.seconds),
            ]
        }),
    );
    let exponents = report.families().into_iter().map(|(name, rows)| {
        let of = |y: fn(&GrowthRow) -> f64| {
            let points: Vec<[f64; 2]> = rows.iter().map(|r| [r.faces as f64, y(r)]).collect();
            exponent(&points).map_or_else(|| "-".to_owned(), |p| format!("{p:.2}"))
        };
        vec![
            name.to_owned(),
            of(|r| r.lines as f64),
            of(|r| r.work.elements as f64),
            of(|r| r.work.evaluations as f64),
            of(|r| r.seconds),
        ]
    });
    table(
        html,
        &[
            "grows with the faces to the power",
            "lines",
            "elements",
            "evaluations",
            "seconds",
        ],
        exponents,
    );
}

fn of_stability(html: &mut String, rows: &[StabilityRow]) {
    html.push_str("<h2>stiff and extreme scenes</h2>\n");
    let header = [
        "case",
        "sound",
        "finite",
        "not negative",
        "balanced within",
        "asked",
        "measured",
        "against the known",
        "sweeps",
        "rounds",
        "elements",
    ];
    table(
        html,
        &header,
        rows.iter().map(|r| {
            let yes = |is: bool| if is { "yes" } else { "NO" }.to_owned();
            let percent = |x: f64| format!("{:.2} %", 100.0 * x);
            vec![
                r.name.clone(),
                yes(r.is_sound()),
                yes(r.is_finite),
                yes(r.is_positive),
                percent(r.imbalance),
                percent(r.asked),
                percent(r.measured),
                r.known.map_or_else(|| "-".to_owned(), percent),
                r.sweeps.to_string(),
                r.rounds.to_string(),
                r.elements.to_string(),
            ]
        }),
    );
}
