//! The figures: lines, areas and text, one function for each verb.
//!
//! In: a figure's arguments, and the blend mode of its session. Out: changed video memory, within
//! the rows to which it is restricted while a figure is drawn in bands.

use super::Engine;
use crate::draw2d::{self, Arc, AreaColors, DrawError, RampColor, RealRect, Rect};
use crate::memory::Rgba;
use crate::server::Session;

impl Engine {
    pub(super) fn line(&mut self, s: &mut Session, p0: [i32; 2], p1: [i32; 2], color: RampColor) {
        draw2d::line(&mut self.framebuffer.memory, p0, p1, color, s.blend);
    }

    pub(super) fn triangle(&mut self, s: &mut Session, points: [[i32; 2]; 3], colors: AreaColors) {
        draw2d::triangle_outline(&mut self.framebuffer.memory, points, colors, s.blend);
    }

    pub(super) fn fill(&mut self, s: &mut Session, points: [[f64; 2]; 3], colors: AreaColors) {
        draw2d::fill(&mut self.framebuffer.memory, points, colors, s.blend);
    }

    pub(super) fn rect(&mut self, s: &mut Session, rect: Rect, color: Rgba) -> Result<(), DrawError> {
        draw2d::rect(&mut self.framebuffer.memory, rect, color, s.blend)
    }

    pub(super) fn fill_rect(
        &mut self,
        s: &mut Session,
        rect: RealRect,
        color: Rgba,
    ) -> Result<(), DrawError> {
        draw2d::fill_rect(&mut self.framebuffer.memory, rect, color, s.blend)
    }

    pub(super) fn circle(
        &mut self,
        s: &mut Session,
        cx: i32,
        cy: i32,
        r: i32,
        color: Rgba,
    ) -> Result<(), DrawError> {
        draw2d::circle(&mut self.framebuffer.memory, [cx, cy], r, color, s.blend)
    }

    pub(super) fn fill_circle(
        &mut self,
        s: &mut Session,
        cx: f64,
        cy: f64,
        r: f64,
        color: Rgba,
    ) -> Result<(), DrawError> {
        draw2d::fill_circle(&mut self.framebuffer.memory, [cx, cy], r, color, s.blend)
    }

    pub(super) fn poly(&mut self, s: &mut Session, color: Rgba, points: &[[i32; 2]]) {
        draw2d::poly(&mut self.framebuffer.memory, points, color, s.blend);
    }

    pub(super) fn fill_poly(&mut self, s: &mut Session, color: Rgba, points: &[[f64; 2]]) {
        draw2d::fill_poly(&mut self.framebuffer.memory, points, color, s.blend);
    }

    pub(super) fn text(
        &mut self,
        s: &mut Session,
        x: i32,
        y: i32,
        color: Rgba,
        utf8: &[u8],
    ) -> Result<(), DrawError> {
        draw2d::scaled_text(&mut self.framebuffer.memory, [x, y], utf8, s.text_size, color, s.blend)
    }

    pub(super) fn print(
        &mut self,
        s: &mut Session,
        x: i32,
        y: i32,
        color: Rgba,
        text: &str,
    ) -> Result<(), DrawError> {
        self.text(s, x, y, color, text.as_bytes())
    }

    pub(super) fn wide_line(
        &mut self,
        s: &mut Session,
        p0: [f64; 2],
        p1: [f64; 2],
        width: f64,
        color: Rgba,
    ) -> Result<(), DrawError> {
        draw2d::wide_line(&mut self.framebuffer.memory, p0, p1, width, color, s.blend)
    }

    pub(super) fn ellipse(
        &mut self,
        s: &mut Session,
        center: [f64; 2],
        radii: [f64; 2],
        color: Rgba,
    ) -> Result<(), DrawError> {
        draw2d::ellipse(&mut self.framebuffer.memory, center, radii, color, s.blend)
    }

    pub(super) fn fill_ellipse(
        &mut self,
        s: &mut Session,
        center: [f64; 2],
        radii: [f64; 2],
        color: Rgba,
    ) -> Result<(), DrawError> {
        draw2d::fill_ellipse(&mut self.framebuffer.memory, center, radii, color, s.blend)
    }

    pub(super) fn arc(
        &mut self,
        s: &mut Session,
        center: [f64; 2],
        radii: [f64; 2],
        angles: [f64; 2],
        color: Rgba,
    ) -> Result<(), DrawError> {
        draw2d::arc(&mut self.framebuffer.memory, Arc { center, radii, angles }, color, s.blend)
    }

    pub(super) fn bezier(
        &mut self,
        s: &mut Session,
        points: [[f64; 2]; 4],
        width: f64,
        color: Rgba,
    ) -> Result<(), DrawError> {
        draw2d::bezier(&mut self.framebuffer.memory, points, width, color, s.blend)
    }

    pub(super) fn line_aa(&mut self, _: &mut Session, p0: [f64; 2], p1: [f64; 2], color: Rgba) {
        draw2d::line_aa(&mut self.framebuffer.memory, p0, p1, color);
    }
}
