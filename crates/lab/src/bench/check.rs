//! Comparison of a workload's picture with the reference at every pixel, by the specification's
//! limits.

use super::Workload;
use super::frame::BACKGROUND;
use fbptr_core::memory::{DepthFormat, DepthMemory, VideoMemory};
use fbptr_truth::TruthPicture;
use fbptr_truth::compare::{COLOR_LIMITS, F32_Z_LIMIT, nearest};
use std::fmt;

/// If more than one pixel in this many differs from the plain path, the cause is not borderline
/// edges, and the reference is not consulted.
const MANY: usize = 4;

/// Result of comparing all pixels of a picture with the reference.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Check {
    /// Largest difference of a channel, in steps of 1/255.
    pub max_error_steps: u8,
    /// Number of pixels with a channel difference of more than one step.
    pub pixels_off: usize,
    /// Number of pixels that only one of picture and reference draws.
    pub coverage_off: usize,
    /// Largest difference in z.
    pub max_depth_error: f64,
    /// Number of pixels whose depth error exceeds the limit of its format.
    pub depths_off: usize,
    /// Number of pixels that the reference draws.
    pub covered: usize,
    /// Number of pixels that differ from the plain path and that the reference accepts: their
    /// centre lies outside the true face, faces tie in depth, or a texture discontinuity is near.
    pub turns: usize,
}

/// Picture with its depths.
#[derive(Clone, Copy)]
pub(super) struct Drawn<'a> {
    pub memory: &'a VideoMemory,
    pub depth: &'a DepthMemory,
}

impl Drawn<'_> {
    fn color(&self, index: usize) -> [u8; 4] {
        self.memory.bytes().as_chunks().0[index]
    }
}

impl Check {
    /// Compares RGBA bytes of one size; pixels that differ from `background` are covered.
    pub(super) fn of_bytes(found: &[u8], truth: &[u8], background: [u8; 4]) -> Check {
        let mut check = Check::default();
        if found.len() != truth.len() {
            check.coverage_off = found.len().max(truth.len()) / 4;
            return check;
        }
        for (f, t) in found.as_chunks::<4>().0.iter().zip(truth.as_chunks::<4>().0) {
            check.add(distance(*f, *t), 0.0, false);
            check.coverage_off += usize::from((*f == background) != (*t == background));
            check.covered += usize::from(*t != background);
        }
        check
    }

    /// Compares colours and depths of a 3-D picture with the plain path's, pixel by pixel, by the
    /// workload's limits. Coverage is decided by depth: a colour may equal the background's. Pixels
    /// with larger differences are decided by the reference (`ask` renders the given pixels), which
    /// has all accepted results: the extrapolated and the clamped one if a centre lies outside the
    /// true face, and only one nearly everywhere else.
    pub(super) fn of_space(
        found: Drawn,
        plain: Drawn,
        limit: u8,
        ask: impl FnOnce(&[[u32; 2]]) -> TruthPicture,
    ) -> Check {
        let mut check = Check::default();
        let (width, height) = (plain.memory.width(), plain.memory.height());
        let pixels = width as usize * height as usize;
        let size = |d: &Drawn| {
            (d.memory.width(), d.memory.height(), d.depth.width(), d.depth.height(), d.depth.format())
        };
        if size(&found) != size(&plain) {
            check.coverage_off = pixels;
            return check;
        }
        let mut suspects = Vec::new();
        for index in 0..pixels {
            let off = distance(found.color(index), plain.color(index));
            let [f, t] = [found, plain].map(|d| d.depth.format().decode(d.depth.word(index)));
            let z_off = (f - t).abs();
            let words = [found, plain].map(|d| d.depth.word(index));
            let is_near = is_near(plain.depth.format(), words, z_off);
            check.coverage_off += usize::from((f < 1.0) != (t < 1.0));
            // Transparent faces write no depth.
            check.covered += usize::from(t < 1.0 || plain.color(index) != BACKGROUND);
            if off <= limit && is_near {
                check.add(off, z_off, false);
            } else {
                suspects.push((index, off, z_off, !is_near));
            }
        }
        if suspects.len() * MANY > check.covered {
            suspects.iter().for_each(|&(_, off, z_off, is_off)| check.add(off, z_off, is_off));
            return check;
        }
        let places: Vec<[u32; 2]> =
            suspects.iter().map(|s| [s.0 as u32 % width, s.0 as u32 / width]).collect();
        if places.is_empty() {
            return check;
        }
        let truth = ask(&places);
        for (&place, &(index, off, z_off, is_off)) in places.iter().zip(&suspects) {
            if truth.is_free(place[0], place[1]) {
                check.add(off, z_off, is_off);
                continue;
            }
            let n = nearest(&truth, place, found.color(index), Some(found.depth.word(index)));
            check.turns += usize::from(!n.color_fails && !n.depth_fails);
            check.add(n.color, n.depth_z, n.depth_fails);
        }
        check
    }

    /// Adds a pixel with these errors.
    fn add(&mut self, steps: u8, z: f64, is_depth_off: bool) {
        self.max_error_steps = self.max_error_steps.max(steps);
        self.pixels_off += usize::from(steps > 1);
        self.max_depth_error = self.max_depth_error.max(z);
        self.depths_off += usize::from(is_depth_off);
    }

    /// Checks that the picture is good enough to be timed; the error describes the reason.
    pub(super) fn within(&self, workload: Workload) -> Result<(), String> {
        let limit = limit_steps(workload);
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
        if self.depths_off > 0 {
            let (off, found) = (self.depths_off, self.max_depth_error);
            return Err(format!(
                "a depth is {found:e} from the truth, and {off} are further than their format allows"
            ));
        }
        Ok(())
    }
}

/// Returns the largest accepted colour error of a workload, in steps of 1/255.
pub(super) fn limit_steps(workload: Workload) -> u8 {
    let [plain, textured] = COLOR_LIMITS;
    match workload {
        Workload::Textured(_) | Workload::Room | Workload::Objects10k | Workload::Scene10k => textured,
        // Integer arithmetic decides these: no difference is accepted.
        Workload::LinesLong | Workload::LinesShort | Workload::PutPixel => 0,
        _ => plain,
    }
}

/// Returns whether a stored depth is close enough to the plain path's without consulting the
/// reference: integer formats have one accepted word nearly everywhere.
fn is_near(format: DepthFormat, [found, plain]: [u32; 2], z_off: f64) -> bool {
    match format {
        DepthFormat::U16 | DepthFormat::U24 | DepthFormat::U32 => found == plain,
        DepthFormat::F32 => z_off <= F32_Z_LIMIT,
        DepthFormat::Reversed => found.abs_diff(plain) <= REVERSED_ULPS,
    }
}

/// Largest accepted error of reversed depths, in units in the last place.
const REVERSED_ULPS: u32 = 4;

/// Returns the largest difference of a channel.
fn distance(a: [u8; 4], b: [u8; 4]) -> u8 {
    (0..4).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0)
}

/// Error of a workload whose time is not reported.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// The workload.
    pub workload: Workload,
    /// Error found in its picture.
    pub reason: String,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: no time, {}", self.workload.name(), self.reason)
    }
}

impl std::error::Error for Refusal {}
