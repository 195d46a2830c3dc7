//! The large payloads that are being received, and which of them are read.
//!
//! In: where payloads begin and end, and the time. Out: whether a connection within a payload may
//! be read. The two payloads that began first are read; the others wait, though their sockets have
//! bytes. Each payload is collected in a buffer of its own length, which is reused for a later one:
//! with few payloads at a time these buffers are few, and stay in the processor's caches. With 64
//! at a time, each needs new pages, which the system clears first, and the processor time doubles.
//!
//! A payload whose sender stops must not hold up the others. One that has not ended within
//! [`PATIENCE`], while others waited, is slow from then on: it is read whenever it has bytes, and
//! makes room for the next. Each that becomes slow also adds one to the number of payloads that are
//! read at a time, and each that ends in time takes one away again. So `n` payloads whose senders
//! stop are all slow after about `log2(n)` times [`PATIENCE`], and whatever the senders do, every
//! payload that is being read when another begins to wait has ended or is slow after [`PATIENCE`].

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// Number of payloads that are read at the same time: while the batches of one are being run, bytes
/// of the other are read.
const AT_ONCE: usize = 2;

/// Time within which a payload must end while others wait.
const PATIENCE: Duration = Duration::from_millis(20);

/// Payloads by their numbers, in order of beginning from 1 on. A payload that is neither active nor
/// queued is slow.
pub(super) struct LargePayloads {
    begun: u64,
    /// The payloads that are read, and the time at which each was admitted.
    active: Vec<(u64, Instant)>,
    /// The payloads that wait for an active one to end.
    queued: BTreeSet<u64>,
    /// Time at which the oldest of those that are queued without a break began to wait.
    queued_since: Instant,
    /// Number of payloads that are active at the same time, [`AT_ONCE`] or more.
    most_active: usize,
}

impl LargePayloads {
    pub fn new(now: Instant) -> Self {
        let (active, queued) = (Vec::new(), BTreeSet::new());
        LargePayloads { begun: 0, active, queued, queued_since: now, most_active: AT_ONCE }
    }

    /// Adds a payload. Returns its number.
    pub fn begin(&mut self, now: Instant) -> u64 {
        self.begun += 1;
        if self.queued.is_empty() {
            self.queued_since = now;
        }
        self.queued.insert(self.begun);
        self.admit(now);
        self.begun
    }

    /// Removes a payload.
    pub fn end(&mut self, number: u64, now: Instant) {
        let before = self.active.len();
        self.active.retain(|(active, _)| *active != number);
        if self.active.len() < before {
            self.most_active = (self.most_active - 1).max(AT_ONCE);
        }
        self.queued.remove(&number);
        self.admit(now);
    }

    fn admit(&mut self, now: Instant) {
        while self.active.len() < self.most_active
            && let Some(oldest) = self.queued.pop_first()
        {
            self.active.push((oldest, now));
        }
    }

    /// Returns whether there are payloads that are not slow.
    pub fn is_any_active(&self) -> bool {
        !self.active.is_empty()
    }

    /// Returns whether this payload is active.
    pub fn is_active(&self, number: u64) -> bool {
        self.active.iter().any(|(active, _)| *active == number)
    }

    /// Returns whether any payload waits.
    pub fn is_any_queued(&self) -> bool {
        !self.queued.is_empty()
    }

    /// Returns whether a connection may be read whose payload has this number; 0 stands for none.
    pub fn may_read(&self, number: u64) -> bool {
        !self.queued.contains(&number)
    }

    /// Returns the time at which the next payload becomes slow, if others wait.
    pub fn deadline(&self) -> Option<Instant> {
        let admitted = self.active.iter().map(|(_, admitted)| *admitted).min()?;
        self.is_any_queued().then(|| admitted.max(self.queued_since) + PATIENCE)
    }

