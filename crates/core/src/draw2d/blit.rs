//! Rectangles of pixels: written to the frame, read from it, and copied within it.

use super::blend::run_of_many;
use super::{Blend, DrawError, Rect, over, pixels_mut, run_mut, visible};
use crate::memory::{Rgba, VideoMemory};
use std::ops::Range;

/// Draws w x h pixels, RGBA rows without padding, at (x, y). Pixels outside the frame are skipped.
///
/// A negative size or a payload of the wrong length is an error, and nothing is drawn.
pub fn blit(memory: &mut VideoMemory, rect: Rect, rgba: &[u8], blend: Blend) -> Result<(), DrawError> {
    let Rect { x, y, w, h } = rect.checked()?;
    // Below 2^64: both sides are below 2^31.
    let expected = w as u64 * h as u64 * 4;
    if rgba.len() as u64 != expected {
        return Err(DrawError::WrongLength { w, h, expected, found: rgba.len() as u64 });
    }
    let [xs, ys] = visible(memory, rect);
    if xs.is_empty() || ys.is_empty() {
        return Ok(());
    }
    let source = rgba.as_chunks().0;
    let skip = (i64::from(xs.start) - i64::from(x)) as usize;
    if w == memory.width() as i32 && xs.len() == w as usize {
        // Full rows are contiguous on both sides.
        let start = (i64::from(ys.start) - i64::from(y)) as usize * w as usize;
        let pixels = &mut pixels_mut(memory)[w as usize * ys.start as usize..w as usize * ys.end as usize];
        run_of_many(blend, &source[start..start + pixels.len()], pixels);
        memory.mark_rows(ys.start as u32..ys.end as u32);
        return Ok(());
    }
    for row in ys.clone() {
        let at = (i64::from(row) - i64::from(y)) as usize * w as usize + skip;
        run_of_many(blend, &source[at..at + xs.len()], run_mut(memory, row, xs.clone()));
    }
    memory.mark_rows(ys.start as u32..ys.end as u32);
    Ok(())
}

/// Draws w x h pixels as [`blit`] does, but for those of the colour `key`, if one is given.
///
/// A negative size or pixels of the wrong length are an error, and nothing is drawn.
pub fn stamp(
    memory: &mut VideoMemory,
    rect: Rect,
    rgba: &[u8],
    key: Option<Rgba>,
    blend: Blend,
) -> Result<(), DrawError> {
    let Some(key) = key else { return blit(memory, rect, rgba, blend) };
    let Rect { x, y, w, h } = rect.checked()?;
    let expected = w as u64 * h as u64 * 4;
    if rgba.len() as u64 != expected {
        return Err(DrawError::WrongLength { w, h, expected, found: rgba.len() as u64 });
    }
    let source = rgba.as_chunks::<4>().0;
    let [xs, ys] = visible(memory, rect);
    if xs.is_empty() {
        return Ok(());
    }
    for row in ys {
        let at = (i64::from(row) - i64::from(y)) as usize * w as usize;
        let left = at + (i64::from(xs.start) - i64::from(x)) as usize;
        let dest = run_mut(memory, row, xs.clone());
        let pixels = source[left..left + dest.len()].iter().zip(dest);
        pixels.filter(|(color, _)| **color != key).for_each(|(color, pixel)| {
            *pixel = if blend == Blend::Replace { *color } else { over(*color, *pixel) };
        });
        memory.mark_row(row as u32);
    }
    Ok(())
}

/// Returns the bytes of w x h pixels from (x, y), row by row, without a copy.
///
/// Pixels outside the frame or a negative size are an error. A width or height
/// of 0 never is, wherever the rectangle lies.
pub fn rows(memory: &VideoMemory, rect: Rect) -> Result<impl Iterator<Item = &[u8]>, DrawError> {
    let (xs, ys) = source_ranges(memory, rect)?;
    let (xs, stride) = (xs.start * 4..xs.end * 4, memory.stride_bytes());
    Ok(ys.map(move |y| &memory.bytes()[y * stride..][xs.clone()]))
}

/// Returns the bytes of w x h pixels from (x, y), RGBA rows without padding. Fails as [`rows`]
/// does.
pub fn read(memory: &VideoMemory, rect: Rect) -> Result<Vec<u8>, DrawError> {
    Ok(rows(memory, rect)?.collect::<Vec<_>>().concat())
}

