//! What people read: results on standard output, errors and warnings on standard error.

use std::io::{self, Write};
use umbrage::bad_input::BadInput;

/// Warnings that are shown when nobody asked for all of them.
const FEW: usize = 5;

/// Puts `text` on standard output. A reader that has closed the pipe has read enough: no error.
pub(super) fn print(text: &str) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(BadInput::new(
            "standard output",
            format!("cannot be written: {error}"),
            "redirect it elsewhere",
        )
        .into()),
        _ => Ok(()),
    }
}

/// One line about what went wrong.
pub(super) fn error(what: &str) {
    line("error", what);
}

/// The first few warnings, or all of them, and how many there are besides.
pub(super) fn warnings(all: &[String], is_verbose: bool) {
    let shown = if is_verbose { all.len() } else { FEW };
    for warning in all.iter().take(shown) {
        line("warning", warning);
    }
    if all.len() > shown {
        let hidden = all.len() - shown;
        line("warning", &format!("and {hidden} more; -v shows them"));
    }
}

/// A stage of the work that begins after so many `seconds`.
pub(super) fn stage(seconds: f64, name: &str) {
    line(&format!("{seconds:8.1} s"), name);
}

/// Nobody is left to tell when standard error is closed.
fn line(kind: &str, what: &str) {
    let _ = writeln!(io::stderr(), "{kind}: {what}");
}
