//! The triangles of a glTF primitive with what belongs to their corners, in the coordinates of its mesh.

use super::triangles::triangles;
use crate::bad_input::BadInput;
use crate::io::gltf_data::accessor::{self, Numbers};
use crate::io::gltf_data::buffers::Buffers;
use crate::io::gltf_data::texture::UvSource;
use crate::io::index_u32;
use glam::{DMat4, DVec2, DVec3};
use gltf::Semantic;
use gltf::mesh::Mode;

/// The corners and triangles of a primitive. All lists but the triangles have the length of the positions or are empty.
#[derive(Debug, Default)]
pub(super) struct Shape {
    pub(super) positions: Vec<DVec3>,
    /// As the file has them: not checked, not of unit length.
    pub(super) normals: Vec<DVec3>,
    pub(super) uvs: Vec<DVec2>,
    /// Indices into the positions, not yet checked.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Whether the indices ended within a triangle.
    pub(super) has_leftover: bool,
}

/// Where a primitive's data are.
pub(super) struct Source<'a> {
    pub(super) buffers: &'a Buffers,
    pub(super) place: &'a str,
    pub(super) numbers: Numbers,
}

impl Source<'_> {
    /// The shape of a primitive; `None` for points, lines, and primitives without positions.
    pub(super) fn shape(
        &self,
        primitive: &gltf::Primitive<'_>,
        uv: Option<UvSource>,
    ) -> Result<Option<Shape>, BadInput> {
        let Some(positions) = self.attribute::<3>(primitive, &Semantic::Positions, "positions")?
        else {
            return Ok(None);
        };
        let count = positions.len();
        let indices = match primitive.indices() {
            Some(indices) => accessor::indices(&indices, self.buffers, self.place)?,
            None => (0..index_u32(count, self.place)?).collect(),
        };
        let Some(triangles) = triangles(primitive.mode(), &indices) else {
            return Ok(None);
        };
        let normals = self.attribute::<3>(primitive, &Semantic::Normals, "normals")?;
        let uvs = match uv {
            Some(uv) => {
                let semantic = Semantic::TexCoords(uv.set);
                let uvs = self.attribute::<2>(primitive, &semantic, "texture coordinates")?;
                let moved = |uvs: Vec<[f64; 2]>| uvs.into_iter().map(|x| uv.apply(x)).collect();
                uvs.map(moved).unwrap_or_default()
            }
            None => Vec::new(),
        };
        let mut shape = Shape {
            positions: positions.into_iter().map(DVec3::from).collect(),
            normals: normals
                .unwrap_or_default()
                .into_iter()
                .map(DVec3::from)
                .collect(),
            uvs,
            triangles,
            has_leftover: primitive.mode() == Mode::Triangles && indices.len() % 3 != 0,
        };
        self.check_length(primitive, shape.normals.len(), count)?;
        self.check_length(primitive, shape.uvs.len(), count)?;
        if !shape.uvs.iter().all(|uv| uv.is_finite()) {
            return Err(self.error(primitive, "a texture coordinate is not finite"));
        }
        if shape.normals.iter().any(|n| !n.is_finite()) {
            shape.normals.clear();
        }
        Ok(Some(shape))
    }

    fn attribute<const N: usize>(
        &self,
        primitive: &gltf::Primitive<'_>,
        semantic: &Semantic,
        what: &str,
    ) -> Result<Option<Vec<[f64; N]>>, BadInput> {
        let read = |found: gltf::Accessor<'_>| {
            accessor::vectors::<N>(&found, self.buffers, self.place, self.numbers, what)
        };
        primitive.get(semantic).map(read).transpose()
    }

    fn check_length(
        &self,
        primitive: &gltf::Primitive<'_>,
        found: usize,
        positions: usize,
    ) -> Result<(), BadInput> {
        if found == 0 || found == positions {
            return Ok(());
        }
        let what = format!("an attribute has {found} elements for {positions} positions");
        Err(self.error(primitive, what))
    }

    fn error(&self, primitive: &gltf::Primitive<'_>, what: impl Into<String>) -> BadInput {
        BadInput::new(
            format!("{}: primitive {}", self.place, primitive.index()),
            what,
            "the file is damaged: export it again",
        )
    }

    /// Moves the corners by the morph targets, each as far as its weight says.
    pub(super) fn morph(
        &self,
        shape: &mut Shape,
        primitive: &gltf::Primitive<'_>,
        weights: &[f32],
    ) -> Result<(), BadInput> {
        for (target, &weight) in primitive.morph_targets().zip(weights) {
            if weight == 0.0 {
                continue;
            }
            let moves = [
                (target.positions(), &mut shape.positions),
                (target.normals(), &mut shape.normals),
            ];
            for (accessor, list) in moves {
                let Some(accessor) = accessor.filter(|_| !list.is_empty()) else {
                    continue;
                };
                let (buffers, place) = (self.buffers, self.place);
                let by = accessor::vectors::<3>(&accessor, buffers, place, self.numbers, "moves")?;
                self.check_length(primitive, by.len(), list.len())?;
                for (vector, by) in list.iter_mut().zip(by) {
                    *vector += DVec3::from(by) * f64::from(weight);
                }
            }
        }
        Ok(())
    }

    /// Puts the corners where the joints of a skin stand, in world coordinates; false when they have no joints.
    ///
    /// `joints` holds, for each joint, where it takes a point of the mesh.
    pub(super) fn pose(
        &self,
        shape: &mut Shape,
        primitive: &gltf::Primitive<'_>,
        joints: &[DMat4],
    ) -> Result<bool, BadInput> {
        let (Some(names), Some(weights)) = (
            primitive.get(&Semantic::Joints(0)),
            primitive.get(&Semantic::Weights(0)),
        ) else {
            return Ok(false);
        };
        // Joint numbers are plain 8- or 16-bit integers: the form that quantization has.
        let (buffers, place) = (self.buffers, self.place);
        let names = accessor::vectors::<4>(&names, buffers, place, Numbers::Quantized, "joints")?;
        let weights = accessor::vectors::<4>(&weights, buffers, place, self.numbers, "weights")?;
        self.check_length(primitive, names.len(), shape.positions.len())?;
        self.check_length(primitive, weights.len(), shape.positions.len())?;
        for (i, (names, weights)) in names.iter().zip(&weights).enumerate() {
            let total: f64 = weights.iter().sum();
            let mut matrix = DMat4::ZERO;
            for (name, weight) in names.iter().zip(weights) {
                let joint = joints.get(*name as usize).copied();
                let joint = joint.ok_or_else(|| {
                    self.error(
                        primitive,
                        format!("joint {name} of {} is named", joints.len()),
                    )
                })?;
                matrix += joint * (weight / if total > 0.0 { total } else { 1.0 });
            }
            shape.positions[i] = matrix.transform_point3(shape.positions[i]);
            if let Some(normal) = shape.normals.get_mut(i) {
                *normal = crate::io::gltf_data::place::normal_matrix(matrix) * *normal;
            }
        }
        Ok(true)
    }
}
