//! Areas: figures that every band of rows can draw for itself, on one thread or on several.
//!
//! In: an [`Area`], or a list of them in their order. Out: the pixels that drawing it whole leaves. An
//! area is drawn by several threads where its estimated time is long beside that of waking them; the
//! estimate counts what is certainly there, so that a short one is drawn where it is. One would know a
//! wrong estimate by `fbptr bench 2d`, where a row would take longer with two threads than with one.

use super::band::{Band, on_all_rows, on_bands};
use super::{
    Arc, AreaColors, Blend, DrawError, RealRect, arc::arc_on, bezier::bezier_on, disc::disc_on,
    ellipse::fill_ellipse_on, fill::fill_on, fill::fill_poly_on, frame, line_aa::line_aa_on,
    rect::fill_rect_on, wide_line::wide_line_on,
};
use crate::executor::{Executor, ThreadPool};
use crate::math::coverage::PixelRect;
use crate::memory::{Rgba, VideoMemory};
use std::ops::Range;
use std::sync::{self, OnceLock};

/// A figure that covers an area, in pixels.
#[derive(Clone, Copy, Debug)]
pub enum Area<'a> {
    /// That of [`fill_rect`](super::fill_rect).
    Rect(RealRect, Rgba),
    /// That of [`fill_circle`](super::fill_circle): centre and radius.
    Disc([f64; 2], f64, Rgba),
    /// That of [`fill_ellipse`](super::fill_ellipse): centre and radii.
    Ellipse([f64; 2], [f64; 2], Rgba),
    /// That of [`fill`](super::fill).
    Triangle([[f64; 2]; 3], AreaColors),
    /// That of [`fill_poly`](super::fill_poly).
    Polygon(&'a [[f64; 2]], Rgba),
    /// That of [`wide_line`](super::wide_line): two ends and the width.
    WideLine([[f64; 2]; 2], f64, Rgba),
    /// That of [`line_aa`](super::line_aa).
    SmoothLine([[f64; 2]; 2], Rgba),
    /// That of [`arc`](super::arc).
    Arc(Arc, Rgba),
    /// That of [`bezier`](super::bezier): four points and the width.
    Curve([[f64; 2]; 4], f64, Rgba),
}

/// Nanoseconds that an area takes one thread, at least, from which several threads draw it: that it is
/// handed to threads which sleep, and that the caller is woken again, takes some 50 microseconds.
const LEAST_NS: f64 = 250_000.0;
/// Nanoseconds of a band, at least.
const BAND_NS: f64 = 10_000.0;
/// Bands for each thread, so that a thread whose rows are short takes another one.
const BANDS_A_THREAD: usize = 4;

/// Nanoseconds of a pixel that is stored, blended, stored in a colour of its own, or blended with one;
/// and of a pixel of an anti-aliased line.
const STORED_NS: f64 = 0.08;
const BLENDED_NS: f64 = 0.19;
const MIXED_NS: f64 = 0.35;
const MIXED_BLENDED_NS: f64 = 0.7;
const SMOOTH_NS: f64 = 12.0;
/// Rows of an anti-aliased line, at least.
const FEW_ROWS: f64 = 64.0;
/// Nanoseconds in which each band begins with a corner of a polygon.
const CORNER_NS: f64 = 20.0;

