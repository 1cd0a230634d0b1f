//! What must hold for every [`Scene`]: for tests and debug builds.

use super::{Face, FaceId, Scene, VertexId};
use crate::geom::loop_area;
use crate::geom::predicates::{Side, side_of_line};
use glam::DVec2;

impl Scene {
    /// Checks the documented invariants, except those that need a search over all pairs; says which one fails where.
    ///
    /// `planarity` is how far a corner may lie off its face's plane, metres.
    pub fn check_invariants(&self, planarity: f64) -> Result<(), String> {
        for (id, face) in self.faces.iter() {
            self.check_loops(id, face)
                .and_then(|()| self.check_plane(face, planarity))
                .and_then(|()| self.check_cover(face))
                .map_err(|what| format!("face {id}: {what}"))?;
        }
        self.check_edges()?;
        for (id, emitter) in self.emitters.iter() {
            if self.faces[emitter.face].emission.0.is_black() {
                return Err(format!("emitter {id}: face {} is dark", emitter.face));
            }
        }
        Ok(())
    }

    fn check_loops(&self, id: FaceId, face: &Face) -> Result<(), String> {
        if face.loops.len() != face.outline.loops.len() || face.loops.len() != face.loop_edges.len()
        {
            return Err("loops, edges and outline differ in number".to_owned());
        }
        for (k, l) in face.loops.iter().enumerate() {
            let mut sorted = l.clone();
            sorted.sort_unstable();
            sorted.dedup();
            if l.len() < 3 || sorted.len() != l.len() {
                return Err(format!("loop {k} is not simple"));
            }
            if (loop_area(&face.outline.loops[k]) > 0.0) != (k == 0) {
                return Err(format!("loop {k} runs the wrong way"));
            }
            for (i, &v) in l.iter().enumerate() {
                let next = l[(i + 1) % l.len()];
                let edge = &self.edges[face.loop_edges[k][i]];
                if face.frame.to_plane(self.vertices[v]) != face.outline.loops[k][i] {
                    return Err(format!("outline point {i} of loop {k} is not its vertex"));
                }
                let has_use = edge
                    .uses
                    .iter()
                    .any(|u| u.face == id && u.is_forward == (v < next));
                if edge.ends != [v.min(next), v.max(next)] || !has_use {
                    return Err(format!("edge {i} of loop {k} does not know the face"));
                }
            }
        }
        Ok(())
    }

    /// The frame passes within twice the planarity of each corner: the corners may lie on either side of their plane,
    /// and the frame starts at one of them. Vertices inserted into edges may add the weld distance.
    fn check_plane(&self, face: &Face, planarity: f64) -> Result<(), String> {
        let plane = face.frame.plane();
        let limit = 2.0 * (planarity + self.weld_distance);
        for &v in face.loops.iter().flatten() {
            let distance = plane.distance(self.vertices[v]).abs();
            if distance > limit {
                return Err(format!("vertex {v} lies {distance:e} m off the plane"));
            }
        }
        Ok(())
    }

    fn check_cover(&self, face: &Face) -> Result<(), String> {
        let place = |v: &VertexId| face.frame.to_plane(self.vertices[*v]);
        let area = |polygons: &mut dyn Iterator<Item = &[VertexId]>| -> f64 {
            polygons
                .map(|l| loop_area(&l.iter().map(place).collect::<Vec<_>>()))
                .sum()
        };
        let (lo, hi) = face.outline.bounds();
        let corners = face.loops.iter().map(Vec::len).sum::<usize>();
        // Each corner enters three sums of products no larger than the box squared.
        let roundoff = (corners * corners) as f64 * f64::EPSILON * (hi - lo).length_squared();
        let triangles = area(&mut face.triangles.iter().map(<[_; 3]>::as_slice));
        let parts = area(&mut face.convex_parts.iter().map(Vec::as_slice));
        for (name, got) in [("triangles", triangles), ("convex parts", parts)] {
            if (got - face.area).abs() > roundoff {
                return Err(format!("{name} cover {got} m² of {} m²", face.area));
            }
        }
        for part in &face.convex_parts {
            let points: Vec<DVec2> = part.iter().map(place).collect();
            let n = points.len();
            let turns_right = |i: usize| {
                side_of_line(points[i], points[(i + 1) % n], points[(i + 2) % n]) == Side::Right
            };
            if (0..n).any(turns_right) {
                return Err("a part is not convex".to_owned());
            }
        }
        Ok(())
    }

    fn check_edges(&self) -> Result<(), String> {
        let steps: usize = self
            .faces
            .iter()
            .flat_map(|(_, f)| f.loops.iter().map(Vec::len))
            .sum();
        let uses: usize = self.edges.iter().map(|(_, e)| e.uses.len()).sum();
        if steps != uses {
            return Err(format!("{uses} edge uses for {steps} loop edges"));
        }
        let mut is_used = vec![false; self.vertices.len()];
        for (id, edge) in self.edges.iter() {
            let [a, b] = edge.ends;
            if a >= b || edge.uses.is_empty() {
                return Err(format!(
                    "edge {id}: ends {a}, {b}, unsorted or without a face"
                ));
            }
            if self.vertices[a].distance(self.vertices[b]) <= self.weld_distance {
                return Err(format!("edge {id} is shorter than the weld distance"));
            }
            is_used[a.0 as usize] = true;
            is_used[b.0 as usize] = true;
        }
        match is_used.iter().position(|&u| !u) {
            Some(v) => Err(format!("vertex {v} belongs to no face")),
            None => Ok(()),
        }
    }
}
