//! Points closer than the weld distance become one vertex.

use super::piece::Positions;
use crate::scene::VertexId;
use glam::{DVec3, I64Vec3};
use std::collections::HashMap;

/// Cell size of the search grid in weld distances: at 2 a point's neighbourhood straddles up to eight cells each time, at
/// this size mostly one, while a cell still holds few vertices (rooms are a million weld distances across).
const CELL_OVER_WELD_DISTANCE: f64 = 32.0;

/// The vertices, and for each point the vertex that it became.
pub(super) struct Welded {
    /// Vertices: each is the position of the first point that made it.
    pub(super) vertices: Positions,
    /// Vertex of each point.
    pub(super) vertex_of: Vec<VertexId>,
}

/// Welds each point to the first vertex within `weld_distance`, or makes it a vertex.
///
/// Points join vertices, never other joined points, so a chain of close points cannot drift, and what remains lies
/// farther apart than the weld distance, exactly.
pub(super) fn weld(points: &[DVec3], weld_distance: f64) -> Welded {
    let cell_size = CELL_OVER_WELD_DISTANCE * weld_distance;
    let cell = |p: DVec3| (p / cell_size).floor().as_i64vec3();
    let mut vertices = Positions::default();
    let mut grid: HashMap<I64Vec3, Vec<VertexId>> = HashMap::with_capacity(points.len());
    let mut vertex_of = Vec::with_capacity(points.len());
    let reach = DVec3::splat(weld_distance);
    for &p in points {
        let (lo, hi) = (cell(p - reach), cell(p + reach));
        let nearby = (lo.x..=hi.x)
            .flat_map(|x| (lo.y..=hi.y).map(move |y| (x, y)))
            .flat_map(|(x, y)| (lo.z..=hi.z).map(move |z| I64Vec3::new(x, y, z)))
            .filter_map(|c| grid.get(&c))
            .flatten()
            .copied()
            .filter(|&v| vertices[v].distance(p) <= weld_distance)
            .min();
        let vertex = nearby.unwrap_or_else(|| {
            let id = vertices.push(p);
            grid.entry(cell(p)).or_default().push(id);
            id
        });
        vertex_of.push(vertex);
    }
    Welded {
        vertices,
        vertex_of,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_of_close_points_does_not_drift() {
        let points: Vec<_> = (0..10).map(|i| DVec3::X * f64::from(i) * 0.6).collect();
        let welded = weld(&points, 1.0);
        for (p, &v) in points.iter().zip(&welded.vertex_of) {
            assert!(welded.vertices[v].distance(*p) <= 1.0);
        }
        assert_eq!(welded.vertices.len(), 5);
    }

    #[test]
    fn neighbours_across_a_cell_border_weld() {
        let border = CELL_OVER_WELD_DISTANCE;
        let points = [DVec3::splat(border - 0.1), DVec3::splat(border + 0.1)];
        assert_eq!(weld(&points, 1.0).vertices.len(), 1);
    }
}
