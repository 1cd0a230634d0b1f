//! How texture coordinates and shading normals run over a polygon.
//!
//! Both are linear over a triangle, and so is what a face keeps of them: one [`AffineMap`] each. Polygons over which they
//! are not linear are cut into triangles, and coplanar polygons merge only where one map serves both. The mesh of a face
//! may then put its vertices anywhere and still know both at each of them; where two texture charts meet, two faces do,
//! and each has its own vertices along the seam.

use super::piece::{Piece, Positions};
use crate::geom::AffineMap;
use crate::scene::{RawScene, VertexId};
use crate::texture::Texture;
use glam::{DVec2, DVec3};

/// Texture coordinates are the same when they lead to places this near each other, texels.
const SAME_TEXEL: f64 = 0.25;

/// Shading normals are the same when they differ by less than this, radians (1°): exporters store them in as few as eight
/// bits a component, and nobody sees a degree. Nearer than this to the polygon's own normal they mean a flat face.
const SAME_NORMAL: f64 = std::f64::consts::PI / 180.0;

/// The maps over one polygon; at least one is there.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceMaps {
    /// Texture coordinates.
    pub(super) uv: Option<AffineMap<2>>,
    /// Shading normals, for polygons of curved surfaces.
    pub(super) shading: Option<AffineMap<3>>,
}

/// What the file says at the corners of its polygons, found by their welded vertices.
pub(super) struct Corners<'a> {
    raw: &'a RawScene,
    /// Vertex of each position that takes part.
    vertex_of: Vec<VertexId>,
}

impl<'a> Corners<'a> {
    /// `vertex_of` holds the welded vertex of each position of `raw`; those that take no part may have any.
    pub(super) fn new(raw: &'a RawScene, vertex_of: Vec<VertexId>) -> Self {
        Self { raw, vertex_of }
    }

