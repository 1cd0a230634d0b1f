//! All integration tests, one binary:
//! - `layering`: no stage of the library uses a later one.
//! - `lines`: the lines on the receivers, where closed forms say.
//! - `references`: the references that other tests trust, held against closed forms and against each other.

mod common;

mod layering;
mod lines;
mod references;
