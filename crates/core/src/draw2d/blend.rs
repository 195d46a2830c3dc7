//! Blending of a source colour with the frame: stored unchanged, or composited over it.

use crate::memory::{Rgba, over};
use crate::simd::{Kernel, Level, Simd, fill_pixels};

/// Blend mode, set by the `BLEND` command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Blend {
    /// Stores the source bytes unchanged.
    #[default]
    Replace,
    /// Composites the source over the destination, see [`over`].
    Over,
}

/// The effect of one colour on every pixel it is drawn to, decided once for each call so that inner
/// loops do not branch.
#[derive(Clone, Copy, Debug)]
pub(super) enum Paint {
    /// Stores the colour.
    Store(Rgba),
    /// Composites the colour, which is neither opaque nor invisible.
    Compose(Rgba),
}

impl Paint {
    /// Returns `None` if drawing the colour changes nothing.
    pub(super) fn new(color: Rgba, blend: Blend) -> Option<Self> {
        match (blend, color[3]) {
            (Blend::Over, 0) => None,
            (Blend::Replace, _) | (Blend::Over, 255) => Some(Paint::Store(color)),
            (Blend::Over, _) => Some(Paint::Compose(color)),
        }
    }

    /// Draws every pixel of a run once.
    #[inline]
    pub(super) fn run(self, pixels: &mut [Rgba]) {
        match self {
            Paint::Store(color) => fill_pixels(pixels, color),
            Paint::Compose(color) => compose_run(color, pixels),
        }
    }

    /// Draws one pixel.
    #[inline]
    pub(super) fn one(self, pixel: &mut Rgba) {
        *pixel = match self {
            Paint::Store(color) => color,
            Paint::Compose(color) => over(color, *pixel),
        }
    }
}

/// Applies [`over`] to every pixel.
fn compose_run(color: Rgba, pixels: &mut [Rgba]) {
    match pixels.len() < WIDE {
        true => compose_color(color, pixels),
        false => Level::best().dispatch(Composed { source: None, color, dest: pixels }),
    }
}

/// Applies [`over`] to every pixel: terms of the source alone are computed once, four pixels side
/// by side.
#[inline(always)]
fn compose_color(color: Rgba, pixels: &mut [Rgba]) {
    let a = u16::from(color[3]);
    // s a + 127; with d (255 - a) at most 255 * 255 + 127.
    let source: [u16; 16] =
        std::array::from_fn(|i| if i % 4 == 3 { 255 } else { u16::from(color[i % 4]) } * a + 127);
    let mix = |d: &mut u8, s: u16| {
        let v = s + u16::from(*d) * (255 - a);
        *d = div_255(v) as u8;
    };
    let (groups, rest) = pixels.as_flattened_mut().as_chunks_mut::<16>();
    for group in groups {
        for (d, s) in group.iter_mut().zip(source) {
            mix(d, s);
        }
    }
    for (d, s) in rest.iter_mut().zip(source) {
        mix(d, s);
    }
}

/// Draws each source pixel to the pixel of `dest` at the same index. Both slices have the same
/// length.
#[inline]
pub(super) fn run_of_many(blend: Blend, source: &[Rgba], dest: &mut [Rgba]) {
    match blend {
        Blend::Replace => dest.copy_from_slice(source),
        Blend::Over => compose_many(source, dest),
    }
}

/// Applies [`over`] pixel by pixel.
fn compose_many(source: &[Rgba], dest: &mut [Rgba]) {
    if dest.len() >= WIDE {
        return Level::best().dispatch(Composed { source: Some(source), color: [0; 4], dest });
    }
    for (dest, source) in dest.iter_mut().zip(source) {
        *dest = compose(*source, *dest);
    }
}

/// Bytes 0 and 2 of a word.
const EVEN: u32 = 0x00FF_00FF;

/// Applies [`over`], two channels in each half of a word.
#[inline(always)]
pub(super) fn compose(source: Rgba, dest: Rgba) -> Rgba {
    let (s, d) = (u32::from_le_bytes(source), u32::from_le_bytes(dest));
    let (opaque, a) = (s | 0xFF00_0000, s >> 24);
    let even = mix_two(opaque & EVEN, d & EVEN, a);
    let odd = mix_two((opaque >> 8) & EVEN, (d >> 8) & EVEN, a);
    (even | odd << 8).to_le_bytes()
}