impl Area<'_> {
    /// Draws the part of the area that lies in a band.
    #[inline]
    pub(super) fn draw_on(&self, band: &mut Band<'_>, blend: Blend) -> Result<(), DrawError> {
        match *self {
            Area::Rect(rect, color) => fill_rect_on(band, rect, color, blend),
            Area::Disc(centre, r, color) => disc_on(band, centre, r, color, blend),
            Area::Ellipse(centre, radii, color) => fill_ellipse_on(band, centre, radii, color, blend),
            Area::WideLine([p0, p1], width, color) => wide_line_on(band, p0, p1, width, color, blend),
            Area::Arc(arc, color) => arc_on(band, arc, color, blend),
            Area::Curve(points, width, color) => bezier_on(band, points, width, color, blend),
            Area::Triangle(points, colors) => {
                fill_on(band, points, colors, blend);
                Ok(())
            }
            Area::Polygon(points, color) => {
                fill_poly_on(band, points, color, blend);
                Ok(())
            }
            Area::SmoothLine([p0, p1], color) => {
                line_aa_on(band, p0, p1, color);
                Ok(())
            }
        }
    }

    /// Returns the corners of a box around the area; not in order where the area is refused.
    #[inline(always)]
    fn bounds(&self) -> [[f64; 2]; 2] {
        let about = |[x, y]: [f64; 2], [rx, ry]: [f64; 2]| [[x - rx, y - ry], [x + rx, y + ry]];
        match *self {
            Area::Rect(RealRect { x, y, w, h }, _) => [[x, y], [x + w, y + h]],
            Area::Disc(centre, r, _) => about(centre, [r, r]),
            Area::Ellipse(centre, radii, _) => about(centre, radii),
            Area::Triangle(points, _) => bounds(&points, 0.0),
            Area::Polygon(points, _) => bounds(points, 0.0),
            Area::WideLine(ends, width, _) => bounds(&ends, width / 2.0),
            Area::SmoothLine(ends, _) => bounds(&ends, 1.0),
            Area::Arc(Arc { center, radii: [_, r], .. }, _) => about(center, [r, r]),
            Area::Curve(points, width, _) => bounds(&points, width / 2.0),
        }
    }

    /// Estimates the nanoseconds that the area takes one thread within a clip, rather too few than too
    /// many.
    #[inline(always)]
    fn least_ns(&self, clip: PixelRect, blend: Blend) -> f64 {
        let [low, high] = self.bounds();
        let side = |axis: usize, from: i32, to: i32| {
            (high[axis].min(f64::from(to)) - low[axis].max(f64::from(from))).max(0.0)
        };
        let [w, h] = [side(0, clip.x0, clip.x1), side(1, clip.y0, clip.y1)];
        let pixel = if self.is_stored(blend) { STORED_NS } else { BLENDED_NS };
        match *self {
            Area::Rect(..) => w * h * pixel,
            Area::Disc(..) | Area::Ellipse(..) => w * h * 0.7 * pixel,
            Area::Triangle(_, AreaColors::One(_)) => w * h * 0.4 * pixel,
            Area::Triangle(_, AreaColors::Three(_)) => {
                w * h * 0.4 * if blend == Blend::Over { MIXED_BLENDED_NS } else { MIXED_NS }
            }
            Area::Polygon(points, _) => match w * h * pixel {
                few if few <= LEAST_NS => few * 0.3,
                ns => ns * filled_share(points) - CORNER_NS * points.len() as f64,
            },
            Area::WideLine(ends, width, _) => {
                let stroke = width.min(w.min(h)) * w.max(h) * 0.7;
                stroke.min(w * h) * pixel * if ends[0] == ends[1] { 0.0 } else { 1.0 }
            }
            // A flat line has few rows to divide.
            Area::SmoothLine(..) if h < FEW_ROWS => 0.0,
            Area::SmoothLine(..) => w.max(h) * 3.0 * SMOOTH_NS,
            Area::Arc(Arc { radii: [inner, outer], .. }, _) => {
                w * h * 0.2 * pixel * if outer > inner { 1.0 - inner / outer } else { 0.0 }
            }
            Area::Curve(_, width, _) => width.min(w.min(h)) * w.max(h) * 0.3 * pixel,
        }
    }

    /// Returns whether several threads draw the area sooner than one. They do not if all that it does is
    /// to store a colour: that takes as long as the memory takes.
    #[inline(always)]
    pub(super) fn is_worth_threads(&self, memory: &VideoMemory, blend: Blend) -> bool {
        !self.is_stored(blend) && self.least_ns(frame(memory), blend) > LEAST_NS
    }

    /// Returns whether the area is stored in one colour.
    #[inline(always)]
    fn is_stored(&self, blend: Blend) -> bool {
        let color = match *self {
            Area::Rect(_, color)
            | Area::Disc(_, _, color)
            | Area::Ellipse(_, _, color)
            | Area::Triangle(_, AreaColors::One(color))
            | Area::Polygon(_, color)
            | Area::WideLine(_, _, color)
            | Area::Arc(_, color)
            | Area::Curve(_, _, color) => color,
            Area::Triangle(_, AreaColors::Three(_)) | Area::SmoothLine(..) => return false,
        };
        blend == Blend::Replace || color[3] == 255
    }

    /// Draws the area on all threads of a pool.
    #[inline(never)]
    pub(super) fn draw_on_pool(
        &self,
        pool: &sync::Arc<ThreadPool>,
        memory: &mut VideoMemory,
        blend: Blend,
    ) -> Result<(), DrawError> {
        let executor = Executor::of_pool(Some(pool.clone()));
        let most = (self.least_ns(frame(memory), blend) / BAND_NS) as usize;
        let bands = match executor.threads() {
            1 => 1,
            threads => (threads * BANDS_A_THREAD).min(most),
        };
        self.draw_in_bands(&executor, memory, bands, blend)
    }

    /// Draws the area in at most so many bands of rows, which the executor's threads take.
    ///
    /// # Errors
    /// If the verb refuses its arguments.
    pub fn draw_in_bands(
        &self,
        executor: &Executor,
        memory: &mut VideoMemory,
        bands: usize,
        blend: Blend,
    ) -> Result<(), DrawError> {
        let ([[_, low], [_, high]], clip) = (self.bounds(), frame(memory));
        // Conversions saturate.
        let first = (low.floor() as i32).saturating_sub(1).max(clip.y0);
        let ys = first..(high.ceil() as i32).saturating_add(1).min(clip.y1);
        if bands <= 1 || ys.is_empty() {
            return on_all_rows(memory, |band| self.draw_on(band, blend));
        }
        let refused = OnceLock::new();
        on_bands(executor, memory, ys, bands, |band| {
            if let Err(error) = self.draw_on(band, blend) {
                let _ = refused.set(error);
            }
        });
        refused.into_inner().map_or(Ok(()), Err)
    }
}

