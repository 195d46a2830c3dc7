//! Numerical stability: the hard cases with the promised and the measured results.
//!
//! Each case is drawn by the fast path on every SIMD level of this CPU and on 1, 2, 3 and 16
//! threads, which has to give the same bytes and depths everywhere, and by the plain path; both are
//! held to the reference.

mod extremes;
mod eye;

use super::picture::{Buffers, truth};
use fbptr_core::draw2d::over;
use fbptr_core::executor::ThreadPool;
use fbptr_core::memory::DepthFormat;
use fbptr_core::pipeline::{RenderOptions, RenderPath, Renderer};
use fbptr_core::simd::Level;
use fbptr_server::worker_pool;
use fbptr_truth::compare::{Comparison, compare};
use fbptr_truth::hard_cases;
use fbptr_truth::scenes::Case;
use std::sync::Arc;

/// Result of one hard case.
#[derive(Clone, Debug, PartialEq)]
pub struct HardRow {
    /// Name of the case.
    pub case: String,
    /// Result promised by theory or by the specification.
    pub promise: String,
    /// Measured result.
    pub measured: String,
    /// True if the promise is kept.
    pub passed: bool,
}

/// Runs all hard cases. `progress` is called with the title of each part before it begins.
pub fn hard(progress: &mut dyn FnMut(&str)) -> Vec<HardRow> {
    progress("Hard cases through the pipeline");
    let ways = Ways::new();
    let mut rows: Vec<HardRow> = hard_cases().iter().map(|case| through_the_pipeline(&ways, case)).collect();
    progress("Numbers at the end of f64");
    rows.extend(extremes::rows(&ways));
    progress("Blending, every value at every opacity");
    rows.push(blending_in_2d());
    progress("The eye");
    rows.extend(eye::rows());
    rows
}

/// Threads that every case is drawn on.
const THREADS: [usize; 4] = [1, 2, 3, 16];

/// Renderers of the fast path: every level of this CPU on every number of threads.
pub(super) struct Ways {
    pools: Vec<(usize, Option<Arc<ThreadPool>>)>,
}

impl Ways {
    fn new() -> Ways {
        Ways { pools: THREADS.map(|n| (n, worker_pool(Some(n)))).to_vec() }
    }

    /// Returns the number of ways.
    fn count(&self) -> usize {
        Level::ALL.iter().filter(|l| l.is_available()).count() * self.pools.len()
    }

    /// Draws by every way. Returns the first result and the names of the ways with another one.
    pub(super) fn draw(&self, draw: impl Fn(&mut Renderer) -> Buffers) -> (Buffers, Vec<String>) {
        let mut first: Option<Buffers> = None;
        let mut others = Vec::new();
        for level in Level::ALL.into_iter().filter(|l| l.is_available()) {
            for (threads, pool) in &self.pools {
                let options =
                    RenderOptions { pool: pool.clone(), simd: Some(level), ..RenderOptions::default() };
                let drawn = draw(&mut Renderer::new(options));
                match &first {
                    Some(first) if !first.is_same(&drawn) => {
                        others.push(format!("{} on {threads}", level.as_str()))
                    }
                    Some(_) => {}
                    None => first = Some(drawn),
                }
            }
        }
        (first.expect("the portable level is always there"), others)
    }

    /// Returns the measured part about the ways.
    pub(super) fn described(&self, others: &[String]) -> String {
        match others {
            [] => format!("{} ways alike", self.count()),
            _ => format!("{} of {} ways differ: {}", others.len(), self.count(), others.join(", ")),
        }
    }
}

/// Returns the errors that the specification allows for a case.
fn promise(case: &Case, is_free: bool) -> String {
    if is_free {
        return "any picture of the face or none, the same by every level and number of threads".into();
    }
    let depth = match case.format {
        DepthFormat::F32 => "depth to 2 ulp or 4e-7",
        DepthFormat::Reversed => "depth to 4 ulp of what is stored",
        _ => "depth to 0.501 of a step",
    };
    let textured = case.scene.objects.iter().any(|o| o.texture.is_some());
    format!(
        "0 pixels off in coverage, colour to {}/255, {depth}; the same by every level and number of threads",
        if textured { 2 } else { 1 }
    )
}

fn through_the_pipeline(ways: &Ways, case: &Case) -> HardRow {
    let (fast, others) = ways.draw(|renderer| Buffers::of_case(renderer, case));
    let plain = RenderOptions { path: RenderPath::Plain, ..RenderOptions::default() };
    let plain = Buffers::of_case(&mut Renderer::new(plain), case);
    let exact = truth(case);
    let [fast, plain] = [&fast, &plain].map(|b| compare(&b.memory, b.depth.as_ref(), &exact));
    let is_free = fast.loose == fast.pixels;
    HardRow {
        case: case.name.clone(),
        promise: promise(case, is_free),
        measured: format!("{}; plain path: {}; {}", counts(&fast), short(&plain), ways.described(&others)),
        passed: fast.is_right() && plain.is_right() && others.is_empty(),
    }
}

fn counts(report: &Comparison) -> String {
    let turns = match report.turns {
        0 => String::new(),
        turns => format!("; {turns} of {} pixels may be either way", report.pixels),
    };
    format!(
        "off: coverage {}, colour {}, depth {}; colour to {}/255, depth to {:.2} of its limit{turns}",
        report.coverage_off, report.color_off, report.depth_off, report.max_color, report.max_depth
    )
}

fn short(report: &Comparison) -> String {
    format!(
        "{} off, colour to {}/255",
        report.coverage_off + report.color_off + report.depth_off,
        report.max_color
    )
}

/// Compares compositing over with the nearest whole number, for every value at every opacity over
/// every value.
fn blending_in_2d() -> HardRow {
    let mut off = 0usize;
    for (value, alpha) in (0..=255u8).flat_map(|v| (0..=255u8).map(move |a| (v, a))) {
        for dest in 0..=255u8 {
            let sum = u32::from(value) * u32::from(alpha) + u32::from(dest) * u32::from(255 - alpha);
            // The nearest k to sum / 255: |255 k - sum| <= 127; 255 is odd, so there is no tie.
            let found = over([value, 0, 0, alpha], [dest, 0, 0, 255]);
            off += usize::from((255 * u32::from(found[0])).abs_diff(sum) > 127 || found[3] != 255);
        }
    }
    HardRow {
        case: "source over dest in 2-D, 256 values x 256 opacities x 256 values".into(),
        promise: "the nearest whole number to (s a + d (255 - a)) / 255, and opaque".into(),
        measured: format!("{off} of {} off", 1 << 24),
        passed: off == 0,
    }
}
