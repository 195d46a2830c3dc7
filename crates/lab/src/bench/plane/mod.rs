//! Benchmark workloads in two dimensions: a stream of figures through the engine, as programs send it.
//!
//! In: a [`PlaneWork`], a size, threads. Out: a [`PlaneRow`] of times, or what is wrong with the picture:
//! then no time is reported. The picture is compared with that of the figures' definitions, evaluated
//! pixel by pixel in whole numbers (`truth`): equal bytes, and at most 1/255 off for anti-aliased lines.
//!
//! A frame is the whole stream, its parsing included, over a cleared memory; clearing is not timed.
//! After the timing one more frame is drawn, which must equal the first one. The copy speed beside it is
//! that of copying a frame of the same size.

mod figures;
mod truth;

pub use figures::PlaneWork;

use super::{FrameTimes, Size, timed};
use fbptr_core::memory::VideoMemory;
use fbptr_core::pipeline::{RenderOptions, Renderer};
use fbptr_engine::{Audience, Budget, Engine, Output, Stream, StreamState};
use std::time::{Duration, Instant};

/// Size of the frame and number of frames.
#[derive(Clone, Debug)]
pub struct PlaneOptions {
    /// Threads.
    pub render: RenderOptions,
    /// Amount of work.
    pub size: Size,
    /// Largest number of timed frames.
    pub frames: usize,
    /// Time after which no further frame is started, once 3 frames have been timed.
    pub budget: Duration,
}

/// Result of a workload in two dimensions.
#[derive(Clone, Debug)]
pub struct PlaneRow {
    /// The workload.
    pub work: PlaneWork,
    /// Number of threads.
    pub threads: usize,
    /// Number of figures.
    pub figures: usize,
    /// Pixels drawn, each as often as a figure drew it.
    pub pixels: u64,
    /// Number of timed frames.
    pub frames: usize,
    /// Median frame in milliseconds.
    pub median_ms: f64,
    /// Shortest frame in milliseconds.
    pub min_ms: f64,
    /// Median time of copying a frame, in milliseconds a megapixel.
    pub copy_ms_per_megapixel: f64,
    /// Largest difference from the truth, in 1/255.
    pub max_error_steps: u8,
}

impl PlaneRow {
    /// Returns nanoseconds a figure, of the median frame.
    pub fn ns_per_figure(&self) -> f64 {
        self.median_ms * 1e6 / self.figures.max(1) as f64
    }

    /// Returns nanoseconds a pixel, of the median frame.
    pub fn ns_per_pixel(&self) -> f64 {
        self.median_ms * 1e6 / self.pixels.max(1) as f64
    }

    /// Returns the share of the copy speed: the time of copying as many pixels over that of drawing them.
    pub fn copy_share(&self) -> f64 {
        self.copy_ms_per_megapixel / self.ns_per_pixel()
    }

    /// Formats one JSON object, without a line break.
    pub fn json(&self) -> String {
        format!(
            "{{\"peer\":\"fbptr\",\"cfg\":\"{}T\",\"wl\":\"{}\",\"med_ms\":{:.4},\"min_ms\":{:.4},\"frames\":{},\
             \"figures\":{},\"pixels\":{},\"ns_per_figure\":{:.2},\"ns_per_pixel\":{:.4},\"copy_share\":{:.4},\
             \"max_error\":{}}}",
            self.threads,
            self.work.name(),
            self.median_ms,
            self.min_ms,
            self.frames,
            self.figures,
            self.pixels,
            self.ns_per_figure(),
            self.ns_per_pixel(),
            self.copy_share(),
            self.max_error_steps,
        )
    }
}

/// Returns the stream of a workload's figures, for other programs.
pub fn plane_stream(work: PlaneWork, size: Size) -> Vec<u8> {
    figures::stream(work, &work.figures(size))
}

/// Draws a workload's figures by their definitions. Returns the picture and the number of pixels drawn.
pub fn plane_truth(work: PlaneWork, size: Size) -> (VideoMemory, u64) {
    let memory = VideoMemory::new(size.width, size.height).expect("the size of a benchmark's frame");
    let mut plain = truth::Plain::new(memory, work.is_over());
    work.figures(size).iter().for_each(|figure| plain.draw(figure));
    (plain.memory, plain.pixels)
}

/// An engine with the stream that it draws.
struct Drawing {
    engine: Engine,
    stream: Vec<u8>,
}

impl Drawing {
    fn new(work: PlaneWork, options: &PlaneOptions) -> Result<Self, String> {
        let mut engine =
            Engine::new(options.size.width, options.size.height).map_err(|fault| fault.message)?;
        engine.set_renderer(Renderer::new(options.render.clone()));
        Ok(Drawing { engine, stream: plane_stream(work, options.size) })
    }

