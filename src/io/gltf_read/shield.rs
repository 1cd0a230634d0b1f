//! Panics of the glTF crates on hostile files, turned into values.
//!
//! `gltf` 1.4 checks a document with code that itself indexes out of range on some broken ones. Such a panic is caught
//! here, and its message kept off standard error.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    /// Whether this thread is inside [`shielded`].
    static IS_SHIELDED: Cell<bool> = const { Cell::new(false) };
}

/// The result of `work`, or the message of the panic that ended it.
///
/// The first call puts a panic hook in front of the one that is there: it is silent for threads inside `shielded` and
/// hands every other panic on, so other threads report theirs as before. `work` must leave nothing half done that its
/// caller sees afterwards.
pub(super) fn shielded<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    // A thread that is panicking may not touch the hook; then the message shows, and nothing else is lost.
    if !std::thread::panicking() {
        HOOK.call_once(|| {
            let previous = panic::take_hook();
            panic::set_hook(Box::new(move |info| {
                if !IS_SHIELDED.try_with(Cell::get).unwrap_or(false) {
                    previous(info);
                }
            }));
        });
    }
    let outer = IS_SHIELDED.replace(true);
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    IS_SHIELDED.set(outer);
    result.map_err(|payload| {
        let text = payload
            .downcast_ref::<&str>()
            .map(|text| (*text).to_owned());
        text.or_else(|| payload.downcast_ref::<String>().cloned())
            .unwrap_or_else(|| "no message".to_owned())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_its_message() {
        let result: Result<(), _> = shielded(|| panic!("index {} out of range", 7));
        assert_eq!(result, Err("index 7 out of range".to_owned()));
        assert!(!IS_SHIELDED.get());
    }

    #[test]
    fn a_result_passes_through() {
        assert_eq!(shielded(|| 3), Ok(3));
    }
}
