//! FRAMING: bytes in, whole commands out, however the transport cut them.
//!
//! At a command boundary the first bytes decide: `PB` is ten bytes, `PXMULTI` a header of fifteen and its run, anything
//! else a line up to LF, after which `:N` bytes of payload may follow. Nothing of a command reaches the sink before its
//! last byte is there. No I/O, no thread.
//!
//! Promises:
//! - the same calls of the sink for every way to cut the stream (but for how many records one `binary_pixels` holds);
//! - memory while waiting: a line's limit, plus payload bytes that have come, at most the payload limit;
//! - a refused command's payload is skipped, so that an error never puts the stream out of step;
//! - every byte sequence is survived, and every place is exact: line = 1 + LF bytes before, byte = bytes before.

use super::args::{Args, Refusal, is_blank, words};
use super::long_line::LongLine;
use super::model::{Command, Rect};
use super::scan::{count_lf, find_lf};
use super::sink::{BINARY_PIXEL_BYTES, Flow, Place, Sink};
use super::spare::SparePayload;
use super::stream_error::{StreamError, Subject};
use super::verb::{Payload, Reading, Verb};
use crate::error::Code;
use crate::simd::text;

/// The bytes that a line may have, LF and one CR before it not counted.
pub const MAX_LINE_BYTES: usize = 4096;

/// Bytes of `PXMULTI`, x, y and n.
const RUN_HEADER_BYTES: usize = 15;

/// Binary pixels are handed on in runs of at most this many: the first look at them must still be in the nearest cache.
const RECORDS_AT_ONCE: usize = 1024;

/// A payload buffer of more than this is put away after use, so that an idle connection holds little.
const KEPT_BYTES: usize = 256 << 10;

/// The room that a payload in pieces begins with, unless it is smaller.
const LEAST_ROOM: usize = 16 << 10;

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
enum State {
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
/// use fbptr::command::{Command, Decoder, EndOfInput, Flow, Limits, Place, Sink, StreamError};
/// #[derive(Default)]
/// struct Heard(Vec<String>);
/// impl Sink for Heard {
///     fn pixel(&mut self, x: i32, y: i32, color: [u8; 4]) { self.0.push(format!("pixel {x} {y} {color:?}")) }
///     fn binary_pixels(&mut self, records: &[u8]) { self.0.push(format!("{} binary", records.len() / 10)) }
///     fn command(&mut self, command: Command, _: Place) -> Flow { self.0.push(format!("{command:?}")); Flow::Continue }
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
    start: Place,
    /// Where the next unread byte stands.
    here: Place,
    state: State,
    /// The beginning of a command whose head is not whole.
    head: Vec<u8>,
    payload: Vec<u8>,
    spare: Option<SparePayload>,
    /// The sink asked for a rest.
    paused: bool,
}

/// What the first bytes of a command tell.
enum Kind {
    Undecided,
    Pixel,
    Run,
    Text,
}

fn kind(bytes: &[u8]) -> Kind {
    const RUN: &[u8] = b"PXMULTI";
    match bytes {
        [b'P', b'B', ..] => Kind::Pixel,
        _ if bytes.starts_with(RUN) => Kind::Run,
        b"P" => Kind::Undecided,
        _ if RUN.starts_with(bytes) => Kind::Undecided,
        _ => Kind::Text,
    }
}

/// A line without the CR before its LF, if it has one.
fn without_cr(line: &[u8]) -> &[u8] {
    line.strip_suffix(b"\r").unwrap_or(line)
}

impl Decoder {
    /// A decoder at the beginning of a stream.
    pub fn new(limits: Limits) -> Self {
        // What a buffer can have at all is a limit, too.
        let payload_bytes = limits.payload_bytes.min(isize::MAX as u64);
        Decoder {
            limits: Limits { payload_bytes },
            start: Place::START,
            here: Place::START,
            state: State::Head,
            head: Vec::new(),
            payload: Vec::new(),
            spare: None,
            paused: false,
        }
    }

    /// The same, which takes the buffers of large payloads from `spare` and gives them back there.
    pub fn with_spare(limits: Limits, spare: &SparePayload) -> Self {
        Decoder { spare: Some(spare.clone()), ..Decoder::new(limits) }
    }

    /// Where the next byte to be fed stands.
    pub fn place(&self) -> Place {
        self.here
    }

