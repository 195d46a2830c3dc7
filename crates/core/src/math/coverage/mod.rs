//! Exact coverage: the pixels that an area covers, decided in integers.
//!
//! In: finite vertices in pixels (y down, pixel (i,j) is the square [i,i+1)x[j,j+1), its centre
//! (i+.5, j+.5)), of any size that f64 can hold. They are snapped to 1/256 pixel, nearest, ties to
//! even. Out: spans of covered pixels, row by row, inside a clip rectangle.
//!
//! Definition: a pixel is covered if its centre is strictly inside the snapped outline or lies on a
//! top edge (horizontal, inside below it) or a left edge (inside to its right). So areas that share
//! an edge cover each pixel of the seam once, whatever their winding, order and size; zero area
//! covers nothing.
//!
//! Verified by the tests, which evaluate the three edge functions at each pixel's centre in big
//! integers.
//!
//! The cost is that of the rows in the clip rectangle, not of the area.
//!
//! Source: the fill rule of Pineda, "A parallel algorithm for polygon rasterization" (1988) and of
//! the graphics APIs since; exact stepping as in Bresenham (1965).

mod edge_walk;
pub(crate) mod exact_int;
mod far_edge_walk;
mod triangle;

pub(crate) use triangle::{Corners, doubled_area, scan_triangle};
pub use triangle::{Filling, SnappedTriangle};

use edge_walk::{Walk, first_row};
use exact_int::{ExactInt, snap_big};
use num_bigint::BigInt;
use std::ops::Range;

/// Pixels `x0..x1` by `y0..y1`, half-open; empty if an end is not beyond its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PixelRect {
    /// First column.
    pub x0: i32,
    /// First row.
    pub y0: i32,
    /// End of the columns.
    pub x1: i32,
    /// End of the rows.
    pub y1: i32,
}

impl PixelRect {
    /// Returns whether the rectangle contains no pixel.
    pub fn is_empty(&self) -> bool {
        self.x0 >= self.x1 || self.y0 >= self.y1
    }
}

/// Bound on snapped coordinates (in 1/256 pixel) that are computed in i64: 262,144 pixels.
///
/// Boxes are then below 2^27 a side, doubled areas below 2^54, and 511 times an area (a colour's
/// numerator) fits.
const NARROW_LIMIT: f64 = (1u64 << 26) as f64;
/// Bound on snapped coordinates that are computed in i128: boxes below 2^58, doubled areas below
/// 2^116.
const MIDDLE_LIMIT: f64 = (1u64 << 57) as f64;

/// Vertices in 1/256 pixel, in the narrowest integer type that is exact for them.
#[derive(Clone, Debug)]
pub(crate) enum Snapped<A, B, C> {
    Narrow(A),
    Middle(B),
    Huge(C),
}

/// Returns the integer width that vertices within `extent` pixels of 0 need.
fn width_for(extent: f64) -> Snapped<(), (), ()> {
    // Scaling by 256 is exact, or infinite and then huge.
    let extent = extent * 256.0;
    if extent < NARROW_LIMIT {
        Snapped::Narrow(())
    } else if extent < MIDDLE_LIMIT {
        Snapped::Middle(())
    } else {
        Snapped::Huge(())
    }
}

fn extent(points: &[[f64; 2]]) -> f64 {
    points.iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs()))
}

fn snap_narrow(v: f64) -> i64 {
    (v * 256.0).round_ties_even() as i64
}

fn snap_middle(v: f64) -> i128 {
    (v * 256.0).round_ties_even() as i128
}

/// Calls `f(y, x0..x1)` for every run of pixels inside the closed polygon `points` (pixels) by the
/// even-odd rule.
///
/// Snapping and edge rule are those of triangles, so a polygon and its triangulation cover the same
/// pixels. Runs come top to bottom, left to right, only those inside `clip`, none empty. Fewer than
/// three points, or one that is not finite, give nothing.
pub fn polygon_spans(points: &[[f64; 2]], clip: PixelRect, f: impl FnMut(i32, Range<i32>)) {
    if points.len() < 3 || clip.is_empty() || points.iter().flatten().any(|v| !v.is_finite()) {
        return;
    }
    fn snapped<I>(points: &[[f64; 2]], snap: fn(f64) -> I) -> Vec<[I; 2]> {
        points.iter().map(|p| p.map(snap)).collect()
    }
    match width_for(extent(points)) {
        Snapped::Narrow(()) => scan_polygon(&snapped(points, snap_narrow), clip, f),
        Snapped::Middle(()) => scan_polygon(&snapped(points, snap_middle), clip, f),
        Snapped::Huge(()) => scan_polygon::<BigInt>(&snapped(points, snap_big), clip, f),
    }
}

