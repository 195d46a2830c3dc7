//! Time taken by a piece of work that can be repeated.

use std::time::{Duration, Instant};

/// How long one run takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// The shortest run, seconds.
    pub min_s: f64,
    /// The run in the middle, seconds.
    pub median_s: f64,
    /// How many runs there were.
    pub runs: usize,
}

/// Runs `work` until `budget` is used up, at least three times; the last output and the times.
pub(super) fn time<T>(budget: Duration, mut work: impl FnMut() -> T) -> (T, Timing) {
    let begin = Instant::now();
    let mut times = Vec::new();
    loop {
        let start = Instant::now();
        let output = work();
        times.push(start.elapsed().as_secs_f64());
        if (times.len() >= 3 && begin.elapsed() >= budget) || times.len() >= 10_000 {
            times.sort_by(f64::total_cmp);
            let timing = Timing { min_s: times[0], median_s: times[times.len() / 2], runs: times.len() };
            return (output, timing);
        }
    }
}
