//! Pixels, bytes and figures of two dimensions: one method for each verb.

use super::Framebuffer;
use crate::{DrawFigure, Figure, each_figure};
use crate::{unless_written, verbs};
use fbptr_core::draw2d::{self, Arc, AreaColors, Blend, DrawError, FigureTarget, RampColor, RealRect, Rect};
use fbptr_core::memory::{FbPtr, MemoryError, Rgba};
use fbptr_formats::load::{self, LoadError};

/// Pixels and bytes. Blocks of bytes are stored unchanged, whatever the blend mode.
impl Framebuffer {
    /// Draws one pixel, as `PX x y colour` does; does nothing off the frame.
    #[doc(alias = "putPixel")]
    pub fn put_pixel(&mut self, x: i32, y: i32, color: Rgba) {
        draw2d::put_pixel(&mut self.memory, x, y, color, self.blend);
    }

    /// Reads one pixel, as `PX x y` does.
    ///
    /// # Errors
    /// If the pixel is outside the frame.
    pub fn get_pixel(&self, x: i32, y: i32) -> Result<Rgba, MemoryError> {
        self.memory.get_pixel(x, y)
    }

    /// Writes bytes at a byte offset, (width * y + x) * 4 for pixel (x, y), as `POKE` does.
    ///
    /// # Errors
    /// If a byte is outside the memory; nothing is then written.
    pub fn poke(&mut self, offset: u64, bytes: &[u8]) -> Result<(), MemoryError> {
        self.memory.poke(FbPtr::new(offset), bytes)
    }

    /// Returns `n` bytes from a byte offset on, as `PEEK` does.
    ///
    /// # Errors
    /// If a byte is outside the memory.
    pub fn peek(&self, offset: u64, n: usize) -> Result<&[u8], MemoryError> {
        self.memory.peek(FbPtr::new(offset), n)
    }

    /// Draws a rectangle of RGBA rows, as `BLIT` does.
    ///
    /// # Errors
    /// If a side is negative, or `rgba` is not width * height * 4 bytes long.
    pub fn blit(&mut self, rect: impl Into<Rect>, rgba: &[u8]) -> Result<(), DrawError> {
        draw2d::blit(&mut self.memory, rect.into(), rgba, Blend::Replace)
    }

    /// Returns the RGBA rows of a rectangle, as `READ` does.
    ///
    /// # Errors
    /// If a side is negative, or the rectangle is not entirely inside the frame.
    pub fn read(&self, rect: impl Into<Rect>) -> Result<Vec<u8>, DrawError> {
        draw2d::read(&self.memory, rect.into())
    }

    /// Copies a rectangle to the place with the upper left corner `dest`, as `COPY` does.
    ///
    /// # Errors
    /// If a side is negative, or the source is not entirely inside the frame.
    pub fn copy(&mut self, source: impl Into<Rect>, dest: [i32; 2]) -> Result<(), DrawError> {
        draw2d::copy(&mut self.memory, source.into(), dest, Blend::Replace)
    }

    /// Draws packed pixels, as `POINTS` does: 8 bytes each, x and y as u16 little-endian, r, g, b,
    /// a.
    ///
    /// # Errors
    /// If the bytes end within a pixel.
    pub fn points(&mut self, packed: &[u8]) -> Result<(), DrawError> {
        draw2d::points(&mut self.memory, packed, Blend::Replace).map(drop)
    }

    /// Stores a run of RGBA pixels from (x, y) on, over the ends of rows, as `PXMULTI` does.
    pub fn pixel_run(&mut self, x: u16, y: u16, rgba: &[u8]) {
        let _ = draw2d::pixel_run(&mut self.memory, x, y, rgba);
    }
}

