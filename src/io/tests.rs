//! What both readers share, and every scene at hand.

mod gltf_files;
mod gltf_hostile;
mod gltf_modern;
mod obj_files;

use super::*;
use std::path::PathBuf;
use tempfile::TempDir;

/// The result of reading `main` beside the other files, all in a directory of their own.
fn read_files(
    main: &str,
    files: &[(&str, &[u8])],
    settings: &ReadSettings,
) -> Result<RawScene, BadInput> {
    let directory = TempDir::new().unwrap();
    for (name, content) in files {
        std::fs::write(directory.path().join(name), content).unwrap();
    }
    // Messages name the path as typed: cut the directory away.
    let strip = |text: &str| text.replace(&format!("{}/", directory.path().display()), "");
    match read_scene(&directory.path().join(main), settings) {
        Ok(mut scene) => {
            for warning in &mut scene.warnings {
                *warning =
                    crate::warning::Warning::new(strip(&warning.place), strip(&warning.message));
            }
            check_indices(&scene);
            Ok(scene)
        }
        Err(error) => Err(BadInput::new(
            strip(&error.place),
            strip(&error.what),
            error.remedy,
        )),
    }
}

/// Replaces a file. Removed first, since some file systems wait for the disk when a file is cut to zero and written again.
fn replace_file(path: &Path, content: &[u8]) {
    let _ = std::fs::remove_file(path);
    std::fs::write(path, content).unwrap();
}

/// Marsaglia's xorshift64: the same mutations every time.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % limit as u64) as usize
    }
}

/// What every stage after the readers relies on.
fn check_indices(scene: &RawScene) {
    assert!(scene.positions.iter().all(|position| position.is_finite()));
    for polygon in &scene.polygons {
        assert!(polygon.corners.len() >= 3);
        assert!(
            polygon
                .corners
                .iter()
                .all(|&c| (c as usize) < scene.positions.len())
        );
        assert!((polygon.material as usize) < scene.materials.len());
        assert!((polygon.group as usize) < scene.groups.len());
    }
}

#[test]
fn an_unknown_extension_is_named() {
    let error = read_files("a.stl", &[("a.stl", b"solid")], &ReadSettings::default()).unwrap_err();
    assert_eq!(error.place, "a.stl");
    assert!(error.what.contains("\"stl\""), "{error}");
}

#[test]
fn a_missing_file_is_an_error() {
    let error = read_files("a.obj", &[], &ReadSettings::default()).unwrap_err();
    assert!(error.what.starts_with("cannot be read"), "{error}");
}

#[test]
fn units_and_axes_read_from_text() {
    assert_eq!("mm".parse(), Ok(Unit::Millimetre));
    assert!("yard".parse::<Unit>().is_err());
    assert_eq!("z".parse(), Ok(UpAxis::Z));
    assert!("x".parse::<UpAxis>().is_err());
}

/// Reads every scene below `UMBRAGE_SCENES`, or the directory where the project's shared scenes are kept.
#[test]
#[allow(clippy::print_stdout, reason = "a skipped test says so")]
fn every_scene_at_hand_has_polygons() {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/scenes");
    let root =
        std::env::var_os("UMBRAGE_SCENES").map_or_else(|| PathBuf::from(beside), PathBuf::from);
    let Ok(folders) = std::fs::read_dir(&root) else {
        println!("skipped: no scenes at {}", root.display());
        return;
    };
    let mut files: Vec<_> = folders
        .filter_map(|folder| std::fs::read_dir(folder.ok()?.path()).ok())
        .flatten()
        .filter_map(|file| Some(file.ok()?.path()))
        .filter(|file| {
            file.extension()
                .is_some_and(|e| e == "obj" || e == "glb" || e == "gltf")
        })
        .collect();
    files.sort();
    for file in files {
        let start = std::time::Instant::now();
        let scene = read_scene(&file, &ReadSettings::default()).unwrap();
        check_indices(&scene);
        assert!(!scene.polygons.is_empty());
        let count = |is: fn(&Material) -> bool| {
            let materials = scene
                .polygons
                .iter()
                .map(|p| &scene.materials[p.material as usize]);
            materials.filter(|material| is(material)).count()
        };
        println!(
            "{}: {} polygons ({} emit, {} see-through), {} positions, {} materials, {} cameras, {:.0?}",
            file.display(),
            scene.polygons.len(),
            count(Material::is_emitter),
            count(|material| material.is_see_through),
            scene.positions.len(),
            scene.materials.len(),
            scene.cameras.len(),
            start.elapsed()
        );
        for warning in scene.warnings.iter().take(3) {
            println!("    {warning}");
        }
    }
}
