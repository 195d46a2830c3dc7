//! The viewport transform: NDC to pixels, its inverse, and the viewport's clip rectangle.
//!
//! Pixels are those of the frame: y down, with the centre of pixel (i, j) at (i + .5, j + .5).
//! Source: notes 001 (`centres`), the graphics APIs (`corners`).

use crate::math::coverage::PixelRect;
use crate::memory::VideoMemory;
use crate::scene::{Viewport, ViewportRule};

/// Transform of one viewport, per axis: pixel = origin + ndc * half.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ViewportTransform {
    origin: [f64; 2],
    half: [f64; 2],
    /// The viewport's pixels that lie on the frame, and in its clip rectangle.
    pub clip: PixelRect,
}

impl ViewportTransform {
    /// Creates the transform of a viewport on a frame, clipped to what drawing may touch of it.
    pub fn on(viewport: Viewport, memory: &VideoMemory) -> Self {
        let mut transform = ViewportTransform::new(viewport, memory.width(), memory.height());
        let ([columns, rows], clip) = (memory.clip(), &mut transform.clip);
        (clip.x0, clip.x1) = (clip.x0.max(columns.start as i32), clip.x1.min(columns.end as i32));
        (clip.y0, clip.y1) = (clip.y0.max(rows.start as i32), clip.y1.min(rows.end as i32));
        transform
    }

    /// Creates the transform of a viewport on a frame of the given size in pixels.
    pub fn new(viewport: Viewport, frame_width: u32, frame_height: u32) -> Self {
        let corner = [viewport.x as f64, viewport.y as f64];
        let size = [viewport.width as f64, viewport.height as f64];
        // `centres` puts pixel centres at integers; half a pixel moves them to where coverage has
        // them.
        let (inset, shift) = match viewport.rule {
            ViewportRule::Corners => (0.0, 0.0),
            ViewportRule::Centres => (1.0, 0.5),
        };
        let half = size.map(|s| (s - inset) * 0.5);
        let end = |at: i32, size: u32, frame: u32| (at as i64 + size as i64).clamp(0, frame as i64) as i32;
        ViewportTransform {
            origin: [corner[0] + shift + half[0], corner[1] + shift + half[1]],
            half: [half[0], -half[1]],
            clip: PixelRect {
                x0: viewport.x.max(0),
                y0: viewport.y.max(0),
                x1: end(viewport.x, viewport.width, frame_width),
                y1: end(viewport.y, viewport.height, frame_height),
            },
        }
    }

    /// Returns the pixel coordinates of an NDC point.
    pub fn of_ndc(&self, ndc: [f64; 2]) -> [f64; 2] {
        [self.origin[0] + ndc[0] * self.half[0], self.origin[1] + ndc[1] * self.half[1]]
    }

    /// Returns origin and half extents: pixel = origin + ndc * half.
    pub fn map(&self) -> ([f64; 2], [f64; 2]) {
        (self.origin, self.half)
    }

    /// Returns the NDC step from one pixel to the next, in x and in y.
    pub fn ndc_per_pixel(&self) -> [f64; 2] {
        self.half.map(|h| 1.0 / h)
    }

    /// Returns the NDC point at the centre of pixel (x, y); not finite for a viewport of size 0.
    #[inline]
    pub fn ndc_of_pixel(&self, x: i32, y: i32) -> [f64; 2] {
        [(x as f64 + 0.5 - self.origin[0]) / self.half[0], (y as f64 + 0.5 - self.origin[1]) / self.half[1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_rules_bound_the_drawing_and_turn_y() {
        let viewport = Viewport { x: -2, y: 3, width: 10, height: 4, rule: ViewportRule::Corners };
        let s = ViewportTransform::new(viewport, 6, 100);
        assert_eq!((s.of_ndc([-1.0, 1.0]), s.of_ndc([1.0, -1.0])), ([-2.0, 3.0], [8.0, 7.0]));
        assert_eq!(s.clip, PixelRect { x0: 0, y0: 3, x1: 6, y1: 7 });
        // Notes 001: (-1,1) is the centre of the first pixel, (1,-1) that of the last.
        let s = ViewportTransform::new(Viewport { rule: ViewportRule::Centres, ..viewport }, 6, 100);
        assert_eq!((s.of_ndc([-1.0, 1.0]), s.of_ndc([1.0, -1.0])), ([-1.5, 3.5], [7.5, 6.5]));
        assert_eq!(s.ndc_of_pixel(-2, 3), [-1.0, 1.0]);
        let far =
            Viewport { x: i32::MAX, y: i32::MIN, width: u32::MAX, height: 1, rule: ViewportRule::Corners };
        assert!(ViewportTransform::new(far, 6, 6).clip.is_empty());
    }
}
