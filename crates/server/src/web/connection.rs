//! A connection before it is a WebSocket: reads the head of a request, and sends the response.
//!
//! In: bytes of a socket that never blocks. Out: the next [`Step`]. Promises: a head has at most
//! [`MAX_HEAD_BYTES`], bodies are not read, and the whole exchange takes at most [`PATIENCE`].

use super::page::{self, Response};
use crate::http::{Refused, head_length};
use mio::net::TcpStream;
use std::io::{self, ErrorKind, Read, Write};
use std::net::Shutdown;
use std::time::Duration;

/// Most bytes of a request's head. Browsers send the cookies of all servers on `localhost`.
const MAX_HEAD_BYTES: usize = 16 << 10;
/// Longest time from the first byte to the end of the response, or to the first message of a
/// WebSocket.
pub(super) const PATIENCE: Duration = Duration::from_secs(5);

/// A connection that speaks HTTP.
#[derive(Debug)]
pub(super) struct HttpConnection {
    stream: TcpStream,
    phase: Phase,
}

#[derive(Debug)]
enum Phase {
    /// Bytes of the head so far.
    Head(Vec<u8>),
    /// The response, and the number of bytes that are sent.
    Response(Vec<u8>, usize),
    /// Bytes that the client still sends are dropped: a socket that is closed with unread bytes is
    /// reset, and the response may be lost.
    Drain,
}

/// State of a connection after a look at its socket.
pub(super) enum Step {
    /// It waits for its socket.
    Waits(HttpConnection),
    /// It is a WebSocket, with the bytes that came behind the head.
    IsSocket(TcpStream, Vec<u8>),
    /// It has ended.
    Ended,
}

impl HttpConnection {
    pub fn new(stream: TcpStream) -> HttpConnection {
        HttpConnection { stream, phase: Phase::Head(Vec::new()) }
    }

    /// Goes on as far as is possible without blocking.
    pub fn advance(mut self, own_name: Option<&str>) -> Step {
        loop {
            let result = match &mut self.phase {
                Phase::Head(bytes) => match read_head(&mut self.stream, bytes) {
                    Ok(length) => match respond(bytes, length, own_name) {
                        Response::Bytes(bytes) => {
                            self.phase = Phase::Response(bytes, 0);
                            Ok(())
                        }
                        Response::Switch(response) => {
                            let rest = bytes.split_off(length.unwrap_or(bytes.len()));
                            // A socket that has sent nothing yet takes it whole.
                            return match self.stream.write(&response) {
                                Ok(sent) if sent == response.len() => Step::IsSocket(self.stream, rest),
                                _ => Step::Ended,
                            };
                        }
                    },
                    Err(e) => Err(e),
                },
                Phase::Response(bytes, at) => match self.stream.write(&bytes[*at..]) {
                    Ok(0) => return Step::Ended,
                    Ok(sent) => {
                        *at += sent;
                        if *at == bytes.len() {
                            let _ = self.stream.shutdown(Shutdown::Write);
                            self.phase = Phase::Drain;
                        }
                        Ok(())
                    }
                    Err(e) => Err(e),
                },
                Phase::Drain => match self.stream.read(&mut [0; 1024]) {
                    Ok(0) => return Step::Ended,
                    Ok(_) => return Step::Waits(self),
                    Err(e) => Err(e),
                },
            };
            match result {
                Ok(()) => {}
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(e) if e.kind() == ErrorKind::WouldBlock => return Step::Waits(self),
                Err(_) => return Step::Ended,
            }
        }
    }
}

/// Reads up to the end of a head. Returns its length, or `None` if it is too long.
fn read_head(stream: &mut TcpStream, bytes: &mut Vec<u8>) -> io::Result<Option<usize>> {
    let mut buffer = [0; 2048];
    loop {
        let filled = stream.read(&mut buffer)?;
        if filled == 0 {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        let from = bytes.len();
        bytes.extend_from_slice(&buffer[..filled]);
        match head_length(bytes, from) {
            Some(length) if length <= MAX_HEAD_BYTES => return Ok(Some(length)),
            None if bytes.len() <= MAX_HEAD_BYTES => {}
            _ => return Ok(None),
        }
    }
}

fn respond(bytes: &[u8], length: Option<usize>, own_name: Option<&str>) -> Response {
    match length {
        Some(length) => page::respond(&bytes[..length], own_name),
        None => {
            let status = "431 Request Header Fields Too Large";
            Response::Bytes(page::refusal(&Refused { status, reason: "the request is too long" }))
        }
    }
}
