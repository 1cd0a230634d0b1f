//! The other tables of a report as CSV.

use super::convergence::SceneReport;
use super::growth::GrowthRow;
use super::record::Work;
use super::stability::StabilityRow;
use std::fmt::Write;

/// Rows of CSV under a header. Writing to a string cannot fail.
fn table<T>(header: &str, rows: &[T], write: impl Fn(&mut String, &T)) -> String {
    let mut text = format!("{header}\n");
    for row in rows {
        write(&mut text, row);
        text.push('\n');
    }
    text
}

/// Cost as the scene grows.
pub fn growth_csv(rows: &[GrowthRow]) -> String {
    let counts = Work::NAMES.join(",");
    let header = format!("family,n,faces,edges,lines,{counts},rms,seconds");
    table(&header, rows, |text, r| {
        let _ = write!(
            text,
            "{},{},{},{},{},",
            r.family, r.n, r.faces, r.edges, r.lines
        );
        for count in r.work.counts() {
            let _ = write!(text, "{count},");
        }
        let _ = write!(text, "{:.6e},{:.3}", r.rms, r.seconds);
    })
}

/// Stiff and extreme scenes.
pub fn stability_csv(rows: &[StabilityRow]) -> String {
    let header = "case,is_sound,is_finite,is_positive,is_balanced,imbalance,asked,measured,known,sweeps,rounds,elements";
    table(header, rows, |text, r| {
        let known = r.known.map(|k| format!("{k:.6e}")).unwrap_or_default();
        let _ = write!(
            text,
            "{},{},{},{},{},{:.6e},{},{:.6e},{known},{},{},{}",
            r.name,
            r.is_sound(),
            r.is_finite,
            r.is_positive,
            r.is_balanced,
            r.imbalance,
            r.asked,
            r.measured,
            r.sweeps,
            r.rounds,
            r.elements
        );
    })
}

/// Time and memory of each stage of the program's own way at the finest error.
pub fn stages_csv(scenes: &[SceneReport]) -> String {
    let rows: Vec<_> = scenes
        .iter()
        .flat_map(|s| s.stages.iter().map(move |stage| (&s.name, stage)))
        .collect();
    table(
        "scene,stage,seconds,peak_bytes",
        &rows,
        |text, (name, cost)| {
            let bytes = cost.peak_bytes.map(|b| b.to_string()).unwrap_or_default();
            let _ = write!(
                text,
                "{name},{},{:.4},{bytes}",
                cost.stage.name, cost.stage.seconds
            );
        },
    )
}
