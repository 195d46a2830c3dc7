//! Benchmark workloads W1 to W7 and S1 to S7, each compared with a reference before it is timed.
//!
//! In: a [`Workload`], a [`Size`] and drawing options. Out: a [`Row`] of times, or a [`Refusal`] if
//! the picture exceeds its error bound: then no time is reported.
//!
//! A frame is everything that a program would do: colour and depth are cleared, the whole scene is
//! drawn, and the result is in video memory. After the timing the memory is overwritten and one
//! more frame is drawn, which must equal the first one byte for byte: so no timed frame can have
//! skipped work.
//!
//! W1 to W5 are a torus knot or 20 layers through [`Renderer`](fbptr_core::pipeline::Renderer). Their
//! reference is the plain f64 path at all pixels, and the reference renderer (`truth`) where the
//! plain path has only one of several accepted results. W6 and W7 are lines and pixels; their
//! reference is the simplest loop, which is timed, too. S1 to S7 are other scenes with the
//! reference of W1; most of them grow, and each step is checked and timed. Built-in models are
//! workloads by their names, held to the same reference. Workloads in two dimensions are
//! [`PlaneWork`]s: streams through the engine.

mod check;
mod cores;
mod export;
mod flat;
mod frame;
mod plane;
mod row;
mod scenes;
mod space;
mod workload;

pub use check::{Check, Refusal};
pub use cores::{CoresRow, run_on_cores};
pub use export::{ExportedFile, export};
pub use plane::{PlaneOptions, PlaneRow, PlaneWork, plane_stream, plane_truth, run_plane};
pub use row::{Row, ScalingFit, Twin};
pub use workload::Workload;

use super::clock::Timing;
use super::frame_times::FrameTimes;
use super::scaling::{Scaling, ScalingPoint};
use fbptr_core::memory::{DepthFormat, VideoMemory};
use fbptr_core::pipeline::RenderOptions;
use fbptr_core::scene::{Fog, FogKind};
use glam::DVec3;
use std::time::{Duration, Instant};

/// Amount of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Width of the frame in pixels.
    pub width: u32,
    /// Height of the frame in pixels.
    pub height: u32,
    /// Divisor of the numbers of faces, lines and pixels in the workload's name.
    pub divisor: u32,
}

impl Size {
    /// Size that all compared programs draw.
    pub const FULL: Size = Size { width: 1920, height: 1080, divisor: 1 };
}

/// Medium between the eye and the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Air {
    /// No fog.
    #[default]
    Clear,
    /// Grey fog that leaves at least half of the colour at the scene's centre.
    Fog,
}

impl Air {
    /// Returns the fog for a scene.
    fn fog(self) -> Option<Fog> {
        let fog = Fog { color: DVec3::splat(0.6), kind: FogKind::Linear, visibility_range: 12.0 };
        (self == Air::Fog).then_some(fog)
    }
}

/// Drawing options and number of frames.
#[derive(Clone, Debug)]
pub struct BenchOptions {
    /// Threads and vector width.
    pub render: RenderOptions,
    /// Format of stored depths; W6 and W7 have none.
    pub depth_format: DepthFormat,
    /// Medium between the eye and the scene.
    pub air: Air,
    /// Amount of work.
    pub size: Size,
    /// Largest number of timed frames.
    pub frames: usize,
    /// Time after which no further frame is started, once 3 frames have been timed.
    pub budget: Duration,
}

/// Workload prepared for drawing.
trait BenchRun {
    /// Draws one whole frame.
    fn frame(&mut self);
    /// Returns the frame's RGBA bytes.
    fn bytes(&self) -> &[u8];
    /// Overwrites all buffers with values that no frame produces.
    fn spoil(&mut self);
    /// Draws the reference picture.
    fn truth(&mut self) -> VideoMemory;
    /// Compares the last frame with the reference.
    fn check(&mut self) -> Check;
    /// Returns the name of the simplest loop, if there is one.
    fn twin(&self) -> Option<&'static str> {
        None
    }
    /// Draws the frame by the simplest loop, into another buffer.
    fn twin_frame(&mut self) {}
    /// Returns the current size of whatever grows.
    fn amount(&self) -> f64 {
        1.0
    }
    /// Returns the number of threads that draw.
    fn threads(&self) -> usize;
    /// Returns the name of the vector width that is used.
    fn simd(&self) -> &'static str;
}

