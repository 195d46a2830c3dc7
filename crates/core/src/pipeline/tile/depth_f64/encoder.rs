//! Encoding of depths in f64 to the words of a depth format, lane by lane, equal to
//! [`DepthFormat::encode`].

use crate::memory::DepthFormat;
use crate::simd::Simd;

/// Encoder of a depth format.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthEncoder {
    /// Factor from depth to words; unused for the reversed format.
    scale: f64,
    /// True if depth is 1 - z and words are the inverted bits of its f32.
    pub is_reversed: bool,
    /// Bits that turn words into signed numbers of equal order.
    flip: i32,
}

impl DepthEncoder {
    /// Returns the encoder of a format; `None` for f32, which has its own kernels.
    pub fn of(format: DepthFormat) -> Option<DepthEncoder> {
        let fixed = |scale, flip| Some(DepthEncoder { scale, is_reversed: false, flip });
        match format {
            DepthFormat::U16 => fixed(65_535.0, 0),
            DepthFormat::U24 => fixed(16_777_215.0, 0),
            DepthFormat::U32 => fixed(4_294_967_295.0, i32::MIN),
            DepthFormat::Reversed => Some(DepthEncoder { scale: 0.0, is_reversed: true, flip: 0 }),
            DepthFormat::F32 => None,
        }
    }

    /// Returns the word of a depth in 0..=1, equal to [`DepthFormat::encode`].
    #[inline(always)]
    pub(super) fn word(&self, depth: f64) -> i32 {
        if self.is_reversed { !(depth as f32).to_bits() as i32 } else { fixed(depth, self.scale) }
    }

    /// Returns the words of depths in 0..=1.
    #[inline(always)]
    pub(super) fn words<S: Simd>(&self, s: S, depths: &[f64; 16]) -> S::I {
        let mut words = [0i32; 16];
        if self.is_reversed {
            for i in 0..S::LANES {
                words[i] = !(depths[i] as f32).to_bits() as i32;
            }
        } else {
            for i in 0..S::LANES {
                words[i] = fixed(depths[i], self.scale);
            }
        }
        s.load_i(&words[..S::LANES])
    }

    /// Returns the bits to invert so that words become signed numbers of equal order.
    #[inline(always)]
    pub(super) fn flip(&self) -> i32 {
        self.flip
    }
}

/// Returns floor(scale * depth + 1/2), without a conversion that checks its range.
#[inline(always)]
fn fixed(depth: f64, scale: f64) -> i32 {
    // Adding 2^52 rounds to an integer, which is then in the low bits.
    const WHOLE: f64 = 4_503_599_627_370_496.0;
    let t = depth * scale + 0.5;
    let r = t + WHOLE;
    (r.to_bits() as u32).wrapping_sub((r - WHOLE > t) as u32) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_those_that_the_memory_encodes() {
        for format in DepthFormat::ALL {
            let Some(encoder) = DepthEncoder::of(format) else { continue };
            let mut words = Vec::new();
            for i in 0..=20_000 {
                // Ties of every format are among them.
                let z = match i % 3 {
                    0 => i as f64 / 20_000.0,
                    1 => (i as f64 + 0.5) / 65_535.0,
                    _ => 1.0 - (i as f64) * 2f64.powi(-40),
                };
                let depth = if encoder.is_reversed { 1.0 - z } else { z };
                let word = encoder.word(depth);
                assert_eq!(word as u32, format.encode(z, depth), "{format:?} of {z}");
                words.push((z, word ^ encoder.flip));
            }
            words.sort_by(|a, b| a.0.total_cmp(&b.0));
            assert!(words.is_sorted_by_key(|w| w.1), "{format:?}: nearer words are smaller");
        }
    }
}
