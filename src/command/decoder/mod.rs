//! FRAMING: bytes in, whole commands out, however the transport cut them.
//!
//! At a command boundary the first bytes decide: `PB` is ten bytes, `PXMULTI` a header of fifteen and its run, anything
//! else a line up to LF, after which `:N` bytes of payload may follow. Nothing of a command reaches the sink before its
//! last byte is there. No I/O, no thread.
//!
//! Promises:
//! - the same calls of the sink for every way to cut the stream (but for how many records `pixels` and `binary_pixels` hold);
//! - memory while waiting: a line's limit, plus payload bytes that have come, at most the payload limit (room for a whole large
//!   payload is asked for when some of it has come, and found by the system as it is written);
//! - a refused command's payload is skipped, so that an error never puts the stream out of step;
//! - every byte sequence is survived, and every place is exact: line = 1 + LF bytes before, byte = bytes before.

mod asks;
mod framing;
mod line;
mod payload;

pub(super) use line::PayloadLength;

use super::args::{ParseError, words};
use super::commands::Command;
use super::long_line::LongLine;
use super::payload_pool::PayloadPool;
use super::scan::count_lf;
use super::sink::{Flow, Sink, StreamPosition};
use super::stream_error::{StreamError, Subject};
use crate::error::Code;
use crate::memory::Reservation;
use framing::{FrameKind, binary_or_text, frame_kind};
use line::{is_idle, without_cr};

/// The bytes that a line may have, LF and one CR before it not counted.
pub const MAX_LINE_BYTES: usize = 4096;

/// What a stream may ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// The largest payload, and the largest run of `PXMULTI`, in bytes.
    pub payload_bytes: u64,
}

impl Default for Limits {
    /// 64 MiB a payload.
    fn default() -> Self {
        Limits { payload_bytes: 64 << 20 }
    }
}

/// What the end of a stream means for a line without its LF.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EndOfInput {
    /// A regular file: its last line may lack the LF.
    File,
    /// Everything else: a line without LF is unfinished.
    Stream,
}

/// Where in a command the stream stands.
enum DecoderState {
    /// At a boundary, or in a head of which `Decoder::head` holds what has come.
    Head,
    /// In the payload of a command that waits for it; `Decoder::payload` holds what has come.
    Collect { command: Command, length: usize },
    /// In bytes that nobody wants. `subject` is who announced them, `None` when their lack was as good as said.
    Skip { left: u64, subject: Option<Subject> },
    /// In a line over the limit, its error said.
    LongLine(LongLine),
    /// Nothing more is read.
    Closed,
}

/// Makes commands of a stream's bytes, fed in pieces of any size.
///
/// ```
/// use fbptr::command::{Command, Decoder, EndOfInput, Flow, Limits, StreamPosition, Sink, StreamError};
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
    /// Where the current command begins.
    start: StreamPosition,
    /// Where the next unread byte stands.
    here: StreamPosition,
    state: DecoderState,
    /// The beginning of a command whose head is not whole.
    head: Vec<u8>,
    payload: Vec<u8>,
    pool: Option<PayloadPool>,
    /// Bytes of the payload's room that the system has found already: another payload was in it.
    warm_bytes: usize,
    /// What the payload holds of the budget.
    payload_held: Option<Reservation>,
    /// One hex digit is a colour of `PX`.
    takes_grey_digits: bool,
    /// The sink asked for a rest.
    paused: bool,
}