    fn texture(&self, piece: &Piece) -> Option<&'a Texture> {
        let material = &self.raw.materials[piece.material as usize];
        let index = material.texture.or(material.emission_texture)?;
        self.raw.textures.get(index as usize)
    }

    /// Index in the file of the corner of `piece` at `vertex`.
    fn position(&self, piece: &Piece, vertex: VertexId) -> Option<usize> {
        let corners = &self.raw.polygons[piece.source as usize].corners;
        let is_there = |c: &&u32| self.vertex_of[**c as usize] == vertex;
        corners.iter().find(is_there).map(|&c| c as usize)
    }

    fn each<T>(&self, piece: &Piece, values: &[T]) -> Option<Vec<T>>
    where
        T: Copy,
    {
        let value = |&v: &VertexId| values.get(self.position(piece, v)?).copied();
        piece.corners.iter().map(value).collect()
    }

    /// The texture coordinates of the corners; none where no texture needs them.
    fn uvs(&self, piece: &Piece) -> Option<Vec<[f64; 2]>> {
        self.texture(piece)?;
        let uvs = self.each(piece, &self.raw.uvs)?;
        Some(uvs.into_iter().map(<[f64; 2]>::from).collect())
    }

    /// The shading normals of the corners; none where the polygon is flat, or where one of them is missing or points to
    /// the polygon's back.
    fn normals(&self, piece: &Piece, positions: &Positions) -> Option<Vec<[f64; 3]>> {
        let normals = self.each(piece, &self.raw.normals)?;
        let front = piece.newell(positions).try_normalize()?;
        let (least, most) = (SAME_NORMAL.sin(), SAME_NORMAL.cos());
        let is_usable = normals.iter().all(|n| n.dot(front) > least);
        let is_curved = normals.iter().any(|n| n.dot(front) < most);
        (is_usable && is_curved).then(|| normals.into_iter().map(<[f64; 3]>::from).collect())
    }

    /// The maps over `piece`: as far as there are any, and linear; `Err` where they are not.
    fn maps(&self, piece: &Piece, positions: &Positions) -> Result<Option<SurfaceMaps>, Bent> {
        let points: Vec<DVec3> = piece.points(positions).collect();
        let Some(triple) = widest_triple(&points) else {
            return Ok(None);
        };
        let uv = match (self.uvs(piece), self.texture(piece)) {
            (Some(uvs), Some(texture)) => {
                let size = texture.size();
                linear(&points, triple, &uvs, |d| DVec2::from(d) * size, SAME_TEXEL)?
            }
            _ => None,
        };
        let shading = match self.normals(piece, positions) {
            Some(normals) => linear(&points, triple, &normals, DVec3::from, SAME_NORMAL)?,
            None => None,
        };
        Ok((uv.is_some() || shading.is_some()).then_some(SurfaceMaps { uv, shading }))
    }

    /// Whether one map of each kind serves the whole of `piece`.
    pub(super) fn are_linear(&self, piece: &Piece, positions: &Positions) -> bool {
        piece.corners.len() == 3 || self.maps(piece, positions).is_ok()
    }

    /// The maps of all pieces; each piece gets the index of its own.
    pub(super) fn all_maps(&self, pieces: &mut [Piece], positions: &Positions) -> Vec<SurfaceMaps> {
        let mut all = Vec::new();
        if self.raw.normals.is_empty() && self.raw.textures.is_empty() {
            return all;
        }
        for piece in pieces {
            if let Ok(Some(maps)) = self.maps(piece, positions) {
                piece.maps = Some(u32::try_from(all.len()).expect("fewer than 2³² polygons"));
                all.push(maps);
            }
        }
        all
    }

    /// Whether the maps of `seed` are those of `candidate` too, at all corners of the latter.
    ///
    /// Whole repetitions of the texture between the two do not show.
    pub(super) fn continue_each_other(
        &self,
        all: &[SurfaceMaps],
        seed: &Piece,
        candidate: &Piece,
        positions: &Positions,
    ) -> bool {
        let maps = |piece: &Piece| piece.maps.map(|i| all[i as usize]);
        let (a, b) = match (maps(seed), maps(candidate)) {
            (None, None) => return true,
            (Some(a), Some(b)) => (a, b),
            _ => return false,
        };
        let points = || candidate.points(positions);
        let same_uv = match (a.uv, b.uv, self.texture(seed)) {
            (None, None, _) => true,
            (Some(a), Some(b), Some(texture)) => {
                let apart = |p| DVec2::from(a.at(p)) - DVec2::from(b.at(p));
                let shift = points().next().map_or(DVec2::ZERO, apart);
                let whole = texture.repetition(shift);
                points().all(|p| ((apart(p) - whole) * texture.size()).length() <= SAME_TEXEL)
            }
            _ => false,
        };
        let same_shading = match (a.shading, b.shading) {
            (None, None) => true,
            (Some(a), Some(b)) => {
                points().all(|p| DVec3::from(a.at(p)).distance(DVec3::from(b.at(p))) <= SAME_NORMAL)
            }
            _ => false,
        };
        same_uv && same_shading
    }
}

/// Something is not linear over a polygon.
struct Bent;

/// The map with `values` at `points`, if it keeps within `tolerance` of them as `measure` sees the difference.
fn linear<const N: usize, V: Length>(
    points: &[DVec3],
    triple: [usize; 3],
    values: &[[f64; N]],
    measure: impl Fn([f64; N]) -> V,
    tolerance: f64,
) -> Result<Option<AffineMap<N>>, Bent> {
    let Some(map) = AffineMap::through(triple.map(|i| points[i]), triple.map(|i| values[i])) else {
        return Ok(None);
    };
    let is_kept = points.iter().zip(values).all(|(&p, value)| {
        let found = map.at(p);
        measure(std::array::from_fn(|i| found[i] - value[i])).size() <= tolerance
    });
    if is_kept { Ok(Some(map)) } else { Err(Bent) }
}

/// Vectors of both dimensions.
trait Length {
    fn size(&self) -> f64;
}

impl Length for DVec2 {
    fn size(&self) -> f64 {
        self.length()
    }
}

impl Length for DVec3 {
    fn size(&self) -> f64 {
        self.length()
    }
}

/// Three corners far from one line: the first, the one farthest from it, and the one farthest from the line through both.
fn widest_triple(points: &[DVec3]) -> Option<[usize; 3]> {
    let farthest = |distance: &dyn Fn(DVec3) -> f64| {
        (0..points.len()).max_by(|&i, &j| distance(points[i]).total_cmp(&distance(points[j])))
    };
    let a = *points.first()?;
    let second = farthest(&|p| p.distance_squared(a))?;
    let along = points[second] - a;
    let third = farthest(&|p| along.cross(p - a).length_squared())?;
    Some([0, second, third])
}
