//! What the fuzz targets share: bytes as the files of a scene, read and cleaned.

use std::cell::RefCell;
use tempfile::TempDir;
use umbrage::io::{ReadSettings, read_scene};
use umbrage::pipeline::World;
use umbrage::settings::Settings;

thread_local! {
    static FOLDER: RefCell<Option<TempDir>> = const { RefCell::new(None) };
}

/// Reads the first of `files` as a scene beside the others. It may be refused; anything else is a find.
pub fn read(files: &[(&str, &[u8])]) {
    FOLDER.with_borrow_mut(|folder| {
        let folder = folder.get_or_insert_with(|| tempfile::tempdir().expect("a folder"));
        for (name, content) in files {
            std::fs::write(folder.path().join(name), content).expect("a file");
        }
        let path = folder.path().join(files[0].0);
        match read_scene(&path, &ReadSettings::default()) {
            Ok(raw) => drop(World::new(&raw, &Settings::default())),
            Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
        }
    });
}
