//! Figures of the 2-D workloads: random ones by name, and the stream of commands that draws them.
//!
//! In: a [`PlaneWork`] and a size. Out: figures with whole coordinates, the same for every program, and
//! the bytes of their stream. Whole coordinates are exact in every program and in the plain reference.

use super::super::{Size, Xorshift};
use fbptr_core::memory::Rgba;

/// A figure with whole coordinates, in pixels.
#[derive(Clone, Debug)]
pub(super) enum Figure {
    /// Left, top, width, height.
    Rect([i32; 4], Rgba),
    /// Centre and radius.
    Disc([i32; 2], i32, Rgba),
    Triangle([[i32; 2]; 3], [Rgba; 3]),
    Polygon(Vec<[i32; 2]>, Rgba),
    Line([[i32; 2]; 2], Rgba),
    SmoothLine([[i32; 2]; 2], Rgba),
    /// Two ends and a width.
    WideLine([[i32; 2]; 2], i32, Rgba),
    /// A picture of the given size, whose pixels are [`picture_pixel`], at a place.
    Picture([i32; 2], [i32; 2]),
    Text([i32; 2], String, Rgba),
    Pixel([i32; 2], Rgba),
}

/// Returns a pixel of the picture that is copied.
pub(super) fn picture_pixel(x: i32, y: i32) -> Rgba {
    [(x ^ y) as u8, (3 * x + 5 * y) as u8, (x >> 3) as u8, 255]
}

/// Workload of figures in two dimensions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaneWork {
    /// Rectangles of 400x300.
    Rects,
    /// Half transparent rectangles of 400x300.
    RectsOver,
    /// Discs of radius 60.
    Discs,
    /// Half transparent discs of radius 60.
    DiscsOver,
    /// Triangles within boxes of 160 pixels, one colour.
    Triangles,
    /// Triangles of that size in three colours.
    TrianglesThree,
    /// Triangles of that size in three half transparent colours.
    TrianglesThreeOver,
    /// Lines all over the frame.
    Lines,
    /// Anti-aliased lines all over the frame.
    SmoothLines,
    /// Lines all over the frame, 8 wide with round ends.
    WideLines,
    /// Stars of five points and radius 60.
    Stars,
    /// Pictures as large as the frame.
    Pictures,
    /// Lines of 54 letters.
    Text,
    /// One half transparent disc as high as the frame.
    LargeDiscOver,
    /// One triangle over the whole frame, in three half transparent colours.
    LargeTriangleOver,
    /// The same triangle, opaque.
    LargeTriangle,
    /// One star over the whole frame, half transparent.
    LargeStarOver,
    /// One rectangle over the whole frame.
    LargeRect,
    /// One line across the frame, as wide as a sixth of its height, half transparent.
    LargeLineOver,
    /// One anti-aliased line across the frame.
    LargeLineSmooth,
    /// Pixels, one command each.
    SmallPixels,
    /// Rectangles of 4x4.
    SmallRects,
    /// Lines of about 10 pixels.
    SmallLines,
    /// Discs of radius 3.
    SmallDiscs,
    /// Single letters.
    SmallLetters,
}

impl PlaneWork {
    /// Every workload.
    pub const ALL: [PlaneWork; 25] = [
        PlaneWork::Rects,
        PlaneWork::RectsOver,
        PlaneWork::Discs,
        PlaneWork::DiscsOver,
        PlaneWork::Triangles,
        PlaneWork::TrianglesThree,
        PlaneWork::TrianglesThreeOver,
        PlaneWork::Lines,
        PlaneWork::SmoothLines,
        PlaneWork::WideLines,
        PlaneWork::Stars,
        PlaneWork::Pictures,
        PlaneWork::Text,
        PlaneWork::LargeDiscOver,
        PlaneWork::LargeTriangleOver,
        PlaneWork::LargeTriangle,
        PlaneWork::LargeStarOver,
        PlaneWork::LargeRect,
        PlaneWork::LargeLineOver,
        PlaneWork::LargeLineSmooth,
        PlaneWork::SmallPixels,
        PlaneWork::SmallRects,
        PlaneWork::SmallLines,
        PlaneWork::SmallDiscs,
        PlaneWork::SmallLetters,
    ];

