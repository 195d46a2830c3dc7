//! Comparison of a drawn picture with the reference, by the project's limits.
//!
//! In: video memory, its depth memory, and the reference picture of the same draws. Out: a
//! [`Comparison`]: the number of pixels with errors in coverage, colour and depth, the largest
//! errors, the first faulty pixels.
//!
//! Limits: coverage 0 pixels; colours 1/255, textured 2/255; f32 depth the larger of 2 ulp and
//! 4e-7; u16, u24, u32 0.501 of a step; reversed 4 ulp of the stored value. A pixel is correct if
//! it agrees with one of its accepted results in colour and depth at once.

use super::double_double::DoubleDouble;
use super::picture::{PixelState, StoredDepth, TruthPicture, ulp_f32};
use fbptr_core::memory::{DepthFormat, DepthMemory, VideoMemory};
use std::fmt;

/// Largest accepted colour errors in 1/255 steps, untextured and textured.
pub const COLOR_LIMITS: [u8; 2] = [1, 2];
/// Largest accepted error of integer depths in steps.
pub const STEP_LIMIT: f64 = 0.501;
/// Largest accepted error of f32 depths in ulp.
pub const F32_ULP_LIMIT: f64 = 2.0;
/// Largest accepted error of f32 depths in z, if that is more than [`F32_ULP_LIMIT`].
pub const F32_Z_LIMIT: f64 = 4e-7;
/// Largest accepted error of reversed depths in ulp of the stored value.
pub const REVERSED_ULP_LIMIT: f64 = 4.0;

/// Kind of error at a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fault {
    /// Drawn where nothing may be drawn, or not drawn where something must be.
    Coverage,
    /// The colour matches no accepted result.
    Color,
    /// The stored depth matches no accepted result of this colour.
    Depth,
}

/// Pixel with an error.
#[derive(Clone, Debug, PartialEq)]
pub struct FaultyPixel {
    /// Column of the pixel.
    pub x: u32,
    /// Row of the pixel.
    pub y: u32,
    /// Kind of the error.
    pub fault: Fault,
    /// Bytes found.
    pub found: [u8; 4],
    /// Stored depth found, if depth was compared.
    pub depth: Option<u32>,
    /// Accepted results.
    pub expected: Vec<PixelState>,
}

/// Result of a comparison.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Comparison {
    /// Number of pixels compared.
    pub pixels: usize,
    /// Number of pixels with an error in coverage.
    pub coverage_off: usize,
    /// Number of pixels with an error in colour.
    pub color_off: usize,
    /// Number of pixels with an error in depth.
    pub depth_off: usize,
    /// Largest difference of a byte from its nearest accepted result.
    pub max_color: u8,
    /// Largest depth error as a fraction of its limit (1 = at the limit).
    pub max_depth: f64,
    /// Number of pixels with more than one accepted result.
    pub turns: usize,
    /// Number of pixels where a range of more than 4 steps, or any colour, is accepted.
    pub loose: usize,
    /// First pixels with errors.
    pub faulty_pixels: Vec<FaultyPixel>,
}

/// Largest number of faulty pixels that a comparison describes.
const MAX_FAULTY_PIXELS: usize = 8;

