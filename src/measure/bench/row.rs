//! What was measured of a workload, and how it is written down.

use super::{Air, Check, Workload};
use crate::memory::DepthFormat;

/// The plain loop that a workload is timed beside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twin {
    /// What it is.
    pub name: &'static str,
    /// Its median frame.
    pub median_ms: f64,
    /// Its shortest frame.
    pub min_ms: f64,
}

/// How a workload's time grows with its size.
#[derive(Clone, Debug, PartialEq)]
pub struct ScalingFit {
    /// What grows, a plural.
    pub what: &'static str,
    /// How much of it, and the shortest frame then, ms; the last is the workload itself.
    pub steps: Vec<(f64, f64)>,
    /// b of the line log time = a + b log size that fits best; `None` where the sizes are one.
    pub exponent: Option<f64>,
}

/// What was measured of one workload.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The workload.
    pub workload: Workload,
    /// Threads that drew.
    pub threads: usize,
    /// Vectors that drew.
    pub simd: &'static str,
    /// The median frame.
    pub median_ms: f64,
    /// The shortest frame.
    pub min_ms: f64,
    /// Frames timed.
    pub frames: usize,
    /// How depths were stored, and through what it was seen.
    pub stored: (DepthFormat, Air),
    /// The picture against the truth.
    pub check: Check,
    /// The plain loop timed in turn with it.
    pub twin: Option<Twin>,
    /// How its time grows, where it was measured at several sizes.
    pub scaling: Option<ScalingFit>,
}

impl Row {
    /// One JSON object on one line: the peers' fields first.
    pub fn json(&self) -> String {
        let c = &self.check;
        let mut line = format!(
            "{{\"peer\":\"fbptr\",\"cfg\":\"{}T\",\"wl\":\"{}\",\"med_ms\":{:.3},\"min_ms\":{:.3},\"n\":{},\
             \"simd\":\"{}\",\"depth\":\"{}\",\"fog\":{},\"max_err\":{},\"pixels_off\":{},\"coverage_off\":{},\"max_depth_err\":{:e},\"covered\":{},\"turns\":{}",
            self.threads,
            self.workload.name(),
            self.median_ms,
            self.min_ms,
            self.frames,
            self.simd,
            self.stored.0.as_str(),
            self.stored.1 == Air::Fog,
            c.max_error_steps,
            c.pixels_off,
            c.coverage_off,
            c.max_depth_error,
            c.covered,
            c.turns,
        );
        if let Some(twin) = &self.twin {
            line += &format!(
                ",\"{0}_med_ms\":{1:.3},\"{0}_min_ms\":{2:.3},\"times_{0}\":{3:.3}",
                twin.name,
                twin.median_ms,
                twin.min_ms,
                twin.median_ms / self.median_ms
            );
        }
        if let Some(scaling) = &self.scaling {
            let steps: Vec<String> = scaling.steps.iter().map(|(x, ms)| format!("[{x},{ms:.3}]")).collect();
            line += &format!(",\"{}_min_ms\":[{}]", scaling.what, steps.join(","));
            if let Some(exponent) = scaling.exponent {
                line += &format!(",\"exponent\":{exponent:.3}");
            }
        }
        line + "}"
    }
}
