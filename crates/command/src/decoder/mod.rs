//! The decoder: bytes in, complete commands out, independent of how the transport splits the
//! stream.
//!
//! At a command boundary the first bytes decide: `PB` is ten bytes, `PXMULTI` a header of fifteen
//! and its run, anything else a line up to LF, after which `:N` bytes of payload may follow. The
//! sink receives nothing of a command before its last byte has arrived. No I/O, no thread.
//!
//! Promises:
//! - The sink gets the same calls for every way to split the stream (except for the number of
//!   records per call of `pixels` and `binary_pixels`).
//! - Memory while waiting is bounded by a line's limit plus the payload bytes received, at most the
//!   payload limit. Room for a whole large payload is allocated when some of it has arrived; the
//!   system maps its pages as they are written.
//! - A refused command's payload is skipped, so that an error never desynchronizes the stream.
//! - No byte sequence causes a panic, and every position is exact: line = 1 + LF bytes before, byte
//!   = bytes before.

mod asks;
mod framing;
mod lent_payload;
mod line;
mod payload;
mod single;
#[cfg(test)]
mod tests;

pub use lent_payload::LentPayload;
#[doc(hidden)]
pub use line::BYTE_ORDER_MARK;
pub(super) use line::PayloadLength;

use super::args::{ParseError, words};
use super::commands::Command;
use super::encode::MAX_LINE_BYTES;
use super::long_line::LongLine;
use super::payload_pool::PayloadPool;
use super::scan::count_lf;
use super::sink::{Flow, Sink};
use super::stream_error::{StreamError, StreamPosition, Subject};
use fbptr_core::error::Code;
use fbptr_core::memory::Reservation;
use framing::{FrameKind, binary_or_text, frame_kind};
use line::{is_idle, without_cr};

/// Size limits for one stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Largest payload, and largest run of `PXMULTI`, in bytes.
    pub payload_bytes: u64,
}

impl Default for Limits {
    /// Allows 64 MiB per payload.
    fn default() -> Self {
        Limits { payload_bytes: 64 << 20 }
    }
}

/// Kind of input that ends: decides about a last line without LF.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EndOfInput {
    /// A regular file: its last line may lack the LF.
    File,
    /// Everything else: a line without LF is incomplete.
    Stream,
}

/// Position of the stream within a command.
enum DecoderState {
    /// At a boundary, or in a head whose beginning is in `Decoder::head`.
    Head,
    /// In the payload of `command`; `Decoder::payload` holds what has arrived.
    Collect { command: Command, length: usize },
    /// The payload's buffer, of which `held` bytes were filled, is lent: see [`Decoder::lend_payload`].
    Lent { command: Command, length: usize, held: usize },
    /// In bytes to be discarded. `subject` is the command that announced them, `None` after an
    /// overlong line, where their absence is not reported.
    Skip { left: u64, subject: Option<Subject> },
    /// In an overlong line whose error has been reported.
    LongLine(LongLine),
    /// Nothing more is read.
    Closed,
}

