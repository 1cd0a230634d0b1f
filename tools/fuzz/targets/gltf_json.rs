//! The JSON of a glTF, whose buffers are in it.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &[u8]| umbrage_fuzz::read(&[("a.gltf", text)]));
