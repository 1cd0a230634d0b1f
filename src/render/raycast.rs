//! The flat view of a lit model: one fixed pattern of rays a pixel, nothing random.

use super::raster::{Raster, Rays, Row, Side};
use super::surface::Surfaces;
use super::{Image, LitModel};
use crate::bad_input::BadInput;
use crate::quantity::Rgb;
use crate::scene::Camera;
use crate::texture::TextureMean;
use crate::visibility::Hit;
use glam::DVec3;
use rayon::prelude::*;

/// Largest width or height of a picture, pixels: what PNG readers and graphics cards agree on.
pub const MAX_SIZE: u32 = 16384;

/// Most rays along one side of a pixel: 256 rays a pixel tell all 8-bit steps of an edge apart.
pub const MAX_SUPERSAMPLE: u32 = 16;

/// A ray meets a cut-out texture where at least this share of its footprint is there.
const THERE_FROM: f64 = 0.5;

/// How a picture is taken.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Width, pixels, 1…[`MAX_SIZE`].
    pub width: u32,
    /// Height, pixels, 1…[`MAX_SIZE`].
    pub height: u32,
    /// The camera. Its vertical field of view fills the height; its aspect gives way to that of the picture.
    pub camera: Camera,
    /// Rays along each side of a pixel, 1…[`MAX_SUPERSAMPLE`]: the pixel is the mean over a regular `n × n` grid.
    pub supersample: u32,
    /// Linear colour where no surface is.
    pub background: Rgb,
}

impl RenderSettings {
    /// Settings for `camera` with 2 × 2 rays a pixel over black.
    pub fn new(width: u32, height: u32, camera: Camera) -> Self {
        Self {
            width,
            height,
            camera,
            supersample: 2,
            background: Rgb::BLACK,
        }
    }

    fn check(&self) -> Result<(), BadInput> {
        let size = 1..=MAX_SIZE;
        if !(size.contains(&self.width) && size.contains(&self.height)) {
            return Err(BadInput::new(
                "picture",
                format!("{} × {} pixels are asked for", self.width, self.height),
                format!("choose 1 to {MAX_SIZE} for each"),
            ));
        }
        if !(1..=MAX_SUPERSAMPLE).contains(&self.supersample) {
            return Err(BadInput::new(
                "picture",
                format!(
                    "{} rays along each side of a pixel are asked for",
                    self.supersample
                ),
                format!("choose 1 to {MAX_SUPERSAMPLE}"),
            ));
        }
        Ok(())
    }
}

/// The picture of `model`, linear: `baseColor × COLOR_0` of the nearest front, interpolated over its triangle.
///
/// Backs of single-sided materials are looked through. The same input gives the same pixels on any number of threads.
pub fn render(model: &LitModel, settings: &RenderSettings) -> Result<Image, BadInput> {
    settings.check()?;
    let view = View::new(model, settings);
    let rows: Vec<Vec<Rgb>> = (0..settings.height)
        .into_par_iter()
        .map_init(Row::default, |found, y| view.row(y, found))
        .collect();
    Ok(Image {
        width: settings.width,
        height: settings.height,
        pixels: rows.concat(),
    })
}

/// A model ready to be looked at.
struct View<'a> {
    settings: &'a RenderSettings,
    raster: Raster,
    model: &'a LitModel,
    surfaces: Surfaces,
    /// Part and corners of each triangle of the raster.
    triangles: Vec<(usize, [u32; 3])>,
}

impl<'a> View<'a> {
    fn new(model: &'a LitModel, settings: &'a RenderSettings) -> Self {
        let triangles: Vec<_> = model
            .parts
            .iter()
            .enumerate()
            .flat_map(|(i, part)| part.triangles.iter().map(move |&corners| (i, corners)))
            .collect();
        let seen = triangles.iter().map(|&(part, corners)| {
            let part = &model.parts[part];
            let side = Side {
                is_double: part.is_double_sided,
                is_cut_out: part.cut_off.is_some(),
            };
            (corners.map(|i| part.positions[i as usize]), side)
        });
        Self {
            settings,
            model,
            surfaces: Surfaces::new(model),
            raster: Raster::new(rays(settings), seen),
            triangles,
        }
    }

    /// The pixels of row `y`: each the mean over its rays.
    fn row(&self, y: u32, found: &mut Row) -> Vec<Rgb> {
        let n = self.settings.supersample;
        let is_there = |hit: &Hit, dir| {
            self.texture(hit, dir)
                .is_none_or(|t| t.coverage >= THERE_FROM)
        };
        let mut pixels = vec![Rgb::BLACK; self.settings.width as usize];
        for row in y * n..(y + 1) * n {
            self.raster.draw(row, is_there, found);
            for (x, pixel) in (0..).zip(&mut pixels) {
                for column in x * n..(x + 1) * n {
                    let hit = self.raster.hit(found, column, row);
                    *pixel += hit.map_or(self.settings.background, |(h, d)| self.colour(&h, d));
                }
            }
        }
        let share = 1.0 / f64::from(n * n);
        pixels.into_iter().map(|sum| sum * share).collect()
    }

    /// What the texture shows at a hit, if there is one.
    fn texture(&self, hit: &Hit, dir: DVec3) -> Option<TextureMean> {
        let (index, corners) = self.triangles[hit.triangle as usize];
        if !self.surfaces.is_textured(index) {
            return None;
        }
        let part = &self.model.parts[index];
        let [p, q, r] = corners.map(|i| part.positions[i as usize]);
        let slant = (q - p).cross(r - p).normalize().dot(dir.normalize()).abs();
        // The square that one ray stands for, at distance 1 and where it hits.
        let rays = f64::from(self.settings.height) * f64::from(self.settings.supersample);
        let side = 2.0 * self.raster.rays().half_up.length() / rays * hit.t;
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        self.surfaces
            .look_up((index, part), corners, weights, side * side / slant)
    }

