//! Rasterizes faces in submission order, for alpha blending and the painter's algorithm; on a pool,
//! in bands of rows.
//!
//! In: a list of faces of prepared draws. Out: bytes, depths and ids in the target. Faces are
//! prepared in batches of the list. Every pixel belongs to one band and every band draws its faces
//! in order, so the result equals that of the plain path for all that it draws: transparency, fog,
//! every depth format, painter. The plan of a draw says whether vector kernels draw its faces. A
//! draw that is preempted stops in each band between two faces, and goes on there.

use super::assemble::Face;
use super::depth_sort::recycle;
use super::draw_call::{DrawStats, Target};
use super::plan::Part;
use super::preemption::{NOT_PREEMPTED, Slice, UNIT_PIXELS};
use super::prepared_draw::PreparedDraw;
use super::reference::WriteMask;
use super::shade::FaceShade;
use super::target_rows::TargetRows;
use super::tile::BlendedFace;
use super::tile_frontend::{BlendedRaster, BlendedSetup, DrawContext};
use super::working::FACE_ENTRY_BYTES;
use crate::executor::{Executor, join};
use crate::math::coverage::PixelRect;
use crate::simd::Level;
use std::fmt;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Faces prepared before they are drawn: bounds the memory for prepared faces.
const BATCH: usize = 8192;
/// Rows of a band.
const BAND_ROWS: u32 = 16;
/// Pixels that take as long as a face takes beside its pixels.
const FACE_COST: i64 = 1 << 10;
/// Total bounding-box pixels below which the calling thread draws alone: waking others costs more.
const FEW_PIXELS: u64 = 20_000;

/// A face ready to be rasterized.
struct PreparedFace<'a> {
    /// Index of the prepared draw.
    object: usize,
    triangle: u32,
    face: Face,
    shade: FaceShade<'a>,
    /// Pixels outside of which the face covers nothing.
    bounds: PixelRect,
    /// Set if a vector kernel draws the face.
    blended_face: Option<BlendedFace<'a>>,
}

/// A face, or `None` if nothing of it is visible, and the statistics of preparing it.
type PreparedFaceResult<'a> = (Option<PreparedFace<'a>>, DrawStats);

/// Items of [`Preemption::without`](super::preemption::Preemption::without) as which the set-up of a
/// face counts.
const FACE_ITEMS: usize = 64;

/// Number of faces that are prepared together: up to it the calling thread does.
const FEW_FACES: usize = 64;

/// Returns the bytes for drawing `faces` faces in submission order, apart from their vertices.
pub(crate) fn face_list_bytes(faces: u64) -> u64 {
    faces.min(BATCH as u64) * size_of::<PreparedFaceResult>() as u64 + faces * FACE_ENTRY_BYTES
}

/// Buffers that one draw leaves to the next for reuse.
#[derive(Default)]
pub(crate) struct FaceList {
    blended_setups: Vec<BlendedSetup>,
    prepared_faces: Vec<PreparedFaceResult<'static>>,
    /// For each band, the number of faces of the batch that it has passed.
    progress: Vec<AtomicU32>,
    /// Faces drawn: by vector kernels, and by the reference.
    drawn: [u64; 2],
}

impl fmt::Debug for FaceList {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "FaceList of {} bytes", self.size_bytes())
    }
}

impl FaceList {
    /// Returns the bytes that the lists take.
    pub fn size_bytes(&self) -> usize {
        self.prepared_faces.capacity() * size_of::<PreparedFaceResult>()
            + self.progress.capacity() * size_of::<AtomicU32>()
            + self.blended_setups.capacity() * size_of::<BlendedSetup>()
            + self.blended_setups.iter().map(BlendedSetup::size_bytes).sum::<usize>()
    }

    /// Returns the number of faces drawn by vector kernels, and of those drawn by the reference.
    pub fn faces_drawn(&self) -> [u64; 2] {
        self.drawn
    }
}

