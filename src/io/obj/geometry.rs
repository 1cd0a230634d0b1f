//! The geometry of an OBJ file: one pass over its statements.

use super::NamedAt;
use super::text::{Statement, statements};
use crate::bad_input::BadInput;
use crate::io::index_u32;
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// Name of what stands before any `o` or `g`.
const UNNAMED: &str = "unnamed_object";

/// A corner as numbers of a position and, from 1, of texture coordinates and of a normal; 0 where there is none.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Corner {
    pub(super) position: u32,
    pub(super) uv: u32,
    pub(super) normal: u32,
}

/// A polygon of the file.
pub(super) struct Face {
    /// Its corners, of all that the file has.
    pub(super) corners: std::ops::Range<usize>,
    /// Index into [`Geometry::used`]; none before any `usemtl`.
    pub(super) material: Option<usize>,
    /// Index into [`Geometry::groups`].
    pub(super) group: u32,
    /// The line on which it starts, from 1.
    line: usize,
}

/// What the file says, in its order. Positions are all finite, and all corners name positions that are there.
#[derive(Default)]
pub(super) struct Geometry {
    pub(super) positions: Vec<DVec3>,
    /// Missing where the file has something else than two numbers.
    pub(super) uvs: Vec<Option<DVec2>>,
    /// Zero where the file has something else than a direction.
    pub(super) normals: Vec<DVec3>,
    pub(super) corners: Vec<Corner>,
    pub(super) faces: Vec<Face>,
    /// Names of objects and groups that have faces, each once.
    pub(super) groups: Vec<String>,
    pub(super) libraries: Vec<NamedAt>,
    /// Materials named by `usemtl`, each once, in the order of first use.
    pub(super) used: Vec<NamedAt>,
    /// Statements that hold points, lines, curves or curved surfaces.
    pub(super) without_area: usize,
    /// Faces with fewer than three corners.
    pub(super) dropped: usize,
}

/// What the statements before a face have set.
struct State {
    group: String,
    material: Option<usize>,
    group_of: HashMap<String, u32>,
    material_of: HashMap<String, usize>,
}

impl Geometry {
    /// Reads the statements of `text`; `place` is the file's name for messages.
    pub(super) fn read(text: &str, place: &str) -> Result<Self, BadInput> {
        let mut geometry = Self::default();
        let mut state = State {
            group: UNNAMED.to_owned(),
            material: None,
            group_of: HashMap::new(),
            material_of: HashMap::new(),
        };
        for statement in statements(text) {
            geometry.push(&statement, &mut state, place)?;
        }
        geometry.check_faces(place)?;
        Ok(geometry)
    }

    fn push(
        &mut self,
        statement: &Statement<'_>,
        state: &mut State,
        place: &str,
    ) -> Result<(), BadInput> {
        let at = || format!("{place}:{}", statement.number);
        let rest = statement.rest();
        match statement.keyword() {
            "v" => {
                let remedy = "write three finite numbers after v";
                let position = position(statement).map_err(|e| BadInput::new(at(), e, remedy))?;
                self.positions.push(position);
            }
            // No light stops for mistakes in these: the face is shown without texture, or flat.
            "vt" => {
                let n = numbers::<2>(statement).or(numbers::<1>(statement).map(|[u]| [u, 0.0]));
                self.uvs.push(n.map(DVec2::from));
            }
            "vn" => {
                let direction =
                    numbers::<3>(statement).and_then(|n| DVec3::from(n).try_normalize());
                self.normals.push(direction.unwrap_or(DVec3::ZERO));
            }
            "f" | "fo" => {
                let remedy = "let each corner of a face name a vertex of the file";
                self.push_face(statement, state, place)
                    .map_err(|e| BadInput::new(at(), e, remedy))?;
            }
            "o" | "g" => {
                let name = if rest.is_empty() { UNNAMED } else { rest };
                state.group = name.to_owned();
            }
            "usemtl" if rest.is_empty() => {
                return Err(BadInput::new(
                    at(),
                    "usemtl without a name",
                    "name a material",
                ));
            }
            "usemtl" => {
                let next = self.used.len();
                let index = *state.material_of.entry(rest.to_owned()).or_insert(next);
                if index == next {
                    self.used.push(NamedAt::new(rest, at()));
                }
                state.material = Some(index);
            }
            "mtllib" => self.libraries.push(NamedAt::new(rest, at())),
            "p" | "l" | "curv" | "curv2" | "surf" => self.without_area += 1,
            _ => {}
        }
        Ok(())
    }

