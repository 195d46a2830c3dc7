//! The large payloads that are being received, and which of them are read.
//!
//! In: where payloads begin and end, and the time. Out: whether a connection within a payload may
//! be read. The two payloads that began first are read; the others wait, though their sockets have
//! bytes. Each payload is collected in a buffer of its own length, which is reused for a later one:
//! with few payloads at a time these buffers are few, and stay in the processor's caches. With 64
//! at a time, each needs new pages, which the system clears first, and the processor time doubles.
//!
//! No payload waits for long, whatever the senders of the others do: where neither of the two has
//! ended for [`PATIENCE`], they are slow from then on. Slow payloads are read whenever they have
//! bytes, and are not counted among the two. Each time this happens again before one has ended,
//! twice as many payloads become slow.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// Number of payloads that are read at the same time: while the batches of one are being run, bytes
/// of the other are read.
const AT_ONCE: usize = 2;

/// Longest time for which the others wait for one of the two to end.
const PATIENCE: Duration = Duration::from_millis(20);

/// Payloads by their numbers, in order of beginning from 1 on.
pub(super) struct LargePayloads {
    begun: u64,
    counted: BTreeSet<u64>,
    slow: BTreeSet<u64>,
    /// Time from which [`PATIENCE`] is counted.
    since: Instant,
    /// Number of payloads that become slow at the end of [`PATIENCE`].
    slow_next: usize,
}

impl LargePayloads {
    pub fn new(now: Instant) -> Self {
        let (counted, slow) = (BTreeSet::new(), BTreeSet::new());
        LargePayloads { begun: 0, counted, slow, since: now, slow_next: AT_ONCE }
    }

    /// Adds a payload. Returns its number.
    pub fn begin(&mut self, now: Instant) -> u64 {
        self.begun += 1;
        self.counted.insert(self.begun);
        if self.counted.len() == 1 {
            self.restart(now);
        }
        self.begun
    }

    /// Removes a payload.
    pub fn end(&mut self, number: u64, now: Instant) {
        if self.counted.contains(&number) && self.may_read(number) {
            self.restart(now);
        }
        self.counted.remove(&number);
        self.slow.remove(&number);
    }

    fn restart(&mut self, now: Instant) {
        (self.since, self.slow_next) = (now, AT_ONCE);
    }

    /// Returns whether there are payloads that are not slow.
    pub fn are_counted(&self) -> bool {
        !self.counted.is_empty()
    }

    /// Returns whether a connection may be read whose payload has this number; 0 stands for none.
    pub fn may_read(&self, number: u64) -> bool {
        let last = self.counted.iter().nth(AT_ONCE - 1);
        last.is_none_or(|last| number <= *last) || self.slow.contains(&number)
    }

    /// Returns the time until payloads that wait may be read, if some do.
    pub fn patience(&self, now: Instant) -> Option<Duration> {
        let waited = now.saturating_duration_since(self.since);
        (self.counted.len() > AT_ONCE).then(|| PATIENCE.saturating_sub(waited))
    }

    /// Makes the oldest payloads slow if the others have waited for [`PATIENCE`].
    pub fn expire(&mut self, now: Instant) {
        if self.patience(now) == Some(Duration::ZERO) {
            for _ in 0..self.slow_next {
                self.slow.extend(self.counted.pop_first());
            }
            (self.since, self.slow_next) = (now, 2 * self.slow_next);
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
        let now = Instant::now();
        let mut payloads = LargePayloads::new(now);
        assert!(!payloads.are_counted() && payloads.may_read(0));
        assert_eq!([1, 2, 3, 4, 5].map(|_| payloads.begin(now)), [1, 2, 3, 4, 5]);
        assert_eq!(read(&payloads, 0..=5), [0, 1, 2]);
        payloads.end(2, now);
        assert_eq!(read(&payloads, 0..=5), [0, 1, 2, 3], "2 has ended");
        payloads.end(1, now);
        payloads.end(3, now);
        assert_eq!(payloads.begin(now), 6);
        assert_eq!(read(&payloads, 4..=6), [4, 5]);
        (4..=6).for_each(|number| payloads.end(number, now));
        assert!(!payloads.are_counted() && payloads.may_read(7));
    }

    #[test]
    fn payloads_that_do_not_end_delay_the_others_by_less_and_less() {
        let start = Instant::now();
        let at = |times: f64| start + PATIENCE.mul_f64(times);
        let mut payloads = LargePayloads::new(start);
        assert_eq!([1, 2].map(|_| payloads.begin(start)), [1, 2]);
        assert_eq!(payloads.patience(at(9.0)), None, "none waits");
        (3..=40).for_each(|number| assert_eq!(payloads.begin(start), number));
        payloads.expire(at(0.5));
        assert_eq!((payloads.patience(at(0.5)), read(&payloads, 1..=40).len()), (Some(PATIENCE / 2), 2));
        // Two, four and eight of them become slow; two more are read each time.
        for (time, count) in [(1.0, 4), (2.0, 8), (3.0, 16)] {
            payloads.expire(at(time));
            payloads.expire(at(time));
            assert_eq!(read(&payloads, 1..=40), (1..=count).collect::<Vec<_>>(), "{time}");
        }
        // The end of a slow one, or of one that waits, changes nothing for the others; that of one
        // of the two does.
        payloads.end(1, at(3.5));
        payloads.end(40, at(3.5));
        assert_eq!(payloads.patience(at(3.5)), Some(PATIENCE / 2));
        payloads.end(15, at(3.5));
        assert_eq!(payloads.patience(at(3.5)), Some(PATIENCE));
        payloads.expire(at(4.5));
        assert_eq!(read(&payloads, 16..=40), [16, 17, 18, 19]);
        // Slow ones do not count.
        (16..=39).for_each(|number| payloads.end(number, at(5.0)));
        assert!(!payloads.are_counted() && payloads.slow.len() == 13);
    }
}
