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
use fbptr_core::simd::bytes::{Avx512Bytes, ByteKernel};
use std::arch::x86_64::{__m256i, __m512i};

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

/// Layout of lines with one line end and one number of colour digits.
struct LineForm {
    /// Hex digits of a colour.
    digits: u16,
    /// Last separator: LF, or the CR before it.
    end: u8,
    /// For each of sixteen bytes, the index of the line's separator from which it is counted.
    from: [u8; 16],
    /// Offset of the byte from that separator, signed.
    offset: [u8; 16],
    /// Room of each byte, signed: with n the digits of its word, the byte is present if n + 1 +
    /// room is not negative.
    room: [u8; 16],
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
            let (from, offset, room): (u8, i8, i8) = match (j, digits) {
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
            (form.from[j], form.offset[j], form.room[j]) = (from, offset as u8, room as u8);
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

/// Reads like [`super::pixel_records`], for as many lines as can be read four at a time.
pub struct PixelRecords<'b, 'f, F> {
    pub bytes: &'b [u8],
    pub emit: &'f mut F,
}

impl<F: FnMut(&[Record])> ByteKernel<Avx512Bytes> for PixelRecords<'_, '_, F> {
    type Output = (usize, u64);

    #[inline(always)]
    fn run(self, v: Avx512Bytes) -> (usize, u64) {
        let PixelRecords { bytes, emit } = self;
        let mut separators =
            Separators { places: [0; BLOCKS * MOST + BLOCK], letters: [0; BLOCKS * MOST + BLOCK], count: 0 };
        let mut records = [[0; 8]; BLOCKS * MOST / 4];
        let (mut used, mut lines, mut blocks) = (0, 0, FIRST_BLOCKS);
        loop {
            let rest = &bytes[used..];
            if rest.len() < LEAST_BYTES {
                break;
            }
            separators.find(v, rest, blocks);
            let form = LINE_FORMS.iter().find(|f| separators.begin_with(f));
            let (taken, count) = form.map_or((0, 0), |f| read(v, f, rest, &separators, &mut records));
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
}

impl Separators {
    /// Lists the separators of the first `blocks` blocks of `bytes`, up to one that no plain line
    /// has.
    #[inline(always)]
    fn find(&mut self, v: Avx512Bytes, bytes: &[u8], blocks: usize) {
        let iota = v.load(&IOTA);
        // A line begins here, as if after LF.
        let (mut at, mut n, mut is_start, mut is_after_cr) = (0, 0, 1u64, 0u64);
        for block in 0..blocks.min(BLOCKS) {
            // With one byte of lookahead.
            let Some(window) = bytes.get(at..at + BLOCK + 1) else { break };
            let (data, next) = (load(v, window, 0), load(v, window, 1));
            let found = v._mm512_cmple_epu8_mask(data, v._mm512_set1_epi8(b' ' as i8));
            let lf = v._mm512_cmpeq_epi8_mask(data, v._mm512_set1_epi8(b'\n' as i8));
            let p = v._mm512_cmpeq_epi8_mask(data, v._mm512_set1_epi8(b'P' as i8));
            let px = v._mm512_mask_cmpeq_epi8_mask(p, next, v._mm512_set1_epi8(b'X' as i8));
            let starts = lf << 1 | is_start;
            is_start = lf >> 63;
            // CR and LF are one separator.
            let cr = v._mm512_cmpeq_epi8_mask(data, v._mm512_set1_epi8(b'\r' as i8));
            let lone_cr = v._mm512_mask_cmpneq_epi8_mask(cr, next, v._mm512_set1_epi8(b'\n' as i8));
            let found = found & !(lf & (cr << 1 | is_after_cr));
            is_after_cr = cr >> 63;
            let count = found.count_ones() as usize;
            if starts & !px | lone_cr != 0 || count > MOST {
                break;
            }
            let places =
                v._mm512_cvtepu8_epi16(v._mm512_castsi512_si256(v._mm512_maskz_compress_epi8(found, iota)));
            let places = v._mm512_add_epi16(places, v._mm512_set1_epi16((block * BLOCK + 1) as i16));
            let letters = v._mm512_maskz_compress_epi8(found, data);
            let to = self.places[n + 1..].first_chunk_mut::<MOST>().expect("there is room for a block more");
            v.store_words(to, places);
            let to = self.letters[n..].first_chunk_mut::<MOST>().expect("there is room for a block more");
            v.store_lower(to, letters);
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
#[inline(always)]
fn read(
    v: Avx512Bytes,
    form: &LineForm,
    bytes: &[u8],
    separators: &Separators,
    records: &mut [Record],
) -> (usize, usize) {
    // For each byte of four lines, the index of its line's first entry; entries have two bytes.
    let line =
        v.shift_left::<3>(v._mm512_and_si512(v.shift_right::<4>(v.load(&IOTA)), v._mm512_set1_epi8(3)));
    let from = v.repeat_16(&form.from);
    let from = v._mm512_add_epi8(line, v._mm512_add_epi8(from, from));
    let (offset, room, fill) = (v.repeat_16(&form.offset), v.repeat_16(&form.room), v.repeat_16(&form.fill));
    // Smallest distances of a line's separators from those before them, and by how much these may
    // be exceeded.
    let ends = if form.end == b'\r' { 2 } else { 1 };
    let (least, more) = (repeat(v, [2 + ends, 2, 2, form.digits + 1]), repeat(v, [0, 3, 3, 0]));
    let colors = 0xff00_ff00_ff00_ff00;
    let weights = v.repeat_16(&[10, 1, 10, 1, 10, 1, 10, 1, 16, 1, 16, 1, 16, 1, 16, 1]);
    // Hundreds and ones of x and y; red and green, blue and alpha as bytes.
    let pair_weights = v._mm512_mask_mov_epi64(
        v._mm512_set1_epi64(0x0001_0064_0001_0064),
        0xaa,
        v._mm512_set1_epi64(0x0100_0001_0100_0001),
    );
    let wanted_letters = v._mm_set1_epi32(i32::from_le_bytes([b' ', b' ', b' ', form.end]));
    let (mut used, mut count) = (0, 0);
    let groups = separators.count / 16;
    for (group, to) in records.as_chunks_mut::<4>().0.iter_mut().enumerate().take(groups) {
        let Some(window) = bytes.get(used..).and_then(|b| b.first_chunk::<REACH>()) else { break };
        let entries = separators.places[16 * group..].first_chunk::<17>().expect("so many were found");
        let letters = separators.letters[16 * group..].first_chunk::<16>().expect("so many were found");
        let before = v.load_words(entries.first_chunk().expect("there are 17"));
        let places = v.load_words(entries.last_chunk().expect("there are 17"));
        let letters = v.load_16(letters);
        let lengths = v._mm256_sub_epi16(places, before);
        let are_well = v._mm256_cmple_epu16_mask(v._mm256_sub_epi16(lengths, least), more)
            & v._mm_cmpeq_epi8_mask(letters, wanted_letters);
        if are_well != 0xffff {
            break;
        }
        // Relative to the start of the group; below 92 each.
        let places = v._mm256_sub_epi16(places, v._mm256_set1_epi16(used as i16 + 1));
        let of_words = v._mm512_permutexvar_epi8(from, v._mm512_castsi256_si512(places));
        let index = v._mm512_add_epi8(of_words, offset);
        let lengths = v._mm512_permutexvar_epi8(from, v._mm512_castsi256_si512(lengths));
        let is_missing = v._mm512_movepi8_mask(v._mm512_add_epi8(lengths, room));
        let text = v._mm512_permutex2var_epi8(load(v, window, 0), index, load(v, window, BLOCK));
        let text = v._mm512_mask_mov_epi8(text, is_missing, fill);
        // Decimal digits everywhere, letters in colours alone.
        let decimal = v._mm512_sub_epi8(text, v._mm512_set1_epi8(b'0' as i8));
        let letter = v._mm512_sub_epi8(
            v._mm512_or_si512(text, v._mm512_set1_epi8(0x20)),
            v._mm512_set1_epi8(b'a' as i8),
        );
        let is_decimal = v._mm512_cmple_epu8_mask(decimal, v._mm512_set1_epi8(9));
        let is_letter = v._mm512_mask_cmple_epu8_mask(colors, letter, v._mm512_set1_epi8(5));
        if is_decimal | is_letter != u64::MAX {
            break;
        }
        let values = v._mm512_mask_add_epi8(decimal, is_letter, letter, v._mm512_set1_epi8(10));
        let pairs = v._mm512_maddubs_epi16(values, weights);
        let words = v._mm512_cvtepi32_epi16(v._mm512_madd_epi16(pairs, pair_weights));
        v.store_records(to, words);
        used = usize::from(entries[16] + ends - 1);
        count += 4;
    }
    (used, count)
}

/// 0 to 63.
static IOTA: [u8; BLOCK] = {
    let mut iota = [0; BLOCK];
    let mut i = 0;
    while i < BLOCK {
        iota[i] = i as u8;
        i += 1;
    }
    iota
};

/// Repeats four numbers for each of four lines.
#[inline(always)]
fn repeat(v: Avx512Bytes, [a, b, c, d]: [u16; 4]) -> __m256i {
    let [a, b, c, d] = [a, b, c, d].map(u64::from);
    v._mm256_set1_epi64x((a | b << 16 | c << 32 | d << 48) as i64)
}

/// Loads 64 bytes from `at` on.
#[inline(always)]
fn load(v: Avx512Bytes, bytes: &[u8], at: usize) -> __m512i {
    v.load(bytes[at..].first_chunk().expect("the callers' windows are long enough"))
}
