//! What a run may use: elements, time, memory.
//!
//! A run that meets the error asked for within its budget is not touched by it. One that does not stops at the best mesh
//! that it has by then, and says what error that is.

use crate::bad_input::BadInput;
use std::str::FromStr;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

const PLACE: &str = "--budget";
const REMEDY: &str = "give any of elements=N,time=SECONDS,memory=MB";

const MEGABYTE: f64 = 1e6;

/// Limits of a run; none where there is no limit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Budget {
    /// Elements of the display mesh.
    pub elements: Option<usize>,
    /// Wall-clock time, seconds.
    pub seconds: Option<f64>,
    /// Resident memory of the process, bytes.
    pub memory: Option<u64>,
}

impl FromStr for Budget {
    type Err = BadInput;

    /// `elements=N,time=SECONDS,memory=MB`, any of them in any order.
    fn from_str(text: &str) -> Result<Self, BadInput> {
        let bad = |what: String| BadInput::new(PLACE, what, REMEDY);
        let mut budget = Self::default();
        for part in text.split(',') {
            let Some((name, value)) = part.split_once('=') else {
                return Err(bad(format!("\"{part}\" is no limit")));
            };
            let (name, value) = (name.trim(), value.trim());
            let positive = || match value.parse::<f64>() {
                Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
                _ => Err(bad(format!("{name}={value} is no number above 0"))),
            };
            let is_new = match name {
                "elements" => match value.parse() {
                    Ok(n) if n > 0 => budget.elements.replace(n).is_none(),
                    _ => return Err(bad(format!("elements={value} is no count above 0"))),
                },
                "time" => budget.seconds.replace(positive()?).is_none(),
                "memory" => budget
                    .memory
                    .replace((positive()? * MEGABYTE) as u64)
                    .is_none(),
                _ => return Err(bad(format!("\"{name}\" cannot be limited"))),
            };
            if !is_new {
                return Err(bad(format!("{name} is limited twice")));
            }
        }
        Ok(budget)
    }
}

/// What a budget can be exceeded in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// Elements of the display mesh.
    Elements,
    /// Time.
    Time,
    /// Memory.
    Memory,
}

impl Limit {
    /// Its name in the option.
    pub fn name(self) -> &'static str {
        match self {
            Self::Elements => "elements",
            Self::Time => "time",
            Self::Memory => "memory",
        }
    }
}

/// A budget that is being used, by any number of threads.
#[derive(Debug)]
pub struct Meter {
    budget: Budget,
    since: Instant,
    /// Time or memory, whichever was used up first.
    used_up: OnceLock<Limit>,
    lacks_elements: AtomicBool,
}

impl Meter {
    /// Starts now.
    pub fn new(budget: Budget) -> Self {
        Self {
            budget,
            since: Instant::now(),
            used_up: OnceLock::new(),
            lacks_elements: AtomicBool::new(false),
        }
    }

    /// Whether time or memory are used up; once they are, they stay so.
    pub fn is_used_up(&self) -> bool {
        if self.is_late() {
            return true;
        }
        let is_over = |most| resident_bytes().is_some_and(|bytes| bytes > most);
        if self.budget.memory.is_some_and(is_over) {
            self.used_up.get_or_init(|| Limit::Memory);
        }
        self.used_up.get().is_some()
    }

    /// The same without another look at the memory: for inner loops.
    pub fn is_late(&self) -> bool {
        let is_over = |most| self.since.elapsed().as_secs_f64() > most;
        if self.used_up.get().is_none() && self.budget.seconds.is_some_and(is_over) {
            self.used_up.get_or_init(|| Limit::Time);
        }
        self.used_up.get().is_some()
    }

    /// Elements that there may be.
    pub fn most_elements(&self) -> usize {
        self.budget.elements.unwrap_or(usize::MAX)
    }

    /// Notes whether the mesh lacks elements that there may not be.
    pub fn lacks_elements(&self, lacks: bool) {
        self.lacks_elements.store(lacks, Ordering::Relaxed);
    }

    /// What stopped the run, if anything did.
    pub fn reached(&self) -> Option<Limit> {
        let lacks = self.lacks_elements.load(Ordering::Relaxed);
        let used_up = self.used_up.get().copied();
        used_up.or(lacks.then_some(Limit::Elements))
    }
}

/// Memory of the process that is resident now, bytes; none where the system does not say (anything but Linux).
pub fn resident_bytes() -> Option<u64> {
    status("VmRSS:")
}

/// The most that was ever resident, bytes; none where the system does not say.
pub fn peak_bytes() -> Option<u64> {
    status("VmHWM:")
}

fn status(name: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix(name))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_subset_in_any_order() {
        let all: Budget = "memory=1.5, time=30 ,elements=5000"
            .parse()
            .expect("a budget");
        let expected = Budget {
            elements: Some(5000),
            seconds: Some(30.0),
            memory: Some(1_500_000),
        };
        assert_eq!(all, expected);
        let one: Budget = "time=0.5".parse().expect("a budget");
        assert_eq!(
            (one.seconds, one.elements, one.memory),
            (Some(0.5), None, None)
        );
    }

    #[test]
    fn what_is_wrong_is_named_in_one_line() {
        for (text, what) in [
            ("", "\"\" is no limit"),
            ("elements", "\"elements\" is no limit"),
            ("elements=0", "elements=0 is no count above 0"),
            ("elements=1e3", "elements=1e3 is no count above 0"),
            ("time=-1", "time=-1 is no number above 0"),
            ("memory=NaN", "memory=NaN is no number above 0"),
            ("memory=inf", "memory=inf is no number above 0"),
            ("speed=1", "\"speed\" cannot be limited"),
            ("time=1,time=2", "time is limited twice"),
            ("time=1,", "\"\" is no limit"),
        ] {
            let error = text.parse::<Budget>().expect_err("no budget").to_string();
            assert!(error.contains(what), "{text}: {error}");
            assert!(error.contains("elements=N") && !error.contains('\n'));
        }
    }

    #[test]
    fn the_first_limit_that_is_reached_is_the_one_told() {
        let free = Meter::new(Budget::default());
        assert!(!free.is_used_up() && free.reached().is_none());
        let no_time = Budget {
            seconds: Some(0.0),
            ..Budget::default()
        };
        let late = Meter::new(no_time);
        assert!(late.is_used_up());
        assert_eq!(late.reached(), Some(Limit::Time));
        late.lacks_elements(true);
        assert_eq!(late.reached(), Some(Limit::Time));
    }
}
