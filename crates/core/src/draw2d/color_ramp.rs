//! Colours that change linearly from pixel to pixel: exact rounding at the cost of one addition for
//! each channel.
//!
//! The exact channel at step k is floor(V(k)) with V(k) = (N + k S) / D, all integers, V in [0.5,
//! 256) (a half was added, so that flooring rounds half up). Here V runs in fixed point with 56
//! fractional bits, each addition off by less than an ulp, so the stored value is at most `slack`
//! below V; `slack` is added at the start, which makes it at most `slack` above. Multiples of 1/D
//! cannot lie strictly between two neighbours, so while slack < 1/D the floor is exact. Where D is
//! too large for that, a value that has just passed an integer is reported as doubtful, and the
//! caller evaluates the exact formula.

use crate::memory::Rgba;

/// Number of fractional bits.
pub(super) const FRACTION_BITS: u32 = 56;

/// Current values of four channels, in 8.56 fixed point, and their increments.
#[derive(Clone, Copy, Debug)]
pub(super) struct ColorRamp {
    value: [u64; 4],
    step: [u64; 4],
    /// Values whose fraction is below this may have been lifted over an integer by the slack.
    doubtful_below: u64,
}

impl ColorRamp {
    /// Creates a ramp from `value` by `step` (modulo 256), each a lower bound within `ulps` of
    /// 2^-56, for at most `steps` steps. The exact values must be multiples of 1/D for a D of at
    /// most `largest_divisor`.
    pub(super) fn new(value: [u64; 4], step: [u64; 4], ulps: u64, steps: u32, largest_divisor: u64) -> Self {
        let slack = ulps * (u64::from(steps) + 1);
        let is_exact = u128::from(slack) * u128::from(largest_divisor) < 1 << FRACTION_BITS;
        ColorRamp {
            value: value.map(|v| v.wrapping_add(slack)),
            step,
            doubtful_below: if is_exact { 0 } else { slack },
        }
    }

    /// Creates the ramp of a line of `n` steps from `from` to `to`, positioned at step `k`, with at
    /// most `steps` steps to go.
    ///
    /// n is below 2^32 and `steps` below 2^16, so it is always exact.
    pub(super) fn along_line(from: Rgba, to: Rgba, n: u64, k: u64, steps: u32) -> Self {
        let Some(divisor) = std::num::NonZeroU64::new(2 * n) else {
            return ColorRamp {
                value: from.map(|c| u64::from(c) << FRACTION_BITS),
                step: [0; 4],
                doubtful_below: 0,
            };
        };
        let d = divisor.get();
        let numerator = |i: usize| {
            let (c0, c1) = (i64::from(from[i]), i64::from(to[i]));
            // At most 511 n: below 2^41, and below 2^25 for n below 2^16.
            ((2 * c0 + 1) * n as i64 + 2 * (c1 - c0) * k as i64) as u64
        };
        let slope = |i: usize| 2 * (i64::from(to[i]) - i64::from(from[i]));
        if n < 1 << 16 {
            // Fewer bits are enough, and one machine division computes them.
            const SHORT_BITS: u32 = 38;
            let rest = FRACTION_BITS - SHORT_BITS;
            let value = std::array::from_fn(|i| ((numerator(i) << SHORT_BITS) / d) << rest);
            let step = std::array::from_fn(|i| {
                ((slope(i) << SHORT_BITS).div_euclid(d as i64) as u64).wrapping_shl(rest)
            });
            ColorRamp::new(value, step, 1 << rest, steps, d)
        } else {
            let value =
                std::array::from_fn(|i| ((u128::from(numerator(i)) << FRACTION_BITS) / u128::from(d)) as u64);
            let step = std::array::from_fn(|i| {
                (i128::from(slope(i)) << FRACTION_BITS).div_euclid(i128::from(d)) as u64
            });
            ColorRamp::new(value, step, 1, steps, d)
        }
    }

    /// Returns the current colour.
    #[inline]
    pub(super) fn color(&self) -> Rgba {
        self.value.map(|v| (v >> FRACTION_BITS) as u8)
    }

    /// Returns whether the current colour must be computed by the exact formula.
    #[inline]
    pub(super) fn is_doubtful(&self) -> bool {
        self.value.iter().any(|v| v & ((1 << FRACTION_BITS) - 1) < self.doubtful_below)
    }

    /// Returns whether channel k of the current colour must be computed by the exact formula.
    #[inline]
    pub(super) fn is_doubtful_in(&self, k: usize) -> bool {
        self.value[k] & ((1 << FRACTION_BITS) - 1) < self.doubtful_below
    }

    /// Returns the ramp `steps` pixels further.
    #[allow(
        clippy::needless_range_loop,
        reason = "adaptors of iterators may not be inlined into wider vectors"
    )]
    #[inline(always)]
    pub(super) fn after(&self, steps: usize) -> Self {
        let mut after = *self;
        for k in 0..4 {
            after.value[k] = self.value[k].wrapping_add(self.step[k].wrapping_mul(steps as u64));
        }
        after
    }

    /// Returns the upper halves of the values and of their increments.
    #[inline(always)]
    pub(super) fn upper_words(&self) -> ([u32; 4], [u32; 4]) {
        let ([r, g, b, a], [dr, dg, db, da]) = (self.value, self.step);
        let upper = [(r >> 32) as u32, (g >> 32) as u32, (b >> 32) as u32, (a >> 32) as u32];
        (upper, [(dr >> 32) as u32, (dg >> 32) as u32, (db >> 32) as u32, (da >> 32) as u32])
    }

    /// Sets channel k to `byte` from here on, never doubtful.
    pub(super) fn hold(&mut self, k: usize, byte: u8) {
        self.value[k] = (u64::from(byte) << FRACTION_BITS) | 1 << (FRACTION_BITS - 1);
        self.step[k] = 0;
    }

    /// Returns whether [`ColorRamp::is_doubtful`] can be true at all.
    pub(super) fn may_be_doubtful(&self) -> bool {
        self.doubtful_below > 0
    }

    /// Advances by one pixel.
    #[inline]
    pub(super) fn step(&mut self) {
        for (v, s) in self.value.iter_mut().zip(self.step) {
            *v = v.wrapping_add(s);
        }
    }
}
