//! Scanner for consecutive binary pixels: counts the records of ten bytes that begin with `PB`, and
//! the LF among their bytes.
//!
//! The letters recur at the same positions of 64-byte vectors every 320 bytes, and of eight-byte
//! words every 40, so whole blocks are compared with a pattern. The comparison is written in words
//! and compiled for each vector level, whose vectors the compiler uses for them.

use fbptr_core::simd::{Kernel, Level, Simd};

/// Size of a record in bytes.
const RECORD: usize = 10;
/// Period in bytes of the letters' positions in a vector: 32 records.
const PERIOD: usize = 320;

/// Expected letters, 0 elsewhere; and a mask of their positions.
static LETTERS: [u8; PERIOD] = pattern(*b"PB");
static ARE_LETTERS: [u8; PERIOD] = pattern([0xff; 2]);

const fn pattern(letters: [u8; 2]) -> [u8; PERIOD] {
    let mut pattern = [0; PERIOD];
    let mut i = 0;
    while i < PERIOD {
        pattern[i] = letters[0];
        pattern[i + 1] = letters[1];
        i += RECORD;
    }
    pattern
}

/// Counts the complete records at the start of `bytes` that are binary pixels, and the LF in them.
#[inline]
pub fn leading_records(bytes: &[u8]) -> (usize, u64) {
    let (count, lines) = Level::best().dispatch(FullPeriods(bytes));
    let rest = bytes[count * RECORD..].as_chunks::<RECORD>().0;
    let more = rest.iter().position(|r| !r.starts_with(b"PB")).unwrap_or(rest.len());
    (count + more, lines + lf_in(rest[..more].as_flattened()))
}

/// Counts as [`leading_records`] does, up to the first block of 32 records that are not all
/// binary pixels.
struct FullPeriods<'b>(&'b [u8]);

impl Kernel for FullPeriods<'_> {
    type Output = (usize, u64);

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> (usize, u64) {
        full_periods(self.0)
    }
}

#[inline(always)]
fn full_periods(bytes: &[u8]) -> (usize, u64) {
    let words = |block: &'static [u8; PERIOD]| block.as_chunks::<8>().0;
    let (letters, are_letters) = (words(&LETTERS), words(&ARE_LETTERS));
    let mut count = 0;
    for block in bytes.as_chunks::<PERIOD>().0 {
        let mut wrong = 0;
        for ((bytes, letters), are) in block.as_chunks::<8>().0.iter().zip(letters).zip(are_letters) {
            let [bytes, letters, are] = [bytes, letters, are].map(|w| u64::from_le_bytes(*w));
            wrong |= (bytes ^ letters) & are;
        }
        if wrong != 0 {
            break;
        }
        count += PERIOD / RECORD;
    }
    (count, lf_in(&bytes[..count * RECORD]))
}

/// Counts the LF bytes.
#[inline(always)]
pub fn lf_in(bytes: &[u8]) -> u64 {
    // Short sums in bytes, which the compiler vectorizes.
    bytes.chunks(192).map(|c| u64::from(c.iter().map(|&b| u8::from(b == b'\n')).sum::<u8>())).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn plainly(bytes: &[u8]) -> (usize, u64) {
        let count = bytes.chunks_exact(RECORD).take_while(|r| r.starts_with(b"PB")).count();
        (count, bytes[..count * RECORD].iter().filter(|&&b| b == b'\n').count() as u64)
    }

    fn check(bytes: &[u8]) {
        let plain = plainly(bytes);
        assert_eq!(leading_records(bytes), plain);
        let blocks = plain.0 / 32 * 32;
        let of_blocks = plainly(&bytes[..blocks * RECORD]);
        for level in Level::ALL {
            assert_eq!(level.dispatch(FullPeriods(bytes)), of_blocks, "{level:?}");
        }
    }

    #[test]
    fn every_letter_of_every_record_is_looked_at() {
        let record = *b"PB\n\n1234\n5";
        let bytes = record.repeat(100);
        check(&bytes);
        for at in 0..bytes.len() {
            for change in [1, 2, 0x20, 0x80] {
                let mut bytes = bytes.clone();
                bytes[at] ^= change;
                check(&bytes);
            }
            check(&bytes[..at]);
        }
    }

    proptest! {
        #[test]
        fn every_level_reads_as_plain_reading_does(
            records in prop::collection::vec(any::<[u8; 8]>(), 0..150),
            lf in prop::collection::vec(any::<prop::sample::Index>(), 0..40),
            damage in prop::option::of((any::<prop::sample::Index>(), any::<u8>())),
        ) {
            let mut bytes: Vec<u8> = records.iter().flat_map(|r| [&b"PB"[..], r].concat()).collect();
            if !bytes.is_empty() {
                for at in lf {
                    let at = at.index(bytes.len());
                    if at % RECORD > 1 {
                        bytes[at] = b'\n';
                    }
                }
                if let Some((at, byte)) = damage {
                    let at = at.index(bytes.len());
                    bytes[at] = byte;
                }
            }
            check(&bytes);
        }
    }
}
