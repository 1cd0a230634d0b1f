//! The program as a user runs it: spawned, in a folder of its own.

mod commands;
mod hostile;
mod pictures;
mod probe;
mod report;

use crate::common::scenes::fixture;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

/// A folder that the program runs in.
struct Folder(TempDir);

/// What came of a run.
struct Run {
    code: Option<i32>,
    out: String,
    err: String,
}

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), bytes).expect("the folder takes a file");
    }

    fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).expect("text")
    }

    fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("the folder is readable");
        let mut names: Vec<String> = entries
            .map(|e| e.expect("the entry is readable").file_name())
            .map(|name| name.to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    fn command<A: AsRef<OsStr>>(&self, args: impl IntoIterator<Item = A>) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_umbrage"));
        command
            .args(args)
            .current_dir(self.0.path())
            .stdin(Stdio::null());
        command
    }

    /// Runs the words of `line`.
    fn run(&self, line: &str) -> Run {
        let output = self.command(line.split_whitespace()).output();
        Run::of(output.expect("the program starts"))
    }

    /// Runs `line`, which has to succeed.
    fn done(&self, line: &str) -> Run {
        let run = self.run(line);
        assert_eq!(run.code, Some(0), "umbrage {line}\n{}", run.err);
        run
    }

    /// Runs `line`, which has to fail with one line that holds `what`.
    fn refused(&self, line: &str, what: &str) {
        let run = self.run(line);
        assert_eq!(run.code, Some(2), "umbrage {line}\n{}{}", run.out, run.err);
        let errors: Vec<&str> = run
            .err
            .lines()
            .filter(|l| !l.starts_with("warning: "))
            .collect();
        assert_eq!(errors.len(), 1, "umbrage {line}\n{}", run.err);
        assert!(errors[0].starts_with("error: "), "{}", run.err);
        assert!(
            errors[0].contains(what),
            "{what} is missing in: {}",
            errors[0]
        );
        assert!(!run.err.contains("panicked"), "{}", run.err);
    }
}

impl Run {
    fn of(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).expect("the program prints UTF-8");
        Self {
            code: output.status.code(),
            out: text(output.stdout),
            err: text(output.stderr),
        }
    }
}

/// The smallest shadow: a square lamp over a square blocker over a floor.
fn small() -> String {
    shown(&fixture("square-over-square"))
}

/// A path as a word of a command line.
fn shown(path: &Path) -> String {
    let text = path.display().to_string();
    assert!(
        !text.contains(char::is_whitespace),
        "the tests split at spaces"
    );
    text
}
