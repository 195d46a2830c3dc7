//! Standard output. A closed pipe is no failure, and ends a program that has nothing else to do.
//! Other write errors, such as a full disk, are reported once and make the program fail.

use super::{Status, say_as_program};
use std::io::{self, ErrorKind, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// Set when any output of the process was lost.
static IS_LOST: AtomicBool = AtomicBool::new(false);

/// Set when the program has nothing to do but to answer on standard output.
static ENDS_IF_CLOSED: AtomicBool = AtomicBool::new(false);

/// Makes a closed pipe end the process, as it ends other programs whose reader has gone.
pub(crate) fn end_if_closed() {
    ENDS_IF_CLOSED.store(true, Ordering::Release);
}

/// Standard output with error reporting, used by all subcommands.
pub(crate) struct Stdout;

impl Write for Stdout {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        io::stdout().write(bytes).inspect_err(notice)
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stdout().flush().inspect_err(notice)
    }
}

/// Writes and flushes a text.
pub(crate) fn print(text: impl AsRef<[u8]>) {
    // `Stdout` reports the error.
    let _ = Stdout.write_all(text.as_ref()).and_then(|()| Stdout.flush());
}

/// Reports the first error of writing, other than a closed pipe or an interruption; a closed pipe
/// ends the process after [`end_if_closed`].
fn notice(error: &io::Error) {
    if error.kind() == ErrorKind::BrokenPipe && ENDS_IF_CLOSED.load(Ordering::Acquire) {
        std::process::exit(0);
    }
    let is_harmless = matches!(error.kind(), ErrorKind::BrokenPipe | ErrorKind::Interrupted);
    if !is_harmless && !IS_LOST.swap(true, Ordering::AcqRel) {
        say_as_program(format_args!("standard output: {error}"));
    }
}

/// Returns the exit status, given the status without lost output.
pub(super) fn ended(status: Status) -> Status {
    let _ = Stdout.flush();
    match status {
        Status::Success if IS_LOST.load(Ordering::Acquire) => Status::Failed,
        _ => status,
    }
}
