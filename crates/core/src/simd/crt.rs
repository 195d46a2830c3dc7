//! A row of a cathode ray tube's screen in vectors: two lines of the frame, mixed by the beam, and
//! the phosphor mask before them.
//!
//! Integers throughout, so that every level gives the same words.

use super::{I32, Kernel, Level, Simd};

/// Columns after which the phosphor mask repeats: stripes of red, green and blue.
pub const STRIPES: usize = 3;
/// Weight of 1.
pub const ONE: i32 = 256;

/// Lanes of the widest vector.
const WIDEST: usize = 16;

/// Columns of the screen: which pixels each shows, and the mask.
#[derive(Clone, Debug)]
pub struct CrtColumns {
    /// Pixels of a line of the frame.
    width: usize,
    /// The left one of two neighbouring pixels.
    left: Vec<i32>,
    /// Weight of the right one.
    right_weight: Vec<i32>,
    /// Weights of red, green and blue, by the column modulo [`STRIPES`], and repeated so that a
    /// vector can be loaded from each of these columns on.
    mask: [[i32; STRIPES + WIDEST]; 3],
}

impl CrtColumns {
    /// Creates the columns: `places` gives each its left pixel, below `width`, and the weight of
    /// the right one, 0 to [`ONE`]; `mask` gives a column's weights of red, green and blue.
    pub fn new(width: usize, places: impl Iterator<Item = (usize, i32)>, mask: [[i32; 3]; STRIPES]) -> Self {
        let (left, right_weight) = places
            .map(|(left, weight)| (left.min(width.saturating_sub(1)) as i32, weight.clamp(0, ONE)))
            .unzip();
        let weights = |channel: usize| std::array::from_fn(|x| mask[x % STRIPES][channel]);
        CrtColumns { width, left, right_weight, mask: [weights(0), weights(1), weights(2)] }
    }

    /// Returns the number of columns.
    pub fn len(&self) -> usize {
        self.left.len()
    }

    /// Returns whether there is no column.
    pub fn is_empty(&self) -> bool {
        self.left.is_empty()
    }
}

/// Mixes two lines of R, G, B, A pixels by their weights, 0 to 2 [`ONE`] in all, and writes the
/// words 0x00RRGGBB of a row, up to the shorter of `columns` and `words`. `mixed` is working memory.
///
/// # Panics
/// If a line has fewer pixels than `columns` was made for.
pub fn crt_row(
    level: Level,
    columns: &CrtColumns,
    lines: [&[u8]; 2],
    weights: [i32; 2],
    mixed: &mut Vec<u8>,
    words: &mut [u32],
) {
    let count = columns.len().min(words.len());
    if columns.width == 0 || count == 0 {
        return;
    }
    let bytes = columns.width * 4;
    // One pixel more: the last one is its own neighbour.
    mixed.resize(bytes + 4, 0);
    let lines = lines.map(|line| &line[..bytes]);
    level.dispatch(Mix { lines, weights, mixed: &mut mixed[..bytes] });
    mixed.copy_within(bytes - 4..bytes, bytes);
    level.dispatch(Mask { columns, mixed, words: &mut words[..count] });
}

/// Returns the bytes of a pixel that two lines are mixed to.
#[inline(always)]
fn mix([above, below]: [[u8; 4]; 2], [a, b]: [i32; 2]) -> [u8; 4] {
    let channel = |i: usize| ((i32::from(above[i]) * a + i32::from(below[i]) * b) >> 8).min(255) as u8;
    [channel(0), channel(1), channel(2), 0]
}

/// Returns the word of a column: two neighbouring pixels of a mixed line, the right one's weight,
/// and the mask's weights.
#[inline(always)]
fn crt_word([left, right]: [[u8; 4]; 2], right_weight: i32, mask: [i32; 3]) -> u32 {
    let channel = |i: usize| {
        let (l, r) = (i32::from(left[i]), i32::from(right[i]));
        let between = l + (((r - l) * right_weight) >> 8);
        ((between * mask[i]) >> 8).min(255) as u32
    };
    channel(0) << 16 | channel(1) << 8 | channel(2)
}

struct Mix<'a> {
    lines: [&'a [u8]; 2],
    weights: [i32; 2],
    mixed: &'a mut [u8],
}

