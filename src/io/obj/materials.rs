//! The materials of an OBJ file: from its libraries, and made up where these do not define one.

use super::NamedAt;
use super::mtl::{self, MtlMaterial};
use crate::bad_input::BadInput;
use crate::io::{check_material, default_material, place_of, read_file};
use crate::scene::RawScene;
use crate::warning::Warning;
use std::collections::HashMap;
use std::path::Path;

/// Name of the material of faces that name none.
const NO_MATERIAL: &str = "(none)";

/// The materials of the scene: those of the libraries in their order, then those that had to be made up.
#[derive(Default)]
pub(super) struct Materials {
    list: Vec<MtlMaterial>,
    index_of: HashMap<String, usize>,
    is_used: Vec<bool>,
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
                self.define(material, warnings);
            }
        }
        Ok(())
    }

    fn define(&mut self, material: MtlMaterial, warnings: &mut Vec<Warning>) {
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
        } else {
            self.index_of.insert(name, self.list.len());
            self.list.push(material);
            self.is_used.push(false);
        }
    }

    /// Makes sure that the material exists.
    pub(super) fn ensure(&mut self, used: &NamedAt, warnings: &mut Vec<Warning>) {
        if !self.index_of.contains_key(&used.name) {
            let message = format!(
                "material \"{}\" is not defined: reflectance 0.5 grey is used",
                used.name
            );
            warnings.push(Warning::new(&used.place, message));
            self.make_up(&used.name, &used.place);
        }
    }

    fn make_up(&mut self, name: &str, place: &str) -> usize {
        let index = self.list.len();
        self.index_of.insert(name.to_owned(), index);
        self.list
            .push(MtlMaterial::made_up(default_material(name, true), place));
        self.is_used.push(false);
        index
    }

    /// Index of the material of `faces` faces, as `tobj` names it.
    pub(super) fn use_for(&mut self, id: Option<usize>, faces: usize, place: &str) -> usize {
        let index = id.unwrap_or_else(|| {
            self.without_material += faces;
            match self.index_of.get(NO_MATERIAL) {
                Some(&index) => index,
                None => self.make_up(NO_MATERIAL, place),
            }
        });
        self.is_used[index] = true;
        index
    }

    /// Names by index.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.list.iter().map(|m| m.material.name.as_str())
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