/// Draws a list of faces, given as (object index, triangle index), in its order. All objects must
/// have the same viewport and depth settings.
pub(crate) fn draw_in_order(
    context: DrawContext<'_>,
    lists: &mut FaceList,
    all: &[PreparedDraw],
    list: &[(usize, u32)],
    target: &mut Target,
    stats: &mut DrawStats,
) {
    let DrawContext { level, executor } = context;
    let pool = executor.pool();
    let preemption = all.first().map_or(&NOT_PREEMPTED, |any| any.preemption);
    let FaceList { blended_setups, prepared_faces, mut progress, drawn } = std::mem::take(lists);
    lists.drawn = drawn;
    let (mut blended_setups, mut prepared_faces): (Vec<BlendedSetup>, Vec<PreparedFaceResult>) =
        (blended_setups, prepared_faces);
    set_up_objects(&mut blended_setups, all, list);
    for batch in list.chunks(BATCH).take_while(|_| !executor.is_cancelled()) {
        let set_up = |&face: &(usize, u32)| set_up_face(all, &blended_setups, face);
        prepared_faces.clear();
        prepared_faces.resize_with(batch.len(), Default::default);
        // A large face is set up row by row.
        preemption.without(target, batch.len() * FACE_ITEMS, || {
            executor.chunks(&mut prepared_faces, FEW_FACES, |run, out| {
                let faces = &batch[run * FEW_FACES..];
                out.iter_mut().zip(faces).for_each(|(out, face)| *out = set_up(face));
            });
        });
        prepared_faces.iter().for_each(|(_, own)| *stats += *own);
        let faces = || prepared_faces.iter().filter_map(|(prepared_faces, _)| prepared_faces.as_ref());
        faces().for_each(|face| lists.drawn[usize::from(face.blended_face.is_none())] += 1);
        let Some(top) = faces().map(|f| f.bounds.y0).min() else { continue };
        let bottom = faces().map(|f| f.bounds.y1).max().unwrap_or(top);
        let area = |b: &PixelRect| (b.x1 - b.x0).max(0) as u64 * (b.y1 - b.y0).max(0) as u64;
        let pixels: u64 = faces().map(|f| area(&f.bounds)).sum();
        let Some(any) = all.first() else { continue };
        let rows = top.max(0) as u32..bottom.max(top).max(0) as u32;
        progress.clear();
        progress.resize_with(rows.len().div_ceil(BAND_ROWS as usize).max(1), AtomicU32::default);
        let work =
            Work { all, faces: &prepared_faces, level, executor, first_row: rows.start, progress: &progress };
        let pool = pool.filter(|_| pixels >= FEW_PIXELS);
        while !work.is_complete(pool.is_some()) && !executor.is_cancelled() {
            let (_, target_rows) = any.target_rows(target).split(rows.start);
            let (target_rows, _) = target_rows.split(rows.end);
            let slice = &Slice::new(preemption);
            let (own, written) = match pool {
                None => work.draw_band(target_rows, &progress[0], slice),
                Some(pool) => {
                    executor.region(|| pool.install(|| work.share(target_rows, rows.clone(), slice)))
                }
            };
            *stats += own;
            target.memory.mark_rows(written);
            preemption.point(target);
        }
    }
    prepared_faces.clear();
    lists.progress = progress;
    lists.prepared_faces = recycle(prepared_faces);
    lists.blended_setups = blended_setups;
}

/// Sets up a face of the list.
fn set_up_face<'p>(
    all: &'p [PreparedDraw],
    blended_setups: &'p [BlendedSetup],
    (object, triangle): (usize, u32),
) -> PreparedFaceResult<'p> {
    let mut own = DrawStats::default();
    let prepared = &all[object];
    let prepared_face = prepared.assemble(triangle, &mut own).map(|face| {
        let shade = prepared.shade(triangle, face.side, &mut own);
        let bounds = prepared.bounds_of(triangle);
        let blended_face =
            blended_setups.get(object).and_then(|v| prepared.blended_face(v, triangle, &face, &shade));
        PreparedFace { object, triangle, face, shade, bounds, blended_face }
    });
    (prepared_face, own)
}

/// Sets up the objects of the list that vector kernels draw, each once.
fn set_up_objects(blended_setups: &mut Vec<BlendedSetup>, all: &[PreparedDraw], list: &[(usize, u32)]) {
    blended_setups.iter_mut().for_each(BlendedSetup::forget);
    blended_setups.resize_with(blended_setups.len().max(all.len()), BlendedSetup::default);
    let mut last = usize::MAX;
    for &(object, _) in list {
        let (prepared, setup) = (&all[object], &mut blended_setups[object]);
        if object != last && prepared.parts.uses(Part::FacesInOrder) && !setup.is_set_up() {
            prepared.set_up_blended(setup);
        }
        last = object;
    }
}

/// Shared inputs of all bands.
struct Work<'w, 'a> {
    all: &'w [PreparedDraw<'a>],
    faces: &'w [PreparedFaceResult<'w>],
    level: Level,
    executor: &'w Executor,
    first_row: u32,
    /// For each band, the number of faces that it has passed.
    progress: &'w [AtomicU32],
}

