//! Rows of colours that change linearly, sixteen pixels at a time.
//!
//! In: a ramp that is exact by itself (never doubtful) and the pixels of a row. Out: the pixels stored
//! or composited, as [`ColorRamp::color`] and [`ColorRamp::step`] give them one by one, which the tests
//! compare. A block is computed from the upper 32 bits of its first value and of the step, whose sum
//! is at most 16 units below that of all 64 bits; where so little more would change a channel, the
//! block is computed pixel by pixel.

use super::Blend;
use super::blend::compose;
use super::color_ramp::ColorRamp;
use crate::memory::Rgba;
use crate::simd::{Kernel, Level, Simd};

/// Pixels of a block.
const BLOCK: usize = 16;
/// More than a value of a block may be too low, in units of its lowest bit.
const MISSING: u32 = BLOCK as u32 + 1;

/// Paints a row by a ramp that is never doubtful.
#[inline]
pub(super) fn paint_ramp(ramp: ColorRamp, row: &mut [Rgba], blend: Blend) {
    let kernel = RampRow { ramp, row, blend };
    match kernel.row.len() < BLOCK {
        true => kernel.plain(),
        false => Level::best().dispatch(kernel),
    }
}

struct RampRow<'a> {
    ramp: ColorRamp,
    row: &'a mut [Rgba],
    blend: Blend,
}

impl RampRow<'_> {
    /// Paints pixel by pixel.
    #[inline]
    fn plain(mut self) {
        for pixel in self.row {
            let color = self.ramp.color();
            *pixel = if self.blend == Blend::Replace { color } else { compose(color, *pixel) };
            self.ramp.step();
        }
    }
}

impl Kernel for RampRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let RampRow { mut ramp, row, blend } = self;
        let (_, step) = ramp.upper_words();
        let steps: [[u32; BLOCK]; 4] = step.map(|step| std::array::from_fn(|i| step.wrapping_mul(i as u32)));
        let (blocks, rest) = row.as_chunks_mut::<BLOCK>();
        for block in blocks {
            let mut colors = [0u32; BLOCK];
            if !colors_of_block(&ramp, &steps, &mut colors) {
                colors = one_by_one(ramp);
            }
            for (pixel, color) in block.iter_mut().zip(colors) {
                let color = color.to_le_bytes();
                *pixel = if blend == Blend::Replace { color } else { compose(color, *pixel) };
            }
            ramp = ramp.after(BLOCK);
        }
        RampRow { ramp, row: rest, blend }.plain();
    }
}

/// Computes a block from upper words. Returns whether its colours are certain.
#[inline(always)]
fn colors_of_block(ramp: &ColorRamp, steps: &[[u32; BLOCK]; 4], colors: &mut [u32; BLOCK]) -> bool {
    let (first, _) = ramp.upper_words();
    let mut changes = 0;
    for i in 0..BLOCK {
        let channel = |k: usize| first[k].wrapping_add(steps[k][i]);
        let [r, g, b, a] = [channel(0), channel(1), channel(2), channel(3)];
        let change = |v: u32| v ^ v.wrapping_add(MISSING);
        changes |= change(r) | change(g) | change(b) | change(a);
        colors[i] = r >> 24 | g >> 24 << 8 | b >> 24 << 16 | a & 0xff00_0000;
    }
    changes >> 24 == 0
}

#[cold]
fn one_by_one(mut ramp: ColorRamp) -> [u32; BLOCK] {
    std::array::from_fn(|_| {
        let color = u32::from_le_bytes(ramp.color());
        ramp.step();
        color
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn rows_are_their_pixels(
            value: [u64; 4], step: [u64; 4], small in 0..64u32, dest: [u8; 4], len in 0..100usize,
        ) {
            // Values just below a carry, and steps of any size.
            let near_carry = value.map(|v| v | 0x00ff_ffff_0000_0000);
            for value in [value, near_carry, [255 << 56 | 1 << 55; 4]] {
                let step = step.map(|s| (s as i64 >> small) as u64);
                for blend in [Blend::Replace, Blend::Over] {
                    let ramp = ColorRamp::new(value, step, 0, 0, 1);
                    let [mut blocks, mut plain] = [(); 2].map(|()| vec![dest; len]);
                    paint_ramp(ramp, &mut blocks, blend);
                    let mut pixel_ramp = ramp;
                    for pixel in &mut plain {
                        let color = pixel_ramp.color();
                        *pixel = if blend == Blend::Replace { color } else { crate::draw2d::over(color, *pixel) };
                        pixel_ramp.step();
                    }
                    prop_assert_eq!(blocks, plain);
                }
            }
        }
    }
}
