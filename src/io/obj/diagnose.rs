//! Where in an OBJ file the mistake is that `tobj`, which counts no lines, has found.

use super::text::{Statement, statements};
use crate::bad_input::BadInput;

/// A failure of `tobj` as an error that names the line, where the line can be told.
pub(super) fn explain(text: &str, place: &str, error: tobj::LoadError) -> BadInput {
    let total = statements(text).filter(|s| s.keyword() == "v").count();
    // `tobj` also refuses a face ahead of its vertices, when an object or a material begins between the two.
    let mistake = first_mistake(text, place, total).or_else(|| first_mistake(text, place, 0));
    mistake.unwrap_or_else(|| {
        BadInput::new(
            place,
            format!("the OBJ reader stopped: {error}"),
            "write the file again from the program it comes from",
        )
    })
}

/// The error for a position that is NaN or infinite.
pub(super) fn not_finite(text: &str, place: &str) -> BadInput {
    first_mistake(text, place, usize::MAX).unwrap_or_else(|| {
        BadInput::new(
            place,
            "a vertex position is not finite",
            "remove or correct the vertex",
        )
    })
}

/// The first statement that cannot be meant so; faces may name vertices up to the `ahead`th before these are defined.
fn first_mistake(text: &str, place: &str, ahead: usize) -> Option<BadInput> {
    let mut so_far = 0;
    for statement in statements(text) {
        let at = || format!("{place}:{}", statement.number);
        match statement.keyword() {
            "v" => {
                so_far += 1;
                if let Some(what) = vertex_mistake(&statement) {
                    return Some(BadInput::new(
                        at(),
                        what,
                        "write three finite numbers after v",
                    ));
                }
            }
            "f" | "fo" => {
                if let Some(what) = face_mistake(&statement, so_far, ahead.max(so_far)) {
                    let remedy = "let each corner of a face name a vertex of the file";
                    return Some(BadInput::new(at(), what, remedy));
                }
            }
            _ => {}
        }
    }
    None
}

fn vertex_mistake(statement: &Statement<'_>) -> Option<String> {
    let mut count = 0;
    for word in statement.values().take(3) {
        match word.parse::<f64>() {
            Ok(value) if value.is_finite() => count += 1,
            Ok(value) => return Some(format!("vertex coordinate {value} is not finite")),
            Err(_) => return Some(format!("vertex coordinate \"{word}\" is not a number")),
        }
    }
    (count < 3).then(|| format!("vertex has {count} coordinates"))
}

/// What is wrong with a face that stands after `so_far` vertices, from which negative indices count back, and may name
/// `known` of them.
fn face_mistake(statement: &Statement<'_>, so_far: usize, known: usize) -> Option<String> {
    for corner in statement.values() {
        let word = corner.split('/').next().unwrap_or(corner);
        let Ok(index) = word.parse::<i128>() else {
            return Some(format!("face corner \"{corner}\" is not an index"));
        };
        let vertices = if index < 0 { so_far } else { known };
        if index == 0 || index.unsigned_abs() > vertices as u128 {
            return Some(format!(
                "face corner {index} is out of range ({vertices} vertices)"
            ));
        }
        if corner
            .split('/')
            .skip(1)
            .any(|w| !w.is_empty() && w.parse::<isize>().is_err())
            || corner.split('/').count() > 3
        {
            return Some(format!(
                "face corner \"{corner}\" is not v, v/vt, v//vn or v/vt/vn"
            ));
        }
    }
    None
}
