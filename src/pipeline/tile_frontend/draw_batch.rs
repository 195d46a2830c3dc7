//! Batches of consecutive small draws: one has too little work for two threads, all of them have
//! enough.
//!
//! First each draw is prepared independently, on any thread: inputs, tables, binning of its faces.
//! Then each row of tiles is drawn, on any thread: the draws that reach it, in submission order. A
//! pixel belongs to one row of tiles, so it sees the draws in order, and each draw writes there
//! what it would write alone: the bytes are the same.

use super::draw_inputs::DrawInputs;
use super::{FEW_FACES, TileWorkspace, frame_of, unsupported_reason};
use crate::executor::Executor;
use crate::memory::DepthFormat;
use crate::pipeline::depth_sort::recycle;
use crate::pipeline::draw_call::{CoarseDepth, DrawStats, Target};
use crate::pipeline::plan::Part;
use crate::pipeline::preemption::{NOT_PREEMPTED, Slice};
use crate::pipeline::prepared_draw::PreparedDraw;
use crate::pipeline::tile::{self, Binned, Binning, Counts, ListBytes, MOST_TILE_ROWS, RowProgress};
use crate::simd::Level;
use rayon::prelude::*;
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Maximum number of draws in a batch.
const MOST_DRAWS: usize = 256;

/// Maximum bytes of the empty tile lists of a batch.
const MOST_BYTES: usize = 8 << 20;

/// Bytes of the batch's tile lists beyond which no further draw is binned.
const LIST_BYTES: usize = 32 << 20;

/// Buffers that one batch leaves to the next.
#[derive(Default)]
pub(crate) struct DrawBatch {
    /// Workspace of each draw.
    slots: Vec<TileWorkspace>,
    /// Shared count of the bytes that all tile lists have room for.
    bytes: ListBytes,
    drawn: Vec<Option<Drawn<'static>>>,
    /// Half the number of draws to try next; small after a batch with a draw that the tile renderer
    /// could not draw.
    half: usize,
    /// Maximum number of draws tried in the last batch.
    most: usize,
}

/// A draw whose faces have been binned.
struct Drawn<'p> {
    inputs: DrawInputs<'p>,
    /// Its bins and the rows of tiles that they reach; `None` if no face reaches a tile.
    binned: Option<(Binned, (usize, usize))>,
    counts: Counts,
    stats: DrawStats,
}

impl fmt::Debug for DrawBatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "DrawBatch of {} bytes", self.size_bytes())
    }
}

impl DrawBatch {
    /// Returns the bytes of all buffers.
    pub fn size_bytes(&self) -> usize {
        let slots = self.slots.iter().map(|m| size_of::<TileWorkspace>() + m.size_bytes());
        slots.sum::<usize>() + self.drawn.capacity() * size_of::<Option<Drawn>>()
    }

    /// Returns the bytes to reserve: the tiles' lists, and the vertices and tables of each draw.
    pub fn held_bytes(&self) -> u64 {
        let slots: usize =
            self.slots.iter().map(|slot| size_of::<TileWorkspace>() + slot.table_bytes()).sum();
        (self.bytes.get() + slots + self.drawn.capacity() * size_of::<Option<Drawn>>()) as u64
    }

    /// Returns the worst-case bytes of a batch. `bindings` yields the bytes of each draw's
    /// materials and lights.
    pub fn worst_bytes(bindings: impl Iterator<Item = u64>, threads: u64, target: &Target) -> u64 {
        let (width, height) = (target.memory.width() as usize, target.memory.height() as usize);
        // A screen vertex and its f64 depth, and four tables.
        let draw = 3 * FEW_FACES as u64 * (tile::SCREEN_VERTEX_BYTES + tile::DEPTH_VERTEX_BYTES + 4 * 16)
            + (size_of::<TileWorkspace>() + size_of::<Option<Drawn>>()) as u64;
        let (count, bindings) = bindings
            .take(MOST_DRAWS)
            .fold((0, 0), |(count, sum): (u64, u64), bytes| (count + 1, sum + bytes));
        let faces = count * FEW_FACES as u64;
        count * draw + bindings + tile::worst_list_bytes(faces, threads, (width, height), LIST_BYTES as u64)
    }

    /// Returns how many of the first of these draws can form a batch; 0 if fewer than two.
    pub fn count(&mut self, all: &[PreparedDraw], target: &Target) -> usize {
        let grid = tile::grid_bytes((target.memory.width() as usize, target.memory.height() as usize));
        let most = (2 * self.half.max(1)).min(MOST_DRAWS).min(MOST_BYTES / grid.max(1));
        self.most = most;
        let count = all.iter().take(most).take_while(|p| can_join(p, &all[0], target)).count();
        if count < 2 {
            self.half = most;
            return 0;
        }
        count
    }

