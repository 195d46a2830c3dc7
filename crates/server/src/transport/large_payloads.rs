//! The large payloads that are being received, and which of them are read.
//!
//! In: where payloads begin and end, and the time. Out: whether a connection within a payload may
//! be read. The two payloads that began first are read; the others wait, though their sockets have
//! bytes. Each payload is collected in a buffer of its own length, which is reused for a later one:
//! with few payloads at a time these buffers are few, and stay in the processor's caches. With 64
//! at a time, each needs new pages, which the system clears first, and the processor time doubles.
//!
//! A payload whose sender stops must not hold up the others. One that made the others wait for
//! [`PATIENCE`] while its own socket was empty is slow from then on: it is read whenever it has
//! bytes, and makes room for the next. Time in which its socket has bytes, which only wait to be
//! read, counts up to [`TOTAL_PATIENCE`]; otherwise, where many are read at a time, those that are
//! read last would become slow, too, and each of them would add one more to those that are read.
//!
//! Each that becomes slow with an empty socket adds one to the number of payloads that are read at a
//! time, and each that ends in time halves it. So `n` payloads whose senders stop are all slow after
//! about `log2(n)` times [`PATIENCE`]. Whatever the senders do, those that have waited for
//! [`LONGEST_WAIT`] are read as well, one more after each [`PATIENCE`].

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Number of payloads that are read at the same time: while the batches of one are being run, bytes
/// of the other are read.
const AT_ONCE: usize = 2;

/// Longest time for which others wait while the socket of a payload that is read is empty.
const PATIENCE: Duration = Duration::from_millis(20);
/// Longest time for which others wait for a payload that is read.
const TOTAL_PATIENCE: Duration = Duration::from_millis(200);
/// Time after which a payload need not wait for others to end. 64 of 8 MB arrive in less, at more
/// than 1.1 GB a second.
const LONGEST_WAIT: Duration = Duration::from_millis(500);
/// Longest time between two calls of [`LargePayloads::count`] that counts as time of an empty
/// socket while no thread polls the sockets.
const UNWATCHED: Duration = Duration::from_millis(1);

/// A payload that is read, and for whose end others wait.
struct Active {
    number: u64,
    /// Set while its socket may have bytes.
    has_bytes: Arc<AtomicBool>,
    /// Time for which others have waited for it, with its socket empty and in total.
    empty: Duration,
    total: Duration,
}

impl Active {
    /// Returns the time that is left until it becomes slow, if its socket is empty.
    fn time_left(&self) -> Duration {
        PATIENCE.saturating_sub(self.empty).min(TOTAL_PATIENCE.saturating_sub(self.total))
    }
}

/// Payloads by their numbers, in order of beginning from 1 on. A payload that is neither active nor
/// queued is slow.
pub(super) struct LargePayloads {
    begun: u64,
    active: Vec<Active>,
    /// The payloads that wait for an active one to end: the flags of their sockets, and the time
    /// when each began.
    queued: BTreeMap<u64, (Arc<AtomicBool>, Instant)>,
    /// Time of the last call of [`Self::count`].
    counted_to: Instant,
    /// Set while a thread polls the sockets: none of them gets bytes unseen.
    is_watched: bool,
    /// Time at which a payload was last admitted only because it had waited for [`LONGEST_WAIT`].
    forced_at: Instant,
    /// Number of payloads that are active at the same time, [`AT_ONCE`] or more.
    most_active: usize,
}

impl LargePayloads {
    pub fn new(now: Instant) -> Self {
        let (active, queued) = (Vec::new(), BTreeMap::new());
        LargePayloads {
            begun: 0,
            active,
            queued,
            counted_to: now,
            is_watched: false,
            forced_at: now,
            most_active: AT_ONCE,
        }
    }

    /// Adds a payload; `has_bytes` is set while its socket may have bytes. Returns its number.
    pub fn begin(&mut self, now: Instant, has_bytes: Arc<AtomicBool>) -> u64 {
        if self.queued.is_empty() {
            self.counted_to = now;
        }
        self.count(|| now);
        self.begun += 1;
        self.queued.insert(self.begun, (has_bytes, now));
        self.admit(now);
        self.begun
    }

