//! The lines that the search finds, held against the breaks that the direct light really has.
//!
//! Recall: breaks found numerically along random lines lie on a line of the search. Precision: across a line of the
//! search there is a break.

mod precision;
mod random;
mod recall;

use umbrage::direct::DirectLight;
use umbrage::discontinuity::{LineMap, LineTolerance, check_outlines, find_lines};
use umbrage::pipeline::World;
use umbrage::scene::Scene;

/// The lines of a world.
fn search(world: &World) -> LineMap {
    let light = DirectLight::new(&world.scene, &world.blockers);
    find_lines(&world.scene, &light, LineTolerance::default())
}

/// Compares the outlines of the emitters at `pairs` pairs of neighbouring points: every change has its line.
fn check_no_line_is_missed(
    name: &str,
    scene: &Scene,
    light: &DirectLight,
    lines: &LineMap,
    pairs: usize,
) {
    let outlines = check_outlines(scene, light, lines, LineTolerance::default(), pairs);
    assert!(
        outlines.changed > 0 && outlines.missed == 0,
        "{name}: {outlines:?}"
    );
}
