//! Ctrl-C: nothing half-written is left.

use umbrage::io::remove_unfinished;

/// What shells report for a program that was interrupted: 128 + SIGINT.
const INTERRUPTED: i32 = 130;

/// From here on Ctrl-C removes what is being written under another name, and ends the program.
///
/// Where the system has no way to do so, Ctrl-C ends it at once, as it always did.
pub(super) fn clean_up_when_interrupted() {
    let _ = ctrlc::set_handler(|| {
        remove_unfinished();
        std::process::exit(INTERRUPTED);
    });
}