    /// Returns its name, the number of its figures at full size, and whether they are half transparent.
    const fn facts(self) -> (&'static str, usize, bool) {
        match self {
            PlaneWork::Rects => ("2d_rects", 500, false),
            PlaneWork::RectsOver => ("2d_rects_over", 500, true),
            PlaneWork::Discs => ("2d_discs", 1000, false),
            PlaneWork::DiscsOver => ("2d_discs_over", 1000, true),
            PlaneWork::Triangles => ("2d_triangles", 2000, false),
            PlaneWork::TrianglesThree => ("2d_triangles_three", 2000, false),
            PlaneWork::TrianglesThreeOver => ("2d_triangles_three_over", 2000, true),
            PlaneWork::Lines => ("2d_lines", 5000, false),
            PlaneWork::SmoothLines => ("2d_lines_aa", 1000, false),
            PlaneWork::WideLines => ("2d_lines_wide", 1000, false),
            PlaneWork::Stars => ("2d_stars", 1000, false),
            PlaneWork::Pictures => ("2d_pictures", 20, false),
            PlaneWork::Text => ("2d_text", 1000, false),
            PlaneWork::LargeDiscOver => ("2d_large_disc_over", 1, true),
            PlaneWork::LargeTriangleOver => ("2d_large_triangle_over", 1, true),
            PlaneWork::LargeTriangle => ("2d_large_triangle", 1, false),
            PlaneWork::LargeStarOver => ("2d_large_star_over", 1, true),
            PlaneWork::LargeRect => ("2d_large_rect", 1, false),
            PlaneWork::LargeLineOver => ("2d_large_line_over", 1, true),
            PlaneWork::LargeLineSmooth => ("2d_large_line_aa", 1, false),
            PlaneWork::SmallPixels => ("2d_small_pixels", 100_000, false),
            PlaneWork::SmallRects => ("2d_small_rects", 100_000, false),
            PlaneWork::SmallLines => ("2d_small_lines", 100_000, false),
            PlaneWork::SmallDiscs => ("2d_small_discs", 100_000, false),
            PlaneWork::SmallLetters => ("2d_small_letters", 100_000, false),
        }
    }

    /// Returns the name on the command line.
    pub const fn name(self) -> &'static str {
        self.facts().0
    }

    /// Returns the number of figures at full size.
    pub const fn count(self) -> usize {
        self.facts().1
    }

    /// Returns whether it is drawn under `BLEND over`, half transparent.
    pub const fn is_over(self) -> bool {
        self.facts().2
    }

    /// Returns the workloads that `name` stands for: `2d` for all, otherwise that of a whole name.
    pub fn named(name: &str) -> Vec<PlaneWork> {
        let name = name.to_ascii_lowercase();
        Self::ALL.into_iter().filter(|w| name == "2d" || w.name() == name).collect()
    }

    /// Returns its figures on a frame of this size.
    pub(super) fn figures(self, size: Size) -> Vec<Figure> {
        let count = (self.count() / size.divisor as usize).max(self.count().min(2));
        let mut random = Random { numbers: Xorshift::new(), size: [size.width as i32, size.height as i32] };
        (0..count).map(|i| random.figure(self, i)).collect()
    }
}

/// Random places and colours.
struct Random {
    numbers: Xorshift,
    size: [i32; 2],
}

impl Random {
    fn below(&mut self, n: i32) -> i32 {
        ((u64::from(self.numbers.next()) * n.max(1) as u64) >> 32) as i32
    }

    fn place(&mut self) -> [i32; 2] {
        self.size.map(|side| self.below(side))
    }

    fn near(&mut self, [x, y]: [i32; 2], reach: i32) -> [i32; 2] {
        [x + self.below(2 * reach + 1) - reach, y + self.below(2 * reach + 1) - reach]
    }

    fn color(&mut self, is_over: bool) -> Rgba {
        let [r, g, b, _] = self.numbers.next().to_le_bytes();
        [r, g, b, if is_over { 128 } else { 255 }]
    }