/// Lines, areas and text. Colours are those of the whole figure, or of its ends or corners.
impl Framebuffer {
    pub(super) fn figures(&mut self) -> FigureTarget<'_> {
        FigureTarget {
            memory: &mut self.memory,
            blend: self.blend,
            text_size: self.text_size,
            pool: self.renderer.options().pool.as_ref(),
        }
    }

    /// Draws a line, both ends included, as `LINE` does. Two colours are a ramp between the ends.
    pub fn line(&mut self, p0: [i32; 2], p1: [i32; 2], color: impl Into<RampColor>) {
        self.figures().line(p0, p1, color.into());
    }

    /// Draws an anti-aliased line by exact coverage, as `LINEAA` does.
    pub fn line_aa(&mut self, p0: [f64; 2], p1: [f64; 2], color: Rgba) {
        self.figures().line_aa(p0, p1, color);
    }

    /// Draws the three lines of a triangle, as `TRI` does.
    pub fn triangle(&mut self, points: [[i32; 2]; 3], colors: impl Into<AreaColors>) {
        self.figures().triangle(points, colors.into());
    }

    /// Fills a triangle, as `FILL` does. Three colours are interpolated between the corners.
    pub fn fill(&mut self, points: [[f64; 2]; 3], colors: impl Into<AreaColors>) {
        self.figures().fill(points, colors.into());
    }

    /// Draws the border of a rectangle, as `RECT` does.
    ///
    /// # Errors
    /// If a side is negative.
    pub fn rect(&mut self, rect: impl Into<Rect>, color: Rgba) -> Result<(), DrawError> {
        self.figures().rect(rect.into(), color)
    }

    /// Fills the pixels whose centres lie in a rectangle, as `FILLRECT` does.
    ///
    /// # Errors
    /// If a side is negative.
    pub fn fill_rect(&mut self, rect: impl Into<RealRect>, color: Rgba) -> Result<(), DrawError> {
        self.figures().fill_rect(rect.into(), color)
    }

    /// Draws a circle about a pixel, as `CIRCLE` does.
    ///
    /// # Errors
    /// If the radius is negative.
    pub fn circle(&mut self, center: [i32; 2], radius: i32, color: Rgba) -> Result<(), DrawError> {
        self.figures().circle(center[0], center[1], radius, color)
    }

    /// Fills the pixels whose centres are nearer than `radius` to a point, as `FILLCIRCLE` does.
    ///
    /// # Errors
    /// If the radius is negative.
    pub fn fill_circle(&mut self, center: [f64; 2], radius: f64, color: Rgba) -> Result<(), DrawError> {
        self.figures().fill_circle(center[0], center[1], radius, color)
    }

    /// Draws a closed outline, as `POLY` does.
    pub fn poly(&mut self, points: &[[i32; 2]], color: Rgba) {
        self.figures().poly(color, points);
    }

    /// Fills a polygon by the even-odd rule, as `FILLPOLY` does.
    pub fn fill_poly(&mut self, points: &[[f64; 2]], color: Rgba) {
        self.figures().fill_poly(color, points);
    }

    /// Draws a line of any width with round ends, as `WIDELINE` does.
    ///
    /// # Errors
    /// If the width is negative.
    pub fn wide_line(
        &mut self,
        p0: [f64; 2],
        p1: [f64; 2],
        width: f64,
        color: Rgba,
    ) -> Result<(), DrawError> {
        self.figures().wide_line(p0, p1, width, color)
    }

    /// Draws the rim of a filled ellipse, as `ELLIPSE` does.
    ///
    /// # Errors
    /// If a radius is negative.
    pub fn ellipse(&mut self, center: [f64; 2], radii: [f64; 2], color: Rgba) -> Result<(), DrawError> {
        self.figures().ellipse(center, radii, color)
    }

    /// Fills the pixels whose centres are inside an ellipse, as `FILLELLIPSE` does.
    ///
    /// # Errors
    /// If a radius is negative.
    pub fn fill_ellipse(&mut self, center: [f64; 2], radii: [f64; 2], color: Rgba) -> Result<(), DrawError> {
        self.figures().fill_ellipse(center, radii, color)
    }

    /// Fills a part of a ring, as `ARC` does.
    ///
    /// # Errors
    /// If a radius is negative.
    pub fn arc(&mut self, arc: Arc, color: Rgba) -> Result<(), DrawError> {
        self.figures().arc(arc.center, arc.radii, arc.angles, color)
    }

    /// Draws a cubic Bezier curve of any width with round ends, as `BEZIER` does.
    ///
    /// # Errors
    /// If the width is negative, or a point is beyond [`FAR_POINT`](draw2d::FAR_POINT).
    pub fn bezier(&mut self, points: [[f64; 2]; 4], width: f64, color: Rgba) -> Result<(), DrawError> {
        self.figures().bezier(points, width, color)
    }

    /// Puts a picture with its upper left corner at (x, y), as `IMAGE` does.
    ///
    /// # Errors
    /// If the bytes are no picture.
    pub fn image(&mut self, [x, y]: [i32; 2], file: &[u8]) -> Result<(), LoadError> {
        let picture = load::texture::decode_file(file, "picture")?;
        let [w, h] = [picture.width(), picture.height()].map(|side| side as i32);
        draw2d::blit(&mut self.memory, Rect { x, y, w, h }, picture.bytes(), self.blend)
            .expect("a picture has as many bytes as its size says");
        Ok(())
    }

    /// Lets later drawing touch a rectangle alone, as `CLIP` does; with `None` the whole frame.
    pub fn set_clip(&mut self, rect: Option<Rect>) {
        let Some(Rect { x, y, w, h }) = rect else { return self.memory.end_clip() };
        let side = |start: i32, length: i32| {
            let end = (i64::from(start) + i64::from(length)).max(0);
            start.max(0) as u32..end.min(i64::from(u32::MAX)) as u32
        };
        self.memory.set_clip(side(x, w), side(y, h));
    }

    /// Draws another framebuffer with its upper left corner at `at`, but for its pixels of the
    /// colour `key`, as `STAMP` does.
    pub fn stamp(&mut self, other: &Framebuffer, at: [i32; 2], key: Option<Rgba>) {
        let [w, h] = [other.width(), other.height()].map(|side| side as i32);
        let rect = Rect { x: at[0], y: at[1], w, h };
        draw2d::stamp(&mut self.memory, rect, other.memory.bytes(), key, self.blend)
            .expect("a frame has as many bytes as its size says");
    }

    /// Sets the magnification of the letters of text, 1 to 8, as `TEXTSIZE` does.
    pub fn set_text_size(&mut self, size: u8) {
        self.text_size = size.clamp(1, 8);
    }

    /// Draws text in the built-in font of 8x8 pixels, as `TEXT` and `PRINT` do; `at` is the upper
    /// left corner of its first character. A line feed begins a new line.
    pub fn text(&mut self, at: [i32; 2], text: &str, color: Rgba) {
        self.figures()
            .text(at[0], at[1], color, text.as_bytes())
            .expect("only bytes that are not UTF-8 are refused");
    }
}

