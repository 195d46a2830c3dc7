//! Results of a workload, and their JSON.

use super::{Air, Check, Workload};
use fbptr_core::memory::DepthFormat;

/// Result of the simplest loop that draws the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twin {
    /// Name of the loop.
    pub name: &'static str,
    /// Median frame in milliseconds.
    pub median_ms: f64,
    /// Shortest frame in milliseconds.
    pub min_ms: f64,
}

/// Growth of a workload's time with its size.
#[derive(Clone, Debug, PartialEq)]
pub struct ScalingFit {
    /// Plural name of whatever grows.
    pub what: &'static str,
    /// Sizes with the shortest frame in milliseconds; the last one is the workload itself.
    pub steps: Vec<(f64, f64)>,
    /// Slope b of the best fit log time = a + b log size; `None` if all sizes are equal.
    pub exponent: Option<f64>,
}

/// Result of one workload.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Measured workload.
    pub workload: Workload,
    /// Number of threads that drew.
    pub threads: usize,
    /// Name of the vector width that was used.
    pub simd: &'static str,
    /// Median frame in milliseconds.
    pub median_ms: f64,
    /// Shortest frame in milliseconds.
    pub min_ms: f64,
    /// 99th percentile of the frames in milliseconds.
    pub p99_ms: f64,
    /// Number of timed frames.
    pub frames: usize,
    /// Format of stored depths, and medium.
    pub stored: (DepthFormat, Air),
    /// Comparison of the picture with the reference.
    pub check: Check,
    /// Result of the simplest loop, timed alternately with the workload.
    pub twin: Option<Twin>,
    /// Growth of its time, if it was measured at several sizes.
    pub scaling: Option<ScalingFit>,
}

impl Row {
    /// Returns one JSON object on one line: first the fields that all compared programs report.
    pub fn json(&self) -> String {
        let c = &self.check;
        let mut line = format!(
            "{{\"peer\":\"fbptr\",\"cfg\":\"{}T\",\"wl\":\"{}\",\"med_ms\":{:.3},\"min_ms\":{:.3},\"n\":{},\
             \"p99_ms\":{:.3},\"simd\":\"{}\",\"depth\":\"{}\",\"fog\":{},\"max_err\":{},\"pixels_off\":{},\"coverage_off\":{},\"max_depth_err\":{:e},\"covered\":{},\"turns\":{}",
            self.threads,
            self.workload.name(),
            self.median_ms,
            self.min_ms,
            self.frames,
            self.p99_ms,
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