    fn figure(&mut self, work: PlaneWork, i: usize) -> Figure {
        use PlaneWork as W;
        let ([w, h], place, color) = (self.size, self.place(), self.color(work.is_over()));
        match work {
            W::Rects | W::RectsOver => Figure::Rect([place[0] - 200, place[1] - 150, 400, 300], color),
            W::Discs | W::DiscsOver => Figure::Disc(place, 60, color),
            W::Triangles => Figure::Triangle(self.corners(place), [color; 3]),
            W::TrianglesThree | W::TrianglesThreeOver => {
                let colors = [color, self.color(work.is_over()), self.color(work.is_over())];
                Figure::Triangle(self.corners(place), colors)
            }
            W::Lines => Figure::Line([place, self.place()], color),
            W::SmoothLines => Figure::SmoothLine([place, self.place()], color),
            W::WideLines => Figure::WideLine([place, self.place()], 8, color),
            W::Stars => Figure::Polygon(star(place, [60, 25], self.below(60)), color),
            W::Pictures => Figure::Picture([i as i32 % 7, i as i32 % 5], self.size),
            W::Text => {
                let text = (0..54).map(|_| char::from(b'!' + self.below(94) as u8)).collect();
                Figure::Text([place[0] / 2, place[1]], text, color)
            }
            W::LargeDiscOver => Figure::Disc([w / 2, h / 2], 12 * h / 25, color),
            W::LargeTriangleOver | W::LargeTriangle => {
                let colors = [color, self.color(work.is_over()), self.color(work.is_over())];
                Figure::Triangle([[-w / 2, 0], [w + w / 2, -h / 9], [w / 3, h + h]], colors)
            }
            W::LargeStarOver => Figure::Polygon(star([w / 2, h / 2], [w, 2 * w / 5], 7), color),
            W::LargeRect => Figure::Rect([0, 0, w - 1, h], color),
            W::LargeLineOver => Figure::WideLine([[w / 20, h / 9], [w - w / 20, h - h / 9]], h / 6, color),
            W::LargeLineSmooth => Figure::SmoothLine([[3, 5], [w - 4, h - 7]], color),
            W::SmallPixels => Figure::Pixel(place, color),
            W::SmallRects => Figure::Rect([place[0], place[1], 4, 4], color),
            W::SmallLines => Figure::Line([place, self.near(place, 10)], color),
            W::SmallDiscs => Figure::Disc(place, 3, color),
            W::SmallLetters => {
                Figure::Text(place, char::from(b'!' + self.below(94) as u8).to_string(), color)
            }
        }
    }

    fn corners(&mut self, place: [i32; 2]) -> [[i32; 2]; 3] {
        std::array::from_fn(|_| self.near(place, 80))
    }
}

/// Returns the ten corners of a star about a place, of the radii of its tips and of the corners between
/// them, turned by `turn` of 60 parts of a tip.
fn star([x, y]: [i32; 2], radii: [i32; 2], turn: i32) -> Vec<[i32; 2]> {
    let corner = |i: i32| {
        let angle = (f64::from(i) + f64::from(turn) / 30.0) * std::f64::consts::PI / 5.0;
        let r = f64::from(radii[i as usize % 2]);
        let (sin, cos) = libm::sincos(angle);
        [x + (r * sin).round() as i32, y - (r * cos).round() as i32]
    };
    (0..10).map(corner).collect()
}

/// Returns the stream of commands that draws figures.
pub(super) fn stream(work: PlaneWork, figures: &[Figure]) -> Vec<u8> {
    let mut out = if work.is_over() { b"BLEND over\n".to_vec() } else { Vec::new() };
    for figure in figures {
        write(&mut out, figure);
    }
    out
}

fn hex([r, g, b, a]: Rgba) -> String {
    if a == 255 { format!("{r:02x}{g:02x}{b:02x}") } else { format!("{r:02x}{g:02x}{b:02x}{a:02x}") }
}

fn write(out: &mut Vec<u8>, figure: &Figure) {
    let points =
        |points: &[[i32; 2]]| points.as_flattened().iter().map(i32::to_string).collect::<Vec<_>>().join(" ");
    let line = match figure {
        Figure::Rect([x, y, w, h], color) => format!("FILLRECT {x} {y} {w} {h} {}", hex(*color)),
        Figure::Disc([x, y], r, color) => format!("FILLCIRCLE {x} {y} {r} {}", hex(*color)),
        Figure::Triangle(corners, colors) if colors[1..] == [colors[0]; 2] => {
            format!("FILL {} {}", points(corners), hex(colors[0]))
        }
        Figure::Triangle(corners, colors) => {
            format!("FILL {} {}", points(corners), colors.map(hex).join(" "))
        }
        Figure::Polygon(corners, color) => format!("FILLPOLY {} {}", hex(*color), points(corners)),
        Figure::Line(ends, color) => format!("LINE {} {}", points(ends), hex(*color)),
        Figure::SmoothLine(ends, color) => format!("LINEAA {} {}", points(ends), hex(*color)),
        Figure::WideLine(ends, width, color) => format!("WIDELINE {} {width} {}", points(ends), hex(*color)),
        Figure::Text([x, y], text, color) => format!("PRINT {x} {y} {} {text}", hex(*color)),
        Figure::Pixel([x, y], color) => format!("PX {x} {y} {}", hex(*color)),
        Figure::Picture([x, y], [w, h]) => {
            out.extend(format!("BLIT {x} {y} {w} {h} :{}\n", w * h * 4).bytes());
            out.extend((0..*h).flat_map(|y| (0..*w).flat_map(move |x| picture_pixel(x, y))));
            String::new()
        }
    };
    out.extend(line.bytes());
    out.push(b'\n');
}