    /// Whether the stream stands between two commands: nothing is pending.
    pub fn is_at_boundary(&self) -> bool {
        self.head.is_empty() && matches!(self.state, State::Head)
    }

    /// Bytes held while waiting for the rest of a command.
    pub fn pending_bytes(&self) -> usize {
        self.head.capacity() + self.payload.capacity()
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
                State::Closed => break,
                State::Head if self.head.is_empty() => self.read_whole(bytes, sink),
                State::Head => self.read_head(bytes, sink),
                State::Collect { .. } => self.read_payload(bytes, sink),
                State::Skip { .. } => self.skip(bytes),
                State::LongLine(_) => self.read_long_line(bytes),
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
        if matches!(self.state, State::Closed) {
            return Flow::Stop;
        }
        let head = std::mem::take(&mut self.head);
        if end == EndOfInput::File && !head.is_empty() && !matches!(kind(&head), Kind::Pixel | Kind::Run) {
            self.line(without_cr(&head), &[], sink);
        } else if !head.is_empty() && !is_idle(&head) {
            let word = match kind(&head) {
                Kind::Pixel => &head[..2],
                Kind::Run => &head[..7],
                Kind::Undecided | Kind::Text => words(&head).next().unwrap_or(b""),
            };
            let subject = binary_or_text(word);
            self.error(subject, Refusal::new(Code::Proto, "the stream ends inside the command", &head), sink);
        }
        match std::mem::replace(&mut self.state, State::Closed) {
            State::Collect { command, length } => {
                let missing = (length - self.payload.len()) as u64;
                self.unfinished(binary_or_text(command.verb().as_bytes()), missing, sink)
            }
            State::Skip { left, subject: Some(subject) } => self.unfinished(subject, left, sink),
            State::Skip { subject: None, .. } | State::Head | State::LongLine(_) => Flow::Continue,
            State::Closed => Flow::Stop,
        }
    }

    /// The stream has ended `missing` bytes before a payload did.
    fn unfinished(&mut self, subject: Subject, missing: u64, sink: &mut impl Sink) -> Flow {
        let message = format!("the stream ends {missing} bytes before the payload does");
        let token = subject.name();
        let refusal = Refusal::new(Code::Proto, message, token.as_bytes());
        sink.error(StreamError::new(self.start, subject, refusal))
    }

    fn flow(&self) -> Flow {
        if matches!(self.state, State::Closed) { Flow::Stop } else { Flow::Continue }
    }

    fn obey(&mut self, flow: Flow) {
        match flow {
            Flow::Continue => {}
            Flow::Pause => self.paused = true,
            Flow::Stop => self.state = State::Closed,
        }
    }

    fn error(&mut self, subject: Subject, refusal: Refusal, sink: &mut impl Sink) {
        let flow = sink.error(StreamError::new(self.start, subject, refusal));
        self.obey(flow);
    }

    /// Counts bytes as read.
    fn pass(&mut self, bytes: &[u8]) {
        self.here.byte += bytes.len() as u64;
        self.here.line += count_lf(bytes);
    }

    /// Reads commands that lie whole in `bytes`, from a boundary on; keeps the beginning of one that does not.
    /// Answers how many bytes it took.
    fn read_whole(&mut self, bytes: &[u8], sink: &mut impl Sink) -> usize {
        let mut at = 0;
        while at < bytes.len() && matches!(self.state, State::Head) && !self.paused {
            let (used, lines) =
                text::pixel_lines(&bytes[at..], &mut |x, y, color| sink.pixel(x.into(), y.into(), color));
            self.here.byte += used as u64;
            self.here.line += lines;
            at += used;
            let rest = &bytes[at..];
            if rest.is_empty() {
                break;
            }
            self.start = self.here;
            at += match kind(rest) {
                Kind::Pixel if rest.len() >= BINARY_PIXEL_BYTES => self.binary_pixels(rest, sink),
                Kind::Run if rest.len() >= RUN_HEADER_BYTES => self.run(rest, sink),
                Kind::Text => match find_lf(&rest[..rest.len().min(MAX_LINE_BYTES + 2)]) {
                    Some(lf) if !is_too_long(&rest[..lf]) => {
                        self.pass(&rest[..lf + 1]);
                        lf + 1 + self.line(without_cr(&rest[..lf]), &rest[lf + 1..], sink)
                    }
                    _ => return at + self.keep(rest, sink),
                },
                Kind::Undecided | Kind::Pixel | Kind::Run => return at + self.keep(rest, sink),
            };
        }
        at
    }

