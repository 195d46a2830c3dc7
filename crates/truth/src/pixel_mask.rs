//! Pixel mask: the pixels of a picture to be rendered.

/// All or some of a viewport's pixels.
pub struct PixelMask {
    /// Pixels that may be drawn, x0..x1 and y0..y1.
    pub clip: [i64; 4],
    width: usize,
    /// Summed-area table in rows of width + 1: at (x, y) the count of set pixels above and to the
    /// left; `None` if all are set.
    sums: Option<Vec<u32>>,
}

impl PixelMask {
    /// Creates a mask of all pixels of `clip`.
    pub fn all(clip: [i64; 4]) -> PixelMask {
        PixelMask { clip, width: 0, sums: None }
    }

    /// Creates a mask of the listed pixels of a picture of `width` x `height`, within `clip`, which
    /// lies inside the picture.
    pub fn some(clip: [i64; 4], [width, height]: [u32; 2], pixels: &[[u32; 2]]) -> PixelMask {
        let (width, height) = (width as usize, height as usize);
        let mut sums = vec![0u32; (width + 1) * (height + 1)];
        for &[x, y] in pixels.iter().filter(|p| (p[0] as usize) < width && (p[1] as usize) < height) {
            sums[(width + 1) * (y as usize + 1) + x as usize + 1] = 1;
        }
        for y in 1..=height {
            let (above, row) = sums[(width + 1) * (y - 1)..].split_at_mut(width + 1);
            let mut left = 0;
            for (here, up) in row[..=width].iter_mut().zip(above) {
                left += *here;
                *here = left + *up;
            }
        }
        PixelMask { clip, width, sums: Some(sums) }
    }

    /// Returns whether any pixel of a box inside `clip` is set; always true if all are.
    pub fn is_any_in(&self, [x0, x1, y0, y1]: [i64; 4]) -> bool {
        let Some(sums) = &self.sums else { return true };
        if x0 >= x1 || y0 >= y1 {
            return false;
        }
        let at = |x: i64, y: i64| sums[(self.width + 1) * y as usize + x as usize];
        at(x1, y1) + at(x0, y0) != at(x0, y1) + at(x1, y0)
    }

    /// Returns whether pixel (x, y) of `clip` is set.
    pub fn has(&self, x: i64, y: i64) -> bool {
        self.is_any_in([x, x + 1, y, y + 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_knows_whether_it_holds_a_wanted_pixel() {
        let pixels = [[0, 0], [4, 2], [4, 2], [2, 1], [5, 0], [0, 3]];
        let some = PixelMask::some([0, 5, 0, 3], [5, 3], &pixels);
        for (y0, y1, x0, x1) in (0..256).map(|i| (i & 3, i >> 2 & 3, i >> 4 & 3, i >> 6 & 3)) {
            let inside =
                |p: &[u32; 2]| (x0..x1).contains(&i64::from(p[0])) && (y0..y1).contains(&i64::from(p[1]));
            assert_eq!(some.is_any_in([x0, x1, y0, y1]), pixels.iter().any(inside), "{x0}..{x1} {y0}..{y1}");
        }
        assert!(some.has(4, 2) && !some.has(3, 2));
        assert!(PixelMask::all([0, 9, 0, 9]).has(3, 2));
    }
}