/// Edge that crosses the row, its column there, and its last row.
struct ActiveEdge<W> {
    walk: W,
    column: i32,
    last_row: i32,
}

fn scan_polygon<I: ExactInt>(points: &[[I; 2]], clip: PixelRect, mut f: impl FnMut(i32, Range<i32>)) {
    let mut pending: Vec<(Range<i32>, usize)> = Vec::with_capacity(points.len());
    let ends = |i: usize| {
        let (a, b) = (&points[i], &points[if i + 1 == points.len() { 0 } else { i + 1 }]);
        if a[1] <= b[1] { (a, b) } else { (b, a) }
    };
    for i in 0..points.len() {
        let (top, bottom) = ends(i);
        let rows = first_row(&top[1], clip.y0, clip.y1)..first_row(&bottom[1], clip.y0, clip.y1);
        if !rows.is_empty() {
            pending.push((rows, i));
        }
    }
    pending.sort_unstable_by_key(|(rows, i)| (rows.start, *i));
    let mut pending = pending.into_iter().peekable();
    let columns = [clip.x0, clip.x1];
    let mut active: Vec<ActiveEdge<I::Walk>> = Vec::with_capacity(points.len());
    let mut crossings: Vec<i32> = Vec::new();
    let mut row = clip.y0;
    loop {
        if active.is_empty() {
            let Some((rows, _)) = pending.peek() else { return };
            row = rows.start;
        }
        while let Some((rows, i)) = pending.next_if(|(rows, _)| rows.start == row) {
            let (top, bottom) = ends(i);
            active.push(ActiveEdge {
                walk: I::Walk::new(top, bottom, rows.clone(), columns),
                column: 0,
                last_row: rows.end - 1,
            });
        }
        // The edges stay the same until one of them ends or the next one begins.
        let last = active.iter().map(|edge| edge.last_row).min().unwrap_or(row);
        let last = pending.peek().map_or(last, |(rows, _)| last.min(rows.start - 1));
        for row in row..=last {
            for edge in &mut active {
                edge.column = edge.walk.column(columns);
                edge.walk.step();
            }
            if active.len() <= FEW_EDGES {
                sort_nearly_sorted(&mut active);
                let pairs = active.as_chunks().0.iter();
                for_each_run(pairs.map(|[a, b]| [a.column, b.column]), |run| f(row, run));
            } else {
                crossings.clear();
                crossings.extend(active.iter().map(|edge| edge.column));
                crossings.sort_unstable();
                for_each_run(crossings.as_chunks().0.iter().copied(), |run| f(row, run));
            }
        }
        active.retain(|edge| edge.last_row > last);
        row = last + 1;
    }
}

/// Number of edges up to which they are kept in order; of more only their columns are sorted.
const FEW_EDGES: usize = 16;

/// Sorts edges by their columns, each by insertion: few have changed places since the row before.
#[inline]
fn sort_nearly_sorted<W>(edges: &mut [ActiveEdge<W>]) {
    for i in 1..edges.len() {
        let mut at = i;
        while at > 0 && edges[at - 1].column > edges[at].column {
            edges.swap(at - 1, at);
            at -= 1;
        }
    }
}

/// Calls `f` with the runs between pairs of crossings in order: a closed outline crosses a row an even
/// number of times. Adjacent runs are merged.
#[inline]
fn for_each_run(pairs: impl Iterator<Item = [i32; 2]>, mut f: impl FnMut(Range<i32>)) {
    let mut run = 0..0;
    for [from, to] in pairs {
        if run.is_empty() {
            run = from..to;
        } else if from > run.end {
            f(std::mem::replace(&mut run, from..to));
        } else {
            run.end = to;
        }
    }
    if !run.is_empty() {
        f(run);
    }
}

#[cfg(test)]
mod tests;
