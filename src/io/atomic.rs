//! Files that appear under their name only when complete.

use crate::bad_input::BadInput;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Files that are being written, under their names for the time being.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Tells the files that one process writes at the same time from each other.
static NEXT: AtomicU32 = AtomicU32::new(0);

/// Leftovers of killed runs with the same process number that are stepped over before giving up.
const MAX_ATTEMPTS: u32 = 64;

/// Puts `bytes` under the name `path`, all of them or none.
///
/// They are written to `NAME.tmp-…` in the same folder, flushed to the disk and renamed; a failure removes that file and
/// leaves an older `path` as it was. A link is followed, so that it stays a link. What is no regular file (`/dev/null`, a
/// pipe) is written straight into: a rename would replace the device itself.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), BadInput> {
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let written = match fs::metadata(&target) {
        Ok(found) if found.is_dir() => {
            return Err(BadInput::new(
                path.display().to_string(),
                "is a folder, so no file can have its name",
                "name a file, for example one inside it",
            ));
        }
        Ok(found) if !found.is_file() => OpenOptions::new()
            .write(true)
            .open(&target)
            .and_then(|mut device| device.write_all(bytes)),
        _ => write_beside(&target, bytes),
    };
    written.map_err(|error| explain(path, &error))
}

fn write_beside(target: &Path, bytes: &[u8]) -> io::Result<()> {
    let (mut file, beside) = create_beside(target)?;
    let beside = Unfinished(beside);
    let done = file
        .write_all(bytes)
        .and_then(|()| file.sync_all())
        .and_then(|()| fs::rename(&beside.0, target));
    if done.is_err() {
        // The first error is the one to tell; that the remains could not be removed either adds nothing to it.
        let _ = fs::remove_file(&beside.0);
    }
    done
}

/// A file that is listed as unfinished as long as this lives.
struct Unfinished(PathBuf);

impl Drop for Unfinished {
    fn drop(&mut self) {
        unfinished().retain(|path| *path != self.0);
    }
}

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes what [`write_atomically`] is writing at this moment, for a program that is about to be ended from outside.
///
/// Nothing can be written any more afterwards: calls that are under way, or come later, wait for ever.
pub fn remove_unfinished() {
    let list = unfinished();
    for path in list.iter() {
        let _ = fs::remove_file(path);
    }
    // Kept locked: a file created from here on would not be removed.
    std::mem::forget(list);
}

fn create_beside(target: &Path) -> io::Result<(File, PathBuf)> {
    let mut last = io::Error::from(io::ErrorKind::AlreadyExists);
    for _ in 0..MAX_ATTEMPTS {
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let mut name = target
            .file_name()
            .ok_or(io::ErrorKind::InvalidInput)?
            .to_os_string();
        name.push(format!(".tmp-{:x}-{number:x}", std::process::id()));
        let beside = target.with_file_name(name);
        let mut list = unfinished();
        match File::create_new(&beside) {
            Ok(file) => {
                list.push(beside.clone());
                return Ok((file, beside));
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => last = error,
            Err(error) => return Err(error),
        }
    }
    Err(last)
}

fn explain(path: &Path, error: &io::Error) -> BadInput {
    let folder = match path.parent() {
        Some(parent) if parent != Path::new("") => parent.display().to_string(),
        _ => String::from("the current folder"),
    };
    let (what, remedy) = match error.kind() {
        io::ErrorKind::NotFound => (
            format!("{folder} does not exist"),
            "create it first, or write elsewhere",
        ),
        io::ErrorKind::NotADirectory => (
            format!("{folder} is not a folder"),
            "write to a path whose parents are folders",
        ),
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => (
            format!("{folder} may not be written to"),
            "change its permissions, or write elsewhere",
        ),
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => (
            String::from("the disk is full"),
            "free some space, or write elsewhere",
        ),
        _ => (
            format!("cannot be written: {error}"),
            "check the path, or write elsewhere",
        ),
    };
    BadInput::new(path.display().to_string(), what, remedy)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn the_file_appears_complete_and_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.glb");
        write_atomically(&path, b"first").unwrap();
        write_atomically(&path, b"second").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        assert_eq!(names(folder.path()), ["out.glb"]);
    }

    #[test]
    fn a_missing_folder_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let error = write_atomically(&folder.path().join("no/out.glb"), b"x").unwrap_err();
        assert!(error.what.ends_with("no does not exist"), "{error}");
    }

    #[test]
    fn a_folder_in_the_way_is_refused_and_kept() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("out.glb")).unwrap();
        let error = write_atomically(&folder.path().join("out.glb"), b"x").unwrap_err();
        assert!(error.what.contains("is a folder"), "{error}");
        assert_eq!(names(folder.path()), ["out.glb"]);
    }

    #[test]
    fn a_rename_that_fails_leaves_no_remains() {
        let folder = tempfile::tempdir().unwrap();
        let taken = folder.path().join("taken");
        fs::create_dir(&taken).unwrap();
        assert!(write_beside(&taken, b"x").is_err());
        assert_eq!(names(folder.path()), ["taken"]);
    }

    #[test]
    fn unfinished_files_are_known_until_they_are_done() {
        let folder = tempfile::tempdir().unwrap();
        let (_, beside) = create_beside(&folder.path().join("out.glb")).unwrap();
        assert!(unfinished().contains(&beside));
        drop(Unfinished(beside.clone()));
        assert!(!unfinished().contains(&beside));
        write_atomically(&folder.path().join("out.glb"), b"x").unwrap();
        let is_ours = |path: &PathBuf| path.starts_with(folder.path());
        assert!(!unfinished().iter().any(is_ours));
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_links_and_devices_stay_devices() {
        use std::os::unix::fs::FileTypeExt;
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        fs::write(&real, b"old").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        write_atomically(&link, b"new").unwrap();
        assert_eq!(fs::read(&real).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());

        write_atomically(Path::new("/dev/null"), b"x").unwrap();
        let null = fs::metadata("/dev/null").unwrap();
        assert!(null.file_type().is_char_device());
    }
}
