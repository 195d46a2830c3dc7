//! W6 and W7 on embedded-graphics, into a frame of 0x00RRGGBB words.

use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::*;
use embedded_graphics::primitives::{Line, PrimitiveStyle};
use fbptr_peers::*;
use std::convert::Infallible;

const PEER: &str = "embedded-graphics";

struct Frame(Vec<u32>);

impl OriginDimensions for Frame {
    fn size(&self) -> Size {
        Size::new(WIDTH as u32, HEIGHT as u32)
    }
}

impl DrawTarget for Frame {
    type Color = Rgb888;
    type Error = Infallible;

    #[inline]
    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(Point { x, y }, color) in pixels {
            if (x as usize) < WIDTH && (y as usize) < HEIGHT {
                self.0[y as usize * WIDTH + x as usize] =
                    u32::from(color.r()) << 16 | u32::from(color.g()) << 8 | u32::from(color.b());
            }
        }
        Ok(())
    }
}

fn main() {
    let mut frame = Frame(vec![BACKGROUND; WIDTH * HEIGHT]);
    let rgb = |[r, g, b]: [u8; 3]| Rgb888::new(r, g, b);
    for (workload, count, is_short) in [("W6_lines_long", 1_000_000, false), ("W6_lines_short", 5_000_000, true)] {
        if !is_wanted("W6") {
            continue;
        }
        let lines = lines(count, is_short);
        let point = |p: [i16; 2]| Point::new(p[0].into(), p[1].into());
        measure(PEER, workload, || {
            frame.0.fill(BACKGROUND);
            for line in &lines {
                let style = PrimitiveStyle::with_stroke(rgb(line.color), 1);
                let Ok(()) = Line::new(point(line.p0), point(line.p1)).into_styled(style).draw(&mut frame);
            }
        });
        save_picture(PEER, workload, &frame.0);
    }
    if is_wanted("W7") {
        measure(PEER, "W7_putpixel_100M", || {
            frame.0.fill(BACKGROUND);
            each_pixel(100_000_000, |x, y, color| {
                let Ok(()) = Pixel(Point::new(x, y), rgb(color)).draw(&mut frame);
            });
        });
        save_picture(PEER, "W7_putpixel_100M", &frame.0);
    }
}
