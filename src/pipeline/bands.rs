//! The plain path over threads: faces set up in pieces of the list, then drawn band by band of rows, in the list's order.
//!
//! Every pixel belongs to one band and every band draws its faces in order, so bytes, depths and ids are those of the plain
//! path for everything that it draws: transparency, fog, every depth format, painter. With a level of vectors, faces that
//! allow it are drawn by them.

use super::assemble::Face;
use super::call::{DrawStats, Target};
use super::fast::Veils;
use super::order::{LISTED_BYTES, emptied};
use super::prepare::Prepared;
use super::raster::{Canvas, Writes};
use super::shade::FaceShade;
use super::tile::{Veil, Workers};
use crate::cancel::CancelToken;
use crate::math::coverage::PixelRect;
use crate::simd::Level;
use rayon::prelude::*;
use std::fmt;
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
    veil: Option<Veil<'a>>,
}

/// A face, unless nothing of it is seen, and what was counted on the way.
type Made<'a> = (Option<SetUp<'a>>, DrawStats);

/// Fewer faces than this are set up by the calling thread.
const FEW_FACES: usize = 64;

/// Bytes that drawing `faces` faces in order takes beside their vertices.
pub(crate) fn listed_bytes(faces: u64) -> u64 {
    faces.min(BATCH as u64) * size_of::<Made>() as u64 + faces * LISTED_BYTES
}

/// Lists that one draw leaves to the next.
#[derive(Default)]
pub(crate) struct Listed {
    veils: Vec<Veils>,
    made: Vec<Made<'static>>,
}

impl fmt::Debug for Listed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Listed of {} bytes", self.size_bytes())
    }
}

impl Listed {
    /// Bytes that the lists take.
    pub fn size_bytes(&self) -> usize {
        self.made.capacity() * size_of::<Made>()
            + self.veils.capacity() * size_of::<Veils>()
            + self.veils.iter().map(Veils::size_bytes).sum::<usize>()
    }
}

/// Draws a list of faces - object, triangle - in its order. All objects are drawn through one viewport, with one rule for
/// depth.
pub(crate) fn draw_listed(
    (crew, level): (&Workers, Option<Level>),
    lists: &mut Listed,
    all: &[Prepared],
    list: &[(usize, u32)],
    target: &mut Target,
    stats: &mut DrawStats,
) {
    let pool = crew.pool();
    if pool.is_none() && level.is_none() {
        let faces = list.iter().take_while(|_| !crew.is_cancelled());
        return faces.for_each(|&(o, t)| all[o].draw_any_face(t, target, stats));
    }
    let Listed { veils, made } = std::mem::take(lists);
    let (mut veils, mut made): (Vec<Veils>, Vec<Made>) = (veils, made);
    if level.is_some() {
        veils.iter_mut().for_each(Veils::forget);
        veils.resize_with(veils.len().max(all.len()), Veils::default);
        let mut last = usize::MAX;
        for &(object, _) in list {
            if object != last && veils[object].is_unasked() {
                all[object].make_veils(target, &mut veils[object]);
            }
            last = object;
        }
    }
    for batch in list.chunks(BATCH).take_while(|_| !crew.is_cancelled()) {
        let set_up = |&(object, triangle): &(usize, u32)| {
            let mut own = DrawStats::default();
            let prepared = &all[object];
            let made = prepared.assemble(triangle, &mut own).map(|face| {
                let shade = prepared.shade(triangle, face.side, &mut own);
                let bounds = prepared.bounds_of(triangle);
                let veil = veils.get(object).and_then(|v| prepared.veil(v, triangle, &face, &shade));
                SetUp { object, triangle, face, shade, bounds, veil }
            });
            (made, own)
        };
        made.clear();
        match pool.filter(|_| batch.len() >= FEW_FACES) {
            None => made.extend(batch.iter().map(set_up)),
            Some(pool) => pool.install(|| batch.par_iter().map(set_up).collect_into_vec(&mut made)),
        }
        made.iter().for_each(|(_, own)| *stats += *own);
        let faces = || made.iter().filter_map(|(made, _)| made.as_ref());
        let Some(top) = faces().map(|f| f.bounds.y0).min() else { continue };
        let bottom = faces().map(|f| f.bounds.y1).max().unwrap_or(top);
        let area = |b: &PixelRect| (b.x1 - b.x0).max(0) as u64 * (b.y1 - b.y0).max(0) as u64;
        let pixels: u64 = faces().map(|f| area(&f.bounds)).sum();
        let Some(any) = all.first() else { continue };
        let canvas = any.canvas(target);
        let rows = top.max(0) as u32..bottom.max(top).max(0) as u32;
        let (_, canvas) = canvas.split(rows.start);
        let (canvas, _) = canvas.split(rows.end);
        let work = Work { all, faces: &made, level: level.unwrap_or(Level::Portable), cancel: crew.cancel() };
        let (own, written) = match pool.filter(|_| pixels >= FEW_PIXELS) {
            None => work.draw_band(canvas),
            Some(pool) => pool.install(|| work.share(canvas, rows)),
        };
        *stats += own;
        target.memory.mark_rows(written);
    }
    made.clear();
    lists.made = emptied(made);
    lists.veils = veils;
}

/// What all bands draw.
struct Work<'w, 'a> {
    all: &'w [Prepared<'a>],
    faces: &'w [Made<'w>],
    level: Level,
    cancel: &'w CancelToken,
}

impl Work<'_, '_> {
    /// Halves the canvas until it is a band.
    fn share(&self, canvas: Canvas, rows: Range<u32>) -> (DrawStats, Range<u32>) {
        if rows.len() as u32 <= BAND_ROWS {
            return self.draw_band(canvas);
        }
        let middle = rows.start + (rows.len() as u32 / 2).next_multiple_of(BAND_ROWS);
        let (above, below) = canvas.split(middle);
        let (a, b) =
            rayon::join(|| self.share(above, rows.start..middle), || self.share(below, middle..rows.end));
        let mut stats = a.0;
        stats += b.0;
        (stats, joined(a.1, b.1))
    }

    fn draw_band(&self, mut canvas: Canvas) -> (DrawStats, Range<u32>) {
        let mut stats = DrawStats::default();
        let rows = canvas.rows();
        let faces = self.faces.iter().filter_map(|(made, _)| made.as_ref());
        for f in faces.filter(|f| f.bounds.y0 < rows.end && f.bounds.y1 > rows.start) {
            if self.cancel.is_cancelled() {
                break;
            }
            let mut raster = self.all[f.object].raster(&mut canvas);
            match &f.veil {
                Some(veil) => raster.veil(self.level, veil, (&f.face, &f.shade), f.triangle, &mut stats),
                None => raster.face(&f.face, &f.shade, f.triangle, Writes::Color, &mut stats),
            }
        }
        (stats, canvas.written)
    }
}

/// The smallest range that holds both, either of which may be empty.
fn joined(a: Range<u32>, b: Range<u32>) -> Range<u32> {
    match (a.is_empty(), b.is_empty()) {
        (true, _) => b,
        (_, true) => a,
        _ => a.start.min(b.start)..a.end.max(b.end),
    }
}
