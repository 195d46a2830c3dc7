//! Where lines end.

/// The place of the first LF.
#[inline]
pub(super) fn find_lf(bytes: &[u8]) -> Option<usize> {
    const LOW: u64 = 0x0101_0101_0101_0101;
    let (words, tail) = bytes.as_chunks::<8>();
    for (i, word) in words.iter().enumerate() {
        // A byte of x is zero where LF stands; the lowest flag is the first of them.
        let x = u64::from_le_bytes(*word) ^ (LOW * b'\n' as u64);
        let flags = x.wrapping_sub(LOW) & !x & (LOW << 7);
        if flags != 0 {
            return Some(i * 8 + flags.trailing_zeros() as usize / 8);
        }
    }
    tail.iter().position(|&b| b == b'\n').map(|n| words.len() * 8 + n)
}

/// How many LF bytes there are.
#[inline]
pub(super) fn count_lf(bytes: &[u8]) -> u64 {
    // Short sums in bytes: the compiler makes vector code of them.
    bytes.chunks(192).map(|c| u64::from(c.iter().map(|&b| u8::from(b == b'\n')).sum::<u8>())).sum()
}

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
                assert_eq!(count_lf(&bytes), bytes.iter().filter(|&&b| b == b'\n').count() as u64);
            }
        }
    }
}
