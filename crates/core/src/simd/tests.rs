//! Each operation of each level compared, bit by bit, with that on plain arrays of as many lanes.

use super::pair::Paired;
use super::*;
use proptest::prelude::*;

/// Inputs of one trial: 16 floats, 16 more, 16 ints, 16 more, mask bits.
#[derive(Clone, Debug)]
struct Input {
    a: [f32; 16],
    b: [f32; 16],
    i: [i32; 16],
    j: [i32; 16],
    bits: u32,
}

/// Tables that the gathers read.
struct Tables {
    floats: Vec<f32>,
    records: Vec<[f32; 4]>,
    shorts: Vec<[u16; 4]>,
    bytes: Vec<u8>,
}

impl Tables {
    fn new() -> Tables {
        let short = |k: u32| ((k * 40_503) >> 4) as u16;
        Tables {
            floats: (0..64).map(|k| k as f32 * 1.5).collect(),
            records: (0..64).map(|k| [k as f32, -(k as f32), 0.5, k as f32 * 3.0]).collect(),
            shorts: (0..65).map(|k| [4 * k, 4 * k + 1, 4 * k + 2, 4 * k + 3].map(short)).collect(),
            bytes: (0..260u32).map(|k| (k * 151) as u8).collect(),
        }
    }
}

/// Vectors of one part of the input, as many lanes as the level has.
struct Part<S: Simd> {
    s: S,
    x: S::F,
    y: S::F,
    p: S::I,
    q: S::I,
    m: S::M,
}

impl<S: Simd> Part<S> {
    #[inline(always)]
    fn new(s: S, input: &Input, at: usize) -> Self {
        Part {
            s,
            x: s.load(&input.a[at..]),
            y: s.load(&input.b[at..]),
            p: s.load_i(&input.i[at..]),
            q: s.load_i(&input.j[at..]),
            m: s.mask(input.bits >> at),
        }
    }

    /// Returns the lanes of a vector.
    #[inline(always)]
    fn lanes(&self, v: S::I) -> Vec<i32> {
        let mut lanes = vec![0; S::LANES];
        self.s.store_i(v, &mut lanes);
        lanes
    }

    /// Pushes the results of the operations that give floats.
    #[inline(always)]
    fn floats(&self, first: f32, out: &mut Vec<Vec<i32>>) {
        let Part { s, x, y, p, m, .. } = *self;
        let floats = [x + y, x - y, x * y, x / y, -x, x.sqrt(), x.floor(), x.abs(), x.min(y), x.max(y)];
        let more = [s.select(m, x, y), p.to_f32(), p.as_f32(), s.splat(first)];
        for f in floats.into_iter().chain(more) {
            // A NaN's payload depends on the machine: only that it is a NaN is compared.
            let canonical = s.select(f.lt(f) | f.le(f), f, s.splat(f32::NAN));
            out.push(self.lanes(canonical.bits()));
        }
    }

    /// Pushes what the gathers and the lookup read.
    #[inline(always)]
    fn gathers(&self, tables: &Tables, out: &mut Vec<Vec<i32>>) {
        let Part { s, p, m, .. } = *self;
        let index = s.select_i(m, p & s.splat_i(63), s.splat_i(-1));
        for v in s.gather_pairs(m, &tables.shorts, index) {
            out.push(self.lanes(v));
        }
        for v in s.gather_byte_pairs(m, &tables.bytes, index) {
            out.push(self.lanes(v));
        }
        for v in s.gather4(m, &tables.records, index) {
            out.push(self.lanes(v.bits()));
        }
        out.push(self.lanes(s.gather_bytes(m, &tables.bytes, index)));
        out.push(self.lanes(s.gather(m, &tables.floats, index).bits()));
        out.push(self.lanes(s.lookup(&[3, 1, 4, -1, 5, i32::MIN, 2, 6], p)));
    }

