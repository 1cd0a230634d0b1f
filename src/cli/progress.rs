//! Progress: a bar on a terminal; in a log, when more is asked for, a line for each stage.

use super::table::percent;
use super::terminal;
use indicatif::{ProgressBar, ProgressStyle};
use std::cell::Cell;
use std::io::IsTerminal;
use std::time::{Duration, Instant};
use umbrage::pipeline::{Measured, Step};

/// What there is to see of the stage that is running.
pub(super) enum Shown {
    /// One bar that changes its name with each stage.
    Bar(ProgressBar),
    /// A line for each stage as it begins, and now and then what share of it is done.
    Log(Log),
    /// Nothing.
    Silent,
}

/// Where a log stands.
pub(super) struct Log {
    since: Instant,
    stage: Cell<&'static str>,
    last: Cell<Instant>,
}

/// Steps of the bar.
const STEPS: u64 = 100;

/// A log says so often how far a stage has come.
const LOG_INTERVAL: Duration = Duration::from_secs(10);

impl Shown {
    /// A bar on a terminal; otherwise, when `is_verbose`, a log; nothing when `is_quiet`.
    pub(super) fn new(is_quiet: bool, is_verbose: bool) -> Self {
        let is_terminal = std::io::stderr().is_terminal();
        if is_quiet || !(is_terminal || is_verbose) {
            return Self::Silent;
        }
        if !is_terminal {
            let now = Instant::now();
            return Self::Log(Log {
                since: now,
                stage: Cell::new(""),
                last: Cell::new(now),
            });
        }
        let bar = ProgressBar::new(STEPS);
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg:14} [{bar:30}] {elapsed}") {
            bar.set_style(style);
        }
        Self::Bar(bar)
    }

    /// Shows the stage that is at work, and says what was missed.
    pub(super) fn show(&self, step: Step) {
        match step {
            Step::Stage(name, done) => self.stage(name, done),
            Step::Missed(measured) => self.say(&missed(measured)),
        }
    }

    /// Shows stage `name`, done to the share `done` (0…1) where that is known.
    fn stage(&self, name: &'static str, done: Option<f64>) {
        match self {
            Self::Bar(bar) => {
                bar.set_message(name);
                bar.set_position((done.unwrap_or(0.0) * STEPS as f64) as u64);
                bar.tick();
            }
            Self::Log(log) => log.show(name, done),
            Self::Silent => {}
        }
    }

    /// Shows what is being done where nobody knows how long it takes.
    pub(super) fn tell(&self, what: &str) {
        match self {
            Self::Bar(bar) => {
                bar.set_message(what.to_owned());
                bar.tick();
            }
            Self::Log(log) => log.line(what),
            Self::Silent => {}
        }
    }

    /// Leaves `what` on the screen.
    fn say(&self, what: &str) {
        match self {
            Self::Bar(bar) => bar.println(what),
            Self::Log(log) => log.line(what),
            Self::Silent => {}
        }
    }

    /// Clears the bar.
    pub(super) fn finish(self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

fn missed(m: &Measured) -> String {
    let [whole, mesh, field] =
        [m.relative_rms, m.relative_rms_mesh, m.relative_rms_field].map(percent);
    format!(
        "measured {whole}, more than was asked for (display mesh {mesh}, indirect field {field}): refining again"
    )
}

impl Log {
    fn show(&self, name: &'static str, done: Option<f64>) {
        if self.stage.replace(name) != name {
            self.line(name);
        } else if let Some(done) = done
            && self.last.get().elapsed() >= LOG_INTERVAL
        {
            self.line(&format!("{name}, {:.0} %", 100.0 * done));
        }
    }

    fn line(&self, text: &str) {
        self.last.set(Instant::now());
        terminal::stage(self.since.elapsed().as_secs_f64(), text);
    }
}
