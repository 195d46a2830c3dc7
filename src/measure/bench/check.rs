//! How far a workload's picture is from the truth, and how far it may be.

use super::Workload;
use crate::memory::DepthMemory;
use crate::truth::compare::{COLOR_LIMITS, F32_Z_LIMIT};
use std::fmt;

/// Of a seam's pixels some have their centre up to 1/256 pixel outside of the face that covers them. Clamped to the face, as
/// the plain path has it, or extrapolated, as the tile renderer does, their depths are both right: one pixel in this many
/// may differ by more than f32 does.
const FEW: usize = 20;
/// What 1/256 pixel is worth on the steepest face of these workloads.
const OUTSIDE_Z_LIMIT: f64 = 1e-3;

/// A picture held to the truth, all pixels of it.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Check {
    /// The largest difference of a channel, in 1/255 steps.
    pub max_error_steps: u8,
    /// Pixels with some channel off by more than one step.
    pub pixels_off: usize,
    /// Pixels drawn where the truth draws none, or the other way about.
    pub coverage_off: usize,
    /// The largest difference in z.
    pub max_depth_error: f64,
    /// Pixels whose depth is further off than f32 depths may be.
    pub depths_off: usize,
    /// Pixels that the truth draws.
    pub covered: usize,
}

impl Check {
    /// Compares RGBA bytes of one size; coverage is what differs from `background`.
    pub(super) fn of_bytes(found: &[u8], truth: &[u8], background: [u8; 4]) -> Check {
        let mut check = Check::default();
        if found.len() != truth.len() {
            check.coverage_off = found.len().max(truth.len()) / 4;
            return check;
        }
        for (f, t) in found.as_chunks::<4>().0.iter().zip(truth.as_chunks::<4>().0) {
            let off = (0..4).map(|c| f[c].abs_diff(t[c])).max().unwrap_or(0);
            check.max_error_steps = check.max_error_steps.max(off);
            check.pixels_off += usize::from(off > 1);
            check.coverage_off += usize::from((*f == background) != (*t == background));
            check.covered += usize::from(*t != background);
        }
        check
    }

    /// Compares depths too, which say better what was drawn: a colour may be the background's.
    pub(super) fn with_depth(mut self, found: &DepthMemory, truth: &DepthMemory) -> Check {
        (self.coverage_off, self.covered) = (0, 0);
        let (width, height) = (truth.width(), truth.height());
        if (found.width(), found.height(), found.format()) != (width, height, truth.format()) {
            self.coverage_off = width as usize * height as usize;
            return self;
        }
        for index in 0..width as usize * height as usize {
            let [f, t] = [found, truth].map(|d| d.format().decode(d.word(index)));
            self.max_depth_error = self.max_depth_error.max((f - t).abs());
            self.depths_off += usize::from((f - t).abs() > F32_Z_LIMIT);
            self.coverage_off += usize::from((f < 1.0) != (t < 1.0));
            self.covered += usize::from(t < 1.0);
        }
        self
    }

    /// Whether the picture is good enough to be timed; else what is wrong.
    pub(super) fn within(&self, workload: Workload) -> Result<(), String> {
        let [plain, textured] = COLOR_LIMITS;
        let limit = match workload {
            Workload::Textured(_) => textured,
            // Whole numbers decide these: nothing may differ.
            Workload::LinesLong | Workload::LinesShort | Workload::PutPixel => 0,
            _ => plain,
        };
        if self.covered == 0 {
            return Err("the truth is empty: there is nothing to hold the picture to".into());
        }
        if self.coverage_off > 0 {
            return Err(format!("{} pixels are off in coverage, 0 allowed", self.coverage_off));
        }
        if self.max_error_steps > limit {
            let found = self.max_error_steps;
            return Err(format!("a colour is {found}/255 from the truth, {limit}/255 allowed"));
        }
        if self.depths_off * FEW > self.covered || self.max_depth_error > OUTSIDE_Z_LIMIT {
            let (off, found) = (self.depths_off, self.max_depth_error);
            return Err(format!(
                "a depth is {found:e} from the truth, {OUTSIDE_Z_LIMIT:e} allowed, and {off} are over {F32_Z_LIMIT:e}, 1 in \
                 {FEW} allowed"
            ));
        }
        Ok(())
    }
}

/// Why there is no time to tell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// The workload.
    pub workload: Workload,
    /// What is wrong with its picture.
    pub reason: String,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: no time, {}", self.workload.name(), self.reason)
    }
}

impl std::error::Error for Refusal {}
