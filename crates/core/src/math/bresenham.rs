//! Bresenham's midpoint line as a function of the step: the one definition for 2-D and 3-D lines.
//!
//! In: two ends in whole pixels. Out: the pixel at each step, and the steps inside a rectangle. At
//! step k of n along the major axis a line has made floor((2 k m + n - 1) / 2 n) = ceil(k m / n -
//! 1/2) of its m steps along the minor one, so a tie stays on the major axis in the direction of
//! travel. Everything is computed from k, so clipping costs two divisions and no loop.
//!
//! Verified by the test, which walks lines in all octants with the midpoint variable.

use super::coverage::PixelRect;
use std::ops::Range;

/// Number of steps below which 64 bits are enough: 2 n t, with t at most n + 1, stays below 2^62.
const MODEST: u64 = 1 << 30;

/// One coordinate along a line: from `start`, in the direction of `sign`.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    start: i64,
    /// -1 or 1.
    pub sign: i64,
    /// Number of steps from end to end.
    pub steps: u64,
}

/// Line between two pixels, both included.
#[derive(Clone, Copy, Debug)]
pub struct BresenhamLine {
    /// Axis of the longer extent, which changes at every step; x if both are equal.
    pub major: Axis,
    /// The other axis.
    pub minor: Axis,
    /// True if x is the major axis.
    pub is_x_major: bool,
}

impl Axis {
    fn new(a: i64, b: i64) -> Self {
        Axis { start: a, sign: if b < a { -1 } else { 1 }, steps: a.abs_diff(b) }
    }

    /// Returns the half-open range of this axis' own steps that lie in `low..high`.
    #[inline]
    fn steps_within(self, low: i64, high: i64) -> Range<i64> {
        let range = match self.sign {
            1 => low - self.start..high - self.start,
            _ => self.start - (high - 1)..self.start - low + 1,
        };
        range.start.max(0)..range.end.min(self.steps as i64 + 1)
    }

    /// Returns the coordinate after so many steps.
    #[inline]
    pub fn at(self, steps: u64) -> i64 {
        self.start + self.sign * steps as i64
    }
}

impl BresenhamLine {
    /// Creates the line between two pixels, each coordinate within 2^32 of 0.
    #[inline]
    pub fn new(p0: [i64; 2], p1: [i64; 2]) -> Self {
        let (x, y) = (Axis::new(p0[0], p1[0]), Axis::new(p0[1], p1[1]));
        let is_x_major = x.steps >= y.steps;
        let (major, minor) = if is_x_major { (x, y) } else { (y, x) };
        BresenhamLine { major, minor, is_x_major }
    }

    /// Returns the steps whose major coordinate is inside a rectangle.
    #[inline]
    pub fn steps_along(&self, rect: PixelRect) -> Range<u64> {
        let (low, high) = if self.is_x_major { (rect.x0, rect.x1) } else { (rect.y0, rect.y1) };
        let along = self.major.steps_within(low.into(), high.into());
        along.start as u64..along.end.max(along.start) as u64
    }

    /// Returns the steps whose pixel is inside a rectangle; `None` if there are none.
    #[inline]
    pub fn steps_inside(&self, rect: PixelRect) -> Option<Range<u64>> {
        let (low, high) = if self.is_x_major { (rect.y0, rect.y1) } else { (rect.x0, rect.x1) };
        let (along, across) = (self.steps_along(rect), self.minor.steps_within(low.into(), high.into()));
        if along.is_empty() || across.is_empty() {
            return None;
        }
        let (mut first, mut end) = (along.start, along.end);
        if across.start > 0 {
            first = first.max(self.step_that_reaches(across.start));
        }
        if across.end <= self.minor.steps as i64 {
            end = end.min(self.step_that_reaches(across.end));
        }
        (first < end).then_some(first..end)
    }