impl Work<'_, '_> {
    /// Returns whether all faces are drawn: in all bands, or in the only one if there is no pool.
    fn is_complete(&self, has_bands: bool) -> bool {
        let bands = if has_bands { self.progress } else { &self.progress[..1] };
        bands.iter().all(|passed| passed.load(Relaxed) as usize >= self.faces.len())
    }

    /// Splits the target rows in halves down to single bands, and draws these on the pool.
    fn share(&self, target_rows: TargetRows, rows: Range<u32>, slice: &Slice) -> (DrawStats, Range<u32>) {
        if rows.len() as u32 <= BAND_ROWS {
            let band = ((rows.start - self.first_row) / BAND_ROWS) as usize;
            let mut drawn = (DrawStats::default(), 0..0);
            self.executor.piece(|| drawn = self.draw_band(target_rows, &self.progress[band], slice));
            return drawn;
        }
        let middle = rows.start + (rows.len() as u32 / 2).next_multiple_of(BAND_ROWS);
        let (above, below) = target_rows.split(middle);
        let (a, b) = join(
            || self.share(above, rows.start..middle, slice),
            || self.share(below, middle..rows.end, slice),
        );
        let mut stats = a.0;
        stats += b.0;
        (stats, joined(a.1, b.1))
    }

    /// Draws the faces that reach the rows of one band and that it has not passed, until the slice
    /// is over. Returns the statistics and the rows written.
    fn draw_band(
        &self,
        mut target_rows: TargetRows,
        passed: &AtomicU32,
        slice: &Slice,
    ) -> (DrawStats, Range<u32>) {
        let mut stats = DrawStats::default();
        let rows = target_rows.rows();
        // Pixels to draw until the clock is read again.
        let (mut left, first) = (0, passed.load(Relaxed) as usize);
        for (i, (face, _)) in self.faces.iter().enumerate().skip(first) {
            let Some(f) = face.as_ref().filter(|f| f.bounds.y0 < rows.end && f.bounds.y1 > rows.start) else {
                continue;
            };
            if left <= 0 {
                if slice.is_over() {
                    passed.store(i as u32, Relaxed);
                    return (stats, target_rows.written);
                }
                left = UNIT_PIXELS;
            }
            left -= FACE_COST + i64::from(rows.end - rows.start) * i64::from(f.bounds.x1 - f.bounds.x0);
            if self.executor.is_cancelled() {
                break;
            }
            let prepared = &self.all[f.object];
            match &f.blended_face {
                Some(blended_face) => {
                    let (triangle, face, shade) = (f.triangle, &f.face, &f.shade);
                    target_rows.open_box(f.bounds);
                    let raster = BlendedRaster { prepared, triangle, blended_face, face, shade };
                    stats += raster.draw(self.level, &mut target_rows);
                }
                None => prepared.raster(&mut target_rows).face(
                    &f.face,
                    &f.shade,
                    f.triangle,
                    WriteMask::Color,
                    &mut stats,
                ),
            }
        }
        passed.store(self.faces.len() as u32, Relaxed);
        (stats, target_rows.written)
    }
}

/// Returns the smallest range that contains both, either of which may be empty.
fn joined(a: Range<u32>, b: Range<u32>) -> Range<u32> {
    match (a.is_empty(), b.is_empty()) {
        (true, _) => b,
        (_, true) => a,
        _ => a.start.min(b.start)..a.end.max(b.end),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_faces_take_what_is_stated_for_them() {
        let mut list = FaceList::default();
        assert_eq!(list.size_bytes(), 0);
        list.prepared_faces.reserve_exact(100);
        let faces = 100 * size_of::<PreparedFaceResult>();
        assert_eq!(list.size_bytes(), faces);
        list.progress.reserve_exact(50);
        list.blended_setups.reserve_exact(2);
        assert_eq!(list.size_bytes(), faces + 50 * 4 + 2 * size_of::<BlendedSetup>());
        // The list that is drawn, and each face of it set up.
        assert!(face_list_bytes(100) >= (faces + 100 * size_of::<(usize, u32)>()) as u64);
        // A long list is set up in parts.
        let per_face = (face_list_bytes(2_000_000) - face_list_bytes(1_000_000)) / 1_000_000;
        assert_eq!(per_face, FACE_ENTRY_BYTES);
    }
}
