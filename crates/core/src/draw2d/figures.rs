//! Figures as their verbs draw them: one function for each verb, with the verb's arguments in order.
//!
//! In: a verb's arguments. Out: changed pixels of a video memory, within its window of rows. The rows
//! of the verb table name these functions: they are what the engine and the framebuffer of a program
//! draw.

use super::{Arc, Area, AreaColors, Blend, DrawError, RampColor, RealRect, Rect};
use crate::executor::ThreadPool;
use crate::memory::{Rgba, VideoMemory};
use std::sync;

/// A video memory with the modes of the figures that are drawn on it.
#[derive(Debug)]
pub struct FigureTarget<'a> {
    /// The memory.
    pub memory: &'a mut VideoMemory,
    /// The blend mode.
    pub blend: Blend,
    /// Magnification of letters, 1 to 8.
    pub text_size: u8,
    /// Threads that draw a large area together, if there are some.
    pub pool: Option<&'a sync::Arc<ThreadPool>>,
}

impl FigureTarget<'_> {
    /// Draws an area by `alone`, or on the threads of the pool if it is large enough.
    #[inline(always)]
    fn area(
        &mut self,
        area: Area<'_>,
        alone: impl FnOnce(&mut VideoMemory, Blend) -> Result<(), DrawError>,
    ) -> Result<(), DrawError> {
        match self.pool {
            Some(pool) if area.is_worth_threads(self.memory, self.blend) => {
                area.draw_on_pool(pool, self.memory, self.blend)
            }
            _ => alone(self.memory, self.blend),
        }
    }
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
        let area = Area::Triangle(points, colors);
        // Never refused.
        let _ = self.area(area, |memory, blend| {
            super::fill(memory, points, colors, blend);
            Ok(())
        });
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
        self.area(Area::Rect(rect, color), |memory, blend| super::fill_rect(memory, rect, color, blend))
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
        self.area(Area::Disc([cx, cy], r, color), |memory, blend| {
            super::fill_circle(memory, [cx, cy], r, color, blend)
        })
    }

    /// Draws a polyline of `POLY`.
    pub fn poly(&mut self, color: Rgba, points: &[[i32; 2]]) {
        super::poly(self.memory, points, color, self.blend);
    }

    /// Fills a polygon of `FILLPOLY`.
    pub fn fill_poly(&mut self, color: Rgba, points: &[[f64; 2]]) {
        let area = Area::Polygon(points, color);
        // Never refused.
        let _ = self.area(area, |memory, blend| {
            super::fill_poly(memory, points, color, blend);
            Ok(())
        });
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
        self.area(Area::WideLine([p0, p1], width, color), |memory, blend| {
            super::wide_line(memory, p0, p1, width, color, blend)
        })
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
        self.area(Area::Ellipse(center, radii, color), |memory, blend| {
            super::fill_ellipse(memory, center, radii, color, blend)
        })
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
        let arc = Arc { center, radii, angles };
        self.area(Area::Arc(arc, color), |memory, blend| super::arc(memory, arc, color, blend))
    }

    /// Draws a curve of `BEZIER`.
    ///
    /// # Errors
    /// If the verb refuses its arguments.
    pub fn bezier(&mut self, points: [[f64; 2]; 4], width: f64, color: Rgba) -> Result<(), DrawError> {
        self.area(Area::Curve(points, width, color), |memory, blend| {
            super::bezier(memory, points, width, color, blend)
        })
    }

    /// Draws an anti-aliased line of `LINEAA`.
    pub fn line_aa(&mut self, p0: [f64; 2], p1: [f64; 2], color: Rgba) {
        let area = Area::SmoothLine([p0, p1], color);
        // Never refused.
        let _ = self.area(area, |memory, _| {
            super::line_aa(memory, p0, p1, color);
            Ok(())
        });
    }
}