    /// Keeps the beginning of a command for the next piece; a line that is already too long is not kept.
    fn keep(&mut self, bytes: &[u8], sink: &mut impl Sink) -> usize {
        let taken = &bytes[..bytes.len().min(MAX_LINE_BYTES + 2)];
        self.pass(taken);
        self.head.extend_from_slice(taken);
        if is_too_long(&self.head) {
            self.begin_long_line(sink);
        }
        taken.len()
    }

    /// Adds to a head that came in pieces, as little as can make it whole. Answers how many bytes it took.
    fn read_head(&mut self, bytes: &[u8], sink: &mut impl Sink) -> usize {
        let wanted = match kind(&self.head) {
            Kind::Undecided => 1,
            Kind::Pixel => BINARY_PIXEL_BYTES - self.head.len(),
            Kind::Run => RUN_HEADER_BYTES - self.head.len(),
            Kind::Text => MAX_LINE_BYTES + 2 - self.head.len(),
        };
        let mut taken = &bytes[..bytes.len().min(wanted)];
        if let (Kind::Text | Kind::Undecided, Some(lf)) = (kind(&self.head), find_lf(taken)) {
            taken = &taken[..lf + 1];
        }
        self.pass(taken);
        let mut head = std::mem::take(&mut self.head);
        head.extend_from_slice(taken);
        match kind(&head) {
            Kind::Pixel if head.len() == BINARY_PIXEL_BYTES => sink.binary_pixels(&head),
            Kind::Run if head.len() == RUN_HEADER_BYTES => {
                self.run_header(&head, &[], sink);
            }
            Kind::Text if head.ends_with(b"\n") && !is_too_long(&head[..head.len() - 1]) => {
                self.line(without_cr(&head[..head.len() - 1]), &[], sink);
            }
            _ => {
                self.head = head;
                if is_too_long(&self.head) {
                    self.begin_long_line(sink);
                }
                return taken.len();
            }
        }
        head.clear();
        self.head = head;
        taken.len()
    }

    /// Hands on the binary pixels at the beginning of `bytes`, of which the first is whole.
    fn binary_pixels(&mut self, bytes: &[u8], sink: &mut impl Sink) -> usize {
        let records = bytes.as_chunks::<BINARY_PIXEL_BYTES>().0;
        let records = &records[..records.len().min(RECORDS_AT_ONCE)];
        let n = records.iter().position(|r| r[0] != b'P' || r[1] != b'B').unwrap_or(records.len());
        let records = records[..n].as_flattened();
        self.pass(records);
        sink.binary_pixels(records);
        records.len()
    }

    /// Reads a `PXMULTI` whose header is whole in `bytes`.
    fn run(&mut self, bytes: &[u8], sink: &mut impl Sink) -> usize {
        let (header, rest) = bytes.split_at(RUN_HEADER_BYTES);
        self.pass(header);
        RUN_HEADER_BYTES + self.run_header(header, rest, sink)
    }

    /// Begins a `PXMULTI`'s run. Answers how many bytes of `rest` it took.
    fn run_header(&mut self, header: &[u8], rest: &[u8], sink: &mut impl Sink) -> usize {
        let &[_, _, _, _, _, _, _, x0, x1, y0, y1, n0, n1, n2, n3] = header else { return 0 };
        let (x, y) = (u16::from_le_bytes([x0, x1]), u16::from_le_bytes([y0, y1]));
        let length = u64::from(u32::from_le_bytes([n0, n1, n2, n3])) * 4;
        if length > self.limits.payload_bytes {
            let subject = binary_or_text(b"PXMULTI");
            return self.refuse_payload(subject, length, rest, sink);
        }
        self.payload(Command::PixelRun { x, y, rgba: Vec::new() }, length, rest, sink)
    }

    /// A payload over the limit: said at the header, then discarded.
    fn refuse_payload(&mut self, subject: Subject, length: u64, rest: &[u8], sink: &mut impl Sink) -> usize {
        let message = format!("a payload has at most {} bytes here", self.limits.payload_bytes);
        let token = format!(":{length}");
        self.refuse(subject, Refusal::new(Code::TooBig, message, token.as_bytes()), length, rest, sink)
    }

