//! `umbrage render`: a picture of a lit glTF.

use super::options::{self, PictureSize};
use super::picture::{self, FieldOfView, Lens};
use super::{Outcome, terminal};
use clap::Args as ClapArgs;
use glam::DVec3;
use std::path::PathBuf;
use umbrage::io::{read_lit, write_atomically, write_png};
use umbrage::quantity::WHITE_EFFICACY;
use umbrage::render::{CameraChoice, ColourScale, LightUnit, LitModel, round_top};

#[derive(Debug, ClapArgs)]
pub(super) struct RenderArgs {
    /// What `umbrage bake` wrote
    #[arg(value_name = "LIT.glb")]
    lit: PathBuf,
    /// The picture
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    /// Pixels; 600 along the longer side when left out
    #[arg(long, value_name = "WxH", value_parser = options::picture_size)]
    size: Option<PictureSize>,
    /// A camera of the file, by name or by index from 0; the first one when left out
    #[arg(long, value_name = "NAME|INDEX", conflicts_with = "eye")]
    camera: Option<String>,
    /// Where the camera stands, metres
    #[arg(long, value_name = "x,y,z", requires = "target", allow_hyphen_values = true, value_parser = options::vector)]
    eye: Option<DVec3>,
    /// What stands in the middle of the picture, metres
    #[arg(long, value_name = "x,y,z", requires = "eye", allow_hyphen_values = true, value_parser = options::vector)]
    target: Option<DVec3>,
    /// Which way is up in the picture; +y when left out
    #[arg(long, value_name = "x,y,z", requires = "eye", allow_hyphen_values = true, value_parser = options::vector)]
    up: Option<DVec3>,
    /// Field of view from top to bottom, degrees; the camera's own, or 40, when left out
    #[arg(long, value_name = "DEGREES", conflicts_with = "hfov", value_parser = options::angle)]
    fov: Option<f64>,
    /// Field of view from left to right, degrees
    #[arg(long, value_name = "DEGREES", value_parser = options::angle)]
    hfov: Option<f64>,
    /// Rays along each side of a pixel, 1 to 16
    #[arg(long, value_name = "N", default_value_t = 2)]
    supersample: u32,
    /// The light that arrives at the surfaces as colours, W/m² (mean of the channels), with its scale below the picture
    #[arg(long)]
    false_colour: bool,
    /// Illuminance in lux instead of W/m²
    #[arg(long, requires = "false_colour")]
    lux: bool,
    /// Lumens a watt of white, for --lux
    #[arg(long, value_name = "LM/W", requires = "lux", value_parser = options::efficacy)]
    efficacy: Option<f64>,
    /// End of the scale of --false-colour; a round number that at most 3 % of the area exceed when left out
    #[arg(long, value_name = "VALUE", requires = "false_colour", value_parser = options::positive)]
    scale: Option<f64>,
    /// Threads; all processors when left out
    #[arg(long)]
    threads: Option<usize>,
    /// Says nothing but errors
    #[arg(long)]
    quiet: bool,
}

pub(super) fn run(args: &RenderArgs) -> anyhow::Result<Outcome> {
    options::use_threads(args.threads)?;
    options::check_distinct(&[&args.lit], &[&args.output])?;
    let model = read_lit(
        &args.lit.display().to_string(),
        &options::read_file(&args.lit)?,
    )?;
    let choice = match (args.eye.zip(args.target), &args.camera) {
        (Some((eye, target)), _) => CameraChoice::LookAt {
            eye,
            target,
            up: args.up,
            vertical_fov_rad: None,
        },
        (None, Some(name)) => CameraChoice::Named(name.clone()),
        (None, None) => CameraChoice::Auto,
    };
    let vertical = args.fov.map(FieldOfView::Vertical);
    let lens = Lens {
        field_of_view: vertical.or(args.hfov.map(FieldOfView::Horizontal)),
        supersample: Some(args.supersample),
    };
    let scale = args.false_colour.then(|| scale(args, &model));
    let picture = picture::take(&model, &choice, args.size, Some(lens), scale.as_ref())?;
    let png = write_png(&picture);
    write_atomically(&args.output, &png)?;
    if !args.quiet {
        let mut text = options::written(&args.output, png.len());
        if let Some(scale) = scale {
            text.push_str(&told(&scale));
        }
        terminal::print(&text)?;
    }
    Ok(Outcome::Done)
}

/// The scale that was asked for, or one that fits the model.
fn scale(args: &RenderArgs, model: &LitModel) -> ColourScale {
    let unit = if args.lux {
        LightUnit::Lux {
            efficacy: args.efficacy.unwrap_or(WHITE_EFFICACY),
        }
    } else {
        LightUnit::WattsPerSquareMetre
    };
    let top = args.scale.unwrap_or_else(|| {
        let light = model.triangle_light();
        round_top(light.into_iter().map(|(e, area)| (unit.of(e), area)))
    });
    ColourScale { unit, top }
}

/// What the colours stand for.
fn told(scale: &ColourScale) -> String {
    let (top, unit) = (scale.top, scale.unit.name());
    match scale.unit {
        LightUnit::WattsPerSquareMetre => {
            format!("scale        0 to {top} {unit}, mean of the channels\n")
        }
        LightUnit::Lux { efficacy } => {
            format!("scale        0 to {top} {unit}, at {efficacy} lm/W of white\n")
        }
    }
}