/// Makes the method of a figure.
macro_rules! figure_method {
    ($function:ident $verb:ident $variant:ident { $($f:ident : $t:ty),* }) => {
        unless_written! { $function {
            impl Framebuffer {
                #[doc = concat!("Draws a figure as `", stringify!($verb), "` does, with its arguments in order.")]
                ///
                /// # Errors
                /// If the verb refuses its arguments.
                pub fn $function(&mut self, $($f: impl Into<$t>),*) -> Result<(), DrawError> {
                    Figure::$variant { $($f: $f.into()),* }.draw(&mut self.figures())
                }
            }
        } }
    };
}
verbs! { each_figure figure_method }

impl Framebuffer {
    /// Draws a figure of the command language, such as a decoded one.
    ///
    /// # Errors
    /// If the verb refuses its arguments.
    pub fn figure(&mut self, figure: &Figure) -> Result<(), DrawError> {
        figure.draw(&mut self.figures())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Verb,
        example::{Figure, example_verbs},
    };

    // The worked example of `CONTRIBUTING.md` has its method, made from its row.
    example_verbs! { each_figure figure_method }

    #[test]
    fn a_figure_that_is_added_has_its_method_at_once() {
        let mut fb = Framebuffer::new(16, 12).unwrap();
        fb.cross(8, 6, 3, [255, 0, 0, 255]).unwrap();
        let red = (0..192).filter(|i| fb.get_pixel(i % 16, i / 16).unwrap() == [255, 0, 0, 255]);
        assert_eq!(red.collect::<Vec<_>>().len(), 13);
        assert_eq!(fb.get_pixel(8, 3).unwrap(), [255, 0, 0, 255]);
        assert!(Verb::named("CROSS").is_none(), "the example is not part of the language");
    }
}
