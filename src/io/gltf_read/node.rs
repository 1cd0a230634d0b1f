//! The node tree of a glTF scene, with each node's place in the world.

use crate::bad_input::BadInput;
use crate::io::UpAxis;
use crate::io::gltf_data::place::local_matrix;
use crate::scene::Camera;
use glam::{DMat4, DVec3};
use gltf::camera::Projection;

/// A node and the map from its coordinates to the world's.
pub(super) struct PlacedNode<'a> {
    pub(super) node: gltf::Node<'a>,
    pub(super) world: DMat4,
}

/// All nodes of the default scene (else the first, else of all trees), parents first, in the order of the file.
///
/// A node that is reached twice is an error: nodes must form trees, and a cycle would have no end.
pub(super) fn placed_nodes<'a>(
    document: &'a gltf::Document,
    place: &str,
) -> Result<Vec<PlacedNode<'a>>, BadInput> {
    let mut is_visited = vec![false; document.nodes().count()];
    let mut placed = Vec::new();
    let mut stack: Vec<_> = roots(document)
        .into_iter()
        .map(|node| (node, DMat4::IDENTITY))
        .collect();
    stack.reverse();
    while let Some((node, parent)) = stack.pop() {
        if std::mem::replace(&mut is_visited[node.index()], true) {
            return Err(BadInput::new(
                format!("{place}: node {}", node.index()),
                "reached twice: the nodes form a cycle, or one has two parents",
                "give each node one parent at most",
            ));
        }
        let world = parent * local(&node, place)?;
        let below = stack.len();
        stack.extend(node.children().map(|child| (child, world)));
        stack[below..].reverse();
        placed.push(PlacedNode { node, world });
    }
    Ok(placed)
}

fn roots(document: &gltf::Document) -> Vec<gltf::Node<'_>> {
    if let Some(scene) = document
        .default_scene()
        .or_else(|| document.scenes().next())
    {
        return scene.nodes().collect();
    }
    let mut is_child = vec![false; document.nodes().count()];
    for child in document.nodes().flat_map(|node| node.children()) {
        is_child[child.index()] = true;
    }
    document
        .nodes()
        .filter(|node| !is_child[node.index()])
        .collect()
}

fn local(node: &gltf::Node<'_>, place: &str) -> Result<DMat4, BadInput> {
    local_matrix(node).ok_or_else(|| {
        BadInput::new(
            format!("{place}: node {}", node.index()),
            "its transform is not finite, or its rotation is zero",
            "reset the transform and export again",
        )
    })
}

/// The camera of a node in the world; `None` for one without perspective or whose axes the transform makes collapse.
pub(super) fn camera(
    placed: &PlacedNode<'_>,
    source: &gltf::Camera<'_>,
    up: UpAxis,
) -> Option<Camera> {
    let Projection::Perspective(perspective) = source.projection() else {
        return None;
    };
    // A glTF camera looks along −z with y up.
    let axis = |v: DVec3| up.to_y_up(placed.world.transform_vector3(v));
    let forward = axis(DVec3::NEG_Z).try_normalize()?;
    let tilted = axis(DVec3::Y);
    let upwards = (tilted - forward * forward.dot(tilted)).try_normalize()?;
    let name = placed.node.name().or(source.name());
    let vertical_fov_rad = f64::from(perspective.yfov());
    let is_seeing = vertical_fov_rad > 0.0 && vertical_fov_rad < std::f64::consts::PI;
    is_seeing.then(|| Camera {
        name: name.map_or_else(|| format!("camera {}", source.index()), str::to_owned),
        eye: up.to_y_up(placed.world.transform_point3(DVec3::ZERO)),
        forward,
        up: upwards,
        vertical_fov_rad,
        aspect: perspective.aspect_ratio().map(f64::from),
    })
}
