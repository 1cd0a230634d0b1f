//! The `umbrage` program: light that is right, baked into the mesh.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
