//! Where nodes stand.

use glam::{DMat3, DMat4, DQuat, DVec3};
use gltf::scene::Transform;

/// The node's own matrix; `None` when it is not finite or its rotation is zero.
pub(in crate::io) fn local_matrix(node: &gltf::Node<'_>) -> Option<DMat4> {
    let matrix = match node.transform() {
        Transform::Matrix { matrix } => {
            DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from)))
        }
        Transform::Decomposed {
            translation,
            rotation,
            scale,
        } => {
            // Normalised again: in f64 the file's 32-bit quaternion would scale by up to 10⁻⁷.
            let rotation = DQuat::from_array(rotation.map(f64::from)).normalize();
            let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
            DMat4::from_scale_rotation_translation(vector(scale), rotation, vector(translation))
        }
    };
    matrix.is_finite().then_some(matrix)
}

/// Turns normals as `world` turns planes: its cofactors, which also stand for a node that is flattened.
pub(in crate::io) fn normal_matrix(world: DMat4) -> DMat3 {
    let turn = DMat3::from_mat4(world);
    let cofactors = DMat3::from_cols(
        turn.y_axis.cross(turn.z_axis),
        turn.z_axis.cross(turn.x_axis),
        turn.x_axis.cross(turn.y_axis),
    );
    cofactors * turn.determinant().signum()
}
