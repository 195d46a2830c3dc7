//! Figures as their verbs draw them: one function for each verb, with the verb's arguments in order.
//!
//! In: a verb's arguments. Out: changed pixels of a video memory, within its window of rows. The rows
//! of the verb table name these functions: they are what the engine and the framebuffer of a program
//! draw.

use super::{Arc, AreaColors, Blend, DrawError, RampColor, RealRect, Rect};
use crate::memory::{Rgba, VideoMemory};

/// A video memory with the modes of the figures that are drawn on it.
#[derive(Debug)]
pub struct FigureTarget<'a> {
    /// The memory.
    pub memory: &'a mut VideoMemory,
    /// The blend mode.
    pub blend: Blend,
    /// Magnification of letters, 1 to 8.
    pub text_size: u8,
}

impl FigureTarget<'_> {
    /// Draws a line of `LINE`.
    pub fn line(&mut self, p0: [i32; 2], p1: [i32; 2], color: RampColor) {
        super::line(self.memory, p0, p1, color, self.blend);
    }

    /// Draws an outline of `TRI`.
    pub fn triangle(&mut self, points: [[i32; 2]; 3], colors: AreaColors) {
        super::triangle_outline(self.memory, points, colors, self.blend);
    }

    /// Fills a triangle of `FILL`.
    pub fn fill(&mut self, points: [[f64; 2]; 3], colors: AreaColors) {
        super::fill(self.memory, points, colors, self.blend);
    }

    /// Draws an outline of `RECT`.
    ///
    /// # Errors
    /// If the verb refuses its arguments.
    pub fn rect(&mut self, rect: Rect, color: Rgba) -> Result<(), DrawError> {
        super::rect(self.memory, rect, color, self.blend)
    }

    /// Fills a rectangle of `FILLRECT`.
    ///
    /// # Errors
    /// If the verb refuses its arguments.
    pub fn fill_rect(&mut self, rect: RealRect, color: Rgba) -> Result<(), DrawError> {
        super::fill_rect(self.memory, rect, color, self.blend)
    }

    /// Draws a circle of `CIRCLE`.
    ///
    /// # Errors
    /// If the verb refuses its arguments.
    pub fn circle(&mut self, cx: i32, cy: i32, r: i32, color: Rgba) -> Result<(), DrawError> {
        super::circle(self.memory, [cx, cy], r, color, self.blend)
    }

    /// Fills a disc of `FILLCIRCLE`.
    ///
    /// # Errors
    /// If the verb refuses its arguments.
    pub fn fill_circle(&mut self, cx: f64, cy: f64, r: f64, color: Rgba) -> Result<(), DrawError> {
        super::fill_circle(self.memory, [cx, cy], r, color, self.blend)
    }

    /// Draws a polyline of `POLY`.
    pub fn poly(&mut self, color: Rgba, points: &[[i32; 2]]) {
        super::poly(self.memory, points, color, self.blend);
    }

    /// Fills a polygon of `FILLPOLY`.
    pub fn fill_poly(&mut self, color: Rgba, points: &[[f64; 2]]) {
        super::fill_poly(self.memory, points, color, self.blend);
    }

    /// Draws UTF-8 text of `TEXT`.
    ///
    /// # Errors
    /// If the verb refuses its arguments.
    pub fn text(&mut self, x: i32, y: i32, color: Rgba, utf8: &[u8]) -> Result<(), DrawError> {
        super::scaled_text(self.memory, [x, y], utf8, self.text_size, color, self.blend)
    }

    /// Draws the text of `PRINT`.
    ///
    /// # Errors
    /// If the verb refuses its arguments.
    pub fn print(&mut self, x: i32, y: i32, color: Rgba, text: &str) -> Result<(), DrawError> {
        self.text(x, y, color, text.as_bytes())
    }

    /// Draws a line of some width of `WIDELINE`.
    ///
    /// # Errors
    /// If the verb refuses its arguments.
    pub fn wide_line(
        &mut self,
        p0: [f64; 2],
        p1: [f64; 2],
        width: f64,
        color: Rgba,
    ) -> Result<(), DrawError> {
        super::wide_line(self.memory, p0, p1, width, color, self.blend)
    }

    /// Draws an ellipse of `ELLIPSE`.
    ///
    /// # Errors
    /// If the verb refuses its arguments.
    pub fn ellipse(&mut self, center: [f64; 2], radii: [f64; 2], color: Rgba) -> Result<(), DrawError> {
        super::ellipse(self.memory, center, radii, color, self.blend)
    }

    /// Fills an ellipse of `FILLELLIPSE`.
    ///
    /// # Errors
    /// If the verb refuses its arguments.
    pub fn fill_ellipse(&mut self, center: [f64; 2], radii: [f64; 2], color: Rgba) -> Result<(), DrawError> {
        super::fill_ellipse(self.memory, center, radii, color, self.blend)
    }

    /// Draws an arc of `ARC`.
    ///
    /// # Errors
    /// If the verb refuses its arguments.
    pub fn arc(
        &mut self,
        center: [f64; 2],
        radii: [f64; 2],
        angles: [f64; 2],
        color: Rgba,
    ) -> Result<(), DrawError> {
        super::arc(self.memory, Arc { center, radii, angles }, color, self.blend)
    }

    /// Draws a curve of `BEZIER`.
    ///
    /// # Errors
    /// If the verb refuses its arguments.
    pub fn bezier(&mut self, points: [[f64; 2]; 4], width: f64, color: Rgba) -> Result<(), DrawError> {
        super::bezier(self.memory, points, width, color, self.blend)
    }

    /// Draws an anti-aliased line of `LINEAA`.
    pub fn line_aa(&mut self, p0: [f64; 2], p1: [f64; 2], color: Rgba) {
        super::line_aa(self.memory, p0, p1, color);
    }
}
