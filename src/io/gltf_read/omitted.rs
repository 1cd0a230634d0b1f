//! What of a glTF file the scene does not hold, counted.

use crate::warning::Warning;

/// How many things of the file carry no light here, by kind.
#[derive(Default)]
pub(super) struct Omitted {
    /// Primitives of points or lines, or without positions.
    pub(super) primitives: usize,
    /// Triangle lists that end within a triangle.
    pub(super) leftovers: usize,
    /// Primitives with vertex colours.
    pub(super) colours: usize,
    /// Lights whose numbers mean nothing.
    pub(super) lights: usize,
    /// Primitives with a texture and without coordinates for it.
    pub(super) without_uvs: usize,
    /// Cameras that are not perspective.
    pub(super) cameras: usize,
    /// Triangles without material.
    pub(super) without_material: usize,
}

impl Omitted {
    /// One warning for each kind that occurred.
    pub(super) fn warn(&self, place: &str, warnings: &mut Vec<Warning>) {
        for (count, message) in [
            (self.primitives, "primitives of points or lines left out"),
            (
                self.leftovers,
                "primitives whose number of indices is no multiple of 3: the rest left out",
            ),
            (
                self.colours,
                "primitives with vertex colours, which are not read",
            ),
            (self.lights, "lights whose numbers mean nothing left out"),
            (
                self.without_uvs,
                "primitives without coordinates for their texture: the base colour factor alone is used",
            ),
            (self.cameras, "cameras without perspective left out"),
            (
                self.without_material,
                "triangles have no material: reflectance 0.5 grey is used",
            ),
        ] {
            if count > 0 {
                warnings.push(Warning::new(place, format!("{count} {message}")));
            }
        }
    }
}
