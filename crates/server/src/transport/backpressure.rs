//! Backpressure: counts the batches of one connection that are in flight to the render thread, and
//! decides when the connection may be read again.

use fbptr_command::LentPayload;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Number of missing bytes from which a payload is large.
const LARGE_BYTES: usize = 1 << 20;

/// Most batches of one connection in flight, in general and within a large payload. There are fewer
/// than pooled buffers, so that other connections get one, too.
const MAX_IN_FLIGHT: usize = 3;
const MAX_PAYLOAD_IN_FLIGHT: usize = 5;
/// Most batches in flight of a connection that may begin a large payload while others are within
/// theirs. A payload of which one batch has arrived is still collected in a small buffer
/// (`KEPT_BYTES` in `decoder/payload.rs` of `fbptr-command`).
const MAX_IN_FLIGHT_AT_START: usize = 1;

/// State that decides whether a socket is read.
#[derive(Default)]
pub(super) struct Backpressure {
    /// Sizes in bytes of the batches in flight, oldest first.
    in_flight: VecDeque<usize>,
    /// Bytes of a large payload that have not been read, as far as the render thread has reported.
    payload_left: usize,
    /// Set when the render thread has released a batch with no part of a large payload since the
    /// connection or its last large payload began.
    sends_small: bool,
    /// Bytes of a large payload that the render thread has not released yet.
    large_left: usize,
    /// Set while the socket may have bytes: the selector has reported it, and no read has found it
    /// empty since.
    pub has_bytes: Arc<AtomicBool>,
    /// Set while it is in the ready queue, or a thread reads it.
    pub is_taken: bool,
    /// Set when the connection has ended: bytes that still arrive are discarded.
    pub is_over: bool,
    /// Set when the end of the input has been read.
    pub is_at_end: bool,
    /// Of a connection with a thread of its own: the large payload that it is to read, whether it reads
    /// a batch, and whether the current payload is read in batches because it was not lent.
    lent: Option<LentPayload>,
    is_reading: bool,
    is_refused: bool,
}

impl Backpressure {
    /// Returns the number of batches in flight.
    pub fn in_flight(&self) -> usize {
        self.in_flight.len()
    }

    /// Returns whether the socket may have bytes and no thread has it.
    pub fn is_free(&self) -> bool {
        self.has_bytes.load(Ordering::Relaxed) && !self.is_taken && !self.is_at_end
    }

    /// Returns whether it may be read: fewer batches than the limit are in flight, or its bytes are
    /// discarded. `others_are_large` tells whether other connections are within large payloads.
    pub fn may_read(&self, others_are_large: bool) -> bool {
        let most = match () {
            () if self.is_within_payload() => MAX_PAYLOAD_IN_FLIGHT,
            () if others_are_large && !self.sends_small => MAX_IN_FLIGHT_AT_START,
            () => MAX_IN_FLIGHT,
        };
        self.in_flight() < most || self.is_over
    }

    /// Returns whether a connection with a thread of its own may read a batch, and notes that it does:
    /// not within a large payload before it is lent or refused.
    pub fn may_begin_read(&mut self) -> bool {
        let waits = self.payload_left >= LARGE_BYTES && !self.is_refused && !self.is_over;
        self.is_reading = !waits && self.may_read(false);
        self.is_reading
    }

    /// Asks `lend` for the large payload that the connection is within, if there is one, and no part of
    /// it is on its way.
    pub fn borrow(&mut self, lend: &mut dyn FnMut() -> Option<LentPayload>) {
        let is_due = self.payload_left >= LARGE_BYTES && self.in_flight.is_empty();
        if is_due && !self.is_reading && !self.is_refused {
            self.lent = lend();
            self.is_refused = self.lent.is_none();
        }
    }

    /// Takes the payload that was lent.
    pub fn take_lent(&mut self) -> Option<LentPayload> {
        self.lent.take()
    }

    /// Notes that a batch was read.
    pub fn on_read(&mut self, bytes: usize) {
        self.is_reading = false;
        self.in_flight.push_back(bytes);
        self.payload_left = self.payload_left.saturating_sub(bytes);
    }

    /// Notes that the render thread has released the oldest batch, after which its current payload
    /// lacks `payload_left` bytes.
    pub fn on_release(&mut self, payload_left: usize) {
        let released = self.in_flight.pop_front().unwrap_or(0);
        // The last part of a large payload counts, too, though less than `LARGE_BYTES` are missing.
        let is_large = payload_left >= LARGE_BYTES || self.payload_left > 0;
        let read: usize = self.in_flight.iter().sum();
        self.payload_left = if is_large { payload_left.saturating_sub(read) } else { 0 };
        self.is_refused &= is_large;
        self.sends_small = !is_large && self.large_left == 0;
        self.large_left = if is_large { payload_left } else { self.large_left.saturating_sub(released) };
    }

