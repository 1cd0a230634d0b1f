//! What a part shows at a point of one of its triangles.

use super::{LitModel, LitPart};
use crate::quantity::Rgb;
use crate::texture::{MipMap, TextureMean};
use glam::DVec2;
use std::sync::Arc;

/// `GL_NEAREST`, as glTF numbers filters.
const NEAREST: u32 = 9728;

/// The textures of a model in linear light.
pub(super) struct Surfaces {
    textures: Vec<Open>,
    /// Index into `textures` of each part.
    of_part: Vec<Option<usize>>,
}

/// A texture, with the cut-off of the parts that use it so.
struct Open {
    texture: u32,
    cut_off: Option<f64>,
    map: MipMap,
    /// Enlarged without blending.
    is_nearest: bool,
}

impl Surfaces {
    /// Opens each texture once for each cut-off that it is used with.
    pub(super) fn new(model: &LitModel) -> Self {
        let mut textures: Vec<Open> = Vec::new();
        let mut open = |part: &LitPart| {
            let index = part
                .texture
                .filter(|_| part.uvs.len() == part.positions.len())?;
            let texture = model.textures.get(index as usize)?;
            let is_it = |o: &Open| (o.texture, o.cut_off) == (index, part.cut_off);
            Some(textures.iter().position(is_it).unwrap_or_else(|| {
                textures.push(Open {
                    texture: index,
                    cut_off: part.cut_off,
                    map: MipMap::new(Arc::clone(&texture.texels), texture.wrap, part.cut_off),
                    is_nearest: texture.filters[0] == Some(NEAREST),
                });
                textures.len() - 1
            }))
        };
        let of_part = model.parts.iter().map(&mut open).collect();
        Self { textures, of_part }
    }

    /// Whether part number `index` has a texture.
    pub(super) fn is_textured(&self, index: usize) -> bool {
        self.of_part[index].is_some()
    }

    /// What the texture of a part shows at barycentric coordinates `weights` of the triangle `corners`, in a pixel that
    /// covers `footprint` m² of it; `None` without a texture.
    pub(super) fn look_up(
        &self,
        part: (usize, &LitPart),
        corners: [u32; 3],
        weights: [f64; 3],
        footprint: f64,
    ) -> Option<TextureMean> {
        let (index, part) = part;
        let open = &self.textures[self.of_part[index]?];
        let uvs = corners.map(|i| part.uvs[i as usize]);
        let uv = uvs[0] * weights[0] + uvs[1] * weights[1] + uvs[2] * weights[2];
        let size = open.map.full_size();
        let texels = (
            uvs.map(|uv| uv * size),
            corners.map(|i| part.positions[i as usize]),
        );
        let ([a, b, c], [p, q, r]) = texels;
        let area = 0.5 * (q - p).cross(r - p).length();
        let texels_per_area = 0.5 * DVec2::perp_dot(b - a, c - a).abs() / area;
        // As many texels as the pixel covers, on the mean of both directions.
        let level = 0.5 * (texels_per_area * footprint).log2();
        let is_enlarged = level.is_nan() || level <= 0.0;
        Some(if open.is_nearest && is_enlarged {
            open.map.nearest(uv)
        } else {
            open.map.sample(uv, if is_enlarged { 0.0 } else { level })
        })
    }

    /// Base colour times texture; a part without one shows its base colour.
    pub(super) fn colour(part: &LitPart, texture: Option<TextureMean>) -> Rgb {
        texture.map_or(part.base_colour, |shown| part.base_colour * shown.colour)
    }
}
