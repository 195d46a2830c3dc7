//! Timing of repeatable work.
//!
//! Alternatives that are to be compared are timed in turns, so that all meet the same load of the
//! machine, and compared round by round ([`Timing::over`]). Work that is shorter than a sample is
//! repeated within one; the duration of a run is the sample's divided by the number of runs. Outputs
//! pass through [`black_box`], so that work whose result nobody uses is not optimized away; callers
//! of [`time`] pass the inputs through it as well. A timing has the median of its samples and the
//! quartiles around it. [`Timing::is_measurable`] is false where a sample is too short for the clock.

use std::hint::black_box;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Least number of samples, unless they take more than [`PATIENCE`] times the budget.
const LEAST_SAMPLES: usize = 30;
/// Largest number of samples.
const MOST_SAMPLES: usize = 1_000;
/// Part of the budget that a sample lasts at least: work in turns begins with the caches of the
/// work before it, which a longer sample makes up for.
const PART_OF_BUDGET: u32 = 100;
/// Multiple of the budget after which fewer samples have to do, but at least three.
const PATIENCE: u32 = 5;
/// Steps of the clock that a sample lasts at least: its error is then below 1 %.
const STEPS_IN_SAMPLE: f64 = 100.0;
/// Largest number of runs in a sample.
const MOST_RUNS: usize = 1 << 20;

/// Work that can be repeated.
pub(super) type Work<'a, T> = Box<dyn FnMut() -> T + 'a>;

/// Durations of one run, in seconds.
#[derive(Clone, Debug, PartialEq)]
pub struct Timing {
    /// First quartile, median and third quartile of the samples.
    pub quartiles_s: [f64; 3],
    /// Number of runs in each sample.
    pub runs: usize,
    /// Duration of a run in each sample, one a round.
    rounds_s: Vec<f64>,
}

impl Timing {
    /// Returns the timing with these samples, one a round, whose durations are those of `runs` runs
    /// each.
    pub fn of(samples_s: &[f64], runs: usize) -> Timing {
        let rounds_s: Vec<f64> = samples_s.iter().map(|s| s / runs as f64).collect();
        Timing { quartiles_s: quartiles(rounds_s.clone()), runs, rounds_s }
    }

    /// Returns a timing of one sample.
    pub fn single(seconds: f64) -> Timing {
        Timing::of(&[seconds], 1)
    }

    /// Returns the number of samples.
    pub fn samples(&self) -> usize {
        self.rounds_s.len()
    }

    /// Returns the median.
    pub fn median_s(&self) -> f64 {
        self.quartiles_s[1]
    }

