//! Each operation of each level compared, bit by bit, with that on plain arrays of as many lanes.

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

/// Results of every operation, as words, over all 16 lanes (8-lane levels run twice).
struct AllOperations(Input);

impl Kernel for AllOperations {
    type Output = Vec<i32>;
    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Vec<i32> {
        let Input { a, b, i, j, bits } = self.0;
        let table_f: Vec<f32> = (0..64).map(|k| k as f32 * 1.5).collect();
        let records: Vec<[f32; 4]> = (0..64).map(|k| [k as f32, -(k as f32), 0.5, k as f32 * 3.0]).collect();
        let short = |k: u32| ((k * 40_503) >> 4) as u16;
        let shorts: Vec<[u16; 4]> =
            (0..65).map(|k| [4 * k, 4 * k + 1, 4 * k + 2, 4 * k + 3].map(short)).collect();
        let bytes: Vec<u8> = (0..260u32).map(|k| (k * 151) as u8).collect();
        let mut parts: Vec<Vec<i32>> = Vec::new();
        for at in (0..16).step_by(S::LANES) {
            let (x, y) = (s.load(&a[at..]), s.load(&b[at..]));
            let (p, q) = (s.load_i(&i[at..]), s.load_i(&j[at..]));
            let m = s.mask(bits >> at);
            let floats = [x + y, x - y, x * y, x / y, -x, x.sqrt(), x.floor(), x.abs(), x.min(y), x.max(y)];
            let more = [s.select(m, x, y), p.to_f32(), p.as_f32(), s.splat(a[0])];
            let index = s.select_i(m, p & s.splat_i(63), s.splat_i(-1));
            let gathered = s.gather4(m, &records, index);
            let mut out = Vec::new();
            let mut push = |v: S::I| {
                let mut lanes = vec![0; S::LANES];
                s.store_i(v, &mut lanes);
                out.push(lanes);
            };
            for f in floats.into_iter().chain(more) {
                // A NaN's payload depends on the machine: only that it is a NaN is compared.
                let canonical = s.select(f.lt(f) | f.le(f), f, s.splat(f32::NAN));
                push(canonical.bits());
            }
            let pairs = (s.gather_pairs(m, &shorts, index), s.gather_byte_pairs(m, &bytes, index));
            pairs.0.into_iter().chain(pairs.1).for_each(|v| push(s.select_i(m, v, s.splat_i(0))));
            gathered.into_iter().for_each(|v| push(s.select(m, v, s.splat(0.0)).bits()));
            let ints = [
                p + q,
                p - q,
                p * q,
                p & q,
                p | q,
                p ^ q,
                p.min(q),
                p.max(q),
                x.to_i32(),
                s.select_i(m, p, q),
            ];
            ints.into_iter().for_each(&mut push);
            [p.shl::<0>(), p.shl::<7>(), p.sar::<9>(), p.sar::<31>(), p.shr::<3>()]
                .into_iter()
                .for_each(&mut push);
            push(s.gather(m, &table_f, index).bits());
            push(s.lookup(&[3, 1, 4, -1, 5, i32::MIN, 2, 6], p));
            push(s.iota() + s.splat_i(at as i32));
            // Few different numbers, so that some recur; which ones come first depends on the
            // width.
            let few = p & s.splat_i(3);
            let mut numbers = vec![0; S::LANES];
            s.store_i(few, &mut numbers);
            let is_set = |k: usize| m.bits() >> k & 1 != 0;
            let is_first = |k: &usize| is_set(*k) && !(0..*k).any(|e| is_set(e) && numbers[e] == numbers[*k]);
            let firsts = (0..S::LANES).filter(is_first).fold(0, |bits, k| bits | 1 << k);
            assert_eq!(s.first_occurrences(m, few).bits(), firsts);
            let mut zipped = vec![0; 2 * S::LANES];
            for (half, to) in s.zip(p, q).into_iter().zip(zipped.chunks_mut(S::LANES)) {
                s.store_i(half, to);
            }
            let in_turn = i[at..].iter().zip(&j[at..]).flat_map(|(p, q)| [*p, *q]);
            assert!(in_turn.take(2 * S::LANES).eq(zipped));
            for mask in [x.lt(y), x.le(y), p.eq(q), p.gt(q), m & x.lt(y), m | p.gt(q), !m] {
                push(s.select_i(mask, s.splat_i(-1), s.splat_i(0)));
                let lane_bits = (0..S::LANES as u32).fold(0, |n, k| n | (mask.bits() & 1 << k));
                assert_eq!(s.mask(lane_bits).bits(), lane_bits);
            }
            let mut masked = vec![5; S::LANES];
            s.store_masked_i(m, p, &mut masked);
            out.push(masked);
            let mut bytes = vec![7u8; S::LANES * 4];
            s.store_masked_bytes(m, q, &mut bytes);
            let mut loaded = vec![0; S::LANES];
            s.store_i(s.load_bytes(&bytes), &mut loaded);
            assert_eq!(bytes, loaded.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<u8>>());
            out.push(loaded);
            parts.extend(out);
        }
        // Blocks of four columns that make up 4x4, in an array of stride 5.
        let field: Vec<i32> = i.iter().chain(&j).copied().collect();
        let mut drawn = [7u8; 20 * 4];
        for at in (0..16).step_by(S::LANES) {
            let row = at / 4;
            let block = s.load_block(&field[row * 5..], 5);
            let m = s.mask(bits >> at);
            s.store_block_bytes(m, block, &mut drawn[row * 20..], 5);
            // Rows that the mask leaves out are not accessed.
            s.store_block_bytes(s.mask(0), block, &mut [], 5);
        }
        let drawn: Vec<i32> = drawn.as_chunks().0.iter().map(|b| i32::from_le_bytes(*b)).collect();
        for (k, word) in drawn.iter().enumerate() {
            let (row, column) = (k / 5, k % 5);
            let is_set = column < 4 && bits >> (row * 4 + column) & 1 == 1;
            assert_eq!(*word, if is_set { field[k] } else { 0x0707_0707 }, "pixel {k} of a block");
        }
        // Lane-major order: the parts of an 8-lane level interleave to what 16 lanes give.
        let per_part = parts.len() * S::LANES / 16;
        let mut words: Vec<i32> =
            (0..per_part).flat_map(|k| parts.iter().skip(k).step_by(per_part).flatten().copied()).collect();
        let mut packed = Vec::new();
        for at in (0..16).step_by(S::LANES) {
            let mut lanes = vec![0; S::LANES];
            let n = s.compress_i(s.mask(bits >> at), s.load_i(&i[at..]), &mut lanes);
            packed.extend_from_slice(&lanes[..n]);
        }
        // Records: whatever the width, those of the set lanes in order, then zeros.
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
        words.extend(packed);
        words
    }
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
        for level in Level::ALL {
            prop_assert_eq!(&level.dispatch(AllOperations(input.clone())), &truth, "{:?}", level);
        }
    }
}

