//! The look of a window's frame: its pixels as they are, or as a cathode ray tube shows them.
//!
//! In: a frame, its layout in the window. Out: the window's words. Uses no window system.

use super::layout::{Layout, Scaling};
use super::scanout;
use fbptr_core::draw2d::crt::{Crt, square_size};
use std::ops::Range;

/// Window pixels for each pixel of a frame from which on a tube's lines and mask are complete.
const CRT_SCALE: usize = 3;
/// Screen size that a window of a tube may take, in pixels.
const LARGE_SCREEN: [usize; 2] = [1920, 1440];

/// Look of a frame on the screen.
#[derive(Debug, Default)]
pub struct ScreenLook {
    is_crt: bool,
    /// Tables of the sizes that were shown last.
    crt: Option<Crt>,
}

impl ScreenLook {
    /// Creates a look.
    pub fn new(is_crt: bool) -> Self {
        ScreenLook { is_crt, crt: None }
    }

    /// Returns whether the frame is shown as a tube shows it.
    pub fn is_crt(&self) -> bool {
        self.is_crt
    }

    /// Sets whether the frame is shown as a tube shows it. Returns whether that changed.
    pub fn set_crt(&mut self, is_crt: bool) -> bool {
        std::mem::replace(&mut self.is_crt, is_crt) != is_crt
    }

    /// Returns the size that a window of scale 1 has for a frame.
    pub fn natural_size(&self, frame: [usize; 2]) -> [usize; 2] {
        if self.is_crt { square_size(frame) } else { frame }
    }

    /// Returns the window pixels for each pixel of a frame at which a window opens: as many as a
    /// usual screen has room for, and for a tube as many as show its lines and mask, if a large
    /// screen has room for them.
    pub fn opening_scale(&self, frame: [usize; 2], screen: [usize; 2]) -> usize {
        let scale = |screen| Layout::opening_scale(self.natural_size(frame), screen);
        if self.is_crt { scale(screen).max(scale(LARGE_SCREEN).min(CRT_SCALE)) } else { scale(screen) }
    }

    /// Returns the layout of a frame in a window: at the aspect ratio that it has on a tube, if it
    /// is shown as one shows it.
    pub fn layout(&self, frame: [usize; 2], window: [usize; 2], scaling: Scaling) -> Layout {
        Layout { frame, ..Layout::scaled(self.natural_size(frame), window, scaling) }
    }

    /// Converts frame rows `rows` of `rgba`, the entire frame, into `words`, the entire window.
    /// Words outside the shown frame are not changed.
    pub fn convert(&mut self, rgba: &[u8], layout: &Layout, rows: Range<usize>, words: &mut [u32]) {
        if !self.is_crt {
            return scanout::convert(rgba, layout, rows, words);
        }
        let Layout { frame, window, origin, shown, .. } = *layout;
        if shown.contains(&0) {
            return;
        }
        let crt = match self.crt.take().filter(|crt| crt.is_of(frame, shown)) {
            Some(crt) => self.crt.insert(crt),
            None => self.crt.insert(Crt::new(frame, shown)),
        };
        for y in crt.screen_rows(rows) {
            let start = (origin[1] + y) * window[0] + origin[0];
            let Some(row) = words.get_mut(start..start + shown[0]) else { return };
            crt.row(rgba, y, row);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_converted_alone_make_the_same_picture_inside_the_bars() {
        for (size, window) in
            [([5, 4], [17, 13]), ([5, 4], [3, 2]), ([320, 2], [330, 9]), ([6, 6], [40, 6]), ([1, 1], [3, 5])]
        {
            let rgba: Vec<u8> = (0..size[0] * size[1] * 4).map(|i| (i * 37) as u8).collect();
            let mut look = ScreenLook::new(true);
            for scaling in [Scaling::Whole, Scaling::Fit] {
                let layout = look.layout(size, window, scaling);
                let (mut whole, mut parts) = (vec![0xdead; window[0] * window[1]], Vec::new());
                parts.clone_from(&whole);
                look.convert(&rgba, &layout, 0..size[1], &mut whole);
                (0..size[1]).for_each(|row| look.convert(&rgba, &layout, row..row + 1, &mut parts));
                assert_eq!(parts, whole, "{size:?} in {window:?}");
                for (i, word) in whole.iter().enumerate() {
                    let is_inside = layout.pixel_at((i % window[0]) as f32, (i / window[0]) as f32).is_some();
                    assert_eq!(*word != 0xdead, is_inside, "{size:?} in {window:?}: word {i}");
                }
            }
        }
    }

    #[test]
    fn a_mode_of_a_tube_is_laid_out_at_its_aspect_by_this_look_alone() {
        let shown = |is_crt, window| ScreenLook::new(is_crt).layout([320, 200], window, Scaling::Whole).shown;
        assert_eq!([shown(false, [960, 720]), shown(true, [960, 720])], [[960, 600], [960, 720]]);
        assert_eq!(shown(true, [100, 90]), [100, 75]);
        let layout = ScreenLook::new(true).layout([320, 200], [960, 720], Scaling::Whole);
        assert_eq!(layout.pixel_at(959.0, 719.0), Some([319, 199]));
    }

    #[test]
    fn a_window_opens_with_room_for_the_lines_of_a_tube() {
        let scale = |is_crt, frame| ScreenLook::new(is_crt).opening_scale(frame, [1280, 800]);
        assert_eq!([scale(false, [640, 480]), scale(true, [640, 480])], [1, 3]);
        assert_eq!([scale(false, [320, 200]), scale(true, [320, 200])], [4, 3]);
        assert_eq!([scale(false, [80, 50]), scale(true, [80, 50])], [8, 8]);
        assert_eq!([scale(true, [800, 600]), scale(true, [1920, 1080])], [2, 1], "no room for more");
    }

    #[test]
    fn a_change_of_the_look_or_the_size_is_followed() {
        let (rgba, mut look) = (vec![200; 4 * 4 * 4], ScreenLook::default());
        let shown = |look: &mut ScreenLook, window: [usize; 2]| {
            let layout = look.layout([4, 4], window, Scaling::Whole);
            let mut words = vec![0; window[0] * window[1]];
            look.convert(&rgba, &layout, 0..4, &mut words);
            words
        };
        assert!(shown(&mut look, [16, 16]).iter().all(|word| *word == 0x00c8_c8c8));
        assert!(look.set_crt(true) && !look.set_crt(true) && look.is_crt());
        let (large, small) = (shown(&mut look, [16, 16]), shown(&mut look, [8, 8]));
        assert!(large.iter().any(|word| *word != 0x00c8_c8c8) && small != large[..64]);
        assert!(look.set_crt(false));
        assert!(shown(&mut look, [16, 16]).iter().all(|word| *word == 0x00c8_c8c8));
    }
}