    /// Pushes the results of the operations that give ints.
    #[inline(always)]
    fn ints(&self, at: usize, out: &mut Vec<Vec<i32>>) {
        let Part { s, x, p, q, m, .. } = *self;
        let arithmetic = [p + q, p - q, p * q, p & q, p | q, p ^ q, p.min(q), p.max(q)];
        let shifts = [p.shl::<0>(), p.shl::<7>(), p.sar::<9>(), p.sar::<31>(), p.shr::<3>()];
        let others = [x.to_i32(), s.select_i(m, p, q), s.increment(m, p), s.iota() + s.splat_i(at as i32)];
        for v in arithmetic.into_iter().chain(shifts).chain(others) {
            out.push(self.lanes(v));
        }
    }

    /// Pushes the results of the comparisons and of the masks' operators.
    #[inline(always)]
    fn masks(&self, out: &mut Vec<Vec<i32>>) {
        let Part { s, x, y, p, q, m } = *self;
        for mask in [x.lt(y), x.le(y), p.eq(q), p.gt(q), m & x.lt(y), m | p.gt(q), !m] {
            out.push(self.lanes(s.select_i(mask, s.splat_i(-1), s.splat_i(0))));
            let lane_bits = (0..S::LANES as u32).fold(0, |n, k| n | (mask.bits() & 1 << k));
            assert_eq!(s.mask(lane_bits).bits(), lane_bits);
        }
    }

    /// Pushes what the masked stores write.
    #[inline(always)]
    fn masked_stores(&self, out: &mut Vec<Vec<i32>>) {
        let Part { s, p, q, m, .. } = *self;
        let mut masked = vec![5; S::LANES];
        s.store_masked_i(m, p, &mut masked);
        out.push(masked);
        let mut bytes = vec![7u8; S::LANES * 4];
        s.store_masked_bytes(m, q, &mut bytes);
        let loaded = self.lanes(s.load_bytes(&bytes));
        assert_eq!(bytes, loaded.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<u8>>());
        out.push(loaded);
    }

    /// Checks the operations whose results depend on the width against plain loops.
    #[inline(always)]
    fn check_across_lanes(&self) {
        let Part { s, p, q, m, .. } = *self;
        // Few different numbers, so that some recur.
        let few = p & s.splat_i(3);
        let numbers = self.lanes(few);
        let is_set = |k: usize| m.bits() >> k & 1 != 0;
        let is_first = |k: &usize| is_set(*k) && !(0..*k).any(|e| is_set(e) && numbers[e] == numbers[*k]);
        let firsts = (0..S::LANES).filter(is_first).fold(0, |bits, k| bits | 1 << k);
        assert_eq!(s.first_occurrences(m, few).bits(), firsts);
        let zipped = s.zip(p, q).map(|half| self.lanes(half)).concat();
        let in_turn = self.lanes(p).into_iter().zip(self.lanes(q)).flat_map(|(p, q)| [p, q]);
        assert!(in_turn.eq(zipped));
    }
}

/// Checks the stores and loads of blocks of four columns that make up 4x4, in an array of stride 5.
#[inline(always)]
fn check_blocks<S: Simd>(s: S, input: &Input) {
    let field: Vec<i32> = input.i.iter().chain(&input.j).copied().collect();
    let mut drawn = [7u8; 20 * 4];
    for at in (0..16).step_by(S::LANES) {
        let row = at / 4;
        let block = s.load_block(&field[row * 5..], 5);
        let m = s.mask(input.bits >> at);
        s.store_block_bytes(m, block, &mut drawn[row * 20..], 5);
        // Rows that the mask leaves out are not accessed.
        s.store_block_bytes(s.mask(0), block, &mut [], 5);
    }
    let drawn: Vec<i32> = drawn.as_chunks().0.iter().map(|b| i32::from_le_bytes(*b)).collect();
    for (k, word) in drawn.iter().enumerate() {
        let (row, column) = (k / 5, k % 5);
        let is_set = column < 4 && input.bits >> (row * 4 + column) & 1 == 1;
        assert_eq!(*word, if is_set { field[k] } else { 0x0707_0707 }, "pixel {k} of a block");
    }
}

