//! `umbrage compare`: are two pictures the same?

use super::{Outcome, options, terminal};
use clap::Args as ClapArgs;
use serde_json::json;
use std::path::{Path, PathBuf};
use umbrage::bad_input::BadInput;
use umbrage::compare::{
    PictureDifference, PictureTolerance, SMALLEST_SEEN, compare, difference_picture,
    perceptual_score,
};
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
    /// Least SSIMULACRA 2 score that is allowed: 100 the same picture, 90 hardly told apart, 70 high quality; not checked
    /// when left out
    #[arg(long, value_name = "SCORE", allow_negative_numbers = true)]
    min_score: Option<f64>,
    /// Writes the figures for machines
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Writes a picture of the differences: blue within the tolerance, red to white beyond it
    #[arg(long, value_name = "OUT.png")]
    diff: Option<PathBuf>,
    /// Says nothing but errors
    #[arg(long)]
    quiet: bool,
}

pub(super) fn run(args: &CompareArgs) -> anyhow::Result<Outcome> {
    let outputs: Vec<&Path> = [&args.diff, &args.json]
        .into_iter()
        .flatten()
        .map(PathBuf::as_path)
        .collect();
    options::check_distinct(&[&args.a, &args.b], &outputs)?;
    if args.min_score.is_some_and(|s| !s.is_finite() || s > 100.0) {
        return Err(BadInput::new(
            "--min-score",
            "no picture has such a score",
            "give a number up to 100, for example 90",
        )
        .into());
    }
    let (a, b) = (read(&args.a)?, read(&args.b)?);
    let tolerance = PictureTolerance {
        max_error: args.max_error,
        mean_error: args.mean_error,
    };
    let found = compare(&a, &b, &tolerance)?;
    let score = perceptual_score(&a, &b)?;
    if args.min_score.is_some() && score.is_none() {
        return Err(BadInput::new(
            "--min-score",
            format!(
                "pictures of {} × {} pixels have no score",
                a.width, a.height
            ),
            format!("compare pictures of {SMALLEST_SEEN} pixels or more each way"),
        )
        .into());
    }
    let is_same = found.is_within && args.min_score.is_none_or(|least| score >= Some(least));
    if let Some(path) = &args.diff {
        let picture = difference_picture(&a, &b, args.max_error)?;
        write_atomically(path, &write_png(&picture))?;
    }
    if let Some(path) = &args.json {
        write_atomically(path, json(args, &found, score, is_same).as_bytes())?;
    }
    if !args.quiet {
        terminal::print(&table(args, &found, score, is_same))?;
    }
    Ok(match is_same {
        true => Outcome::Done,
        false => Outcome::CheckFailed,
    })
}

fn table(
    args: &CompareArgs,
    found: &PictureDifference,
    score: Option<f64>,
    is_same: bool,
) -> String {
    let score = score.map_or_else(|| "-".to_owned(), |s| format!("{s:.2}"));
    let least = match args.min_score {
        Some(least) => format!("  (at least {least})"),
        None => String::new(),
    };
    format!(
        "max error   {:>8}  (allowed {})\nmean error  {:>8.4}  (allowed {})\nrms error   {:>8.4}\nssimulacra2 {score:>8}{least}\npixels      {:>8}  ({} beyond the max error)\n{}\n",
        found.max_error,
        args.max_error,
        found.mean_error,
        args.mean_error,
        found.rms_error,
        found.pixels,
        found.pixels_beyond,
        if is_same {
            "same picture"
        } else {
            "different pictures"
        },
    )
}

fn json(
    args: &CompareArgs,
    found: &PictureDifference,
    score: Option<f64>,
    is_same: bool,
) -> String {
    let value = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "command": "compare",
        "a": args.a.display().to_string(),
        "b": args.b.display().to_string(),
        "difference": found,
        "ssimulacra2": score,
        "allowed": {
            "max_error": args.max_error,
            "mean_error": args.mean_error,
            "min_score": args.min_score,
        },
        "is_same": is_same,
    });
    format!("{value:#}\n")
}

fn read(path: &Path) -> anyhow::Result<Picture> {
    let bytes = options::read_file(path)?;
    Ok(read_png(&path.display().to_string(), &bytes)?)
}
