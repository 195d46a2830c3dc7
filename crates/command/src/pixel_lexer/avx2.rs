//! AVX2 version: a line in one register of sixteen bytes (SSE4.1 instructions in AVX2's encoding).
//!
//! One comparison finds the blanks of `x y rrggbb`. They select a shuffle that moves x and y into
//! place, four digits each with zeros before them; the colour is loaded so that it ends where the
//! register does. Then all digits are checked and weighted together: pairs by 10 and 1 or 16 and 1,
//! then pairs of pairs by 100 and 1.

use super::WINDOW;
use fbptr_core::simd::bytes::{Avx2Bytes, ByteKernel};

/// Reads lines from the start of the bytes on, at most `most`, up to the last window; returns the
/// bytes and lines read.
pub struct PixelLines<'b, 'f, F> {
    pub bytes: &'b [u8],
    pub most: u64,
    pub each: &'f mut F,
}

impl<F: FnMut(u16, u16, [u8; 4])> ByteKernel<Avx2Bytes> for PixelLines<'_, '_, F> {
    type Output = (usize, u64);

    #[inline(always)]
    fn run(self, v: Avx2Bytes) -> (usize, u64) {
        super::runs!(
            self.bytes,
            self.most,
            self.each,
            [
                |window| line::<6, 1>(v, window),
                |window| line::<8, 1>(v, window),
                |window| line::<2, 1>(v, window),
                |window| line::<6, 2>(v, window),
                |window| line::<8, 2>(v, window),
                |window| line::<2, 2>(v, window)
            ]
        )
    }
}

/// Shuffles for blanks at byte a and byte b of `x y c`: positions of the digits of x and y, the
/// last ones last. A byte with its high bit selects nothing; `'0'` in its low bits is filled in
/// there. Impossible positions select nothing and fill in nothing.
static SHUFFLES: [[[u8; 16]; 16]; 16] = {
    const NOTHING: u8 = 0x80;
    const ZERO: u8 = 0x80 | b'0';
    let mut table = [[[NOTHING; 16]; 16]; 16];
    let mut a = 1;
    while a <= 4 {
        let mut b = a + 2;
        while b <= a + 5 {
            let mut i = 0;
            while i < 4 {
                // Counted from the last digit.
                table[a][b][3 - i] = if i < a { (a - 1 - i) as u8 } else { ZERO };
                table[a][b][7 - i] = if i < b - a - 1 { (b - 1 - i) as u8 } else { ZERO };
                i += 1;
            }
            b += 1;
        }
        a += 1;
    }
    table
};

/// Reads one line: x, y, colour of `DIGITS` hex digits, and the line's length in bytes with its
/// `ENDS` bytes of LF or CR LF.
#[inline(always)]
fn line<const DIGITS: usize, const ENDS: usize>(
    v: Avx2Bytes,
    window: &[u8; WINDOW],
) -> Option<(u16, u16, [u8; 4], usize)> {
    const VERB: u32 = u32::from_le_bytes(*b"PX \0");
    let words = v.load(window[3..].first_chunk()?);
    let blanks = v._mm_movemask_epi8(v._mm_cmpeq_epi8(words, v._mm_set1_epi8(b' ' as i8))) as u32;
    // Two bits beyond, so that there are always two.
    let blanks = blanks & 0x3fff | 0xc000;
    let a = blanks.trailing_zeros() as usize;
    let b = (blanks & (blanks - 1)).trailing_zeros() as usize;
    let end = 4 + b + DIGITS;
    let verb = u32::from_le_bytes([window[0], window[1], window[2], window[3]]);
    let ends = match ENDS {
        1 => window[end] == b'\n',
        _ => window[end] == b'\r' && window[end + 1] == b'\n',
    };
    if verb & 0xff_ffff != VERB || !ends {
        return None;
    }
    let shuffle = v.load(&SHUFFLES[a][b]);
    let numbers = v._mm_shuffle_epi8(words, shuffle);
    let numbers = v._mm_or_si128(numbers, v._mm_and_si128(shuffle, v._mm_set1_epi8(b'0' as i8)));
    // Consecutive blanks put the end of a short colour nearer than that: such a line is not
    // accepted.
    let color = window.get(end.checked_sub(8)?..)?.first_chunk()?;
    let color = v._mm_cvtsi64_si128(i64::from_le_bytes(*color));
    let digits = v._mm_unpacklo_epi64(numbers, color);
    // Decimal digits everywhere, letters in the colour alone: 0x80 moves all bytes of the numbers
    // out of the letters' range.
    let decimal = v._mm_sub_epi8(digits, v._mm_set1_epi8(b'0' as i8));
    let case = v._mm_set_epi64x(0x2020_2020_2020_2020, 0x8080_8080_8080_8080_u64 as i64);
    let letter = v._mm_sub_epi8(v._mm_or_si128(digits, case), v._mm_set1_epi8(b'a' as i8));
    let is_decimal = v._mm_cmpeq_epi8(v._mm_min_epu8(decimal, v._mm_set1_epi8(9)), decimal);
    let is_letter = v._mm_cmpeq_epi8(v._mm_min_epu8(letter, v._mm_set1_epi8(5)), letter);
    let good = v._mm_movemask_epi8(v._mm_or_si128(is_decimal, is_letter)) as u32;
    // Bytes before a shorter colour are not checked here: the blank and digits of y, checked above.
    let needed = 0xffff << (16 - DIGITS) & 0xffff | 0xff;
    if good & needed != needed {
        return None;
    }
    // A decimal digit is far from a letter: the smaller of the two values is the right one.
    let values = v._mm_min_epu8(decimal, v._mm_add_epi8(letter, v._mm_set1_epi8(10)));
    let weights = v._mm_set_epi64x(0x0110_0110_0110_0110, 0x010a_010a_010a_010a);
    let pairs = v._mm_maddubs_epi16(values, weights);
    let places = v._mm_madd_epi16(pairs, v._mm_set_epi64x(0, 0x0001_0064_0001_0064));
    let places = v._mm_cvtsi128_si64(places) as u64;
    let color = v.second_dword(v._mm_packus_epi16(pairs, pairs));
    let color = match DIGITS {
        2 => (color >> 24).wrapping_mul(0x01_0101) | 0xff00_0000,
        6 => color >> 8 | 0xff00_0000,
        _ => color,
    };
    Some((places as u16, (places >> 32) as u16, color.to_le_bytes(), end + ENDS))
}
