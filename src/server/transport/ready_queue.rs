//! The queue of readable sockets, in the order in which they are read: those whose last read was
//! short before all others, and of those within large payloads the one whose payload began first.
//!
//! A payload is held in memory until it is complete. If many connections send large ones and each
//! is read in rotation, all of them are held at the same time, in more memory than any cache has.
//! So connections within a large payload give their places in the rotation to the one of them whose
//! payload began first, and only a few payloads are read at a time (`large_payloads.rs`). Other
//! connections keep their places. A connection whose payload is complete waits until the payloads
//! that began before its next one are complete, too.

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
        match member.is_interactive() {
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
        let may_read = |member: &&T| self.large.may_read(member.payload_since());
        self.interactive.len() + self.throughput.iter().filter(may_read).count()
    }

    /// Takes the next socket. Returns `None` if there is none, or if all wait for payloads of
    /// others.
    pub fn next(&mut self) -> Option<T> {
        if let Some(interactive) = self.next_interactive() {
            return Some(interactive);
        }
        if self.large.patience(Instant::now()).is_some() {
            self.large.expire(Instant::now());
        }
        let may_read = |member: &T| self.large.may_read(member.payload_since());
        let first = self.throughput.iter().position(may_read)?;
        let first = self.throughput.remove(first)?;
        let since = first.payload_since();
        if since == 0 {
            return Some(first);
        }
        let began = |member: &T| {
            let number = Some(member.payload_since()).filter(|&n| n > 0 && n < since)?;
            self.large.may_read(number).then_some(number)
        };
        let oldest = (0..self.throughput.len()).filter_map(|i| Some((began(&self.throughput[i])?, i))).min();
        match oldest.and_then(|(_, i)| self.throughput.remove(i)) {
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

    #[test]
    fn those_within_payloads_give_their_turns_to_the_oldest_and_others_keep_theirs() {
        let mut ready = ReadyQueue::new();
        let all = [named('a', 7), named('b', 5), named('x', 0), named('c', 6), named('y', 0)];
        all.iter().for_each(|member| ready.push(member.clone()));
        let mut turns = |count: usize| {
            let mut turn = || {
                let member = ready.next().unwrap();
                ready.push(member.clone());
                member.0
            };
            (0..count).map(|_| turn()).collect::<String>()
        };
        assert_eq!(turns(8), "bxbybxby");
        // Its payload is complete and the next has begun: it goes behind those that wait.
        all[1].1.set(8);
        assert_eq!(turns(8).replace(['x', 'y'], ""), "cccc");
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
        let mut ready = ReadyQueue::new();
        let now = Instant::now();
        let numbers = [0; 4].map(|_| ready.large.begin(now));
        let all: Vec<Named> = "abcd".chars().zip(numbers).map(|(c, n)| named(c, n)).collect();
        // The first two have no bytes now; the others have.
        ready.push(all[3].clone());
        ready.push(all[2].clone());
        assert_eq!((ready.len(), ready.readable()), (2, 0));
        ready.push(named('x', 0));
        assert_eq!((ready.readable(), ready.next().unwrap().0), (1, 'x'));
        ready.large.end(1, now);
        assert_eq!((ready.readable(), ready.next().unwrap().0), (1, 'c'));
        // From a time that has passed on, the first ones are slow.
        ready.push(all[2].clone());
        ready.large = LargePayloads::new(now);
        let long_ago = now.checked_sub(std::time::Duration::from_secs(60)).unwrap_or(now);
        assert_eq!([0; 4].map(|_| ready.large.begin(long_ago)), numbers);
        assert_eq!([ready.next().unwrap().0, ready.next().unwrap().0], ['c', 'd']);
    }

    #[test]
    fn a_payload_that_waits_is_not_read_before_a_slow_one() {
        let mut ready = ReadyQueue::new();
        let now = Instant::now();
        assert_eq!([0; 4].map(|_| ready.large.begin(now)), [1, 2, 3, 4]);
        // 1 and 2 are slow; 3 and 4 are read; 5 and 6 wait.
        ready.large.expire(now + std::time::Duration::from_secs(60));
        let later = now + std::time::Duration::from_secs(60);
        assert_eq!([0; 2].map(|_| ready.large.begin(later)), [5, 6]);
        ready.push(named('e', 5));
        ready.push(named('b', 2));
        ready.push(named('a', 1));
        let mut names = Vec::new();
        while let Some(member) = ready.next() {
            names.push(member.0);
        }
        assert_eq!((names, ready.len()), (vec!['a', 'b'], 1));
    }
}
