//! Portable version, in words of eight bytes.
//!
//! The position of LF is taken from one word, so that finding the next line depends on nothing
//! else; x and y are found and converted together, without a branch on their number of digits.
//! Words are little-endian: the first character is the lowest byte.

use super::WINDOW;
use std::num::NonZero;

const LOW: u64 = 0x0101_0101_0101_0101;
const HIGH: u64 = 0x8080_8080_8080_8080;

/// Reads lines from the start of `bytes` on, at most `most`, up to the last window; returns the
/// bytes and lines read.
#[inline]
pub fn pixel_lines(bytes: &[u8], most: u64, each: &mut impl FnMut(u16, u16, [u8; 4])) -> (usize, u64) {
    super::runs!(
        bytes,
        most,
        each,
        [line::<6, 1>, line::<8, 1>, line::<2, 1>, line::<6, 2>, line::<8, 2>, line::<2, 2>]
    )
}

#[inline(always)]
fn word(window: &[u8; WINDOW], at: usize) -> Option<u64> {
    window.get(at..)?.first_chunk().map(|b| u64::from_le_bytes(*b))
}

/// Reads one line: x, y, colour of `DIGITS` hex digits, and the line's length in bytes with its
/// `ENDS` bytes of LF or CR LF.
#[inline(always)]
fn line<const DIGITS: usize, const ENDS: usize>(window: &[u8; WINDOW]) -> Option<(u16, u16, [u8; 4], usize)> {
    // The shortest line, `PX 0 0 ` and the colour, puts LF at 6 + DIGITS + ENDS; six more digits
    // can stand before it.
    let first = 5 + DIGITS + ENDS;
    let start = word(window, 0)?;
    let ends = word(window, first)? ^ (LOW * b'\n' as u64);
    // The lowest flag marks the first zero byte; higher ones may be false.
    let ends = NonZero::new(ends.wrapping_sub(LOW) & !ends & HIGH)?;
    if start & 0xff_ffff != u64::from_le_bytes(*b"PX \0\0\0\0\0") {
        return None;
    }
    let lf = first + ends.trailing_zeros() as usize / 8;
    let (x, x_digits) = number(start >> 24)?;
    let (y, y_digits) = number(word(window, 4 + x_digits)?)?;
    let end = 5 + x_digits + y_digits + DIGITS;
    let ends_well = end + ENDS == lf + 1 && (ENDS == 1 || window[end] == b'\r');
    if !ends_well || window[3 + x_digits] != b' ' || window[4 + x_digits + y_digits] != b' ' {
        return None;
    }
    let color = color::<DIGITS>(word(window, end.checked_sub(8)?)?)?;
    let [x, y] = values(x, y);
    Some((x, y, color, lf + 1))
}

/// Reads one to four digits at the start of a word: returns digit values, the last in the highest
/// byte, zeros before the first, and the number of digits.
#[inline(always)]
fn number(word: u64) -> Option<(u32, usize)> {
    // Digits become 0 to 9, which stay below 0x80 when 0x76 is added; other bytes do not, or have
    // that bit already.
    let values = word ^ (LOW * b'0' as u64);
    let others = NonZero::new((values.wrapping_add(LOW * 0x76) | values) & HIGH)?;
    // One to four digits put the flag at bit 15, 23, 31 or 39.
    let bit = others.trailing_zeros();
    (15..=39).contains(&bit).then(|| ((values as u32) << (39 - bit), bit as usize / 8))
}

/// Returns the numbers that two words of four digit values each stand for.
#[inline(always)]
fn values(x: u32, y: u32) -> [u16; 2] {
    let digits = u64::from(x) | u64::from(y) << 32;
    // ab cd in bytes: 10a + b in byte 0, 10c + d in byte 2; no sum leaves its byte.
    let pairs = (digits.wrapping_mul(10) + (digits >> 8)) & 0x00ff_00ff_00ff_00ff;
    let fours = pairs.wrapping_mul(100) + (pairs >> 16);
    [fours as u16, (fours >> 32) as u16]
}

/// Returns the colour in the last `DIGITS` bytes of a word.
#[inline(always)]
pub fn color<const DIGITS: usize>(word: u64) -> Option<[u8; 4]> {
    let c = if DIGITS == 8 { word } else { word >> (64 - 8 * DIGITS) };
    // Bytes that are not part of the colour become digits.
    let c = if DIGITS == 8 { c } else { c | (LOW * b'0' as u64) << (8 * DIGITS % 64) };
    // k is 1 where bit 6 marks a letter. Letters lose their case and 0x40, digits lose 0x30: v is 1
    // to 6, or 0 to 9.
    let k = (c >> 6) & LOW;
    let v = (c & !(k << 5)) ^ (LOW * 0x30 + (k << 4));
    // w is 0 to 5, or 0 to 9; the sum stays below 0x80 for these alone. A borrow or carry comes
    // from a flagged byte.
    let w = v.wrapping_sub(k);
    let bad = (w.wrapping_add(LOW * 0x76 + k * 4) | w) & HIGH;
    if bad != 0 {
        return None;
    }
    let nibbles = w + k * 10;
    let bytes = (nibbles << 4 | nibbles >> 8) & 0x00ff_00ff_00ff_00ff;
    // r, g, b and a are in every other byte.
    let pairs = bytes | bytes >> 8;
    let rgb = (pairs & 0xffff | (bytes >> 16) & 0xff_0000) as u32;
    let rgba = match DIGITS {
        2 => ((bytes as u32 & 0xff) * 0x01_0101) | 0xff00_0000,
        6 => rgb | 0xff00_0000,
        _ => rgb | (bytes >> 24) as u32 & 0xff00_0000,
    };
    Some(rgba.to_le_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_in_every_place_of_a_colour_is_checked() {
        fn check<const DIGITS: usize>() {
            for digit in *b"0f" {
                for at in 0..DIGITS {
                    for byte in 0..=255 {
                        let mut text = [b'\n'; 8];
                        text[8 - DIGITS..].fill(digit);
                        text[8 - DIGITS + at] = byte;
                        let found = color::<DIGITS>(u64::from_le_bytes(text));
                        assert_eq!(found.is_some(), byte.is_ascii_hexdigit(), "{text:?}");
                    }
                }
            }
        }
        check::<2>();
        check::<6>();
        check::<8>();
    }

    #[test]
    fn numbers_have_one_to_four_digits() {
        for n in 0..=9999u16 {
            for width in 1..=4 {
                let text = format!("{n:0width$} 77777777");
                let word = u64::from_le_bytes(*text.as_bytes().first_chunk().unwrap());
                let (digits, count) = number(word).unwrap();
                assert_eq!((values(digits, 0), count), ([n, 0], text.find(' ').unwrap()), "{text}");
                assert_eq!(values(0, digits), [0, n]);
            }
        }
        for at in 0..5 {
            for byte in 0..=255u8 {
                let mut text = *b"1234 678";
                text[at] = byte;
                let found = number(u64::from_le_bytes(text)).map(|n| n.1);
                let expected = text.iter().position(|b| !b.is_ascii_digit()).filter(|n| (1..=4).contains(n));
                assert_eq!(found, expected, "{text:?}");
            }
        }
    }
}
