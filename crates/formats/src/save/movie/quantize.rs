//! Colour quantization to 256 colours: exact if there are no more, otherwise by median cut.
//!
//! Median cut works on cells of 8x8x8 colours: the box whose pixels are spread the most is split at
//! the median of its longest side until there are 256; the colour of a box is the mean of its
//! pixels. Integers only: the same picture gives the same file.
//!
//! Source: P. Heckbert, Color Image Quantization for Frame Buffer Display (1982), section 3.2.

use std::collections::HashMap;

/// Most colours of a palette.
const COLORS: usize = 256;

/// Returns an index for each pixel, and the palette as R, G, B bytes.
pub(super) fn indexed(rgb: &[u8]) -> (Vec<u8>, Vec<u8>) {
    let pixels = rgb.as_chunks::<3>().0;
    exact(pixels).unwrap_or_else(|| median_cut(pixels))
}

/// Returns indices and palette without loss, or `None` if there are more than [`COLORS`] colours.
fn exact(pixels: &[[u8; 3]]) -> Option<(Vec<u8>, Vec<u8>)> {
    let mut palette: Vec<u8> = Vec::new();
    let mut numbers: HashMap<[u8; 3], u8> = HashMap::new();
    let mut indices = Vec::with_capacity(pixels.len());
    let mut last: Option<([u8; 3], u8)> = None;
    for &pixel in pixels {
        let number = match last {
            Some((color, number)) if color == pixel => number,
            _ => match (numbers.get(&pixel), numbers.len()) {
                (Some(&number), _) => number,
                (None, COLORS..) => return None,
                (None, count) => {
                    palette.extend_from_slice(&pixel);
                    numbers.insert(pixel, count as u8);
                    count as u8
                }
            },
        };
        last = Some((pixel, number));
        indices.push(number);
    }
    Some((indices, palette))
}

/// Returns the cell of a colour: five bits per channel.
#[inline]
fn cell([r, g, b]: [u8; 3]) -> usize {
    usize::from(r >> 3) << 10 | usize::from(g >> 3) << 5 | usize::from(b >> 3)
}

/// Returns one channel of a cell, 0..32.
fn side(cell: u16, channel: usize) -> u16 {
    cell >> (10 - 5 * channel) & 31
}

/// Cells that share a palette colour.
struct Group {
    cells: Vec<u16>,
    pixels: u64,
    longest: usize,
    length: u16,
}

impl Group {
    fn new(cells: Vec<u16>, counts: &[u32]) -> Self {
        let extent = |channel| {
            let all = || cells.iter().map(|&c| side(c, channel));
            all().max().unwrap_or(0) - all().min().unwrap_or(0)
        };
        let longest = (0..3).rev().max_by_key(|&c| extent(c)).unwrap_or(0);
        let length = extent(longest);
        let pixels = cells.iter().map(|&c| u64::from(counts[usize::from(c)])).sum();
        Group { cells, pixels, longest, length }
    }

    /// Returns the priority of splitting this group: pixels times the square of the longest side.
    fn spread(&self) -> u64 {
        self.pixels * u64::from(self.length) * u64::from(self.length)
    }
}

/// Returns indices and palette by median cut.
fn median_cut(pixels: &[[u8; 3]]) -> (Vec<u8>, Vec<u8>) {
    let mut counts = vec![0u32; 1 << 15];
    pixels.iter().for_each(|&p| counts[cell(p)] += 1);
    let used = (0..1u16 << 15).filter(|&c| counts[usize::from(c)] > 0).collect();
    let mut groups = vec![Group::new(used, &counts)];
    while groups.len() < COLORS {
        let widest = (0..groups.len()).max_by_key(|&i| groups[i].spread()).unwrap_or(0);
        if groups[widest].length == 0 {
            break;
        }
        let mut group = groups.swap_remove(widest);
        group.cells.sort_unstable_by_key(|&c| (side(c, group.longest), c));
        let mut below = 0;
        let median = group.cells.iter().position(|&c| {
            below += 2 * u64::from(counts[usize::from(c)]);
            below >= group.pixels
        });
        let at = median.map_or(1, |m| m + 1).clamp(1, group.cells.len() - 1);
        let upper = group.cells.split_off(at);
        groups.push(Group::new(group.cells, &counts));
        groups.push(Group::new(upper, &counts));
    }
    let mut number_of = vec![0u8; 1 << 15];
    for (number, group) in groups.iter().enumerate() {
        group.cells.iter().for_each(|&c| number_of[usize::from(c)] = number as u8);
    }
    let mut sums = vec![[0u64; 4]; groups.len()];
    let indices: Vec<u8> = pixels
        .iter()
        .map(|&p| {
            let number = number_of[cell(p)];
            let sum = &mut sums[usize::from(number)];
            (0..3).for_each(|c| sum[c] += u64::from(p[c]));
            sum[3] += 1;
            number
        })
        .collect();
    let mean = |[r, g, b, n]: &[u64; 4]| [r, g, b].map(|s| ((s + n / 2) / n.max(&1)) as u8);
    (indices, sums.iter().flat_map(mean).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colours_are_kept_and_many_are_near() {
        let few: Vec<u8> = (0..900).map(|i| (i / 3 % 200) as u8).collect();
        let (indices, palette) = indexed(&few);
        let back: Vec<u8> =
            indices.iter().flat_map(|&i| palette[usize::from(i) * 3..][..3].to_vec()).collect();
        assert_eq!(back, few);
        // A gradient of red over a gradient of green, in every byte.
        let many: Vec<u8> =
            (0..256 * 256).flat_map(|i: u32| [(i % 256) as u8, (i / 256) as u8, 40]).collect();
        let (indices, palette) = indexed(&many);
        assert_eq!((palette.len(), indices.len()), (768, 65536));
        let off = |i: usize| {
            (0..3).map(|c| palette[usize::from(indices[i]) * 3 + c].abs_diff(many[i * 3 + c])).max()
        };
        assert!((0..65536).map(|i| off(i).unwrap_or(0)).max() <= Some(16));
    }

    #[test]
    fn colours_within_one_cell_share_their_mean() {
        // More than 256 colours in two cells: no group can be split further.
        let many: Vec<u8> =
            (0..600u32).flat_map(|i| [(i % 8) as u8, (i / 8 % 8) as u8, (i / 64) as u8 + 120]).collect();
        let (indices, palette) = indexed(&many);
        assert!(indices.iter().all(|&i| usize::from(i) * 3 < palette.len()));
    }
}
