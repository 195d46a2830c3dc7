//! AVX-512 version: four lines at a time, in vectors of 64 bytes with byte permutations.
//!
//! First the separators of some kilobytes are found, 64 bytes at once: all bytes up to the blank
//! (CR LF being one); their positions and values are packed into two lists. A plain line has four
//! of them, so four lines are sixteen entries: the distances between entries give the number of
//! digits of each word, and one comparison checks them all. Then one permutation moves the digits
//! of four lines into place, sixteen bytes for each line: four of x, four of y and eight of the
//! colour, each word's last digit last and `0` before its first (`ff` behind a colour without
//! alpha). 64 digits are checked and weighted together.

use super::Record;
use std::arch::x86_64::*;

/// Largest number of blocks whose separators are listed at once, and the initial one, so that a
/// failure wastes little.
const BLOCKS: usize = 64;
const FIRST_BLOCKS: usize = 8;
const BLOCK: usize = 64;
/// Largest number of separators of a block: plain lines of ten bytes have four.
const MOST: usize = 32;
/// Bytes that are read from the start of four lines on: enough for the longest, of 23 bytes each.
const REACH: usize = 2 * BLOCK;
/// Smallest number of bytes for which this version pays.
pub const LEAST_BYTES: usize = FIRST_BLOCKS * BLOCK + REACH;

/// Returns whether the CPU has the features that this file needs.
#[inline]
pub fn is_there() -> bool {
    is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512vbmi")
        && is_x86_feature_detected!("avx512vbmi2")
        && is_x86_feature_detected!("popcnt")
}

/// Layout of lines with one line end and one number of colour digits.
struct LineForm {
    /// Hex digits of a colour.
    digits: u16,
    /// Last separator: LF, or the CR before it.
    end: u8,
    /// For each of sixteen bytes, the index of the line's separator from which it is counted.
    from: [u8; 16],
    /// Offset of the byte from that separator.
    offset: [i8; 16],
    /// Room of each byte: with n the digits of its word, the byte is present if n + 1 + room is not
    /// negative.
    room: [i8; 16],
    /// Byte to fill in where there is no digit.
    fill: [u8; 16],
}

impl LineForm {
    const fn new(digits: u16, end: u8) -> LineForm {
        let mut form =
            LineForm { digits, end, from: [0; 16], offset: [0; 16], room: [0; 16], fill: [b'0'; 16] };
        let mut j = 0;
        while j < 16 {
            let i = j as i8;
            (form.from[j], form.offset[j], form.room[j]) = match (j, digits) {
                (0..4, _) => (1, i - 4, i - 5),
                (4..8, _) => (2, i - 8, i - 9),
                // One pair of digits for red, green and blue.
                (8..14, 2) => (3, i % 2 - 2, 64),
                (14.., 8) | (8..14, _) => (3, i - 8 - digits as i8, 64),
                _ => {
                    form.fill[j] = b'f';
                    (3, 0, -64)
                }
            };
            j += 1;
        }
        form
    }
}

static LINE_FORMS: [LineForm; 6] = [
    LineForm::new(6, b'\n'),
    LineForm::new(8, b'\n'),
    LineForm::new(2, b'\n'),
    LineForm::new(6, b'\r'),
    LineForm::new(8, b'\r'),
    LineForm::new(2, b'\r'),
];

/// Separators of some blocks: their positions, plus 1 so that the first entry can be the end of the
/// previous line, and their values.
struct Separators {
    places: [u16; BLOCKS * MOST + BLOCK],
    letters: [u8; BLOCKS * MOST + BLOCK],
    count: usize,
}

/// Like [`super::pixel_records`], for as many lines as can be read four at a time.
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512vbmi,avx512vbmi2,popcnt")]
pub fn pixel_records(bytes: &[u8], emit: &mut impl FnMut(&[Record])) -> (usize, u64) {
    let mut separators =
        Separators { places: [0; BLOCKS * MOST + BLOCK], letters: [0; BLOCKS * MOST + BLOCK], count: 0 };
    let mut records = [[0; 8]; BLOCKS * MOST / 4];
    let (mut used, mut lines, mut blocks) = (0, 0, FIRST_BLOCKS);
    loop {
        let rest = &bytes[used..];
        if rest.len() < LEAST_BYTES {
            break;
        }
        separators.find(rest, blocks);
        let form = LINE_FORMS.iter().find(|f| separators.begin_with(f));
        let (taken, count) = form.map_or((0, 0), |f| read(f, rest, &separators, &mut records));
        used += taken;
        lines += count as u64;
        if count > 0 {
            emit(&records[..count]);
        }
        if count < separators.count / 16 * 4 || count == 0 {
            break;
        }
        blocks = (2 * blocks).min(BLOCKS);
    }
    (used, lines)
}

