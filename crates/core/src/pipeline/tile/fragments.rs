//! Fragments of the smallest faces, which cover one or two pixels as most faces of a fine mesh do:
//! each pixel with its depth.
//!
//! The result is exactly that of drawing the face: equal pixels, equal sums for their depths, in
//! file order. A list of fragments is drawn by comparing and storing, without evaluating a face's
//! coverage; a fragment lies in one tile only. Depth formats that are evaluated in f64 compute the
//! depth from the face.

use super::list_bytes::ListBytes;
use super::tile_buffers::NO_FACE;
use crate::simd::{F32, I32, Mask, Simd};

/// Vector of fragments, in file order of their faces.
#[derive(Clone, Copy)]
pub struct Fragments<S: Simd> {
    /// Pixel: column in the low half, row in the high half.
    pub at: S::I,
    /// Depth word.
    pub z: S::I,
    /// Index of the triangle in the mesh; [`NO_FACE`] for unused lanes.
    pub face: S::I,
}

/// Fragments of a tile.
#[derive(Debug, Default)]
pub struct FragmentList {
    // Pixels, depth words and faces, each with room behind the last element.
    lists: [Vec<i32>; 3],
    count: usize,
}

impl FragmentList {
    /// Returns the number of fragments.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Returns whether there are no fragments.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Appends the set lanes of a vector.
    #[inline(always)]
    pub fn add<S: Simd>(&mut self, s: S, lanes: S::M, fragments: &Fragments<S>, bytes: &ListBytes) {
        let end = self.count + S::LANES;
        let [at, z, face] = &mut self.lists;
        if face.len() < end {
            for list in [&mut *at, &mut *z, &mut *face] {
                bytes.lengthen(list, end, 0);
            }
        }
        s.compress_i(lanes, fragments.at, &mut at[self.count..]);
        s.compress_i(lanes, fragments.z, &mut z[self.count..]);
        self.count += s.compress_i(lanes, fragments.face, &mut face[self.count..]);
    }

    /// Returns pixel, depth word and face of the fragments in `range`.
    #[inline(always)]
    pub fn some(&self, range: std::ops::Range<usize>) -> impl Iterator<Item = [i32; 3]> {
        let [at, z, face] = self.lists.each_ref().map(|list| &list[range.clone()]);
        at.iter().zip(z).zip(face).map(|((at, z), face)| [*at, *z, *face])
    }

    /// Removes all fragments; the allocations are reused.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Returns the capacity in bytes.
    pub fn size_bytes(&self) -> usize {
        self.lists.iter().map(|list| list.capacity() * size_of::<i32>()).sum()
    }
}

/// Returns the lanes that have at most two pixels, all in the first four rows of their boxes.
#[inline(always)]
pub(super) fn has_few<S: Simd>(s: S, (low, high): (S::I, S::I)) -> S::M {
    let second = low & (low - s.splat_i(1));
    ((second & (second - s.splat_i(1))) | high).eq(s.splat_i(0))
}

/// Returns the fragments of such faces, where `faces` is set: of their first pixels, or of both,
/// face by face, and the number of vectors.
///
/// `word` is the low half of their coverage, `first` the box's first column and row in one word,
/// `depth` the depth at that pixel and its steps.
#[inline(always)]
pub(super) fn of<S: Simd>(
    s: S,
    faces: S::M,
    numbers: S::I,
    word: S::I,
    first: S::I,
    depth: [S::F; 3],
) -> ([Fragments<S>; 2], usize) {
    let none = s.splat_i(NO_FACE);
    let second = word & (word - s.splat_i(1));
    let mut a = at_bit(s, word ^ second, first, depth);
    a.face = s.select_i(faces, numbers, none);
    let has_second = faces & !second.eq(s.splat_i(0));
    if !has_second.any() {
        return ([a, a], 1);
    }
    let mut b = at_bit(s, second, first, depth);
    b.face = s.select_i(has_second, numbers, none);
    let (at, z, face) = (s.zip(a.at, b.at), s.zip(a.z, b.z), s.zip(a.face, b.face));
    ([Fragments { at: at[0], z: z[0], face: face[0] }, Fragments { at: at[1], z: z[1], face: face[1] }], 2)
}

