//! Timing of repeatable work.

use std::time::{Duration, Instant};

/// Duration of one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Shortest run in seconds.
    pub min_s: f64,
    /// Median run in seconds.
    pub median_s: f64,
    /// Number of runs.
    pub runs: usize,
}

/// Runs `work` until `budget` is used up, at least three times. Returns the last output and the
/// timing.
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
