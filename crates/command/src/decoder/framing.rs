//! Framing: the boundaries of commands and the ends of their heads.

use super::line::without_cr;
use super::{Decoder, DecoderState, MAX_LINE_BYTES};
use crate::args::{ParseError, words};
use crate::commands::Command;
use crate::decoder::PayloadLength;
use crate::long_line::LongLine;
use crate::scan::find_lf;
use crate::sink::{BINARY_PIXEL_BYTES, Sink};
use crate::stream_error::Subject;
use crate::verb::{Encoding, Verb};
use crate::{binary_pixels, pixel_lexer, plain_line};
use fbptr_core::error::Code;

/// Bytes of a `PXMULTI` header: the verb, x, y and n.
const RUN_HEADER_BYTES: usize = 15;

/// Most bytes of binary pixels passed to the sink at once: the first records must still be in the
/// L1 cache when the sink reads them.
const BYTES_AT_ONCE: usize = 1024 * BINARY_PIXEL_BYTES;

/// Kind of a command by its first bytes.
pub(super) enum FrameKind {
    Undecided,
    Pixel,
    Run,
    Text,
}

/// Returns the kind of the command that begins with `bytes`.
pub(super) fn frame_kind(bytes: &[u8]) -> FrameKind {
    const RUN: &[u8] = b"PXMULTI";
    match bytes {
        [b'P', b'B', ..] => FrameKind::Pixel,
        _ if bytes.starts_with(RUN) => FrameKind::Run,
        b"P" => FrameKind::Undecided,
        _ if RUN.starts_with(bytes) => FrameKind::Undecided,
        _ => FrameKind::Text,
    }
}

impl Decoder {
    /// Reads the complete commands in `bytes`, starting at a boundary; stores the beginning of an
    /// incomplete one. Returns the number of bytes read.
    pub(super) fn read_complete(&mut self, bytes: &[u8], sink: &mut impl Sink) -> usize {
        let mut at = 0;
        while at < bytes.len() && matches!(self.state, DecoderState::Head) && !self.paused {
            let (used, lines) = pixel_lexer::pixel_records(&bytes[at..], &mut |records| sink.pixels(records));
            self.here.byte += used as u64;
            self.here.line += lines;
            at += used;
            let rest = &bytes[at..];
            if rest.is_empty() {
                break;
            }
            let used = self.plain_lines(rest, sink);
            if used > 0 {
                at += used;
                continue;
            }
            self.start = self.here;
            at += match frame_kind(rest) {
                FrameKind::Pixel if rest.len() >= BINARY_PIXEL_BYTES => self.binary_pixels(rest, sink),
                FrameKind::Run if rest.len() >= RUN_HEADER_BYTES => self.run(rest, sink),
                FrameKind::Text => match find_lf(&rest[..rest.len().min(MAX_LINE_BYTES + 2)]) {
                    Some(lf) if !is_too_long(&rest[..lf]) => {
                        self.here.byte += lf as u64 + 1;
                        self.here.line += 1;
                        lf + 1 + self.line(without_cr(&rest[..lf]), &rest[lf + 1..], sink)
                    }
                    _ => return at + self.hold_head(rest, sink),
                },
                FrameKind::Undecided | FrameKind::Pixel | FrameKind::Run => {
                    return at + self.hold_head(rest, sink);
                }
            };
        }
        at
    }

    /// Reads the plain lines of figures at the beginning of `bytes`. Returns the number of bytes read.
    fn plain_lines(&mut self, bytes: &[u8], sink: &mut impl Sink) -> usize {
        let mut used = 0;
        while matches!(self.state, DecoderState::Head) && !self.paused {
            let Some((figure, length)) = plain_line::figure(&bytes[used..]) else { break };
            self.start = self.here;
            self.here.byte += length as u64;
            self.here.line += 1;
            used += length;
            let flow = sink.figure(figure, self.start);
            self.obey(flow);
        }
        used
    }

    /// Stores the beginning of a command for the next piece; a line that is already too long is not
    /// stored.
    fn hold_head(&mut self, bytes: &[u8], sink: &mut impl Sink) -> usize {
        let taken = &bytes[..bytes.len().min(MAX_LINE_BYTES + 2)];
        self.pass(taken);
        self.head.extend_from_slice(taken);
        if is_too_long(&self.head) {
            self.begin_long_line(sink);
        }
        taken.len()
    }