    /// Says an error and skips the payload of the refused command. Answers how many bytes of `rest` it took.
    fn refuse(
        &mut self,
        subject: Subject,
        refusal: Refusal,
        payload: u64,
        rest: &[u8],
        sink: &mut impl Sink,
    ) -> usize {
        if payload > 0 {
            self.state = State::Skip { left: payload, subject: Some(subject.clone()) };
        }
        self.error(subject, refusal, sink);
        match self.state {
            State::Skip { .. } if !rest.is_empty() => self.skip(rest),
            _ => 0,
        }
    }

    /// Reads one whole line without its end; `rest` is what follows it in the same piece.
    /// Answers how many bytes of `rest` the payload took.
    fn line(&mut self, line: &[u8], rest: &[u8], sink: &mut impl Sink) -> usize {
        if is_idle(line) {
            return 0;
        }
        let verb_start = line.iter().position(|&b| !is_blank(b)).unwrap_or(0);
        let verb_end =
            line[verb_start..].iter().position(|&b| is_blank(b)).map_or(line.len(), |n| verb_start + n);
        let word = &line[verb_start..verb_end];
        let last_end = line.iter().rposition(|&b| !is_blank(b)).map_or(0, |n| n + 1);
        let last_start = line[..last_end].iter().rposition(|&b| is_blank(b)).map_or(0, |n| n + 1);
        let announced = match &line[last_start..last_end] {
            [b':', digits @ ..] if !digits.is_empty() => match announced(digits) {
                Announced::Length(n) => Some(n),
                Announced::Beyond => {
                    let refusal = Refusal::new(
                        Code::Proto,
                        "a payload's length must be below 2^64",
                        &line[last_start..last_end],
                    );
                    let mut error = StreamError::new(self.start, Subject::of(word), refusal);
                    error.closes = true;
                    self.state = State::Closed;
                    // Whatever it answers: no later command of this stream can be found.
                    let _ = sink.error(error);
                    return 0;
                }
                Announced::Junk => {
                    let message = "the last word after a colon must be a payload's length";
                    let refusal = Refusal::new(Code::Proto, message, &line[last_start..last_end]);
                    self.error(Subject::of(word), refusal, sink);
                    return 0;
                }
            },
            _ => None,
        };
        let arguments = match announced {
            Some(_) => &line[verb_end.min(last_start)..last_start],
            None => &line[verb_end..],
        };
        let length = announced.unwrap_or(0);
        if length > self.limits.payload_bytes {
            return self.refuse_payload(Subject::of(word), length, rest, sink);
        }
        let Some(verb) = Verb::find(word) else {
            let refusal = Refusal::new(Code::Verb, "unknown verb", word);
            return self.refuse(Subject::of(word), refusal, length, rest, sink);
        };
        match read_command(verb, arguments, announced, word) {
            Ok(Command::Pixel { x, y, color }) => {
                sink.pixel(x, y, color);
                0
            }
            Ok(command) => self.payload(command, length, rest, sink),
            Err(refusal) => self.refuse(Subject::Known(verb), refusal, length, rest, sink),
        }
    }

    /// A command whose head is right: runs it if its payload lies in `rest`, else waits for it.
    /// Answers how many bytes of `rest` it took.
    fn payload(&mut self, command: Command, length: u64, rest: &[u8], sink: &mut impl Sink) -> usize {
        let length = length as usize;
        if let Some(payload) = rest.get(..length) {
            self.pass(payload);
            let flow = deliver(command, Bytes::Borrowed(payload), self.start, sink);
            self.obey(flow);
            return length;
        }
        if length > KEPT_BYTES
            && let Some(spare) = &self.spare
        {
            spare.swap_for_larger(&mut self.payload);
        }
        self.state = State::Collect { command, length };
        if rest.is_empty() { 0 } else { self.read_payload(rest, sink) }
    }

