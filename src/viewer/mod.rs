//! One page that shows a lit scene in any browser, from a file, without a network: lit, in false colours, by its error, with
//! its elements and the lines along which the light breaks, and what made the line that is pointed at.
//!
//! The page is one file: `page.html` around the data (JSON, long lists as base64 of little-endian
//! numbers) and a script, `page.min.js`, which `tools/viewer` bundles from its sources and three.js (MIT).

pub(crate) mod base64;
mod breaks;
mod page;
mod surfaces;

pub use page::Page;

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests;
