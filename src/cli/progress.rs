//! Progress bars on a terminal, nothing when piped.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;

/// One bar that changes its name with each stage.
pub(super) struct Bar(Option<ProgressBar>);

/// Steps of the bar.
const STEPS: u64 = 100;

impl Bar {
    /// A bar on a terminal; otherwise, or when `quiet`, none.
    pub(super) fn new(quiet: bool) -> Self {
        if quiet || !std::io::stderr().is_terminal() {
            return Self(None);
        }
        let bar = ProgressBar::new(STEPS);
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg:14} [{bar:30}] {elapsed}") {
            bar.set_style(style);
        }
        Self(Some(bar))
    }

    /// Shows stage `name`, done to the share `done` (0…1) where that is known.
    pub(super) fn show(&self, name: &'static str, done: Option<f64>) {
        if let Some(bar) = &self.0 {
            bar.set_message(name);
            bar.set_position((done.unwrap_or(0.0) * STEPS as f64) as u64);
            bar.tick();
        }
    }

    /// Shows what is being done where nobody knows how long it takes.
    pub(super) fn tell(&self, what: &str) {
        if let Some(bar) = &self.0 {
            bar.set_message(what.to_owned());
            bar.tick();
        }
    }

    /// Clears the line.
    pub(super) fn finish(self) {
        if let Some(bar) = self.0 {
            bar.finish_and_clear();
        }
    }
}
