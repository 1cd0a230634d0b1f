//! The library's direct light, held against an independent computation and against closed forms.

mod analytic;
mod crowd;
mod dark;
mod fixtures;
mod outlook;
mod regressions;
mod stuck;
mod vantage;
