//! Backpressure: the batches of one connection that are in flight to the render thread, and whether
//! it may be read again.

use std::collections::VecDeque;

/// A payload of which so much is missing is large.
const LARGE_BYTES: usize = 1 << 20;

/// Batches of one connection on their way, and of one that is within a large payload: fewer than
/// there are pooled buffers, so that others have one, too.
const MAX_IN_FLIGHT: usize = 3;
const MAX_PAYLOAD_IN_FLIGHT: usize = 5;

/// The state that decides whether a socket is read.
#[derive(Default)]
pub(super) struct Backpressure {
    /// How many bytes each batch has that did not come back.
    in_flight: VecDeque<usize>,
    /// Bytes of a large payload that were not read yet, as far as is known.
    payload_left: usize,
    /// The system may have something of it: the selector said so, and it was not found empty since.
    pub is_ready: bool,
    /// It is in line, or somebody reads it.
    pub is_taken: bool,
    /// The render thread wants no more: what comes is thrown away.
    pub is_over: bool,
    /// Nothing more comes.
    pub is_at_end: bool,
}

impl Backpressure {
    /// Batches that did not come back.
    pub fn in_flight(&self) -> usize {
        self.in_flight.len()
    }

    /// Whether it may be read again: there are not too many on their way, or nobody wants them.
    pub fn may_read(&self) -> bool {
        let most = if self.is_within_payload() { MAX_PAYLOAD_IN_FLIGHT } else { MAX_IN_FLIGHT };
        self.in_flight() < most || self.is_over
    }

    /// Notes that a batch was read.
    pub fn on_read(&mut self, bytes: usize) {
        self.in_flight.push_back(bytes);
        self.payload_left = self.payload_left.saturating_sub(bytes);
    }

    /// Notes that the oldest batch came back, after which the payload that the render thread is at
    /// waits for `payload_left` bytes.
    pub fn on_release(&mut self, payload_left: usize) {
        self.in_flight.pop_front();
        // The end of a large one counts, too.
        let is_large = payload_left >= LARGE_BYTES || self.payload_left > 0;
        let read: usize = self.in_flight.iter().sum();
        self.payload_left = if is_large { payload_left.saturating_sub(read) } else { 0 };
    }

    /// Whether what will be read next is of a large payload that has begun.
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
        // 1.5 times large is missing after the first batch, a quarter of that is on its way.
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
        // The last batch held the end, and the beginning of the next one.
        backpressure.on_release(5 * PIECE);
        assert!(backpressure.is_within_payload() && backpressure.in_flight() == 0);
    }

    #[test]
    fn few_are_on_their_way_and_some_more_within_a_large_payload() {
        let mut backpressure = Backpressure::default();
        let fill = |backpressure: &mut Backpressure| {
            while backpressure.may_read() {
                backpressure.on_read(1000);
            }
            backpressure.in_flight()
        };
        assert_eq!(fill(&mut backpressure), MAX_IN_FLIGHT);
        backpressure.on_release(4 * LARGE_BYTES);
        assert_eq!(fill(&mut backpressure), MAX_PAYLOAD_IN_FLIGHT);
        // It is whole: first some of them come back.
        backpressure.on_read(8 * LARGE_BYTES);
        assert!(!backpressure.is_within_payload() && !backpressure.may_read());
        for in_flight in (MAX_IN_FLIGHT..=MAX_PAYLOAD_IN_FLIGHT).rev() {
            backpressure.on_release(1000);
            assert!(backpressure.in_flight() == in_flight && !backpressure.may_read());
        }
        backpressure.on_release(0);
        assert!(backpressure.may_read());
        assert_eq!(fill(&mut backpressure), MAX_IN_FLIGHT);
        backpressure.is_over = true;
        assert!(backpressure.may_read(), "what nobody wants is read and thrown away");
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
}