    /// Returns whether the next bytes belong to a large payload that has begun.
    pub fn is_within_payload(&self) -> bool {
        self.payload_left > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_payload_is_over_when_its_last_byte_is_read_though_it_did_not_come_back() {
        const PIECE: usize = LARGE_BYTES / 4;
        let mut backpressure = Backpressure::default();
        backpressure.on_read(PIECE);
        backpressure.on_read(PIECE);
        assert!(
            !backpressure.is_within_payload() && backpressure.in_flight() == 2,
            "nobody has looked into them"
        );
        // After the first batch 1.5 large sizes are missing, of which a quarter is in flight.
        backpressure.on_release(6 * PIECE);
        assert!(backpressure.is_within_payload() && backpressure.in_flight() == 1);
        for _ in 0..4 {
            backpressure.on_read(PIECE);
            assert!(backpressure.is_within_payload());
        }
        backpressure.on_read(PIECE);
        assert!(!backpressure.is_within_payload());
        for missing in [5, 4, 3, 2, 1] {
            backpressure.on_release(missing * PIECE);
            assert!(!backpressure.is_within_payload(), "{missing} pieces are on their way");
        }
        // The last batch contained the end, and the beginning of the next payload.
        backpressure.on_release(5 * PIECE);
        assert!(backpressure.is_within_payload() && backpressure.in_flight() == 0);
    }

    #[test]
    fn few_are_on_their_way_and_some_more_within_a_large_payload() {
        let mut backpressure = Backpressure::default();
        let fill = |backpressure: &mut Backpressure| {
            while backpressure.may_read(false) {
                backpressure.on_read(1000);
            }
            backpressure.in_flight()
        };
        assert_eq!(fill(&mut backpressure), MAX_IN_FLIGHT);
        backpressure.on_release(4 * LARGE_BYTES);
        assert_eq!(fill(&mut backpressure), MAX_PAYLOAD_IN_FLIGHT);
        // The payload is fully read: reading waits until some batches are released.
        backpressure.on_read(8 * LARGE_BYTES);
        assert!(!backpressure.is_within_payload() && !backpressure.may_read(false));
        for in_flight in (MAX_IN_FLIGHT..=MAX_PAYLOAD_IN_FLIGHT).rev() {
            backpressure.on_release(1000);
            assert!(backpressure.in_flight() == in_flight && !backpressure.may_read(false));
        }
        backpressure.on_release(0);
        assert!(backpressure.may_read(false));
        assert_eq!(fill(&mut backpressure), MAX_IN_FLIGHT);
        backpressure.is_over = true;
        assert!(backpressure.may_read(false), "what nobody wants is read and thrown away");
    }

    #[test]
    fn small_payloads_do_not_count() {
        let mut backpressure = Backpressure::default();
        for payload_left in [LARGE_BYTES - 1, 0, 100] {
            backpressure.on_read(1000);
            backpressure.on_release(payload_left);
            assert!(!backpressure.is_within_payload());
        }
    }

    #[test]
    fn a_connection_that_may_begin_a_large_payload_has_one_batch_in_flight_beside_others() {
        const PIECE: usize = LARGE_BYTES / 4;
        let mut backpressure = Backpressure::default();
        let may_read = |b: &Backpressure| [b.may_read(false), b.may_read(true)];
        backpressure.on_read(PIECE);
        assert_eq!(may_read(&backpressure), [true, false], "it is new");
        // A large payload: it is read as far as for one.
        backpressure.on_release(5 * PIECE);
        (0..4).for_each(|_| backpressure.on_read(PIECE));
        assert_eq!(may_read(&backpressure), [true, true]);
        backpressure.on_read(PIECE);
        (0..5).rev().for_each(|missing| backpressure.on_release(missing * PIECE));
        // It has ended, and another may begin.
        backpressure.on_read(PIECE);
        assert_eq!(may_read(&backpressure), [true, false]);
        // None did, though the batch ends within a small one.
        backpressure.on_release(PIECE / 3);
        backpressure.on_read(PIECE);
        assert_eq!(may_read(&backpressure), [true, true]);
        backpressure.on_release(PIECE / 3);
        (0..2).for_each(|_| backpressure.on_read(PIECE));
        assert_eq!(may_read(&backpressure), [true, true]);
    }
}
