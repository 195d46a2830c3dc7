//! A socket that gives a bounded number of bytes a turn.
//!
//! In: a socket that never blocks. Out: the same bytes, and "would block" once a turn's are read.
//! Without it a page that sends pieces of a message without end, of no bytes each, would keep the
//! WebSocket's reader busy for ever: it returns with a whole message, or when there are no bytes.

use mio::net::TcpStream;
use std::io::{self, ErrorKind, Read, Write};

/// Most bytes that are read in a turn.
const TURN_BYTES: usize = 64 << 10;

/// A socket, and what is left of the turn's bytes.
#[derive(Debug)]
pub(super) struct TurnStream {
    stream: TcpStream,
    left: usize,
}

impl TurnStream {
    pub fn new(stream: TcpStream) -> TurnStream {
        TurnStream { stream, left: TURN_BYTES }
    }

    /// Allows a turn's bytes to be read.
    pub fn begin_turn(&mut self) {
        self.left = TURN_BYTES;
    }

    /// Returns whether the turn's bytes are read, so that there may be more.
    pub fn is_spent(&self) -> bool {
        self.left == 0
    }

    /// Returns the number of bytes that were read in this turn.
    pub fn bytes_read(&self) -> usize {
        TURN_BYTES - self.left
    }

    /// Returns the socket, to be registered and deregistered.
    pub fn stream(&mut self) -> &mut TcpStream {
        &mut self.stream
    }
}

impl Read for TurnStream {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.left == 0 && !into.is_empty() {
            return Err(ErrorKind::WouldBlock.into());
        }
        let most = into.len().min(self.left);
        let filled = self.stream.read(&mut into[..most])?;
        self.left -= filled;
        Ok(filled)
    }
}

impl Write for TurnStream {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_ends_while_there_are_bytes() {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let mut sender = std::net::TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        let (stream, _) = listener.accept().unwrap();
        // It blocks, unlike the server's, so that all bytes come.
        let mut stream = TurnStream::new(TcpStream::from_std(stream));
        let writer = std::thread::spawn(move || sender.write_all(&[7; TURN_BYTES + 10]));
        for expected in [TURN_BYTES, 10] {
            stream.begin_turn();
            let mut bytes = Vec::new();
            let end = stream.read_to_end(&mut bytes);
            assert_eq!((bytes.len(), stream.bytes_read()), (expected, expected));
            let is_first = expected == TURN_BYTES;
            assert_eq!(stream.is_spent(), is_first);
            assert_eq!(end.map_err(|e| e.kind()).ok(), (!is_first).then_some(10));
        }
        writer.join().unwrap().unwrap();
    }
}
