//! The text of an OBJ file.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &[u8]| umbrage_fuzz::read(&[("a.obj", text)]));
