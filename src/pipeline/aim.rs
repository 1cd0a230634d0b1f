//! What each part of a bake may be off by so that the whole is as good as asked.

use super::Measured;
use super::evidence::Expected;
use super::stages::Mesher;

/// Shares of the permitted error that interpolation over the display mesh and the indirect field may use; errors add in
/// squares, and the rest is left to the solution and to what the estimates miss. With more to the display mesh, .8 and .45, or .7
/// and .5 of it, four rooms took 1.1 to 1.5 times as long for the same error: gathers are dear.
const DISPLAY_SHARE: f64 = 0.6;
const FIELD_SHARE: f64 = 0.6;

/// Share of the display mesh where there is no indirect light: the rest covers what the samples of the estimate miss.
const DIRECT_SHARE: f64 = 0.9;

/// Share of the error asked for that is aimed at once it has been missed.
const AIM_AGAIN: f64 = 0.9;

/// A part is asked for no less than this share of what it is: half in squares. A bright spot or two may have made it so much.
const LEAST_STEP: f64 = 0.7;

/// A field that is off by more than this share of the error asked for makes the whole miss it, with what the display mesh is off by.
const PROBED_MOST: f64 = 0.9;

/// What it is to be off by then.
const PROBED_AIM: f64 = 0.7;

/// What the parts of a bake may be off by, as shares of the error asked for.
pub(super) struct Aim {
    pub(super) mesher: Mesher,
    /// Interpolation over the display mesh, and the most that it may be found to be off by.
    pub(super) display: f64,
    pub(super) most_display: f64,
    /// The indirect field, and the most that it may be found to be off by.
    pub(super) field: f64,
    pub(super) most_field: f64,
    /// What the weakest emitters at a point may together be off by, W/m².
    pub(super) weak: f64,
}

impl Aim {
    /// For a scene that has indirect light or none.
    pub(super) fn new(mesher: Mesher, is_lit_indirectly: bool, weak: f64) -> Self {
        // Alone the mesh may use it all: what the estimate missed has been measured then.
        let (display, most_display) = match is_lit_indirectly {
            true => (DISPLAY_SHARE, DISPLAY_SHARE),
            false => (DIRECT_SHARE, 1.0),
        };
        Self {
            mesher,
            display,
            most_display,
            field: FIELD_SHARE,
            most_field: FIELD_SHARE,
            weak,
        }
    }

    /// Whether the field, off by `found` of the mean before anything shows it, would make the whole miss its error.
    pub(super) fn is_field_missed(&self, error: f64, found: f64) -> bool {
        found > PROBED_MOST * error
    }

    /// Asks for as much more of it as that is too large; by now it is `expected` to be what it is.
    pub(super) fn ask_more_of_field(&mut self, error: f64, found: f64, expected: f64) {
        let step = (PROBED_AIM * error / found).max(LEAST_STEP);
        self.field = step * expected / error;
    }

