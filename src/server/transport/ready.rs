//! READY: the sockets that can be read, in turns; and of those that send large payloads the one that goes first.
//!
//! A payload is held until it is whole. When many connections send large ones and each is read in its turn, all of them are
//! held at the same time, in more memory than any cache has. So those that are within a large payload give their turns
//! to the one of them whose payload began first. The turns of all others are theirs: those within payloads have no more than
//! before, and one whose payload is whole waits until those that began before its next one are whole, too.

use std::collections::VecDeque;

/// One that gave less is watched before it is read again.
const MUCH_BYTES: usize = 64 << 10;
/// So many turns of those within payloads are given before it is looked which others can be read.
const MOST_GIVEN: usize = 8;

/// A socket.
pub(super) trait Member: Clone {
    /// When the large payload began that it is in the midst of, as a number that grows; 0 when it is in none.
    fn payload_since(&self) -> u64;
}

pub(super) struct Ready<T> {
    line: VecDeque<T>,
    given: usize,
}

impl<T: Member> Ready<T> {
    pub fn new() -> Self {
        Ready { line: VecDeque::new(), given: 0 }
    }

    /// One more that can be read.
    pub fn push(&mut self, member: T) {
        self.line.push_back(member);
    }

    /// After a read that gave so many bytes: whether it stays here, because it is within a payload and there may be more.
    pub fn keep(&mut self, member: &T, bytes: usize) -> bool {
        let stays = bytes >= MUCH_BYTES && member.payload_since() > 0;
        if stays {
            self.push(member.clone());
        }
        stays
    }

    pub fn is_empty(&self) -> bool {
        self.line.is_empty()
    }

    pub fn len(&self) -> usize {
        self.line.len()
    }

    /// Whether there is one of this kind.
    pub fn holds(&self, what: impl FnMut(&T) -> bool) -> bool {
        self.line.iter().any(what)
    }

    /// Whether the system is to be asked for more of them first.
    pub fn is_stale(&self) -> bool {
        self.line.is_empty() || self.given >= MOST_GIVEN
    }

    /// It was asked.
    pub fn refresh(&mut self) {
        self.given = 0;
    }

    /// Whose turn it is.
    pub fn next(&mut self) -> Option<T> {
        let first = self.line.pop_front()?;
        let since = first.payload_since();
        if since == 0 {
            return Some(first);
        }
        self.given += 1;
        let began = |member: &T| Some(member.payload_since()).filter(|&n| n > 0 && n < since);
        let oldest = (0..self.line.len()).filter_map(|i| Some((began(&self.line[i])?, i))).min();
        match oldest.and_then(|(_, i)| self.line.remove(i)) {
            Some(oldest) => {
                self.push(first);
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

    /// Its name, and when its payload began.
    #[derive(Clone)]
    struct Named(char, Rc<Cell<u64>>);

    impl Member for Named {
        fn payload_since(&self) -> u64 {
            self.1.get()
        }
    }

    fn named(name: char, since: u64) -> Named {
        Named(name, Rc::new(Cell::new(since)))
    }

    #[test]
    fn those_within_payloads_give_their_turns_to_the_oldest_and_others_keep_theirs() {
        let mut ready = Ready::new();
        let all = [named('a', 7), named('b', 5), named('x', 0), named('c', 6), named('y', 0)];
        all.iter().for_each(|member| ready.push(member.clone()));
        let mut turns = |count: usize| {
            let mut turn = || {
                let member = ready.next().unwrap();
                if !ready.keep(&member, MUCH_BYTES) {
                    ready.push(member.clone());
                }
                member.0
            };
            (0..count).map(|_| turn()).collect::<String>()
        };
        assert_eq!(turns(8), "bxbybxby");
        // Its payload is whole and the next has begun: it goes behind those that wait.
        all[1].1.set(8);
        assert_eq!(turns(8).replace(['x', 'y'], ""), "cccc");
    }

    #[test]
    fn one_that_gave_little_is_watched_and_the_system_is_asked_now_and_then() {
        let mut ready = Ready::new();
        assert!(ready.is_stale() && ready.is_empty());
        let (a, b) = (named('a', 1), named('b', 2));
        assert!(!ready.keep(&a, MUCH_BYTES - 1) && ready.is_empty());
        assert!(!ready.keep(&named('x', 0), 1 << 20));
        ready.push(b);
        for _ in 0..MOST_GIVEN {
            assert!(!ready.is_stale());
            let member = ready.next().unwrap();
            assert_eq!(member.0, 'b', "the older one has nothing");
            assert!(ready.keep(&member, MUCH_BYTES));
        }
        assert!(ready.is_stale() && !ready.is_empty());
        ready.refresh();
        ready.push(a);
        assert!(!ready.is_stale());
        assert_eq!(ready.next().unwrap().0, 'a');
    }
}
