//! A frame on a number of cores: its pieces in the order in which rayon's threads take them.
//!
//! A region's pieces are halved until one is left. A thread goes on with the first half and keeps the
//! second one where others can take it; it takes its own back, the youngest first. A thread without
//! work takes the oldest from another. One that has slept comes later: each thread that is awake wakes
//! one more, so that the number of those awake doubles in each time of waking.
//!
//! In: steps of a frame, their times measured on one core. Out: the time of the frame. What is not in
//! the model: pieces that slow each other down because they share caches, memory, or a core.

use super::trace::Step;
use std::collections::VecDeque;
use std::ops::Range;

/// Costs of threads, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ThreadCosts {
    /// From the beginning of a region until a thread that slept has begun a piece.
    pub wake: f64,
    /// Time for which a thread without work looks for some before it sleeps.
    pub awake: f64,
    /// Taking work from another thread.
    pub steal: f64,
}

/// Returns the time of a frame on this many cores, right after another frame: its threads are awake.
pub(super) fn frame_time(steps: &[Step], cores: usize, costs: &ThreadCosts) -> f64 {
    let (mut time, mut idle) = (0.0, 0.0);
    for step in steps {
        match step {
            Step::Serial(took) => {
                time += took;
                idle += took;
            }
            Step::Pieces(pieces) if pieces.len() < 2 => time += pieces.iter().sum::<f64>(),
            Step::Pieces(pieces) => {
                let wake = if idle > costs.awake { costs.wake } else { 0.0 };
                time += region_time(pieces, cores, wake, costs.steal);
                idle = 0.0;
            }
        }
    }
    time
}

/// A thread of the simulation.
struct Worker {
    /// Time when it looks for work next.
    ready: f64,
    /// Runs of pieces that others may take: the oldest at the front.
    kept: VecDeque<Range<usize>>,
}

/// Returns the time of a region.
fn region_time(pieces: &[f64], cores: usize, wake: f64, steal: f64) -> f64 {
    // The k-th thread wakes when the number of those awake has doubled often enough.
    let arrival = |k: usize| wake * f64::from((k + 1).next_power_of_two().ilog2());
    let new = |k| Worker { ready: arrival(k), kept: VecDeque::new() };
    let mut workers: Vec<Worker> = (0..cores.clamp(1, pieces.len())).map(new).collect();
    workers[0].kept.push_back(0..pieces.len());
    let (mut left, mut end) = (pieces.len(), 0.0_f64);
    while left > 0 {
        let next = |a: &usize, b: &usize| workers[*a].ready.total_cmp(&workers[*b].ready);
        let k = (0..workers.len()).min_by(next).unwrap_or(0);
        let own = workers[k].kept.pop_back();
        let taken = own.map(|run| (run, 0.0)).or_else(|| {
            let longest =
                (0..workers.len()).max_by_key(|&other| workers[other].kept.front().map_or(0, Range::len));
            Some((workers[longest?].kept.pop_front()?, steal))
        });
        let Some((mut run, cost)) = taken else {
            // Nothing to take until another thread has divided what it takes next.
            let now = workers[k].ready;
            let busy = workers.iter().map(|w| w.ready).filter(|ready| *ready > now);
            workers[k].ready = busy.fold(f64::INFINITY, f64::min);
            continue;
        };
        while run.len() > 1 {
            let half = run.start + run.len() / 2;
            workers[k].kept.push_back(half..run.end);
            run.end = half;
        }
        workers[k].ready += cost + pieces[run.start];
        end = end.max(workers[k].ready);
        left -= 1;
    }
    end
}

#[cfg(test)]
mod tests {
    use super::*;

    const FREE: ThreadCosts = ThreadCosts { wake: 0.0, awake: 1.0, steal: 0.0 };

    fn time(pieces: &[f64], cores: usize) -> f64 {
        frame_time(&[Step::Pieces(pieces.to_vec())], cores, &FREE)
    }

    #[test]
    fn equal_pieces_are_shared_evenly_and_no_more_cores_help_than_there_are_pieces() {
        let pieces = [1.0; 64];
        for (cores, want) in [(1, 64.0), (2, 32.0), (4, 16.0), (8, 8.0), (64, 1.0), (100, 1.0)] {
            assert_eq!(time(&pieces, cores), want, "{cores}");
        }
        assert_eq!(time(&[1.0; 3], 2), 2.0);
    }

    #[test]
    fn one_long_piece_is_the_least_time() {
        let mut pieces = [1.0; 32];
        pieces[31] = 100.0;
        assert_eq!(time(&pieces, 1), 131.0);
        // The second thread takes the second half, and reaches the long piece after 15 others at the
        // latest.
        assert!((100.0..=116.0).contains(&time(&pieces, 2)), "{}", time(&pieces, 2));
        assert!((100.0..=104.0).contains(&time(&pieces, 32)), "{}", time(&pieces, 32));
    }

    #[test]
    fn never_longer_than_the_greedy_bound_and_never_shorter_than_the_work_allows() {
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f64 / 1e6
        };
        for count in [1, 2, 5, 17, 40, 301] {
            let pieces: Vec<f64> = (0..count).map(|_| random()).collect();
            let (sum, longest) = (pieces.iter().sum::<f64>(), pieces.iter().copied().fold(0.0, f64::max));
            for cores in [1, 2, 3, 4, 16, 64] {
                let found = time(&pieces, cores);
                let least = longest.max(sum / cores as f64);
                // Graham's bound for any order in which no thread waits while there is work.
                let most = sum / cores as f64 + longest * (1.0 - 1.0 / cores as f64);
                assert!(found >= least * (1.0 - 1e-12) && found <= most * (1.0 + 1e-12), "{count} {cores}");
            }
        }
    }

    #[test]
    fn serial_steps_add_up_and_threads_that_slept_come_later() {
        let costs = ThreadCosts { wake: 1.0, awake: 5.0, steal: 0.25 };
        let pieces = Step::Pieces(vec![4.0; 2]);
        assert_eq!(frame_time(std::slice::from_ref(&pieces), 2, &costs), 4.25);
        let steps = [pieces.clone(), Step::Serial(3.0), pieces.clone(), Step::Serial(6.0), pieces];
        assert_eq!(frame_time(&steps, 2, &costs), 4.25 + 3.0 + 4.25 + 6.0 + 5.25);
        assert_eq!(frame_time(&steps, 1, &costs), 8.0 + 3.0 + 8.0 + 6.0 + 8.0);
    }
}
