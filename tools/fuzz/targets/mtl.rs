//! The text of an MTL file, under a triangle that uses its material `a`.
#![no_main]

const OBJ: &[u8] = b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n";

libfuzzer_sys::fuzz_target!(|text: &[u8]| umbrage_fuzz::read(&[("a.obj", OBJ), ("a.mtl", text)]));
