//! Colours and counts of all pixels of a picture, and pictures made from them, for the subcommands:
//! their own code is built without optimization, so loops over pixels are here.
//!
//! In: pictures, of one size where there are two. Out: counts, colours, new pictures. Right is what
//! the plain loop gives, which each of them is; the tests below have a picture of four pixels.

use fbptr_core::memory::{MemoryError, Rgba, VideoMemory};
use std::collections::HashMap;

fn pixels(memory: &VideoMemory) -> &[Rgba] {
    memory.bytes().as_chunks::<4>().0
}

fn is_black(pixel: &Rgba) -> bool {
    pixel[..3] == [0; 3]
}

/// Returns the colour of the first pixel that is not black.
pub fn first_not_black(memory: &VideoMemory) -> Option<Rgba> {
    pixels(memory).iter().copied().find(|pixel| !is_black(pixel))
}

/// Returns whether all pixels are black, or of the colour `or`.
pub fn is_all_black(memory: &VideoMemory, or: Option<Rgba>) -> bool {
    pixels(memory).iter().all(|pixel| is_black(pixel) || Some(*pixel) == or)
}

/// Returns whether all pixels have this colour.
pub fn is_all(memory: &VideoMemory, color: Rgba) -> bool {
    pixels(memory).iter().all(|pixel| *pixel == color)
}

/// Returns the commonest colour; the first one of several.
pub fn commonest(memory: &VideoMemory) -> Rgba {
    let mut counts: HashMap<Rgba, usize> = HashMap::new();
    pixels(memory).iter().for_each(|pixel| *counts.entry(*pixel).or_default() += 1);
    let most = counts.values().max().copied().unwrap_or(0);
    pixels(memory).iter().find(|pixel| counts[*pixel] == most).copied().unwrap_or([0; 4])
}

/// Returns the number of pixels of which a channel differs by more than `allowed`.
pub fn count_wrong(mine: &VideoMemory, exact: &VideoMemory, allowed: u8) -> usize {
    let differs = |(m, e): (&Rgba, &Rgba)| m.iter().zip(e).any(|(m, e)| m.abs_diff(*e) > allowed);
    pixels(mine).iter().zip(pixels(exact)).filter(|pair| differs(*pair)).count()
}

/// Returns the number of pixels that have another colour than the background in either picture.
pub fn count_drawn(mine: &VideoMemory, exact: &VideoMemory, background: Rgba) -> usize {
    let is_drawn = |(m, e): (&Rgba, &Rgba)| *m != background || *e != background;
    pixels(mine).iter().zip(pixels(exact)).filter(|pair| is_drawn(*pair)).count()
}

/// Returns a picture in black and white.
pub fn black_and_white(mut memory: VideoMemory) -> VideoMemory {
    for pixel in memory.bytes_mut().as_chunks_mut::<4>().0 {
        let shade = if is_black(pixel) { 0 } else { 255 };
        *pixel = [shade, shade, shade, 255];
    }
    memory
}

/// Returns a picture of which each pixel is the mean of `times` by `times` of the given one.
///
/// # Errors
/// The smaller picture has no pixels, or there is no memory for it.
pub fn mean(large: &VideoMemory, times: u32) -> Result<VideoMemory, MemoryError> {
    let mut memory = VideoMemory::new(large.width() / times, large.height() / times)?;
    let (width, from, n) = (large.width() as usize, pixels(large), times as usize);
    let columns = memory.width() as usize;
    for (at, pixel) in memory.bytes_mut().as_chunks_mut::<4>().0.iter_mut().enumerate() {
        let (x, y) = (at % columns * n, at / columns * n);
        for (channel, value) in pixel.iter_mut().enumerate() {
            let places = (0..n * n).map(|k| (y + k / n) * width + x + k % n);
            let sum: usize = places.map(|place| usize::from(from[place][channel])).sum();
            *value = ((sum + n * n / 2) / (n * n)) as u8;
        }
    }
    Ok(memory)
}

/// Copies what is outside of a region of x, y, width and height, so that nothing there differs.
pub fn take_outside(mine: &mut VideoMemory, exact: &VideoMemory, [x, y, w, h]: [u32; 4]) {
    let width = exact.width() as usize;
    let inside = |at: usize| {
        let (px, py) = ((at % width) as u32, (at / width) as u32);
        (x..x + w).contains(&px) && (y..y + h).contains(&py)
    };
    let to = mine.bytes_mut().as_chunks_mut::<4>().0;
    let pairs = to.iter_mut().zip(pixels(exact)).enumerate();
    pairs.filter(|(at, _)| !inside(*at)).for_each(|(_, (to, from))| *to = *from);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: u32, colors: &[Rgba]) -> VideoMemory {
        let mut memory = VideoMemory::new(width, colors.len() as u32 / width).unwrap();
        memory.bytes_mut().copy_from_slice(colors.as_flattened());
        memory
    }

    const BLACK: Rgba = [0, 0, 0, 255];
    const RED: Rgba = [200, 0, 0, 255];
    const PINK: Rgba = [202, 0, 3, 255];

    #[test]
    fn colours_are_found_and_counted() {
        let (mine, exact) = (picture(2, &[BLACK, RED, PINK, RED]), picture(2, &[BLACK, RED, RED, BLACK]));
        assert_eq!((first_not_black(&mine), first_not_black(&picture(1, &[BLACK]))), (Some(RED), None));
        assert!(is_all_black(&exact, Some(RED)) && !is_all_black(&mine, Some(RED)));
        assert!(!is_all_black(&exact, None) && is_all_black(&picture(1, &[BLACK, [0, 0, 0, 7]]), None));
        assert!(is_all(&picture(1, &[RED, RED]), RED) && !is_all(&mine, RED));
        assert_eq!((commonest(&mine), commonest(&exact)), (RED, BLACK));
        assert_eq!([0, 2, 3, 202].map(|allowed| count_wrong(&mine, &exact, allowed)), [2, 2, 1, 0]);
        assert_eq!(count_drawn(&mine, &exact, BLACK), 3);
    }

    #[test]
    fn new_pictures_have_the_pixels_that_they_should() {
        let mine = picture(2, &[BLACK, RED, PINK, RED]);
        let white = [255; 4];
        assert_eq!(black_and_white(mine.clone()).bytes(), [BLACK, white, white, white].as_flattened());
        assert_eq!(mean(&mine, 2).unwrap().bytes(), [151, 0, 1, 255]);
        let mut taken = mine.clone();
        take_outside(&mut taken, &picture(2, &[PINK; 4]), [1, 0, 1, 1]);
        assert_eq!(taken.bytes(), [PINK, RED, PINK, PINK].as_flattened());
    }
}