    /// Makes payloads slow that have not ended in time.
    pub fn expire(&mut self, now: Instant) {
        if self.deadline().is_none_or(|deadline| now < deadline) {
            return;
        }
        let before = self.active.len();
        let since = self.queued_since;
        self.active.retain(|(_, admitted)| now < (*admitted).max(since) + PATIENCE);
        self.most_active += before - self.active.len();
        self.admit(now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(payloads: &LargePayloads, all: std::ops::RangeInclusive<u64>) -> Vec<u64> {
        all.filter(|number| payloads.may_read(*number)).collect()
    }

    /// Returns payloads of which `count` have begun at `now`.
    fn begun(count: u64, now: Instant) -> LargePayloads {
        let mut payloads = LargePayloads::new(now);
        (1..=count).for_each(|number| assert_eq!(payloads.begin(now), number));
        payloads
    }

    #[test]
    fn two_are_read_at_a_time_in_order_of_beginning() {
        let now = Instant::now();
        let mut payloads = begun(5, now);
        assert_eq!(read(&payloads, 0..=5), [0, 1, 2]);
        payloads.end(2, now);
        assert_eq!(read(&payloads, 0..=5), [0, 1, 2, 3], "2 has ended");
        payloads.end(1, now);
        payloads.end(3, now);
        assert_eq!(payloads.begin(now), 6);
        assert_eq!(read(&payloads, 4..=6), [4, 5]);
        // One that waits may end, too: its connection has ended.
        payloads.end(6, now);
        assert!(!payloads.is_any_queued() && payloads.is_any_active());
        (4..=5).for_each(|number| payloads.end(number, now));
        assert!(!payloads.is_any_active() && payloads.may_read(7));
    }

    #[test]
    fn payloads_whose_senders_stop_are_passed_by_twice_as_many_at_a_time() {
        let start = Instant::now();
        let at = |times: f64| start + PATIENCE.mul_f64(times);
        let mut payloads = begun(40, start);
        assert_eq!(payloads.deadline(), Some(at(1.0)));
        payloads.expire(at(0.99));
        assert_eq!(read(&payloads, 1..=40).len(), 2);
        for (time, count) in [(1.0, 2 + 4), (2.0, 6 + 8), (3.0, 14 + 16)] {
            payloads.expire(at(time));
            payloads.expire(at(time));
            assert_eq!(read(&payloads, 1..=40), (1..=count).collect::<Vec<_>>(), "{time}");
            assert_eq!(payloads.deadline(), Some(at(time + 1.0)));
            assert!(!payloads.is_active(count / 3) && payloads.is_active(count));
        }
        // Ends of slow and queued ones admit none, nor do those beyond the number of active ones
        // that fell by one with each.
        payloads.end(1, at(3.1));
        payloads.end(40, at(3.1));
        (15..=28).for_each(|number| payloads.end(number, at(3.2)));
        assert_eq!(read(&payloads, 29..=40), [29, 30, 40], "2 of 2 are active");
        payloads.end(29, at(3.5));
        assert_eq!(read(&payloads, 30..=39), [30, 31]);
    }

    #[test]
    fn payloads_that_stop_do_not_prolong_the_wait_behind_those_that_end() {
        let start = Instant::now();
        // Halves of PATIENCE until the last of 200 is read, if every `nth` one ends after one half
        // and the others stop.
        let halves = |nth: usize| {
            let mut payloads = begun(200, start);
            (1_u32..).find(|half| {
                let now = start + PATIENCE / 2 * *half;
                let ended: Vec<u64> = (1..=200).step_by(nth).filter(|n| payloads.is_active(*n)).collect();
                ended.iter().for_each(|number| payloads.end(*number, now));
                payloads.expire(now);
                payloads.may_read(200)
            })
        };
        assert_eq!(halves(1), Some(99));
        assert!(halves(2) <= Some(100) && halves(4) <= Some(20) && halves(200) <= Some(14));
    }

    #[test]
    fn time_counts_from_when_a_payload_is_read_and_another_waits() {
        let start = Instant::now();
        let at = |times: f64| start + PATIENCE.mul_f64(times);
        let mut payloads = begun(2, start);
        payloads.expire(at(9.0));
        assert_eq!((payloads.deadline(), payloads.is_active(1)), (None, true), "none waits");
        (3..=5).for_each(|number| assert_eq!(payloads.begin(at(9.0)), number));
        assert_eq!(payloads.deadline(), Some(at(10.0)));
        payloads.end(2, at(9.5));
        payloads.expire(at(10.0));
        // 1 is slow; 3 was admitted later, and has its own time.
        assert!(!payloads.is_active(1) && payloads.is_active(3));
        assert_eq!((read(&payloads, 1..=5), payloads.deadline()), (vec![1, 2, 3, 4, 5], None));
        assert_eq!(payloads.begin(at(10.2)), 6);
        assert_eq!(payloads.deadline(), Some(at(11.2)), "6 waits from then on");
    }
}
