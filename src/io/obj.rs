//! Wavefront OBJ with its MTL libraries.
//!
//! `tobj` reads the faces. It is handed a cleaned copy of the text, since it stops at things that files do hold (line
//! continuations, stray bytes, comments behind numbers), takes a polyline for a polygon, and knows no line numbers: those
//! are found afterwards, by a second look at the text, once something is wrong.

mod diagnose;
mod materials;
mod mtl;
mod text;

use super::{ReadSettings, index_u32, place_of, read_file};
use crate::bad_input::BadInput;
use crate::scene::{RawPolygon, RawScene};
use crate::warning::Warning;
use glam::DVec3;
use materials::Materials;
use std::collections::HashMap;
use std::io::{Cursor, Read as _};
use std::path::Path;
use text::{decode, statements};

/// The scene in an OBJ file; its faces reflect on both sides and emit from the front.
pub(super) fn read(path: &Path, settings: &ReadSettings) -> Result<RawScene, BadInput> {
    let place = place_of(path);
    let bytes = read_file(path)?;
    let text = decode(&bytes);
    let outline = Outline::of(&text, &place)?;

    let mut warnings = outline.warnings(&place);
    let mut materials = Materials::default();
    for library in &outline.libraries {
        materials.read_library(path, library, &mut warnings)?;
    }
    for used in &outline.used {
        materials.ensure(used, &mut warnings);
    }

    let models = load_models(&outline.geometry, &materials)
        .map_err(|error| diagnose::explain(&text, &place, error))?;
    let mut builder = Builder {
        scene: RawScene {
            source: place.clone(),
            warnings,
            ..RawScene::default()
        },
        place: &place,
        settings,
        group_of: HashMap::new(),
        dropped: 0,
    };
    for model in &models {
        builder.push_model(model, &mut materials)?;
    }
    let mut scene = builder.scene;
    if !scene.positions.iter().all(|position| position.is_finite()) {
        return Err(diagnose::not_finite(&text, &place));
    }
    if builder.dropped > 0 {
        let message = format!(
            "{} faces with fewer than 3 corners left out",
            builder.dropped
        );
        scene.warnings.push(Warning::new(&place, message));
    }
    materials.finish(&mut scene)?;
    Ok(scene)
}

/// What one pass over the text finds: the geometry for `tobj`, and what `tobj` would lose.
#[derive(Default)]
struct Outline {
    /// The statements `v`, `f`, `o`, `g`, `usemtl` alone. Without texture coordinates and normals, since no light depends
    /// on them: their mistakes do not matter and they split no vertices.
    geometry: String,
    libraries: Vec<NamedAt>,
    /// Materials named by `usemtl`, each once, in the order of first use.
    used: Vec<NamedAt>,
    /// Statements that hold points, lines, curves or curved surfaces.
    without_area: usize,
}

/// A name in the file and `file:line` of the statement.
struct NamedAt {
    name: String,
    place: String,
}

impl Outline {
    fn of(text: &str, place: &str) -> Result<Self, BadInput> {
        let mut outline = Self::default();
        outline.geometry.reserve(text.len());
        let mut seen = HashMap::new();
        for statement in statements(text) {
            let at = || format!("{place}:{}", statement.number);
            let rest = statement.rest();
            match statement.keyword() {
                // A fourth number is the weight of a curve's control point, further ones are colours.
                "v" => outline.push_words("v", statement.values().take(3)),
                "f" | "fo" => outline.push_words("f", statement.values()),
                "o" | "g" => outline.push_words(statement.keyword(), [rest].into_iter()),
                "usemtl" if rest.is_empty() => {
                    return Err(BadInput::new(
                        at(),
                        "usemtl without a name",
                        "name a material",
                    ));
                }
                "usemtl" => {
                    outline.push_words("usemtl", [rest].into_iter());
                    seen.entry(rest.to_owned()).or_insert_with(|| {
                        outline.used.push(NamedAt {
                            name: rest.to_owned(),
                            place: at(),
                        });
                    });
                }
                "mtllib" => outline.libraries.push(NamedAt {
                    name: rest.to_owned(),
                    place: at(),
                }),
                "p" | "l" | "curv" | "curv2" | "surf" => outline.without_area += 1,
                _ => {}
            }
        }
        Ok(outline)
    }

