//! The triangles of a glTF primitive.

use gltf::mesh::Mode;

/// Corners of the triangles that `indices` describe in the given mode, counter-clockwise as the glTF specification
/// (3.7.2.1) orders them; `None` for points and lines. Indices left over at the end make no triangle.
pub(super) fn triangles(mode: Mode, indices: &[u32]) -> Option<Vec<[u32; 3]>> {
    match mode {
        Mode::Triangles => Some(
            indices
                .chunks_exact(3)
                .map(|c| [c[0], c[1], c[2]])
                .collect(),
        ),
        // Every second triangle of a strip runs the other way round.
        Mode::TriangleStrip => Some(
            indices
                .windows(3)
                .enumerate()
                .map(|(i, c)| {
                    if i % 2 == 0 {
                        [c[0], c[1], c[2]]
                    } else {
                        [c[0], c[2], c[1]]
                    }
                })
                .collect(),
        ),
        Mode::TriangleFan => {
            let (&hub, rim) = indices.split_first()?;
            Some(rim.windows(2).map(|c| [c[0], c[1], hub]).collect())
        }
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_alternate_and_fans_share_their_hub() {
        let indices = [0, 1, 2, 3, 4];
        assert_eq!(triangles(Mode::Triangles, &indices), Some(vec![[0, 1, 2]]));
        assert_eq!(
            triangles(Mode::TriangleStrip, &indices),
            Some(vec![[0, 1, 2], [1, 3, 2], [2, 3, 4]])
        );
        assert_eq!(
            triangles(Mode::TriangleFan, &indices),
            Some(vec![[1, 2, 0], [2, 3, 0], [3, 4, 0]])
        );
        assert_eq!(triangles(Mode::Lines, &indices), None);
    }
}
