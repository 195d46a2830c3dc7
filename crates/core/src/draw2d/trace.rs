//! Trace of a figure at one pixel: the numbers by which it was drawn there, as in a textbook.
//!
//! In: a figure's arguments and a pixel. Out: text, or `None` where the figure does not draw the
//! pixel. LINE and CIRCLE print the decision variable at every step up to the pixel, LINEAA the area
//! of the pixel that the line covers, FILL the three edge functions and who owns an edge, FILLPOLY
//! the crossings of the pixel's row.
//!
//! Right is: a figure has a text exactly where it draws. The tests compare all pixels of figures
//! with the drawn memory, and the variable's walk with the drawn line. The numbers are computed
//! from the definitions, not by the functions that draw.

use super::line_aa::coverage_at;
use super::{AreaColors, RampColor};
use crate::math::bresenham::BresenhamLine;
use crate::memory::Rgba;
use std::fmt::Write as _;

/// Number of steps at most that are printed; of longer walks, the last ones.
const STEPS: u64 = 400;

fn color_text([r, g, b, a]: Rgba) -> String {
    format!("{r} {g} {b} {a} = #{r:02x}{g:02x}{b:02x}{a:02x}")
}

/// Appends a line; a `String` takes all.
macro_rules! put {
    ($out:ident, $($arg:tt)*) => {
        let _ = writeln!($out, $($arg)*);
    };
}

/// Traces the line of [`super::line`] at pixel (x, y).
pub fn trace_line(p0: [i32; 2], p1: [i32; 2], color: RampColor, at: [i32; 2]) -> Option<String> {
    let line = BresenhamLine::new(p0.map(i64::from), p1.map(i64::from));
    let (major, minor) = if line.is_x_major { (0, 1) } else { (1, 0) };
    let step = (i64::from(at[major]) - i64::from(p0[major])) * line.major.sign;
    let (n, m) = (line.major.steps, line.minor.steps);
    let step = u64::try_from(step).ok().filter(|k| *k <= n)?;
    if line.at(step) != at.map(i64::from) {
        return None;
    }
    let names = ["x", "y"];
    let sign = |s: i64| if s < 0 { '-' } else { '+' };
    let [a, b] = [names[major], names[minor]];
    let mut out =
        format!("line ({}, {}) ({}, {}), pixel ({}, {})\n", p0[0], p0[1], p1[0], p1[1], at[0], at[1]);
    put!(
        out,
        "octant      {a} is the longer axis, n = |d{a}| = {n}, and {b} the shorter, m = |d{b}| = {m}; steps are \
         {a}{}1 and {b}{}1",
        sign(line.major.sign),
        sign(line.minor.sign)
    );
    let [n2, m2] = [n, m].map(|v| 2 * i128::from(v));
    put!(out, "decision    d = 2m - n = {} at first", m2 - i128::from(n));
    put!(out, "            d > 0: {b} makes a step too, d += 2m - 2n = {}; else d += 2m = {m2}", m2 - n2);
    put!(out, "   step        x        y            d");
    let first = if step < STEPS { 0 } else { step - STEPS + 1 };
    if first > 0 {
        put!(out, "    ...  ({first} steps before)");
    }
    for k in first..=step {
        let [x, y] = line.at(k);
        // d after k steps, of which so many were made along the minor axis too.
        let made = i128::from(line.minor_at(k).0);
        let d = m2 * (i128::from(k) + 1) - i128::from(n) - n2 * made;
        put!(out, "{k:>7} {x:>8} {y:>8} {d:>12}");
    }
    let off = match n {
        0 => 0.0,
        _ => (i128::from(line.minor_at(step).0) * n2 - i128::from(step) * m2) as f64 / n2 as f64,
    };
    put!(out, "distance    {off:+.3} pixel from the ideal line along {b}, towards its step; at most 1/2");
    match color.to.filter(|to| *to != color.from) {
        None => {
            put!(out, "colour      {}", color_text(color.from));
        }
        Some(to) => {
            let mix: Rgba = std::array::from_fn(|c| {
                let (from, to, n, k) =
                    (i128::from(color.from[c]), i128::from(to[c]), i128::from(n.max(1)), i128::from(step));
                ((2 * (from * n + (to - from) * k) + n).div_euclid(2 * n)) as u8
            });
            put!(out, "colour      c0 + (c1 - c0) {step}/{n} = {}", color_text(mix));
        }
    }
    Some(out)
}

