//! Exact coverage of one triangle.

use super::edge_walk::{Walk, first_row};
use super::exact_int::{ExactInt, snap_big, snap_wide};
use super::{PixelRect, Snapped, extent, snap_middle, snap_narrow, width_for};
use crate::math::double_double::DoubleDouble;
use crate::math::sort3;
use num_bigint::BigInt;
use std::cmp::Ordering;
use std::ops::Range;

/// Three corners in 1/256 pixel.
pub(crate) type Corners<I> = [[I; 2]; 3];

/// Triangle whose corners are snapped to 1/256 pixel.
///
/// Corners are stored in i64, i128 or big integers, as their size requires; the results do not
/// depend on it.
#[derive(Clone, Debug)]
pub struct SnappedTriangle(Snapped<Corners<i64>, Corners<i128>, Box<Corners<BigInt>>>);

impl SnappedTriangle {
    /// Snaps three corners in pixels (x right, y down). A corner that is not finite makes the
    /// triangle empty.
    pub fn new(points: [[f64; 2]; 3]) -> Self {
        if points.iter().flatten().any(|v| !v.is_finite()) {
            return SnappedTriangle(Snapped::Narrow([[0; 2]; 3]));
        }
        SnappedTriangle(match width_for(extent(&points)) {
            Snapped::Narrow(()) => Snapped::Narrow(points.map(|p| p.map(snap_narrow))),
            Snapped::Middle(()) => Snapped::Middle(points.map(|p| p.map(snap_middle))),
            Snapped::Huge(()) => Snapped::Huge(Box::new(points.map(|p| p.map(snap_big)))),
        })
    }

    /// Snaps three corners whose places have the digits of two f64, as [`Self::new`] does.
    pub(crate) fn of_wide(points: [[DoubleDouble; 2]; 3]) -> Self {
        if points.iter().flatten().any(|v| !v.is_finite()) {
            return SnappedTriangle(Snapped::Narrow([[0; 2]; 3]));
        }
        SnappedTriangle(Snapped::Huge(Box::new(points.map(|p| p.map(snap_wide)))))
    }

    /// Returns the sign of the doubled area (x1-x0)(y2-y0) - (x2-x0)(y1-y0), with y down.
    ///
    /// `Greater`: clockwise as seen on the screen. `Less`: counter-clockwise. `Equal`: no area,
    /// covers nothing.
    pub fn orientation(&self) -> Ordering {
        match &self.0 {
            Snapped::Narrow(p) => doubled_area(p).signum_order(),
            Snapped::Middle(p) => doubled_area(p).signum_order(),
            Snapped::Huge(p) => doubled_area(p).signum_order(),
        }
    }

    /// Returns the corners in 1/256 pixel if all are within 262,144 pixels of the origin: doubled
    /// areas are then below 2^54.
    ///
    /// `None` for a triangle with a corner further out.
    pub fn corners_fixed(&self) -> Option<[[i64; 2]; 3]> {
        match &self.0 {
            Snapped::Narrow(p) => Some(*p),
            _ => None,
        }
    }

    /// Returns the corners in the integer type in which they are stored.
    pub(crate) fn corners(&self) -> Snapped<&Corners<i64>, &Corners<i128>, &Corners<BigInt>> {
        match &self.0 {
            Snapped::Narrow(p) => Snapped::Narrow(p),
            Snapped::Middle(p) => Snapped::Middle(p),
            Snapped::Huge(p) => Snapped::Huge(p),
        }
    }

    /// Returns how much of `rect` is covered, at the cost of a few products; `Part` if that does
    /// not decide.
    pub fn filling(&self, rect: PixelRect) -> Filling {
        // Products of numbers below 2^27; otherwise the rectangle is further out than any frame's.
        let is_near = [rect.x0, rect.y0, rect.x1, rect.y1].iter().all(|v| v.unsigned_abs() < 1 << 18);
        match &self.0 {
            Snapped::Narrow(p) if is_near => filling_of(p, rect),
            _ => Filling::Part,
        }
    }

