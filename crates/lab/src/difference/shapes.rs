//! The geometry of an exact picture, and what it tells about a wrong pixel.
//!
//! In: lines, circles and faces on the screen. A line's ends and a circle's middle are pixels; a
//! face's corners are in pixels from the frame's corner, so that pixel (x, y) has its centre at
//! (x + 1/2, y + 1/2). Out: a [`Verdict`] for each wrong pixel that they explain.
//!
//! The distance of a pixel from an ideal line is measured along the minor axis, as Bresenham's
//! decision variable does: a pixel of the line has at most 1/2; where two have exactly 1/2, both are
//! right. Edge functions are integers on corners snapped to 1/256 pixel, so that a centre on an edge
//! has exactly 0.

use super::pixels::{Pixels, pixel};
use super::{Class, distance};
use fbptr_core::memory::Rgba;
use std::cell::RefCell;
use std::collections::HashMap;
use std::fmt;

/// Figure on the screen.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Line between two pixels, both included.
    Line {
        /// The two pixels.
        ends: [[i32; 2]; 2],
        /// Colours at the ends; `None` where they are not known, as those of a scene's lines.
        colors: Option<[Rgba; 2]>,
        /// True if it is composed over what is there.
        is_blended: bool,
    },
    /// Circle of one pixel's width.
    Circle {
        /// Pixel in the middle.
        center: [i32; 2],
        /// Radius in pixels.
        radius: i32,
        /// Colour.
        color: Rgba,
        /// True if it is composed over what is there.
        is_blended: bool,
    },
    /// Triangle.
    Face {
        /// Corners in pixels.
        corners: [[f64; 2]; 3],
        /// Its colour, if it has one only.
        color: Option<Rgba>,
        /// True if it is composed over what is there.
        is_blended: bool,
        /// Number of a scene's triangle, whose colour is asked for.
        number: Option<u64>,
    },
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Shape::Line { ends: [[x0, y0], [x1, y1]], .. } => {
                write!(f, "the line from ({x0}, {y0}) to ({x1}, {y1})")
            }
            Shape::Circle { center: [x, y], radius, .. } => {
                write!(f, "the circle of radius {radius} about ({x}, {y})")
            }
            Shape::Face { number: Some(n), .. } => write!(f, "triangle {n}"),
            Shape::Face { corners: [a, b, c], .. } => write!(
                f,
                "the triangle ({}, {}) ({}, {}) ({}, {})",
                a[0] as f32, a[1] as f32, b[0] as f32, b[1] as f32, c[0] as f32, c[1] as f32
            ),
        }
    }
}

/// A scene's triangle as it would be seen at one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Its bytes, over black if it is transparent.
    pub color: Rgba,
    /// Opacity, 1 for an opaque one.
    pub opacity: f64,
    /// Depth, 0 near and 1 far.
    pub z: f64,
}

/// Geometry of a picture.
pub struct Geometry<'a> {
    /// Figures in drawing order.
    pub shapes: Vec<Shape>,
    /// Returns what a scene's triangle shows at a pixel that it covers.
    pub surface: &'a dyn Fn(u64, [u32; 2]) -> Option<Surface>,
    /// True if the picture shows nothing else.
    pub is_complete: bool,
}

/// Cause of one wrong pixel.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Verdict {
    pub class: Class,
    /// Distance in pixels from the ideal line or the edge.
    pub distance: Option<f64>,
    /// The figure.
    pub subject: String,
    /// True if the geometry alone decides: a centre exactly on an edge.
    pub is_certain: bool,
}

/// Side of the squares, in pixels, that the figures are sorted into.
const CELL: i64 = 16;
/// Number of entries of squares; pictures with more are judged by their pixels alone.
const ENTRIES: usize = 4_000_000;
/// Coordinates beyond which a figure is not looked at.
const FAR: f64 = 1_000_000.0;
/// Difference up to which a found colour is taken for an expected one.
const STEPS: u8 = 2;
/// Number of triangles that are asked for their colour at one pixel.
const LAYERS: usize = 8;