    fn push_words<'a>(&mut self, keyword: &str, words: impl Iterator<Item = &'a str>) {
        self.geometry.push_str(keyword);
        for word in words {
            self.geometry.push(' ');
            self.geometry.push_str(word);
        }
        self.geometry.push('\n');
    }

    fn warnings(&self, place: &str) -> Vec<Warning> {
        let count = self.without_area;
        (count > 0)
            .then(|| {
                let message = format!(
                    "{count} point, line and curve statements left out: they are no polygons"
                );
                Warning::new(place, message)
            })
            .into_iter()
            .collect()
    }
}

/// The faces by group and material, in the order of the file. Material ids are indices into `materials`: `tobj` gets
/// their names at the top, so that a `usemtl` ahead of its `mtllib` finds its material as well.
fn load_models(geometry: &str, materials: &Materials) -> Result<Vec<tobj::Model>, tobj::LoadError> {
    let mut reader = Cursor::new("mtllib all\n").chain(geometry.as_bytes());
    let options = tobj::LoadOptions::default();
    let (models, _) = tobj::load_obj_buf(&mut reader, &options, |_| {
        let names = || materials.names().map(str::to_owned);
        let named = |name| tobj::Material {
            name,
            ..tobj::Material::default()
        };
        let index_of = names().enumerate().map(|(index, name)| (name, index));
        Ok((names().map(named).collect(), index_of.collect()))
    })?;
    Ok(models)
}

struct Builder<'a> {
    scene: RawScene,
    place: &'a str,
    settings: &'a ReadSettings,
    group_of: HashMap<String, u32>,
    dropped: usize,
}

impl Builder<'_> {
    fn push_model(
        &mut self,
        model: &tobj::Model,
        materials: &mut Materials,
    ) -> Result<(), BadInput> {
        let mesh = &model.mesh;
        if mesh.indices.is_empty() {
            self.dropped += mesh.face_arities.len();
            return Ok(());
        }
        // `tobj` leaves the arities out where all are 3.
        let triangles = vec![
            3;
            if mesh.face_arities.is_empty() {
                mesh.indices.len() / 3
            } else {
                0
            }
        ];
        let arities = if mesh.face_arities.is_empty() {
            &triangles
        } else {
            &mesh.face_arities
        };
        let material = materials.use_for(mesh.material_id, arities.len(), self.place);
        let material = index_u32(material, self.place)?;
        let group = self.group(&model.name)?;

        let base = index_u32(self.scene.positions.len(), self.place)?;
        index_u32(
            self.scene.positions.len() + mesh.positions.len() / 3,
            self.place,
        )?;
        let unit = self.settings.unit.unwrap_or_default();
        self.scene
            .positions
            .extend(mesh.positions.chunks_exact(3).map(|p| {
                self.settings
                    .up
                    .to_y_up(unit.to_metres(DVec3::new(p[0], p[1], p[2])))
            }));

        let mut rest = &mesh.indices[..];
        for &arity in arities {
            let (corners, after) = rest.split_at(arity as usize);
            rest = after;
            if arity < 3 {
                self.dropped += 1;
                continue;
            }
            self.scene.polygons.push(RawPolygon {
                corners: corners.iter().map(|corner| base + corner).collect(),
                material,
                group,
            });
        }
        Ok(())
    }

    fn group(&mut self, name: &str) -> Result<u32, BadInput> {
        if let Some(&group) = self.group_of.get(name) {
            return Ok(group);
        }
        let group = index_u32(self.scene.groups.len(), self.place)?;
        self.scene.groups.push(name.to_owned());
        self.group_of.insert(name.to_owned(), group);
        Ok(group)
    }
}
