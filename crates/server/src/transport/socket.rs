//! A connected TCP or Unix socket: one descriptor for its reader, its writer and the render thread.
//!
//! Reads and sends do not block. A writer that must wait does so until the selector reports that
//! the socket is writable.

use super::Control;
use super::selector::{Selector, Writable};
use crate::admission::Slot;
use mio::net::TcpStream;
#[cfg(unix)]
use mio::net::UnixStream;
use std::io::{self, ErrorKind, Read, Write};
use std::net::Shutdown;
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

/// The system's socket.
#[derive(Debug)]
pub(crate) enum Stream {
    Tcp(TcpStream),
    #[cfg(unix)]
    Unix(UnixStream),
}

impl Stream {
    /// Closes one side or both. An error, such as that it is closed already, is ignored.
    pub fn shutdown(&self, how: Shutdown) {
        let _ = match self {
            Stream::Tcp(s) => s.shutdown(how),
            #[cfg(unix)]
            Stream::Unix(s) => s.shutdown(how),
        };
    }

    pub(super) fn register(&mut self, selector: &Selector, id: u64) -> io::Result<()> {
        match self {
            Stream::Tcp(s) => selector.register(s, id),
            #[cfg(unix)]
            Stream::Unix(s) => selector.register(s, id),
        }
    }

    fn begin_writer(&mut self, selector: &Selector, id: u64, writable: &Arc<Writable>) -> io::Result<()> {
        match self {
            Stream::Tcp(s) => selector.begin_writer(s, id, writable.clone()),
            #[cfg(unix)]
            Stream::Unix(s) => selector.begin_writer(s, id, writable.clone()),
        }
    }

    fn end_writer(&mut self, selector: &Selector, id: u64) {
        match self {
            Stream::Tcp(s) => selector.end_writer(s, id),
            #[cfg(unix)]
            Stream::Unix(s) => selector.end_writer(s, id),
        }
    }
}

impl Read for &Stream {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Stream::Tcp(s) => (&mut &*s).read(buffer),
            #[cfg(unix)]
            Stream::Unix(s) => (&mut &*s).read(buffer),
        }
    }
}

impl Write for &Stream {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Stream::Tcp(s) => (&mut &*s).write(bytes),
            #[cfg(unix)]
            Stream::Unix(s) => (&mut &*s).write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A registered socket and its place among the allowed connections.
#[derive(Debug)]
pub(crate) struct Socket {
    pub id: u64,
    /// Locked for writing only to change the registration with the selector.
    stream: RwLock<Stream>,
    selector: Arc<Selector>,
    writable: Arc<Writable>,
    /// Declared after the stream, so that the place is freed after the descriptor.
    _slot: Slot,
}

impl Socket {
    /// Wraps a stream that is registered with the selector under the number `id`.
    pub(super) fn new(stream: Stream, id: u64, selector: Arc<Selector>, slot: Slot) -> Self {
        Socket { id, stream: RwLock::new(stream), selector, writable: Arc::default(), _slot: slot }
    }

    fn stream(&self) -> RwLockReadGuard<'_, Stream> {
        // A stream is valid even if a thread panicked while it held the lock.
        self.stream.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reads what has arrived. Does not block.
    pub fn receive(&self, buffer: &mut [u8]) -> io::Result<usize> {
        (&mut &*self.stream()).read(buffer)
    }

    /// Sends some of the bytes; blocks until the system takes any. Returns how many were sent.
    fn send_some(&self, bytes: &[u8]) -> io::Result<usize> {
        match self.send(bytes) {
            Err(e) if e.kind() == ErrorKind::WouldBlock => {}
            result => return result,
        }
        self.stream_mut().begin_writer(&self.selector, self.id, &self.writable)?;
        let result = loop {
            // In this order, a socket that becomes writable in between is not missed.
            self.writable.unset();
            match self.send(bytes) {
                Err(e) if e.kind() == ErrorKind::WouldBlock => self.writable.wait(),
                result => break result,
            }
        };
        self.stream_mut().end_writer(&self.selector, self.id);
        result
    }

    fn send(&self, bytes: &[u8]) -> io::Result<usize> {
        (&mut &*self.stream()).write(bytes)
    }

    fn stream_mut(&self) -> RwLockWriteGuard<'_, Stream> {
        self.stream.write().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The writer's end of a socket.
#[derive(Debug)]
pub(crate) struct Replies(pub Arc<Socket>);

impl Write for Replies {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.send_some(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Control for Socket {
    fn send_now(&self, bytes: &[u8]) -> usize {
        // The writer finds an error again when it is given all of the bytes.
        self.send(bytes).unwrap_or(0)
    }

    fn stop_reading(&self) -> bool {
        self.stream().shutdown(Shutdown::Read);
        true
    }

    fn finish_writing(&self) {
        self.stream().shutdown(Shutdown::Write);
    }

    fn abort(&self) {
        self.stream().shutdown(Shutdown::Both);
        self.writable.set();
    }
}
