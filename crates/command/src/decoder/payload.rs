//! Payloads: collected, passed to the sink, or skipped.

use super::framing::binary_or_text;
use super::line::parse_error;
use super::{Decoder, DecoderState};
use crate::args::ParseError;
use crate::codec::Codec;
use crate::commands::Command;
use crate::sink::{Flow, Sink};
use crate::stream_error::{StreamError, StreamPosition, Subject};
use fbptr_core::error::Code;
use fbptr_core::memory::{MemoryUse, OverBudget, Reservation};
use fbptr_core::simd::allocator;
use std::collections::TryReserveError;

/// Largest payload buffer that grows by doubling as bytes arrive, and that is kept afterwards.
/// If doubling would exceed it, the payload moves to a buffer for its whole length, which is
/// returned to the pool after use: an idle connection holds little memory, and so does one whose
/// payload has only begun.
const KEPT_BYTES: usize = 256 << 10;

/// Step in bytes in which memory is reserved for a large payload.
const RESERVED_BYTES: usize = 1 << 20;

/// Length of a payload of pixels from which the sink is given its buffer. Shorter ones, such as whole
/// frames, are drawn from the decoder's, which is used again.
const LONG_BYTES: usize = 16 << 20;

/// Initial capacity for a payload that arrives in pieces, unless it is smaller.
const LEAST_ROOM: usize = 16 << 10;

impl Decoder {
    /// Handles a command whose head is valid: runs it if its payload is complete in `rest`,
    /// otherwise starts collecting. Returns the number of bytes read from `rest`.
    pub(super) fn payload(
        &mut self,
        command: Command,
        length: u64,
        rest: &[u8],
        sink: &mut impl Sink,
    ) -> usize {
        let length = length as usize;
        if let Some(payload) = rest.get(..length) {
            self.pass(payload);
            let flow = deliver(command, Bytes::Borrowed(payload), self.start, sink);
            self.obey(flow);
            return length;
        }
        self.state = DecoderState::Collect { command, length };
        if rest.is_empty() { 0 } else { self.read_payload(rest, sink) }
    }

    /// Collects bytes of a payload, and runs the command when it is complete. Returns the number of
    /// bytes read.
    pub(super) fn read_payload(&mut self, bytes: &[u8], sink: &mut impl Sink) -> usize {
        let DecoderState::Collect { length, .. } = self.state else { return 0 };
        let held = self.payload.len();
        let taken = &bytes[..bytes.len().min(length - held)];
        // The announced bytes may never arrive: the buffer grows as they do, and never beyond all
        // of them.
        if self.payload.capacity() < held + taken.len() {
            let expected = (2 * self.payload.capacity()).max(LEAST_ROOM).clamp(held + taken.len(), length);
            let result = match expected <= KEPT_BYTES {
                true => self.payload.try_reserve_exact(expected - held),
                false => self.make_large_room(length),
            };
            if result.is_err() {
                let why = "there is no memory for the payload".to_owned();
                return self.give_up_payload(bytes, Code::TooBig, why, sink);
            }
        }
        if let Err(e) = self.reserve_payload(held + taken.len(), length) {
            return self.give_up_payload(bytes, e.code(), e.to_string(), sink);
        }
        self.pass(taken);
        self.payload.extend_from_slice(taken);
        self.end_payload(sink);
        taken.len()
    }

    /// Runs the command whose payload is being collected if it is complete.
    pub(super) fn end_payload(&mut self, sink: &mut impl Sink) {
        if let DecoderState::Collect { length, .. } = self.state
            && self.payload.len() == length
            && let DecoderState::Collect { command, .. } =
                std::mem::replace(&mut self.state, DecoderState::Head)
        {
            let payload = Bytes::Owned(&mut self.payload, &mut self.payload_held);
            let flow = deliver(command, payload, self.start, sink);
            self.put_away_payload();
            self.obey(flow);
        }
    }

    /// Moves to a buffer for the whole payload: a used one from the pool, or a new one, in huge
    /// pages where they help. The system maps no more pages of a new one than are written.
    pub(super) fn make_large_room(&mut self, length: usize) -> Result<(), TryReserveError> {
        let mut room = self.pool.as_ref().and_then(|pool| pool.take(length)).unwrap_or_default();
        self.warm_bytes = room.capacity();
        if room.capacity() < length {
            room.try_reserve_exact(length)?;
            allocator::prefer_huge_pages(&mut room);
        }
        room.extend_from_slice(&self.payload);
        self.payload = room;
        Ok(())
    }

    /// Reserves memory for the first `filled` bytes of a payload of `length` bytes. Of a new large
    /// buffer the system maps the pages that are written, the last of them a huge page perhaps, so
    /// that is reserved in steps; a used buffer is reserved in full.
    pub(super) fn reserve_payload(&mut self, filled: usize, length: usize) -> Result<(), OverBudget> {
        let capacity = self.payload.capacity();
        let mapped = (filled + allocator::mapped_ahead(capacity)).min(length).max(self.warm_bytes);
        let held = match &mut self.payload_held {
            Some(held) if held.bytes() >= mapped as u64 => return Ok(()),
            Some(held) => held,
            none => {
                let Some(pool) = &self.pool else { return Ok(()) };
                none.insert(pool.budget().empty(MemoryUse::Payloads))
            }
        };
        let room = match capacity {
            0..=KEPT_BYTES => capacity,
            _ => mapped.next_multiple_of(RESERVED_BYTES).min(length).max(self.warm_bytes),
        };
        held.try_cover(room as u64)
    }

