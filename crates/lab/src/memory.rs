//! Peak memory use of the process, if the system reports it.

/// Resets the peak to the current use. If the system cannot, the peak continues from the last one.
pub(super) fn forget_peak() {
    // On Linux, writing 5 resets the peak of the resident set.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// Returns the largest resident set since [`forget_peak`] in bytes, or `None` if it is not
/// available.
pub(super) fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    parse(&status)
}

fn parse(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_peak_is_read_in_bytes() {
        assert_eq!(super::parse("Name:\tx\nVmHWM:\t    2048 kB\nVmRSS:\t 1 kB\n"), Some(2048 * 1024));
        assert_eq!(super::parse("Name: x\n"), None);
    }
}