    /// Adds to an incomplete head as few bytes as can complete it. Returns the number of bytes
    /// read.
    pub(super) fn read_head(&mut self, bytes: &[u8], sink: &mut impl Sink) -> usize {
        let expected = match frame_kind(&self.head) {
            FrameKind::Undecided => 1,
            FrameKind::Pixel => BINARY_PIXEL_BYTES - self.head.len(),
            FrameKind::Run => RUN_HEADER_BYTES - self.head.len(),
            FrameKind::Text => MAX_LINE_BYTES + 2 - self.head.len(),
        };
        let mut taken = &bytes[..bytes.len().min(expected)];
        if let (FrameKind::Text | FrameKind::Undecided, Some(lf)) = (frame_kind(&self.head), find_lf(taken)) {
            taken = &taken[..lf + 1];
        }
        self.pass(taken);
        let mut head = std::mem::take(&mut self.head);
        head.extend_from_slice(taken);
        match frame_kind(&head) {
            FrameKind::Pixel if head.len() == BINARY_PIXEL_BYTES => sink.binary_pixels(&head),
            FrameKind::Run if head.len() == RUN_HEADER_BYTES => {
                self.run_header(&head, &[], sink);
            }
            FrameKind::Text if head.ends_with(b"\n") && !is_too_long(&head[..head.len() - 1]) => {
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

    /// Passes the binary pixels at the beginning of `bytes` to the sink; the first one is complete.
    /// Returns the number of bytes read.
    fn binary_pixels(&mut self, bytes: &[u8], sink: &mut impl Sink) -> usize {
        let (count, lines) = binary_pixels::leading_records(&bytes[..bytes.len().min(BYTES_AT_ONCE)]);
        let records = &bytes[..count * BINARY_PIXEL_BYTES];
        self.here.byte += records.len() as u64;
        self.here.line += lines;
        sink.binary_pixels(records);
        records.len()
    }

    /// Reads a `PXMULTI` whose header is complete in `bytes`. Returns the number of bytes read.
    fn run(&mut self, bytes: &[u8], sink: &mut impl Sink) -> usize {
        let (header, rest) = bytes.split_at(RUN_HEADER_BYTES);
        self.pass(header);
        RUN_HEADER_BYTES + self.run_header(header, rest, sink)
    }

    /// Starts the run of a `PXMULTI`. Returns the number of bytes read from `rest`.
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

    /// Reports an overlong line, whose beginning is in `head`, and continues to its end.
    fn begin_long_line(&mut self, sink: &mut impl Sink) {
        let head = std::mem::take(&mut self.head);
        let long = LongLine::new(&head);
        let word = words(&head).next().unwrap_or(b"");
        let parse_error =
            ParseError::new(Code::Proto, format!("a line has at most {MAX_LINE_BYTES} bytes"), &head);
        self.state = DecoderState::LongLine(long);
        self.error(Subject::of(word), parse_error, sink);
        self.end_long_line();
    }

    /// Reads on in an overlong line. Returns the number of bytes read.
    pub(super) fn read_long_line(&mut self, bytes: &[u8]) -> usize {
        let DecoderState::LongLine(long) = &mut self.state else { return 0 };
        let taken = long.read(bytes);
        self.pass(&bytes[..taken]);
        self.end_long_line();
        taken
    }

    /// Leaves an overlong line once it has ended: skips the payload that it announces, or closes
    /// the stream if that length does not fit in 64 bits.
    fn end_long_line(&mut self) {
        let DecoderState::LongLine(long) = &self.state else { return };
        let Some(payload_length) = long.payload() else { return };
        self.state = match payload_length {
            PayloadLength::Length(0) | PayloadLength::Junk => DecoderState::Head,
            PayloadLength::Length(left) => DecoderState::Skip { left, subject: None },
            PayloadLength::Beyond => DecoderState::Closed,
        };
    }
}

/// Returns whether a line without LF is over the limit, whatever follows.
fn is_too_long(line: &[u8]) -> bool {
    line.len() > MAX_LINE_BYTES + 1 || (line.len() == MAX_LINE_BYTES + 1 && !line.ends_with(b"\r"))
}

/// Returns the subject of a command that begins with `word`, binary verbs included.
pub(super) fn binary_or_text(word: &[u8]) -> Subject {
    match Verb::all().iter().find(|v| v.encoding == Encoding::Binary && v.name.as_bytes() == word) {
        Some(verb) => Subject::Known(verb),
        None => Subject::of(word),
    }
}
