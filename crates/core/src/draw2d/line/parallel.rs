//! Many lines at once: one after another on this thread, or each thread of an executor in its own
//! band of rows.
//!
//! A pixel belongs to one band, and in it the lines are drawn in order, so the result has the same
//! bytes as calling [`line`](super::line) for each, with any number of threads.

use super::bresenham::VisibleRun;
use super::{draw, inside, is_short, store_short};
use crate::draw2d::band::{NO_ROWS, on_bands};
use crate::draw2d::{Blend, RampColor, pixels_mut};
use crate::executor::Executor;
use crate::math::coverage::PixelRect;
use crate::memory::{Rgba, VideoMemory};
use std::ops::Range;

/// A line, as [`lines`] takes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Line {
    /// The end it starts from, in pixels.
    pub p0: [i32; 2],
    /// The end it goes to, in pixels.
    pub p1: [i32; 2],
    /// Its colour, or the two colours at its ends.
    pub color: RampColor,
}

/// Draws lines one after another, as [`line`](super::line) does, with less overhead for each.
#[inline]
pub fn lines(memory: &mut VideoMemory, lines: impl IntoIterator<Item = Line>, blend: Blend) {
    let size = [memory.width(), memory.height()];
    let is_slow = blend == Blend::Over || memory.is_clipped();
    let mut rows = NO_ROWS;
    let mut lines = lines.into_iter();
    loop {
        let pixels = pixels_mut(memory);
        let other = lines.find(|&Line { p0, p1, color }| {
            if is_slow || color.to.is_some() || !is_short(p0, p1) || !inside(p0, size) || !inside(p1, size) {
                return true;
            }
            store_short(pixels, p0, p1, size[0], color.from);
            let (a, b) = (p0[1] as u32, p1[1] as u32);
            rows = rows.start.min(a.min(b))..rows.end.max(a.max(b) + 1);
            false
        });
        match other {
            Some(Line { p0, p1, color }) => draw(memory, p0, p1, color, blend),
            None => return memory.mark_rows(rows),
        }
    }
}

/// Draws lines as [`lines`] does, on all threads of `executor` if there is enough to do. Accepts
/// any type that converts to [`Line`].
pub fn lines_on<L>(executor: &Executor, memory: &mut VideoMemory, lines: &[L], blend: Blend)
where
    L: Copy + Sync + Into<Line>,
{
    let threads = executor.threads();
    if threads == 1 || !is_worth_threads(lines) {
        return super::lines(memory, lines.iter().map(|&l| l.into()), blend);
    }
    // No more bands than threads: each of them reads all lines.
    on_bands(executor, memory, 0..memory.height() as i32, threads, |band| {
        let PixelRect { x0, y0, x1, y1 } = band.clip();
        let lines_of = LineBand { top: y0, rows: (y1 - y0) as u32, width: band.size()[0], columns: x0..x1 };
        let drawn = lines_of.draw(band.pixels_mut(), lines, blend);
        if drawn.start < drawn.end {
            band.mark_rows(band.top() + drawn.start..band.top() + drawn.end);
        }
    });
}

/// Number of steps below which waking other threads costs more than it gains: some 50 microseconds
/// of work.
const FEW_STEPS: u64 = 50_000;

/// Returns whether the lines are enough work for several threads.
pub(super) fn is_worth_threads<L: Copy + Into<Line>>(lines: &[L]) -> bool {
    // A line costs its steps, and a start-up cost of about 16 more.
    let cost = |&line: &L| {
        let Line { p0, p1, .. } = line.into();
        u64::from(p0[0].abs_diff(p1[0]).max(p0[1].abs_diff(p1[1])).min(1 << 15)) + 16
    };
    lines.len() as u64 * 16 > FEW_STEPS || lines.iter().map(cost).sum::<u64>() > FEW_STEPS
}

/// Number of lines that are filtered at once; their indices stay in the L1 cache.
const BLOCK: usize = 256;

/// A band of rows of the frame, drawn by one thread.
struct LineBand {
    top: i32,
    rows: u32,
    width: u32,
    /// Columns that may be drawn.
    columns: Range<i32>,
}

impl LineBand {
    /// Draws the lines that fall into the band. Returns the rows written, relative to the band.
    fn draw<L: Copy + Into<Line>>(&self, pixels: &mut [Rgba], lines: &[L], blend: Blend) -> Range<u32> {
        let mut drawn = NO_ROWS;
        for block in lines.chunks(BLOCK) {
            let mut here = [0u8; BLOCK];
            let mut count = 0;
            // Whether a line touches the band is close to random, so it is computed without a
            // branch.
            for (k, &line) in block.iter().enumerate() {
                if let Some(place) = here.get_mut(count) {
                    *place = k as u8;
                }
                count += usize::from(self.touches(line.into()));
            }
            for &k in &here[..count] {
                let Some(&line) = block.get(usize::from(k)) else { continue };
                let rows = self.draw_one(pixels, line.into(), blend);
                drawn = drawn.start.min(rows.start)..drawn.end.max(rows.end);
            }
        }
        drawn
    }

    /// Returns whether the rows between a line's ends meet the band.
    #[inline(always)]
    fn touches(&self, line: Line) -> bool {
        let (low, high) = (line.p0[1].min(line.p1[1]), line.p0[1].max(line.p1[1]));
        (high >= self.top) & (i64::from(low) < i64::from(self.top) + i64::from(self.rows))
    }

    /// Draws the part of a line inside the band. Returns its rows, relative to the band.
    #[inline(always)]
    fn draw_one(&self, pixels: &mut [Rgba], line: Line, blend: Blend) -> Range<u32> {
        let Line { p0, p1, color } = line;
        // The top is 0 or more: only ends above the frame can leave i32, and they are not inside
        // either way.
        let [a, b] = [p0, p1].map(|[x, y]| [x, y.saturating_sub(self.top)]);
        let size = [self.width, self.rows];
        if self.columns.len() == self.width as usize && inside(a, size) && inside(b, size) {
            if blend == Blend::Replace && color.to.is_none() && is_short(a, b) {
                store_short(pixels, a, b, self.width, color.from);
                let (a, b) = (a[1] as u32, b[1] as u32);
                return a.min(b)..a.max(b) + 1;
            }
            return VisibleRun::unclipped(a, b, self.width).draw(pixels, color, blend);
        }
        let [a, b] = [p0, p1].map(|[x, y]| [i64::from(x), i64::from(y) - i64::from(self.top)]);
        let band = PixelRect { x0: self.columns.start, y0: 0, x1: self.columns.end, y1: self.rows as i32 };
        let run = VisibleRun::clipped(a, b, band, self.width);
        run.map_or(NO_ROWS, |run| run.draw(pixels, color, blend))
    }
}
