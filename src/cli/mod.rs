//! The command line: arguments as typed, checked options, and one file for each command.

mod args;
mod bake;
mod options;
mod progress;

pub(crate) use args::Args;

use crate::cli::args::Command;
use std::process::ExitCode;

/// How a command ended, short of bad input.
pub(crate) enum Outcome {
    /// Done.
    Done,
}

/// Runs the command; the exit code is decided here and nowhere else: 0 done, 1 a check failed, 2 bad input or use.
pub(crate) fn run(args: Args) -> ExitCode {
    let result = match args.command {
        Command::Bake(a) => bake::run(&a),
    };
    match result {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}
