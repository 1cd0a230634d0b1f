//! Scene files in, [`RawScene`](crate::scene::RawScene) out: metres, right-handed, y up, nothing repaired.

pub mod builtin;