/// Mixes bytes 0 and 2 of two words. Both fields stay below 2^16; the division is `div_255`.
#[inline(always)]
fn mix_two(s: u32, d: u32, a: u32) -> u32 {
    let v = s * a + d * (255 - a) + 127 * 0x0001_0001;
    ((v + 0x0001_0001 + ((v >> 8) & EVEN)) >> 8) & EVEN
}

/// Pixels of a run from which the widest vectors pay: their code is called, not inlined.
const WIDE: usize = 16;

/// A run of pixels of one colour or of a source each, composited at a level's width of vectors.
struct Composed<'a> {
    source: Option<&'a [Rgba]>,
    color: Rgba,
    dest: &'a mut [Rgba],
}

impl Kernel for Composed<'_> {
    type Output = ();

    /// Plain loops without closures, which a function of wider vectors would call, not inline.
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        match self.source {
            // Four lanes have no products of 32 bits everywhere.
            None if S::LANES <= 4 => compose_color(self.color, self.dest),
            None => {
                for dest in self.dest {
                    *dest = compose(self.color, *dest);
                }
            }
            Some(source) => {
                for (dest, source) in self.dest.iter_mut().zip(source) {
                    *dest = compose(*source, *dest);
                }
            }
        }
    }
}

/// Returns v / 255 for every v up to 255 * 255 + 127, the largest value that compositing gives.
#[inline]
fn div_255(v: u16) -> u16 {
    (v + 1 + (v >> 8)) >> 8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn over_is_the_formula_for_every_byte() {
        for s in 0..=255u8 {
            for a in 0..=255u8 {
                for d in [0, 1, 2, 127, 128, 200, 254, 255u8] {
                    let want =
                        |s: u8| ((s as u32 * a as u32 + d as u32 * (255 - a as u32) + 127) / 255) as u8;
                    assert_eq!(
                        over([s, d, 255 - s, a], [d; 4]),
                        [want(s), want(d), want(255 - s), want(255)]
                    );
                }
            }
        }
    }

    #[test]
    fn runs_are_their_pixels() {
        let dest: Vec<Rgba> = (0..10_000u32).map(|i| i.wrapping_mul(2_654_435_761).to_le_bytes()).collect();
        for len in (0..40).chain([8191, 8192, 8197, 10_000]) {
            for color in [[1, 2, 3, 255], [7; 4], [255, 0, 77, 1], [255, 255, 255, 254], [9, 200, 31, 128]] {
                for blend in [Blend::Replace, Blend::Over] {
                    let (mut run, mut one) = (dest.clone(), dest.clone());
                    let paint = Paint::new(color, blend).unwrap();
                    paint.run(&mut run[..len]);
                    one[..len].iter_mut().for_each(|p| paint.one(p));
                    assert!(run == one, "{len} {color:?} {blend:?}");
                    let expected = |d: Rgba| if blend == Blend::Over { over(color, d) } else { color };
                    assert!(one.iter().zip(&dest).take(len).all(|(o, d)| *o == expected(*d)));
                }
            }
        }
    }

    #[test]
    fn the_division_by_255_is_exact() {
        assert!((0..=255 * 255 + 127).all(|v| div_255(v) == v / 255));
    }

    #[test]
    fn many_are_composed_as_one_by_one() {
        let mix = |i: u32| i.wrapping_mul(2_654_435_761).to_le_bytes();
        for len in (0..20).chain([1001]) {
            let source: Vec<Rgba> = (0..len).map(mix).collect();
            let mut dest: Vec<Rgba> = (0..len).map(|i| mix(i + 12_345)).collect();
            let want: Vec<Rgba> = source.iter().zip(&dest).map(|(s, d)| over(*s, *d)).collect();
            run_of_many(Blend::Over, &source, &mut dest);
            assert_eq!(dest, want);
        }
    }

    #[test]
    fn opaque_stores_and_invisible_does_nothing() {
        assert_eq!(over([1, 2, 3, 255], [9, 8, 7, 6]), [1, 2, 3, 255]);
        assert_eq!(over([1, 2, 3, 0], [9, 8, 7, 6]), [9, 8, 7, 6]);
        assert!(Paint::new([1, 2, 3, 0], Blend::Over).is_none());
        assert!(matches!(Paint::new([0; 4], Blend::Replace), Some(Paint::Store([0, 0, 0, 0]))));
    }
}
