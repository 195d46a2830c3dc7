//! The queue of readable sockets, in the order in which they are read: those whose last read was
//! short before all others, and of those within large payloads the one whose payload began first.
//!
//! A payload is held in memory until it is complete. If many connections send large ones and each
//! is read in rotation, all of them are held at the same time, in more memory than any cache has.
//! So only a few payloads are read at a time (`large_payloads.rs`), and their connections give their
//! places in the rotation to the one of them whose payload began first. Other connections keep
//! their places, also those whose payloads are slow. A connection whose payload is complete waits
//! until the payloads that began before its next one are complete, too.

use super::large_payloads::LargePayloads;
use std::collections::VecDeque;
use std::time::Instant;

/// A socket in the queue.
pub(super) trait Member: Clone {
    /// Returns the number of the large payload that is being received, in order of beginning; 0 if
    /// there is none.
    fn payload_since(&self) -> u64;

    /// Returns whether its last read was short.
    fn is_interactive(&self) -> bool;
}

pub(super) struct ReadyQueue<T> {
    interactive: VecDeque<T>,
    throughput: VecDeque<T>,
    pub large: LargePayloads,
}

impl<T: Member> ReadyQueue<T> {
    pub fn new() -> Self {
        ReadyQueue {
            interactive: VecDeque::new(),
            throughput: VecDeque::new(),
            large: LargePayloads::new(Instant::now()),
        }
    }

