//! The command line: arguments as typed, checked options, and one file for each command.

mod args;
mod bake;
mod compare;
mod faces;
mod fault;
mod inspect;
mod interrupt;
mod lighting;
mod memory;
mod options;
mod picture;
mod probe;
mod progress;
mod render;
mod report;
mod table;
mod terminal;
mod usage;

use args::{Args, Command};
use clap::Parser;
use std::process::ExitCode;
use umbrage::pipeline::LightError;

/// How a command ended, short of an error.
enum Outcome {
    /// Done.
    Done,
    /// The work was done, and failed the check that was asked for.
    CheckFailed,
}

/// Exit codes; README.md lists them.
const FAILED: u8 = 1;
const BAD_INPUT: u8 = 2;

/// Runs the program. Exit codes are decided here and nowhere else: 0 done; 1 a check failed, or the program has a fault
/// of its own; 2 bad input or use.
pub(crate) fn main() -> ExitCode {
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(message) if message.use_stderr() => {
            terminal::error(&usage::one_line(&message));
            return ExitCode::from(BAD_INPUT);
        }
        // Help and version are what was asked for.
        Err(text) => return exit_code(terminal::print(&text.to_string()).map(|()| Outcome::Done)),
    };
    interrupt::clean_up_when_interrupted();
    match fault::caught(|| run(&args.command)) {
        Ok(result) => exit_code(result),
        Err(fault) => {
            terminal::error(&fault);
            ExitCode::from(FAILED)
        }
    }
}

fn run(command: &Command) -> anyhow::Result<Outcome> {
    match command {
        Command::Bake(a) => bake::run(a),
        Command::Probe(a) => probe::run(a),
        Command::Inspect(a) => inspect::run(a),
        Command::Render(a) => render::run(a),
        Command::Compare(a) => compare::run(a),
        Command::Report(a) => report::run(a),
    }
}

fn exit_code(result: anyhow::Result<Outcome>) -> ExitCode {
    match result {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::CheckFailed) => ExitCode::from(FAILED),
        Err(error) => match error.downcast_ref::<LightError>() {
            Some(LightError::Mesh(bug)) => {
                terminal::error(&fault::message(&bug.to_string()));
                ExitCode::from(FAILED)
            }
            _ => {
                terminal::error(&format!("{error:#}"));
                ExitCode::from(BAD_INPUT)
            }
        },
    }
}
