//! The framebuffer as a target of the crate `embedded-graphics`: its fonts, styles and widgets.
//!
//! Colours are RGB; pixels are stored opaque, whatever the blend mode. Pixels off the frame are
//! dropped.

use super::Framebuffer;
use embedded_graphics_core::Pixel;
use embedded_graphics_core::draw_target::DrawTarget;
use embedded_graphics_core::geometry::{OriginDimensions, Size};
use embedded_graphics_core::pixelcolor::{Rgb888, RgbColor};
use embedded_graphics_core::primitives::Rectangle;
use fbptr_core::draw2d::{self, Blend};
use std::convert::Infallible;

fn rgba(color: Rgb888) -> [u8; 4] {
    [color.r(), color.g(), color.b(), 255]
}

impl OriginDimensions for Framebuffer {
    fn size(&self) -> Size {
        Size::new(self.width(), self.height())
    }
}

impl DrawTarget for Framebuffer {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(at, color) in pixels {
            self.memory.put_pixel(at.x, at.y, rgba(color));
        }
        Ok(())
    }

    fn fill_solid(&mut self, area: &Rectangle, color: Rgb888) -> Result<(), Infallible> {
        let at = [area.top_left.x, area.top_left.y].map(f64::from);
        let size = [area.size.width, area.size.height].map(f64::from);
        let rect = draw2d::RealRect { x: at[0], y: at[1], w: size[0], h: size[1] };
        draw2d::fill_rect(&mut self.memory, rect, rgba(color), Blend::Replace)
            .expect("unsigned sizes are not negative");
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_graphics_core::geometry::Point;

    #[test]
    fn pixels_and_areas_are_stored_opaque_and_clipped() {
        let mut fb = Framebuffer::new(8, 6).unwrap();
        fb.set_blend(Blend::Over);
        let red = Rgb888::new(255, 0, 0);
        let at = |x, y| Pixel(Point::new(x, y), red);
        fb.draw_iter([at(2, 1), at(-1, 0), at(8, 0), at(0, i32::MAX)]).unwrap();
        let green = Rgb888::new(0, 200, 0);
        fb.fill_solid(&Rectangle::new(Point::new(-3, 4), Size::new(5, u32::MAX)), green).unwrap();
        let lit: Vec<_> = (0..48).map(|i| fb.get_pixel(i % 8, i / 8).unwrap()).collect();
        let expected = (0..48).map(|i| match (i % 8, i / 8) {
            (2, 1) => [255, 0, 0, 255],
            (0..2, 4..) => [0, 200, 0, 255],
            _ => [0, 0, 0, 255],
        });
        assert!(lit.into_iter().eq(expected));
        assert_eq!(OriginDimensions::size(&fb), Size::new(8, 6));
    }
}