    fn push_face(
        &mut self,
        statement: &Statement<'_>,
        state: &mut State,
        place: &str,
    ) -> Result<(), String> {
        let first = self.corners.len();
        for word in statement.values() {
            let corner = self.corner(word)?;
            self.corners.push(corner);
        }
        if self.corners.len() - first < 3 {
            self.corners.truncate(first);
            self.dropped += 1;
            return Ok(());
        }
        let group = match state.group_of.get(&state.group) {
            Some(&group) => group,
            None => {
                let group = index_u32(self.groups.len(), place).map_err(|e| e.what)?;
                self.groups.push(state.group.clone());
                state.group_of.insert(state.group.clone(), group);
                group
            }
        };
        self.faces.push(Face {
            corners: first..self.corners.len(),
            material: state.material,
            group,
            line: statement.number,
        });
        Ok(())
    }

    /// A corner `v`, `v/vt`, `v//vn` or `v/vt/vn`; negative numbers count back from the last definition so far. Positions
    /// may be defined further down, so that their upper limit is checked at the end.
    fn corner(&self, word: &str) -> Result<Corner, String> {
        let mut parts = word.split('/');
        let index: i128 = parts
            .next()
            .and_then(|part| part.parse().ok())
            .ok_or_else(|| format!("face corner \"{word}\" is not an index"))?;
        let known = self.positions.len();
        let position = from_start(index, known)
            .and_then(|i| u32::try_from(i).ok())
            .ok_or_else(|| format!("face corner {index} is out of range ({known} vertices)"))?;
        let mut other = |known: usize| match parts.next() {
            None | Some("") => Ok(0),
            Some(part) => match part.parse::<i128>() {
                // One out of range is as none: no light stops for it.
                Ok(index) => Ok(from_start(index, known)
                    .and_then(|i| u32::try_from(i + 1).ok())
                    .unwrap_or(0)),
                Err(_) => Err(()),
            },
        };
        let found = other(self.uvs.len()).and_then(|uv| Ok((uv, other(self.normals.len())?)));
        match (found, parts.next()) {
            (Ok((uv, normal)), None) => Ok(Corner {
                position,
                uv,
                normal,
            }),
            _ => Err(format!(
                "face corner \"{word}\" is not v, v/vt, v//vn or v/vt/vn"
            )),
        }
    }

    fn check_faces(&self, place: &str) -> Result<(), BadInput> {
        let known = self.positions.len();
        for face in &self.faces {
            let corners = &self.corners[face.corners.clone()];
            if let Some(bad) = corners.iter().find(|c| c.position as usize >= known) {
                let index = u64::from(bad.position) + 1;
                return Err(BadInput::new(
                    format!("{place}:{}", face.line),
                    format!("face corner {index} is out of range ({known} vertices)"),
                    "let each corner of a face name a vertex of the file",
                ));
            }
        }
        Ok(())
    }
}

/// Number from 0 of what the file calls `index`, from 1 or, backwards, from −1; `known` are defined so far.
fn from_start(index: i128, known: usize) -> Option<usize> {
    match index {
        0 => None,
        1.. => usize::try_from(index - 1).ok(),
        _ => usize::try_from(known as i128 + index).ok(),
    }
}

/// The first `N` values, if they are finite numbers.
fn numbers<const N: usize>(statement: &Statement<'_>) -> Option<[f64; N]> {
    let mut values = statement.values();
    let mut found = [0.0; N];
    for slot in &mut found {
        *slot = values
            .next()?
            .parse()
            .ok()
            .filter(|x: &f64| x.is_finite())?;
    }
    Some(found)
}

/// A fourth number is the weight of a curve's control point, further ones are colours.
fn position(statement: &Statement<'_>) -> Result<DVec3, String> {
    let mut found = [0.0; 3];
    let mut count = 0;
    for (slot, word) in found.iter_mut().zip(statement.values()) {
        *slot = match word.parse::<f64>() {
            Ok(value) if value.is_finite() => value,
            Ok(value) => return Err(format!("vertex coordinate {value} is not finite")),
            Err(_) => return Err(format!("vertex coordinate \"{word}\" is not a number")),
        };
        count += 1;
    }
    if count < 3 {
        return Err(format!("vertex has {count} coordinates"));
    }
    Ok(found.into())
}