/// Returns the set lanes packed, as numbers and as records, then the smallest and the largest lane.
#[inline(always)]
fn packed<S: Simd>(s: S, Input { i, j, bits, .. }: &Input) -> Vec<i32> {
    let mut packed = Vec::new();
    for at in (0..16).step_by(S::LANES) {
        let mut lanes = vec![0; S::LANES];
        let n = s.compress_i(s.mask(bits >> at), s.load_i(&i[at..]), &mut lanes);
        packed.extend_from_slice(&lanes[..n]);
    }
    // Records: for each width, those of the set lanes in order, then zeros.
    let mut least = (i32::MAX, i32::MIN);
    for at in (0..16).step_by(S::LANES) {
        let (p, q) = (s.load_i(&i[at..]), s.load_i(&j[at..]));
        least = (least.0.min(p.reduce_min()), least.1.max(p.reduce_max()));
        let mut records = [[5; 8]; 17];
        let fields = [p, q, p + q, p ^ q, p & q, p | q, p - q, p * q];
        let n = s.compress8(s.mask(bits >> at), fields, &mut records);
        packed.extend(records[..n].iter().flatten());
        assert!(records[n..S::LANES].iter().all(|r| *r == [0; 8]) && records[16] == [5; 8]);
    }
    packed.extend([least.0, least.1]);
    packed
}

/// Results of every operation, as words, over all 16 lanes (8-lane levels run twice).
struct AllOperations(Input);

impl Kernel for AllOperations {
    type Output = Vec<i32>;
    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Vec<i32> {
        let input = &self.0;
        let tables = Tables::new();
        let mut parts: Vec<Vec<i32>> = Vec::new();
        for at in (0..16).step_by(S::LANES) {
            let part = Part::new(s, input, at);
            part.floats(input.a[0], &mut parts);
            part.gathers(&tables, &mut parts);
            part.ints(at, &mut parts);
            part.masks(&mut parts);
            part.masked_stores(&mut parts);
            part.check_across_lanes();
        }
        check_blocks(s, input);
        // Lane-major order: the parts of an 8-lane level interleave to what 16 lanes give.
        let per_part = parts.len() * S::LANES / 16;
        let mut words: Vec<i32> =
            (0..per_part).flat_map(|k| parts.iter().skip(k).step_by(per_part).flatten().copied()).collect();
        words.extend(packed(s, input));
        words
    }
}

/// Units of the levels of kernels that pairs are tried with.
mod all_operations {
    crate::simd::long_kernel!(super::AllOperations);
}
mod outside {
    crate::simd::long_kernel!(super::Outside);
}
mod inside {
    crate::simd::long_kernel!(super::Inside);
}

fn odd_float() -> impl Strategy<Value = f32> {
    let special =
        [0.0, -0.0, 1.0, -0.5, 0.99999994, 8388607.5, -8388608.5, 2147483648.0, -2147483648.0, 1e-40];
    prop_oneof![
        any::<f32>(),
        -100.0f32..100.0,
        prop::sample::select(special.to_vec()),
        prop::sample::select(vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN_POSITIVE]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]
    #[test]
    fn every_level_gives_the_bits_of_plain_arrays(
        a in prop::array::uniform16(odd_float()),
        b in prop::array::uniform16(odd_float()),
        i in prop::array::uniform16(any::<i32>()),
        j in prop::array::uniform16(prop_oneof![any::<i32>(), -3..3i32]),
        bits in 0u32..65536,
    ) {
        let input = Input { a, b, i, j, bits };
        let truth = AllOperations(input.clone()).run(Portable::<16>);
        prop_assert_eq!(&AllOperations(input.clone()).run(Portable::<8>), &truth);
        prop_assert_eq!(&AllOperations(input.clone()).run(Paired(Portable::<4>)), &truth);
        prop_assert_eq!(&AllOperations(input.clone()).run(Paired(Portable::<8>)), &truth);
        for level in Level::ALL {
            prop_assert_eq!(&level.dispatch(AllOperations(input.clone())), &truth, "{:?}", level);
            prop_assert_eq!(&level.dispatch_long(AllOperations(input.clone())), &truth, "{:?}", level);
        }
        for pairs in [false, true] {
            let found = long(pairs, || Level::Avx2.dispatch_long(AllOperations(input.clone())));
            prop_assert_eq!(&found, &truth, "pairs: {}", pairs);
        }
    }
}

/// Calls `work` with or without pairs of AVX2's vectors, where there are any.
fn long<T>(pairs: bool, work: impl FnOnce() -> T) -> T {
    #[cfg(target_arch = "x86_64")]
    return with_pairs(pairs, work);
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = pairs;
        work()
    }
}