/// The figures of a picture, by squares of the frame.
pub(super) struct Judge<'a> {
    geometry: &'a Geometry<'a>,
    pixels: &'a Pixels<'a>,
    cells: HashMap<[i64; 2], Vec<u32>>,
    /// Lines that were looked at as a whole, by their addresses.
    lines: RefCell<HashMap<*const Shape, Presence>>,
}

/// Part of a line that is in a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Presence {
    /// Some of it, in its place or one beside it.
    Some,
    /// Nothing but perhaps its ends, which other lines may have.
    Nothing,
    /// Nothing in its colour, but something else.
    OtherColors,
}

/// A place on an ideal line or circle.
struct Along {
    /// Twice the signed distance along the minor axis, and its divisor.
    twice: i64,
    divisor: i64,
    /// Steps from the first end, and their number.
    step: i64,
    steps: i64,
    /// Step along the minor axis.
    minor: [i64; 2],
    /// Step along the major axis.
    major: [i64; 2],
}

impl Along {
    fn distance(&self) -> f64 {
        self.twice.unsigned_abs() as f64 / (2 * self.divisor) as f64
    }

    fn is_inside(&self) -> bool {
        (0..=self.steps).contains(&self.step)
    }
}

/// Returns where a pixel is on a line.
fn along(ends: &[[i32; 2]; 2], at: [i64; 2]) -> Along {
    let [a, b] = ends.map(|end| end.map(i64::from));
    let d = [b[0] - a[0], b[1] - a[1]];
    let m = usize::from(d[1].abs() > d[0].abs());
    let n = 1 - m;
    let steps = d[m].abs();
    let sign = if d[m] < 0 { -1 } else { 1 };
    let step = (at[m] - a[m]) * sign;
    let divisor = steps.max(1);
    // Minor axis: at - a - d step/steps, times the divisor.
    let off = (at[n] - a[n]) * divisor - d[n] * step;
    let unit = |axis: usize, v: i64| if axis == 0 { [v, 0] } else { [0, v] };
    let minor = unit(n, if off > 0 { -1 } else { 1 });
    Along { twice: 2 * off, divisor, step, steps, minor, major: unit(m, sign) }
}

fn moved(at: [i64; 2], by: [i64; 2], times: i64) -> [i64; 2] {
    [at[0] + by[0] * times, at[1] + by[1] * times]
}

fn mix(colors: &[Rgba; 2], step: i64, steps: i64) -> Rgba {
    let t = if steps == 0 { 0.0 } else { step as f64 / steps as f64 };
    std::array::from_fn(|c| {
        let [a, b] = colors.map(|color| f64::from(color[c]));
        (a + (b - a) * t).round() as u8
    })
}

/// Composes a colour of an opacity 0..1 over another.
fn over(color: [f64; 3], opacity: f64, below: Rgba) -> [f64; 3] {
    std::array::from_fn(|c| color[c] * opacity + f64::from(below[c]) * (1.0 - opacity))
}

impl<'a> Judge<'a> {
    pub fn new(geometry: &'a Geometry<'a>, pixels: &'a Pixels<'a>) -> Self {
        let mut cells: HashMap<[i64; 2], Vec<u32>> = HashMap::new();
        let mut entries = 0;
        for (i, shape) in (0u32..).zip(&geometry.shapes) {
            let Some([x0, y0, x1, y1]) = bounds(shape, pixels.size) else { continue };
            for y in y0.div_euclid(CELL)..=y1.div_euclid(CELL) {
                for x in x0.div_euclid(CELL)..=x1.div_euclid(CELL) {
                    cells.entry([x, y]).or_default().push(i);
                    entries += 1;
                }
            }
            if entries > ENTRIES {
                cells.clear();
                break;
            }
        }
        Judge { geometry, pixels, cells, lines: RefCell::default() }
    }

