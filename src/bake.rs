//! The whole way in one call.

use crate::lit_scene::LitScene;
use crate::pipeline::{LightError, Summary, World, light};
use crate::scene::RawScene;
use crate::settings::Settings;
use crate::warning::Warning;

/// A lit scene, and how it came about.
#[derive(Clone, Debug)]
pub struct Baked {
    /// Meshes with light at their vertices, ready for [`write_glb`](crate::io::write_glb).
    pub scene: LitScene,
    /// Counts, times (seconds) and errors; `summary.measured` holds the error found at random points.
    pub summary: Summary,
    /// What the reader and the clean-up repaired or left out.
    pub warnings: Vec<Warning>,
}

/// Cleans and lights `raw` to the error that `settings` ask for.
///
/// The same scene and settings give the same result on any number of threads. Whoever wants progress, or to ask for the
/// light at points afterwards, takes the steps singly: [`World::new`] and [`light`].
///
/// # Errors
/// [`LightError::Input`] when the scene cannot be used: the message names the place and a remedy. [`LightError::Mesh`] is
/// a fault of our own.
///
/// # Example
/// ```no_run
/// use std::path::Path;
/// use umbrage::io::{ReadSettings, read_scene, write_atomically, write_glb};
/// use umbrage::settings::Settings;
///
/// let raw = read_scene(Path::new("room.glb"), &ReadSettings::default())?;
/// let baked = umbrage::bake(&raw, &Settings { error: 0.02, ..Settings::default() })?;
/// println!("{:.2} % off", 100.0 * baked.summary.measured.relative_rms);
/// write_atomically(Path::new("room.lit.glb"), &write_glb(&baked.scene))?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn bake(raw: &RawScene, settings: &Settings) -> Result<Baked, LightError> {
    let world = World::new(raw, settings)?;
    let solution = light(&world, settings, &mut |_| {})?;
    Ok(Baked {
        scene: solution.lit_scene(),
        summary: solution.summary.clone(),
        warnings: world.warnings.clone(),
    })
}
