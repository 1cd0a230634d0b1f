//! Files that are broken, by rule and at random: each is read, or refused in one clear line; none stops the program, fills
//! the memory or keeps it busy.

mod broken;
mod fuzz;
mod pictures;
mod seeds;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use umbrage::bad_input::BadInput;
use umbrage::io::{ReadSettings, read_lit, read_scene};
use umbrage::pipeline::World;
use umbrage::settings::Settings;

/// No file of a few kB may keep a reader busy for longer, even in a debug build on a loaded machine.
const MAX_TIME: Duration = Duration::from_secs(5);

/// A set of files, of which the first is read.
#[derive(Clone)]
struct Files {
    files: Vec<(String, Vec<u8>)>,
}

/// What became of a file.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Outcome {
    Read,
    Refused,
}

/// A folder of its own for the files of one test.
struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder of our own");
        Self { folder }
    }

    fn put(&self, name: &str, content: &[u8]) -> PathBuf {
        let path = self.folder.path().join(name);
        // Removed first: some file systems wait for the disk when a file is cut to zero and written again.
        let _ = std::fs::remove_file(&path);
        std::fs::write(&path, content).expect("a file in our own folder");
        path
    }

    /// Reads and cleans the files as a scene; `case` names them should that go wrong.
    fn scene(&self, files: &Files, case: &str) -> Outcome {
        for (name, content) in files.files.iter().skip(1) {
            self.put(name, content);
        }
        let (name, content) = &files.files[0];
        let path = self.put(name, content);
        let _guard = Named(case);
        let start = Instant::now();
        let cleaned = read_scene(&path, &ReadSettings::default()).and_then(|raw| {
            check_lists(&raw);
            World::new(&raw, &Settings::default())
        });
        assert!(start.elapsed() < MAX_TIME, "took {:?}", start.elapsed());
        judge(cleaned.err(), &path)
    }

    /// Reads the bytes as a lit file.
    fn lit(&self, bytes: &[u8], case: &str) -> Outcome {
        let _guard = Named(case);
        let start = Instant::now();
        let read = read_lit("lit.glb", bytes);
        assert!(start.elapsed() < MAX_TIME, "took {:?}", start.elapsed());
        judge(read.err(), Path::new("lit.glb"))
    }
}

/// An error is one line that begins with a place, says something, and offers a remedy.
fn judge(error: Option<BadInput>, path: &Path) -> Outcome {
    let Some(error) = error else {
        return Outcome::Read;
    };
    let folder = path.parent().unwrap_or(Path::new("")).display().to_string();
    let text = error.to_string();
    assert!(!text.contains('\n'), "more than one line: {text:?}");
    assert!(error.place.starts_with(&folder), "no place: {text}");
    assert!(!error.what.is_empty() && !error.remedy.is_empty(), "{text}");
    Outcome::Refused
}

/// What the library's users rely on.
fn check_lists(raw: &umbrage::scene::RawScene) {
    let count = raw.positions.len();
    assert!([0, count].contains(&raw.uvs.len()) && [0, count].contains(&raw.normals.len()));
    for polygon in &raw.polygons {
        assert!(polygon.corners.len() >= 3);
        assert!(polygon.corners.iter().all(|&c| (c as usize) < count));
        assert!((polygon.material as usize) < raw.materials.len());
        assert!((polygon.group as usize) < raw.groups.len());
    }
}

/// Tells which case a panic comes from.
struct Named<'a>(&'a str);

impl Drop for Named<'_> {
    #[allow(clippy::print_stderr, reason = "a failing test says what it was at")]
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("failed at: {}", self.0);
        }
    }
}

/// Most virtual memory that this process has had, bytes, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmPeak:"))?;
    let kilobytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024)
}