/// Traces the circle of [`super::circle`] at pixel (x, y).
pub fn trace_circle([cx, cy]: [i32; 2], r: i32, color: Rgba, at: [i32; 2]) -> Option<String> {
    let radius = i128::from(u32::try_from(r).ok()?);
    let (dx, dy) = (i128::from(at[0]) - i128::from(cx), i128::from(at[1]) - i128::from(cy));
    let (a, b) = (dx.abs().min(dy.abs()), dx.abs().max(dy.abs()));
    // b is the integer nearest to the root of r^2 - a^2.
    let of = |a: i128| {
        let square = radius * radius - a * a;
        (square >= 0).then(|| ((4 * square).isqrt() + 1) / 2)
    };
    if of(a)? != b {
        return None;
    }
    let mut out = format!("circle of radius {r} about ({cx}, {cy}), pixel ({}, {})\n", at[0], at[1]);
    put!(
        out,
        "octant      0 <= a <= b of 8: the pixel is a = |d{}| = {a}, b = |d{}| = {b} from the centre",
        if dx.abs() <= dy.abs() { "x" } else { "y" },
        if dx.abs() <= dy.abs() { "y" } else { "x" }
    );
    put!(out, "decision    d = (a + 1)^2 + (b - 1/2)^2 - r^2, less 1/4: 1 - r = {} at first", 1 - radius);
    put!(out, "            d < 0: d += 2a + 3; else b falls by 1, d += 2(a - b) + 5");
    put!(out, "      a        b            d");
    let first = (a - i128::from(STEPS) + 1).max(0);
    if first > 0 {
        put!(out, "    ...  ({first} steps before)");
    }
    for a in first..=a {
        let b = of(a)?;
        put!(out, "{a:>7} {b:>8} {:>12}", (a + 1) * (a + 1) + b * b - b - radius * radius);
    }
    let ideal = ((radius * radius - a * a) as f64).sqrt();
    put!(out, "distance    {:+.3} pixel from the ideal circle along b", b as f64 - ideal);
    put!(out, "colour      {}", color_text(color));
    Some(out)
}

/// Traces the line of [`super::line_aa`] at pixel (x, y) of a frame of `size`.
pub fn trace_line_aa(size: [u32; 2], [p0, p1]: [[f64; 2]; 2], color: Rgba, at: [i32; 2]) -> Option<String> {
    let area = coverage_at(size, p0, p1, at)?;
    let coverage = (area * 255.0 + 0.5) as u16;
    let alpha = (coverage * u16::from(color[3]) + 127) / 255;
    if alpha == 0 {
        return None;
    }
    let [dx, dy] = [p1[0] - p0[0], p1[1] - p0[1]];
    let length = dx.hypot(dy);
    let [px, py] = [f64::from(at[0]) - p0[0], f64::from(at[1]) - p0[1]];
    let mut out = format!(
        "line ({}, {}) ({}, {}), anti-aliased, pixel ({}, {})\n",
        p0[0], p0[1], p1[0], p1[1], at[0], at[1]
    );
    put!(out, "line        u = ({:.6}, {:.6}), length {length:.4}, one pixel wide", dx / length, dy / length);
    put!(
        out,
        "centre      {:.4} along u, {:.4} to its side",
        (px * dx + py * dy) / length,
        (py * dx - px * dy) / length
    );
    put!(out, "coverage    the pixel's square has {area:.6} of its area in the line: {coverage} of 255");
    put!(out, "alpha       {coverage} * {} / 255 = {alpha}", color[3]);
    put!(
        out,
        "colour      {}, composed over what is there",
        color_text([color[0], color[1], color[2], alpha as u8])
    );
    Some(out)
}

/// Snaps a coordinate to 1/256 pixel; `None` beyond what the trace prints.
fn snapped(v: f64) -> Option<i128> {
    (v.abs() < 1e12).then(|| (v * 256.0).round_ties_even() as i128)
}

fn snapped_point([x, y]: [f64; 2]) -> Option<[i128; 2]> {
    Some([snapped(x)?, snapped(y)?])
}

/// Returns the centre of a pixel in 1/256 pixel.
fn center(at: [i32; 2]) -> [i128; 2] {
    at.map(|v| i128::from(v) * 256 + 128)
}

