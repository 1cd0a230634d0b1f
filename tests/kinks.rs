//! The lines that the search finds, held against the breaks that the direct light really has.
//!
//! Recall: breaks found numerically along random lines lie on a line of the search. Precision: across a line of the
//! search there is a break.

mod precision;
mod random;
mod recall;

use umbrage::direct::DirectLight;
use umbrage::discontinuity::{LineMap, LineTolerance, find_lines};
use umbrage::pipeline::World;

/// The lines of a world.
fn search(world: &World) -> LineMap {
    let light = DirectLight::new(&world.scene, &world.blockers);
    find_lines(&world.scene, &light, LineTolerance::default())
}
