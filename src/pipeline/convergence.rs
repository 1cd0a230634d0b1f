//! What elements buy: one scene lit at a series of errors, by meshes that follow its lines and by others.

use super::{LightError, World, light};
use crate::adapt::Meshing;
use crate::settings::Settings;
use std::fmt::Write;
use std::time::Instant;

/// One bake.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvergenceRow {
    /// Name of the scene.
    pub scene: String,
    /// What its meshes followed.
    pub meshing: Meshing,
    /// Relative RMS error asked for.
    pub error_asked: f64,
    /// Display elements.
    pub elements: usize,
    /// Relative RMS error measured.
    pub error_measured: f64,
    /// Wall-clock time of the bake.
    pub seconds: f64,
}

/// The name of a kind of mesh in tables.
pub fn meshing_name(meshing: Meshing) -> &'static str {
    match meshing {
        Meshing::Discontinuity => "discontinuity",
        Meshing::Adaptive => "adaptive",
        Meshing::Uniform => "uniform",
    }
}

/// Lights `world` with each of `meshings` to each of `errors`, the largest first, other settings as given. A series ends where
/// no finer mesh is to be had.
///
/// # Errors
/// As for [`light`].
pub fn convergence(
    world: &World,
    scene: &str,
    meshings: &[Meshing],
    errors: &[f64],
    settings: &Settings,
) -> Result<Vec<ConvergenceRow>, LightError> {
    let mut rows = Vec::new();
    for &meshing in meshings {
        for &error in errors {
            let settings = Settings {
                error,
                meshing,
                ..settings.clone()
            };
            let start = Instant::now();
            let solution = light(world, &settings, &mut |_| {})?;
            let (elements, measured) = (solution.summary.elements, solution.summary.measured);
            // A uniform mesh that was cut off does not get better by asking for more.
            let is_same = |r: &ConvergenceRow| r.meshing == meshing && r.elements == elements;
            if measured.relative_rms > error && rows.last().is_some_and(is_same) {
                break;
            }
            rows.push(ConvergenceRow {
                scene: scene.to_owned(),
                meshing,
                error_asked: error,
                elements,
                error_measured: measured.relative_rms,
                seconds: start.elapsed().as_secs_f64(),
            });
        }
    }
    Ok(rows)
}

/// The rows as CSV: `scene,meshing,error_asked,elements,error_measured,seconds`.
pub fn convergence_csv(rows: &[ConvergenceRow]) -> String {
    let mut text = "scene,meshing,error_asked,elements,error_measured,seconds\n".to_owned();
    for r in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{},{},{},{},{},{:.4}",
            r.scene,
            meshing_name(r.meshing),
            r.error_asked,
            r.elements,
            r.error_measured,
            r.seconds
        );
    }
    text
}

/// The power of the number of elements that the measured error falls with, by least squares over the logarithms: −1 where
/// twice the elements halve the error. None without two rows that differ.
pub fn convergence_slope<'r>(rows: impl Iterator<Item = &'r ConvergenceRow>) -> Option<f64> {
    let points: Vec<(f64, f64)> = rows
        .filter(|r| r.error_measured > 0.0)
        .map(|r| ((r.elements as f64).ln(), r.error_measured.ln()))
        .collect();
    let count = points.len() as f64;
    let (x, y) = points
        .iter()
        .fold((0.0, 0.0), |(x, y), p| (x + p.0 / count, y + p.1 / count));
    let (mut xx, mut xy) = (0.0, 0.0);
    for p in &points {
        xx += (p.0 - x).powi(2);
        xy += (p.0 - x) * (p.1 - y);
    }
    (xx > 0.0).then(|| xy / xx)
}
