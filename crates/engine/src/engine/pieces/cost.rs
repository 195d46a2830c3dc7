//! Estimates of the time that commands on the video memory take.
//!
//! In: a command, the frame's size and clip, and the connection's settings. Out: whether the command
//! is long enough to run in pieces. The estimate must not miss a command that takes long: one would
//! know by `benches/waits.py`, where another client then waits.

use crate::Session;
use crate::engine::Engine;
use fbptr_command::{AreaColors, Command, Figure, RealRect};
use fbptr_core::draw2d::{self, Blend};

/// Estimated nanoseconds from which a command runs in pieces.
const LONG_NS: u64 = 2_000_000;
/// Estimated nanoseconds of a pixel of a line, each in a memory page of its own at worst; and of a row
/// of a curve beside its pixels.
const LINE_PIXEL_NS: u64 = 40;
const ROW_NS: u64 = 1000;

impl Engine {
    /// Returns whether a command of so many estimated nanoseconds runs in pieces.
    pub(in crate::engine) fn is_long_ns(ns: u64) -> bool {
        ns > LONG_NS
    }

    /// Returns whether a command may take so long that others should not wait for all of it. To be
    /// asked on the surface of its verb.
    pub(in crate::engine) fn is_long(&self, s: &Session, command: &Command) -> bool {
        use Command as C;
        let frame = self.framebuffer.area();
        let cost = match command {
            C::Figure(figure) => self.figure_ns(s, figure),
            C::Clear { .. } | C::Crc { rect: None } => frame / 4,
            C::Crc { rect: Some(rect) } => self.framebuffer.visible(*rect) / 4,
            C::Read { rect } => self.framebuffer.visible(*rect),
            C::Copy { source, .. } => self.framebuffer.visible(*source),
            C::Stamp { name, x, y, .. } => {
                let rect = self.stamped_rect(s, name, [*x, *y]);
                rect.map_or(0, |rect| self.framebuffer.visible(rect)) * composed(s)
            }
            C::Blit { rect, .. } => self.framebuffer.visible(*rect),
            C::PixelRun { rgba, .. } => rgba.len() as u64 / 4,
            C::Points { packed } => packed.len() as u64,
            C::Peek { n, .. } => u64::try_from(*n).unwrap_or(0) * 2,
            _ => return false,
        };
        Engine::is_long_ns(cost)
    }

