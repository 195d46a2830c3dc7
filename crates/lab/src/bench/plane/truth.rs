//! The 2-D workloads drawn by their definitions, pixel by pixel, in whole numbers.
//!
//! In: figures with whole coordinates. Out: the picture, and the number of pixels that were drawn.
//! Nothing is shared with what draws but the font's table: every pixel near a figure is tested by
//! itself. Areas of anti-aliased lines are those of the rectangle cut by the pixel's square, in f64.

use super::figures::{Figure, picture_pixel};
use fbptr_core::draw2d::font;
use fbptr_core::memory::{Rgba, VideoMemory};
use std::ops::Range;

/// The picture being drawn.
pub(super) struct Plain {
    pub memory: VideoMemory,
    /// Pixels drawn, each as often as a figure drew it.
    pub pixels: u64,
    is_over: bool,
}

impl Plain {
    /// Begins with a cleared picture.
    pub fn new(memory: VideoMemory, is_over: bool) -> Self {
        Plain { memory, pixels: 0, is_over }
    }

    fn put(&mut self, x: i32, y: i32, color: Rgba, is_over: bool) {
        let Ok(dest) = self.memory.get_pixel(x, y) else { return };
        let a = u32::from(color[3]);
        let mix = |s: u8, d: u8| ((u32::from(s) * a + u32::from(d) * (255 - a) + 127) / 255) as u8;
        let color = match is_over {
            true => {
                [mix(color[0], dest[0]), mix(color[1], dest[1]), mix(color[2], dest[2]), mix(255, dest[3])]
            }
            false => color,
        };
        self.memory.put_pixel(x, y, color);
        self.pixels += 1;
    }

    /// Draws the pixels of a box for which `color` returns one.
    fn each(&mut self, xs: Range<i32>, ys: Range<i32>, color: impl Fn(i64, i64) -> Option<Rgba>) {
        let (xs, ys) = (self.columns(xs), self.rows(ys));
        for y in ys {
            for x in xs.clone() {
                if let Some(color) = color(x.into(), y.into()) {
                    self.put(x, y, color, self.is_over);
                }
            }
        }
    }

    fn columns(&self, xs: Range<i32>) -> Range<i32> {
        xs.start.max(0)..xs.end.min(self.memory.width() as i32)
    }

    fn rows(&self, ys: Range<i32>) -> Range<i32> {
        ys.start.max(0)..ys.end.min(self.memory.height() as i32)
    }

    pub fn draw(&mut self, figure: &Figure) {
        match figure {
            &Figure::Rect([x, y, w, h], color) => self.each(x..x + w, y..y + h, |_, _| Some(color)),
            &Figure::Disc([cx, cy], r, color) => self.each(cx - r..cx + r, cy - r..cy + r, |x, y| {
                let d = [2 * x + 1 - 2 * i64::from(cx), 2 * y + 1 - 2 * i64::from(cy)];
                (d[0] * d[0] + d[1] * d[1] < 4 * i64::from(r).pow(2)).then_some(color)
            }),
            Figure::Triangle(corners, colors) => {
                let [xs, ys] = bounds(corners);
                let (corners, colors) = (*corners, *colors);
                self.each(xs, ys, |x, y| is_inside(&corners, x, y).then(|| mixed(&corners, &colors, x, y)));
            }
            Figure::Polygon(corners, color) => {
                let [xs, ys] = bounds(corners);
                self.each(xs, ys, |x, y| is_inside(corners, x, y).then_some(*color));
            }
            &Figure::Line(ends, color) => self.line(ends, color),
            &Figure::SmoothLine(ends, color) => self.smooth_line(ends, color),
            &Figure::WideLine(ends, width, color) => {
                for (y, xs) in self.rows_about(ends, f64::from(width) / 2.0) {
                    self.each(xs, y..y + 1, |x, y| is_near(ends, width.into(), x, y).then_some(color));
                }
            }
            &Figure::Picture([left, top], [w, h]) => self.each(left..left + w, top..top + h, |x, y| {
                Some(picture_pixel(x as i32 - left, y as i32 - top))
            }),
            Figure::Text([left, top], text, color) => {
                for (i, letter) in text.chars().enumerate() {
                    let (glyph, left) = (font::glyph(letter), left + 8 * i as i32);
                    self.each(left..left + 8, *top..top + 8, |x, y| {
                        let row = glyph[(y - i64::from(*top)) as usize];
                        (row << (x - i64::from(left)) & 0x80 != 0).then_some(*color)
                    });
                }
            }
            &Figure::Pixel([x, y], color) => self.put(x, y, color, false),
        }
    }