    /// Removes a payload.
    pub fn end(&mut self, number: u64, now: Instant) {
        self.count(|| now);
        let before = self.active.len();
        self.active.retain(|active| active.number != number);
        if self.active.len() < before {
            self.most_active = (self.most_active / 2).max(AT_ONCE);
        }
        self.queued.remove(&number);
        self.admit(now);
    }

    /// Notes that a thread begins to poll the sockets, or has ended to.
    pub fn watch(&mut self, now: impl FnOnce() -> Instant, is_watched: bool) {
        self.count(now);
        self.is_watched = is_watched;
    }

    /// Counts the time since the last call, if others wait. Must be called before a flag of a socket
    /// changes.
    pub fn count(&mut self, now: impl FnOnce() -> Instant) {
        if !self.is_any_queued() {
            return;
        }
        let now = now();
        let time = now.saturating_duration_since(self.counted_to);
        self.counted_to += time;
        let empty = if self.is_watched { time } else { time.min(UNWATCHED) };
        for active in &mut self.active {
            active.total += time;
            if !active.has_bytes.load(Ordering::Relaxed) {
                active.empty += empty;
            }
        }
    }

    fn admit(&mut self, now: Instant) {
        while let Some(forced) = self.next_forced() {
            if self.active.len() >= self.most_active {
                if now < forced {
                    break;
                }
                self.forced_at = now;
            }
            let Some((number, (has_bytes, _))) = self.queued.pop_first() else { break };
            self.active.push(Active { number, has_bytes, empty: Duration::ZERO, total: Duration::ZERO });
        }
    }

    /// Returns the time from which the oldest payload that waits need not, if there is one.
    fn next_forced(&self) -> Option<Instant> {
        let (_, (_, begun)) = self.queued.first_key_value()?;
        Some((*begun + LONGEST_WAIT).max(self.forced_at + PATIENCE))
    }

    /// Returns whether there are payloads that are not slow.
    pub fn is_any_active(&self) -> bool {
        !self.active.is_empty()
    }

    /// Returns whether this payload is active.
    pub fn is_active(&self, number: u64) -> bool {
        // They were admitted in order.
        self.active.binary_search_by_key(&number, |active| active.number).is_ok()
    }

    /// Returns whether any payload waits.
    pub fn is_any_queued(&self) -> bool {
        !self.queued.is_empty()
    }

    /// Returns whether a connection may be read whose payload has this number; 0 stands for none.
    pub fn may_read(&self, number: u64) -> bool {
        !self.queued.contains_key(&number)
    }

    /// Returns the earliest time at which a payload that waits may be read, if some do and none
    /// ends.
    pub fn deadline(&self) -> Option<Instant> {
        let left = self.active.iter().map(Active::time_left).min()?;
        Some((self.counted_to + left).min(self.next_forced()?))
    }

