//! The materials of an OBJ file: from its libraries, and made up where these do not define one.

use super::NamedAt;
use super::mtl::{self, MtlMaterial, SEE_THROUGH_BELOW};
use super::texture::UvMove;
use crate::bad_input::BadInput;
use crate::io::{check_material, default_material, index_u32, place_of, read_file};
use crate::scene::RawScene;
use crate::warning::Warning;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Name of the material of faces that name none.
const NO_MATERIAL: &str = "(none)";

/// The materials of the scene: those of the libraries in their order, then those that had to be made up.
#[derive(Default)]
pub(super) struct Materials {
    list: Vec<MtlMaterial>,
    index_of: HashMap<String, usize>,
    is_used: Vec<bool>,
    /// The library of each material.
    file_of: Vec<PathBuf>,
    /// Index in the scene of each texture that was looked for, by library and name; none where it cannot be read.
    texture_of: HashMap<(PathBuf, String), Option<u32>>,
    /// Faces before any `usemtl`.
    without_material: usize,
}

impl Materials {
    /// Adds what `mtllib` names, relative to the OBJ file. A library that is not there is a warning: its materials are
    /// made up when a face uses them.
    pub(super) fn read_library(
        &mut self,
        obj: &Path,
        library: &NamedAt,
        warnings: &mut Vec<Warning>,
    ) -> Result<(), BadInput> {
        let directory = obj.parent().unwrap_or(Path::new(""));
        // One file name may hold spaces; else there are several names; both may have been written on Windows.
        let whole = library.name.replace('\\', "/");
        let names = if directory.join(&whole).is_file() {
            vec![whole.as_str()]
        } else {
            whole.split_whitespace().collect()
        };
        for name in names {
            let file = directory.join(name);
            if !file.is_file() {
                warnings.push(Warning::new(
                    &library.place,
                    format!("material library {} not found", place_of(&file)),
                ));
                continue;
            }
            for material in mtl::parse(&read_file(&file)?, &place_of(&file), warnings)? {
                self.define(material, &file, warnings);
            }
        }
        Ok(())
    }

    fn define(&mut self, material: MtlMaterial, library: &Path, warnings: &mut Vec<Warning>) {
        let name = material.material.name.clone();
        if let Some(&earlier) = self.index_of.get(&name) {
            warnings.push(Warning::new(
                &material.place,
                format!(
                    "material \"{name}\" is defined again: this definition replaces the one at {}",
                    self.list[earlier].place
                ),
            ));
            self.list[earlier] = material;
            self.file_of[earlier] = library.to_owned();
        } else {
            self.index_of.insert(name, self.list.len());
            self.list.push(material);
            self.file_of.push(library.to_owned());
            self.is_used.push(false);
        }
    }

    /// Index of the material, which is made up if no library defines it.
    pub(super) fn ensure(&mut self, used: &NamedAt, warnings: &mut Vec<Warning>) -> usize {
        if let Some(&index) = self.index_of.get(&used.name) {
            return index;
        }
        let message = format!(
            "material \"{}\" is not defined: reflectance 0.5 grey is used",
            used.name
        );
        warnings.push(Warning::new(&used.place, message));
        self.make_up(&used.name, &used.place)
    }

    fn make_up(&mut self, name: &str, place: &str) -> usize {
        let index = self.list.len();
        self.index_of.insert(name.to_owned(), index);
        self.list
            .push(MtlMaterial::made_up(default_material(name, true), place));
        self.file_of.push(PathBuf::new());
        self.is_used.push(false);
        index
    }

    /// Index of the material of a face that names `id`, or none.
    pub(super) fn use_for(&mut self, id: Option<usize>, place: &str) -> usize {
        let index = id.unwrap_or_else(|| {
            self.without_material += 1;
            match self.index_of.get(NO_MATERIAL) {
                Some(&index) => index,
                None => self.make_up(NO_MATERIAL, place),
            }
        });
        self.is_used[index] = true;
        index
    }

    /// How the texture of a material is looked up, if it has one that can be read; the scene gets it at its first use.
    pub(super) fn open_texture(
        &mut self,
        index: usize,
        scene: &mut RawScene,
    ) -> Result<Option<UvMove>, BadInput> {
        let material = &self.list[index];
        let Some(map) = &material.texture else {
            return Ok(None);
        };
        if material.material.texture.is_some() {
            return Ok(Some(map.uv));
        }
        let key = (self.file_of[index].clone(), format!("{map:?}"));
        let known = self.texture_of.get(&key).copied();
        let found = match known {
            Some(known) => known,
            None => match map.load(&key.0) {
                Ok(texture) => {
                    scene.textures.push(texture);
                    Some(index_u32(scene.textures.len() - 1, &scene.source)?)
                }
                Err(why) => {
                    let name = &material.material.name;
                    let message = format!("material \"{name}\": map_Kd {why}; Kd alone is used");
                    scene.warnings.push(Warning::new(&material.place, message));
                    None
                }
            },
        };
        self.texture_of.insert(key, found);
        let material = &mut self.list[index];
        material.material.texture = found;
        if found.is_none() {
            material.texture = None;
            return Ok(None);
        }
        material.material.cut_off = material.is_cut_out().then_some(SEE_THROUGH_BELOW);
        Ok(material.texture.as_ref().map(|map| map.uv))
    }

    /// Checks the materials that faces use and hands all over to the scene.
    pub(super) fn finish(self, scene: &mut RawScene) -> Result<(), BadInput> {
        for (material, _) in self
            .list
            .iter()
            .zip(&self.is_used)
            .filter(|(_, is_used)| **is_used)
        {
            check_material(&material.place, &material.material)?;
        }
        if self.without_material > 0 {
            let message = format!(
                "{} faces have no material: reflectance 0.5 grey is used",
                self.without_material
            );
            scene.warnings.push(Warning::new(&scene.source, message));
        }
        scene.materials = self.list.into_iter().map(|m| m.material).collect();
        Ok(())
    }
}