/// Copies w x h pixels to `dest`, as if through a temporary copy. Pixels outside the frame at
/// `dest` are skipped.
///
/// A source that is not entirely inside the frame or a negative size is an error, and nothing is
/// drawn.
pub fn copy(memory: &mut VideoMemory, source: Rect, dest: [i32; 2], blend: Blend) -> Result<(), DrawError> {
    let (from_xs, from_ys) = source_ranges(memory, source)?;
    let [xs, ys] = visible(memory, Rect { x: dest[0], y: dest[1], ..source });
    if xs.is_empty() || ys.is_empty() {
        return Ok(());
    }
    let stride = memory.width() as usize;
    let from = |x: i32, y: i32| {
        let dx = (i64::from(x) - i64::from(dest[0])) as usize;
        let dy = (i64::from(y) - i64::from(dest[1])) as usize;
        stride * (from_ys.start + dy) + from_xs.start + dx
    };
    let mut temporary = Vec::new();
    let mut one = |y: i32| {
        let at = from(xs.start, y) * 4..(from(xs.start, y) + xs.len()) * 4;
        let to = (stride * y as usize + xs.start as usize) * 4;
        match blend {
            Blend::Replace => memory.bytes_mut().copy_within(at, to),
            Blend::Over => {
                temporary.clear();
                temporary.extend_from_slice(memory.bytes()[at].as_chunks().0);
                run_of_many(blend, &temporary, run_mut(memory, y, xs.clone()));
            }
        }
    };
    // A row must be read before it is overwritten: upwards from the last row when moving down,
    // downwards from the first otherwise.
    if i64::from(dest[1]) > i64::from(source.y) {
        ys.clone().rev().for_each(&mut one);
    } else {
        ys.clone().for_each(&mut one);
    }
    memory.mark_rows(ys.start as u32..ys.end as u32);
    Ok(())
}