    /// Calls `f(y, x0..x1)` for the covered pixels of each row inside `clip`, top to bottom; empty
    /// rows are skipped.
    ///
    /// The winding does not matter. The cost is that of the visible rows.
    pub fn for_each_span(&self, clip: PixelRect, f: impl FnMut(i32, Range<i32>)) {
        match &self.0 {
            Snapped::Narrow(p) => scan_triangle(p, clip, f),
            Snapped::Middle(p) => scan_triangle(p, clip, f),
            Snapped::Huge(p) => scan_triangle(p, clip, f),
        }
    }
}

/// Extent to which a rectangle of pixels is covered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filling {
    /// No pixel is covered.
    None,
    /// Some pixels may be covered.
    Part,
    /// Every pixel is covered.
    All,
}

/// Decides by the corner pixels: a half-plane that contains (or excludes) their four centres
/// contains (or excludes) all between.
fn filling_of([a, b, c]: &Corners<i64>, rect: PixelRect) -> Filling {
    let area = doubled_area(&[*a, *b, *c]);
    if area == 0 || rect.is_empty() {
        return Filling::None;
    }
    let (b, c) = if area < 0 { (c, b) } else { (b, c) };
    let centre = |v: i32| i64::from(v) * 256 + 128;
    let (columns, rows) = ([rect.x0, rect.x1 - 1].map(centre), [rect.y0, rect.y1 - 1].map(centre));
    let mut filling = Filling::All;
    for (p, q) in [(a, b), (b, c), (c, a)] {
        let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
        // Clockwise: inside where this is positive, and on top and left edges.
        let bias = i64::from(!(dy < 0 || dy == 0 && dx > 0));
        let (x, y) = (columns.map(|x| dy * (x - p[0])), rows.map(|y| dx * (y - p[1])));
        let (least, most) = (y[0].min(y[1]) - x[0].max(x[1]), y[0].max(y[1]) - x[0].min(x[1]));
        if most < bias {
            return Filling::None;
        }
        if least < bias {
            filling = Filling::Part;
        }
    }
    filling
}

/// Returns twice the signed area, in 1/65536 square pixels: positive if clockwise on a screen whose
/// y points down.
pub(crate) fn doubled_area<I: ExactInt>(p: &Corners<I>) -> I {
    let [a, b, c] = p;
    let ab = [b[0].minus(&a[0]), b[1].minus(&a[1])];
    let ac = [c[0].minus(&a[0]), c[1].minus(&a[1])];
    ab[0].times(&ac[1]).minus(&ac[0].times(&ab[1]))
}

/// Calls `f(y, x0..x1)` for the covered pixels of each row inside `clip`, top to bottom, in exact
/// integer arithmetic.
pub(crate) fn scan_triangle<I: ExactInt>(
    p: &Corners<I>,
    clip: PixelRect,
    mut f: impl FnMut(i32, Range<i32>),
) {
    if clip.is_empty() {
        return;
    }
    let mut order = [&p[0], &p[1], &p[2]];
    sort3(&mut order, |a, b| a[1] < b[1]);
    let [top, middle, bottom] = order;
    let [y0, y1, y2] = [top, middle, bottom].map(|v| first_row(&v[1], clip.y0, clip.y1));
    if y0 == y2 {
        return;
    }
    // One edge spans all rows; the other two share the other side. Comparing columns tells left
    // from right.
    let columns = [clip.x0, clip.x1];
    let mut long = I::Walk::new(top, bottom, y0..y2, columns);
    for (from, to, rows) in [(top, middle, y0..y1), (middle, bottom, y1..y2)] {
        if rows.is_empty() {
            continue;
        }
        let mut short = I::Walk::new(from, to, rows.clone(), columns);
        for y in rows {
            let (a, b) = (long.column(columns), short.column(columns));
            if a != b {
                f(y, a.min(b)..a.max(b));
            }
            long.step();
            short.step();
        }
    }
}
