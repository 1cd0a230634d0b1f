//! A minimal reader of OBJ and MTL, independent of the library's: positions, convex polygons, `Kd` and `Ke`.

use glam::DVec3;
use std::collections::BTreeMap;
use std::path::Path;

/// A diffuse material.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Surface {
    /// Name in the file.
    pub(crate) name: String,
    /// Reflectance of both sides, red, green, blue.
    pub(crate) kd: DVec3,
    /// Radiance of the front, W/(m² sr).
    pub(crate) ke: DVec3,
}

/// A convex polygon, counter-clockwise seen from its front.
#[derive(Clone, Debug)]
pub(crate) struct Polygon {
    /// Its corners.
    pub(crate) corners: Vec<DVec3>,
    /// Its material, an index into [`ObjMesh::surfaces`].
    pub(crate) surface: usize,
    /// The object that it belongs to (`o`).
    pub(crate) object: String,
}

impl Polygon {
    /// Unit normal of the front (Newell's sum).
    pub(crate) fn normal(&self) -> DVec3 {
        self.area_vector().normalize()
    }

    /// Area in m².
    pub(crate) fn area(&self) -> f64 {
        self.area_vector().length()
    }

    /// Mean of the corners.
    pub(crate) fn centre(&self) -> DVec3 {
        let first = self.corners[0];
        let sum: DVec3 = self.corners.iter().map(|&c| c - first).sum();
        first + sum / self.corners.len() as f64
    }

    fn area_vector(&self) -> DVec3 {
        let [first, rest @ ..] = self.corners.as_slice() else {
            return DVec3::ZERO;
        };
        rest.windows(2)
            .map(|w| (w[0] - *first).cross(w[1] - *first) / 2.0)
            .sum()
    }
}

/// A triangle of a polygon's fan.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    /// Corners, counter-clockwise seen from the front.
    pub(crate) corners: [DVec3; 3],
    /// Reflectance of both sides.
    pub(crate) kd: DVec3,
    /// Radiance of the front, W/(m² sr).
    pub(crate) ke: DVec3,
}

/// A scene as its file says.
#[derive(Clone, Debug, Default)]
pub(crate) struct ObjMesh {
    /// All polygons, in the order of the file.
    pub(crate) polygons: Vec<Polygon>,
    /// All materials.
    pub(crate) surfaces: Vec<Surface>,
}

impl ObjMesh {
    /// Reads an OBJ file and the MTL files that it names. Panics with the file and line on whatever it cannot read.
    pub(crate) fn read(path: &Path) -> Self {
        let mut mesh = Self::default();
        let mut by_name = BTreeMap::new();
        let (mut positions, mut object, mut surface) = (Vec::new(), String::new(), None);
        for (number, line) in lines(path).into_iter().enumerate() {
            let at = || format!("{}:{}", path.display(), number + 1);
            let words: Vec<&str> = line.split_whitespace().collect();
            match words.as_slice() {
                ["v", x, y, z] => positions.push(vector([x, y, z], &at)),
                ["o" | "g", name] => object = (*name).to_owned(),
                ["mtllib", file] => {
                    let directory = path.parent().expect("a file has a directory");
                    mesh.read_materials(&directory.join(file), &mut by_name);
                }
                ["usemtl", name] => {
                    surface = Some(
                        *by_name
                            .get(*name)
                            .unwrap_or_else(|| panic!("{}: no material {name}", at())),
                    );
                }
                ["f", corners @ ..] => mesh.polygons.push(Polygon {
                    corners: corners
                        .iter()
                        .map(|c| positions[index(c, positions.len(), &at)])
                        .collect(),
                    surface: surface.unwrap_or_else(|| panic!("{}: a face before usemtl", at())),
                    object: object.clone(),
                }),
                [] => {}
                [word, ..] if word.starts_with('#') || ["vn", "vt", "s"].contains(word) => {}
                _ => panic!("{}: cannot read: {line}", at()),
            }
        }
        mesh
    }

    fn read_materials(&mut self, path: &Path, by_name: &mut BTreeMap<String, usize>) {
        for (number, line) in lines(path).into_iter().enumerate() {
            let at = || format!("{}:{}", path.display(), number + 1);
            let words: Vec<&str> = line.split_whitespace().collect();
            match words.as_slice() {
                ["newmtl", name] => {
                    by_name.insert((*name).to_owned(), self.surfaces.len());
                    self.surfaces.push(Surface {
                        name: (*name).to_owned(),
                        kd: DVec3::ZERO,
                        ke: DVec3::ZERO,
                    });
                }
                [key @ ("Kd" | "Ke"), r, g, b] => {
                    let value = vector([r, g, b], &at);
                    let last = self
                        .surfaces
                        .last_mut()
                        .unwrap_or_else(|| panic!("{}: {key} before newmtl", at()));
                    *(if *key == "Kd" {
                        &mut last.kd
                    } else {
                        &mut last.ke
                    }) = value;
                }
                _ => {}
            }
        }
    }

    /// The material of a polygon.
    pub(crate) fn surface_of(&self, polygon: usize) -> &Surface {
        &self.surfaces[self.polygons[polygon].surface]
    }

    /// Every polygon as a fan of triangles.
    pub(crate) fn triangles(&self) -> Vec<Triangle> {
        let mut triangles = Vec::new();
        for (i, polygon) in self.polygons.iter().enumerate() {
            let Surface { kd, ke, .. } = *self.surface_of(i);
            triangles.extend(polygon.corners[1..].windows(2).map(|w| Triangle {
                corners: [polygon.corners[0], w[0], w[1]],
                kd,
                ke,
            }));
        }
        triangles
    }

    /// The box around all corners: least and greatest coordinates.
    pub(crate) fn bounds(&self) -> (DVec3, DVec3) {
        let corners = self.polygons.iter().flat_map(|p| &p.corners);
        corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &c| {
            (low.min(c), high.max(c))
        })
    }

    /// Adds a polygon of its own material, for scenes that a test makes up.
    pub(crate) fn add(&mut self, corners: &[[f64; 3]], kd: f64, ke: f64) {
        self.surfaces.push(Surface {
            name: format!("material {}", self.surfaces.len()),
            kd: DVec3::splat(kd),
            ke: DVec3::splat(ke),
        });
        self.polygons.push(Polygon {
            corners: corners.iter().map(|&c| DVec3::from(c)).collect(),
            surface: self.surfaces.len() - 1,
            object: String::new(),
        });
    }
}

fn lines(path: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(path)
        .unwrap_or_else(|e| panic!("{}: cannot be read: {e}", path.display()));
    text.lines().map(str::to_owned).collect()
}

fn vector(words: [&&str; 3], at: &dyn Fn() -> String) -> DVec3 {
    let parse = |w: &str| -> f64 {
        w.parse()
            .unwrap_or_else(|_| panic!("{}: not a number: {w}", at()))
    };
    DVec3::from(words.map(|w| parse(w)))
}

/// The position that `corner` (`7`, `7/1/2`, `-1`) of a face means.
fn index(corner: &str, count: usize, at: &dyn Fn() -> String) -> usize {
    let first = corner.split('/').next().unwrap_or_default();
    let number: i64 = first
        .parse()
        .unwrap_or_else(|_| panic!("{}: not an index: {corner}", at()));
    let zero_based = if number < 0 {
        count as i64 + number
    } else {
        number - 1
    };
    usize::try_from(zero_based)
        .ok()
        .filter(|&i| i < count)
        .unwrap_or_else(|| panic!("{}: no position {corner}", at()))
}
