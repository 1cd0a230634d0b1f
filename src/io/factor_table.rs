//! Form factors as CSV.

use crate::form_factor::FormFactors;
use crate::scene::FaceSide;
use std::fmt::Write;

/// One row for each pair of sides that see each other: the face and side that send, those that receive, the share of the
/// light that arrives (0…1) and how far it may be off. A last row for each sender, with nothing under `to`, holds its sum:
/// 1 where no light escapes.
pub fn form_factors_csv(factors: &FormFactors) -> String {
    let mut text = String::from("from,from_side,to,to_side,form_factor,error\n");
    let name = |i: usize| {
        let (face, side) = factors.sides[i];
        let side = match side {
            FaceSide::Front => "front",
            FaceSide::Back => "back",
        };
        format!("{face},{side}")
    };
    let count = factors.sides.len();
    for i in 0..count {
        let from = name(i);
        for j in 0..count {
            let f = factors.get(i, j);
            if f.value > 0.0 {
                // Writing to a string cannot fail.
                let _ = writeln!(text, "{from},{},{},{:.3e}", name(j), f.value, f.error);
            }
        }
        let sum = factors.row_sum(i);
        let _ = writeln!(text, "{from},,,{},{:.3e}", sum.value, sum.error);
    }
    text
}