impl Separators {
    /// Lists the separators of the first `blocks` blocks of `bytes`, up to one that no plain line
    /// has.
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512vbmi,avx512vbmi2,popcnt")]
    fn find(&mut self, bytes: &[u8], blocks: usize) {
        let iota = iota();
        // A line begins here, as if after LF.
        let (mut at, mut n, mut is_start, mut is_after_cr) = (0, 0, 1u64, 0u64);
        for block in 0..blocks.min(BLOCKS) {
            // With one byte of lookahead.
            let Some(window) = bytes.get(at..at + BLOCK + 1) else { break };
            let (data, next) = (load(window, 0), load(window, 1));
            let found = _mm512_cmple_epu8_mask(data, _mm512_set1_epi8(b' ' as i8));
            let lf = _mm512_cmpeq_epi8_mask(data, _mm512_set1_epi8(b'\n' as i8));
            let p = _mm512_cmpeq_epi8_mask(data, _mm512_set1_epi8(b'P' as i8));
            let px = _mm512_mask_cmpeq_epi8_mask(p, next, _mm512_set1_epi8(b'X' as i8));
            let starts = lf << 1 | is_start;
            is_start = lf >> 63;
            // CR and LF are one separator.
            let cr = _mm512_cmpeq_epi8_mask(data, _mm512_set1_epi8(b'\r' as i8));
            let lone_cr = _mm512_mask_cmpneq_epi8_mask(cr, next, _mm512_set1_epi8(b'\n' as i8));
            let found = found & !(lf & (cr << 1 | is_after_cr));
            is_after_cr = cr >> 63;
            let count = found.count_ones() as usize;
            if starts & !px | lone_cr != 0 || count > MOST {
                break;
            }
            let places =
                _mm512_cvtepu8_epi16(_mm512_castsi512_si256(_mm512_maskz_compress_epi8(found, iota)));
            let places = _mm512_add_epi16(places, _mm512_set1_epi16((block * BLOCK + 1) as i16));
            let letters = _mm512_castsi512_si256(_mm512_maskz_compress_epi8(found, data));
            let to = self.places[n + 1..].first_chunk_mut::<MOST>().expect("there is room for a block more");
            // SAFETY: 32 numbers of two bytes are as long as the vector.
            unsafe { _mm512_storeu_si512(to.as_mut_ptr().cast(), places) };
            let to = self.letters[n..].first_chunk_mut::<MOST>().expect("there is room for a block more");
            // SAFETY: 32 bytes are as long as the vector.
            unsafe { _mm256_storeu_si256(to.as_mut_ptr().cast(), letters) };
            n += count;
            at += BLOCK;
        }
        self.count = n;
    }

    /// Returns whether the first line's colour and end match the form. If so, adjusts the first
    /// entry to be like all others.
    fn begin_with(&mut self, form: &LineForm) -> bool {
        let is_it = self.count >= 4
            && self.letters[3] == form.end
            && self.places[4].wrapping_sub(self.places[3]) == form.digits + 1;
        self.places[0] = if is_it && form.end == b'\r' { u16::MAX } else { 0 };
        is_it
    }
}

