//! Where the test scenes are.

use super::obj_lite::ObjMesh;
use std::path::{Path, PathBuf};

/// The scenes of `fixtures/scenes` that have a known shape of shadow, unmoved and unscaled.
pub(crate) const SHADOW_SCENES: [&str; 14] = [
    "square-over-square",
    "rotated-blocker",
    "tilted-triangle",
    "crossing-blockers",
    "blocker-touching-floor",
    "box-on-table",
    "wall-piercing-floor",
    "coplanar-edges",
    "receiver-through-emitter",
    "emitter-plane-on-receiver",
    "back-facing-emitter",
    "non-convex-emitter",
    "emitter-with-hole",
    "two-emitters",
];

/// Scenes in which every surface leaves 1 W/m².
pub(crate) const FURNACES: [&str; 12] = [
    "furnace-box-r10",
    "furnace-box-r50",
    "furnace-box-r90",
    "furnace-box-r99",
    "furnace-l-room-r10",
    "furnace-l-room-r50",
    "furnace-l-room-r90",
    "furnace-l-room-r99",
    "furnace-cornell-r10",
    "furnace-cornell-r50",
    "furnace-cornell-r90",
    "furnace-cornell-r99",
];

/// The directory of the fixtures.
pub(crate) fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures")
}

/// The OBJ file of a scene of our own.
pub(crate) fn fixture(name: &str) -> PathBuf {
    fixtures()
        .join("scenes")
        .join(name)
        .join(name)
        .with_extension("obj")
}

/// Names of all scenes of our own, sorted.
pub(crate) fn fixture_names() -> Vec<String> {
    let directory = fixtures().join("scenes");
    let entries = std::fs::read_dir(&directory).expect("the fixtures are there");
    let mut names: Vec<String> = entries
        .map(|e| e.expect("the entry is readable").path())
        .filter(|path| path.is_dir())
        .filter_map(|path| Some(path.file_name()?.to_string_lossy().into_owned()))
        .collect();
    names.sort();
    names
}

/// A scene of our own, read.
pub(crate) fn read_fixture(name: &str) -> ObjMesh {
    ObjMesh::read(&fixture(name))
}

/// A scene from outside the repository, `directory/file` under `../shared/scenes`; `None` with one line on standard
/// error where it is missing, so that the caller can return.
pub(crate) fn shared_scene(relative: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../shared/scenes")
        .join(relative);
    if path.is_file() {
        return Some(path);
    }
    eprintln!(
        "skipped: scene {relative} is not there ({})",
        path.display()
    );
    None
}