    /// Returns the least k at which the minor coordinate has made t > 0 of its m steps: ceil((2 n t
    /// - n + 1) / 2 m).
    #[inline]
    fn step_that_reaches(&self, t: i64) -> u64 {
        let (n, m) = (self.major.steps, self.minor.steps);
        if n < MODEST {
            // t and n are at least 1, so the numerator is positive.
            (2 * n * t as u64 - n + 1).div_ceil(2 * m)
        } else {
            let numerator = 2 * i128::from(n) * i128::from(t) - i128::from(n) + 1;
            let quotient = numerator.div_euclid(2 * i128::from(m));
            let k = quotient + i128::from(numerator.rem_euclid(2 * i128::from(m)) != 0);
            u64::try_from(k).unwrap_or(u64::MAX)
        }
    }

    /// Divides 2 k m + n - 1 by 2 n: returns the minor steps made at step k, and the remainder.
    #[inline]
    pub fn minor_at(&self, k: u64) -> (u64, u64) {
        let (n, m) = (self.major.steps, self.minor.steps);
        if k == 0 {
            (0, n.saturating_sub(1))
        } else if n < MODEST {
            let numerator = 2 * k * m + n - 1;
            (numerator / (2 * n), numerator % (2 * n))
        } else {
            let numerator = 2 * u128::from(k) * u128::from(m) + u128::from(n) - 1;
            let divisor = 2 * u128::from(n);
            ((numerator / divisor) as u64, (numerator % divisor) as u64)
        }
    }

    /// Returns the pixel (x, y) at step k.
    #[inline]
    pub fn at(&self, k: u64) -> [i64; 2] {
        let (major, minor) = (self.major.at(k), self.minor.at(self.minor_at(k).0));
        if self.is_x_major { [major, minor] } else { [minor, major] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Walks a line with the midpoint variable, updated step by step.
    fn walked(a: [i64; 2], b: [i64; 2]) -> Vec<[i64; 2]> {
        let (dx, dy) = ((b[0] - a[0]).abs(), (b[1] - a[1]).abs());
        let s = [(b[0] - a[0]).signum(), (b[1] - a[1]).signum()];
        let (n, m, i) = if dx >= dy { (dx, dy, 0) } else { (dy, dx, 1) };
        let (mut p, mut d, mut out) = (a, 2 * m - n, vec![a]);
        for _ in 0..n {
            p[i] += s[i];
            if d > 0 {
                p[1 - i] += s[1 - i];
                d -= 2 * n;
            }
            d += 2 * m;
            out.push(p);
        }
        out
    }

    #[test]
    fn steps_are_bresenhams_in_all_octants() {
        let clip = PixelRect { x0: -100, y0: -100, x1: 100, y1: 100 };
        for (x, y) in (-7..=7).flat_map(|x| (-7..=7).map(move |y| (x, y))) {
            let (a, b) = ([2, -1], [2 + x, -1 + y]);
            let line = BresenhamLine::new(a, b);
            let found: Vec<_> = line.steps_along(clip).map(|k| line.at(k)).collect();
            assert_eq!(found, walked(a, b), "{x} {y}");
        }
        let far = BresenhamLine::new([-4_000_000_000, 0], [4_000_000_000, 50]);
        assert_eq!(far.steps_along(PixelRect { x0: 0, y0: 0, x1: 10, y1: 60 }).count(), 10);
        assert_eq!(far.at(4_000_000_000), [0, 25]);
    }

    #[test]
    fn the_steps_inside_are_those_of_the_pixels_inside() {
        let rect = PixelRect { x0: -2, y0: 1, x1: 4, y1: 6 };
        let is_inside = |[x, y]: [i64; 2]| (-2..4).contains(&x) && (1..6).contains(&y);
        for (a, b) in (0..900).map(|i| ([i % 10 - 5, i / 10 % 9 - 1], [i * 7 % 13 - 6, i * 11 % 17 - 5])) {
            let line = BresenhamLine::new(a, b);
            let found = line.steps_inside(rect).unwrap_or(0..0);
            let wanted = walked(a, b).iter().map(|p| is_inside(*p)).collect::<Vec<_>>();
            let is_found = (0..wanted.len() as u64).map(|k| found.contains(&k));
            assert!(wanted.iter().copied().eq(is_found), "{a:?} {b:?}: {found:?}");
        }
        let above = BresenhamLine::new([0, -3], [5, -3]);
        assert_eq!((above.steps_inside(rect), above.steps_along(rect)), (None, 0..4));
    }
}
