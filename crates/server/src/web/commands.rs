//! The command line of a viewer who may drive: an ordinary connection of the render thread, with
//! its session and its quotas, over two channels instead of a socket.
//!
//! In: lines of the page. Out: bytes of replies. The web thread never blocks here: the channels are
//! bounded, and the connection's own reader and writer threads wait for them. Dropping a
//! [`CommandLine`] ends the connection.

use super::socket::Viewer;
use super::{WebFeed, WebTarget};
use crate::admission::{Admission, Slot};
use crate::message::Medium;
use crate::transport::{ByteSource, Endpoint, Link, Uncontrolled, serve_connection};
use crossbeam_channel::{Receiver, Sender, TryRecvError, TrySendError, bounded};
use fbptr_command::EndOfInput;
use fbptr_engine::session::Audience;
use std::io::{self, Read, Write};
use std::net::IpAddr;
use std::sync::Arc;

/// Messages of the page that may be queued, and chunks of replies.
const QUEUE_LENGTH: usize = 8;
/// Most bytes of a chunk of replies.
const CHUNK_BYTES: usize = 16 << 10;

/// The web thread's end of a connection.
#[derive(Debug)]
pub(super) struct CommandLine {
    lines: Sender<Vec<u8>>,
    replies: Receiver<Vec<u8>>,
}

impl CommandLine {
    /// Opens a connection, which reports errors.
    ///
    /// # Errors
    /// The sentence for the user, if the server is full or has no thread.
    pub fn open(
        link: &Link,
        admission: &Arc<Admission>,
        peer: IpAddr,
        feed: &Arc<WebFeed>,
    ) -> Result<CommandLine, String> {
        let slot = admission.admit(Some(peer)).map_err(|refusal| refusal.to_string())?;
        let (lines, lines_out) = bounded(QUEUE_LENGTH);
        let (replies_in, replies) = bounded(QUEUE_LENGTH);
        // There is room: nothing was sent before.
        let _ = lines.try_send(b"ERRORS report\n".to_vec());
        let reader = LineReader { lines: lines_out, current: Vec::new(), at: 0, feed: feed.clone() };
        let writer = ReplyWriter { replies: Some(replies_in), feed: feed.clone(), _slot: slot };
        let endpoint = Endpoint {
            input: ByteSource::Alone(Box::new(reader)),
            output: Box::new(writer),
            control: Arc::new(Uncontrolled),
            end: EndOfInput::Stream,
            audience: Audience::Connection,
            medium: Medium::Pipe,
            may_replay: false,
            on_notice: None,
            on_end: None,
        };
        serve_connection(link, endpoint).map_err(|e| format!("no thread for commands: {e}"))?;
        Ok(CommandLine { lines, replies })
    }

    /// Queues bytes for the connection. Returns them if there is no room now; the web thread is
    /// woken when there is. Those of a connection that has ended are dropped.
    pub fn send(&self, bytes: Vec<u8>) -> Option<Vec<u8>> {
        match self.lines.try_send(bytes) {
            Err(TrySendError::Full(bytes)) => Some(bytes),
            Ok(()) | Err(TrySendError::Disconnected(_)) => None,
        }
    }

    /// Takes the next chunk of replies, or `None` if there is none now.
    ///
    /// # Errors
    /// If the connection has ended.
    pub fn reply(&self) -> Result<Option<Vec<u8>>, ()> {
        match self.replies.try_recv() {
            Ok(chunk) => Ok(Some(chunk)),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err(()),
        }
    }
}

/// Runs lines of a viewer in a connection of its own, which the first one opens.
pub(super) fn send_line(viewer: &mut Viewer, line: String, target: &WebTarget, feed: &Arc<WebFeed>) {
    let WebTarget::Thread { link, admission } = target else { return };
    let commands = match viewer.commands.take() {
        Some(commands) => commands,
        None => match CommandLine::open(link, admission, viewer.peer, feed) {
            Ok(commands) => commands,
            Err(reason) => {
                viewer.note(format!("refused {reason}"));
                return;
            }
        },
    };
    let mut bytes = line.into_bytes();
    bytes.push(b'\n');
    viewer.stalled = commands.send(bytes);
    viewer.commands = Some(commands);
}

/// The connection's input.
struct LineReader {
    lines: Receiver<Vec<u8>>,
    current: Vec<u8>,
    at: usize,
    feed: Arc<WebFeed>,
}

impl Read for LineReader {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        while self.at == self.current.len() {
            // Without a sender the viewer has gone.
            let Ok(next) = self.lines.recv() else { return Ok(0) };
            (self.current, self.at) = (next, 0);
            self.feed.wake_web();
        }
        let length = into.len().min(self.current.len() - self.at);
        into[..length].copy_from_slice(&self.current[self.at..self.at + length]);
        self.at += length;
        Ok(length)
    }
}

/// The connection's output.
struct ReplyWriter {
    replies: Option<Sender<Vec<u8>>>,
    feed: Arc<WebFeed>,
    _slot: Slot,
}

impl Write for ReplyWriter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let length = bytes.len().min(CHUNK_BYTES);
        let sent =
            self.replies.as_ref().is_some_and(|replies| replies.send(bytes[..length].to_vec()).is_ok());
        self.feed.wake_web();
        if sent { Ok(length) } else { Err(io::ErrorKind::BrokenPipe.into()) }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Drop for ReplyWriter {
    fn drop(&mut self) {
        self.replies = None;
        self.feed.wake_web();
    }
}