    /// Clears the memory and draws all figures. Returns the time of the figures.
    fn frame(&mut self) -> Result<Duration, String> {
        self.engine.memory_mut().clear(VideoMemory::CLEAR);
        let mut stream = Stream::new(&self.engine, 1, Audience::Owner);
        let mut out = Output::default();
        let (time, (used, state)) =
            timed(|| stream.feed(&mut self.engine, &self.stream, &mut out, Budget::NONE));
        match (used == self.stream.len(), state, out.notices.as_slice(), out.replies.as_slice()) {
            (true, StreamState::Ready, [], []) => Ok(time),
            (_, state, notices, replies) => {
                Err(format!("the stream ends in {state:?}: {notices:?} {}", replies.escape_ascii()))
            }
        }
    }
}

/// Returns the largest difference of two pictures' bytes.
fn largest_difference(a: &[u8], b: &[u8]) -> u8 {
    a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

/// Holds a workload to its truth, which [`plane_truth`] returns, then times it.
///
/// # Errors
/// A line that says how the picture, or a later one, is wrong.
pub fn run_plane(
    work: PlaneWork,
    options: &PlaneOptions,
    (truth, pixels): &(VideoMemory, u64),
) -> Result<PlaneRow, String> {
    let mut drawing = Drawing::new(work, options)?;
    drawing.frame()?;
    let first = drawing.engine.memory().bytes().to_vec();
    let max_error_steps = largest_difference(&first, truth.bytes());
    let allowed = u8::from(matches!(work, PlaneWork::SmoothLines | PlaneWork::LargeLineSmooth));
    if max_error_steps > allowed {
        return Err(format!("{max_error_steps}/255 from the truth, {allowed}/255 allowed"));
    }
    let begin = Instant::now();
    let (mut times, mut copies) = (FrameTimes::default(), FrameTimes::default());
    let mut copy = vec![0; first.len()];
    while times.len() < options.frames.max(1) && (times.len() < 3 || begin.elapsed() < options.budget) {
        times.push(drawing.frame()?);
        copies.push(timed(|| copy.copy_from_slice(std::hint::black_box(&first))).0);
        std::hint::black_box(&copy);
    }
    if drawing.engine.memory().bytes() != first {
        return Err("a later frame differs from the first".to_owned());
    }
    let [min_ms, median_ms] = times.percentiles_ms([0, 50]);
    let [copy_ms] = copies.percentiles_ms([50]);
    Ok(PlaneRow {
        work,
        threads: options.render.pool.as_ref().map_or(1, |pool| pool.current_num_threads()),
        figures: work.figures(options.size).len(),
        pixels: *pixels,
        frames: times.len(),
        median_ms,
        min_ms,
        copy_ms_per_megapixel: copy_ms * 4e6 / first.len() as f64,
        max_error_steps,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn small() -> PlaneOptions {
        let size = Size { width: 300, height: 200, divisor: 40 };
        PlaneOptions { render: RenderOptions::default(), size, frames: 2, budget: Duration::from_millis(20) }
    }

    #[test]
    fn every_workload_equals_its_definition_and_is_timed() {
        for work in PlaneWork::ALL {
            let truth = plane_truth(work, small().size);
            let row = run_plane(work, &small(), &truth).unwrap_or_else(|e| panic!("{}: {e}", work.name()));
            assert!(row.frames >= 2 && row.min_ms > 0.0 && row.pixels > 100, "{row:?}");
            let json: serde_json::Value = serde_json::from_str(&row.json()).expect("one object");
            assert_eq!(json["wl"], work.name());
            assert!(json["ns_per_pixel"].as_f64() > Some(0.0) && json["copy_share"].as_f64() > Some(0.0));
            assert_eq!(PlaneWork::named(work.name()), [work]);
        }
        assert_eq!(PlaneWork::named("2D").len(), PlaneWork::ALL.len());
        assert!(PlaneWork::named("2d_").is_empty());
    }

    #[test]
    fn a_wrong_picture_has_no_time() {
        let (mut memory, pixels) = plane_truth(PlaneWork::Discs, small().size);
        let at = memory.bytes().iter().position(|v| *v > 3).expect("something is drawn");
        memory.bytes_mut()[at] -= 1;
        let refused = run_plane(PlaneWork::Discs, &small(), &(memory, pixels)).unwrap_err();
        assert_eq!(refused, "1/255 from the truth, 0/255 allowed");
    }
}
