//! Scan-out in vectors: R, G, B, A bytes to 0x00RRGGBB words.

use super::{I32, Kernel, Level, Simd};

/// Returns the word of one pixel, 0x00RRGGBB, which [`scan_out`] computes in every lane.
#[inline(always)]
pub fn word(rgba: [u8; 4]) -> u32 {
    u32::from_be_bytes(rgba) >> 8
}

/// Converts pixels of four bytes R, G, B, A to words, up to the shorter of both slices.
pub fn scan_out(level: Level, rgba: &[u8], words: &mut [u32]) {
    let count = (rgba.len() / 4).min(words.len());
    level.dispatch(ScanOut { rgba: &rgba[..count * 4], words: &mut words[..count] });
}

/// Adds pixels of four bytes R, G, B, A, times a weight, to the sums of their columns; up to the shorter of
/// both slices.
pub fn add_weighted(sums: &mut [[u32; 3]], pixels: &[[u8; 4]], weight: u32) {
    for (sum, pixel) in sums.iter_mut().zip(pixels) {
        for c in 0..3 {
            sum[c] += weight * u32::from(pixel[c]);
        }
    }
}

/// Returns the word of a mean of sums, up to the shorter of both slices; the weights of a whole column,
/// and those of a whole row that the sums were made with, add up to `whole` each.
pub fn mean_word(sums: &[[u32; 3]], weights: &[u32], whole: u32) -> u32 {
    let mut mean = [whole * whole / 2; 3];
    for (sum, weight) in sums.iter().zip(weights) {
        for c in 0..3 {
            mean[c] += weight * sum[c];
        }
    }
    let [r, g, b] = mean.map(|sum| sum / (whole * whole));
    r << 16 | g << 8 | b
}

struct ScanOut<'a> {
    rgba: &'a [u8],
    words: &'a mut [u32],
}

impl Kernel for ScanOut<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        // SAFETY: u32 and i32 have one size and alignment, and every value of one is a value of the
        // other.
        let words: &mut [i32] =
            unsafe { std::slice::from_raw_parts_mut(self.words.as_mut_ptr().cast(), self.words.len()) };
        let (low, middle) = (s.splat_i(0xff), s.splat_i(0xff00));
        let mut sources = self.rgba.chunks_exact(4 * S::LANES);
        let mut targets = words.chunks_exact_mut(S::LANES);
        for (source, target) in sources.by_ref().zip(targets.by_ref()) {
            // R is the lowest byte of a loaded lane.
            let v = s.load_bytes(source);
            let [red, green, blue] = [(v & low).shl::<16>(), v & middle, v.shr::<16>() & low];
            s.store_i(red + green + blue, target);
        }
        let rest = sources.remainder().as_chunks::<4>().0;
        for (&pixel, target) in rest.iter().zip(targets.into_remainder()) {
            *target = word(pixel) as i32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_level_gives_the_word_of_every_pixel(
            pixels in prop::collection::vec(any::<[u8; 4]>(), 0..120), start in 0..5usize, room in 0..130usize,
        ) {
            // Bytes of any alignment, and more or fewer words than pixels.
            let bytes: Vec<u8> = pixels.as_flattened().iter().copied().skip(start).collect();
            let mut want = vec![0xdead_beef; room];
            for (w, p) in want.iter_mut().zip(bytes.as_chunks::<4>().0) {
                *w = u32::from(p[0]) << 16 | u32::from(p[1]) << 8 | u32::from(p[2]);
            }
            for level in Level::ALL.into_iter().filter(|l| l.is_available()) {
                let mut words = vec![0xdead_beef; room];
                scan_out(level, &bytes, &mut words);
                prop_assert_eq!(&words, &want, "{}", level.as_str());
            }
        }
    }
}