/// Incremental decoder: turns a stream's bytes, fed in pieces of any size, into commands.
///
/// ```
/// use fbptr_command::{Command, Decoder, EndOfInput, Flow, Limits, StreamPosition, Sink, StreamError};
/// #[derive(Default)]
/// struct Heard(Vec<String>);
/// impl Sink for Heard {
///     fn pixel(&mut self, x: i32, y: i32, color: [u8; 4]) { self.0.push(format!("pixel {x} {y} {color:?}")) }
///     fn binary_pixels(&mut self, records: &[u8]) { self.0.push(format!("{} binary", records.len() / 10)) }
///     fn command(&mut self, command: Command, _: StreamPosition) -> Flow { self.0.push(format!("{command:?}")); Flow::Continue }
///     fn error(&mut self, error: StreamError) -> Flow { self.0.push(error.wire_line()); Flow::Continue }
/// }
/// let (mut decoder, mut heard) = (Decoder::new(Limits::default()), Heard::default());
/// for piece in [&b"PX 1 2 ff"[..], b"0000\nSIZ", b"E\nFOO\n"] {
///     assert_eq!(decoder.feed(piece, &mut heard), Flow::Continue);
/// }
/// assert_eq!(decoder.finish(EndOfInput::Stream, &mut heard), Flow::Continue);
/// assert_eq!(heard.0, ["pixel 1 2 [255, 0, 0, 255]", "Size", "ERR 3 19 EVERB FOO: unknown verb, got \"FOO\""]);
/// ```
pub struct Decoder {
    limits: Limits,
    /// Position where the current command begins.
    start: StreamPosition,
    /// Position of the next unread byte.
    here: StreamPosition,
    state: DecoderState,
    /// Beginning of a command whose head is incomplete.
    head: Vec<u8>,
    payload: Vec<u8>,
    pool: Option<PayloadPool>,
    /// Bytes of the payload's buffer whose pages are mapped already because an earlier payload used
    /// it.
    warm_bytes: usize,
    /// Reservation of the memory budget for the payload's buffer.
    payload_held: Option<Reservation>,
    /// True if `PX` accepts one hex digit as a colour.
    takes_grey_digits: bool,
    /// Set when the sink has returned `Flow::Pause` during this call.
    paused: bool,
}

impl Decoder {
    /// Creates a decoder at the beginning of a stream.
    pub fn new(limits: Limits) -> Self {
        // No buffer can be larger than isize::MAX bytes.
        let payload_bytes = limits.payload_bytes.min(isize::MAX as u64);
        Decoder {
            limits: Limits { payload_bytes },
            start: StreamPosition::START,
            here: StreamPosition::START,
            state: DecoderState::Head,
            head: Vec::new(),
            payload: Vec::new(),
            pool: None,
            warm_bytes: 0,
            payload_held: None,
            takes_grey_digits: false,
            paused: false,
        }
    }

    /// Creates a decoder that takes the buffers of large payloads from `pool` and returns them to
    /// it.
    pub fn with_payload_pool(limits: Limits, pool: &PayloadPool) -> Self {
        Decoder { pool: Some(pool.clone()), ..Decoder::new(limits) }
    }

    /// Sets whether `PX x y g` with one hex digit is accepted, as the grey `gg`; by default such a
    /// word is no colour.
    pub fn set_grey_digits(&mut self, on: bool) {
        self.takes_grey_digits = on;
    }

    /// Returns the position of the next byte to be fed.
    pub fn place(&self) -> StreamPosition {
        self.here
    }

    /// Returns whether the stream is between two commands, with nothing pending.
    pub fn is_at_boundary(&self) -> bool {
        self.head.is_empty() && matches!(self.state, DecoderState::Head)
    }

    /// Returns the capacity in bytes of the buffers for an incomplete command.
    pub fn pending_bytes(&self) -> usize {
        self.head.capacity() + self.payload.capacity()
    }

    /// Returns how many bytes the payload in progress still needs.
    pub fn missing_bytes(&self) -> usize {
        match self.state {
            DecoderState::Collect { length, .. } => length - self.payload.len(),
            DecoderState::Lent { length, held, .. } => length - held,
            _ => 0,
        }
    }

    /// Reads the next piece of the stream. After `Stop`, from the sink or because the stream cannot
    /// be decoded further, every later call reads nothing and returns `Stop`. `Pause` is ignored:
    /// all bytes are read.
    pub fn feed(&mut self, mut bytes: &[u8], sink: &mut impl Sink) -> Flow {
        loop {
            match self.feed_some(bytes, sink) {
                (used, Flow::Pause) => bytes = &bytes[used..],
                (_, flow) => return flow,
            }
        }
    }