    /// Draws a line: for each step along the longer side the nearest pixel, a tie to the second end's
    /// side of the first.
    fn line(&mut self, [[mut x, mut y], [x1, y1]]: [[i32; 2]; 2], color: Rgba) {
        let (dx, dy) = ((x1 - x).abs(), -(y1 - y).abs());
        let (step_x, step_y) = ((x1 - x).signum(), (y1 - y).signum());
        let mut error = dx + dy;
        loop {
            self.put(x, y, color, self.is_over);
            if [x, y] == [x1, y1] {
                return;
            }
            let twice = 2 * error;
            if twice > dy {
                (error, x) = (error + dy, x + step_x);
            }
            if twice < dx {
                (error, y) = (error + dx, y + step_y);
            }
        }
    }

    /// Returns the rows of a segment widened by `reach` with their columns, and a little more.
    fn rows_about(&self, [[ax, ay], [bx, by]]: [[i32; 2]; 2], reach: f64) -> Vec<(i32, Range<i32>)> {
        let (reach, [ax, ay, bx, by]) = (reach + 2.0, [ax, ay, bx, by].map(f64::from));
        let rows = self.rows((ay.min(by) - reach) as i32..(ay.max(by) + reach) as i32 + 1);
        rows.map(|y| {
            let at = |level: f64| if ay == by { 0.0 } else { ((level - ay) / (by - ay)).clamp(0.0, 1.0) };
            let ends = if ay == by {
                [ax, bx]
            } else {
                [-reach, reach].map(|d| ax + (bx - ax) * at(f64::from(y) + d))
            };
            (y, (ends[0].min(ends[1]) - reach) as i32..(ends[0].max(ends[1]) + reach) as i32 + 1)
        })
        .collect()
    }

    fn smooth_line(&mut self, ends: [[i32; 2]; 2], color: Rgba) {
        let [a, b] = ends.map(|p| p.map(f64::from));
        let d = [b[0] - a[0], b[1] - a[1]];
        let length = (d[0] * d[0] + d[1] * d[1]).sqrt();
        if length == 0.0 {
            return;
        }
        let n = [-d[1] / length / 2.0, d[0] / length / 2.0];
        let corners = [(a, 1.0), (b, 1.0), (b, -1.0), (a, -1.0)];
        let corners = corners.map(|(p, side)| [p[0] + side * n[0], p[1] + side * n[1]]);
        for (y, xs) in self.rows_about(ends, 0.5) {
            for x in self.columns(xs) {
                let coverage = (area_in_square(&corners, x, y).min(1.0) * 255.0 + 0.5) as u32;
                let alpha = (coverage * u32::from(color[3]) + 127) / 255;
                if alpha > 0 {
                    self.put(x, y, [color[0], color[1], color[2], alpha as u8], true);
                }
            }
        }
    }
}

/// Returns the columns and rows of the points' box.
fn bounds(points: &[[i32; 2]]) -> [Range<i32>; 2] {
    [0, 1].map(|axis| {
        let along = || points.iter().map(|p| p[axis]);
        along().min().unwrap_or(0)..along().max().unwrap_or(0)
    })
}

