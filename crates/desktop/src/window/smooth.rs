//! Smooth scaling of a frame to its window.
//!
//! In: RGBA bytes and a layout. Out: words in which each pixel of the window is a mean of frame
//! pixels. Along each axis, at n window pixels for m of the frame: enlarged, the two frame pixels
//! whose centres lie around the window pixel's centre, by the distance (bilinear); reduced, all
//! frame pixels that the window pixel covers, by the length covered (a box). Weights are integers
//! that sum to 256, so a frame of one colour keeps it to the bit.

use super::layout::Layout;
use fbptr_core::simd::{add_weighted, mean_word};
use std::ops::Range;

/// Sum of a window pixel's weights along one axis.
const WHOLE: u32 = 256;

/// Frame pixels that a window pixel shows along one axis: the first, and the weight of each.
struct Part {
    first: usize,
    weights: Vec<u32>,
}

/// Returns the parts of all `shown` window pixels along an axis of `frame` pixels.
fn parts(frame: usize, shown: usize) -> Vec<Part> {
    let part = |i: usize| {
        if shown >= frame {
            // Twice the place of the window pixel's centre, times `shown`, from the first centre.
            let place = ((2 * i + 1) * frame).saturating_sub(shown);
            let first = (place / (2 * shown)).min(frame - 1);
            let next = (place % (2 * shown)) as u64 * u64::from(WHOLE) / (2 * shown as u64);
            let next = if first + 1 < frame { next as u32 } else { 0 };
            let weights = if next == 0 { vec![WHOLE] } else { vec![WHOLE - next, next] };
            return Part { first, weights };
        }
        // In units of a window pixel over `frame`.
        let (from, to) = (i * frame, (i + 1) * frame);
        let (first, last) = (from / shown, (to - 1) / shown);
        let mut used = 0;
        let weights = (first..=last).map(|j| {
            let covered = ((j + 1) * shown).min(to) - from;
            let end = (covered as u64 * u64::from(WHOLE) / frame as u64) as u32;
            end - std::mem::replace(&mut used, end)
        });
        Part { first, weights: weights.collect() }
    };
    (0..shown).map(part).collect()
}

/// Converts what frame rows `rows` of `rgba`, the entire frame, change in `words`, the entire
/// window.
pub(super) fn convert(rgba: &[u8], layout: &Layout, rows: Range<usize>, words: &mut [u32]) {
    let Layout { frame, window, origin, shown, .. } = *layout;
    if shown.contains(&0) || rgba.len() < frame[0] * frame[1] * 4 || rows.is_empty() {
        return;
    }
    let (across, down) = (parts(frame[0], shown[0]), parts(frame[1], shown[1]));
    let mut sums = vec![[0_u32; 3]; frame[0]];
    for (y, part) in down.iter().enumerate() {
        if part.first >= rows.end || part.first + part.weights.len() <= rows.start {
            continue;
        }
        // The mean of the frame rows, for each column.
        sums.fill([0; 3]);
        for (row, weight) in (part.first..).zip(&part.weights) {
            let pixels = rgba[row * frame[0] * 4..][..frame[0] * 4].as_chunks::<4>().0;
            add_weighted(&mut sums, pixels, *weight);
        }
        let start = (origin[1] + y) * window[0] + origin[0];
        let Some(target) = words.get_mut(start..start + shown[0]) else { return };
        for (word, part) in target.iter_mut().zip(&across) {
            *word = mean_word(&sums[part.first..], &part.weights, WHOLE);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::window::Scaling;

    #[test]
    fn weights_are_whole_and_in_the_frame() {
        for (frame, shown) in [(1, 1), (1, 9), (7, 23), (23, 7), (640, 1000), (1000, 640), (5, 5), (3, 1)] {
            for (i, part) in parts(frame, shown).iter().enumerate() {
                assert_eq!(part.weights.iter().sum::<u32>(), WHOLE, "{frame} on {shown}: {i}");
                assert!(part.first + part.weights.len() <= frame, "{frame} on {shown}: {i}");
            }
        }
        // Enlarged by two, a pixel shows 3/4 of its own and 1/4 of its neighbour.
        let two = parts(4, 8);
        assert_eq!((two[3].first, &two[3].weights[..]), (1, &[192, 64][..]));
        // Reduced by two, half of each.
        assert_eq!(parts(8, 4)[1].weights, [128, 128]);
    }

    #[test]
    fn one_colour_stays_and_rows_alone_make_the_same_picture() {
        for (size, window) in [([5, 4], [17, 13]), ([20, 10], [7, 9]), ([3, 3], [40, 6]), ([1, 1], [3, 5])] {
            let layout = Layout::scaled(size, window, Scaling::Smooth);
            let all = window[0] * window[1];
            let mut words = vec![0; all];
            convert(&[7, 99, 250, 255].repeat(size[0] * size[1]), &layout, 0..size[1], &mut words);
            assert!(words.iter().all(|w| *w == 0 || *w == 0x0007_63fa));
            let rgba: Vec<u8> = (0..size[0] * size[1] * 4).map(|i| (i * 37) as u8).collect();
            let (mut whole, mut changed) = (vec![0; all], words);
            convert(&rgba, &layout, 0..size[1], &mut whole);
            (0..size[1]).for_each(|row| convert(&rgba, &layout, row..row + 1, &mut changed));
            assert!(whole == changed, "{size:?} in {window:?}");
        }
    }

    #[test]
    fn an_edge_becomes_a_ramp() {
        let rgba: Vec<u8> = [[0, 0, 0, 255], [255, 255, 255, 255]].concat();
        let layout = Layout::scaled([2, 1], [16, 8], Scaling::Smooth);
        let mut words = vec![0; 16 * 8];
        convert(&rgba, &layout, 0..1, &mut words);
        let row: Vec<u32> = words[..16].iter().map(|w| w & 255).collect();
        assert!(row[0] == 0 && row[15] == 255 && row.windows(2).all(|w| w[0] <= w[1]), "{row:?}");
        assert!(row.iter().filter(|v| (1..255).contains(*v)).count() >= 6, "{row:?}");
    }
}