    /// Reads the next piece of the stream up to the end of the command for which the sink returned
    /// `Pause`, or all of it. Returns the number of bytes read; the caller feeds the rest later.
    pub fn feed_some(&mut self, bytes: &[u8], sink: &mut impl Sink) -> (usize, Flow) {
        let all = bytes.len();
        let mut bytes = bytes;
        self.paused = false;
        while !bytes.is_empty() && !self.paused {
            let used = match self.state {
                // What was read before the lent buffer is back is not its continuation.
                DecoderState::Closed | DecoderState::Lent { .. } => break,
                DecoderState::Head if self.head.is_empty() => self.read_complete(bytes, sink),
                DecoderState::Head => self.read_head(bytes, sink),
                DecoderState::Collect { .. } => self.read_payload(bytes, sink),
                DecoderState::Skip { .. } => self.skip(bytes),
                DecoderState::LongLine(_) => self.read_long_line(bytes),
            };
            bytes = &bytes[used..];
        }
        (all - bytes.len(), self.flow())
    }

    /// Ends the stream and reports what is incomplete. Further calls do nothing.
    pub fn finish(&mut self, end: EndOfInput, sink: &mut impl Sink) -> Flow {
        if matches!(self.state, DecoderState::Closed) {
            return Flow::Stop;
        }
        let head = std::mem::take(&mut self.head);
        if end == EndOfInput::File
            && !head.is_empty()
            && !matches!(frame_kind(&head), FrameKind::Pixel | FrameKind::Run)
        {
            self.line(without_cr(&head), &[], sink);
        } else if !head.is_empty() && !is_idle(&head) {
            let word = match frame_kind(&head) {
                FrameKind::Pixel => &head[..2],
                FrameKind::Run => &head[..7],
                FrameKind::Undecided | FrameKind::Text => words(&head).next().unwrap_or(b""),
            };
            let subject = binary_or_text(word);
            self.error(
                subject,
                ParseError::new(Code::Proto, "the stream ends inside the command", &head),
                sink,
            );
        }
        match std::mem::replace(&mut self.state, DecoderState::Closed) {
            DecoderState::Collect { command, length } => {
                let missing = (length - self.payload.len()) as u64;
                self.unfinished(binary_or_text(command.verb().as_bytes()), missing, sink)
            }
            DecoderState::Lent { command, length, held } => {
                self.unfinished(binary_or_text(command.verb().as_bytes()), (length - held) as u64, sink)
            }
            DecoderState::Skip { left, subject: Some(subject) } => self.unfinished(subject, left, sink),
            DecoderState::Skip { subject: None, .. } | DecoderState::Head | DecoderState::LongLine(_) => {
                Flow::Continue
            }
            DecoderState::Closed => Flow::Stop,
        }
    }

    /// Reports that the stream ended `missing` bytes before a payload did.
    fn unfinished(&mut self, subject: Subject, missing: u64, sink: &mut impl Sink) -> Flow {
        let message = format!("the stream ends {missing} bytes before the payload does");
        let token = subject.name();
        let parse_error = ParseError::new(Code::Proto, message, token.as_bytes());
        sink.error(StreamError::new(self.start, subject, parse_error))
    }

    /// Returns `Stop` if the stream is closed, `Pause` if the sink has asked for that in this call.
    fn flow(&self) -> Flow {
        match self.state {
            DecoderState::Closed => Flow::Stop,
            _ if self.paused => Flow::Pause,
            _ => Flow::Continue,
        }
    }

    /// Applies the sink's answer: pauses this call, or closes the stream.
    fn obey(&mut self, flow: Flow) {
        match flow {
            Flow::Continue => {}
            Flow::Pause => self.paused = true,
            Flow::Stop => self.state = DecoderState::Closed,
        }
    }

    /// Reports an error at the current command to the sink, and applies its answer.
    fn error(&mut self, subject: Subject, parse_error: ParseError, sink: &mut impl Sink) {
        let flow = sink.error(StreamError::new(self.start, subject, parse_error));
        self.obey(flow);
    }

    /// Advances the position past `bytes`.
    fn pass(&mut self, bytes: &[u8]) {
        self.here.byte += bytes.len() as u64;
        self.here.line += count_lf(bytes);
    }
}
