//! Position of the frame in the window, and the mapping from window to frame pixels.
//!
//! The entire frame is shown at its own aspect ratio, centred in the window: enlarged by the
//! largest integer factor that fits, or, if the window is smaller than the frame, reduced (each
//! window pixel shows one frame pixel). Exact mapping: window pixel (X, Y) shows frame pixel
//! floor((X - left) * frame_width / shown_width), and likewise in y.

/// Scaling of a frame that is smaller than its window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scaling {
    /// By an integer factor, with bars at the sides: all pixels are squares of one size.
    #[default]
    Whole,
    /// To the window's width or height, sharp: pixels may differ in size by one.
    Fit,
    /// To the window's width or height, smooth: each pixel of the window is a mean of frame pixels.
    Smooth,
}

impl Scaling {
    /// Returns the next mode.
    pub fn next(self) -> Scaling {
        match self {
            Scaling::Whole => Scaling::Fit,
            Scaling::Fit => Scaling::Smooth,
            Scaling::Smooth => Scaling::Whole,
        }
    }
}

/// Position and size of the shown frame, in window pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Width and height of the frame in pixels.
    pub frame: [usize; 2],
    /// Width and height of the window in pixels.
    pub window: [usize; 2],
    /// Left and top of the shown frame in the window.
    pub origin: [usize; 2],
    /// Width and height of the shown frame in the window.
    pub shown: [usize; 2],
    /// Set to mix frame pixels where they and the window's differ in size.
    pub is_smooth: bool,
}

impl Layout {
    /// Creates the layout of a frame in a window, scaled by an integer factor; a window without
    /// area shows nothing.
    pub fn new(frame: [usize; 2], window: [usize; 2]) -> Self {
        Layout::scaled(frame, window, Scaling::Whole)
    }

    /// Creates the layout of a frame in a window; a window without area shows nothing.
    pub fn scaled(frame: [usize; 2], window: [usize; 2], scaling: Scaling) -> Self {
        let [fw, fh] = frame.map(|n| n.max(1));
        let scale = (window[0] / fw).min(window[1] / fh);
        let shown = if scale >= 1 && scaling == Scaling::Whole {
            [fw * scale, fh * scale]
        } else if window[0] * fh <= window[1] * fw {
            // The width is the limit: the height follows it, rounded, and is at least 1.
            [window[0], ((window[0] * fh + fw / 2) / fw).max(1).min(window[1])]
        } else {
            [((window[1] * fw + fh / 2) / fh).max(1).min(window[0]), window[1]]
        };
        let origin = [(window[0] - shown[0]) / 2, (window[1] - shown[1]) / 2];
        Layout { frame: [fw, fh], window, origin, shown, is_smooth: scaling == Scaling::Smooth }
    }

    /// Returns the largest integer factor, from 1 to 8, at which a frame fits a screen of `screen`
    /// pixels.
    pub fn opening_scale(frame: [usize; 2], screen: [usize; 2]) -> usize {
        (screen[0] / frame[0].max(1)).min(screen[1] / frame[1].max(1)).clamp(1, 8)
    }

    /// Returns the frame pixel at a position in the window, or `None` outside the shown frame.
    pub fn pixel_at(&self, x: f32, y: f32) -> Option<[usize; 2]> {
        let at = |v: f32, axis: usize| {
            let v = v.floor();
            let inside = v >= self.origin[axis] as f32 && v < (self.origin[axis] + self.shown[axis]) as f32;
            inside.then(|| (v as usize - self.origin[axis]) * self.frame[axis] / self.shown[axis])
        };
        Some([at(x, 0)?, at(y, 1)?])
    }

    /// Returns the frame coordinates of a position in the window, also outside the shown frame.
    /// They are rounded down, so -1 is just left of column 0.
    pub fn frame_coordinates(&self, x: f32, y: f32) -> [i32; 2] {
        let at = |v: f32, axis: usize| {
            let shown = self.shown[axis].max(1) as f32;
            ((v - self.origin[axis] as f32).floor() * self.frame[axis] as f32 / shown).floor() as i32
        };
        [at(x, 0), at(y, 1)]
    }

    /// Returns the rectangle of the window that shows at least a rectangle of the frame: left, top,
    /// right, bottom.
    pub fn window_rectangle(&self, [left, top, right, bottom]: [usize; 4]) -> [usize; 4] {
        let first = |v: usize, axis: usize| self.origin[axis] + v * self.shown[axis] / self.frame[axis];
        let end =
            |v: usize, axis: usize| self.origin[axis] + (v * self.shown[axis]).div_ceil(self.frame[axis]);
        [first(left, 0), first(top, 1), end(right, 0), end(bottom, 1)]
    }

