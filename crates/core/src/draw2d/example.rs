//! The function of the worked example of `CONTRIBUTING.md`, as it stands there.

use super::FigureTarget;
use crate::memory::Rgba;

impl FigureTarget<'_> {
    /// Draws a cross of two lines, `r` pixels to each side of a pixel.
    pub fn cross(&mut self, x: i32, y: i32, r: i32, color: Rgba) {
        let [left, right] = [x.saturating_sub(r), x.saturating_add(r)];
        let [top, bottom] = [y.saturating_sub(r), y.saturating_add(r)];
        self.line([left, y], [right, y], color.into());
        self.line([x, top], [x, bottom], color.into());
    }
}