    /// Returns the figures near a pixel, the latest drawn first.
    fn near(&self, at: [u32; 2]) -> impl Iterator<Item = &'a Shape> {
        let cell = at.map(|v| i64::from(v).div_euclid(CELL));
        let numbers = self.cells.get(&cell).map_or(&[][..], |list| list);
        numbers.iter().rev().map(|&i| &self.geometry.shapes[i as usize])
    }

    fn mine(&self, at: [i64; 2]) -> Option<Rgba> {
        pixel(self.pixels.mine, at[0], at[1])
    }

    fn exact(&self, at: [i64; 2]) -> Option<Rgba> {
        pixel(self.pixels.exact, at[0], at[1])
    }

    /// Returns whether a pixel and its neighbour are exchanged where an ideal line passes midway.
    pub fn is_tie(&self, at: [u32; 2]) -> bool {
        let place = at.map(i64::from);
        let is_same = |a: Option<Rgba>, b: Option<Rgba>| match (a, b) {
            (Some(a), Some(b)) => self.pixels.is_same(a, b),
            _ => a == b,
        };
        self.near(at).any(|shape| {
            let Shape::Line { ends, .. } = shape else { return false };
            let p = along(ends, place);
            let twin = moved(place, p.minor, 1);
            p.is_inside()
                && p.twice.abs() == p.divisor
                && is_same(self.mine(twin), self.exact(place))
                && is_same(self.mine(place), self.exact(twin))
        })
    }

    /// Returns the number of the pixels that have more than one face below them.
    pub fn hidden(&self, pixels: &[[u32; 2]]) -> usize {
        pixels.iter().filter(|at| self.faces(**at).nth(1).is_some()).count()
    }

    /// Returns the cause of a wrong pixel, as far as the geometry tells it; another face only if
    /// `allow` is set.
    pub fn verdict(&self, at: [u32; 2], allow: bool) -> Option<Verdict> {
        let lines = self.near(at).find_map(|shape| match shape {
            Shape::Line { ends, colors, is_blended } => {
                self.line(shape, ends, colors.as_ref(), *is_blended, at.map(i64::from))
            }
            Shape::Circle { center, radius, color, .. } => {
                self.circle(shape, *center, *radius, *color, at.map(i64::from))
            }
            Shape::Face { .. } => None,
        });
        let other_face = || allow.then(|| self.other_face(at)).flatten();
        lines.or_else(|| self.twice(at)).or_else(other_face).or_else(|| self.edge(at))
    }

    fn line(
        &self,
        shape: &Shape,
        ends: &[[i32; 2]; 2],
        colors: Option<&[Rgba; 2]>,
        is_blended: bool,
        at: [i64; 2],
    ) -> Option<Verdict> {
        let p = along(ends, at);
        let (found, right) = (self.mine(at)?, self.exact(at)?);
        let is_at = |c: Rgba, step: i64| self.is_of_step(colors, c, step, p.steps);
        let is_of_line = |c: Rgba| !is_blended && is_at(c, p.step);
        let verdict = |class, distance: Option<f64>| {
            Some(Verdict { class, distance, subject: shape.to_string(), is_certain: false })
        };
        if is_of_line(found) && !is_of_line(right) {
            // Along the major axis beyond an end, or along the minor one.
            let beyond = (-p.step).max(p.step - p.steps).max(0) as f64;
            let off = p.distance().max(beyond);
            return if off > 0.5 && off < 3.0 { verdict(Class::OutsideLine, Some(off)) } else { None };
        }
        if !is_of_line(right) || p.distance() > 0.5 || !p.is_inside() {
            return None;
        }
        if colors.is_some_and(|c| c[0] != c[1] && on_ramp(c, found)) {
            return verdict(Class::Ramp, None);
        }
        match self.presence(shape, ends, colors) {
            Presence::Nothing => return verdict(Class::MissingLine, None),
            // A law may explain them.
            Presence::OtherColors => return None,
            Presence::Some => {}
        }
        let is_drawn = |at: [i64; 2]| self.mine(at).is_some_and(is_of_line);
        if [-1, 1].iter().any(|d| is_drawn(moved(at, p.minor, *d))) {
            return verdict(Class::OutsideLine, None);
        }
        let to_end = |sign: i64, count: i64| {
            (0..=count).all(|k| {
                let mut place = moved(at, p.major, sign * k);
                let q = along(ends, place);
                // The line's own pixel of that step.
                place = moved(place, q.minor, (q.distance() + 0.499).floor() as i64);
                !self.mine(place).is_some_and(|c| is_at(c, q.step))
            })
        };
        match to_end(1, p.steps - p.step) || to_end(-1, p.step) {
            true => verdict(Class::MissingAtEnd, None),
            false => verdict(Class::GapInLine, None),
        }
    }

    /// Returns whether a colour is that of a line's step; without a known colour, whatever is not
    /// background.
    fn is_of_step(&self, colors: Option<&[Rgba; 2]>, c: Rgba, step: i64, steps: i64) -> bool {
        match colors {
            Some(colors) => distance(c, mix(colors, step.clamp(0, steps), steps)) <= STEPS,
            None => !self.pixels.is_same(c, self.pixels.background),
        }
    }

    /// Returns what of a line is in the picture.
    fn presence(&self, shape: &Shape, ends: &[[i32; 2]; 2], colors: Option<&[Rgba; 2]>) -> Presence {
        if let Some(known) = self.lines.borrow().get(&std::ptr::from_ref(shape)) {
            return *known;
        }
        let first = ends[0].map(i64::from);
        let Along { steps, major, .. } = along(ends, first);
        // Other lines may light the ends, and pixels that they cross.
        let [from, to] = if steps > 4 { [1, steps - 1] } else { [0, steps] };
        // The steps in the frame alone.
        let m = usize::from(major[0] == 0);
        let last = i64::from(self.pixels.size[m]) - 1 - first[m];
        let (least, most) = if major[m] > 0 { (-first[m], last) } else { (-last, first[m]) };
        let [mut count, mut near, mut empty] = [0_u64; 3];
        for step in from.max(least)..=to.min(most) {
            let place = moved(first, major, step);
            let q = along(ends, place);
            let place = moved(place, q.minor, (q.distance() + 0.499).floor() as i64);
            let Some(found) = self.mine(place) else { continue };
            let is_found = |at| self.mine(at).is_some_and(|c| self.is_of_step(colors, c, step, steps));
            count += 1;
            near += u64::from((-1..=1).any(|d| is_found(moved(place, q.minor, d))));
            empty += u64::from(self.pixels.is_same(found, self.pixels.background));
        }
        let presence = match (count > 0 && near * 10 <= count, empty * 2 >= count) {
            (false, _) => Presence::Some,
            (true, true) => Presence::Nothing,
            (true, false) => Presence::OtherColors,
        };
        self.lines.borrow_mut().insert(shape, presence);
        presence
    }

    fn circle(&self, shape: &Shape, c: [i32; 2], radius: i32, color: Rgba, at: [i64; 2]) -> Option<Verdict> {
        let (found, right) = (self.mine(at)?, self.exact(at)?);
        let d = [0, 1].map(|i| (at[i] - i64::from(c[i])).abs());
        let (major, minor) = (d[0].min(d[1]) as f64, d[0].max(d[1]) as f64);
        let off = (minor - (f64::from(radius).powi(2) - major * major).max(0.0).sqrt()).abs();
        let is_of_circle = |c: Rgba| distance(c, color) <= STEPS;
        let verdict = |class, distance| {
            Some(Verdict { class, distance, subject: shape.to_string(), is_certain: false })
        };
        match (is_of_circle(found), is_of_circle(right)) {
            (true, false) if off > 0.5 && off < 3.0 => verdict(Class::OutsideLine, Some(off)),
            (false, true) if off <= 0.5 => {
                let near = (-1..=1).flat_map(|y| (-1..=1).map(move |x| [x, y])).filter(|by| *by != [0, 0]);
                let is_replaced = near.map(|by| moved(at, by, 1)).any(|p| {
                    self.mine(p).is_some_and(is_of_circle) && !self.exact(p).is_some_and(is_of_circle)
                });
                verdict(if is_replaced { Class::OutsideLine } else { Class::GapInLine }, None)
            }
            _ => None,
        }
    }

    /// Returns the faces that cover a pixel's centre or have it on an edge.
    fn faces(&self, at: [u32; 2]) -> impl Iterator<Item = &'a Shape> {
        self.near(at).filter(move |shape| match shape {
            Shape::Face { corners, .. } => edges(corners, at).is_some_and(|e| e.iter().all(|e| e.value >= 0)),
            _ => false,
        })
    }

    fn twice(&self, at: [u32; 2]) -> Option<Verdict> {
        let (found, right) = (self.pixels.mine_at(at), self.pixels.exact_at(at));
        let is_again = |color: [f64; 3], opacity: f64| {
            let again = over(color, opacity, right);
            opacity < 1.0 && (0..3).all(|c| (again[c] - f64::from(found[c])).abs() <= f64::from(STEPS))
        };
        let one = |[r, g, b, a]: Rgba| is_again([r, g, b].map(f64::from), f64::from(a) / 255.0);
        let place = at.map(i64::from);
        let shape = self.near(at).find(|shape| match shape {
            Shape::Line { ends, colors, is_blended } => {
                let p = along(ends, place);
                let color = colors.as_ref().map(|colors| mix(colors, p.step, p.steps));
                *is_blended && p.is_inside() && p.distance() <= 0.5 && color.is_some_and(one)
            }
            Shape::Circle { color, is_blended, .. } => *is_blended && one(*color),
            Shape::Face { corners, color, is_blended, number } => {
                edges(corners, at).is_some_and(|e| e.iter().all(|e| e.value >= 0))
                    && match (color, number) {
                        (Some(color), _) => *is_blended && one(*color),
                        (None, Some(n)) => (self.geometry.surface)(*n, at).is_some_and(|s| {
                            let [r, g, b, _] = s.color.map(|v| f64::from(v) / s.opacity.max(1e-3));
                            is_again([r, g, b], s.opacity)
                        }),
                        _ => false,
                    }
            }
        })?;
        Some(Verdict {
            class: Class::CountedTwice,
            distance: None,
            subject: shape.to_string(),
            is_certain: false,
        })
    }

    fn other_face(&self, at: [u32; 2]) -> Option<Verdict> {
        let (found, right) = (self.pixels.mine_at(at), self.pixels.exact_at(at));
        let mut seen = None;
        let mut others = Vec::new();
        for shape in self.faces(at).take(LAYERS) {
            let Shape::Face { color, number, is_blended: false, .. } = shape else { continue };
            let surface = match (color, number) {
                (Some(color), _) => Surface { color: *color, opacity: 1.0, z: others.len() as f64 },
                (None, Some(n)) => match (self.geometry.surface)(*n, at) {
                    Some(surface) => surface,
                    None => continue,
                },
                _ => continue,
            };
            if distance(surface.color, right) <= STEPS {
                seen = Some(surface);
            }
            others.push((surface, shape));
        }
        let seen = seen?;
        let is_behind = |s: &Surface| distance(s.color, found) <= STEPS && s.z > seen.z;
        let (_, shape) = others.iter().find(|(surface, _)| is_behind(surface))?;
        Some(Verdict {
            class: Class::OtherFace,
            distance: None,
            subject: format!("{shape} at ({}, {})", at[0], at[1]),
            is_certain: false,
        })
    }

    fn edge(&self, at: [u32; 2]) -> Option<Verdict> {
        if !self.pixels.is_from_neighbor(at) {
            return None;
        }
        let near = self.near(at).filter_map(|shape| match shape {
            Shape::Face { corners, .. } => {
                let edges = edges(corners, at)?;
                let is_near = edges.iter().all(|e| e.distance > -1.0);
                let nearest = edges.iter().map(|e| e.distance.abs()).min_by(f64::total_cmp)?;
                (is_near && nearest < 1.0).then_some((nearest, shape))
            }
            _ => None,
        });
        let (off, shape) = near.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Verdict {
            class: Class::Edge,
            distance: Some(off),
            subject: shape.to_string(),
            is_certain: off == 0.0,
        })
    }
}