    /// Returns the rows of the window that show rows `rows` of the frame, and no other; with smooth
    /// scaling, neighbours show them too.
    pub fn window_rows(&self, rows: std::ops::Range<usize>) -> std::ops::Range<usize> {
        let first_at_or_after = |row: usize| self.origin[1] + (row * self.shown[1]).div_ceil(self.frame[1]);
        first_at_or_after(rows.start.min(self.frame[1]))..first_at_or_after(rows.end.min(self.frame[1]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn enlarges_by_whole_factors_only_and_centres() {
        let l = Layout::new([100, 50], [350, 170]);
        assert_eq!((l.shown, l.origin), ([300, 150], [25, 10]));
        assert_eq!(l.pixel_at(25.0, 10.0), Some([0, 0]));
        assert_eq!(l.pixel_at(324.9, 159.9), Some([99, 49]));
        assert_eq!(
            (l.pixel_at(24.9, 10.0), l.pixel_at(25.0, 160.0), l.pixel_at(-1.0, f32::NAN)),
            (None, None, None)
        );
    }

    #[test]
    fn a_window_smaller_than_the_frame_keeps_the_aspect() {
        let l = Layout::new([400, 200], [100, 100]);
        assert_eq!((l.shown, l.origin), ([100, 50], [0, 25]));
        assert_eq!(l.pixel_at(99.0, 74.0), Some([396, 196]));
        let thin = Layout::new([1, 30_000], [10, 100]);
        assert!(thin.shown[0] >= 1 && thin.shown[1] <= 100);
    }

    #[test]
    fn every_window_row_belongs_to_the_frame_row_that_the_pointer_finds() {
        for (frame, window) in [([7, 5], [23, 19]), ([40, 30], [17, 11]), ([3, 3], [3, 3]), ([9, 9], [1, 1])]
        {
            let l = Layout::new(frame, window);
            for row in 0..frame[1] {
                for y in l.window_rows(row..row + 1) {
                    assert_eq!(
                        l.pixel_at(l.origin[0] as f32, y as f32).map(|p| p[1]),
                        Some(row),
                        "{l:?} {y}"
                    );
                }
            }
            assert_eq!(l.window_rows(0..frame[1]), l.origin[1]..l.origin[1] + l.shown[1]);
        }
    }

    #[test]
    fn a_rectangle_of_the_window_holds_every_pixel_of_the_frames_one() {
        for (frame, window) in [([7, 5], [23, 19]), ([40, 30], [17, 11]), ([9, 9], [1, 1])] {
            let layout = Layout::scaled(frame, window, Scaling::Fit);
            let [left, top, right, bottom] = layout.window_rectangle([2, 1, 6, 4]);
            let inside = |x: usize, y: usize| (left..right).contains(&x) && (top..bottom).contains(&y);
            for (x, y) in (0..window[0]).flat_map(|x| (0..window[1]).map(move |y| (x, y))) {
                let pixel = layout.pixel_at(x as f32, y as f32);
                if matches!(pixel, Some([px, py]) if (2..6).contains(&px) && (1..4).contains(&py)) {
                    assert!(inside(x, y), "{layout:?} {x} {y}");
                }
            }
            assert!(right - left <= 4 * layout.shown[0].div_ceil(frame[0]) + 2);
        }
    }

    #[test]
    fn a_fitted_frame_fills_one_side() {
        for (frame, window, shown) in [
            ([1280, 720], [1920, 1080], [1920, 1080]),
            ([100, 50], [350, 170], [340, 170]),
            ([100, 50], [350, 900], [350, 175]),
            ([400, 200], [100, 100], [100, 50]),
        ] {
            let l = Layout::scaled(frame, window, Scaling::Fit);
            assert_eq!(l.shown, shown, "{frame:?} in {window:?}");
            assert_eq!(l.origin, [(window[0] - shown[0]) / 2, (window[1] - shown[1]) / 2]);
        }
    }

    #[test]
    fn windows_without_area_show_nothing() {
        for window in [[0, 0], [0, 10], [10, 0]] {
            let l = Layout::new([8, 8], window);
            assert_eq!(l.pixel_at(0.0, 0.0), None);
        }
    }
}