fn run_of(workload: Workload, options: &BenchOptions) -> Box<dyn BenchRun> {
    let last = scenes::steps(workload).and_then(|(_, steps)| steps.last().copied());
    match workload {
        Workload::Room
        | Workload::Layers64
        | Workload::Objects10k
        | Workload::Scene10k
        | Workload::Mesh4M
        | Workload::Sizes
        | Workload::Lights
        | Workload::Model(_)
        | Workload::Hidden => Box::new(scenes::Scenes::new(workload, options, last.unwrap_or(1))),
        Workload::LinesLong | Workload::LinesShort => Box::new(flat::Lines::run_of(workload, options)),
        Workload::PutPixel => Box::new(flat::Pixels::run_of(options)),
        _ => Box::new(space::Space::new(workload, options)),
    }
}

/// Checks a workload, then times it.
///
/// # Errors
/// If its picture exceeds its error bound, or a later frame differs from the first.
pub fn run(workload: Workload, options: &BenchOptions) -> Result<Row, Refusal> {
    let Some((what, steps)) = scenes::steps(workload) else {
        return measure(workload, &mut *run_of(workload, options), options);
    };
    let own = BenchOptions { budget: options.budget / steps.len() as u32, ..options.clone() };
    let mut rows = Vec::with_capacity(steps.len());
    for &step in steps {
        let mut run_of = scenes::Scenes::new(workload, options, step);
        let row = measure(workload, &mut run_of, &own)?;
        rows.push((run_of.amount(), row));
    }
    let points = rows.iter().map(|(x, row)| ScalingPoint {
        x: *x,
        timing: Some(Timing::single(row.min_ms)),
        peak_bytes: None,
    });
    let scaling = Scaling { title: String::new(), grows: what, at_most: None, points: points.collect() };
    let steps = rows.iter().map(|(x, row)| (*x, row.min_ms)).collect();
    let scaling = Some(ScalingFit { what, steps, exponent: scaling.exponent() });
    let (_, last) = rows.pop().expect("a workload that grows has steps");
    Ok(Row { scaling, ..last })
}

/// Draws the reference picture of a workload, with which other programs' pictures are compared.
pub fn truth_picture(workload: Workload, options: &BenchOptions) -> VideoMemory {
    run_of(workload, options).truth()
}

/// Number of untimed frames before the measurement of short frames.
const WARM_UP_FRAMES: usize = 5;
/// Duration below which a first frame counts as short.
const SHORT_FRAME: Duration = Duration::from_millis(300);

fn measure(workload: Workload, run_of: &mut dyn BenchRun, options: &BenchOptions) -> Result<Row, Refusal> {
    let refuse = |reason: String| Refusal { workload, reason };
    run_of.spoil();
    let (first_time, _) = timed(|| run_of.frame());
    let check = run_of.check();
    check.within(workload).map_err(refuse)?;
    let first = run_of.bytes().to_vec();
    if first_time < SHORT_FRAME {
        (0..WARM_UP_FRAMES).for_each(|_| run_of.frame());
    }
    let begin = Instant::now();
    let (mut times, mut twin_times) = (FrameTimes::default(), FrameTimes::default());
    while times.len() < options.frames.max(1) && (times.len() < 3 || begin.elapsed() < options.budget) {
        times.push(timed(|| run_of.frame()).0);
        if run_of.twin().is_some() {
            twin_times.push(timed(|| run_of.twin_frame()).0);
        }
    }
    run_of.spoil();
    run_of.frame();
    if run_of.bytes() != first {
        return Err(refuse(
            "a later frame differs from the first: what was timed is not what was checked".into(),
        ));
    }
    let [min_ms, median_ms, p99_ms] = times.percentiles_ms([0, 50, 99]);
    let twin = run_of.twin().map(|name| {
        let [min_ms, median_ms] = twin_times.percentiles_ms([0, 50]);
        Twin { name, median_ms, min_ms }
    });
    let (threads, simd) = (run_of.threads(), run_of.simd());
    let (frames, stored) = (times.len(), (options.depth_format, options.air));
    Ok(Row { workload, threads, simd, median_ms, min_ms, p99_ms, frames, stored, check, twin, scaling: None })
}

fn timed<T>(work: impl FnOnce() -> T) -> (Duration, T) {
    let start = Instant::now();
    let output = work();
    (start.elapsed(), output)
}

/// Random number generator of all compared programs: xorshift of 32 bits.
#[derive(Clone, Copy, Debug)]
struct Xorshift(u32);

impl Xorshift {
    fn new() -> Self {
        Xorshift(0x1234_5678)
    }

    #[inline(always)]
    fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }
}

#[cfg(test)]
mod tests;