fn cross(a: [i128; 2], b: [i128; 2], c: [i128; 2]) -> i128 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Traces the triangle of [`super::fill`] at pixel (x, y).
pub fn trace_fill(points: [[f64; 2]; 3], colors: AreaColors, at: [i32; 2]) -> Option<String> {
    let [a, b, c] = points.map(snapped_point);
    let p = [a?, b?, c?];
    let area = cross(p[0], p[1], p[2]);
    let turn = area.signum();
    let centre = center(at);
    let mut out = format!("triangle, pixel ({}, {})\n", at[0], at[1]);
    for (i, [x, y]) in p.iter().enumerate() {
        put!(out, "corner {i}    ({}, {}), snapped to ({x}, {y}) / 256", points[i][0], points[i][1]);
    }
    let turning =
        if turn > 0 { "clockwise on the screen" } else { "counter-clockwise, so signs are reversed" };
    put!(out, "area        {area} / 65536 / 2 square pixels: {turning}");
    put!(out, "centre      ({}, {}) / 256", centre[0], centre[1]);
    let mut values = [0; 3];
    for i in 0..3 {
        // Edge i is opposite corner i; inside is positive.
        let (from, to) = (p[(i + 1) % 3], p[(i + 2) % 3]);
        let e = cross(from, to, centre) * turn;
        values[i] = e;
        let [dx, dy] = [(to[0] - from[0]) * turn, (to[1] - from[1]) * turn];
        // With y down and the inside on the right of its direction.
        let kind = match (dy.signum(), dx.signum()) {
            (0, 1) => "a top edge",
            (-1, _) => "a left edge",
            _ => "no top or left edge",
        };
        let owns = kind != "no top or left edge";
        let verdict = match e.signum() {
            1 => "inside".to_owned(),
            -1 => return None,
            _ if owns => format!("the centre lies on it, and {kind} belongs to this triangle"),
            _ => return None,
        };
        put!(out, "edge {i}      e{i} = {e}, {kind}: {verdict}");
    }
    if turn == 0 {
        return None;
    }
    let color = match colors {
        AreaColors::One(color) => color_text(color),
        AreaColors::Three(c) => {
            let total = area * turn;
            let weights = values.map(|e| e as f64 / total as f64);
            put!(
                out,
                "weights     {:.6} {:.6} {:.6}: each edge function over the area",
                weights[0],
                weights[1],
                weights[2]
            );
            color_text(std::array::from_fn(|k| {
                let sum: i128 = (0..3).map(|i| values[i] * i128::from(c[i][k])).sum();
                (2 * sum + total).div_euclid(2 * total) as u8
            }))
        }
    };
    put!(out, "colour      {color}");
    Some(out)
}