    /// Draws the opaque faces of these draws, as counted by [`DrawBatch::count`]. Returns how many
    /// draws were drawn.
    pub fn draw(
        &mut self,
        (level, executor, coarse): (Level, &Executor, CoarseDepth),
        all: &[PreparedDraw],
        target: &mut Target,
        stats: &mut DrawStats,
    ) -> usize {
        let (Some(pool), count) = (executor.pool(), all.len()) else { return 0 };
        let serial = &executor.serial();
        if self.bytes.get() > LIST_BYTES {
            self.slots.iter_mut().for_each(|slot| slot.scratch.give_lists_back());
        }
        let mut drawn: Vec<Option<Drawn>> = std::mem::take(&mut self.drawn);
        if self.slots.len() < count {
            let bytes = &self.bytes;
            self.slots.resize_with(count, || {
                let mut slot = TileWorkspace::default();
                slot.scratch.share_lists(bytes, LIST_BYTES);
                slot
            });
        }
        let slots = &mut self.slots[..count];
        let (width, format) = (target.memory.width() as usize, target.depth_format);
        let preemption = all.first().map_or(&NOT_PREEMPTED, |any| any.preemption);
        let complete = preemption.run_draw(executor, || {
            let pairs = slots.par_iter_mut().zip(all).with_min_len(4);
            let binned = pairs.map(|(slot, p)| Drawn::new(p, slot, (level, serial, coarse), (width, format)));
            pool.install(|| binned.collect_into_vec(&mut drawn));
            let complete = drawn.iter().take_while(|d| d.is_some()).count();
            draw_rows((level, executor), (&drawn[..complete], &*slots, all), target);
            complete
        });
        self.half = if complete < count { complete.max(1) } else { self.most };
        for (i, ((drawn, slot), prepared)) in drawn.drain(..).zip(slots).zip(all).enumerate() {
            let Some(Drawn { inputs, counts, stats: mut own, .. }) = drawn else { continue };
            slot.recycled.take_back(inputs.bindings);
            if i < complete {
                let (tested, passed) = counts.fragments();
                (own.pixels_tested, own.pixels_written) = (own.pixels_tested + tested, passed);
                own.faces_hidden = counts.hidden();
                *stats += prepared.counted(own);
            }
        }
        self.drawn = recycle(drawn);
        complete
    }
}

/// Draws the rows of tiles of a batch, in slices between preemption points. A slice ends between two
/// rows.
fn draw_rows(
    (level, executor): (Level, &Executor),
    (drawn, slots, all): (&[Option<Drawn>], &[TileWorkspace], &[PreparedDraw]),
    target: &mut Target,
) {
    let each = || drawn.iter().flatten().zip(slots).zip(all);
    let reached = || each().filter_map(|((d, _), _)| d.binned.as_ref()).map(|b| b.1);
    let (first, last) = (reached().map(|b| b.0).min(), reached().map(|b| b.1).max());
    let (Some(first), Some(last), Some(((any, _), _))) = (first, last, each().next()) else { return };
    let format = target.depth_format;
    let has_depth = all[0].plan.uses(Part::DepthMemory);
    let complete = [const { AtomicBool::new(false) }; MOST_TILE_ROWS];
    let is_complete = |band: usize| complete[band].load(Relaxed);
    while !executor.is_cancelled() && !(first..=last).all(is_complete) {
        let (slice, whole) = (&Slice::new(all[0].preemption), &Slice::new(&NOT_PREEMPTED));
        let work = |band: usize, buffers: &mut tile::TileRowBuffers<'_>, ids: &mut _| {
            if is_complete(band) || slice.is_over() {
                return;
            }
            for ((d, slot), prepared) in each() {
                let reaches = |b: &&(Binned, (usize, usize))| b.1.0 <= band && band <= b.1.1;
                let Some((binned, _)) = d.binned.as_ref().filter(reaches) else { continue };
                prepared.with_job(&d.inputs, &slot.tables, format, |job| {
                    let (scratch, counts) = (&slot.scratch, &d.counts);
                    let draw = tile::BinnedDraw { level, scratch, binned, job, counts, slice: whole };
                    draw.draw_tile_row(band, &RowProgress::default(), buffers, ids);
                });
            }
            complete[band].store(true, Relaxed);
        };
        let rows = executor.run(|| {
            let frame = frame_of(target, has_depth);
            tile::for_each_tile_row(executor, (first, last), &any.inputs.view, frame, &work)
        });
        target.memory.mark_rows(rows.0..rows.1);
        all[0].preemption.point(target);
    }
}

impl<'p> Drawn<'p> {
    /// Prepares a draw up to binning. Returns `None` if the tile renderer cannot draw it in one
    /// piece.
    fn new(
        prepared: &'p PreparedDraw,
        slot: &mut TileWorkspace,
        (level, executor, coarse): (Level, &Executor, CoarseDepth),
        (width, format): (usize, DepthFormat),
    ) -> Option<Self> {
        let TileWorkspace { scratch, tables, recycled } = slot;
        let mut inputs = prepared.inputs(recycled)?;
        inputs.coarse = coarse;
        prepared.make_tables(&mut inputs, level, executor, tables);
        let mut stats = DrawStats::default();
        let binned = prepared.with_job(&inputs, tables, format, |job| {
            Binning::new(level, executor, scratch, job, width).next(level, executor, scratch, job, &mut stats)
        });
        // A draw that needs several pieces is drawn by itself.
        let faces = prepared.call.geometry.mesh.triangles.len();
        if binned.is_some_and(|b| b.until < faces) {
            return None;
        }
        let binned = binned.and_then(|b| Some((b, b.bands?)));
        Some(Drawn { inputs, binned, counts: Counts::default(), stats })
    }
}

/// Returns whether a draw can be batched with `first`: it is small, supported by the tile renderer,
/// and has the same clip rectangle and depth use.
fn can_join(prepared: &PreparedDraw, first: &PreparedDraw, target: &Target) -> bool {
    let mesh = &prepared.call.geometry.mesh;
    let has_depth = |p: &PreparedDraw| p.plan.uses(Part::DepthMemory);
    mesh.triangles.len() <= FEW_FACES
        && mesh.lines.is_empty()
        && mesh.points.is_empty()
        && prepared.transform().screen.clip == first.transform().screen.clip
        && has_depth(prepared) == has_depth(first)
        && unsupported_reason(prepared.call, target, &prepared.plan).is_none()
}