    /// Makes payloads slow for which others have waited too long.
    pub fn expire(&mut self, now: impl FnOnce() -> Instant) {
        self.count(now);
        if self.is_any_queued() {
            self.most_active += self.active.iter().filter(|active| active.empty >= PATIENCE).count();
            self.active.retain(|active| active.time_left() > Duration::ZERO);
            self.admit(self.counted_to);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(payloads: &LargePayloads, all: std::ops::RangeInclusive<u64>) -> Vec<u64> {
        all.filter(|number| payloads.may_read(*number)).collect()
    }

    /// Payloads whose sockets are empty until their flags are set, with numbers from 1 on.
    struct Test {
        start: Instant,
        payloads: LargePayloads,
        has_bytes: Vec<Arc<AtomicBool>>,
    }

    impl Test {
        /// Returns payloads of which `count` have begun at `start`.
        fn new(count: usize) -> Self {
            let start = Instant::now();
            let mut payloads = LargePayloads::new(start);
            payloads.watch(|| start, true);
            let mut test = Test { start, payloads, has_bytes: Vec::new() };
            test.begin(count, 0.0);
            test
        }

        /// Returns the time after `times` the patience.
        fn at(&self, times: f64) -> Instant {
            self.start + PATIENCE.mul_f64(times)
        }

        fn begin(&mut self, count: usize, times: f64) {
            for _ in 0..count {
                self.has_bytes.push(Arc::default());
                let number =
                    self.payloads.begin(self.at(times), self.has_bytes[self.has_bytes.len() - 1].clone());
                assert_eq!(number as usize, self.has_bytes.len());
            }
        }

        fn end(&mut self, number: u64, times: f64) {
            self.payloads.end(number, self.at(times));
        }

        fn expire(&mut self, times: f64) {
            let now = self.at(times);
            self.payloads.expire(|| now);
        }

        fn set_has_bytes(&mut self, number: usize, has_bytes: bool, times: f64) {
            let now = self.at(times);
            self.payloads.count(|| now);
            self.has_bytes[number - 1].store(has_bytes, Ordering::Relaxed);
        }
    }

    #[test]
    fn two_are_read_at_a_time_in_order_of_beginning() {
        let mut test = Test::new(5);
        assert_eq!(read(&test.payloads, 0..=5), [0, 1, 2]);
        test.end(2, 0.0);
        assert_eq!(read(&test.payloads, 0..=5), [0, 1, 2, 3], "2 has ended");
        test.end(1, 0.0);
        test.end(3, 0.0);
        test.begin(1, 0.0);
        assert_eq!(read(&test.payloads, 4..=6), [4, 5]);
        // One that waits may end, too: its connection has ended.
        test.end(6, 0.0);
        assert!(!test.payloads.is_any_queued() && test.payloads.is_any_active());
        (4..=5).for_each(|number| test.end(number, 0.0));
        assert!(!test.payloads.is_any_active() && test.payloads.may_read(7));
    }

    #[test]
    fn payloads_whose_senders_stop_are_passed_by_twice_as_many_at_a_time() {
        let mut test = Test::new(40);
        assert_eq!(test.payloads.deadline(), Some(test.at(1.0)));
        test.expire(0.99);
        assert_eq!(read(&test.payloads, 1..=40).len(), 2);
        for (time, count) in [(1.0, 2 + 4), (2.0, 6 + 8), (3.0, 14 + 16)] {
            test.expire(time);
            test.expire(time);
            assert_eq!(read(&test.payloads, 1..=40), (1..=count).collect::<Vec<_>>(), "{time}");
            assert_eq!(test.payloads.deadline(), Some(test.at(time + 1.0)));
            assert!(!test.payloads.is_active(count / 3) && test.payloads.is_active(count));
        }
        // Ends of slow and queued ones admit none, nor do those of active ones while there are more
        // than the number that each of them halves.
        test.end(1, 3.1);
        test.end(40, 3.1);
        (15..=28).for_each(|number| test.end(number, 3.2));
        assert_eq!(read(&test.payloads, 29..=40), [29, 30, 40], "2 of 2 are active");
        test.end(29, 3.5);
        assert_eq!(read(&test.payloads, 30..=39), [30, 31]);
    }

    #[test]
    fn payloads_that_stop_do_not_prolong_the_wait_behind_those_that_end() {
        // Halves of the patience until the last of 40 is read, if every `nth` one ends after one
        // half and the others stop.
        let halves = |nth: usize| {
            let mut test = Test::new(40);
            (1..).find(|half| {
                let times = f64::from(*half) / 2.0;
                let all = (1..=40).step_by(nth);
                let ended: Vec<u64> = all.filter(|n| test.payloads.is_active(*n)).collect();
                ended.iter().for_each(|number| test.end(*number, times));
                test.expire(times);
                test.payloads.may_read(40)
            })
        };
        assert_eq!([1, 2, 4, 40].map(halves), [Some(19), Some(20), Some(13), Some(8)]);
    }

    #[test]
    fn time_counts_while_a_payload_is_read_and_another_waits() {
        let mut test = Test::new(2);
        test.expire(9.0);
        assert_eq!((test.payloads.deadline(), test.payloads.is_active(1)), (None, true), "none waits");
        test.begin(3, 9.0);
        assert_eq!(test.payloads.deadline(), Some(test.at(10.0)));
        test.end(2, 9.5);
        test.expire(10.0);
        // 1 is slow; 3 was admitted later, and has its own time.
        assert!(!test.payloads.is_active(1) && test.payloads.is_active(3));
        assert_eq!(read(&test.payloads, 1..=5), [1, 2, 3, 4, 5]);
        assert_eq!(test.payloads.deadline(), None);
        // Nobody waits until 6 does.
        test.begin(1, 10.2);
        assert_eq!(test.payloads.deadline(), Some(test.at(10.7)));
    }

    #[test]
    fn bytes_that_wait_to_be_read_make_no_payload_slow_for_a_long_time() {
        let mut test = Test::new(3);
        test.set_has_bytes(1, true, 0.5);
        test.expire(1.0);
        assert!(test.payloads.is_active(1) && !test.payloads.is_active(2), "2 is slow");
        test.begin(8, 1.0);
        test.set_has_bytes(1, false, 5.0);
        test.expire(5.4);
        assert!(test.payloads.is_active(1));
        test.expire(5.5);
        assert!(!test.payloads.is_active(1), "empty for twice a half of the patience");

        let mut test = Test::new(3);
        [1, 2].iter().for_each(|number| test.set_has_bytes(*number, true, 0.0));
        let total = TOTAL_PATIENCE.as_secs_f64() / PATIENCE.as_secs_f64();
        test.expire(total - 0.1);
        assert!(test.payloads.is_active(1));
        test.expire(total);
        assert!(!test.payloads.is_active(1));
    }

    #[test]
    fn time_in_which_no_thread_polls_the_sockets_counts_little() {
        let mut test = Test::new(3);
        test.payloads.is_watched = false;
        let now = test.at(2.0);
        test.payloads.expire(|| now);
        assert!(test.payloads.is_active(1), "bytes may have come unseen");
        let count = PATIENCE.as_millis() / UNWATCHED.as_millis();
        for _ in 1..count {
            assert!(test.payloads.is_active(1));
            let now = test.payloads.counted_to + PATIENCE / 10;
            test.payloads.expire(|| now);
        }
        assert!(!test.payloads.is_active(1));
    }

    #[test]
    fn payloads_that_have_waited_for_the_longest_time_are_read_one_after_the_other() {
        let mut test = Test::new(4);
        let most = LONGEST_WAIT.as_secs_f64() / PATIENCE.as_secs_f64();
        // 1 and 2 have bytes, and are read as if each ended just in time: two at a time, for ever.
        [1, 2].iter().for_each(|number| test.set_has_bytes(*number, true, 0.0));
        let count = |test: &mut Test, times: f64| {
            let now = test.at(times);
            test.payloads.count(|| now);
            test.payloads.active.iter_mut().for_each(|a| (a.empty, a.total) = Default::default());
        };
        let expire = |test: &mut Test, times: f64| {
            count(test, times);
            test.expire(times);
            read(&test.payloads, 1..=5)
        };
        assert_eq!(expire(&mut test, most - 0.5), [1, 2, 5], "5 has not begun");
        test.begin(1, most - 0.5);
        assert_eq!(test.payloads.deadline(), Some(test.at(most)), "3 has waited for as long then");
        assert_eq!(expire(&mut test, most), [1, 2, 3]);
        assert_eq!(expire(&mut test, most + 0.9), [1, 2, 3]);
        assert_eq!(expire(&mut test, most + 1.0), [1, 2, 3, 4]);
        assert_eq!(expire(&mut test, most + 9.0), [1, 2, 3, 4], "5 began late");
        assert_eq!(test.payloads.most_active, AT_ONCE);
    }
}