/// Traces the polygon of [`super::fill_poly`] at pixel (x, y).
pub fn trace_fill_poly(points: &[[f64; 2]], color: Rgba, at: [i32; 2]) -> Option<String> {
    let p = points.iter().map(|p| snapped_point(*p)).collect::<Option<Vec<_>>>()?;
    let [x, y] = center(at);
    let mut crossings = Vec::new();
    for i in 0..p.len() {
        let j = (i + 1) % p.len();
        let (top, bottom) = if p[i][1] <= p[j][1] { (p[i], p[j]) } else { (p[j], p[i]) };
        if top[1] <= y && y < bottom[1] {
            // The centre lies on the edge or to its right: the crossing is at or before it.
            let is_before = cross(top, bottom, [x, y]) <= 0;
            let t = (y - top[1]) as f64 / (bottom[1] - top[1]) as f64;
            let place = top[0] as f64 + (bottom[0] - top[0]) as f64 * t;
            crossings.push((place / 256.0, [i, j], is_before));
        }
    }
    crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let before = crossings.iter().filter(|c| c.2).count();
    if before % 2 == 0 {
        return None;
    }
    let mut out = format!("polygon of {} points, pixel ({}, {})\n", points.len(), at[0], at[1]);
    put!(
        out,
        "row         y = {}: edges cross it from their upper end on, their lower end left out",
        y as f64 / 256.0
    );
    for (place, [i, j], is_before) in &crossings {
        let side = if *is_before { "at or left of the centre" } else { "right of it" };
        put!(out, "crossing    x = {place:.4} by the edge from point {i} to {j}: {side}");
    }
    put!(out, "centre      x = {}: {before} crossings before it, odd: inside (even-odd)", x as f64 / 256.0);
    put!(out, "colour      {}", color_text(color));
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw2d::{self, Blend};
    use crate::memory::VideoMemory;

    const C: Rgba = [10, 200, 30, 255];
    const D: Rgba = [250, 20, 90, 255];
    const SIZE: [u32; 2] = [20, 16];

    /// Compares where a figure draws, and its colour, with the traces.
    #[track_caller]
    fn assert_traced(draw: impl Fn(&mut VideoMemory), trace: impl Fn([i32; 2]) -> Option<String>) {
        let mut memory = VideoMemory::new(SIZE[0], SIZE[1]).unwrap();
        memory.clear([1, 2, 3, 255]);
        draw(&mut memory);
        for (x, y) in (0..16).flat_map(|y| (0..20).map(move |x| (x, y))) {
            let found = memory.get_pixel(x, y).unwrap();
            match trace([x, y]) {
                None => assert_eq!(found, [1, 2, 3, 255], "({x}, {y}) is drawn and has no trace"),
                Some(text) if text.contains("composed over") => {}
                Some(text) => assert!(text.contains(&color_text(found)), "({x}, {y}) {found:?}: {text}"),
            }
        }
    }

    #[test]
    fn lines_in_all_octants_and_their_colours() {
        for (x, y) in (-3..8).flat_map(|x| (-3..8).map(move |y| (x * 3 - 2, y * 2 - 1))) {
            let color = RampColor { from: C, to: Some(D) };
            assert_traced(
                |m| draw2d::line(m, [9, 7], [x, y], color, Blend::Replace),
                |at| trace_line([9, 7], [x, y], color, at),
            );
        }
    }

    #[test]
    fn the_decision_variable_is_bresenhams() {
        let text = trace_line([0, 0], [7, -3], C.into(), [6, -3]).unwrap();
        let rows: Vec<Vec<i64>> = text
            .lines()
            .filter_map(|l| l.split_whitespace().map(|w| w.parse().ok()).collect::<Option<Vec<i64>>>())
            .collect();
        let (mut d, mut y) = (2 * 3 - 7, 0);
        for (k, row) in rows.iter().enumerate() {
            assert_eq!(*row, [k as i64, k as i64, y, d], "{text}");
            if d > 0 {
                y -= 1;
                d -= 14;
            }
            d += 6;
        }
        assert_eq!(rows.len(), 7, "{text}");
        assert!(text.contains("n = |dx| = 7") && text.contains("y-1"), "{text}");
        // Far ends, and a long walk.
        let text =
            trace_line([-2_000_000_000, -2_000_000_000], [2_000_000_000, 2_000_000_000], C.into(), [5, 5]);
        assert!(text.unwrap().contains("steps before"));
    }

    #[test]
    fn circles_and_their_variable() {
        for r in 0..12 {
            assert_traced(
                |m| draw2d::circle(m, [9, 8], r, C, Blend::Replace).unwrap(),
                |at| trace_circle([9, 8], r, C, at),
            );
        }
        let text = trace_circle([0, 0], 8, C, [5, 6]).unwrap();
        let rows: Vec<Vec<i64>> = text
            .lines()
            .filter_map(|l| l.split_whitespace().map(|w| w.parse().ok()).collect::<Option<Vec<i64>>>())
            .collect();
        let (mut b, mut d) = (8, 1 - 8);
        for (a, row) in (0..).zip(&rows) {
            assert_eq!(*row, [a, b, d], "{text}");
            if d < 0 {
                d += 2 * a + 3;
            } else {
                d += 2 * (a - b) + 5;
                b -= 1;
            }
        }
        assert_eq!(rows.len(), 6);
        assert_eq!(trace_circle([0, 0], -1, C, [0, 0]), None);
    }

    #[test]
    fn anti_aliased_lines() {
        let (p0, p1) = ([2.25, 3.0], [16.5, 11.75]);
        assert_traced(|m| draw2d::line_aa(m, p0, p1, C), |at| trace_line_aa(SIZE, [p0, p1], C, at));
        let text = trace_line_aa(SIZE, [[0.0, 5.0], [10.0, 5.0]], C, [4, 5]).unwrap();
        assert!(text.contains("1.000000 of its area") && text.contains("255 * 255 / 255 = 255"), "{text}");
    }

    #[test]
    fn triangles_of_both_windings_and_the_owner_of_an_edge() {
        let corners = [[2.5, 1.5], [17.5, 4.5], [6.5, 13.5]];
        for points in [corners, [corners[0], corners[2], corners[1]], [[0.5, 0.5], [12.5, 0.5], [0.5, 12.5]]]
        {
            for colors in [AreaColors::One(C), AreaColors::Three([C, D, [0, 0, 255, 255]])] {
                assert_traced(
                    |m| draw2d::fill(m, points, colors, Blend::Replace),
                    |at| trace_fill(points, colors, at),
                );
            }
        }
        let text = trace_fill([[0.5, 0.5], [12.5, 0.5], [0.5, 12.5]], C.into(), [3, 0]).unwrap();
        assert!(text.contains("lies on it, and a top edge belongs"), "{text}");
        assert_eq!(trace_fill([[1.0, 1.0], [5.0, 5.0], [9.0, 9.0]], C.into(), [3, 3]), None);
    }

    #[test]
    fn polygons_by_their_crossings() {
        let star = [[9.5, 0.5], [14.5, 14.5], [1.5, 5.5], [17.5, 5.5], [4.5, 14.5]];
        assert_traced(|m| draw2d::fill_poly(m, &star, C, Blend::Replace), |at| trace_fill_poly(&star, C, at));
        let square = [[2.0, 2.0], [10.5, 2.0], [10.5, 9.5], [2.0, 9.5]];
        assert_traced(
            |m| draw2d::fill_poly(m, &square, C, Blend::Replace),
            |at| trace_fill_poly(&square, C, at),
        );
        assert_eq!(trace_fill_poly(&[], C, [0, 0]), None);
    }
}
