//! Payloads that the transport reads by itself: into the buffer that they are run from.
//!
//! In: a decoder within a payload, and a transport that can read as many bytes as that still lacks. Out:
//! the same calls of the sink as if the bytes had been fed. A payload that is fed is copied from the
//! transport's buffer to the decoder's; one that is lent is not.

use super::{Decoder, DecoderState};
use crate::scan::count_lf;
use crate::sink::{Flow, Sink};
use std::io::Read;

/// Buffer of a payload that a decoder has begun to collect, lent to whoever reads the rest of it.
#[derive(Debug)]
pub struct LentPayload {
    /// The payload's first bytes, with capacity for all of them.
    bytes: Vec<u8>,
    length: usize,
}

impl LentPayload {
    /// Returns the number of bytes that the payload still lacks.
    pub fn missing(&self) -> usize {
        self.length - self.bytes.len()
    }

    /// Reads the bytes that the payload lacks, and none after them. Returns how many were read: fewer
    /// if the input has ended, or failed.
    pub fn read_from(&mut self, input: impl Read) -> usize {
        let before = self.bytes.len();
        let missing = self.missing() as u64;
        // What was read before an error is in the buffer.
        let _ = input.take(missing).read_to_end(&mut self.bytes);
        self.bytes.len() - before
    }
}

impl Decoder {
    /// Lends the buffer of the payload that is being collected, with capacity for all of it; `None` if
    /// there is no such payload, or no memory for the rest, which is reported when its bytes are fed.
    /// Until it is taken back the decoder reads nothing that is fed.
    pub fn lend_payload(&mut self) -> Option<LentPayload> {
        let DecoderState::Collect { length, .. } = self.state else { return None };
        if self.payload.capacity() < length {
            self.make_large_room(length).ok()?;
        }
        self.reserve_payload(length, length).ok()?;
        let DecoderState::Collect { command, .. } = std::mem::replace(&mut self.state, DecoderState::Head)
        else {
            return None;
        };
        let bytes = std::mem::take(&mut self.payload);
        self.state = DecoderState::Lent { command, length, held: bytes.len() };
        Some(LentPayload { bytes, length })
    }

    /// Takes back what [`Decoder::lend_payload`] lent, and runs the command if its payload is complete
    /// now. Returns the number of bytes read, and what the sink returned.
    pub fn take_back(&mut self, payload: LentPayload, sink: &mut impl Sink) -> (usize, Flow) {
        self.paused = false;
        let DecoderState::Lent { command, length, held } =
            std::mem::replace(&mut self.state, DecoderState::Head)
        else {
            return (0, self.flow());
        };
        self.state = DecoderState::Collect { command, length };
        self.payload = payload.bytes;
        let read = &self.payload[held..];
        let (bytes, lines) = (read.len(), count_lf(read));
        self.here.byte += bytes as u64;
        self.here.line += lines;
        self.end_payload(sink);
        (bytes, self.flow())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Command, EndOfInput, Limits, StreamError, StreamPosition};

    /// Notes what it is told.
    #[derive(Default)]
    struct Notes(Vec<String>);

    impl Sink for Notes {
        fn pixel(&mut self, x: i32, y: i32, _: [u8; 4]) {
            self.0.push(format!("pixel {x} {y}"));
        }
        fn binary_pixels(&mut self, _: &[u8]) {}
        fn command(&mut self, command: Command, place: StreamPosition) -> Flow {
            self.0.push(format!("{command:?} at {place:?}"));
            Flow::Pause
        }
        fn error(&mut self, error: StreamError) -> Flow {
            self.0.push(error.wire_line());
            Flow::Continue
        }
    }

    const STREAM: &[u8] = b"TEXT 1 2 ff :12\nabc\ndef\nghi\nSIZE\nBLIT 0 0 1 1 :4\n\n\n\n\nNOPE\n";

    /// Decodes the stream up to `cut` by feeding it, then lends if that is possible and reads the rest
    /// of that payload from `rest`, then feeds what is left.
    fn notes(cut: usize, lends: bool, end: usize) -> (Vec<String>, StreamPosition) {
        let (mut decoder, mut notes) = (Decoder::new(Limits::default()), Notes::default());
        let mut rest = &STREAM[cut..end];
        let _ = decoder.feed(&STREAM[..cut], &mut notes);
        if lends && let Some(mut payload) = decoder.lend_payload() {
            let missing = payload.missing();
            assert_eq!(decoder.missing_bytes(), missing);
            assert_eq!(decoder.feed_some(b"x", &mut notes).0, 0, "what it has lent is not here");
            let read = payload.read_from(&mut rest);
            assert_eq!(read, missing.min(end - cut));
            let count = notes.0.len();
            let (taken, flow) = decoder.take_back(payload, &mut notes);
            assert_eq!((taken, flow == Flow::Pause), (read, notes.0.len() > count));
        }
        let _ = decoder.feed(rest, &mut notes);
        let _ = decoder.finish(EndOfInput::Stream, &mut notes);
        (notes.0, decoder.place())
    }

    #[test]
    fn lent_payloads_are_those_that_are_fed_wherever_they_are_cut_and_wherever_they_end() {
        let lent = (0..STREAM.len()).filter(|cut| {
            let (mut decoder, mut notes) = (Decoder::new(Limits::default()), Notes::default());
            let _ = decoder.feed(&STREAM[..*cut], &mut notes);
            decoder.lend_payload().is_some()
        });
        assert_eq!(lent.count(), 12 + 4, "after the heads, and within the payloads");
        for cut in 0..STREAM.len() {
            for end in cut..=STREAM.len() {
                assert_eq!(notes(cut, true, end), notes(cut, false, end), "{cut} {end}");
            }
        }
    }

    #[test]
    fn a_payload_that_is_not_back_at_the_end_is_missing() {
        let (mut decoder, mut notes) = (Decoder::new(Limits::default()), Notes::default());
        let _ = decoder.feed(&STREAM[..20], &mut notes);
        let payload = decoder.lend_payload();
        assert!(payload.is_some() && decoder.lend_payload().is_none());
        let _ = decoder.finish(EndOfInput::Stream, &mut notes);
        assert!(notes.0[0].contains("the stream ends 8 bytes before the payload does"), "{:?}", notes.0);
    }
}
