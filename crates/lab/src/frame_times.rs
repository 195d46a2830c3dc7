//! Times of single frames, and their percentiles.
//!
//! In: the duration of each frame. Out: percentiles by nearest rank: the p-th is the shortest of
//! the times that at least p percent of the frames did not exceed, so it always is one of them.

use std::fmt;
use std::time::Duration;

/// Durations of frames, in any order.
#[derive(Clone, Debug, Default)]
pub struct FrameTimes(Vec<Duration>);

impl FrameTimes {
    /// Adds a frame's duration.
    pub fn push(&mut self, time: Duration) {
        self.0.push(time);
    }

    /// Returns the number of frames.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns whether there are no frames.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns percentiles in milliseconds, in the order asked for: 0 is the shortest frame, 50 the
    /// median, 100 the longest. NaN without frames.
    pub fn percentiles_ms<const N: usize>(&self, percents: [usize; N]) -> [f64; N] {
        let mut sorted = self.0.clone();
        sorted.sort_unstable();
        percents.map(|percent| {
            let rank = (percent * sorted.len()).div_ceil(100).max(1);
            sorted.get(rank - 1).map_or(f64::NAN, |time| time.as_secs_f64() * 1e3)
        })
    }
}

impl fmt::Display for FrameTimes {
    /// Writes the number of frames, the median, the 99th percentile and the longest on one line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [median, p99, longest] = self.percentiles_ms([50, 99, 100]);
        write!(
            f,
            "{} frames: median {median:.3} ms, 99th percentile {p99:.3} ms, longest {longest:.3} ms",
            self.len()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(milliseconds: impl IntoIterator<Item = u64>) -> FrameTimes {
        FrameTimes(milliseconds.into_iter().map(Duration::from_millis).collect())
    }

    #[test]
    fn percentiles_are_of_the_nearest_rank() {
        assert_eq!(of((1..=200).rev()).percentiles_ms([0, 1, 50, 99, 100]), [1.0, 2.0, 100.0, 198.0, 200.0]);
        assert_eq!(of([7, 5]).percentiles_ms([0, 50, 51, 99]), [5.0, 5.0, 7.0, 7.0]);
        assert_eq!(of([9]).percentiles_ms([0, 50, 100]), [9.0; 3]);
        assert!(of([]).percentiles_ms([50])[0].is_nan());
    }

    #[test]
    fn one_late_frame_of_a_hundred_is_no_percentile_but_the_longest() {
        let line = of((0..99).map(|_| 4).chain([90])).to_string();
        assert_eq!(line, "100 frames: median 4.000 ms, 99th percentile 4.000 ms, longest 90.000 ms");
    }
}