    /// Asks for as much more as the measured error is too large, of the parts that were found to be off by more than their share:
    /// of each in proportion to that. The estimates then fall as the errors have to; they are `expected` to be what they are by now.
    pub(super) fn ask_more(&mut self, error: f64, measured: &Measured, expected: Expected) {
        let found = [measured.relative_rms_mesh, measured.relative_rms_field];
        let allowed = [self.most_display, self.most_field].map(|share| share * error);
        let excess = [0, 1].map(|i| (found[i].powi(2) - allowed[i].powi(2)).max(0.0));
        let over = measured.relative_rms.powi(2) - (AIM_AGAIN * error).powi(2);
        let all = excess[0] + excess[1];
        let more = |i: usize, share: f64, expected: f64| {
            let expected = expected / error;
            if excess[i] > 0.0 {
                let left = 1.0 - excess[i] * (over / all).min(1.0) / found[i].powi(2);
                expected * left.sqrt().max(LEAST_STEP)
            } else if all > 0.0 {
                // It is good enough, whatever is expected of it.
                share.max(expected)
            } else {
                // What is off without being in either part is not known from here: a little less of both.
                share * AIM_AGAIN
            }
        };
        let display = more(0, self.display, expected.mesh);
        (self.display, self.field) = (display, more(1, self.field, expected.field));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adapt::Meshing;

    const ERROR: f64 = 0.01;

    /// What shares are computed to.
    const ROUND_OFF: f64 = 1e-12;

    fn aim() -> Aim {
        let meshing = Meshing::Adaptive;
        let mesher = Mesher {
            meshing,
            spacing: 1.0,
            limit: None,
        };
        Aim {
            display: 0.6,
            most_display: 0.8,
            field: 0.3,
            most_field: 0.4,
            ..Aim::new(mesher, false, 0.0)
        }
    }

    /// The shares of the display mesh and of the field once those were found to be off by so much, and both estimates were right.
    fn shares(mesh: f64, field: f64) -> [f64; 2] {
        let measured = Measured {
            relative_rms: mesh.hypot(field),
            relative_rms_mesh: mesh,
            relative_rms_field: field,
            ..Measured::default()
        };
        let mut aim = aim();
        aim.ask_more(ERROR, &measured, Expected { mesh, field });
        [aim.display, aim.field]
    }

    #[test]
    fn a_field_that_would_miss_it_alone_is_asked_for_what_the_rest_leaves() {
        let mut aim = aim();
        assert!(!aim.is_field_missed(ERROR, 0.85 * ERROR));
        assert!(aim.is_field_missed(ERROR, 0.95 * ERROR));
        // The estimate, which says half of what was found, has to fall as that has to.
        aim.ask_more_of_field(ERROR, 0.9 * ERROR, 0.45 * ERROR);
        assert!((aim.field - 0.35).abs() < ROUND_OFF, "{}", aim.field);
        aim.ask_more_of_field(ERROR, 10.0 * ERROR, 2.0 * ERROR);
        assert!((aim.field - 2.0 * LEAST_STEP).abs() < ROUND_OFF);
    }

    #[test]
    fn only_the_part_that_is_too_large_is_asked_for_less_and_the_whole_is_met_then() {
        let [display, field] = shares(0.011, 0.002);
        // What is good enough is not refined.
        assert_eq!(field, 0.3);
        let whole = (ERROR * display).hypot(0.002);
        assert!((whole - AIM_AGAIN * ERROR).abs() < ROUND_OFF, "{whole}");
        let [display, field] = shares(0.005, 0.0105);
        assert_eq!(display, 0.6);
        let whole = (ERROR * field).hypot(0.005);
        assert!((whole - AIM_AGAIN * ERROR).abs() < ROUND_OFF, "{whole}");
    }

    #[test]
    fn of_two_parts_each_is_asked_for_less_by_as_much_as_it_is_too_large() {
        let [display, field] = shares(0.011, 0.005);
        let excess = |found: f64, share: f64, now: f64| {
            (found.powi(2) - (now * ERROR).powi(2)) / (found.powi(2) - (share * ERROR).powi(2))
        };
        let [mesh, field] = [excess(0.011, 0.8, display), excess(0.005, 0.4, field)];
        assert!((mesh - field).abs() < 1e3 * ROUND_OFF, "{mesh} {field}");
    }

    #[test]
    fn no_step_is_too_large_and_what_is_in_neither_part_makes_both_a_little_less() {
        let [display, _] = shares(0.1, 0.002);
        assert!(
            (display - LEAST_STEP * 0.1 / ERROR).abs() < ROUND_OFF,
            "{display}"
        );
        let measured = Measured {
            relative_rms: 0.0107,
            relative_rms_mesh: 0.0079,
            relative_rms_field: 0.0039,
            ..Measured::default()
        };
        let mut aim = aim();
        let expected = Expected {
            mesh: 0.006,
            field: 0.003,
        };
        aim.ask_more(ERROR, &measured, expected);
        assert_eq!([aim.display, aim.field], [0.6, 0.3].map(|s| s * AIM_AGAIN));
    }
}
