//! Pixels of framebuffer formats to R, G, B, A bytes.
//!
//! Plain loops, compiled once for every level's instructions: the compiler makes vectors of them.
//! Channels of less than eight bits are widened by repeating their bits, from the highest on: 0 stays
//! 0, the largest value becomes 255, and both of the kernel's rules for narrow channels give the
//! value back: the rounding one of `CNVT_TOHW` (`drivers/video/fbdev/vfb.c`) and the one of
//! `drm_format_helper.c`, which drops bits.

use super::{Kernel, Level, Simd};

/// Pixels to be converted, with all that their format needs.
#[derive(Clone, Copy, Debug)]
pub enum Pixels<'a> {
    /// Words of 32 bits: the lowest bit of red, green, blue and, if it is kept, alpha.
    Words {
        /// Pixels of four bytes, little-endian.
        bytes: &'a [u8],
        /// Lowest bits of the channels.
        shifts: [u32; 4],
        /// False if every pixel is opaque.
        has_alpha: bool,
    },
    /// Three bytes: the places of red, green and blue among them.
    Triples {
        /// Pixels of three bytes.
        bytes: &'a [u8],
        /// Places of the channels.
        places: [usize; 3],
    },
    /// Words of 16 bits: the lowest bit and the number of bits of red, green and blue.
    Halves {
        /// Pixels of two bytes, little-endian.
        bytes: &'a [u8],
        /// Lowest bits of the channels.
        shifts: [u32; 3],
        /// Bits of the channels, 4 to 8.
        lengths: [u32; 3],
    },
    /// Indices of 8, 4, 2 or 1 bits.
    Indices {
        /// Bytes of one or more pixels.
        bytes: &'a [u8],
        /// Bits of an index.
        bits: u32,
        /// Pixels of the first byte that are left out.
        skip: usize,
        /// True if a byte's leftmost pixel is its highest bits; otherwise its lowest.
        high_first: bool,
        /// Colours of the indices.
        palette: &'a [[u8; 4]; 256],
    },
}

/// Converts pixels to R, G, B, A, up to the shorter of both sides.
pub fn unpack(level: Level, pixels: Pixels<'_>, to: &mut [[u8; 4]]) {
    level.dispatch(Unpack { pixels, to });
}

/// Returns a channel of `length` bits (4 to 8) in eight.
#[inline(always)]
pub fn widen(value: u32, length: u32) -> u32 {
    value << (8 - length) | value >> (2 * length - 8)
}

struct Unpack<'a> {
    pixels: Pixels<'a>,
    to: &'a mut [[u8; 4]],
}

impl Kernel for Unpack<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        match self.pixels {
            Pixels::Words { bytes, shifts, has_alpha } => words(bytes, shifts, has_alpha, self.to),
            Pixels::Triples { bytes, places: [r, g, b] } => {
                for (to, from) in self.to.iter_mut().zip(bytes.as_chunks::<3>().0) {
                    *to = [from[r], from[g], from[b], 255];
                }
            }
            Pixels::Halves { bytes, shifts, lengths } => halves(bytes, shifts, lengths, self.to),
            Pixels::Indices { bytes, bits: 8, palette, .. } => {
                for (to, from) in self.to.iter_mut().zip(bytes) {
                    *to = palette[usize::from(*from)];
                }
            }
            Pixels::Indices { bytes, bits, skip, high_first, palette } => {
                let (per_byte, mask) = (8 / bits, (1u8 << bits) - 1);
                let pixels = bytes.iter().flat_map(|byte| {
                    (0..per_byte).map(move |i| {
                        let place = if high_first { per_byte - 1 - i } else { i };
                        byte >> (place * bits) & mask
                    })
                });
                for (to, index) in self.to.iter_mut().zip(pixels.skip(skip)) {
                    *to = palette[usize::from(index)];
                }
            }
        }
    }
}

#[inline(always)]
fn words(bytes: &[u8], [r, g, b, a]: [u32; 4], has_alpha: bool, to: &mut [[u8; 4]]) {
    let (a, opaque) = if has_alpha { (a & 31, 0) } else { (0, 0xff00_0000) };
    // Shifts of the same count in all lanes, without a check for 32 or more.
    let (r, g, b) = (r & 31, g & 31, b & 31);
    for (to, from) in to.iter_mut().zip(bytes.as_chunks::<4>().0) {
        let v = u32::from_le_bytes(*from);
        let color = v >> r & 0xff | (v >> g & 0xff) << 8 | (v >> b & 0xff) << 16 | (v >> a & 0xff) << 24;
        *to = (color | opaque).to_le_bytes();
    }
}

