//! A GLB with its frame and chunks, as a scene and as a lit file.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    umbrage_fuzz::read(&[("a.glb", bytes)]);
    drop(umbrage::io::read_lit("a.glb", bytes));
});