impl Decoder {
    /// A decoder at the beginning of a stream.
    pub fn new(limits: Limits) -> Self {
        // What a buffer can have at all is a limit, too.
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

    /// The same, which takes the buffers of large payloads from `pool` and gives them back there.
    pub fn with_payload_pool(limits: Limits, pool: &PayloadPool) -> Self {
        Decoder { pool: Some(pool.clone()), ..Decoder::new(limits) }
    }

    /// Takes `PX x y g` with one hex digit from now on, the grey `gg`; otherwise such a word is no colour.
    pub fn set_grey_digits(&mut self, on: bool) {
        self.takes_grey_digits = on;
    }

    /// Where the next byte to be fed stands.
    pub fn place(&self) -> StreamPosition {
        self.here
    }

    /// Whether the stream stands between two commands: nothing is pending.
    pub fn is_at_boundary(&self) -> bool {
        self.head.is_empty() && matches!(self.state, DecoderState::Head)
    }

    /// Bytes held while waiting for the rest of a command.
    pub fn pending_bytes(&self) -> usize {
        self.head.capacity() + self.payload.capacity()
    }

    /// Bytes that the payload which has begun is waiting for.
    pub fn missing_bytes(&self) -> usize {
        match self.state {
            DecoderState::Collect { length, .. } => length - self.payload.len(),
            _ => 0,
        }
    }

    /// Reads the next piece of the stream. After `Stop`, from the sink or because the stream cannot be followed, every
    /// later call reads nothing and answers `Stop`. A `Pause` is not heeded: all bytes are read.
    pub fn feed(&mut self, mut bytes: &[u8], sink: &mut impl Sink) -> Flow {
        loop {
            match self.feed_some(bytes, sink) {
                (used, Flow::Pause) => bytes = &bytes[used..],
                (_, flow) => return flow,
            }
        }
    }

    /// Reads the next piece of the stream up to the end of the command for which the sink answered `Pause`, or all of
    /// it. Answers how many bytes were read; the caller feeds the rest later.
    pub fn feed_some(&mut self, bytes: &[u8], sink: &mut impl Sink) -> (usize, Flow) {
        let all = bytes.len();
        let mut bytes = bytes;
        self.paused = false;
        while !bytes.is_empty() && !self.paused {
            let used = match self.state {
                DecoderState::Closed => break,
                DecoderState::Head if self.head.is_empty() => self.read_complete(bytes, sink),
                DecoderState::Head => self.read_head(bytes, sink),
                DecoderState::Collect { .. } => self.read_payload(bytes, sink),
                DecoderState::Skip { .. } => self.skip(bytes),
                DecoderState::LongLine(_) => self.read_long_line(bytes),
            };
            bytes = &bytes[used..];
        }
        let flow = match self.flow() {
            Flow::Continue if self.paused => Flow::Pause,
            flow => flow,
        };
        (all - bytes.len(), flow)
    }

    /// Ends the stream: says what is left unfinished. Further calls do nothing.
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
            DecoderState::Skip { left, subject: Some(subject) } => self.unfinished(subject, left, sink),
            DecoderState::Skip { subject: None, .. } | DecoderState::Head | DecoderState::LongLine(_) => {
                Flow::Continue
            }
            DecoderState::Closed => Flow::Stop,
        }
    }

    /// The stream has ended `missing` bytes before a payload did.
    fn unfinished(&mut self, subject: Subject, missing: u64, sink: &mut impl Sink) -> Flow {
        let message = format!("the stream ends {missing} bytes before the payload does");
        let token = subject.name();
        let parse_error = ParseError::new(Code::Proto, message, token.as_bytes());
        sink.error(StreamError::new(self.start, subject, parse_error))
    }

    fn flow(&self) -> Flow {
        if matches!(self.state, DecoderState::Closed) { Flow::Stop } else { Flow::Continue }
    }

    fn obey(&mut self, flow: Flow) {
        match flow {
            Flow::Continue => {}
            Flow::Pause => self.paused = true,
            Flow::Stop => self.state = DecoderState::Closed,
        }
    }

    fn error(&mut self, subject: Subject, parse_error: ParseError, sink: &mut impl Sink) {
        let flow = sink.error(StreamError::new(self.start, subject, parse_error));
        self.obey(flow);
    }

    /// Counts bytes as read.
    fn pass(&mut self, bytes: &[u8]) {
        self.here.byte += bytes.len() as u64;
        self.here.line += count_lf(bytes);
    }
}
