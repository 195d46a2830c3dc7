//! How a source colour meets what is in memory: stored as it is, or composed over it.

use crate::memory::Rgba;

/// The mode of `BLEND`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Blend {
    /// The bytes are stored as they are.
    #[default]
    Replace,
    /// Source over destination, see [`over`].
    Over,
}

/// `source` over `dest`: each channel (s a + d (255 - a) + 127) / 255 in integers, with s = 255 for alpha itself.
///
/// An opaque source gives itself, one of alpha 0 gives `dest`.
#[inline]
pub fn over(source: Rgba, dest: Rgba) -> Rgba {
    let a = u16::from(source[3]);
    let mix = |s: u8, d: u8| ((u16::from(s) * a + u16::from(d) * (255 - a) + 127) / 255) as u8;
    [mix(source[0], dest[0]), mix(source[1], dest[1]), mix(source[2], dest[2]), mix(255, dest[3])]
}

/// What one colour does to every pixel that it meets: decided once a verb, so that inner loops do not ask.
#[derive(Clone, Copy, Debug)]
pub(super) enum Paint {
    /// Stored.
    Store(Rgba),
    /// Composed; neither opaque nor invisible.
    Compose(Rgba),
}

impl Paint {
    /// `None` when nothing can change.
    pub(super) fn new(color: Rgba, blend: Blend) -> Option<Self> {
        match (blend, color[3]) {
            (Blend::Over, 0) => None,
            (Blend::Replace, _) | (Blend::Over, 255) => Some(Paint::Store(color)),
            (Blend::Over, _) => Some(Paint::Compose(color)),
        }
    }

    /// Meets every pixel of a run once.
    #[inline]
    pub(super) fn run(self, pixels: &mut [Rgba]) {
        match self {
            Paint::Store(color) => pixels.fill(color),
            Paint::Compose(color) => pixels.iter_mut().for_each(|p| *p = over(color, *p)),
        }
    }

    /// Meets one pixel.
    #[inline]
    pub(super) fn one(self, pixel: &mut Rgba) {
        *pixel = match self {
            Paint::Store(color) => color,
            Paint::Compose(color) => over(color, *pixel),
        }
    }
}

/// Meets each pixel of `dest` with the source pixel at the same place.
#[inline]
pub(super) fn run_of_many(blend: Blend, source: &[Rgba], dest: &mut [Rgba]) {
    match blend {
        Blend::Replace => dest.copy_from_slice(source),
        Blend::Over => dest.iter_mut().zip(source).for_each(|(d, s)| *d = over(*s, *d)),
    }
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
    fn opaque_stores_and_invisible_does_nothing() {
        assert_eq!(over([1, 2, 3, 255], [9, 8, 7, 6]), [1, 2, 3, 255]);
        assert_eq!(over([1, 2, 3, 0], [9, 8, 7, 6]), [9, 8, 7, 6]);
        assert!(Paint::new([1, 2, 3, 0], Blend::Over).is_none());
        assert!(matches!(Paint::new([0; 4], Blend::Replace), Some(Paint::Store([0, 0, 0, 0]))));
    }
}
