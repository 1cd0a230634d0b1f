//! Panics, which are always faults of our own, as one line for the user.

use std::panic::{self, AssertUnwindSafe};
use std::sync::{Mutex, PoisonError};

/// Where the first panic happened.
static PLACE: Mutex<Option<String>> = Mutex::new(None);

/// The result of `work`, or the line that tells of its panic. Nothing else is printed.
pub(super) fn caught<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    panic::set_hook(Box::new(|info| {
        let mut place = PLACE.lock().unwrap_or_else(PoisonError::into_inner);
        *place = info.location().map(ToString::to_string);
    }));
    panic::catch_unwind(AssertUnwindSafe(work)).map_err(|payload| {
        let text = payload
            .downcast_ref::<&str>()
            .map(|text| (*text).to_owned())
            .or_else(|| payload.downcast_ref::<String>().cloned())
            .unwrap_or_else(|| "no message".to_owned());
        let place = PLACE.lock().unwrap_or_else(PoisonError::into_inner).take();
        message(&format!("{text} ({})", place.unwrap_or_default()))
    })
}

/// The line for a fault of our own.
pub(super) fn message(what: &str) -> String {
    let what = what.replace(['\n', '\r'], " ");
    format!(
        "internal error in umbrage {}: {what}; please report it with the scene and the command, nothing was written",
        env!("CARGO_PKG_VERSION")
    )
}