/// Returns whether a colour lies between two, within the steps.
fn on_ramp(colors: &[Rgba; 2], found: Rgba) -> bool {
    let [a, b] = colors;
    let axis = (0..3).max_by_key(|&c| a[c].abs_diff(b[c])).unwrap_or(0);
    let (from, to) = (f64::from(a[axis]), f64::from(b[axis]));
    let t = (f64::from(found[axis]) - from) / (to - from);
    (-0.01..=1.01).contains(&t) && distance(mix(colors, (t * 4096.0) as i64, 4096), found) <= STEPS
}

/// One edge of a face, at a pixel's centre.
struct Edge {
    /// Edge function in 1/65536 square pixels, positive inside.
    value: i128,
    /// Distance of the centre in pixels, positive inside.
    distance: f64,
}

/// Returns the three edges; `None` for a face without area.
fn edges(corners: &[[f64; 2]; 3], [x, y]: [u32; 2]) -> Option<[Edge; 3]> {
    let p = corners.map(|corner| corner.map(|v| (v * 256.0).round_ties_even() as i128));
    let at = [x, y].map(|v| i128::from(v) * 256 + 128);
    let cross = |a: [i128; 2], b: [i128; 2], c: [i128; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let sign = cross(p[0], p[1], p[2]).signum();
    (sign != 0).then(|| {
        std::array::from_fn(|i| {
            let (a, b) = (p[i], p[(i + 1) % 3]);
            let value = cross(a, b, at) * sign;
            let length = ((b[0] - a[0]) as f64).hypot((b[1] - a[1]) as f64);
            Edge { value, distance: value as f64 / length.max(1.0) / 256.0 }
        })
    })
}

/// Returns the rectangle x0, y0, x1, y1 of the pixels that a figure, or an error of it, may touch.
fn bounds(shape: &Shape, size: [u32; 2]) -> Option<[i64; 4]> {
    let points: Vec<[f64; 2]> = match shape {
        Shape::Line { ends, .. } => ends.iter().map(|end| end.map(f64::from)).collect(),
        Shape::Circle { center, radius, .. } => {
            let ([x, y], r) = (center.map(f64::from), f64::from(*radius));
            vec![[x - r, y - r], [x + r, y + r]]
        }
        Shape::Face { corners, .. } => corners.to_vec(),
    };
    if points.iter().flatten().any(|v| !v.is_finite() || v.abs() > FAR) {
        return None;
    }
    let side = |axis: usize, end: u32| {
        let values = points.iter().map(|p| p[axis]);
        let (low, high) = values.fold((FAR, -FAR), |(low, high), v| (low.min(v), high.max(v)));
        let (low, high) = (low.floor() as i64 - 3, high.ceil() as i64 + 3);
        (high >= 0 && low < i64::from(end)).then(|| (low.max(0), high.min(i64::from(end) - 1)))
    };
    let ((x0, x1), (y0, y1)) = (side(0, size[0])?, side(1, size[1])?);
    Some([x0, y0, x1, y1])
}