    /// Adds a readable socket.
    pub fn push(&mut self, member: T) {
        // Within a payload that waits, it waits, however short its last read was.
        match member.is_interactive() && self.may_read(&member) {
            true => self.interactive.push_back(member),
            false => self.throughput.push_back(member),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub fn len(&self) -> usize {
        self.interactive.len() + self.throughput.len()
    }

    /// Returns whether any queued socket satisfies `what`.
    pub fn holds(&self, what: impl FnMut(&T) -> bool) -> bool {
        self.interactive.iter().chain(&self.throughput).any(what)
    }

    /// Takes the next socket among those whose last read was short.
    pub fn next_interactive(&mut self) -> Option<T> {
        self.interactive.pop_front()
    }

    /// Returns the number of sockets that may be read.
    pub fn readable(&self) -> usize {
        match self.large.is_any_queued() {
            true => self.len() - self.throughput.iter().filter(|member| !self.may_read(member)).count(),
            false => self.len(),
        }
    }

    /// Returns whether a socket may be read; otherwise it waits for payloads of others.
    pub fn may_read(&self, member: &T) -> bool {
        self.large.may_read(member.payload_since())
    }

    /// Takes the next socket. Returns `None` if there is none, or if all wait for payloads of
    /// others.
    pub fn next(&mut self) -> Option<T> {
        if let Some(interactive) = self.next_interactive() {
            return Some(interactive);
        }
        self.large.expire(Instant::now);
        let first = self.throughput.iter().position(|member| self.may_read(member))?;
        let first = self.throughput.remove(first)?;
        let since = first.payload_since();
        if !self.large.is_active(since) {
            return Some(first);
        }
        let number = |i: usize| self.throughput[i].payload_since();
        let is_older = |i: &usize| number(*i) < since && self.large.is_active(number(*i));
        let oldest = (0..self.throughput.len()).filter(is_older).min_by_key(|i| number(*i));
        match oldest.and_then(|i| self.throughput.remove(i)) {
            Some(oldest) => {
                self.throughput.push_back(first);
                Some(oldest)
            }
            None => Some(first),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;
    use std::rc::Rc;
    use std::sync::Arc;
    use std::time::Duration;

    /// A socket's name, the number of its payload, and its flag for a short last read.
    #[derive(Clone)]
    struct Named(char, Rc<Cell<u64>>, bool);

    impl Member for Named {
        fn payload_since(&self) -> u64 {
            self.1.get()
        }

        fn is_interactive(&self) -> bool {
            self.2
        }
    }

    fn named(name: char, since: u64) -> Named {
        Named(name, Rc::new(Cell::new(since)), false)
    }

    /// Begins a payload whose socket is empty. Returns its number.
    fn begin(ready: &mut ReadyQueue<Named>, now: Instant) -> u64 {
        ready.large.begin(now, Arc::default())
    }

    /// Returns the names in the order in which they are read, each queued again after its turn.
    fn turns(ready: &mut ReadyQueue<Named>, count: usize) -> String {
        let mut turn = || {
            let member = ready.next().unwrap();
            ready.push(member.clone());
            member.0
        };
        (0..count).map(|_| turn()).collect()
    }

    /// Returns a queue for which `count` payloads have begun at a time of which no test sees the
    /// end, and that time.
    fn with_payloads(count: u64) -> (ReadyQueue<Named>, Instant) {
        let (mut ready, later) = (ReadyQueue::new(), Instant::now() + Duration::from_secs(60));
        ready.large = LargePayloads::new(later);
        (1..=count).for_each(|number| assert_eq!(begin(&mut ready, later), number));
        (ready, later)
    }

    #[test]
    fn those_within_payloads_give_their_turns_to_the_oldest_and_others_keep_theirs() {
        let (mut ready, later) = with_payloads(2);
        let all = [named('a', 2), named('b', 1), named('x', 0), named('y', 0)];
        all.iter().for_each(|member| ready.push(member.clone()));
        assert_eq!(turns(&mut ready, 8), "bxybxybx");
        // Its payload is complete and the next has begun.
        ready.large.end(1, later);
        all[1].1.set(begin(&mut ready, later));
        assert_eq!(turns(&mut ready, 8).replace(['x', 'y'], ""), "aaa");
    }

    #[test]
    fn interactive_sockets_go_before_all_others() {
        let mut ready = ReadyQueue::new();
        assert!(ready.is_empty() && ready.next().is_none() && ready.next_interactive().is_none());
        ready.push(named('a', 1));
        ready.push(named('x', 0));
        ready.push(Named('s', Rc::default(), true));
        ready.push(Named('t', Rc::default(), true));
        assert!(ready.len() == 4 && ready.holds(|member| member.0 == 't'));
        assert_eq!(ready.next_interactive().unwrap().0, 's');
        let mut turn = || ready.next().unwrap().0;
        assert_eq!([turn(), turn(), turn()], ['t', 'a', 'x']);
        assert!(ready.is_empty());
    }

    #[test]
    fn payloads_beyond_the_first_two_wait_until_one_ends() {
        let (mut ready, later) = with_payloads(4);
        // The first two have no bytes now; the others have.
        let all = [named('c', 3), named('d', 4)];
        ready.push(all[1].clone());
        ready.push(all[0].clone());
        assert_eq!((ready.len(), ready.readable()), (2, 0));
        assert!(ready.next().is_none());
        ready.push(named('x', 0));
        assert_eq!((ready.readable(), ready.next().unwrap().0), (1, 'x'));
        ready.large.end(1, later);
        assert_eq!((ready.readable(), ready.next().unwrap().0), (1, 'c'));
        assert_eq!((ready.readable(), ready.len()), (0, 1));
    }

    #[test]
    fn slow_payloads_keep_their_turns_and_take_none() {
        let (mut ready, later) = with_payloads(4);
        let much_later = later + Duration::from_secs(60);
        // 1 and 2 are slow, 3 to 6 are read, and 7 waits.
        ready.large.expire(|| much_later);
        (5..=7).for_each(|number| assert_eq!(begin(&mut ready, much_later), number));
        for member in [named('a', 1), named('b', 2), named('d', 4), named('c', 3), named('g', 7)] {
            ready.push(member);
        }
        assert_eq!(turns(&mut ready, 8), "abcabcab");
        assert_eq!(ready.readable(), 4);
    }

    #[test]
    fn a_short_read_within_a_payload_that_waits_brings_no_turn() {
        let (mut ready, later) = with_payloads(3);
        ready.push(Named('c', Rc::new(Cell::new(3)), true));
        assert!(ready.next_interactive().is_none() && ready.next().is_none());
        assert_eq!((ready.len(), ready.readable()), (1, 0));
        ready.large.end(1, later);
        assert_eq!((ready.readable(), ready.next().unwrap().0), (1, 'c'));
    }
}