    /// Estimates the nanoseconds of a figure, rather too many than too few. To be asked on its surface.
    #[allow(unreachable_patterns, reason = "a new figure has no estimate of its own at first")]
    pub(in crate::engine) fn figure_ns(&self, s: &Session, figure: &Figure) -> u64 {
        let composed = composed(s);
        let [width, height] = [self.framebuffer.width(), self.framebuffer.height()].map(u64::from);
        match figure {
            Figure::FillRect { rect: RealRect { x, y, w, h }, .. } => {
                self.visible_box([*x, *y], [x + w, y + h]).0 * composed / 2
            }
            Figure::FillCircle { cx, cy, r, .. } => {
                self.visible_box([cx - r, cy - r], [cx + r, cy + r]).0 * composed / 2
            }
            Figure::Fill { points, colors } => {
                let (pixels, is_near) = self.visible_of(points);
                let per_pixel = if matches!(colors, AreaColors::Three(_)) { 2 } else { 1 };
                match is_near {
                    true => pixels * per_pixel * composed,
                    // Coordinates need arbitrary precision, so each row may be expensive.
                    false => pixels * 64,
                }
            }
            Figure::FillPoly { points, .. } => {
                let (pixels, _) = self.visible_of(points);
                pixels * composed + height * points.len() as u64 * 32
            }
            Figure::Text { utf8, .. } => utf8.len() as u64 * 8 * u64::from(s.text_size).pow(2),
            Figure::FillEllipse { center: [cx, cy], radii: [rx, ry], .. } => {
                self.visible_box([cx - rx, cy - ry], [cx + rx, cy + ry]).0 * composed / 2
            }
            Figure::Arc { center: [cx, cy], radii: [_, r], .. } => {
                let (pixels, is_near) = self.visible_box([cx - r, cy - r], [cx + r, cy + r]);
                if is_near { pixels * composed } else { pixels * 64 }
            }
            Figure::WideLine { p0, p1, width, .. } => {
                let (pixels, is_near) = self.visible_stroke(&[*p0, *p1], *width);
                if is_near { pixels * composed } else { pixels * 64 }
            }
            Figure::Bezier { points, width, .. } => {
                // Up to 8192 steps, each of which may meet every row; unseen ones are computed, too.
                let (pixels, _) = self.visible_stroke(points, *width);
                let step = if pixels > 0 { 4000 } else { 100 };
                pixels * composed + draw2d::bezier_steps(points) * step
            }
            Figure::Ellipse { center: [cx, cy], radii: [rx, ry], .. } => {
                let (pixels, is_near) = self.visible_box([cx - rx, cy - ry], [cx + rx, cy + ry]);
                if is_near { pixels.min(height * ROW_NS) } else { pixels * 64 }
            }
            Figure::Line { .. }
            | Figure::LineAa { .. }
            | Figure::Triangle { .. }
            | Figure::Rect { .. }
            | Figure::Circle { .. } => (width + height) * LINE_PIXEL_NS,
            Figure::Poly { points, .. } => self.outline_pixels(points) * LINE_PIXEL_NS / 2,
            Figure::Print { text, .. } => text.len() as u64 * 64 * u64::from(s.text_size).pow(2) * composed,
            // A figure that is not named here may be as large as the target.
            _ => self.framebuffer.area() * composed,
        }
    }

    /// Returns an upper bound of the pixels of a closed outline.
    fn outline_pixels(&self, points: &[[i32; 2]]) -> u64 {
        let most = u64::from(self.framebuffer.width().max(self.framebuffer.height()));
        let side = |a: i32, b: i32| u64::from(a.abs_diff(b)).min(most);
        let pairs = points.iter().zip(points.iter().cycle().skip(1));
        pairs.map(|(p, q)| side(p[0], q[0]).max(side(p[1], q[1]))).sum()
    }

    /// Returns the number of visible pixels in the bounding box of points, and whether all of them
    /// are close enough for fixed-width integers.
    fn visible_of(&self, points: &[[f64; 2]]) -> (u64, bool) {
        let [low, high] = bounds(points);
        self.visible_box(low, high)
    }

    /// Returns the same of the points nearer than half a width to some points' bounding box.
    fn visible_stroke<const N: usize>(&self, points: &[[f64; 2]; N], width: f64) -> (u64, bool) {
        let reach = width / 2.0;
        let [low, high] = bounds(points);
        self.visible_box(low.map(|v| v - reach), high.map(|v| v + reach))
    }

    /// Returns an upper bound of the visible pixels of a box, and whether its corners are close enough for
    /// fixed-width integers.
    fn visible_box(&self, low: [f64; 2], high: [f64; 2]) -> (u64, bool) {
        let size = [self.framebuffer.width(), self.framebuffer.height()].map(f64::from);
        // One more instead of rounding up, which is a call where the CPU has no instruction for it.
        let side = |i: usize| match high[i].min(size[i]) - low[i].max(0.0) {
            length if length > 0.0 => length as u32 as u64 + 1,
            _ => 0,
        };
        let is_near = low.iter().chain(&high).all(|v| v.abs() < f64::from(1 << 20));
        (side(0) * side(1), is_near)
    }
}

/// Returns the factor of the time of a pixel by the blend mode.
fn composed(s: &Session) -> u64 {
    if s.blend == Blend::Over { 2 } else { 1 }
}

/// Returns the corners of the bounding box of points.
fn bounds(points: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for p in points {
        (low, high) = ([0, 1].map(|i| low[i].min(p[i])), [0, 1].map(|i| high[i].max(p[i])));
    }
    [low, high]
}