/// Returns the corners of the box around points, `reach` wider on all sides.
#[inline(always)]
fn bounds(points: &[[f64; 2]], reach: f64) -> [[f64; 2]; 2] {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for p in points {
        (low, high) = ([0, 1].map(|i| low[i].min(p[i])), [0, 1].map(|i| high[i].max(p[i])));
    }
    [low.map(|v| v - reach), high.map(|v| v + reach)]
}

/// Returns the share of the box around a polygon that its outline encloses; of one that crosses itself,
/// less or more.
#[cold]
fn filled_share(points: &[[f64; 2]]) -> f64 {
    let [low, high] = bounds(points, 0.0);
    let pairs = points.iter().zip(points.iter().cycle().skip(1));
    let doubled: f64 =
        pairs.map(|(a, b)| (a[0] - low[0]) * (b[1] - low[1]) - (a[1] - low[1]) * (b[0] - low[0])).sum();
    (doubled.abs() / 2.0 / ((high[0] - low[0]) * (high[1] - low[1]))).min(1.0)
}

/// Draws areas in their order on all threads of an executor, `band_rows` rows at a time. Returns
/// `false`, and draws nothing, where one thread is as quick.
///
/// `area` returns an item's area, if it is one, and the rows of the frame that it may touch. Areas that
/// are refused draw nothing.
pub fn areas_on<'a, T: Sync>(
    executor: &Executor,
    memory: &mut VideoMemory,
    areas: &'a [T],
    band_rows: u32,
    blend: Blend,
    area: impl Fn(&'a T) -> Option<(Range<u32>, Area<'a>)> + Sync,
) -> bool {
    let clip = frame(memory);
    if executor.threads() == 1 || least_ns(areas.iter().filter_map(&area), clip, blend) <= LEAST_NS {
        return false;
    }
    let bands = ((clip.y1 - clip.y0) as u32).div_ceil(band_rows.max(1));
    on_bands(executor, memory, clip.y0..clip.y1, bands as usize, |band| {
        let PixelRect { y0, y1, .. } = band.clip();
        for (rows, area) in areas.iter().filter_map(&area) {
            if rows.start < y1 as u32 && rows.end > y0 as u32 {
                let _ = area.draw_on(band, blend);
            }
        }
    });
    true
}

/// Estimates the nanoseconds of areas that threads can share: where many are stored over each other, all
/// but the first, which takes as long as the memory takes.
fn least_ns<'a>(areas: impl Iterator<Item = (Range<u32>, Area<'a>)>, clip: PixelRect, blend: Blend) -> f64 {
    let (mut stored, mut other) = (0.0, 0.0);
    for (_, area) in areas {
        *(if area.is_stored(blend) { &mut stored } else { &mut other }) += area.least_ns(clip, blend);
    }
    let once = f64::from(clip.x1 - clip.x0) * f64::from(clip.y1 - clip.y0) * STORED_NS;
    other + (stored - once).max(0.0)
}
