//! Scenes in which the estimate of the error was found to be wrong.

use super::Errors;
use crate::common::bake::{bake, surface_points};
use crate::common::fine_field::FineField;
use crate::common::library::regression_world;
use umbrage::radiosity::Bounces;

const ASKED: f64 = 0.03;

#[test]
fn small_faces_with_dark_middles_are_gathered_where_they_are_lit() {
    /// A side of a peg has less than this, m².
    const LARGEST_SMALL: f64 = 0.05;
    let world = regression_world("pegs-in-a-wall");
    let solution = bake(&world, 0.1, Bounces::All);
    let field = solution.indirect.as_ref().expect("the room reflects");
    let mut gatherer = field.gatherer();
    let (mut squares, mut light) = (0.0, 0.0);
    for p in surface_points(&solution, 6000, 3) {
        let receiver = &solution.receivers[p.receiver];
        if receiver.area() < LARGEST_SMALL {
            let f = receiver.solve_face.expect("it is lit");
            let there = field.gather(&mut gatherer, &p.view(&solution));
            squares += (field.at(f, p.plane) - there).0.mean_square();
            light += there.0.mean_square();
        }
    }
    let off = (squares / light).sqrt();
    // Small faces may be off by more than the whole; those with one dark value are off by all their light.
    assert!(off < 0.5, "{off} of the light on them");
}

#[test]
fn cells_follow_the_light_where_something_is_close() {
    let world = regression_world("lamp-under-the-ceiling");
    // One bake is off by .5 to .85 of what is asked, as it happens to be stopped.
    let asked = [0.9 * ASKED, ASKED, 1.1 * ASKED];
    let shares = asked.map(|asked| {
        let solution = bake(&world, asked, Bounces::All);
        let fine = FineField::new(&solution, 1500.0);
        Errors::measure(&solution, fine.as_ref().map(FineField::field), 4000, 7).solution / asked
    });
    let mean_square = shares.iter().map(|s| s * s).sum::<f64>() / shares.len() as f64;
    assert!(mean_square.sqrt() < 0.75, "{shares:?}");
}

#[test]
fn a_gap_between_two_boards_does_not_fill_with_light() {
    let world = regression_world("crossing-boards");
    let solution = bake(&world, ASKED, Bounces::All);
    let energy = solution.energy().expect("all bounces are followed");
    assert!(energy.is_balanced, "{energy:?}");
    let corrections = &solution.summary.corrections;
    // Where they led away from the solution, the first one was ten times the mean.
    let [first, .., last] = corrections[..] else {
        panic!("{corrections:?}");
    };
    assert!(first < 0.2 && last < 0.3 * first, "{corrections:?}");
}
