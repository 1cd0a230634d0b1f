//! How cost grows with the scene.

use super::record::Work;
use super::scenes::{blinds, city};
use crate::pipeline::{LightError, World, light};
use crate::radiosity::Bounces;
use crate::scene::RawScene;
use crate::settings::Settings;

/// A family of scenes that grow: its name, how one is made, and the sizes that are lit.
type Family = (&'static str, fn(usize) -> RawScene, [usize; 4]);

const FAMILIES: [Family; 2] = [
    ("blinds", blinds, [4, 8, 16, 32]),
    ("city", city, [2, 3, 5, 8]),
];

/// Error asked for: coarse, since it is the scene that grows.
const ERROR: f64 = 0.05;

/// One scene of a family: what it is, and what it costs.
#[derive(Clone, Debug)]
pub struct GrowthRow {
    /// Name of the family.
    pub family: &'static str,
    /// Slats, or boxes along a side.
    pub n: usize,
    /// Faces, edges.
    pub faces: usize,
    /// Edges.
    pub edges: usize,
    /// Lines found.
    pub lines: usize,
    /// Counted work.
    pub work: Work,
    /// Wall clock without the measuring, seconds.
    pub seconds: f64,
    /// Error measured.
    pub rms: f64,
}

/// Lights every scene of every family, direct light alone.
///
/// # Errors
/// A fault of our own: the scenes are the report's.
pub fn growth(tell: &mut dyn FnMut(&str)) -> Result<Vec<GrowthRow>, LightError> {
    let settings = Settings {
        error: ERROR,
        bounces: Bounces::Count(0),
        ..Settings::default()
    };
    let mut rows = Vec::new();
    for (family, make, sizes) in FAMILIES {
        for n in sizes {
            tell(&format!("growth: {family} {n}"));
            let world = World::new(&make(n), &settings)?;
            let s = light(&world, &settings, &mut |_| {})?.summary;
            let stages = s.stages.iter().filter(|t| t.name != "measure");
            rows.push(GrowthRow {
                family,
                n,
                faces: s.clean.faces,
                edges: s.clean.edges,
                lines: s.lines.lines,
                work: Work::of(&s),
                seconds: stages.map(|t| t.seconds).sum(),
                rms: s.measured.relative_rms,
            });
        }
    }
    Ok(rows)
}