/// Returns whether a pixel's centre is inside an outline, even-odd: on the right of an odd number of the
/// edges that cross its row, or on them.
fn is_inside(points: &[[i32; 2]], x: i64, y: i64) -> bool {
    let wide = |p: &[i32; 2]| p.map(|v| 2 * i64::from(v));
    let (px, py) = (2 * x + 1, 2 * y + 1);
    let edges = points.iter().zip(points.iter().cycle().skip(1));
    let crossed = edges.filter(|(a, b)| {
        let (a, b) = (wide(a), wide(b));
        let (top, bottom) = if a[1] <= b[1] { (a, b) } else { (b, a) };
        let is_in_row = top[1] <= py && py < bottom[1];
        is_in_row && (px - top[0]) * (bottom[1] - top[1]) >= (py - top[1]) * (bottom[0] - top[0])
    });
    crossed.count() % 2 == 1
}

/// Returns the colour of a triangle's pixel, rounded to the nearest, halves up.
fn mixed(corners: &[[i32; 2]; 3], colors: &[Rgba; 3], x: i64, y: i64) -> Rgba {
    let p = corners.map(|p| p.map(|v| 2 * i64::from(v)));
    let centre = [2 * x + 1, 2 * y + 1];
    let doubled =
        |a: [i64; 2], b: [i64; 2], c: [i64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    let whole = doubled(p[0], p[1], p[2]);
    let parts = [doubled(centre, p[1], p[2]), doubled(p[0], centre, p[2]), doubled(p[0], p[1], centre)];
    std::array::from_fn(|k| {
        let sum: i64 = (0..3).map(|i| i64::from(colors[i][k]) * parts[i]).sum();
        (2 * sum * whole.signum() + whole.abs()).div_euclid(2 * whole.abs()) as u8
    })
}

/// Returns whether a pixel's centre is nearer than half of `width` to a segment, or as near on its upper
/// side, on the left one of an upright segment.
fn is_near(ends: [[i32; 2]; 2], width: i64, x: i64, y: i64) -> bool {
    // In halves of a pixel.
    let [a, b] = ends.map(|p| p.map(|v| i128::from(2 * v)));
    let p = [2 * x + 1, 2 * y + 1].map(i128::from);
    let sub = |p: [i128; 2], q: [i128; 2]| [p[0] - q[0], p[1] - q[1]];
    let dot = |p: [i128; 2], q: [i128; 2]| p[0] * q[0] + p[1] * q[1];
    let (d, from_a, from_b) = (sub(b, a), sub(p, a), sub(p, b));
    let (along, square, reach) = (dot(from_a, d), dot(d, d), i128::from(width).pow(2));
    if along < 0 || square == 0 {
        return dot(from_a, from_a) < reach;
    }
    if along > square {
        return dot(from_b, from_b) < reach;
    }
    let cross = from_a[0] * d[1] - from_a[1] * d[0];
    let up = if d[0] == 0 { -d[1] } else { d[0] };
    let is_upper = cross != 0 && (cross > 0) == (up > 0);
    cross * cross < reach * square || is_upper && cross * cross == reach * square
}

/// Returns the area that a convex polygon has in common with the square about (x, y).
fn area_in_square(corners: &[[f64; 2]], x: i32, y: i32) -> f64 {
    let mut polygon = corners.to_vec();
    for (axis, at, sign) in [(0, x, 1.0), (0, x, -1.0), (1, y, 1.0), (1, y, -1.0)] {
        // What is on the inner side of a border, half a pixel from the centre.
        let depth = |p: &[f64; 2]| sign * (p[axis] - f64::from(at)) + 0.5;
        let mut inner = Vec::with_capacity(8);
        for (p, q) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
            let (from, to) = (depth(p), depth(q));
            if from >= 0.0 {
                inner.push(*p);
            }
            if (from > 0.0 && to < 0.0) || (from < 0.0 && to > 0.0) {
                let t = from / (from - to);
                inner.push([0, 1].map(|i| p[i] + (q[i] - p[i]) * t));
            }
        }
        polygon = inner;
    }
    let pairs = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let from = |p: &[f64; 2]| [p[0] - f64::from(x), p[1] - f64::from(y)];
    pairs.map(|(p, q)| (from(p), from(q))).map(|(p, q)| p[0] * q[1] - p[1] * q[0]).sum::<f64>().abs() / 2.0
}
