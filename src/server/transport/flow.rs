//! FLOW: what of one connection was read and did not come back yet, and what follows for its large
//! payload.

use std::collections::VecDeque;

/// A payload of which so much is missing is large.
const LARGE_BYTES: usize = 1 << 20;

/// Batches of one connection on their way, and of one that is within a large payload: fewer than
/// there are leases, so that others have one, too.
const AHEAD: usize = 3;
const PAYLOAD_AHEAD: usize = 5;

/// Whether and why a socket is not read.
#[derive(Default)]
pub(super) struct Flow {
    /// How many bytes each batch has that did not come back.
    on_their_way: VecDeque<usize>,
    /// Bytes of a large payload that were not read yet, as far as is known.
    wanted: usize,
    /// The system may have something of it: the selector said so, and it was not found empty since.
    pub is_ready: bool,
    /// It is in line, or somebody reads it.
    pub is_taken: bool,
    /// The render thread wants no more: what comes is thrown away.
    pub is_over: bool,
    /// Nothing more comes.
    pub is_at_end: bool,
}

impl Flow {
    /// Batches that did not come back.
    pub fn ahead(&self) -> usize {
        self.on_their_way.len()
    }

    /// Whether it may be read again: there are not too many on their way, or nobody wants them.
    pub fn may_come(&self) -> bool {
        let most = if self.is_within_payload() { PAYLOAD_AHEAD } else { AHEAD };
        self.ahead() < most || self.is_over
    }

    /// A batch was read.
    pub fn came(&mut self, bytes: usize) {
        self.on_their_way.push_back(bytes);
        self.wanted = self.wanted.saturating_sub(bytes);
    }

    /// The oldest batch came back, after which the payload that the render thread is at waits for
    /// so many bytes.
    pub fn went(&mut self, wanted: usize) {
        self.on_their_way.pop_front();
        // The end of a large one counts, too.
        let is_large = wanted >= LARGE_BYTES || self.wanted > 0;
        let read: usize = self.on_their_way.iter().sum();
        self.wanted = if is_large { wanted.saturating_sub(read) } else { 0 };
    }

    /// Whether what will be read next is of a large payload that has begun.
    pub fn is_within_payload(&self) -> bool {
        self.wanted > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_payload_is_over_when_its_last_byte_is_read_though_it_did_not_come_back() {
        const PIECE: usize = LARGE_BYTES / 4;
        let mut flow = Flow::default();
        flow.came(PIECE);
        flow.came(PIECE);
        assert!(!flow.is_within_payload() && flow.ahead() == 2, "nobody has looked into them");
        // 1.5 times large is missing after the first batch, a quarter of that is on its way.
        flow.went(6 * PIECE);
        assert!(flow.is_within_payload() && flow.ahead() == 1);
        for _ in 0..4 {
            flow.came(PIECE);
            assert!(flow.is_within_payload());
        }
        flow.came(PIECE);
        assert!(!flow.is_within_payload());
        for missing in [5, 4, 3, 2, 1] {
            flow.went(missing * PIECE);
            assert!(!flow.is_within_payload(), "{missing} pieces are on their way");
        }
        // The last batch held the end, and the beginning of the next one.
        flow.went(5 * PIECE);
        assert!(flow.is_within_payload() && flow.ahead() == 0);
    }

    #[test]
    fn few_are_on_their_way_and_some_more_within_a_large_payload() {
        let mut flow = Flow::default();
        let fill = |flow: &mut Flow| {
            while flow.may_come() {
                flow.came(1000);
            }
            flow.ahead()
        };
        assert_eq!(fill(&mut flow), AHEAD);
        flow.went(4 * LARGE_BYTES);
        assert_eq!(fill(&mut flow), PAYLOAD_AHEAD);
        // It is whole: first some of them come back.
        flow.came(8 * LARGE_BYTES);
        assert!(!flow.is_within_payload() && !flow.may_come());
        for ahead in (AHEAD..=PAYLOAD_AHEAD).rev() {
            flow.went(1000);
            assert!(flow.ahead() == ahead && !flow.may_come());
        }
        flow.went(0);
        assert!(flow.may_come());
        assert_eq!(fill(&mut flow), AHEAD);
        flow.is_over = true;
        assert!(flow.may_come(), "what nobody wants is read and thrown away");
    }

    #[test]
    fn small_payloads_do_not_count() {
        let mut flow = Flow::default();
        for wanted in [LARGE_BYTES - 1, 0, 100] {
            flow.came(1000);
            flow.went(wanted);
            assert!(!flow.is_within_payload());
        }
    }
}
