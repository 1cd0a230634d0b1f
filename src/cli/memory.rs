//! How much memory the process has used.

/// The most that was ever resident, bytes; none where the system does not say (anything but Linux).
pub(super) fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// Starts a new measurement of the peak where the system can (Linux); elsewhere it stays the peak of the whole run.
pub(super) fn reset_peak() {
    // Nothing is lost but the figure when it cannot.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}
