//! Areas that wait for others, so that all of them are drawn band by band.
//!
//! In: filled figures of one stream, in their order. Out: the pixels that drawing one after the other
//! leaves. A large area is written at the speed of the memory behind the caches, and where areas
//! overlap, as they do in most pictures, each pixel is written several times. So the rows of the frame
//! are divided into bands that stay in a cache of the processor, and in each band the areas are drawn
//! in their order: a figure restricted to a window of rows stores the same bytes there as a whole one
//! (`pieces/bands.rs` relies on it, too). One would know a mistake by the comparison below, and by the
//! golden pictures, which streams draw.
//!
//! Where the renderer has a pool and the areas take long enough, its threads draw the bands.
//!
//! Only areas that cannot be refused wait, so that each error has its place among the replies.

use super::Engine;
use crate::Session;
use fbptr_command::{Figure, RealRect, StreamPosition};
use fbptr_core::draw2d::{self, Area, Blend};
use fbptr_core::error::Fault;
use fbptr_core::memory::Rgba;
use std::ops::Range;

/// Bytes of a band: a part of the second-level cache of common processors. In tests, whose frames are
/// small, a few rows.
const BAND_BYTES: usize = if cfg!(test) { 8 << 10 } else { 256 << 10 };

/// Estimated nanoseconds of an area from which it begins to wait: it touches enough memory that its
/// windows of rows cost less than they save. That is so for rectangles, and for discs that are blended
/// with what is there; an opaque disc of 11,000 pixels takes 6 % longer in bands, a triangle 8 %.
const LEAST_NS: u64 = 8_000;

/// Estimated nanoseconds of areas that wait, at most, and their number: others wait for them.
pub(crate) const MOST_AREAS_NS: u64 = 8_000_000;
pub(crate) const MOST_AREAS: usize = 1024;

/// An area that waits.
#[derive(Debug)]
pub(crate) struct QueuedArea {
    pub figure: Figure,
    pub place: StreamPosition,
    /// Rows of the frame that it may touch.
    rows: Range<u32>,
}

impl QueuedArea {
    /// Returns whether it gains by waiting for others.
    pub fn gains(figure: &Figure, blend: Blend, ns: u64) -> bool {
        let is_blended = |color: &Rgba| blend == Blend::Over && color[3] != 255;
        ns >= LEAST_NS
            && match figure {
                Figure::FillRect { .. } => true,
                Figure::FillCircle { color, .. } => is_blended(color),
                _ => false,
            }
    }

    /// Returns an area that may wait, and the figure otherwise.
    pub fn of(figure: Figure, place: StreamPosition) -> Result<QueuedArea, Figure> {
        let sides = match &figure {
            Figure::FillRect { rect: RealRect { y, w, h, .. }, .. } if *w >= 0.0 && *h >= 0.0 => {
                Some([*y, *y + *h])
            }
            Figure::FillCircle { cy, r, .. } if *r >= 0.0 => Some([*cy - *r, *cy + *r]),
            Figure::Fill { points: [a, b, c], .. } => {
                Some([a[1].min(b[1]).min(c[1]), a[1].max(b[1]).max(c[1])])
            }
            Figure::FillPoly { points, .. } => {
                let rows = points.iter().map(|p| p[1]);
                Some([rows.clone().fold(f64::INFINITY, f64::min), rows.fold(f64::NEG_INFINITY, f64::max)])
            }
            _ => None,
        };
        // A conversion saturates.
        let rows = |[low, high]: [f64; 2]| (low - 1.0) as u32..((high + 2.0) as u32).saturating_add(1);
        match sides {
            Some(sides) => Ok(QueuedArea { rows: rows(sides), figure, place }),
            None => Err(figure),
        }
    }

    /// Returns the rows that it may touch, and the area.
    fn area(&self) -> Option<(Range<u32>, Area<'_>)> {
        let area = match &self.figure {
            Figure::FillRect { rect, color } => Area::Rect(*rect, *color),
            Figure::FillCircle { cx, cy, r, color } => Area::Disc([*cx, *cy], *r, *color),
            Figure::Fill { points, colors } => Area::Triangle(*points, *colors),
            Figure::FillPoly { color, points } => Area::Polygon(points, *color),
            // None of these may wait.
            _ => return None,
        };
        Some((self.rows.clone(), area))
    }
}

impl Engine {
    /// Draws areas in their order. Returns the faults of those that met a defect of the server.
    pub(crate) fn draw_areas(
        &mut self,
        s: &mut Session,
        areas: &[QueuedArea],
    ) -> Vec<(StreamPosition, &'static str, Fault)> {
        s.stats.commands += areas.len() as u64;
        s.has_used_other_verbs = true;
        let height = self.framebuffer.height();
        let band_rows = match areas.len() {
            1 => height,
            _ => (BAND_BYTES / (self.framebuffer.width() as usize * 4)).max(1) as u32,
        };
        let (has_drawn, mut refused) = match self.draw_areas_on_threads(s, areas, band_rows) {
            Ok(has_drawn) => (has_drawn, Vec::new()),
            // Nobody knows which of them met the defect.
            Err(fault) => (true, vec![(0, fault)]),
        };
        let rows = if has_drawn { 0..0 } else { 0..height };
        for top in rows.step_by(band_rows as usize) {
            let band = top..(top + band_rows).min(height);
            self.framebuffer.memory.set_window(band.clone());
            for (i, area) in areas.iter().enumerate() {
                if area.rows.start >= band.end || area.rows.end <= band.start {
                    continue;
                }
                let result = self.guarded(|engine| {
                    let result = engine.figure(s, &area.figure);
                    #[cfg(debug_assertions)]
                    engine.meet_defect(area.figure.verb());
                    Ok(result?)
                });
                if let Err(fault) = result {
                    // A defect has removed the window.
                    self.framebuffer.memory.set_window(band.clone());
                    if refused.iter().all(|(other, _)| *other != i) {
                        refused.push((i, fault));
                    }
                }
            }
        }
        self.end_band();
        let end = |(i, fault): (usize, Fault)| {
            let QueuedArea { figure, place, .. } = &areas[i];
            let fault = self.end_request(s, false, Err(fault), &[], &mut Vec::new(), 0).err()?;
            Some((*place, figure.verb(), fault))
        };
        refused.sort_by_key(|(i, _)| *i);
        refused.into_iter().filter_map(end).collect()
    }

    /// Draws areas on all threads of the pool. Returns `false` where one thread is as quick.
    fn draw_areas_on_threads(
        &mut self,
        s: &Session,
        areas: &[QueuedArea],
        band_rows: u32,
    ) -> Result<bool, Fault> {
        if areas.len() == 1 {
            return Ok(false);
        }
        let executor = self.executor();
        self.guarded(|engine| {
            let memory = &mut engine.framebuffer.memory;
            let has_drawn = draw2d::areas_on(&executor, memory, areas, band_rows, s.blend, QueuedArea::area);
            #[cfg(debug_assertions)]
            if has_drawn {
                areas.iter().for_each(|queued| engine.meet_defect(queued.figure.verb()));
            }
            Ok(has_drawn)
        })
    }
}