/// Returns the fragments at the pixels of one set bit each, with the sums that drawing their faces
/// would use.
#[inline(always)]
fn at_bit<S: Simd>(s: S, bit: S::I, first: S::I, [z0, zx, zy]: [S::F; 3]) -> Fragments<S> {
    // The exponent of a power of two is the index of its bit.
    let number = (bit.to_f32().bits().shr::<23>() & s.splat_i(0xff)) - s.splat_i(127);
    let (row, column) = (number.shr::<3>(), number & s.splat_i(7));
    let z = (z0 + zy * row.to_f32()) + zx * column.to_f32();
    Fragments {
        at: first + (column | row.shl::<16>()),
        z: z.bits().max(s.splat_i(0)),
        face: s.splat_i(NO_FACE),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Kernel, Level};

    /// Faces of one or two pixels: set lanes, coverage, depth and steps.
    struct Faces {
        live: u32,
        words: [i32; 16],
        depth: [[f32; 16]; 3],
    }

    impl Kernel for &Faces {
        /// Pixel, depth word and face of each fragment, as a list holds them.
        type Output = Vec<[i32; 3]>;
        #[inline(always)]
        fn run<S: Simd>(self, s: S) -> Vec<[i32; 3]> {
            let mut list = FragmentList::default();
            for start in (0..16).step_by(S::LANES) {
                let lanes = s.iota() + s.splat_i(start as i32);
                let depth = self.depth.each_ref().map(|d| s.load(&d[start..]));
                let word = s.load_i(&self.words[start..]);
                assert!(!(!has_few(s, (word, s.splat_i(0)))).any());
                let first = (lanes * s.splat_i(5)) | (s.splat_i(300) - lanes).shl::<16>();
                let (vectors, count) =
                    of(s, s.mask(self.live >> start), lanes + s.splat_i(1000), word, first, depth);
                for vector in &vectors[..count] {
                    list.add(s, vector.face.gt(s.splat_i(NO_FACE)), vector, &ListBytes::default());
                }
            }
            list.some(0..list.len()).collect()
        }
    }

    /// Returns pseudorandom numbers that repeat in every run.
    fn noise(state: &mut u32) -> u32 {
        *state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        *state >> 8
    }

    #[test]
    fn fragments_are_a_faces_pixels_in_file_order_with_its_depths() {
        let mut state = 7;
        for round in 0..400u32 {
            // Every bit occurs, alone and with others; all rounds but the first leave some lanes
            // out.
            let faces = Faces {
                live: if round == 0 { u32::MAX } else { noise(&mut state) },
                words: std::array::from_fn(|i| {
                    let first = 1 << ((round + i as u32) & 31);
                    let second = 1 << (noise(&mut state) & 31);
                    if round & 1 == 0 { first } else { first | second }
                }),
                depth: std::array::from_fn(|k| {
                    std::array::from_fn(|_| noise(&mut state) as f32 * 6e-8 - [0.1, 0.5, 0.5][k])
                }),
            };
            let mut expected = Vec::new();
            for i in (0..16).filter(|i| faces.live >> i & 1 == 1) {
                for bit in (0..32).filter(|bit| faces.words[i] >> bit & 1 == 1) {
                    let (row, column) = (bit >> 3, bit & 7);
                    let [z0, zx, zy] = faces.depth.map(|d| d[i]);
                    let z = (z0 + zy * row as f32) + zx * column as f32;
                    let i = i as i32;
                    let at = (5 * i + column) | (300 - i + row) << 16;
                    expected.push([at, (z.to_bits() as i32).max(0), 1000 + i]);
                }
            }
            for level in Level::ALL.into_iter().filter(|l| l.is_available()) {
                assert_eq!(level.dispatch(&faces), expected, "round {round}, {level:?}");
            }
        }
    }

    #[test]
    fn three_pixels_or_a_fifth_row_are_not_few() {
        struct Few([i32; 2]);
        impl Kernel for Few {
            type Output = bool;
            #[inline(always)]
            fn run<S: Simd>(self, s: S) -> bool {
                has_few(s, (s.splat_i(self.0[0]), s.splat_i(self.0[1]))).bits() & 1 == 1
            }
        }
        for level in Level::ALL.into_iter().filter(|l| l.is_available()) {
            let is_few = |words| level.dispatch(Few(words));
            assert!(is_few([1, 0]) && is_few([i32::MIN, 0]) && is_few([i32::MIN | 1, 0]));
            assert!(!is_few([7, 0]) && !is_few([i32::MIN | 3, 0]) && !is_few([1, 1]));
        }
    }
}
