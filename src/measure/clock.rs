//! Timing of repeatable work.
//!
//! Work that is shorter than the clock can tell is run many times in a sample; the duration of a run
//! is the sample's divided by them. Outputs pass through [`black_box`], so that work whose result
//! nobody uses is done nevertheless; whoever calls [`time`] passes the inputs through it as well. A
//! timing has the median of its samples and the quartiles around it; where even a whole sample is
//! not far above the clock's step, it says so ([`Timing::is_measurable`]).

use std::hint::black_box;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Least number of samples, unless they take more than [`PATIENCE`] times the budget.
const LEAST_SAMPLES: usize = 30;
/// Largest number of samples.
const MOST_SAMPLES: usize = 10_000;
/// Multiple of the budget after which fewer samples have to do, but at least three.
const PATIENCE: u32 = 5;
/// Steps of the clock that a sample lasts at least: its error is then below 1 %.
const STEPS_IN_SAMPLE: f64 = 100.0;
/// Largest number of runs in a sample.
const MOST_RUNS: usize = 1 << 20;

/// Durations of one run, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// First quartile, median and third quartile of the samples.
    pub quartiles_s: [f64; 3],
    /// Number of samples.
    pub samples: usize,
    /// Number of runs in each sample.
    pub runs: usize,
}

impl Timing {
    /// Returns the timing with these samples, whose durations are those of `runs` runs each.
    fn of(mut samples_s: Vec<f64>, runs: usize) -> Timing {
        samples_s.sort_by(f64::total_cmp);
        let last = samples_s.len() - 1;
        let quartile = |k: usize| samples_s[(last * k + 2) / 4] / runs as f64;
        Timing { quartiles_s: [quartile(1), quartile(2), quartile(3)], samples: samples_s.len(), runs }
    }

    /// Returns a timing of one sample.
    pub fn single(seconds: f64) -> Timing {
        Timing { quartiles_s: [seconds; 3], samples: 1, runs: 1 }
    }

    /// Returns the median.
    pub fn median_s(&self) -> f64 {
        self.quartiles_s[1]
    }

    /// Returns the distance of the quartiles as a part of the median.
    pub fn spread(&self) -> f64 {
        (self.quartiles_s[2] - self.quartiles_s[0]) / self.quartiles_s[1]
    }

    /// Returns whether samples last long enough for the clock.
    pub fn is_measurable(&self) -> bool {
        self.median_s() * self.runs as f64 >= STEPS_IN_SAMPLE * clock_step_s()
    }
}

/// Returns the smallest time between two different readings of the clock, in seconds; measured once.
fn clock_step_s() -> f64 {
    static STEP: OnceLock<f64> = OnceLock::new();
    *STEP.get_or_init(|| {
        let step = |_| {
            let start = Instant::now();
            loop {
                let passed = start.elapsed();
                if !passed.is_zero() {
                    return passed.as_secs_f64();
                }
            }
        };
        (0..100).map(step).fold(f64::INFINITY, f64::min)
    })
}

/// Runs `work` until `budget` is used up and there are 30 samples. Returns the last output and the
/// timing.
pub(super) fn time<T>(budget: Duration, mut work: impl FnMut() -> T) -> (T, Timing) {
    let begin = Instant::now();
    let mut output = black_box(work());
    let mut runs = 1;
    let mut samples_s = Vec::new();
    loop {
        let start = Instant::now();
        for _ in 0..runs {
            output = black_box(work());
        }
        let sample_s = start.elapsed().as_secs_f64();
        // Until a sample lasts for the clock's sake, it only tells how many runs one needs.
        if samples_s.is_empty() && runs < MOST_RUNS && sample_s < 2.0 * STEPS_IN_SAMPLE * clock_step_s() {
            runs *= 2;
            continue;
        }
        samples_s.push(sample_s);
        let (count, spent) = (samples_s.len(), begin.elapsed());
        let is_enough = count >= LEAST_SAMPLES || (count >= 3 && spent >= PATIENCE * budget);
        if (is_enough && spent >= budget) || count >= MOST_SAMPLES {
            return (output, Timing::of(samples_s, runs));
        }
    }
}

/// Runs several works in turns until each has its `budget` and 30 samples, so that all see the same
/// machine. Returns their timings.
pub(super) fn in_turns(budget: Duration, works: &mut [Box<dyn FnMut() + '_>]) -> Vec<Timing> {
    let sample = |work: &mut Box<dyn FnMut() + '_>, runs: usize| {
        let start = Instant::now();
        (0..runs).for_each(|_| work());
        start.elapsed().as_secs_f64()
    };
    let mut runs = vec![1; works.len()];
    for (work, runs) in works.iter_mut().zip(&mut runs) {
        work();
        while *runs < MOST_RUNS && sample(work, *runs) < 2.0 * STEPS_IN_SAMPLE * clock_step_s() {
            *runs *= 2;
        }
    }
    let all = budget * works.len().max(1) as u32;
    let mut samples_s: Vec<Vec<f64>> = vec![Vec::new(); works.len()];
    let begin = Instant::now();
    for count in 1..=MOST_SAMPLES {
        for ((work, runs), samples_s) in works.iter_mut().zip(&runs).zip(&mut samples_s) {
            samples_s.push(sample(work, *runs));
        }
        let spent = begin.elapsed();
        let is_enough = count >= LEAST_SAMPLES || (count >= 3 && spent >= PATIENCE * all);
        if is_enough && spent >= all {
            break;
        }
    }
    samples_s.into_iter().zip(runs).map(|(samples_s, runs)| Timing::of(samples_s, runs)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_are_those_of_single_runs() {
        let timing = Timing::of(vec![5.0, 1.0, 4.0, 2.0, 3.0], 10);
        assert_eq!(timing.quartiles_s, [0.2, 0.3, 0.4]);
        assert_eq!((timing.samples, timing.runs), (5, 10));
        assert!((timing.spread() - 2.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn short_work_is_repeated_within_a_sample() {
        let mut count = 0u64;
        let (output, timing) = time(Duration::from_millis(1), || {
            count += 1;
            count
        });
        assert_eq!(output, count);
        assert!(timing.samples >= 30 && timing.runs > 1 && timing.is_measurable(), "{timing:?}");
        assert!(!Timing { runs: 1, ..timing }.is_measurable());
        let [low, median, high] = timing.quartiles_s;
        assert!(0.0 < low && low <= median && median <= high);
    }

    #[test]
    fn works_in_turns_have_as_many_samples_each() {
        let order = std::cell::RefCell::new(Vec::new());
        let pause = |who: u8, ms| {
            let order = &order;
            move || {
                std::thread::sleep(Duration::from_millis(ms));
                order.borrow_mut().push(who);
            }
        };
        let timings = in_turns(Duration::ZERO, &mut [Box::new(pause(0, 1)), Box::new(pause(1, 2))]);
        assert!(timings.len() == 2 && timings[0].samples == timings[1].samples, "{timings:?}");
        let order = order.borrow();
        assert!(order[4..].chunks_exact(2).all(|two| two[0] != two[1]), "{order:?}");
    }

    #[test]
    fn long_work_takes_few_samples() {
        let (_, timing) = time(Duration::ZERO, || std::thread::sleep(Duration::from_millis(2)));
        assert!(timing.samples >= 3 && timing.samples <= 30 && timing.runs == 1, "{timing:?}");
    }
}