#[inline(always)]
fn halves(bytes: &[u8], shifts: [u32; 3], lengths: [u32; 3], to: &mut [[u8; 4]]) {
    let [r, g, b] = shifts.map(|shift| shift & 15);
    // Bounds that the loop's shifts need no checks for.
    let lengths = lengths.map(|length| length.clamp(4, 8));
    let [red_max, green_max, blue_max] = lengths.map(|length| (1u32 << length) - 1);
    let channel = |v: u32, length: u32| widen(v, length);
    for (to, from) in to.iter_mut().zip(bytes.as_chunks::<2>().0) {
        let v = u32::from(u16::from_le_bytes(*from));
        let red = channel(v >> r & red_max, lengths[0]);
        let green = channel(v >> g & green_max, lengths[1]);
        let blue = channel(v >> b & blue_max, lengths[2]);
        *to = (red | green << 8 | blue << 16 | 0xff00_0000).to_le_bytes();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn levels() -> impl Iterator<Item = Level> {
        Level::ALL.into_iter().filter(|level| level.is_available())
    }

    /// Returns the first eight bits of a channel's bits, repeated without end.
    fn repeated(value: u32, length: u32) -> u8 {
        (0..8).fold(0, |wide, bit| wide << 1 | (value >> (length - 1 - bit % length) & 1) as u8)
    }

    /// `CNVT_TOHW(val, width)` of the kernel's `vfb.c`: a channel of 16 bits in `width` bits.
    fn kernel_narrow(val: u32, width: u32) -> u32 {
        ((val << width) + 0x7fff - val) >> 16
    }

    #[test]
    fn the_kernels_rules_for_narrow_channels_give_every_value_back() {
        for length in 4..=8 {
            for v in 0..1 << length {
                let wide = widen(v, length);
                assert!(wide < 256);
                assert_eq!(kernel_narrow(wide * 257, length), v, "{v} of {length} bits");
                assert_eq!(wide >> (8 - length), v, "{v} of {length} bits, by dropping bits");
            }
            assert_eq!((widen(0, length), widen((1 << length) - 1, length)), (0, 255));
        }
    }

    #[test]
    fn every_value_of_16_bits_is_widened_by_repeating_its_bits() {
        let bytes: Vec<u8> = (0..=u16::MAX).flat_map(u16::to_le_bytes).collect();
        for level in levels() {
            for (shifts, lengths) in [([11, 5, 0], [5, 6, 5]), ([0, 5, 10], [5; 3]), ([8, 4, 0], [4; 3])] {
                let mut to = vec![[0; 4]; 1 << 16];
                unpack(level, Pixels::Halves { bytes: &bytes, shifts, lengths }, &mut to);
                for (v, pixel) in (0u32..).zip(&to) {
                    let channel = |i: usize| repeated(v >> shifts[i] & ((1 << lengths[i]) - 1), lengths[i]);
                    assert_eq!(*pixel, [channel(0), channel(1), channel(2), 255], "{v:#x} at {level:?}");
                }
            }
        }
    }

    #[test]
    fn words_and_triples_keep_every_channel_where_it_belongs() {
        let bytes: Vec<u8> = (0..=255).chain((0..=255).rev()).chain(7..=130).collect();
        for level in levels() {
            for shifts in [[16, 8, 0, 24], [0, 8, 16, 24], [8, 16, 24, 0], [24, 16, 8, 0]] {
                for has_alpha in [false, true] {
                    let mut to = vec![[0; 4]; bytes.len() / 4 + 3];
                    unpack(level, Pixels::Words { bytes: &bytes, shifts, has_alpha }, &mut to);
                    for (to, from) in to.iter().zip(bytes.as_chunks::<4>().0) {
                        let mut want = shifts.map(|shift| from[shift as usize / 8]);
                        want[3] = if has_alpha { want[3] } else { 255 };
                        assert_eq!(*to, want);
                    }
                    assert_eq!(to[bytes.len() / 4..], [[0; 4]; 3]);
                }
            }
            let mut to = vec![[0; 4]; 100];
            unpack(level, Pixels::Triples { bytes: &bytes, places: [2, 1, 0] }, &mut to);
            assert_eq!((to[0], to[99]), ([2, 1, 0, 255], [bytes[299], bytes[298], bytes[297], 255]));
        }
    }

    #[test]
    fn indices_of_each_width_are_looked_up_from_either_end_of_a_byte() {
        let palette: [[u8; 4]; 256] = std::array::from_fn(|i| [i as u8, 0, 0, 255]);
        let bytes = [0b1110_0100, 0b0001_1011];
        let cases: [(u32, bool, usize, &[u8]); 7] = [
            (8, false, 0, &[0b1110_0100, 0b0001_1011]),
            (4, false, 0, &[4, 14, 11, 1]),
            (4, true, 0, &[14, 4, 1, 11]),
            (2, false, 1, &[1, 2, 3, 3, 2, 1, 0]),
            (2, true, 0, &[3, 2, 1, 0, 0, 1, 2, 3]),
            (1, false, 3, &[0, 0, 1, 1, 1, 1, 1, 0, 1, 1, 0, 0, 0]),
            (1, true, 0, &[1, 1, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 1, 0, 1, 1]),
        ];
        for (bits, high_first, skip, want) in cases {
            let mut to = vec![[9; 4]; 20];
            let pixels = Pixels::Indices { bytes: &bytes, bits, skip, high_first, palette: &palette };
            unpack(Level::best(), pixels, &mut to);
            let found: Vec<u8> = to.iter().map(|p| p[0]).take(want.len()).collect();
            assert_eq!(found, want, "{bits} bits, high first: {high_first}");
            assert_eq!(to[want.len()], [9; 4]);
        }
    }
}
