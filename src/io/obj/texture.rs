//! Textures of an MTL file: `map_Kd` with its options.

use super::text::Statement;
use crate::texture::{Texture, Wrap};
use glam::DVec2;
use std::path::{Path, PathBuf};

/// What a texture statement says.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TextureMap {
    /// The file as it is written.
    pub(super) file: String,
    /// How coordinates are moved before the look-up.
    pub(super) uv: UvMove,
    /// Whether the picture ends at its border.
    is_clamped: bool,
}

/// `-s` and `-o`: coordinates are scaled, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UvMove {
    scale: DVec2,
    offset: DVec2,
}

impl UvMove {
    /// The coordinates of the file, whose v points up, as a texture is looked up with.
    pub(super) fn apply(&self, uv: DVec2) -> DVec2 {
        let moved = uv * self.scale + self.offset;
        DVec2::new(moved.x, 1.0 - moved.y)
    }
}

impl TextureMap {
    /// The options and the file name of a statement; the name may hold spaces. `None` when there is no name.
    pub(super) fn parse(statement: &Statement<'_>) -> Option<Self> {
        let mut map = Self {
            file: String::new(),
            uv: UvMove {
                scale: DVec2::ONE,
                offset: DVec2::ZERO,
            },
            is_clamped: false,
        };
        let mut rest = statement.rest();
        while rest.starts_with('-') {
            let (option, after) = next_word(rest);
            rest = after;
            match option {
                "-s" => map.uv.scale = vector(&mut rest, DVec2::ONE),
                "-o" => map.uv.offset = vector(&mut rest, DVec2::ZERO),
                "-t" => drop(vector(&mut rest, DVec2::ZERO)),
                "-clamp" => {
                    let (word, after) = next_word(rest);
                    map.is_clamped = word == "on";
                    rest = after;
                }
                "-mm" => rest = next_word(next_word(rest).1).1,
                "-blendu" | "-blendv" | "-cc" | "-imfchan" | "-texres" | "-bm" | "-boost"
                | "-type" => rest = next_word(rest).1,
                // A name that begins with a dash.
                _ => {
                    rest = statement.rest();
                    break;
                }
            }
        }
        map.file = rest.trim().to_owned();
        (!map.file.is_empty()).then_some(map)
    }

    /// The texture, whose file is looked for where its name says, then beside the library: many libraries keep the path
    /// of the machine that they were written on.
    ///
    /// # Errors
    /// Why there is none, in words.
    pub(super) fn load(&self, library: &Path) -> Result<Texture, String> {
        let name = self.file.replace('\\', "/");
        let folder = library.parent().unwrap_or(Path::new(""));
        let beside = Path::new(&name).file_name().map(PathBuf::from);
        let candidates = [
            Some(folder.join(&name)),
            beside.map(|file| folder.join(file)),
        ];
        let file = candidates.into_iter().flatten().find(|file| file.is_file());
        let file = file.ok_or_else(|| format!("{} is not there", self.file))?;
        let bytes =
            std::fs::read(&file).map_err(|e| format!("{} cannot be read: {e}", self.file))?;
        let mut texture =
            Texture::new(&name, bytes).map_err(|why| format!("{} {why}", self.file))?;
        if self.is_clamped {
            texture.wrap = [Wrap::Clamp; 2];
        }
        Ok(texture)
    }
}

fn next_word(text: &str) -> (&str, &str) {
    match text.split_once(char::is_whitespace) {
        Some((word, rest)) => (word, rest.trim_start()),
        None => (text, ""),
    }
}

/// One to three numbers, of which the first two count; what is not stated stays as in `default`.
fn vector(rest: &mut &str, default: DVec2) -> DVec2 {
    let mut found = default;
    for axis in 0..3 {
        let (word, after) = next_word(rest);
        let Some(value) = word.parse::<f64>().ok().filter(|x| x.is_finite()) else {
            break;
        };
        if axis < 2 {
            found[axis] = value;
        }
        *rest = after;
    }
    found
}
