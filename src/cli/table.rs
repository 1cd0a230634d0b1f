//! The summary of a run as a table for people.

use super::options;
use std::fmt::Write;
use umbrage::budget::peak_bytes;
use umbrage::pipeline::{Energy, Solution, Summary, World};
use umbrage::radiosity::SolveReport;
use umbrage::render::LightUnit;
use umbrage::report::LightStatistics;
use umbrage::scene::{CleanReport, FaceSide};

/// Everything worth knowing about a run in some fifteen lines.
pub(super) fn summary_table(world: &World, s: &Summary) -> String {
    let c = &s.clean;
    let mut rows = Rows::default();
    rows.add("scene", &world.scene.source);
    rows.add(
        "input",
        format!(
            "{}, {} m across",
            count(c.polygons, "polygon"),
            significant(world.scene.diagonal)
        ),
    );
    rows.add(
        "repaired",
        repairs(c).unwrap_or_else(|| "nothing".to_owned()),
    );
    rows.add(
        "surfaces",
        format!(
            "{}, {}, {}; {} emitting{}; light reaches {} of {} sides, {} m²",
            count(c.faces, "face"),
            count(c.edges, "edge"),
            if c.vertices == 1 {
                "1 vertex".to_owned()
            } else {
                format!("{} vertices", c.vertices)
            },
            count(c.emitters, "side"),
            match c.lights {
                0 => String::new(),
                n => format!(", {}", count(n, "light")),
            },
            s.lit_sides,
            s.sides,
            significant(s.lit_area_m2)
        ),
    );
    let kept: usize = s.line_counts.iter().map(|l| l.kept).sum();
    let found: usize = s.line_counts.iter().map(|l| l.found).sum();
    rows.add("lines", format!("{found} found, {kept} kept"));
    for l in &s.line_counts {
        rows.add(
            "",
            format!(
                "D{} {:<8}{:>7} found {:>7} kept",
                l.order, l.kind, l.found, l.kept
            ),
        );
    }
    rows.add(
        "mesh",
        format!(
            "{}, {}",
            count(s.elements, "element"),
            count(s.sites, "value")
        ),
    );
    if s.solve.nodes > 0 {
        rows.add(
            "indirect",
            format!(
                "{}, {}, {}, {}",
                count(s.solve.elements, "element"),
                count(s.solve.nodes, "unknown"),
                count(s.solve.links, "link"),
                steps(&s.solve)
            ),
        );
        rows.add("solver", format!("{}: {}", s.solve.method, s.solve.reason));
    }
    let m = &s.measured;
    rows.add(
        "error",
        format!(
            "asked {}, estimated {}, measured {} rms and {} max ({}, mean {} W/m²)",
            percent(s.error_asked),
            percent(s.error_estimated),
            percent(m.relative_rms),
            percent(m.relative_max),
            count(m.samples as usize, "point"),
            significant(m.mean)
        ),
    );
    if let Some(e) = &s.error_at_vertices {
        rows.add(
            "at vertices",
            format!(
                "estimated {} rms and {} max: solution {}, indirect field {}, display mesh {}",
                percent(e.relative_rms),
                percent(e.relative_max),
                percent(e.relative_rms_solution),
                percent(e.relative_rms_field),
                percent(e.relative_rms_mesh)
            ),
        );
    }
    if let Some(energy) = &s.energy {
        rows.add("energy", balance(energy));
    }
    let total: f64 = s.stages.iter().map(|t| t.seconds).sum();
    let stages: Vec<String> = s
        .stages
        .iter()
        .map(|t| format!("{} {:.2}", t.name, t.seconds))
        .collect();
    rows.add("time", format!("{total:.2} s: {}", stages.join(", ")));
    if let Some(bytes) = peak_bytes() {
        let most = options::size(bytes);
        let stages: Vec<String> = s
            .stages
            .iter()
            .filter_map(|t| Some((t.name, t.peak_memory_bytes?)))
            .map(|(name, bytes)| format!("{name} {:.0}", bytes as f64 / 1e6))
            .collect();
        rows.add(
            "memory",
            format!(
                "{most} at most; MB by the end of each: {}",
                stages.join(", ")
            ),
        );
    }
    for l in &s.left_out {
        rows.add("left out", format!("{}: {}", l.what, l.why));
    }
    rows.add("warnings", s.warnings.len().to_string());
    rows.text
}

fn steps(s: &SolveReport) -> String {
    match s.shots {
        0 => count(s.residuals.len(), "step"),
        shots => count(shots, "shot"),
    }
}