    /// Returns first quartile, median and third quartile of this time over that of another work,
    /// round by round: both were timed in turns.
    pub fn over(&self, other: &Timing) -> [f64; 3] {
        quartiles(self.rounds_s.iter().zip(&other.rounds_s).map(|(a, b)| a / b).collect())
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

/// Returns the quartiles of one value at least.
fn quartiles(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_unstable_by(f64::total_cmp);
    let last = values.len() - 1;
    [1, 2, 3].map(|k| values[(last * k + 2) / 4])
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
pub(super) fn time<T>(budget: Duration, work: impl FnMut() -> T) -> (T, Timing) {
    in_turns(budget, vec![Box::new(work)]).pop().expect("a result for the one work")
}

/// Runs a work as often as a sample needs. Returns the last output and the duration in seconds.
fn sample<T>(work: &mut Work<'_, T>, runs: usize) -> (T, f64) {
    let start = Instant::now();
    for _ in 1..runs {
        black_box(work());
    }
    let output = black_box(work());
    (output, start.elapsed().as_secs_f64())
}

/// Runs several works in turns until each has its `budget` and 30 samples, so that all see the same
/// machine: forth in one round, and back in the next. Returns their last outputs and timings.
pub(super) fn in_turns<T>(budget: Duration, mut works: Vec<Work<'_, T>>) -> Vec<(T, Timing)> {
    let least_s = (budget / PART_OF_BUDGET).as_secs_f64().max(2.0 * STEPS_IN_SAMPLE * clock_step_s());
    // Each work's runs in a sample, and its last output.
    let mut first = |work: &mut Work<'_, T>| {
        let (mut output, mut runs) = (black_box(work()), 1);
        while runs < MOST_RUNS {
            let (next, seconds) = sample(work, runs);
            output = next;
            if seconds >= least_s {
                break;
            }
            runs *= 2;
        }
        (runs, output)
    };
    let (runs, mut outputs): (Vec<usize>, Vec<T>) = works.iter_mut().map(&mut first).unzip();
    let all = budget * works.len().max(1) as u32;
    let mut samples_s: Vec<Vec<f64>> = vec![Vec::new(); works.len()];
    let begin = Instant::now();
    for round in 1..=MOST_SAMPLES {
        for k in 0..works.len() {
            let i = if round % 2 == 0 { works.len() - 1 - k } else { k };
            let (output, seconds) = sample(&mut works[i], runs[i]);
            outputs[i] = output;
            samples_s[i].push(seconds);
        }
        let spent = begin.elapsed();
        let is_enough = round >= LEAST_SAMPLES || (round >= 3 && spent >= PATIENCE * all);
        if is_enough && spent >= all {
            break;
        }
    }
    let timings = samples_s.iter().zip(runs).map(|(samples_s, runs)| Timing::of(samples_s, runs));
    outputs.into_iter().zip(timings).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_are_those_of_single_runs() {
        let timing = Timing::of(&[5.0, 1.0, 4.0, 2.0, 3.0], 10);
        assert_eq!(timing.quartiles_s, [0.2, 0.3, 0.4]);
        assert_eq!((timing.samples(), timing.runs), (5, 10));
        assert!((timing.spread() - 2.0 / 3.0).abs() < 1e-12);
    }

    /// A machine that becomes slower and slower changes both works of a round, and no ratio.
    #[test]
    fn ratios_are_taken_round_by_round() {
        let slower: Vec<f64> = (1..=100).map(f64::from).collect();
        let twice: Vec<f64> = slower.iter().map(|s| 2.0 * s).collect();
        let (a, b) = (Timing::of(&slower, 1), Timing::of(&twice, 1));
        assert_eq!((a.over(&b), b.over(&a)), ([0.5; 3], [2.0; 3]));
        assert!(a.spread() > 0.9 && a.quartiles_s[2] > b.quartiles_s[0]);
    }

    #[test]
    fn short_work_is_repeated_within_a_sample() {
        let mut count = 0u64;
        let (output, timing) = time(Duration::from_millis(1), || {
            count += 1;
            count
        });
        assert_eq!(output, count);
        assert!(timing.samples() >= 30 && timing.runs > 1 && timing.is_measurable(), "{timing:?}");
        let [low, median, high] = timing.quartiles_s;
        assert!(0.0 < low && low <= median && median <= high);
        assert!(!Timing { runs: 1, ..timing }.is_measurable());
    }

    #[test]
    fn works_in_turns_have_as_many_samples_each() {
        let order = std::cell::RefCell::new(Vec::new());
        let pause = |who: u8, ms| {
            let order = &order;
            let work = move || {
                std::thread::sleep(Duration::from_millis(ms));
                order.borrow_mut().push(who);
                who
            };
            Box::new(work) as Work<u8>
        };
        let found = in_turns(Duration::ZERO, vec![pause(0, 1), pause(1, 2)]);
        assert!(found.len() == 2 && found[0].1.samples() == found[1].1.samples(), "{found:?}");
        assert_eq!([found[0].0, found[1].0], [0, 1]);
        let order = order.borrow();
        assert!(order[4..].chunks_exact(2).all(|two| two[0] != two[1]), "{order:?}");
        assert!(order[4..].chunks_exact(4).all(|four| four == [0, 1, 1, 0]), "{order:?}");
    }

    #[test]
    fn long_work_takes_few_samples() {
        let (_, timing) = time(Duration::ZERO, || std::thread::sleep(Duration::from_millis(2)));
        assert!(timing.samples() >= 3 && timing.samples() <= 30 && timing.runs == 1, "{timing:?}");
    }
}
