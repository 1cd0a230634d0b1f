//! OBJ files of a directory, `UMBRAGE_SCENES`: cleaned, checked and timed.

use super::*;
use std::path::{Path, PathBuf};
use std::time::Instant;

fn read(path: &Path) -> RawScene {
    let options = tobj::LoadOptions {
        ignore_lines: true,
        ignore_points: true,
        ..tobj::LoadOptions::default()
    };
    let (models, materials) = tobj::load_obj(path, &options).expect("a readable OBJ");
    let mut raw = soup(&[], &[]);
    raw.source = path.display().to_string();
    raw.materials = materials
        .expect("a readable MTL")
        .iter()
        .map(|m| {
            let is_lamp = m.emissive.is_some_and(|e| e.iter().any(|&v| v > 0.0));
            Material {
                is_see_through: m.dissolve.is_some_and(|d| d < 0.5),
                ..material(&m.name, if is_lamp { 1.0 } else { 0.0 })
            }
        })
        .collect();
    raw.groups = models.iter().map(|m| m.name.clone()).collect();
    raw.groups.dedup();
    let mut group = 0;
    for model in models {
        group += u32::from(raw.groups[group as usize] != model.name);
        let mesh = model.mesh;
        let first = u32::try_from(raw.positions.len()).expect("fewer than 2³² positions");
        let positions = mesh.positions.chunks_exact(3);
        raw.positions.extend(positions.map(DVec3::from_slice));
        let mut corners = mesh.indices.iter().map(|i| i + first);
        let triangles = vec![3; mesh.indices.len() / 3];
        let arities = if mesh.face_arities.is_empty() {
            &triangles
        } else {
            &mesh.face_arities
        };
        for &arity in arities {
            raw.polygons.push(RawPolygon {
                corners: corners.by_ref().take(arity as usize).collect(),
                material: u32::try_from(mesh.material_id.unwrap_or(0)).expect("few materials"),
                group,
            });
        }
    }
    raw
}

#[test]
#[ignore = "needs UMBRAGE_SCENES, a directory with a directory for each scene"]
fn scenes_of_others_come_out_valid() {
    let root = PathBuf::from(std::env::var("UMBRAGE_SCENES").expect("UMBRAGE_SCENES is set"));
    let mut files: Vec<PathBuf> = std::fs::read_dir(root)
        .expect("a readable directory")
        .flat_map(|dir| std::fs::read_dir(dir.expect("an entry").path()))
        .flatten()
        .map(|file| file.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "obj"))
        .collect();
    files.sort();
    for path in files {
        let raw = read(&path);
        let start = Instant::now();
        let (scene, report, warnings) =
            clean(&raw, &CleanSettings::default()).expect("the scene has faces");
        eprintln!("{} in {:?}", path.display(), start.elapsed());
        eprintln!("{}", serde_json::to_string(&report).expect("plain numbers"));
        warnings.iter().for_each(|w| eprintln!("  {w}"));
        scene
            .check_invariants(report.planarity_m)
            .expect("the scene is valid");
        assert_separated(&scene);
    }
}
