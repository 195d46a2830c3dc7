//! Standard output. A pipe that nobody reads any more is no failure; what a full disk does not take is lost, which is said once
//! and is one.

use super::{Status, say_as_program};
use std::io::{self, ErrorKind, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether anything that the process wrote to its standard output is lost.
static IS_LOST: AtomicBool = AtomicBool::new(false);

/// Standard output, as all subcommands use it.
pub(crate) struct Stdout;

impl Write for Stdout {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        io::stdout().write(bytes).inspect_err(notice)
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stdout().flush().inspect_err(notice)
    }
}

/// Writes a text at once.
pub(crate) fn print(text: impl AsRef<[u8]>) {
    // What fails is noticed.
    let _ = Stdout.write_all(text.as_ref()).and_then(|()| Stdout.flush());
}

fn notice(error: &io::Error) {
    let is_harmless = matches!(error.kind(), ErrorKind::BrokenPipe | ErrorKind::Interrupted);
    if !is_harmless && !IS_LOST.swap(true, Ordering::AcqRel) {
        say_as_program(format_args!("standard output: {error}"));
    }
}

/// How a process ends that would end with `status`, but for what is lost.
pub(super) fn ended(status: Status) -> Status {
    let _ = Stdout.flush();
    match status {
        Status::Success if IS_LOST.load(Ordering::Acquire) => Status::Failed,
        _ => status,
    }
}
