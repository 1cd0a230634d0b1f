//! All integration tests, one binary:
//! - `layering`: no stage of the library uses a later one.
//! - `references`: the references that other tests trust, held against closed forms and against each other.

mod common;

mod layering;
mod references;