impl Comparison {
    /// Returns whether no pixel has an error.
    pub fn is_right(&self) -> bool {
        self.coverage_off == 0 && self.color_off == 0 && self.depth_off == 0
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} pixels: off in coverage {}, colour {}, depth {}; largest colour error {} steps, depth {:.3} of its \
             limit; {} turns, {} loose",
            self.pixels,
            self.coverage_off,
            self.color_off,
            self.depth_off,
            self.max_color,
            self.max_depth,
            self.turns,
            self.loose
        )?;
        for p in &self.faulty_pixels {
            write!(f, "  ({},{}) {:?}: found {:?}", p.x, p.y, p.fault, p.found)?;
            if let Some(word) = p.depth {
                write!(f, " depth word {word:#010x} ({})", f32::from_bits(word))?;
            }
            for s in p.expected.iter().take(4) {
                write!(f, "; right {:?}..{:?} z {:.9}..{:.9}", s.lo, s.hi, s.z[0].to_f64(), s.z[1].to_f64())?;
                write!(f, " face {:?}", s.drawn)?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

/// Compares a drawn picture with the reference. Without a depth memory only colours are compared.
///
/// # Panics
/// If the pictures differ in size, or the depth formats differ.
pub fn compare(memory: &VideoMemory, depth: Option<&DepthMemory>, truth: &TruthPicture) -> Comparison {
    assert_eq!((memory.width(), memory.height()), (truth.width(), truth.height()), "pictures of one size");
    if let Some(d) = depth {
        assert_eq!((d.width(), d.height()), (truth.width(), truth.height()), "depth of the same size");
        assert_eq!(d.format(), truth.depth_format(), "depth of the same format");
    }
    let mut comparison = Comparison::default();
    for y in 0..truth.height() {
        for x in 0..truth.width() {
            let at = (truth.width() * y + x) as usize;
            let found = std::array::from_fn(|c| memory.bytes()[4 * at + c]);
            let word = depth.map(|d| d.word(at));
            judge(&mut comparison, truth, [x, y], found, word);
        }
    }
    comparison
}

fn judge(
    comparison: &mut Comparison,
    truth: &TruthPicture,
    [x, y]: [u32; 2],
    found: [u8; 4],
    word: Option<u32>,
) {
    let states = truth.states(x, y);
    comparison.pixels += 1;
    comparison.turns += usize::from(states.len() > 1);
    let is_wide = |s: &PixelState| (0..3).any(|c| s.hi[c] - s.lo[c] > 4);
    let free = truth.is_free(x, y);
    comparison.loose += usize::from(free || states.iter().any(is_wide));
    if free {
        return;
    }
    let Nearest { color, depth, color_fails, depth_fails, .. } = nearest(truth, [x, y], found, word);
    if !color_fails && !depth_fails {
        comparison.max_color = comparison.max_color.max(color);
        comparison.max_depth = comparison.max_depth.max(depth);
        return;
    }
    let untouched = |s: &PixelState| s.drawn.is_none();
    let all_drawn = !states.iter().any(untouched);
    let none_drawn = states.iter().all(untouched);
    let looks_cleared = found == [0, 0, 0, 255] || found[3] != 255;
    let fault = if color_fails && (none_drawn || (all_drawn && looks_cleared)) {
        comparison.coverage_off += 1;
        Fault::Coverage
    } else if color_fails {
        comparison.color_off += 1;
        comparison.max_color = comparison.max_color.max(color);
        Fault::Color
    } else {
        comparison.depth_off += 1;
        comparison.max_depth = comparison.max_depth.max(depth);
        Fault::Depth
    };
    if comparison.faulty_pixels.len() < MAX_FAULTY_PIXELS {
        comparison.faulty_pixels.push(FaultyPixel {
            x,
            y,
            fault,
            found,
            depth: word,
            expected: states.to_vec(),
        });
    }
}

/// Distance of a pixel from its nearest accepted result: one that it agrees with if there is any,
/// else the closest in colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Largest difference of a byte, in 1/255 steps.
    pub color: u8,
    /// Depth error as a fraction of its limit; 0 if depth is not compared.
    pub depth: f64,
    /// Depth error in z.
    pub depth_z: f64,
    /// True if the colour exceeds its limit.
    pub color_fails: bool,
    /// True if the depth exceeds its limit.
    pub depth_fails: bool,
}

/// Compares one pixel with its accepted results, even if the pixel is unconstrained.
///
/// # Panics
/// If the pixel is off the picture.
pub fn nearest(truth: &TruthPicture, [x, y]: [u32; 2], found: [u8; 4], word: Option<u32>) -> Nearest {
    let format = truth.depth_format();
    let measured = truth.states(x, y).iter().map(|s| {
        let color = color_distance(s, found);
        let depth = word.map_or(0.0, |w| depth_use_of_limit(format, s, w));
        let depth_z = word.map_or(0.0, |w| {
            let z = DoubleDouble::new(format.decode(w));
            (s.z[0] - z).max(z - s.z[1]).max(DoubleDouble::ZERO).to_f64()
        });
        let color_fails = color > COLOR_LIMITS[usize::from(s.is_textured)];
        Nearest { color, depth, depth_z, color_fails, depth_fails: depth > 1.0 }
    });
    let best = measured.min_by(|a, b| {
        let key = |n: &Nearest| (n.color_fails, n.depth_fails, n.color);
        key(a).cmp(&key(b)).then(a.depth.total_cmp(&b.depth))
    });
    best.expect("a pixel has at least one right answer")
}

/// Returns the RGBA bytes of the accepted results nearest to a picture's: the reference for other
/// measures.
///
/// # Panics
/// If the pictures differ in size.
pub fn nearest_bytes(truth: &TruthPicture, found: &[u8]) -> Vec<u8> {
    let pixels = truth.width() as usize * truth.height() as usize;
    assert_eq!(found.len(), 4 * pixels, "pictures of one size");
    let answer = |(i, found): (usize, &[u8; 4])| {
        let [x, y] = [i as u32 % truth.width(), i as u32 / truth.width()];
        let best = truth.states(x, y).iter().min_by_key(|s| color_distance(s, *found));
        let s = best.expect("a pixel has at least one right answer");
        let [r, g, b] = [0, 1, 2].map(|c| found[c].clamp(s.lo[c], s.hi[c]));
        [r, g, b, 255]
    };
    found.as_chunks().0.iter().enumerate().flat_map(answer).collect()
}

/// Returns the distance of a pixel's bytes from the nearest accepted result, in 1/255 steps;
/// `index` is width * y + x.
///
/// # Panics
/// If the pixel is off the picture.
pub fn color_error(truth: &TruthPicture, index: usize, found: [u8; 4]) -> u8 {
    let [x, y] = [index as u32 % truth.width(), index as u32 / truth.width()];
    if truth.is_free(x, y) {
        return 0;
    }
    truth.states(x, y).iter().map(|s| color_distance(s, found)).min().unwrap_or(0)
}

/// Returns the largest distance of a byte from a result's range; a drawn pixel's alpha is 255.
fn color_distance(s: &PixelState, found: [u8; 4]) -> u8 {
    if s.drawn.is_some() && found[3] != 255 {
        return 255;
    }
    (0..3).map(|c| s.lo[c].saturating_sub(found[c]).max(found[c].saturating_sub(s.hi[c]))).max().unwrap_or(0)
}

/// Returns the error of a stored depth as a fraction of its limit: at most 1 if it is accepted.
pub fn depth_use_of_limit(format: DepthFormat, s: &PixelState, word: u32) -> f64 {
    let distance_beyond = |v: DoubleDouble, lo: DoubleDouble, hi: DoubleDouble| {
        (lo - v).max(v - hi).max(DoubleDouble::ZERO).to_f64()
    };
    let one = DoubleDouble::ONE;
    match format.steps() {
        Some(steps) => {
            let scaled = s.z.map(|z| z * DoubleDouble::new(steps));
            distance_beyond(DoubleDouble::new(word as f64), scaled[0], scaled[1]) / STEP_LIMIT
        }
        None if format == DepthFormat::Reversed => {
            let stored = f32::from_bits(!word) as f64;
            let off = distance_beyond(DoubleDouble::new(stored), one - s.z[1], one - s.z[0]);
            let ulp = ulp_f32(stored.max((one - s.z[1]).to_f64()));
            off / (REVERSED_ULP_LIMIT * ulp)
        }
        None => {
            let off = distance_beyond(DoubleDouble::new(f32::from_bits(word) as f64), s.z[0], s.z[1]);
            off / (F32_ULP_LIMIT * ulp_f32(s.z[1].to_f64())).max(F32_Z_LIMIT)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Settings, TruthPicture};

    #[test]
    fn a_cleared_memory_agrees_and_a_stray_pixel_is_coverage() {
        let truth = TruthPicture::new(4, 3, DepthFormat::U16);
        let mut memory = VideoMemory::new(4, 3).unwrap();
        let mut depth = DepthMemory::new(4, 3, DepthFormat::U16);
        let comparison = compare(&memory, Some(&depth), &truth);
        assert!(comparison.is_right() && comparison.pixels == 12, "{comparison}");
        memory.put_pixel(1, 2, [9, 0, 0, 255]);
        depth.set_word(0, 65_534);
        let comparison = compare(&memory, Some(&depth), &truth);
        assert_eq!((comparison.coverage_off, comparison.color_off, comparison.depth_off), (1, 0, 1));
        assert!(comparison.to_string().contains("(1,2) Coverage"));
    }

    #[test]
    fn a_step_more_than_the_limit_is_off() {
        let scene = crate::scenes::lit_triangle();
        let truth = crate::render(&scene, 16, 16, DepthFormat::F32, &Settings::default()).unwrap();
        let mut memory = VideoMemory::new(16, 16).unwrap();
        memory.bytes_mut().copy_from_slice(&truth.bytes());
        let exact = compare(&memory, None, &truth);
        assert!(exact.is_right() && exact.max_color == 0, "{exact}");
        for (change, right) in [(1, true), (2, false)] {
            let mut off = memory.clone();
            off.bytes_mut().chunks_exact_mut(4).filter(|p| p[0] > 9).for_each(|p| p[0] -= change);
            assert_eq!(compare(&off, None, &truth).is_right(), right);
        }
    }
}
