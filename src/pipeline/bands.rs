//! The plain path over threads: faces set up in pieces of the list, then drawn band by band of rows, in the list's order.
//!
//! Every pixel belongs to one band and every band draws its faces in order, so bytes, depths and ids are those of the plain
//! path for everything that it draws: transparency, fog, every depth format, painter.

use super::assemble::Face;
use super::call::{DrawStats, Target};
use super::prepare::Prepared;
use super::raster::{Canvas, Writes};
use super::shade::FaceShade;
use super::tile::Workers;
use crate::math::coverage::PixelRect;
use rayon::prelude::*;
use std::ops::Range;

/// Faces that are set up before they are drawn: bounds what the set-ups take.
const BATCH: usize = 8192;
/// Rows of a band.
const BAND_ROWS: u32 = 16;
/// Boxes of fewer pixels than this together are drawn by the calling thread: waking others costs more.
const FEW_PIXELS: u64 = 20_000;

/// A face ready for its pixels.
struct SetUp<'a> {
    object: usize,
    triangle: u32,
    face: Face,
    shade: FaceShade<'a>,
    bounds: PixelRect,
}

/// Draws a list of faces - object, triangle - in its order. All objects are drawn through one viewport, with one rule for
/// depth.
pub(crate) fn draw_listed(
    crew: &Workers,
    all: &[&Prepared],
    list: &[(usize, u32)],
    target: &mut Target,
    stats: &mut DrawStats,
) {
    let Workers::Pool(pool) = crew else {
        return list.iter().for_each(|&(o, t)| all[o].draw_any_face(t, target, stats));
    };
    for batch in list.chunks(BATCH) {
        let set_up = |&(object, triangle): &(usize, u32)| {
            let mut own = DrawStats::default();
            let prepared: &Prepared = all[object];
            let made = prepared.assemble(triangle, &mut own).map(|face| {
                let shade = prepared.shade(triangle, face.side, &mut own);
                let bounds = prepared.bounds_of(triangle);
                SetUp { object, triangle, face, shade, bounds }
            });
            (made, own)
        };
        let made: Vec<_> = match batch.len() < 64 {
            true => batch.iter().map(set_up).collect(),
            false => pool.install(|| batch.par_iter().map(set_up).collect()),
        };
        made.iter().for_each(|(_, own)| *stats += *own);
        let faces: Vec<SetUp> = made.into_iter().filter_map(|(made, _)| made).collect();
        let Some(top) = faces.iter().map(|f| f.bounds.y0).min() else { continue };
        let bottom = faces.iter().map(|f| f.bounds.y1).max().unwrap_or(top);
        let area = |b: &PixelRect| (b.x1 - b.x0).max(0) as u64 * (b.y1 - b.y0).max(0) as u64;
        let pixels: u64 = faces.iter().map(|f| area(&f.bounds)).sum();
        let Some(any) = all.first() else { return };
        let canvas = any.canvas(target);
        let rows = top.max(0) as u32..bottom.max(top).max(0) as u32;
        let (_, canvas) = canvas.split(rows.start);
        let (canvas, _) = canvas.split(rows.end);
        let (own, written) = match pixels < FEW_PIXELS {
            true => draw_band(all, &faces, canvas),
            false => pool.install(|| share(all, &faces, canvas, rows)),
        };
        *stats += own;
        target.memory.mark_rows(written);
    }
}

/// Halves the canvas until it is a band.
fn share(all: &[&Prepared], faces: &[SetUp], canvas: Canvas, rows: Range<u32>) -> (DrawStats, Range<u32>) {
    if rows.len() as u32 <= BAND_ROWS {
        return draw_band(all, faces, canvas);
    }
    let middle = rows.start + (rows.len() as u32 / 2).next_multiple_of(BAND_ROWS);
    let (above, below) = canvas.split(middle);
    let (a, b) = rayon::join(
        || share(all, faces, above, rows.start..middle),
        || share(all, faces, below, middle..rows.end),
    );
    let mut stats = a.0;
    stats += b.0;
    (stats, joined(a.1, b.1))
}

fn draw_band(all: &[&Prepared], faces: &[SetUp], mut canvas: Canvas) -> (DrawStats, Range<u32>) {
    let mut stats = DrawStats::default();
    let rows = canvas.rows();
    for f in faces.iter().filter(|f| f.bounds.y0 < rows.end && f.bounds.y1 > rows.start) {
        let mut raster = all[f.object].raster(&mut canvas);
        raster.face(&f.face, &f.shade, f.triangle, Writes::Color, &mut stats);
    }
    (stats, canvas.written)
}

/// The smallest range that holds both, either of which may be empty.
fn joined(a: Range<u32>, b: Range<u32>) -> Range<u32> {
    match (a.is_empty(), b.is_empty()) {
        (true, _) => b,
        (_, true) => a,
        _ => a.start.min(b.start)..a.end.max(b.end),
    }
}
