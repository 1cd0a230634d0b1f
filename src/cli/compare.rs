//! `umbrage compare`: are two pictures the same?

use super::{Outcome, options, terminal};
use clap::Args as ClapArgs;
use std::path::{Path, PathBuf};
use umbrage::compare::{PictureTolerance, compare, difference_picture};
use umbrage::io::{read_png, write_atomically, write_png};
use umbrage::render::Picture;

#[derive(Debug, ClapArgs)]
pub(super) struct CompareArgs {
    /// The one picture
    #[arg(value_name = "A.png")]
    a: PathBuf,
    /// The other one
    #[arg(value_name = "B.png")]
    b: PathBuf,
    /// Largest difference of a channel that is allowed, in steps of 0 to 255
    #[arg(long, value_name = "N", default_value_t = PictureTolerance::default().max_error)]
    max_error: f64,
    /// Mean difference over all channels that is allowed, in steps of 0 to 255
    #[arg(long, value_name = "N", default_value_t = PictureTolerance::default().mean_error)]
    mean_error: f64,
    /// Writes a picture of the differences: blue within the tolerance, red to white beyond it
    #[arg(long, value_name = "OUT.png")]
    diff: Option<PathBuf>,
    /// Says nothing but errors
    #[arg(long)]
    quiet: bool,
}

pub(super) fn run(args: &CompareArgs) -> anyhow::Result<Outcome> {
    let outputs: Vec<&Path> = args.diff.iter().map(PathBuf::as_path).collect();
    options::check_distinct(&[&args.a, &args.b], &outputs)?;
    let (a, b) = (read(&args.a)?, read(&args.b)?);
    let tolerance = PictureTolerance {
        max_error: args.max_error,
        mean_error: args.mean_error,
    };
    let found = compare(&a, &b, &tolerance)?;
    if let Some(path) = &args.diff {
        let picture = difference_picture(&a, &b, args.max_error)?;
        write_atomically(path, &write_png(&picture))?;
    }
    if !args.quiet {
        terminal::print(&format!(
            "max error   {:>8}  (allowed {})\nmean error  {:>8.4}  (allowed {})\nrms error   {:>8.4}\npixels      {:>8}  ({} beyond the max error)\n{}\n",
            found.max_error,
            args.max_error,
            found.mean_error,
            args.mean_error,
            found.rms_error,
            found.pixels,
            found.pixels_beyond,
            if found.is_within {
                "same picture"
            } else {
                "different pictures"
            },
        ))?;
    }
    Ok(if found.is_within {
        Outcome::Done
    } else {
        Outcome::CheckFailed
    })
}

fn read(path: &Path) -> anyhow::Result<Picture> {
    let bytes = options::read_file(path)?;
    Ok(read_png(&path.display().to_string(), &bytes)?)
}