/// A call that must panic, by number.
struct Outside(usize);

impl Outside {
    const CALLS: usize = 16;
}

impl Kernel for Outside {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let (all, none, last) = (s.mask(u32::MAX), s.mask(0), s.mask(1 << (S::LANES - 1)));
        let (numbers, mut kept) = (vec![1.0; S::LANES - 1], vec![1; S::LANES - 1]);
        let (zero, two, from_one) = (s.splat_i(0), s.splat_i(2), s.iota() + s.splat_i(1));
        match self.0 {
            // Behind the last element, or record, or the last one where a pair is read.
            0 => drop(s.gather(last, &vec![1.0; S::LANES], from_one)),
            1 => drop(s.gather_bytes(last, &vec![1; 4 * S::LANES], from_one)),
            2 => drop(s.gather4(all, &[[0.0; 4]; 2], two)),
            3 => drop(s.gather_pairs(all, &[[0; 4]; 3], two)),
            4 => drop(s.gather_byte_pairs(all, &[0; 12], two)),
            5 => drop(s.gather(all, &[1.0; 4], s.splat_i(-1))),
            // No record for the unset lanes.
            6 => drop(s.gather4(none, &[], zero)),
            7 => drop(s.gather_pairs(none, &[[0; 4]; 1], zero)),
            8 => drop(s.gather_byte_pairs(none, &[0; 4], zero)),
            // A slice that is too short for a vector.
            9 => drop(s.load(&numbers)),
            10 => drop(s.load_i(&kept)),
            11 => drop(s.load_bytes(&vec![0; 4 * S::LANES - 1])),
            12 => s.store_i(two, &mut kept),
            13 => s.store_masked_bytes(all, two, &mut vec![0; 4 * S::LANES - 1]),
            14 => drop(s.compress_i(all, two, &mut kept)),
            _ => drop(s.compress8(all, [two; 8], &mut vec![[0; 8]; S::LANES - 1])),
        }
    }
}

/// Gathers that read nothing outside: the last element, and none of an empty slice.
struct Inside;

impl Kernel for Inside {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let from_one = s.iota() + s.splat_i(1);
        let lanes = |v: S::I| {
            let mut lanes = vec![0; S::LANES];
            s.store_i(v, &mut lanes);
            lanes
        };
        let numbers: Vec<f32> = (0..=S::LANES).map(|i| i as f32).collect();
        assert_eq!(lanes(s.gather(s.mask(u32::MAX), &numbers, from_one).to_i32()), lanes(from_one));
        assert_eq!(lanes(s.gather(s.mask(0), &[], from_one).bits()), lanes(s.splat_i(0)));
        assert_eq!(lanes(s.gather_bytes(s.mask(0), &[], from_one)), lanes(s.splat_i(0)));
    }
}

#[test]
#[cfg_attr(not(panic = "unwind"), ignore = "a panic ends the program")]
fn what_would_read_or_write_outside_its_slice_panics() {
    for level in Level::ALL {
        for call in 0..Outside::CALLS {
            let outcome = std::panic::catch_unwind(|| level.dispatch(Outside(call)));
            assert!(outcome.is_err(), "{level:?}, call {call}");
        }
    }
    for pairs in [false, true] {
        for call in 0..Outside::CALLS {
            let work = || std::panic::catch_unwind(|| Level::Avx2.dispatch_long(Outside(call)));
            assert!(long(pairs, work).is_err(), "pairs: {pairs}, call {call}");
        }
    }
}

#[test]
fn gathers_reach_the_last_element_and_need_none_where_no_lane_is_set() {
    for level in Level::ALL {
        level.dispatch(Inside);
    }
    for pairs in [false, true] {
        long(pairs, || Level::Avx2.dispatch_long(Inside));
    }
}

#[test]
fn levels_have_names_and_the_best_one_is_available() {
    for level in Level::ALL {
        assert_eq!(Level::from_name(level.as_str()), Some(level));
    }
    assert!(Level::best().is_available() && Level::Portable.is_available());
    assert_eq!(Level::from_name("mmx"), None);
}
