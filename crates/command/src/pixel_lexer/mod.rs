//! Lexer for consecutive plain text pixels: the decoder's hot path.
//!
//! In: a stream from a command boundary on. Accepted here: lines `PX x y c` + LF with single
//! blanks, x and y of one to four digits, c of two, six or eight hex digits in either case, LF or
//! CR LF. Anything else (signs, names, queries, other verbs, an incomplete line) ends the run and
//! is left to the general reader. Every byte is checked: a line with anything out of place is not
//! accepted. Out: a [`Record`] for each, in order.
//!
//! Three versions with equal results for every input: `portable` in words of eight bytes and
//! `avx2`, vectors of sixteen bytes where the CPU has AVX2, a line at a time; `avx512`, AVX-512,
//! four lines at a time, which leaves what it does not accept to the others. Both are compiled with
//! the crate's feature `avx`. The CPU is queried at each call, which costs a load.

#[cfg(all(target_arch = "x86_64", feature = "avx"))]
mod avx2;
#[cfg(all(target_arch = "x86_64", feature = "avx"))]
mod avx512;
pub(super) mod portable;
#[cfg(test)]
mod tests;

#[cfg(all(target_arch = "x86_64", feature = "avx"))]
use fbptr_core::simd::bytes::{Avx2Bytes, Avx512Bytes};

/// Decoded pixel: x and y as u16 little-endian, r, g, b, a.
pub type Record = [u8; 8];

/// Bytes in which a line is read: no accepted line is longer, and all versions may read this far.
const WINDOW: usize = 32;

/// Records in a batch if lines are read one by one.
const BATCH_RECORDS: usize = 64;

/// Lines that are read one by one before four at a time are tried; doubled after each failed try,
/// up to the second constant.
const PATIENCE: u64 = 4;
const MOST_PATIENCE: u64 = 512;

/// Reads plain pixels from the start of `bytes` on, passing them to `emit` in batches. Returns the
/// bytes and lines read: those up to the first line that is not plain or not complete.
#[inline]
pub fn pixel_records(bytes: &[u8], emit: &mut impl FnMut(&[Record])) -> (usize, u64) {
    if !bytes.starts_with(b"PX ") {
        return (0, 0);
    }
    let (mut used, mut lines, mut patience) = (0, 0, PATIENCE);
    loop {
        let rest = &bytes[used..];
        let most = if is_wide(rest) { patience } else { u64::MAX };
        let (more_used, more_lines) = read_single(rest, most, emit);
        used += more_used;
        lines += more_lines;
        if more_lines < most {
            return (used, lines);
        }
        let (more_used, more_lines) = read_by_four(&bytes[used..], emit);
        used += more_used;
        lines += more_lines;
        patience = if more_lines > patience { PATIENCE } else { (2 * patience).min(MOST_PATIENCE) };
    }
}

/// Reads lines one by one, at most `most`; returns the bytes and lines read.
#[inline]
fn read_single(bytes: &[u8], most: u64, emit: &mut impl FnMut(&[Record])) -> (usize, u64) {
    let mut batch = Batch { records: [[0; 8]; BATCH_RECORDS], count: 0, emit };
    let mut each = |x, y, color| batch.add(x, y, color);
    let (mut used, mut lines) = full_windows(bytes, most, &mut each);
    // The last lines are read from a padded copy. The zeros do not form a line, since they contain
    // no LF.
    let rest = &bytes[used..];
    if lines < most && rest.len() < WINDOW && rest.starts_with(b"PX ") {
        let mut padded = [0; 2 * WINDOW];
        padded[..rest.len()].copy_from_slice(rest);
        let (more_used, more_lines) = full_windows(&padded, most - lines, &mut each);
        used += more_used;
        lines += more_lines;
    }
    batch.flush();
    (used, lines)
}

/// Single pixels until their batch is full.
struct Batch<'a, F: FnMut(&[Record])> {
    records: [Record; BATCH_RECORDS],
    count: usize,
    emit: &'a mut F,
}

impl<F: FnMut(&[Record])> Batch<'_, F> {
    #[inline(always)]
    fn add(&mut self, x: u16, y: u16, color: [u8; 4]) {
        if let Some(record) = self.records.get_mut(self.count) {
            let place = u64::from(x) | u64::from(y) << 16;
            *record = (place | u64::from(u32::from_le_bytes(color)) << 32).to_le_bytes();
        }
        self.count += 1;
        if self.count == BATCH_RECORDS {
            self.flush();
        }
    }

    #[inline]
    fn flush(&mut self) {
        if let Some(records) = self.records.get(..self.count)
            && !records.is_empty()
        {
            (self.emit)(records);
        }
        self.count = 0;
    }
}

/// Reads lines one by one, except in the last window; returns the bytes and lines read.
#[inline]
fn full_windows(bytes: &[u8], most: u64, each: &mut impl FnMut(u16, u16, [u8; 4])) -> (usize, u64) {
    #[cfg(all(target_arch = "x86_64", feature = "avx"))]
    if let Some(read) = Avx2Bytes::run(avx2::PixelLines { bytes, most, each: &mut *each }) {
        return read;
    }
    portable::pixel_lines(bytes, most, each)
}

/// Returns whether `bytes` are enough, and the CPU able, to read four lines at a time.
#[inline]
fn is_wide(bytes: &[u8]) -> bool {
    #[cfg(all(target_arch = "x86_64", feature = "avx"))]
    return bytes.len() >= avx512::LEAST_BYTES && Avx512Bytes::is_available();
    #[cfg(not(all(target_arch = "x86_64", feature = "avx")))]
    return bytes.len() == usize::MAX;
}

/// Reads lines four at a time, if the CPU can; returns the bytes and lines read.
#[inline]
fn read_by_four(bytes: &[u8], emit: &mut impl FnMut(&[Record])) -> (usize, u64) {
    #[cfg(all(target_arch = "x86_64", feature = "avx"))]
    if let Some(read) = Avx512Bytes::run(avx512::PixelRecords { bytes, emit: &mut *emit }) {
        return read;
    }
    let _ = (bytes, emit);
    (0, 0)
}

/// Runs one line reader after the other for as long as any of them accepts a line, at most `most`
/// times: a stream usually uses one form of colour. Returns the bytes and lines read.
macro_rules! runs {
    ($bytes:expr, $most:expr, $each:expr, [$($line:expr),+]) => {{
        let (bytes, most, each): (&[u8], u64, _) = ($bytes, $most, $each);
        let (mut rest, mut lines) = (bytes, 0u64);
        loop {
            let before = lines;
            $(
                while lines < most
                    && let Some(window) = rest.first_chunk::<{ super::WINDOW }>()
                {
                    let Some((x, y, color, length)) = ($line)(window) else { break };
                    each(x, y, color);
                    lines += 1;
                    rest = &rest[length..];
                }
            )+
            if lines == before {
                break (bytes.len() - rest.len(), lines);
            }
        }
    }};
}
use runs;
