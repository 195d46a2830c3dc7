//! Frame times on more cores than a machine has, by simulation.
//!
//! In: a workload. Out: its frame time on 1, 2, 4 ... cores, from the time of each piece of its work on
//! one core ([`trace`]) in the order in which the threads would take the pieces ([`schedule`]). One
//! would know that it is right by measuring: the time on as many cores as this machine has is measured
//! in alternation with the pieces, and printed beside the simulated one.

mod schedule;
mod trace;

use super::{BenchOptions, BenchRun, Refusal, Workload, run_of, timed};
use crate::frame_times::FrameTimes;
use fbptr_core::executor::{Executor, ThreadPool};
use fbptr_engine::workers::DRAW_STACK_BYTES;
use schedule::{ThreadCosts, frame_time};
use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};
use trace::{PieceRecorder, Step};

/// Frame times of a workload by the number of cores.
#[derive(Clone, Debug, PartialEq)]
pub struct CoresRow {
    /// The workload.
    pub workload: Workload,
    /// Number of cores, and the simulated milliseconds of the median frame.
    pub simulated_ms: Vec<(usize, f64)>,
    /// Number of threads of the measurement, and its median frame in milliseconds; `None` on one core.
    pub measured_ms: Option<(usize, f64)>,
    /// Share of the frame on one core that runs on one thread whatever the number of cores.
    pub serial_share: f64,
    /// Microseconds until a sleeping thread has begun to work.
    pub wake_us: f64,
}

impl CoresRow {
    /// Returns one JSON object on one line.
    pub fn json(&self) -> String {
        let simulated: Vec<String> =
            self.simulated_ms.iter().map(|(cores, ms)| format!("[{cores},{ms:.3}]")).collect();
        let measured = self.measured_ms.map_or("null".into(), |(threads, ms)| format!("[{threads},{ms:.3}]"));
        format!(
            "{{\"wl\":\"{}\",\"simulated_ms\":[{}],\"measured_ms\":{measured},\"serial_share\":{:.4},\"wake_us\":{:.1}}}",
            self.workload.name(),
            simulated.join(","),
            self.serial_share,
            self.wake_us,
        )
    }
}

impl fmt::Display for CoresRow {
    /// Writes one line: milliseconds by cores, then what was measured.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:<18}", self.workload.name())?;
        for (cores, ms) in &self.simulated_ms {
            write!(f, "  {cores}: {ms:.3} ms")?;
        }
        if let Some((threads, ms)) = self.measured_ms {
            write!(f, "; measured on {threads}: {ms:.3} ms")?;
        }
        write!(f, "; {:.1} % on one thread; {:.0} us to wake one", self.serial_share * 100.0, self.wake_us)
    }
}

/// Time for which rayon's threads look for work before they sleep, about: 32 rounds of yielding.
const AWAKE: Duration = Duration::from_micros(30);
/// Taking work from another thread: some cache lines that move between two cores.
const STEAL: Duration = Duration::from_nanos(500);

/// Simulates a workload on these numbers of cores.
///
/// # Errors
/// If its picture exceeds its error bound.
pub fn run_on_cores(
    workload: Workload,
    options: &BenchOptions,
    cores: &[usize],
) -> Result<CoresRow, Refusal> {
    let refuse = |reason: String| Refusal { workload, reason };
    let (mut pieces, recorder) = recorded_run(workload, options).map_err(refuse)?;
    let mut whole = run_of(workload, options);
    for run in [&mut pieces, &mut whole] {
        run.spoil();
        run.frame();
        run.check().within(workload).map_err(refuse)?;
        (0..3).for_each(|_| run.frame());
    }
    let wake = options.render.pool.as_ref().map_or(0.0, wake_time);
    let costs = ThreadCosts { wake, awake: AWAKE.as_secs_f64(), steal: STEAL.as_secs_f64() };
    let (mut frames, mut measured) = (Vec::new(), FrameTimes::default());
    let begin = Instant::now();
    while frames.len() < options.frames.max(1) && (frames.len() < 3 || begin.elapsed() < 2 * options.budget) {
        recorder.begin();
        pieces.frame();
        frames.push(recorder.end());
        // The threads of the second one are awake.
        whole.frame();
        measured.push(timed(|| whole.frame()).0);
    }
    let threads = whole.threads();
    let [median] = measured.percentiles_ms([50]);
    let on = |cores: usize| median_of(frames.iter().map(|steps| frame_time(steps, cores, &costs)));
    Ok(CoresRow {
        workload,
        simulated_ms: cores.iter().map(|&cores| (cores, on(cores) * 1e3)).collect(),
        measured_ms: (threads > 1).then_some((threads, median)),
        serial_share: median_of(frames.iter().map(|steps| serial_share(steps))),
        wake_us: wake * 1e6,
    })
}

