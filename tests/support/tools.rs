//! System programs that a test needs. If one is missing, the test is skipped with a message past
//! the harness's capture, so that it is seen without `--nocapture`; with `FBPTR_ALL_TESTS` set it
//! fails.

use std::io::Write;
use std::process::{Command, Stdio};

/// Returns whether each of these programs can be started; prints the name of the first that cannot.
pub fn are_there(tools: &[&str]) -> bool {
    let starts = |tool: &&str| {
        let help = Command::new(tool).arg("-help").stdin(Stdio::null()).output();
        // A stand-in for a program that is not installed exits with 126 or 127.
        help.is_ok_and(|o| !matches!(o.status.code(), Some(126 | 127)))
    };
    match tools.iter().find(|t| !starts(t)) {
        Some(missing) => {
            skip(&format!("{missing} is not installed"));
            false
        }
        None => true,
    }
}

/// Prints that the running test is skipped, or panics if `FBPTR_ALL_TESTS` is set.
pub fn skip(reason: &str) {
    let test = std::thread::current().name().unwrap_or("a test").to_owned();
    assert!(std::env::var_os("FBPTR_ALL_TESTS").is_none(), "{test} would be skipped: {reason}");
    let _ = writeln!(std::io::stderr(), "skipped: {test}: {reason}");
}
