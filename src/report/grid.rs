//! Grids of measuring points on faces.

use crate::bad_input::BadInput;
use crate::scene::{FaceId, FaceSide, Scene};
use glam::{DVec2, DVec3};

/// Points a metre or two apart are a room; more than this would be a mistake of the unit.
const MAX_POINTS: f64 = 1e7;

/// The measuring points of one side of a face.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceGrid {
    /// World coordinates, metres; row after row.
    pub points: Vec<DVec3>,
    /// Unit normal of the side.
    pub normal: DVec3,
    /// Distance between points along the rows and across them, metres: at most the one asked for.
    pub spacing: [f64; 2],
}

/// Spacing of a grid over a rectangle, metres: `p = 0.2 · 5^log₁₀(d)`, at most 10 m, where `d` is the longer side, or the
/// shorter one if the rectangle is twice as long or more (EN 12464-1, §4.4).
pub fn standard_spacing(sides: DVec2) -> f64 {
    let (short, long) = (sides.min_element(), sides.max_element());
    let d = if long >= 2.0 * short { short } else { long };
    (0.2 * 5.0_f64.powf(d.log10())).min(10.0)
}

/// Points on `face`, `spacing` metres apart or the standard's distance, `height` metres above it.
///
/// The grid follows the longest edge of the face; points are the middles of equal cells of the box around the face, as far
/// as they lie inside the face.
///
/// # Errors
/// When no point or too many would lie on the face.
pub fn face_grid(
    scene: &Scene,
    face: FaceId,
    side: FaceSide,
    spacing: Option<f64>,
    height: f64,
) -> Result<FaceGrid, BadInput> {
    let f = &scene.faces[face];
    let axis = longest_edge(scene, face);
    let turn = |p: DVec2| DVec2::new(p.dot(axis), axis.perp_dot(p));
    let corners = f.loops[0].iter();
    let corners = corners.map(|&v| turn(f.frame.to_plane(scene.vertices[v])));
    let (low, high) = corners.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
        (low.min(p), high.max(p))
    });
    let sides = high - low;
    let asked = spacing.unwrap_or_else(|| standard_spacing(sides));
    let counts = (sides / asked).ceil().max(DVec2::ONE);
    if counts.x * counts.y > MAX_POINTS {
        return Err(BadInput::new(
            "--spacing",
            format!(
                "{asked} m over face {face} are {} points",
                counts.x * counts.y
            ),
            format!("at most {MAX_POINTS} are measured: ask for a wider spacing"),
        ));
    }
    let cell = sides / counts;
    let normal = scene.normal(face, side);
    let mut points = Vec::new();
    for row in 0..counts.y as u32 {
        for column in 0..counts.x as u32 {
            let at = DVec2::new(f64::from(column), f64::from(row)) + 0.5;
            let q = low + cell * at;
            let p = axis * q.x + axis.perp() * q.y;
            if f.outline.contains(p) {
                points.push(scene.origin + f.frame.to_space(p) + normal * height);
            }
        }
    }
    if points.is_empty() {
        return Err(BadInput::new(
            "--spacing",
            format!("no point of a grid of {asked} m lies on face {face}"),
            "ask for a narrower spacing",
        ));
    }
    Ok(FaceGrid {
        points,
        normal,
        spacing: cell.to_array(),
    })
}

fn longest_edge(scene: &Scene, face: FaceId) -> DVec2 {
    let f = &scene.faces[face];
    let points = &f.loops[0];
    let at = |i: usize| f.frame.to_plane(scene.vertices[points[i % points.len()]]);
    let edges = (0..points.len()).map(|i| at(i + 1) - at(i));
    let longest = edges.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    longest.unwrap_or(DVec2::X).normalize_or(DVec2::X)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;
    use crate::io::builtin::cornell_box;
    use crate::scene::{CleanSettings, clean};

    #[test]
    fn the_standard_gives_the_spacings_of_its_own_table() {
        // EN 12464-1, table 1: 1 m → 0.2 m, 5 m → 0.6 m, 10 m → 1 m, 50 m → 3 m, 100 m → 5 m.
        for (d, p) in [
            (1.0, 0.2),
            (5.0, 0.6),
            (10.0, 1.0),
            (50.0, 3.0),
            (100.0, 5.0),
        ] {
            let found = standard_spacing(DVec2::new(d, 0.8 * d));
            assert!((found - p).abs() < 0.1 * p, "{d} m: {found}");
        }
        // A corridor is measured by its width.
        let corridor = standard_spacing(DVec2::new(20.0, 1.0));
        assert!((corridor - 0.2).abs() < 1e-12);
    }

    #[test]
    fn points_lie_on_the_face_in_even_rows() {
        let (scene, _, _) = clean(&cornell_box(), &CleanSettings::default()).unwrap();
        let floor = FaceId(0);
        let grid = face_grid(&scene, floor, FaceSide::Front, Some(0.1), 0.25).unwrap();
        assert!(grid.normal.distance(DVec3::Y) < 1e-15);
        // 0.5528 × 0.5592 m: six rows of six.
        assert!(
            grid.points.len() >= 35 && grid.points.len() <= 36,
            "{}",
            grid.points.len()
        );
        for p in &grid.points {
            assert!((p.y - 0.25).abs() < 1e-12 && p.x > 0.0 && p.x < 0.5528);
        }
        assert!(face_grid(&scene, floor, FaceSide::Front, Some(1e-6), 0.0).is_err());
    }
}