/// Reads four lines at a time while they have that form. Returns the bytes and lines read.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512vbmi,avx512vbmi2,popcnt")]
fn read(form: &LineForm, bytes: &[u8], separators: &Separators, records: &mut [Record]) -> (usize, usize) {
    // For each byte of four lines, the index of its line's first entry; entries have two bytes.
    let line = _mm512_slli_epi16::<3>(_mm512_and_si512(_mm512_srli_epi16::<4>(iota()), _mm512_set1_epi8(3)));
    let from = spread(&form.from);
    let from = _mm512_add_epi8(line, _mm512_add_epi8(from, from));
    let (offset, room, fill) = (spread(&form.offset), spread(&form.room), spread(&form.fill));
    // Smallest distances of a line's separators from those before them, and by how much these may
    // be exceeded.
    let ends = if form.end == b'\r' { 2 } else { 1 };
    let (least, more) = (repeat([2 + ends, 2, 2, form.digits + 1]), repeat([0, 3, 3, 0]));
    let colors = 0xff00_ff00_ff00_ff00;
    let weights = spread(&[10u8, 1, 10, 1, 10, 1, 10, 1, 16, 1, 16, 1, 16, 1, 16, 1]);
    // Hundreds and ones of x and y; red and green, blue and alpha as bytes.
    let pair_weights = _mm512_mask_mov_epi64(
        _mm512_set1_epi64(0x0001_0064_0001_0064),
        0xaa,
        _mm512_set1_epi64(0x0100_0001_0100_0001),
    );
    let wanted_letters = _mm_set1_epi32(i32::from_le_bytes([b' ', b' ', b' ', form.end]));
    let (mut used, mut count) = (0, 0);
    let groups = separators.count / 16;
    for (group, to) in records.as_chunks_mut::<4>().0.iter_mut().enumerate().take(groups) {
        let Some(window) = bytes.get(used..).and_then(|b| b.first_chunk::<REACH>()) else { break };
        let entries = separators.places[16 * group..].first_chunk::<17>().expect("so many were found");
        let letters = separators.letters[16 * group..].first_chunk::<16>().expect("so many were found");
        // SAFETY: sixteen numbers of two bytes, twice, and sixteen bytes are as long as these
        // vectors.
        let (before, places, letters) = unsafe {
            (
                _mm256_loadu_si256(entries.as_ptr().cast()),
                _mm256_loadu_si256(entries[1..].as_ptr().cast()),
                _mm_loadu_si128(letters.as_ptr().cast()),
            )
        };
        let lengths = _mm256_sub_epi16(places, before);
        let are_well = _mm256_cmple_epu16_mask(_mm256_sub_epi16(lengths, least), more)
            & _mm_cmpeq_epi8_mask(letters, wanted_letters);
        if are_well != 0xffff {
            break;
        }
        // Relative to the start of the group; below 92 each.
        let places = _mm256_sub_epi16(places, _mm256_set1_epi16(used as i16 + 1));
        let of_words = _mm512_permutexvar_epi8(from, _mm512_castsi256_si512(places));
        let index = _mm512_add_epi8(of_words, offset);
        let lengths = _mm512_permutexvar_epi8(from, _mm512_castsi256_si512(lengths));
        let is_missing = _mm512_movepi8_mask(_mm512_add_epi8(lengths, room));
        let text = _mm512_permutex2var_epi8(load(window, 0), index, load(window, BLOCK));
        let text = _mm512_mask_mov_epi8(text, is_missing, fill);
        // Decimal digits everywhere, letters in colours alone.
        let decimal = _mm512_sub_epi8(text, _mm512_set1_epi8(b'0' as i8));
        let letter =
            _mm512_sub_epi8(_mm512_or_si512(text, _mm512_set1_epi8(0x20)), _mm512_set1_epi8(b'a' as i8));
        let is_decimal = _mm512_cmple_epu8_mask(decimal, _mm512_set1_epi8(9));
        let is_letter = _mm512_mask_cmple_epu8_mask(colors, letter, _mm512_set1_epi8(5));
        if is_decimal | is_letter != u64::MAX {
            break;
        }
        let values = _mm512_mask_add_epi8(decimal, is_letter, letter, _mm512_set1_epi8(10));
        let pairs = _mm512_maddubs_epi16(values, weights);
        let words = _mm512_cvtepi32_epi16(_mm512_madd_epi16(pairs, pair_weights));
        // SAFETY: four records are as long as the vector.
        unsafe { _mm256_storeu_si256(to.as_mut_ptr().cast(), words) };
        used = usize::from(entries[16] + ends - 1);
        count += 4;
    }
    (used, count)
}

/// Returns 0 to 63.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn iota() -> __m512i {
    static IOTA: [u8; BLOCK] = {
        let mut iota = [0; BLOCK];
        let mut i = 0;
        while i < BLOCK {
            iota[i] = i as u8;
            i += 1;
        }
        iota
    };
    load(&IOTA, 0)
}

/// Repeats sixteen bytes for each of four lines.
#[inline]
#[target_feature(enable = "avx512f")]
fn spread<T: Copy>(bytes: &[T; 16]) -> __m512i {
    const { assert!(size_of::<T>() == 1) };
    // SAFETY: sixteen bytes, of any alignment; any bytes are a vector.
    _mm512_broadcast_i32x4(unsafe { _mm_loadu_si128(bytes.as_ptr().cast()) })
}

/// Repeats four numbers for each of four lines.
#[inline]
#[target_feature(enable = "avx512f")]
fn repeat([a, b, c, d]: [u16; 4]) -> __m256i {
    let [a, b, c, d] = [a, b, c, d].map(u64::from);
    _mm256_set1_epi64x((a | b << 16 | c << 32 | d << 48) as i64)
}

/// Loads 64 bytes from `at` on.
#[inline]
#[target_feature(enable = "avx512f")]
fn load(bytes: &[u8], at: usize) -> __m512i {
    let block: &[u8; BLOCK] = bytes[at..].first_chunk().expect("the callers' windows are long enough");
    // SAFETY: the reference is to 64 bytes, of any alignment.
    unsafe { _mm512_loadu_si512(block.as_ptr().cast()) }
}
