//! Plain text pixels, many in a row: the decoder's hot path.
//!
//! In: a stream from a command boundary on. Taken here: lines `PX x y c` + LF with single blanks, x and y of one to four
//! digits, c of two, six or eight hex digits in either case, LF or CR LF. All else (signs, names, queries, other verbs, a
//! line that is not whole) ends the run and is left to the general reader. Every byte is looked at: a line with anything
//! out of place is not taken. Out: a [`Record`] of each, in order.
//!
//! Three twins with the same answer for every input: `portable` in whole words of eight bytes and `avx2`, vectors of sixteen
//! bytes where the CPU has AVX2, a line at a time; `avx512`, AVX-512, four lines at a time, which leaves what it does not
//! take to the others. Which one runs is asked of the CPU at each call, which costs a load.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod portable;
#[cfg(test)]
mod tests;

/// One pixel: x and y as u16 little-endian, r, g, b, a.
pub type Record = [u8; 8];

/// How many bytes a line is read through: none that is taken here has more, and a twin may look this far.
const WINDOW: usize = 32;

/// Records in a batch where lines are read one by one.
const BATCH_RECORDS: usize = 64;

/// Lines that are read one by one before four at a time are tried; after a trial in vain twice as many, up to the second.
const PATIENCE: u64 = 4;
const MOST_PATIENCE: u64 = 512;

/// Reads plain pixels from the start of `bytes` on, giving them to `emit` some at a time. Answers how many bytes and lines
/// it took: those up to the first line that is not plain or not whole.
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

/// Reads lines one by one, at most so many.
#[inline]
fn read_single(bytes: &[u8], most: u64, emit: &mut impl FnMut(&[Record])) -> (usize, u64) {
    let mut batch = Batch { records: [[0; 8]; BATCH_RECORDS], count: 0, emit };
    let mut each = |x, y, color| batch.add(x, y, color);
    let (mut used, mut lines) = full_windows(bytes, most, &mut each);
    // The last lines are read in a copy with room behind it. No line is made of the zeros: none holds an LF.
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

/// Reads lines one by one, without the last window.
#[inline]
fn full_windows(bytes: &[u8], most: u64, each: &mut impl FnMut(u16, u16, [u8; 4])) -> (usize, u64) {
    #[cfg(target_arch = "x86_64")]
    if avx2::is_there() {
        // SAFETY: the CPU was just asked for what the function needs.
        return unsafe { avx2::pixel_lines(bytes, most, each) };
    }
    portable::pixel_lines(bytes, most, each)
}

/// Whether lines of so many bytes can be read four at a time.
#[inline]
fn is_wide(bytes: &[u8]) -> bool {
    #[cfg(target_arch = "x86_64")]
    return bytes.len() >= avx512::LEAST_BYTES && avx512::is_there();
    #[cfg(not(target_arch = "x86_64"))]
    return bytes.len() == usize::MAX;
}

/// Reads lines four at a time, where the CPU can.
#[inline]
fn read_by_four(bytes: &[u8], emit: &mut impl FnMut(&[Record])) -> (usize, u64) {
    #[cfg(target_arch = "x86_64")]
    if avx512::is_there() {
        // SAFETY: the CPU was just asked for what the function needs.
        return unsafe { avx512::pixel_records(bytes, emit) };
    }
    let _ = (bytes, emit);
    (0, 0)
}

/// Runs one line reader after the other for as long as any of them takes a line, at most `most` times: a stream keeps to one
/// form of colour. Answers how many bytes and lines were taken.
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
                    let Some((x, y, color, length)) = $line(window) else { break };
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
