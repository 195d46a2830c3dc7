//! The queue of jobs: which connection's job begins next, and how many run beside each other.
//!
//! In: jobs with their connections, and times. Out: the next job, or none for now. The connection
//! whose jobs have run for the least time is next. [`USUAL`] jobs run at a time; a job of a connection
//! that has hardly run any begins beside them, up to [`MOST`], once those that run are long ones. So a
//! few connections whose jobs take long share the usual places, and make no other wait.
//!
//! Times are arguments, so that tests need no clock.

use super::Id;
use std::collections::{HashMap, VecDeque};
use std::time::{Duration, Instant};

/// Jobs that run at a time: more than a small machine has cores, so that long jobs of a few clients
/// leave room for those of others.
const USUAL: usize = 4;
/// Jobs that run at a time at most.
pub(super) const MOST: usize = 16;
/// Time of running from which a job is a long one, and a connection one of long jobs.
pub(super) const LONG: Duration = Duration::from_millis(50);
/// A connection's time is forgotten at this fraction of the time that passes.
const FORGOTTEN: u32 = 4;

/// Jobs that wait, and the times of those that run or have run.
pub(super) struct Queue<T> {
    waiting: VecDeque<(Id, T)>,
    running: Vec<(Id, Instant)>,
    /// Time that a connection's jobs have run, and when that was counted.
    used: HashMap<Id, (Duration, Instant)>,
}

impl<T> Default for Queue<T> {
    fn default() -> Self {
        Queue { waiting: VecDeque::new(), running: Vec::new(), used: HashMap::new() }
    }
}

impl<T> Queue<T> {
    /// Adds a job.
    pub fn push(&mut self, connection: Id, job: T) {
        self.waiting.push_back((connection, job));
    }

    /// Returns the number of jobs that wait.
    pub fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// Takes the job that begins now, if one may.
    pub fn next(&mut self, now: Instant) -> Option<(Id, T)> {
        // Of connections with equal times, the first that came.
        let (index, used) = (self.waiting.iter().enumerate())
            .map(|(index, (connection, _))| (index, self.used(*connection, now)))
            .min_by_key(|(_, used)| *used)?;
        let short = self.running.iter().filter(|(_, begun)| now.duration_since(*begun) < LONG).count();
        let may_begin_beside = used < LONG && short < USUAL && self.running.len() < MOST;
        if self.running.len() >= USUAL && !may_begin_beside {
            return None;
        }
        let (connection, job) = self.waiting.remove(index)?;
        self.running.push((connection, now));
        Some((connection, job))
    }

    /// Counts the time of a connection's job that has ended.
    pub fn end(&mut self, connection: Id, now: Instant) {
        let Some(index) = self.running.iter().position(|(of, _)| *of == connection) else { return };
        let (_, begun) = self.running.swap_remove(index);
        let used = self.used(connection, now) + now.duration_since(begun);
        self.used.insert(connection, (used, now));
        if self.used.len() > 4 * MOST {
            self.used.retain(|_, (used, counted)| remaining(*used, *counted, now) > Duration::ZERO);
        }
    }

    fn used(&self, connection: Id, now: Instant) -> Duration {
        self.used.get(&connection).map_or(Duration::ZERO, |(used, counted)| remaining(*used, *counted, now))
    }
}

/// Returns what is not forgotten of a time that was counted earlier.
fn remaining(used: Duration, counted: Instant, now: Instant) -> Duration {
    used.saturating_sub(now.duration_since(counted) / FORGOTTEN)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    /// Begins all jobs that may begin; returns their connections.
    fn begin(queue: &mut Queue<()>, now: Instant) -> Vec<Id> {
        std::iter::from_fn(|| queue.next(now)).map(|(connection, ())| connection).collect()
    }

    #[test]
    fn a_connection_that_has_run_nothing_waits_for_no_long_job() {
        let (mut queue, start) = (Queue::default(), Instant::now());
        (0..8).for_each(|id| queue.push(id, ()));
        assert_eq!(begin(&mut queue, start), [0, 1, 2, 3], "short ones until they are known to be long");
        let known = start + LONG;
        assert_eq!(begin(&mut queue, known), [4, 5, 6, 7]);
        queue.push(100, ());
        assert_eq!(begin(&mut queue, known).len(), 0, "no more than four at a time are begun beside others");
        assert_eq!(begin(&mut queue, known + LONG), [100]);
        // From the second job on, those of long jobs have four places together.
        let later = start + SECOND;
        (0..8).for_each(|id| queue.end(id, later));
        queue.end(100, known + LONG);
        (0..8).for_each(|id| queue.push(id, ()));
        assert_eq!(begin(&mut queue, later).len(), 4);
        let later = later + SECOND;
        assert_eq!(begin(&mut queue, later).len(), 0);
        (200..205).for_each(|id| queue.push(id, ()));
        assert_eq!(begin(&mut queue, later), [200, 201, 202, 203], "they pass by those that wait");
        assert_eq!(begin(&mut queue, later + LONG), [204]);
        assert_eq!(queue.waiting(), 4);
    }

    #[test]
    fn the_places_are_shared_by_time_and_bounded() {
        let (mut queue, mut now) = (Queue::default(), Instant::now());
        // Connection 1 has jobs of a second, 2 of a quarter: beside three that never end.
        (10..13).for_each(|id| queue.push(id, ()));
        assert_eq!(begin(&mut queue, now).len(), 3);
        let mut ran = [Duration::ZERO; 2];
        queue.push(1, ());
        queue.push(2, ());
        for _ in 0..100 {
            // Both have run long jobs, so one place is left for them.
            let begun = begin(&mut queue, now);
            now += if begun == [1] { SECOND } else { SECOND / 4 };
            for id in begun {
                ran[id as usize - 1] += if id == 1 { SECOND } else { SECOND / 4 };
                queue.end(id, now);
                queue.push(id, ());
            }
        }
        let [a, b] = ran.map(|ran| ran.as_secs_f64());
        assert!(a > 5.0 && b > 5.0 && (0.5..2.0).contains(&(a / b)), "{a} s and {b} s");
        // However many connections come, so many jobs run and no more; and all of them end.
        let (mut queue, mut begun) = (Queue::default(), 0);
        (0..1000).for_each(|id| queue.push(id, ()));
        for _ in 0..20 {
            begun += begin(&mut queue, now).len();
            now += SECOND;
        }
        assert_eq!(begun, MOST);
        for id in 0..1000 {
            queue.end(id, now);
            begun += begin(&mut queue, now).len();
            now += SECOND;
        }
        assert_eq!((begun, queue.waiting()), (1000, 0));
        assert!(queue.used.len() <= 200 && queue.running.len() <= MOST);
    }
}