/// Power by where it goes, mean of the channels.
fn balance(energy: &Energy) -> String {
    let watts = |w: [f64; 3]| significant(w.iter().sum::<f64>() / 3.0);
    let mut text = format!(
        "{} W emitted, {} absorbed, {} escaped",
        watts(energy.emitted_w),
        watts(energy.absorbed_w),
        watts(energy.escaped_w)
    );
    if energy.unfollowed_w.iter().any(|&w| w > 0.0) {
        let _ = write!(text, ", {} not followed", watts(energy.unfollowed_w));
    }
    let word = if energy.is_balanced {
        ""
    } else {
        ": more than the error asked for"
    };
    let _ = write!(text, "; off by {}{word}", percent(energy.imbalance.abs()));
    text
}

#[derive(Default)]
struct Rows {
    text: String,
}

impl Rows {
    fn add(&mut self, name: &str, value: impl AsRef<str>) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.text, "{name:<13}{}", value.as_ref());
    }
}

fn repairs(c: &CleanReport) -> Option<String> {
    let all = [
        (c.welded, "positions welded"),
        (c.degenerate, "degenerate polygons dropped"),
        (c.duplicates + c.duplicate_faces, "duplicates dropped"),
        (c.self_crossing, "self-crossing polygons dropped"),
        (c.bent, "bent polygons cut"),
        (c.t_junctions, "vertices inserted into edges"),
        (c.straightened, "vertices removed from straight edges"),
        (c.unmerged, "overlapping coplanar sets left"),
    ];
    let some: Vec<String> = all
        .iter()
        .filter(|(n, _)| *n > 0)
        .map(|(n, what)| format!("{what}: {n}"))
        .collect();
    (!some.is_empty()).then(|| some.join(", "))
}

/// `1 edge`, `2 edges`.
fn count(n: usize, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}

/// Two decimals of a per cent.
pub(super) fn percent(share: f64) -> String {
    format!("{:.2} %", 100.0 * share)
}

/// Four significant digits.
fn significant(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let magnitude = x.abs().log10().floor() as i32;
    if (-4..7).contains(&magnitude) {
        format!("{x:.*}", (3 - magnitude).max(0) as usize)
    } else {
        format!("{x:.3e}")
    }
}

/// Light on receiver number `only`, or on every lit side.
pub(super) fn statistics_table(
    solution: &Solution,
    only: Option<usize>,
    unit: LightUnit,
) -> String {
    let mut rows = Rows::default();
    let scene = &solution.world.scene;
    let name = match unit {
        LightUnit::WattsPerSquareMetre => "W/m², mean of the channels".to_owned(),
        LightUnit::Lux { efficacy } => format!("lx, at {efficacy} lm/W of white"),
    };
    let _ = writeln!(
        rows.text,
        "light        {name}\n  face side          min       mean        max  min/mean    area m²  object"
    );
    for (i, r) in solution.receivers.iter().enumerate() {
        if only.is_some_and(|o| o != i) || r.mesh.elements.is_empty() {
            continue;
        }
        let face = r.domain.face;
        let found = LightStatistics::of_receiver(r, unit);
        let _ = writeln!(
            rows.text,
            "{:>6} {:<6} {:>10} {:>10} {:>10} {:>9.3} {:>10}  {}",
            face.0,
            side_name(r.domain.side),
            significant(found.min),
            significant(found.mean),
            significant(found.max),
            found.uniformity(),
            significant(r.area()),
            scene.groups[scene.faces[face].group as usize],
        );
    }
    rows.text
}

/// Light at the points of a grid, as [`statistics_table`] says it of faces.
pub(super) fn points_line(found: &LightStatistics, points: usize, unit: &str) -> String {
    format!(
        "light        {}: min {}, mean {}, max {} {unit}, min/mean {:.3}\n",
        count(points, "point"),
        significant(found.min),
        significant(found.mean),
        significant(found.max),
        found.uniformity(),
    )
}

fn side_name(side: FaceSide) -> &'static str {
    match side {
        FaceSide::Front => "front",
        FaceSide::Back => "back",
    }
}

/// Every lit side with its number, which `--face` takes.
pub(super) fn faces_table(solution: &Solution) -> String {
    let mut rows = Rows::default();
    let scene = &solution.world.scene;
    let _ = writeln!(
        rows.text,
        "\n  face side   elements  found   kept    area m²  object, material"
    );
    for r in &solution.receivers {
        let (id, lines) = (r.domain.face, &r.lines);
        let face = &scene.faces[id];
        let _ = writeln!(
            rows.text,
            "{:>6} {:<6} {:>8} {:>6} {:>6} {:>10}  {}, {}{}",
            id.0,
            side_name(r.domain.side),
            r.mesh.elements.len(),
            lines.contacts.len() + lines.candidates.len(),
            lines.contacts.len() + r.kept().count(),
            significant(face.area),
            scene.groups[face.group as usize],
            scene.material_of(id).name,
            if r.is_lit {
                ""
            } else {
                " (no light reaches it)"
            },
        );
    }
    rows.text
}
