//! A connected socket, TCP or Unix, behind one face.

use super::{Control, Slot};
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
#[cfg(unix)]
use std::os::unix::net::UnixStream;
use std::sync::Arc;

/// What the system gives.
#[derive(Debug)]
pub(crate) enum Stream {
    Tcp(TcpStream),
    #[cfg(unix)]
    Unix(UnixStream),
}

/// A connected socket, with one descriptor for reading, writing and closing, and its place among the connections.
#[derive(Debug)]
pub(crate) struct Socket {
    stream: Stream,
    /// Declared behind the stream: the place is free when the descriptor is.
    _slot: Option<Slot>,
}

impl Socket {
    pub fn new(stream: Stream, slot: Option<Slot>) -> Self {
        Socket { stream, _slot: slot }
    }

    /// Closes one side or both. One that is closed already stays so.
    pub fn shutdown(&self, how: Shutdown) {
        let _ = match &self.stream {
            Stream::Tcp(s) => s.shutdown(how),
            #[cfg(unix)]
            Stream::Unix(s) => s.shutdown(how),
        };
    }

    /// Has reads and writes wait, or not.
    pub fn set_nonblocking(&self, is_nonblocking: bool) -> io::Result<()> {
        match &self.stream {
            Stream::Tcp(s) => s.set_nonblocking(is_nonblocking),
            #[cfg(unix)]
            Stream::Unix(s) => s.set_nonblocking(is_nonblocking),
        }
    }
}

impl Read for &Socket {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match &self.stream {
            Stream::Tcp(s) => (&mut &*s).read(buffer),
            #[cfg(unix)]
            Stream::Unix(s) => (&mut &*s).read(buffer),
        }
    }
}

impl Write for &Socket {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &self.stream {
            Stream::Tcp(s) => (&mut &*s).write(bytes),
            #[cfg(unix)]
            Stream::Unix(s) => (&mut &*s).write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A socket that its reader, its writer and the render thread share.
#[derive(Clone, Debug)]
pub(crate) struct SharedSocket(pub Arc<Socket>);

impl Read for SharedSocket {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        (&mut &*self.0).read(buffer)
    }
}

impl Write for SharedSocket {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        (&mut &*self.0).write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Control for Socket {
    #[cfg(target_os = "linux")]
    fn send_now(&self, bytes: &[u8]) -> usize {
        use rustix::net::{SendFlags, send};
        // What went wrong is found by the writer, when it is left all of it.
        send(self, bytes, SendFlags::DONTWAIT | SendFlags::NOSIGNAL).unwrap_or(0)
    }

    fn stop_reading(&self) -> bool {
        self.shutdown(Shutdown::Read);
        true
    }

    fn finish_writing(&self) {
        self.shutdown(Shutdown::Write);
    }

    fn abort(&self) {
        self.shutdown(Shutdown::Both);
    }
}

#[cfg(unix)]
impl std::os::fd::AsFd for Socket {
    fn as_fd(&self) -> std::os::fd::BorrowedFd<'_> {
        match &self.stream {
            Stream::Tcp(s) => s.as_fd(),
            Stream::Unix(s) => s.as_fd(),
        }
    }
}