    fn colour(&self, hit: &Hit, dir: DVec3) -> Rgb {
        let (index, corners) = self.triangles[hit.triangle as usize];
        let part = &self.model.parts[index];
        let [a, b, c] = corners.map(|i| part.colours[i as usize]);
        (a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v)
            * Surfaces::colour(part, self.texture(hit, dir))
    }
}

/// All rays that `settings` ask for.
fn rays(settings: &RenderSettings) -> Rays {
    let camera = &settings.camera;
    let slope = (camera.vertical_fov_rad / 2.0).tan();
    let aspect = f64::from(settings.width) / f64::from(settings.height);
    Rays {
        eye: camera.eye,
        columns: settings.width * settings.supersample,
        rows: settings.height * settings.supersample,
        forward: camera.forward,
        half_right: camera.forward.cross(camera.up) * (slope * aspect),
        half_up: camera.up * slope,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;
    use crate::render::{CameraChoice, LitPart, choose_camera};

    /// A quad 2 × 2 at height `z`, seen from +z, red on the left to blue on the right.
    fn quad(z: f64) -> LitPart {
        let (red, blue) = (Rgb::new(1.0, 0.0, 0.0), Rgb::new(0.0, 0.0, 1.0));
        let at = |x, y| DVec3::new(x, y, z);
        LitPart {
            base_colour: Rgb::grey(0.5),
            positions: vec![at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)],
            normals: vec![DVec3::Z; 4],
            colours: vec![red, blue, blue, red],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Default::default()
        }
    }

    fn picture(parts: Vec<LitPart>, eye: DVec3, size: [u32; 2]) -> Image {
        let model = LitModel {
            parts,
            ..Default::default()
        };
        // At distance 2 the half-angle with tangent 1/2 sees exactly the quad.
        let look = CameraChoice::LookAt {
            eye,
            target: DVec3::ZERO,
            up: None,
            vertical_fov_rad: Some(2.0 * 0.5f64.atan()),
        };
        let camera = choose_camera(&look, &model, 1.0).unwrap();
        render(&model, &RenderSettings::new(size[0], size[1], camera)).unwrap()
    }

    #[test]
    fn a_quad_that_fills_the_picture_shows_its_colours_where_they_are() {
        let image = picture(vec![quad(0.0)], DVec3::Z * 2.0, [8, 4]);
        for (i, pixel) in image.pixels.iter().enumerate() {
            // Twice as wide as high: the quad fills the middle half of each row.
            let x = i % 8;
            let right = (x as f64 - 1.5) / 4.0;
            let expected = if (2..6).contains(&x) {
                DVec3::new(1.0 - right, 0.0, right) * 0.5
            } else {
                DVec3::ZERO
            };
            assert!(pixel.0.distance(expected) < 1e-12, "{x}: {pixel:?}");
        }
        // sRGB of 0.4375, 0 and 0.0625.
        assert_eq!(image.to_srgb().pixels[2], [177, 0, 71]);
    }

    #[test]
    fn the_number_of_threads_changes_nothing() {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let take = || picture(vec![quad(0.0)], DVec3::new(0.3, 0.7, 2.0), [31, 17]);
            pool.unwrap().install(take)
        };
        assert_eq!(on(1), on(4));
    }

    #[test]
    fn up_is_up() {
        let mut part = quad(0.0);
        part.colours = vec![Rgb::BLACK, Rgb::BLACK, Rgb::grey(1.0), Rgb::grey(1.0)];
        let image = picture(vec![part], DVec3::Z * 2.0, [1, 2]);
        assert!(image.pixels[0].mean() > image.pixels[1].mean());
    }

    #[test]
    fn backs_are_looked_through_unless_double_sided() {
        let behind = |is_double_sided| {
            let mut near = quad(1.0);
            near.base_colour = Rgb::BLACK;
            near.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            near.is_double_sided = is_double_sided;
            picture(vec![near, quad(0.0)], DVec3::Z * 2.0, [1, 1]).pixels[0]
        };
        assert!(behind(true).is_black());
        assert!((behind(false).mean() - 0.5 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn two_sides_in_one_place_show_the_one_that_faces_the_camera() {
        let mut back = quad(0.0);
        back.base_colour = Rgb::BLACK;
        back.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let parts = vec![back, quad(0.0)];
        let from_front = picture(parts.clone(), DVec3::Z * 2.0, [1, 1]);
        let from_back = picture(parts, DVec3::Z * -2.0, [1, 1]);
        assert!(!from_front.pixels[0].is_black());
        assert!(from_back.pixels[0].is_black());
    }

    #[test]
    fn sizes_that_no_file_can_hold_are_refused() {
        let camera = choose_camera(
            &CameraChoice::LookAt {
                eye: DVec3::Z,
                target: DVec3::ZERO,
                up: None,
                vertical_fov_rad: None,
            },
            &LitModel::default(),
            1.0,
        )
        .unwrap();
        let size = |width, height, supersample| RenderSettings {
            supersample,
            ..RenderSettings::new(width, height, camera.clone())
        };
        for bad in [
            size(0, 4, 1),
            size(4, 20000, 1),
            size(4, 4, 0),
            size(4, 4, 17),
        ] {
            assert!(render(&LitModel::default(), &bad).is_err());
        }
        let empty = render(&LitModel::default(), &size(2, 3, 1)).unwrap();
        assert_eq!(empty.pixels, vec![Rgb::BLACK; 6]);
    }
}