struct GatherOutside;

impl Kernel for GatherOutside {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let index = s.iota() + s.splat_i(1);
        let fits: Vec<f32> = vec![1.0; S::LANES + 1];
        s.gather(s.mask(u32::MAX), &fits, index);
        s.gather(s.mask(0), &[], index);
        let short: Vec<f32> = vec![1.0; S::LANES];
        s.gather(s.mask(1 << (S::LANES - 1)), &short, index);
    }
}

/// Gathers in each lane the last record, which has no successor.
struct PairOutside;

impl Kernel for PairOutside {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let all = s.mask(u32::MAX);
        s.gather_pairs(all, &[[0; 4]; 3], s.splat_i(2));
    }
}

/// Gathers in each lane the last pixel, which has no successor.
struct BytePairOutside;

impl Kernel for BytePairOutside {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let all = s.mask(u32::MAX);
        s.gather_byte_pairs(all, &[0; 12], s.splat_i(2));
    }
}

#[test]
fn a_gather_outside_its_slice_panics_instead_of_reading() {
    for level in Level::ALL {
        assert!(std::panic::catch_unwind(|| level.dispatch(PairOutside)).is_err(), "{level:?}");
        assert!(std::panic::catch_unwind(|| level.dispatch(BytePairOutside)).is_err(), "{level:?}");
        let outcome = std::panic::catch_unwind(|| level.dispatch(GatherOutside));
        assert!(outcome.is_err(), "{level:?}");
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