/// Returns the columns and rows of a source, entirely inside the frame or empty.
fn source_ranges(memory: &VideoMemory, rect: Rect) -> Result<(Range<usize>, Range<usize>), DrawError> {
    let Rect { x, y, w, h } = rect.checked()?;
    if w == 0 || h == 0 {
        return Ok((0..0, 0..0));
    }
    let (width, height) = (memory.width(), memory.height());
    let inside = |start: i32, len: i32, limit: u32| {
        let start = u32::try_from(start).ok()?;
        let end = start.checked_add(len.unsigned_abs())?;
        (end <= limit).then_some(start as usize..end as usize)
    };
    match (inside(x, w, width), inside(y, h, height)) {
        (Some(xs), Some(ys)) => Ok((xs, ys)),
        _ => Err(DrawError::SourceOutside { rect, width, height }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw2d::put_pixel;
    use crate::draw2d::raster::{extremes, memory};

    /// Creates a frame whose every pixel encodes its position, with many different alphas.
    fn marked(w: u32, h: u32) -> VideoMemory {
        let mut m = memory(w, h);
        for (x, y) in (0..h as i32).flat_map(|y| (0..w as i32).map(move |x| (x, y))) {
            m.put_pixel(x, y, [10 + x as u8, 20 + y as u8, 200, (x * 37 + y * 91) as u8]);
        }
        m.take_damage();
        m
    }

    #[test]
    fn blit_is_its_pixels_anywhere_in_i32() {
        let source: Vec<Rgba> = (0..12).map(|i| [100 + i, i, 3, 20 * i]).collect();
        for (x, y) in extremes().into_iter().flat_map(|x| extremes().map(|y| (x, y))) {
            for blend in [Blend::Replace, Blend::Over] {
                let (mut got, mut want) = (marked(7, 5), marked(7, 5));
                blit(&mut got, Rect { x, y, w: 4, h: 3 }, source.as_flattened(), blend).unwrap();
                for (i, &color) in source.iter().enumerate() {
                    let (px, py) = (x.checked_add(i as i32 % 4), y.checked_add(i as i32 / 4));
                    if let (Some(px), Some(py)) = (px, py) {
                        put_pixel(&mut want, px, py, color, blend);
                    }
                }
                assert_eq!(got.bytes(), want.bytes(), "{x} {y} {blend:?}");
                if blend == Blend::Replace {
                    assert_eq!(got.take_damage(), want.take_damage(), "{x} {y}");
                }
            }
        }
    }

    #[test]
    fn whole_rows_are_their_pixels_above_and_below_the_frame() {
        let source: Vec<Rgba> = (0..28).map(|i| [100 + i, i, 3, 9 * i]).collect();
        for (x, y) in (-1..2).flat_map(|x| (-5..7).map(move |y| (x, y))) {
            for blend in [Blend::Replace, Blend::Over] {
                let (mut got, mut want) = (marked(7, 5), marked(7, 5));
                blit(&mut got, Rect { x, y, w: 7, h: 4 }, source.as_flattened(), blend).unwrap();
                for (i, &color) in source.iter().enumerate() {
                    put_pixel(&mut want, x + i as i32 % 7, y + i as i32 / 7, color, blend);
                }
                assert_eq!(got.bytes(), want.bytes(), "{x} {y} {blend:?}");
                if blend == Blend::Replace {
                    assert_eq!(got.take_damage(), want.take_damage(), "{x} {y}");
                }
            }
        }
    }

    #[test]
    fn copy_is_as_through_a_temporary_copy() {
        for (dx, dy) in (-5..9).flat_map(|x| (-4..7).map(move |y| (x, y))) {
            for blend in [Blend::Replace, Blend::Over] {
                let source = Rect { x: 2, y: 1, w: 4, h: 3 };
                let (mut got, mut want) = (marked(8, 6), marked(8, 6));
                let temporary = read(&want, source).unwrap();
                blit(&mut want, Rect { x: dx, y: dy, ..source }, &temporary, blend).unwrap();
                copy(&mut got, source, [dx, dy], blend).unwrap();
                assert_eq!(got.bytes(), want.bytes(), "{dx} {dy} {blend:?}");
                assert_eq!(got.take_damage(), want.take_damage());
            }
        }
    }

    #[test]
    fn a_stamp_leaves_its_key_out() {
        let source: Vec<Rgba> = (0..12).map(|i| [100 + i, i, 3, 20 * i]).collect();
        for (x, y) in extremes().into_iter().flat_map(|x| extremes().map(|y| (x, y))) {
            for (blend, key) in
                [(Blend::Replace, None), (Blend::Replace, Some(source[5])), (Blend::Over, Some(source[7]))]
            {
                let (mut got, mut want) = (marked(7, 5), marked(7, 5));
                stamp(&mut got, Rect { x, y, w: 4, h: 3 }, source.as_flattened(), key, blend).unwrap();
                for (i, &color) in source.iter().enumerate().filter(|(_, color)| Some(**color) != key) {
                    let (px, py) = (x.checked_add(i as i32 % 4), y.checked_add(i as i32 / 4));
                    if let (Some(px), Some(py)) = (px, py) {
                        put_pixel(&mut want, px, py, color, blend);
                    }
                }
                assert_eq!(got.bytes(), want.bytes(), "{x} {y} {blend:?} {key:?}");
            }
        }
        let short =
            stamp(&mut marked(7, 5), Rect { x: 0, y: 0, w: 2, h: 2 }, &[0; 15], Some([0; 4]), Blend::Replace);
        assert_eq!(short.unwrap_err().code().as_str(), "EFORMAT");
    }

    #[test]
    fn what_is_read_is_what_was_put() {
        let (m, rect) = (marked(8, 6), Rect { x: 3, y: 2, w: 5, h: 4 });
        let bytes = read(&m, rect).unwrap();
        let mut copy_of = memory(8, 6);
        blit(&mut copy_of, rect, &bytes, Blend::Replace).unwrap();
        assert_eq!(read(&copy_of, rect).unwrap(), bytes);
        assert_eq!(rows(&m, rect).unwrap().count(), 4);
        assert_eq!(read(&m, Rect { x: 0, y: 0, w: 8, h: 6 }).unwrap(), m.bytes());
    }

    #[test]
    fn asking_outside_and_broken_payloads_are_refused_and_draw_nothing() {
        let mut m = marked(8, 6);
        let before = m.bytes().to_vec();
        let rect = |x, y, w, h| Rect { x, y, w, h };
        for bad in [
            rect(-1, 0, 2, 2),
            rect(0, -1, 2, 2),
            rect(7, 0, 2, 2),
            rect(0, 5, 2, 2),
            rect(0, 0, 1, i32::MAX),
        ]
        .into_iter()
        .chain([
            rect(i32::MAX, i32::MAX, i32::MAX, i32::MAX),
            rect(i32::MIN, 0, 9, 1),
            rect(0, 0, -1, 2),
        ]) {
            assert_eq!(read(&m, bad).unwrap_err().code().as_str(), "ERANGE", "{bad:?}");
            assert_eq!(copy(&mut m, bad, [0, 0], Blend::Replace).unwrap_err().code().as_str(), "ERANGE");
        }
        let short = blit(&mut m, rect(0, 0, 2, 2), &[0; 15], Blend::Replace).unwrap_err();
        assert_eq!(short.to_string(), "16 bytes expected for 2x2 pixels, 15 found");
        assert_eq!(short.code().as_str(), "EFORMAT");
        let huge = rect(0, 0, i32::MAX, i32::MAX);
        assert_eq!(blit(&mut m, huge, &[0; 4], Blend::Replace).unwrap_err().code().as_str(), "EFORMAT");
        assert_eq!(
            blit(&mut m, rect(0, 0, 2, -2), &[], Blend::Replace).unwrap_err().code().as_str(),
            "ERANGE"
        );
        // Empty rectangles request no pixels.
        assert!(read(&m, rect(i32::MIN, i32::MAX, 0, i32::MAX)).unwrap().is_empty());
        copy(&mut m, rect(-5, 0, 0, 3), [1, 1], Blend::Replace).unwrap();
        blit(&mut m, rect(0, 0, 0, 5), &[], Blend::Replace).unwrap();
        assert!(!m.is_damaged());
        assert_eq!(m.bytes(), before);
    }
}
