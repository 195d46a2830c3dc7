//! Rows of colours that change linearly, composited sixteen pixels at a time.
//!
//! In: a ramp that is exact by itself (never doubtful) and the pixels of a row. Out: the pixels with the
//! ramp's colours over them, as [`ColorRamp::color`] and [`ColorRamp::step`] give them one by one, which the tests
//! compare. A block is computed from the upper 32 bits of its first value and of the step, whose sum
//! is at most 16 units below that of all 64 bits; where so little more would change a channel, the
//! block is computed pixel by pixel.

use super::blend::compose;
use super::color_ramp::ColorRamp;
use crate::memory::Rgba;
use crate::simd::{Kernel, Level, Simd};

/// Pixels of a block.
const BLOCK: usize = 16;
/// More than a value of a block may be too low, in units of its lowest bit.
const MISSING: u32 = BLOCK as u32 + 1;

/// Composites the colours of a ramp that is never doubtful over a row.
#[inline]
pub(super) fn compose_ramp(ramp: ColorRamp, row: &mut [Rgba]) {
    Level::best().dispatch(RampRow { ramp, row });
}

struct RampRow<'a> {
    ramp: ColorRamp,
    row: &'a mut [Rgba],
}

impl Kernel for RampRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        compose_blocks(self.ramp, self.row);
    }
}

/// Composites a row in blocks: plain loops without closures, which a function of wider vectors would call,
/// not inline.
#[allow(clippy::needless_range_loop, reason = "adaptors of iterators may not be inlined into wider vectors")]
#[inline(always)]
fn compose_blocks(mut ramp: ColorRamp, row: &mut [Rgba]) {
    let step = ramp.upper_words().1;
    let mut steps = [[0; BLOCK]; 4];
    for k in 0..4 {
        for i in 0..BLOCK {
            steps[k][i] = step[k].wrapping_mul(i as u32);
        }
    }
    let (blocks, rest) = row.as_chunks_mut::<BLOCK>();
    for block in blocks {
        let colors = colors_of_block(&ramp, &steps);
        for i in 0..BLOCK {
            block[i] = compose(colors[i].to_le_bytes(), block[i]);
        }
        ramp = ramp.after(BLOCK);
    }
    if !rest.is_empty() {
        let colors = colors_of_block(&ramp, &steps);
        for (pixel, color) in rest.iter_mut().zip(colors) {
            *pixel = compose(color.to_le_bytes(), *pixel);
        }
    }
}

/// Computes a block's colours from upper words, or pixel by pixel if they are not certain.
#[allow(clippy::needless_range_loop, reason = "adaptors of iterators may not be inlined into wider vectors")]
#[inline(always)]
fn colors_of_block(ramp: &ColorRamp, steps: &[[u32; BLOCK]; 4]) -> [u32; BLOCK] {
    let [r0, g0, b0, a0] = ramp.upper_words().0;
    let (mut colors, mut changes) = ([0; BLOCK], 0);
    for i in 0..BLOCK {
        let (r, g) = (r0.wrapping_add(steps[0][i]), g0.wrapping_add(steps[1][i]));
        let (b, a) = (b0.wrapping_add(steps[2][i]), a0.wrapping_add(steps[3][i]));
        changes |= r ^ r.wrapping_add(MISSING) | g ^ g.wrapping_add(MISSING);
        changes |= b ^ b.wrapping_add(MISSING) | a ^ a.wrapping_add(MISSING);
        colors[i] = r >> 24 | g >> 24 << 8 | b >> 24 << 16 | a & 0xff00_0000;
    }
    if changes >> 24 == 0 { colors } else { one_by_one(*ramp) }
}

#[cold]
#[inline(never)]
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
                let ramp = ColorRamp::new(value, step, 0, 0, 1);
                let [mut blocks, mut plain] = [(); 2].map(|()| vec![dest; len]);
                compose_ramp(ramp, &mut blocks);
                let mut pixel_ramp = ramp;
                for pixel in &mut plain {
                    *pixel = crate::draw2d::over(pixel_ramp.color(), *pixel);
                    pixel_ramp.step();
                }
                prop_assert_eq!(blocks, plain);
            }
        }
    }
}