    fn read_payload(&mut self, bytes: &[u8], sink: &mut impl Sink) -> usize {
        let State::Collect { length, .. } = self.state else { return 0 };
        let held = self.payload.len();
        let taken = &bytes[..bytes.len().min(length - held)];
        // What has been announced may never come: room is made as bytes do, and never more than for all of them.
        if self.payload.capacity() < held + taken.len() {
            let wanted = (2 * self.payload.capacity()).max(LEAST_ROOM).clamp(held + taken.len(), length);
            if self.payload.try_reserve_exact(wanted - held).is_err() {
                return self.give_up_payload(bytes, sink);
            }
        }
        self.pass(taken);
        self.payload.extend_from_slice(taken);
        if self.payload.len() == length
            && let State::Collect { command, .. } = std::mem::replace(&mut self.state, State::Head)
        {
            let flow = deliver(command, Bytes::Owned(&mut self.payload), self.start, sink);
            self.put_away_payload();
            self.obey(flow);
        }
        taken.len()
    }

    /// There is no memory for the payload that has begun: says so, and discards it to its end.
    fn give_up_payload(&mut self, bytes: &[u8], sink: &mut impl Sink) -> usize {
        let State::Collect { command, length } = std::mem::replace(&mut self.state, State::Head) else {
            return 0;
        };
        let left = (length - self.payload.len()) as u64;
        self.payload = Vec::new();
        let refusal =
            Refusal::new(Code::TooBig, "there is no memory for the payload", format!(":{length}").as_bytes());
        self.refuse(binary_or_text(command.verb().as_bytes()), refusal, left, bytes, sink)
    }

    fn put_away_payload(&mut self) {
        self.payload.clear();
        if self.payload.capacity() > KEPT_BYTES {
            let large = std::mem::take(&mut self.payload);
            if let Some(spare) = &self.spare {
                spare.give(large);
            }
        }
    }

    fn skip(&mut self, bytes: &[u8]) -> usize {
        let State::Skip { left, .. } = &mut self.state else { return 0 };
        let taken = usize::try_from(*left).unwrap_or(usize::MAX).min(bytes.len());
        *left -= taken as u64;
        if *left == 0 {
            self.state = State::Head;
        }
        self.pass(&bytes[..taken]);
        taken
    }

    /// `head` holds the beginning of a line over the limit: says so, and goes on to its end.
    fn begin_long_line(&mut self, sink: &mut impl Sink) {
        let head = std::mem::take(&mut self.head);
        let long = LongLine::new(&head);
        let word = words(&head).next().unwrap_or(b"");
        let refusal = Refusal::new(Code::Proto, format!("a line has at most {MAX_LINE_BYTES} bytes"), &head);
        self.state = State::LongLine(long);
        self.error(Subject::of(word), refusal, sink);
        self.end_long_line();
    }

    fn read_long_line(&mut self, bytes: &[u8]) -> usize {
        let State::LongLine(long) = &mut self.state else { return 0 };
        let taken = long.read(bytes);
        self.pass(&bytes[..taken]);
        self.end_long_line();
        taken
    }

    fn end_long_line(&mut self) {
        let State::LongLine(long) = &self.state else { return };
        let Some(announced) = long.payload() else { return };
        self.state = match announced {
            Announced::Length(0) | Announced::Junk => State::Head,
            Announced::Length(left) => State::Skip { left, subject: None },
            Announced::Beyond => State::Closed,
        };
    }
}

/// What a last word after its colon announces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Announced {
    Length(u64),
    /// Digits, and too many.
    Beyond,
    /// No length.
    Junk,
}

fn announced(digits: &[u8]) -> Announced {
    let mut length = Announced::Length(0);
    for digit in digits {
        length = length.with(*digit);
    }
    length
}

impl Announced {
    /// One more byte after the colon and what came before.
    pub(super) fn with(self, byte: u8) -> Self {
        let digit = u64::from(byte.wrapping_sub(b'0'));
        match self {
            _ if digit > 9 => Announced::Junk,
            Announced::Length(n) => match n.checked_mul(10).and_then(|n| n.checked_add(digit)) {
                Some(n) => Announced::Length(n),
                None => Announced::Beyond,
            },
            other => other,
        }
    }
}

/// Whether a line does nothing: a comment, or blanks alone.
fn is_idle(line: &[u8]) -> bool {
    line.first() == Some(&b'#') || without_cr(line).iter().all(|&b| is_blank(b))
}

/// Whether a line without LF has more bytes than a line may, whatever follows.
fn is_too_long(line: &[u8]) -> bool {
    line.len() > MAX_LINE_BYTES + 1 || (line.len() == MAX_LINE_BYTES + 1 && !line.ends_with(b"\r"))
}

