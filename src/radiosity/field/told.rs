//! The light as the cells tell it, without any gathering.

use super::IndirectField;
use crate::mesh::barycentric;
use crate::quantity::Radiosity;
use glam::DVec2;

impl IndirectField<'_> {
    /// Radiosity at frame coordinates `p` of solve face `f`, as the smallest cell there tells it in the basis asked for: what
    /// all gathers take light from, W/m². None where the face has no area.
    pub fn told_at(&self, f: usize, p: DVec2) -> Option<Radiosity> {
        let tree = &self.solution.trees[f];
        let mut c = tree.root_at(p)?;
        while let Some(child) = tree.child_towards(c, p) {
            c = child;
        }
        let corners = self.solution.light.faces[f].cells[c].corners;
        let mut sum = Radiosity::ZERO;
        for (b, w) in corners.iter().zip(barycentric(tree.cells[c].flat, p)) {
            sum += *b * w;
        }
        Some(sum)
    }
}