impl Kernel for Mix<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let [a, b] = self.weights.map(|weight| s.splat_i(weight));
        let (low, all) = (s.splat_i(0xff), s.mask(u32::MAX));
        let step = 4 * S::LANES;
        let [above, below] = self.lines;
        let whole = self.mixed.len() / step * step;
        for at in (0..whole).step_by(step) {
            let (above, below) = (s.load_bytes(&above[at..]), s.load_bytes(&below[at..]));
            let red = (((above & low) * a + (below & low) * b).shr::<8>()).min(low);
            let green = (((above.shr::<8>() & low) * a + (below.shr::<8>() & low) * b).shr::<8>()).min(low);
            let blue = (((above.shr::<16>() & low) * a + (below.shr::<16>() & low) * b).shr::<8>()).min(low);
            let pixels = red + green.shl::<8>() + blue.shl::<16>();
            s.store_masked_bytes(all, pixels, &mut self.mixed[at..]);
        }
        let rest = self.mixed[whole..].as_chunks_mut::<4>().0;
        let lines = above[whole..].as_chunks::<4>().0.iter().zip(below[whole..].as_chunks::<4>().0);
        for (pixel, (above, below)) in rest.iter_mut().zip(lines) {
            *pixel = mix([*above, *below], self.weights);
        }
    }
}

struct Mask<'a> {
    columns: &'a CrtColumns,
    mixed: &'a [u8],
    words: &'a mut [u32],
}

impl Kernel for Mask<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        // SAFETY: u32 and i32 have one size and alignment, and every value of one is a value of the
        // other.
        let words: &mut [i32] =
            unsafe { std::slice::from_raw_parts_mut(self.words.as_mut_ptr().cast(), self.words.len()) };
        let (low, all) = (s.splat_i(0xff), s.mask(u32::MAX));
        let CrtColumns { left, right_weight, mask, .. } = self.columns;
        let whole = words.len() / S::LANES * S::LANES;
        for x in (0..whole).step_by(S::LANES) {
            let [l, r] = s.gather_byte_pairs(all, self.mixed, s.load_i(&left[x..]));
            let weight = s.load_i(&right_weight[x..]);
            let stripe = x % STRIPES;
            let channel = |l: S::I, r: S::I, mask: &[i32]| {
                let value = l + ((r - l) * weight).sar::<8>();
                (value * s.load_i(&mask[stripe..])).shr::<8>().min(low)
            };
            let red = channel(l & low, r & low, &mask[0]);
            let green = channel(l.shr::<8>() & low, r.shr::<8>() & low, &mask[1]);
            let blue = channel(l.shr::<16>() & low, r.shr::<16>() & low, &mask[2]);
            s.store_i(red.shl::<16>() + green.shl::<8>() + blue, &mut words[x..]);
        }
        let pixels = self.mixed.as_chunks::<4>().0;
        for x in whole..words.len() {
            let at = left[x] as usize;
            let weights = [0, 1, 2].map(|channel| mask[channel][x % STRIPES]);
            words[x] = crt_word([pixels[at], pixels[at + 1]], right_weight[x], weights) as i32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_level_gives_the_word_of_every_column(
            pixels in prop::collection::vec(any::<[[u8; 4]; 2]>(), 1..70),
            places in prop::collection::vec((any::<prop::sample::Index>(), 0..=ONE), 0..120),
            weights in prop::array::uniform2(0..=ONE),
            mask in prop::array::uniform3(prop::array::uniform3(0..2 * ONE)),
            room in 0..130usize,
        ) {
            let places: Vec<(usize, i32)> =
                places.into_iter().map(|(index, weight)| (index.index(pixels.len()), weight)).collect();
            let lines: [Vec<u8>; 2] =
                [0, 1].map(|line| pixels.iter().flat_map(|pair| pair[line]).collect());
            // Pixel by pixel, from the description alone.
            let mixed = |at: usize| {
                let pair = pixels[at.min(pixels.len() - 1)];
                let sum = |i: usize| i32::from(pair[0][i]) * weights[0] + i32::from(pair[1][i]) * weights[1];
                [0, 1, 2].map(|i| (sum(i) / 256).min(255))
            };
            let mut want = vec![0xdead_beef; room];
            for (x, (word, (at, weight))) in want.iter_mut().zip(&places).enumerate() {
                let (l, r) = (mixed(*at), mixed(at + 1));
                let value = |i: usize| {
                    let between = l[i] + ((r[i] - l[i]) * weight).div_euclid(256);
                    (between * mask[x % 3][i] / 256).min(255) as u32
                };
                *word = value(0) << 16 | value(1) << 8 | value(2);
            }
            let columns = CrtColumns::new(pixels.len(), places.into_iter(), mask);
            for level in Level::ALL.into_iter().filter(|level| level.is_available()) {
                let (mut words, mut scratch) = (vec![0xdead_beef; room], vec![7; 3]);
                crt_row(level, &columns, [&lines[0], &lines[1]], weights, &mut scratch, &mut words);
                prop_assert_eq!(&words, &want, "{}", level.as_str());
            }
        }
    }
}