/// The subject of a command that begins with `word`, a binary verb's name included.
fn binary_or_text(word: &[u8]) -> Subject {
    match Verb::all().iter().find(|v| matches!(v.reading, Reading::Binary) && v.name.as_bytes() == word) {
        Some(verb) => Subject::Known(verb),
        None => Subject::of(word),
    }
}

/// Reads a text command's words, the table's counts first.
fn read_command(
    verb: &'static Verb,
    rest: &[u8],
    payload: Option<u64>,
    word: &[u8],
) -> Result<Command, Refusal> {
    let mut args = Args::new(rest);
    if !verb.counts.allows(args.count()) {
        return Err(wrong_count(verb, &args, word));
    }
    match (verb.payload, payload) {
        (Payload::Never, Some(length)) => return Err(unwanted(length)),
        (Payload::Always, None) => return Err(missing(&args, word)),
        _ => {}
    }
    let Reading::Text(parse) = verb.reading else {
        return Err(Refusal::new(Code::Verb, "unknown verb", word));
    };
    // Looked at where it is: taking it out of its Result and putting it back would copy it twice.
    let parsed = parse(&mut args);
    if let Ok(command) = &parsed {
        if verb.payload == Payload::BySubject {
            match (command.payload().is_some(), payload) {
                (false, Some(length)) => return Err(unwanted(length)),
                (true, None) => return Err(missing(&Args::new(rest), word)),
                _ => {}
            }
        }
        let checked = command.check_sizes().and_then(|()| command.check_payload_length(payload.unwrap_or(0)));
        checked.map_err(refusal)?;
    }
    parsed
}

fn refusal(fault: crate::error::Fault) -> Refusal {
    Refusal { code: fault.code, message: fault.message.into(), token: fault.token.unwrap_or_default().into() }
}

fn wrong_count(verb: &Verb, args: &Args<'_>, word: &[u8]) -> Refusal {
    let found = args.count();
    let most = match verb.counts {
        super::verb::Counts::Of(counts) => counts.last().copied().unwrap_or(0),
        super::verb::Counts::From(_) => usize::MAX,
    };
    // The first word too many, or the last one before those that are missing.
    let blamed = match found.min(most) {
        0 if found == 0 => word,
        n if found > most => args.nth_left(n),
        n => args.nth_left(n - 1),
    };
    let syntax = verb.forms.first().map_or("", |f| f.syntax);
    Refusal::new(Code::Args, format!("takes {}, not {found} ({syntax})", verb.counts.in_words()), blamed)
}

fn unwanted(length: u64) -> Refusal {
    Refusal::new(Code::Args, "takes no payload", format!(":{length}").as_bytes())
}

fn missing(args: &Args<'_>, word: &[u8]) -> Refusal {
    let last = if args.count() == 0 { word } else { args.nth_left(args.count() - 1) };
    Refusal::new(Code::Args, "the line must end with a payload's length :N", last)
}

/// A payload, in the piece that was fed or in the decoder's buffer.
enum Bytes<'a> {
    Borrowed(&'a [u8]),
    Owned(&'a mut Vec<u8>),
}

/// Gives a whole command to the sink.
fn deliver(mut command: Command, payload: Bytes<'_>, place: Place, sink: &mut impl Sink) -> Flow {
    let seen: &[u8] = match &payload {
        Bytes::Borrowed(bytes) => bytes,
        Bytes::Owned(bytes) => bytes,
    };
    match command {
        Command::PixelRun { x, y, .. } => return sink.pixel_run(x, y, seen, place),
        Command::Blit { rect: rect @ Rect { .. }, .. } => return sink.blit(rect, seen, place),
        Command::Points { .. } => return sink.points(seen, place),
        _ => {}
    }
    if let Some(own) = command.payload_mut() {
        *own = match payload {
            Bytes::Borrowed(bytes) => bytes.to_vec(),
            // A buffer with much more room than bytes would be held for nothing; it is of use here.
            Bytes::Owned(bytes) if bytes.capacity() / 2 > bytes.len() => bytes.to_vec(),
            Bytes::Owned(bytes) => std::mem::take(bytes),
        };
    }
    match command.check_text() {
        Ok(()) => sink.command(command, place),
        Err(fault) => {
            let subject = Subject::of(command.verb().as_bytes());
            sink.error(StreamError::new(place, subject, refusal(fault)))
        }
    }
}
