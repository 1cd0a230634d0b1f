//! A picture file, as a texture.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| drop(umbrage::texture::decode(bytes)));
