//! Scan-out: conversion of RGBA bytes of video memory to the window's 0x00RRGGBB words, enlarged or
//! reduced.
//!
//! The only module that uses minifb's word order. Alpha is ignored: R, G and B are shown as they
//! are.

use super::layout::Layout;
use super::smooth;
use fbptr_core::simd::{Level, scan_out};
use std::ops::Range;

pub use fbptr_core::simd::word;

/// Converts frame rows `rows` of `rgba` into `words` (the entire window, row after row) according
/// to `layout`.
///
/// `rgba` is the entire frame. Rows outside the frame and words outside the shown frame are not
/// changed.
pub fn convert(rgba: &[u8], layout: &Layout, rows: Range<usize>, words: &mut [u32]) {
    let [frame_width, frame_height] = layout.frame;
    let [shown_width, shown_height] = layout.shown;
    let window_width = layout.window[0];
    if shown_width == 0 || shown_height == 0 {
        return;
    }
    if layout.is_smooth && layout.shown != layout.frame {
        return smooth::convert(rgba, layout, rows, words);
    }
    let stride_bytes = frame_width * 4;
    // 0 if pixels differ in size.
    let scale = if shown_width.is_multiple_of(frame_width) { shown_width / frame_width } else { 0 };
    let level = Level::best();
    let mut last_source = None;
    for y in layout.window_rows(rows) {
        let row = (y - layout.origin[1]) * frame_height / shown_height;
        let start = y * window_width + layout.origin[0];
        if last_source == Some(row) {
            // The frame row is that of the words above: copy them.
            words.copy_within(start - window_width..start - window_width + shown_width, start);
            continue;
        }
        let Some(source) = rgba.get(row * stride_bytes..(row + 1) * stride_bytes) else { return };
        let Some(target) = words.get_mut(start..start + shown_width) else { return };
        let source = source.as_chunks::<4>().0;
        if scale == 1 && shown_width == frame_width {
            scan_out(level, source.as_flattened(), target);
        } else if scale >= 1 {
            match scale {
                2 => enlarge::<2>(source, target),
                3 => enlarge::<3>(source, target),
                4 => enlarge::<4>(source, target),
                _ => target.chunks_exact_mut(scale).zip(source).for_each(|(block, &p)| block.fill(word(p))),
            }
        } else {
            for (x, w) in target.iter_mut().enumerate() {
                *w = word(source[x * frame_width / shown_width]);
            }
        }
        last_source = Some(row);
    }
}

/// Repeats each pixel N times: with a constant N the stores are few and wide.
fn enlarge<const N: usize>(source: &[[u8; 4]], target: &mut [u32]) {
    for (block, &p) in target.as_chunks_mut::<N>().0.iter_mut().zip(source) {
        *block = [word(p); N];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::window::Scaling;

    fn frame(w: usize, h: usize) -> Vec<u8> {
        (0..w * h).flat_map(|i| [i as u8, (i * 7) as u8, (i * 13) as u8, 77]).collect()
    }

    #[test]
    fn every_window_pixel_shows_the_pixel_that_the_pointer_finds() {
        for (size, window) in [
            ([5, 4], [5, 4]),
            ([5, 4], [17, 13]),
            ([5, 4], [11, 9]),
            ([50, 4], [210, 30]),
            ([130, 3], [130, 3]),
            ([2, 2], [12, 12]),
            ([20, 10], [7, 9]),
            ([1, 1], [3, 2]),
        ] {
            let rgba = frame(size[0], size[1]);
            for scaling in [Scaling::Whole, Scaling::Fit] {
                let layout = Layout::scaled(size, window, scaling);
                let mut words = vec![0xdead; window[0] * window[1]];
                // Row by row must give the same as all at once: changed rows are converted alone.
                for row in 0..size[1] {
                    convert(&rgba, &layout, row..row + 1, &mut words);
                }
                for (i, &w) in words.iter().enumerate() {
                    let expected =
                        layout.pixel_at((i % window[0]) as f32, (i / window[0]) as f32).map(|[x, y]| {
                            let p = &rgba[(y * size[0] + x) * 4..][..4];
                            (p[0] as u32) << 16 | (p[1] as u32) << 8 | p[2] as u32
                        });
                    assert_eq!(w, expected.unwrap_or(0xdead), "{size:?} in {window:?} {scaling:?}, word {i}");
                }
            }
        }
    }
}
