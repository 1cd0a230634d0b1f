//! Discontinuity lines as CSV.

use crate::discontinuity::Cause;
use crate::pipeline::{LineRecord, kind_name, order_number};
use std::fmt::Write;

/// Columns of [`lines_csv`].
const HEADER: &str = "face,order,kind,x0,y0,z0,x1,y1,z1,jump,emitter,cause";

/// The lines that the meshes hold, one a row: ends in metres (world, y up), jump in W/m² (measured; of contact lines
/// predicted), emitter by number (empty without one), cause as in [`cause_name`].
pub fn lines_csv(lines: &[LineRecord]) -> String {
    let mut text = format!("{HEADER}\n");
    for line in lines.iter().filter(|line| line.is_kept) {
        text.push_str(&row(line));
        text.push('\n');
    }
    text
}

/// All lines, with a last column `kept`: 1 for those of [`lines_csv`], 0 for the others, whose jump is predicted.
pub fn candidates_csv(lines: &[LineRecord]) -> String {
    let mut text = format!("{HEADER},kept\n");
    for line in lines {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{},{}", row(line), u8::from(line.is_kept));
    }
    text
}

fn row(line: &LineRecord) -> String {
    let [a, b] = line.ends;
    format!(
        "{},{},{},{},{},{},{},{},{},{},{},{}",
        line.face,
        order_number(line.order),
        kind_name(line.kind),
        a.x,
        a.y,
        a.z,
        b.x,
        b.y,
        b.z,
        line.jump,
        line.emitter.map(|e| e.to_string()).unwrap_or_default(),
        cause_name(&line.cause)
    )
}

/// What made a line: `v12/e34` a vertex of the emitter, or of another blocker, past a blocker's edge, `e(3-4)/v7` an
/// emitter's edge past a blocker's vertex, `light0/e17` a light without a surface past a blocker's edge, `light0` the rim of a
/// spot's cone, `e3/e5/e8` three edges on one sight line, `face 5` the face that touches, `plane` the emitter's own plane. Numbers are those of the cleaned scene.
pub fn cause_name(cause: &Cause) -> String {
    match cause {
        Cause::VertexEdge(v, e) => format!("v{v}/e{e}"),
        Cause::EdgeVertex([a, b], v) => format!("e({a}-{b})/v{v}"),
        Cause::Edges([a, b, c]) => format!("e{a}/e{b}/e{c}"),
        Cause::Face(f) => format!("face {f}"),
        Cause::EmitterPlane => "plane".to_owned(),
        Cause::LightEdge(light, e) => format!("light{light}/e{e}"),
        Cause::Cone(light) => format!("light{light}"),
    }
}
