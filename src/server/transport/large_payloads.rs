//! The large payloads that are being received, and which of them are read.
//!
//! In: where payloads begin and end, and for how long nothing could be read. Out: whether a
//! connection within a payload may be read. The two payloads that began first are read; the others
//! wait, though their sockets have bytes. Each payload is collected in a buffer of its own length
//! and leaves it to the next one: with few of them at a time these buffers are few, and stay in the
//! processor's caches. With all of 64 at once, each needs new pages, which the system clears first,
//! and the processor time doubles.
//!
//! A payload that does not arrive holds the others up for [`PATIENCE`] at most, all such payloads
//! together: then all that have no bytes are called slow, which are read whenever they have some,
//! and no longer count as one of the two.

use std::collections::BTreeSet;
use std::time::Duration;

/// Number of payloads that are read at the same time: while the batches of one are being run, bytes
/// of the other are read.
const AT_ONCE: usize = 2;

/// Longest time without anything to read, in total since a payload ended, for which the others wait.
const PATIENCE: Duration = Duration::from_millis(10);

/// Payloads by their numbers, in order of beginning from 1 on.
#[derive(Default)]
pub(super) struct LargePayloads {
    begun: u64,
    counted: BTreeSet<u64>,
    slow: BTreeSet<u64>,
    idle: Duration,
}

impl LargePayloads {
    /// Adds a payload. Returns its number.
    pub fn begin(&mut self) -> u64 {
        self.begun += 1;
        self.counted.insert(self.begun);
        self.begun
    }

    /// Removes a payload.
    pub fn end(&mut self, number: u64) {
        self.counted.remove(&number);
        self.slow.remove(&number);
        self.idle = Duration::ZERO;
    }

    /// Returns whether there are no payloads.
    pub fn is_empty(&self) -> bool {
        self.counted.is_empty() && self.slow.is_empty()
    }

    /// Returns whether a connection may be read whose payload has this number; 0 stands for none.
    pub fn may_read(&self, number: u64) -> bool {
        let last = self.counted.iter().nth(AT_ONCE - 1);
        last.is_none_or(|last| number <= *last) || self.slow.contains(&number)
    }

    /// Returns for how long nothing may be read before [`Self::note_idle`] lets others be read.
    pub fn patience(&self) -> Duration {
        PATIENCE - self.idle
    }

    /// Notes that nothing was read for this time, though some of the payloads that wait had bytes:
    /// those of which `has_bytes` is true.
    pub fn note_idle(&mut self, time: Duration, has_bytes: impl Fn(u64) -> bool) {
        self.idle += time;
        if self.idle >= PATIENCE {
            let (left, slow) = self.counted.iter().partition(|number| has_bytes(**number));
            self.counted = left;
            self.slow.extend::<BTreeSet<u64>>(slow);
            self.idle = Duration::ZERO;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(payloads: &LargePayloads, all: std::ops::RangeInclusive<u64>) -> Vec<u64> {
        all.filter(|number| payloads.may_read(*number)).collect()
    }

    #[test]
    fn two_are_read_at_a_time_in_order_of_beginning() {
        let mut payloads = LargePayloads::default();
        assert!(payloads.is_empty() && payloads.may_read(0));
        assert_eq!([1, 2, 3, 4, 5].map(|_| payloads.begin()), [1, 2, 3, 4, 5]);
        assert_eq!(read(&payloads, 0..=5), [0, 1, 2]);
        payloads.end(2);
        assert_eq!(read(&payloads, 0..=5), [0, 1, 2, 3], "2 has ended");
        payloads.end(1);
        payloads.end(3);
        assert_eq!(payloads.begin(), 6);
        assert_eq!(read(&payloads, 4..=6), [4, 5]);
        [4, 5, 6].map(|number| payloads.end(number));
        assert!(payloads.is_empty() && payloads.may_read(7));
    }

    #[test]
    fn those_that_do_not_arrive_hold_the_others_up_once() {
        let mut payloads = LargePayloads::default();
        (0..40).for_each(|_| drop(payloads.begin()));
        // Only 38 and 40 have bytes, and wait for 1 and 2.
        let has_bytes = |number| number == 38 || number == 40;
        payloads.note_idle(PATIENCE / 2, has_bytes);
        assert_eq!((read(&payloads, 38..=40), payloads.patience()), (vec![], PATIENCE / 2));
        payloads.note_idle(payloads.patience(), has_bytes);
        // All others are slow: read when they have bytes, and no longer in the way.
        assert_eq!((read(&payloads, 1..=40).len(), payloads.patience()), (40, PATIENCE));
        let [a, b] = [payloads.begin(), payloads.begin()];
        assert!(read(&payloads, a..=b).is_empty());
        payloads.end(38);
        assert_eq!(read(&payloads, a..=b), [a]);
        // Idle times between ends of payloads do not add up.
        payloads.note_idle(PATIENCE / 2, has_bytes);
        payloads.end(1);
        assert_eq!(payloads.patience(), PATIENCE);
    }
}