/// Returns the workload on a pool of one thread, and the recorder of its frames' steps.
fn recorded_run(
    workload: Workload,
    options: &BenchOptions,
) -> Result<(Box<dyn BenchRun>, Arc<PieceRecorder>), String> {
    let recorder = Arc::new(PieceRecorder::new());
    let mut one = options.clone();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).stack_size(DRAW_STACK_BYTES).build();
    one.render.pool = Some(Arc::new(pool.map_err(|e| e.to_string())?));
    one.render.observer = Some(recorder.clone());
    Ok((run_of(workload, &one), recorder))
}

fn serial_share(steps: &[Step]) -> f64 {
    let sum = |step: &Step| match step {
        Step::Serial(took) => [*took, 0.0],
        Step::Pieces(pieces) if pieces.len() < 2 => [pieces.iter().sum(), 0.0],
        Step::Pieces(pieces) => [0.0, pieces.iter().sum()],
    };
    let [serial, shared] =
        steps.iter().map(sum).fold([0.0, 0.0], |[a, b], [serial, shared]| [a + serial, b + shared]);
    serial / (serial + shared)
}

fn median_of(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Returns the time until a sleeping thread of the pool has begun a piece, in seconds: what two equal
/// pieces take longer together than one of them, after a pause in which the threads fall asleep.
fn wake_time(pool: &Arc<ThreadPool>) -> f64 {
    const PIECE: Duration = Duration::from_micros(400);
    let executor = Executor::of_pool(Some(pool.clone()));
    let spin = |_: usize, _: &mut [u8]| {
        let begin = Instant::now();
        while begin.elapsed() < PIECE {
            std::hint::spin_loop();
        }
    };
    median_of((0..41).map(|_| {
        std::thread::sleep(Duration::from_millis(2));
        // Like a frame, it is submitted to a thread of the pool that is awake by then.
        executor.run(|| {
            spin(0, &mut []);
            let (took, ()) = timed(|| executor.chunks(&mut [0; 2], 1, spin));
            took.saturating_sub(PIECE).as_secs_f64()
        })
    }))
}

#[cfg(test)]
mod tests {
    use super::super::{Air, Size};
    use super::*;
    use fbptr_core::memory::DepthFormat;
    use fbptr_core::pipeline::RenderOptions;

    fn small() -> BenchOptions {
        BenchOptions {
            render: RenderOptions { pool: fbptr_engine::worker_pool(Some(2)), ..RenderOptions::default() },
            depth_format: DepthFormat::F32,
            air: Air::Clear,
            size: Size { width: 320, height: 180, divisor: 100 },
            frames: 3,
            budget: Duration::from_secs(1),
        }
    }

    /// Returns the steps of a frame after its first.
    fn steps(workload: Workload) -> Vec<Step> {
        let (mut run, recorder) = recorded_run(workload, &small()).unwrap();
        run.frame();
        recorder.begin();
        run.frame();
        recorder.end()
    }

    #[test]
    fn a_frame_is_simulated_from_its_own_pieces() {
        let steps = steps(Workload::Phong70k);
        let free = ThreadCosts { wake: 0.0, awake: 0.0, steal: 0.0 };
        let [one, two, most] = [1, 2, 64].map(|cores| frame_time(&steps, cores, &free));
        assert!(two < one && most <= two, "{one} {two} {most}");
        // Amdahl's law.
        let serial = serial_share(&steps);
        assert!(serial > 0.0 && most >= one * serial * (1.0 - 1e-9), "{serial} of {one}, {most}");
    }

    #[test]
    fn a_row_has_all_cores_and_what_was_measured() {
        let row = run_on_cores(Workload::Phong70k, &small(), &[1, 2, 64]).expect("the right picture");
        assert_eq!(row.simulated_ms.iter().map(|(cores, _)| *cores).collect::<Vec<_>>(), [1, 2, 64]);
        assert!(row.simulated_ms.iter().all(|(_, ms)| *ms > 0.0), "{row:?}");
        assert!(row.serial_share > 0.0 && row.serial_share < 1.0, "{row:?}");
        assert!(row.measured_ms.is_some_and(|(threads, ms)| threads == 2 && ms > 0.0));
    }

    #[test]
    fn small_draws_have_the_pieces_that_two_threads_share() {
        for workload in [Workload::Objects10k, Workload::Scene10k] {
            let steps = steps(workload);
            let is_shared = |step: &Step| matches!(step, Step::Pieces(pieces) if pieces.len() > 1);
            assert!(steps.iter().any(is_shared), "{workload:?}: {steps:?}");
        }
    }
}
