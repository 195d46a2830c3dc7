//! Byte searches for the ends of lines and words, eight bytes at a time, and the words of up to 64 bytes as bits.

/// The lowest bit of every byte.
const LOW: u64 = 0x0101_0101_0101_0101;
/// The highest bit of every byte.
const HIGH: u64 = 0x8080_8080_8080_8080;

/// Sets the high bit of every byte of `word` that equals `byte`; bytes above the first match may be
/// set falsely.
const fn flags(word: u64, byte: u8) -> u64 {
    let x = word ^ (LOW * byte as u64);
    x.wrapping_sub(LOW) & !x & HIGH
}

/// Returns the index of the first match: `flags` marks the matches in a word of eight bytes, as
/// [`flags`] does, and `is_it` tests the remaining bytes.
fn find(bytes: &[u8], flags: impl Fn(u64) -> u64, is_it: impl Fn(u8) -> bool) -> Option<usize> {
    let (words, tail) = bytes.as_chunks::<8>();
    for (i, word) in words.iter().enumerate() {
        let flags = flags(u64::from_le_bytes(*word));
        if flags != 0 {
            return Some(i * 8 + flags.trailing_zeros() as usize / 8);
        }
    }
    tail.iter().position(|&b| is_it(b)).map(|n| words.len() * 8 + n)
}

/// Returns the index of the first LF.
#[inline]
pub(super) fn find_lf(bytes: &[u8]) -> Option<usize> {
    find(bytes, |word| flags(word, b'\n'), |b| b == b'\n')
}

/// Returns the index of the first blank or tab.
#[inline]
pub(super) fn find_blank(bytes: &[u8]) -> Option<usize> {
    find(bytes, |word| flags(word, b' ') | flags(word, b'\t'), |b| b == b' ' || b == b'\t')
}

/// Returns the index of the first blank of sixteen bytes. A tab is none.
#[inline]
pub(super) fn find_blank_of_16(bytes: &[u8; 16]) -> Option<usize> {
    let [low, high] = bytes.as_chunks::<8>().0 else { return None };
    match flags(u64::from_le_bytes(*low), b' ') {
        0 => match flags(u64::from_le_bytes(*high), b' ') {
            0 => None,
            found => Some(8 + found.trailing_zeros() as usize / 8),
        },
        found => Some(found.trailing_zeros() as usize / 8),
    }
}

/// Returns the bytes of up to 64 that are neither blank nor tab, the first as the lowest bit.
#[inline]
pub(super) fn letters(bytes: &[u8]) -> u64 {
    debug_assert!(bytes.len() <= 64);
    let Some(tail) = bytes.last_chunk::<8>() else {
        let bits = bytes.iter().enumerate().map(|(i, &b)| u64::from(b != b' ' && b != b'\t') << i);
        return bits.fold(0, |all, bit| all | bit);
    };
    let mut found = 0;
    for (i, word) in bytes.as_chunks::<8>().0.iter().enumerate() {
        found |= letters_of_eight(*word) << (8 * i);
    }
    // The last eight bytes overlap what was read.
    found | letters_of_eight(*tail) << (bytes.len() - 8)
}

/// [`letters`] of eight bytes. Exact, unlike [`flags`]: no carry goes from byte to byte.
#[inline]
fn letters_of_eight(bytes: [u8; 8]) -> u64 {
    let word = u64::from_le_bytes(bytes);
    // The high bit of each byte that is not zero.
    let is_set = |x: u64| ((x & !HIGH) + !HIGH) | x;
    let letters = is_set(word ^ (LOW * b' ' as u64)) & is_set(word ^ (LOW * b'\t' as u64)) & HIGH;
    // Bit 8i moves to bit 56 + i.
    ((letters >> 7).wrapping_mul(0x0102_0408_1020_4080)) >> 56
}

pub(super) use super::binary_pixels::lf_in as count_lf;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_agree_with_looking_at_each_byte() {
        for len in 0..600 {
            for step in [1, 2, 3, 7, 64, 1000] {
                let bytes: Vec<u8> = (0..len)
                    .map(|i| if (i + 1) % step == 0 { b'\n' } else { [9, 11, 0, 255, 0x8a][i % 5] })
                    .collect();
                assert_eq!(find_lf(&bytes), bytes.iter().position(|&b| b == b'\n'), "{bytes:?}");
                let blanks: Vec<u8> =
                    bytes.iter().map(|&b| if b == b'\n' { b" \t"[len % 2] } else { b }).collect();
                assert_eq!(find_blank(&blanks), blanks.iter().position(|&b| b == b' ' || b == b'\t'));
                for part in blanks.array_windows::<16>() {
                    assert_eq!(find_blank_of_16(part), part.iter().position(|&b| b == b' '), "{part:?}");
                }
                for part in blanks.chunks(64) {
                    let bit = |i: usize| part.get(i).is_some_and(|b| !b" \t".contains(b));
                    let expected = (0..64).fold(0, |all, i| all | u64::from(bit(i)) << i);
                    assert_eq!(letters(part), expected, "{part:?}");
                }
                assert_eq!(count_lf(&bytes), bytes.iter().filter(|&&b| b == b'\n').count() as u64);
            }
        }
    }
}
