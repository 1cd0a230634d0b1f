//! What the page holds, and the page itself.

use super::base64::Packed;
use super::breaks::{LineOnPage, lines_of};
use super::surfaces::{PartOnPage, Surfaces, of_model, of_solution};
use crate::bad_input::BadInput;
use crate::pipeline::Solution;
use crate::quantity::{LUMINANCE_WEIGHTS, WHITE_EFFICACY};
use crate::render::{COLOUR_MAP, LightUnit, LitModel, frame_box, round_top};
use crate::scene::Camera;
use glam::DVec3;

/// Width over height for which the view of the whole scene is framed.
const ASPECT: f64 = 4.0 / 3.0;

/// The page around the data, in the order in which they follow each other.
const TEMPLATE: &str = include_str!("page.html");
pub(super) const SCRIPT: &str = include_str!("page.min.js");

/// The page of one lit scene.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Page {
    version: &'static str,
    source: String,
    /// World position of the local origin, metres; everything else is relative to it.
    origin: [f64; 3],
    bounds: [[f64; 3]; 2],
    cameras: Vec<CameraOnPage>,
    parts: Vec<PartOnPage>,
    positions: Packed,
    /// Linear `baseColor × COLOR_0`.
    colours: Packed,
    irradiance: Packed,
    triangles: Packed,
    /// Error at the middle of each triangle over the mean irradiance; none for a lit file.
    errors: Option<Packed>,
    lines: Vec<LineOnPage>,
    line_ends: Packed,
    colour_map: &'static [[u8; 3]],
    luminance_weights: [f64; 3],
    /// lm/W of white.
    efficacy: f64,
    irradiance_top: f64,
    lux_top: f64,
    /// Per cent of the mean.
    error_top: f64,
}

#[derive(Clone, Debug, serde::Serialize)]
struct CameraOnPage {
    name: String,
    eye: [f64; 3],
    forward: [f64; 3],
    up: [f64; 3],
    vertical_fov_rad: f64,
}

impl Page {
    /// Everything there is to see of a lit world: its light, its error, its lines and what made them.
    ///
    /// Illuminance is shown at `efficacy` lumens a watt ([`WHITE_EFFICACY`] when not stated).
    ///
    /// # Errors
    /// When nothing of the world is lit or seen.
    pub fn of_solution(solution: &Solution, efficacy: Option<f64>) -> Result<Self, BadInput> {
        let surfaces = of_solution(solution);
        let world = &solution.world.scene;
        let (lines, ends) = lines_of(solution, &surfaces.parts);
        let page = Self::new(
            &world.source,
            world.origin,
            surfaces,
            &world.cameras,
            efficacy,
        )?;
        Ok(Self {
            lines,
            line_ends: Packed::floats(ends),
            ..page
        })
    }

    /// What a lit file shows: its light. It holds neither lines nor errors.
    ///
    /// # Errors
    /// When the file is empty or does not state its exposure.
    pub fn of_model(model: &LitModel, efficacy: Option<f64>) -> Result<Self, BadInput> {
        let [low, high] = model.bounds().unwrap_or_default();
        let origin = low.midpoint(high);
        let surfaces = of_model(model, origin)?;
        Self::new(&model.source, origin, surfaces, &model.cameras, efficacy)
    }

    fn new(
        source: &str,
        origin: DVec3,
        surfaces: Surfaces,
        cameras: &[Camera],
        efficacy: Option<f64>,
    ) -> Result<Self, BadInput> {
        let bounds = surfaces.bounds().ok_or_else(|| {
            BadInput::new(
                source,
                "holds nothing to look at",
                "give a scene with surfaces",
            )
        })?;
        let efficacy = efficacy.unwrap_or(WHITE_EFFICACY);
        let mut views: Vec<CameraOnPage> = cameras.iter().map(|c| view(c, origin)).collect();
        let whole = Camera {
            name: "whole scene".to_owned(),
            ..frame_box(bounds, ASPECT)?
        };
        views.push(view(&whole, DVec3::ZERO));
        let top = |unit: LightUnit| {
            let light = surfaces.light.iter();
            round_top(light.map(|&(e, area)| (unit.of(e), area)))
        };
        let errors = surfaces.errors.iter().flatten();
        let areas = surfaces.areas.iter();
        Ok(Self {
            version: env!("CARGO_PKG_VERSION"),
            source: source.to_owned(),
            origin: origin.to_array(),
            bounds: bounds.map(|p| p.to_array()),
            cameras: views,
            irradiance_top: top(LightUnit::WattsPerSquareMetre),
            lux_top: top(LightUnit::Lux { efficacy }),
            error_top: round_top(errors.zip(areas).map(|(e, a)| (100.0 * e, *a))),
            parts: surfaces.parts,
            positions: triples(surfaces.positions.iter().copied()),
            colours: triples(surfaces.colours.iter().map(|c| c.0)),
            irradiance: triples(surfaces.irradiance.iter().map(|e| e.0.0)),
            triangles: Packed::indices(surfaces.triangles.into_iter().flatten()),
            errors: surfaces.errors.map(Packed::floats),
            lines: Vec::new(),
            line_ends: Packed::default(),
            colour_map: &COLOUR_MAP,
            luminance_weights: LUMINANCE_WEIGHTS.to_array(),
            efficacy,
        })
    }

    /// The page as one file; the same scene gives the same bytes.
    pub fn html(&self) -> String {
        let data = serde_json::to_string(self).expect("numbers, texts and lists are JSON");
        // No name in the scene may end the element that the data stand in.
        let data = data.replace('<', "\\u003c");
        let mut html = String::with_capacity(TEMPLATE.len() + SCRIPT.len() + data.len());
        for (i, piece) in TEMPLATE.split("<!-- here -->").enumerate() {
            html.push_str(match i {
                1 => &data,
                2 => SCRIPT,
                _ => "",
            });
            html.push_str(piece);
        }
        html
    }
}

fn triples(values: impl Iterator<Item = DVec3>) -> Packed {
    Packed::floats(values.flat_map(|v| v.to_array()))
}

fn view(camera: &Camera, origin: DVec3) -> CameraOnPage {
    CameraOnPage {
        name: camera.name.clone(),
        eye: (camera.eye - origin).to_array(),
        forward: camera.forward.to_array(),
        up: camera.up.to_array(),
        vertical_fov_rad: camera.vertical_fov_rad,
    }
}