    /// Reports that there is no memory for the current payload, and skips the rest of it. Returns
    /// the number of bytes read.
    fn give_up_payload(&mut self, bytes: &[u8], code: Code, why: String, sink: &mut impl Sink) -> usize {
        let DecoderState::Collect { command, length } =
            std::mem::replace(&mut self.state, DecoderState::Head)
        else {
            return 0;
        };
        let left = (length - self.payload.len()) as u64;
        (self.payload, self.payload_held, self.warm_bytes) = (Vec::new(), None, 0);
        let parse_error = ParseError::new(code, why, format!(":{length}").as_bytes());
        self.refuse(binary_or_text(command.verb().as_bytes()), parse_error, left, bytes, sink)
    }

    /// Empties the payload's buffer after use: a large one goes to the pool, and a small one is
    /// kept unless memory is short.
    fn put_away_payload(&mut self) {
        self.warm_bytes = 0;
        self.payload.clear();
        if self.payload.capacity() > KEPT_BYTES {
            let large = std::mem::take(&mut self.payload);
            if let Some(pool) = &self.pool {
                pool.give(large);
            }
        }
        if let Some(held) = &mut self.payload_held {
            if held.budget().is_tight() {
                self.payload = Vec::new();
            }
            held.shrink_to(self.payload.capacity() as u64);
        }
    }

    /// Discards bytes of a refused command's payload. Returns the number of bytes read.
    pub(super) fn skip(&mut self, bytes: &[u8]) -> usize {
        let DecoderState::Skip { left, .. } = &mut self.state else { return 0 };
        let taken = usize::try_from(*left).unwrap_or(usize::MAX).min(bytes.len());
        *left -= taken as u64;
        if *left == 0 {
            self.state = DecoderState::Head;
        }
        self.pass(&bytes[..taken]);
        taken
    }

    /// Refuses a payload over the limit as soon as its length is known, and skips it.
    pub(super) fn refuse_payload(
        &mut self,
        subject: Subject,
        length: u64,
        rest: &[u8],
        sink: &mut impl Sink,
    ) -> usize {
        let message = format!("a payload has at most {} bytes here", self.limits.payload_bytes);
        let token = format!(":{length}");
        self.refuse(subject, ParseError::new(Code::TooBig, message, token.as_bytes()), length, rest, sink)
    }

    /// Reports an error and skips the payload of the refused command. Returns the number of bytes
    /// read from `rest`.
    pub(super) fn refuse(
        &mut self,
        subject: Subject,
        parse_error: ParseError,
        payload: u64,
        rest: &[u8],
        sink: &mut impl Sink,
    ) -> usize {
        if payload > 0 {
            self.state = DecoderState::Skip { left: payload, subject: Some(subject.clone()) };
        }
        self.error(subject, parse_error, sink);
        match self.state {
            DecoderState::Skip { .. } if !rest.is_empty() => self.skip(rest),
            _ => 0,
        }
    }
}

/// A payload, in the caller's bytes or in the decoder's buffer.
enum Bytes<'a> {
    Borrowed(&'a [u8]),
    /// The buffer, and the reservation that covers it.
    Owned(&'a mut Vec<u8>, &'a mut Option<Reservation>),
}

/// Passes a complete command to the sink.
fn deliver(mut command: Command, payload: Bytes<'_>, place: StreamPosition, sink: &mut impl Sink) -> Flow {
    let seen: &[u8] = match &payload {
        Bytes::Borrowed(bytes) => bytes,
        Bytes::Owned(bytes, _) => bytes,
    };
    // What takes long is the sink's to keep, so that it can do it in pieces.
    let is_long = matches!(&payload, Bytes::Owned(bytes, _) if bytes.len() > LONG_BYTES);
    match command {
        _ if is_long => {}
        Command::PixelRun { x, y, .. } => return sink.pixel_run(x, y, seen, place),
        Command::Blit { rect, .. } => return sink.blit(rect, seen, place),
        Command::Points { .. } => return sink.points(seen, place),
        _ => {}
    }
    let mut moved = None;
    if let Some(own) = Codec::payload_mut(&mut command) {
        *own = match payload {
            Bytes::Borrowed(bytes) => bytes.to_vec(),
            // The command would hold a buffer with much unused capacity, which the decoder can
            // reuse.
            Bytes::Owned(bytes, _) if bytes.capacity() / 2 > bytes.len() => bytes.to_vec(),
            Bytes::Owned(bytes, held) => {
                moved = held.take();
                std::mem::take(bytes)
            }
        };
    }
    match command.validate_payload() {
        Ok(()) => {
            if let Some(held) = moved {
                sink.payload_held(held);
            }
            sink.command(command, place)
        }
        Err(fault) => {
            let subject = Subject::of(command.verb().as_bytes());
            sink.error(StreamError::new(place, subject, parse_error(fault)))
        }
    }
}
