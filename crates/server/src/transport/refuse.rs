//! Refusal of connections: one `ERR` line, then the end.
//!
//! In: sockets that cannot be served, from the threads that accept. Out: closed sockets. A socket
//! that is closed with unread bytes is reset, which may discard the line; so up to [`LINGERING`]
//! sockets are read from, and the bytes discarded, for up to [`PATIENCE`], by one thread that
//! exists while there are any. Promises: never blocks; every client is sent the line; sockets
//! beyond the limit are closed at once.

use super::Stream;
use super::report::{Trouble, report};
use std::io::{Read, Write};
use std::net::Shutdown;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::{Duration, Instant};

/// Refused sockets that are still read from, at most.
pub(crate) const LINGERING: usize = 16;
/// Time for which they are read from.
const PATIENCE: Duration = Duration::from_secs(1);
/// Pause between two rounds of reading, and the most bytes that are read of one socket in a round.
const PAUSE: Duration = Duration::from_millis(10);
const ROUND_BYTES: usize = 64 << 10;

struct LingeringSockets {
    sockets: Vec<(Stream, Instant)>,
    has_thread: bool,
}

static LINGERING_SOCKETS: Mutex<LingeringSockets> =
    Mutex::new(LingeringSockets { sockets: Vec::new(), has_thread: false });

fn lock() -> MutexGuard<'static, LingeringSockets> {
    // The list is valid even if a thread panicked while it held the lock.
    LINGERING_SOCKETS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Sends a client the reason why it cannot be served, and closes the connection.
pub(super) fn refuse(socket: Stream, why: &str) {
    let Some(socket) = send_refusal(socket, why) else { return };
    let mut lingering = lock();
    if lingering.sockets.len() >= LINGERING {
        return;
    }
    lingering.sockets.push((socket, Instant::now() + PATIENCE));
    if !lingering.has_thread {
        let thread =
            Builder::new().name("refuse".into()).stack_size(super::STACK_BYTES).spawn(read_lingering);
        match thread {
            Ok(_) => lingering.has_thread = true,
            Err(e) => {
                lingering.sockets.clear();
                report(Trouble::Threads, format_args!("no thread to let refused clients go: {e}"));
            }
        }
    }
}

/// Sends the refusal and closes the socket at once, so that no descriptor is kept.
pub(super) fn refuse_now(socket: Stream, why: &str) {
    drop(send_refusal(socket, why));
}

/// Sends the error line and reads what has arrived. Returns the socket if its client may send more.
fn send_refusal(socket: Stream, why: &str) -> Option<Stream> {
    // The first bytes on a socket fit into the system's buffer, and a client that is gone does not
    // need them.
    (&socket).write_all(format!("ERR 0 0 EQUOTA CONNECT: {why}\n").as_bytes()).ok()?;
    socket.shutdown(Shutdown::Write);
    discard(&socket).then_some(socket)
}

/// Reads and discards what has arrived. Returns whether more may come.
fn discard(mut socket: &Stream) -> bool {
    let mut rest = [0; 4096];
    for _ in 0..ROUND_BYTES / rest.len() {
        match socket.read(&mut rest) {
            Ok(0) => return false,
            Ok(_) => {}
            Err(e) => return e.kind() == std::io::ErrorKind::WouldBlock,
        }
    }
    true
}

fn read_lingering() {
    loop {
        std::thread::sleep(PAUSE);
        let now = Instant::now();
        let mut lingering = lock();
        lingering.sockets.retain(|(socket, until)| now < *until && discard(socket));
        if lingering.sockets.is_empty() {
            lingering.has_thread = false;
            return;
        }
    }
}
