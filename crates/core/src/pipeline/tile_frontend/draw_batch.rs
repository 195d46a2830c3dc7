//! Batches of draws by the tile renderer: a draw of any size by itself, or several small ones, each
//! of which has too little work for two threads.
//!
//! First each draw is prepared independently, on any thread: inputs, tables, binning of its faces.
//! Then each row of tiles is drawn, on any thread: the draws that reach it, in submission order. A
//! pixel belongs to one row of tiles, so it sees the draws in order, and each draw writes there
//! what it would write alone: the bytes are the same. The owner of the target has it while faces are
//! binned, and between slices of the rows of tiles.

use super::draw_inputs::DrawInputs;
use super::{DrawContext, FEW_FACES, TileWorkspace, frame_of};
use crate::executor::prelude::*;
use crate::memory::DepthFormat;
use crate::pipeline::depth_sort::recycle;
use crate::pipeline::draw_call::{DrawStats, Target};
use crate::pipeline::plan::Part;
use crate::pipeline::preemption::Slice;
use crate::pipeline::prepared_draw::PreparedDraw;
use crate::pipeline::tile::{self, Binned, Binning, Counts, ListBytes, RowProgress};
use std::fmt;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Maximum number of draws in a batch.
const MOST_DRAWS: usize = 256;

/// Maximum bytes of the empty tile lists of a batch.
const MOST_BYTES: usize = 8 << 20;

/// Bytes of the batch's tile lists beyond which no further draw is binned.
const LIST_BYTES: usize = 32 << 20;

/// Buffers that one batch leaves to the next.
#[derive(Default)]
pub(crate) struct DrawBatch {
    /// Workspace of a draw by itself.
    single: TileWorkspace,
    /// Workspaces of draws that are drawn together.
    slots: Vec<TileWorkspace>,
    /// Shared count of the bytes that the slots' tile lists have room for.
    bytes: ListBytes,
    drawn: Vec<Drawn<'static>>,
    rows: Vec<BatchRow>,
    /// Maximum number of draws to try next; small after a batch with a draw whose lists did not fit.
    limit: usize,
    /// Faces of the draws that were drawn.
    faces: u64,
}

/// A draw whose faces are binned, piece by piece.
struct Drawn<'p> {
    inputs: DrawInputs<'p>,
    binning: Binning,
    /// The current piece; `None` after the last.
    binned: Option<Binned>,
    counts: Counts,
    stats: DrawStats,
}

/// Progress of a row of tiles: the draw that it stands at, and where in it.
#[derive(Default)]
struct BatchRow {
    draw: AtomicUsize,
    within: RowProgress,
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
        slots.sum::<usize>()
            + self.single.size_bytes()
            + self.drawn.capacity() * size_of::<Drawn>()
            + self.rows.capacity() * size_of::<BatchRow>()
    }

    /// Returns the bytes to reserve for draws that are drawn together: the tiles' lists, and the
    /// vertices and tables of each draw.
    pub fn held_bytes(&self) -> u64 {
        let slots: usize =
            self.slots.iter().map(|slot| size_of::<TileWorkspace>() + slot.table_bytes()).sum();
        (self.bytes.get() + slots + self.drawn.capacity() * size_of::<Drawn>()) as u64
    }

    /// Returns the bytes that the tile lists of a draw by itself have room for.
    pub fn list_bytes(&self) -> u64 {
        self.single.scratch.lists_held() as u64
    }

    /// Sets the bytes of the tiles' face lists at which a draw by itself is split into pieces.
    pub fn bound_lists(&mut self, bytes: usize) {
        self.single.scratch.list_bytes = bytes;
    }

    /// Returns the number of faces of all draws that were drawn.
    pub fn faces_drawn(&self) -> u64 {
        self.faces
    }

    /// Returns the worst-case bytes of a batch. `bindings` yields the bytes of each draw's
    /// materials and lights.
    pub fn worst_bytes(bindings: impl Iterator<Item = u64>, threads: u64, target: &Target) -> u64 {
        let (width, height) = (target.memory.width() as usize, target.memory.height() as usize);
        // A screen vertex and its f64 depth, and four tables.
        let draw = 3 * FEW_FACES as u64 * (tile::SCREEN_VERTEX_BYTES + tile::DEPTH_VERTEX_BYTES + 4 * 16)
            + (size_of::<TileWorkspace>() + size_of::<Drawn>()) as u64;
        let (count, bindings) = bindings
            .take(MOST_DRAWS)
            .fold((0, 0), |(count, sum): (u64, u64), bytes| (count + 1, sum + bytes));
        let faces = count * FEW_FACES as u64;
        count * draw + bindings + tile::worst_list_bytes(faces, threads, (width, height), LIST_BYTES as u64)
    }

    /// Returns how many of the first of these draws can be drawn together, at least 1.
    pub fn count(&mut self, all: &[PreparedDraw], target: &Target) -> usize {
        let grid = tile::grid_bytes((target.memory.width() as usize, target.memory.height() as usize));
        let most = self.limit.clamp(2, MOST_DRAWS).min(MOST_BYTES / grid.max(1));
        self.limit = 2 * most;
        all.iter().take(most).take_while(|p| can_join(p, &all[0])).count().max(1)
    }

    /// Draws the opaque faces of these draws, which the plan leaves to the tile renderer: of one, or
    /// of as many as [`DrawBatch::count`] returns. Returns how many draws were drawn: fewer, perhaps
    /// none, if one of several does not fit in one piece. `each` is given the counts of each.
    pub fn draw(
        &mut self,
        context: DrawContext<'_>,
        all: &[PreparedDraw],
        target: &mut Target,
        each: &mut dyn FnMut(usize, DrawStats),
    ) -> usize {
        let Some(first) = all.first() else { return 0 };
        let is_single = all.len() == 1;
        let serial = context.executor.serial();
        let serial = DrawContext { level: context.level, executor: &serial };
        let context = if is_single && first.is_small() { serial } else { context };
        let mut drawn: Vec<Drawn> = std::mem::take(&mut self.drawn);
        if !is_single {
            self.open_slots(all.len());
        }
        let DrawBatch { single, slots, rows, limit, faces, .. } = self;
        let slots = if is_single { std::slice::from_mut(single) } else { &mut slots[..all.len()] };
        let preemption = first.preemption;
        let items = all.iter().map(PreparedDraw::items).sum();
        let (width, format) = (target.memory.width() as usize, target.depth_format);
        let complete = preemption.run_draw(context.executor, || {
            let prepare = || match (all, &mut *slots) {
                ([one], [slot]) => drawn.push(Drawn::new(one, slot, context, width, format)),
                (_, slots) => {
                    let pairs = slots.par_iter_mut().zip(all).with_min_len(4);
                    let each = pairs.map(|(slot, p)| Drawn::new(p, slot, serial, width, format));
                    each.collect_into_vec(&mut drawn);
                }
            };
            preemption.without(target, items, || context.executor.run(prepare));
            let complete = match is_single {
                true => 1,
                false => drawn.iter().zip(all).take_while(|(drawn, p)| drawn.is_whole(p)).count(),
            };
            BinnedBatch { context, drawn: &drawn[..complete], slots, all }.draw_rows(rows, target);
            while is_single && !drawn[0].is_whole(first) {
                let bin = || drawn[0].bin(first, &mut slots[0], context, format);
                preemption.without(target, items, || context.executor.run(bin));
                BinnedBatch { context, drawn: &drawn, slots, all }.draw_rows(rows, target);
            }
            complete
        });
        if complete < all.len() {
            *limit = 2 * complete;
        }
        for (i, ((drawn, slot), prepared)) in drawn.drain(..).zip(slots).zip(all).enumerate() {
            slot.recycled.take_back(drawn.inputs.bindings);
            if i < complete {
                let mut own = drawn.stats;
                drawn.counts.add_to(&mut own);
                each(i, prepared.counted(own));
                *faces += prepared.call.geometry.mesh.triangles.len() as u64;
            }
        }
        self.drawn = recycle(drawn);
        complete
    }

    /// Makes workspaces for `count` draws that are drawn together.
    fn open_slots(&mut self, count: usize) {
        if self.bytes.get() > LIST_BYTES {
            self.slots.iter_mut().for_each(|slot| slot.scratch.give_lists_back());
        }
        if self.slots.len() < count {
            let bytes = &self.bytes;
            self.slots.resize_with(count, || {
                let mut slot = TileWorkspace::default();
                slot.scratch.share_lists(bytes, LIST_BYTES);
                slot
            });
        }
    }
}

/// A batch whose faces are binned, each draw with its workspace.
struct BinnedBatch<'b> {
    context: DrawContext<'b>,
    drawn: &'b [Drawn<'b>],
    slots: &'b [TileWorkspace],
    all: &'b [PreparedDraw<'b>],
}

impl BinnedBatch<'_> {
    /// Draws the rows of tiles that faces reach, in slices between preemption points.
    fn draw_rows(&self, rows: &mut Vec<BatchRow>, target: &mut Target) {
        let BinnedBatch { context: DrawContext { level, executor }, drawn, slots, all } = *self;
        let reached = || drawn.iter().filter_map(|d| d.binned?.bands);
        let (first, last) = (reached().map(|b| b.0).min(), reached().map(|b| b.1).max());
        let (Some(first), Some(last), [any, ..]) = (first, last, all) else { return };
        let format = target.depth_format;
        rows.clear();
        rows.resize_with(last - first + 1, BatchRow::default);
        let rows = rows.as_slice();
        while !executor.is_cancelled() && rows.iter().any(|row| row.draw.load(Relaxed) < drawn.len()) {
            let slice = &Slice::new(any.preemption);
            let work = |band: usize, buffers: &mut tile::TileRowBuffers<'_>, ids: &mut _| {
                let BatchRow { draw, within } = &rows[band - first];
                for i in draw.load(Relaxed)..drawn.len() {
                    let Drawn { inputs, binned, counts, .. } = &drawn[i];
                    let reaches = |b: &&Binned| b.bands.is_some_and(|(from, to)| from <= band && band <= to);
                    if let Some(binned) = binned.as_ref().filter(reaches) {
                        all[i].with_job(inputs, &slots[i].tables, format, |job| {
                            let scratch = &slots[i].scratch;
                            let draw = tile::BinnedDraw { level, scratch, binned, job, counts, slice };
                            draw.draw_tile_row(band, within, buffers, ids);
                        });
                        if !within.is_complete() {
                            return;
                        }
                        within.restart();
                    }
                    draw.store(i + 1, Relaxed);
                }
            };
            let (top, bottom) = executor.run(|| {
                let frame = frame_of(target, any.parts);
                tile::for_each_tile_row(executor, (first, last), &drawn[0].inputs.view, frame, &work)
            });
            target.memory.mark_rows(top..bottom);
            any.preemption.point(target);
        }
    }
}

impl<'p> Drawn<'p> {
    /// Prepares a draw, and bins the first piece of its faces.
    fn new(
        prepared: &'p PreparedDraw,
        slot: &mut TileWorkspace,
        context: DrawContext<'_>,
        width: usize,
        format: DepthFormat,
    ) -> Self {
        let DrawContext { level, executor } = context;
        let TileWorkspace { scratch, tables, recycled } = slot;
        let mut inputs = prepared.inputs(recycled);
        prepared.make_tables(&mut inputs, context, tables);
        let mut binning = prepared
            .with_job(&inputs, tables, format, |job| Binning::new(level, executor, scratch, job, width));
        if prepared.preemption.is_possible() {
            binning.bound_chunks();
        }
        let (counts, stats) = (Counts::default(), DrawStats::default());
        let mut drawn = Drawn { inputs, binning, binned: None, counts, stats };
        drawn.bin(prepared, slot, context, format);
        drawn
    }

    /// Bins the next piece of the faces.
    fn bin(
        &mut self,
        prepared: &PreparedDraw,
        slot: &mut TileWorkspace,
        context: DrawContext<'_>,
        format: DepthFormat,
    ) {
        let (TileWorkspace { scratch, tables, .. }, Drawn { inputs, binning, stats, .. }) =
            (slot, &mut *self);
        self.binned = prepared.with_job(inputs, tables, format, |job| {
            binning.next(context.level, context.executor, scratch, job, stats)
        });
    }

    /// Returns whether the current piece is the last.
    fn is_whole(&self, prepared: &PreparedDraw) -> bool {
        self.binned.is_none_or(|b| b.until >= prepared.call.geometry.mesh.triangles.len())
    }
}

/// Returns whether a draw can be drawn together with `first`: it is small, planned for the tile
/// renderer, and has the same clip rectangle and memories.
fn can_join(prepared: &PreparedDraw, first: &PreparedDraw) -> bool {
    let mesh = &prepared.call.geometry.mesh;
    let memories = |p: &PreparedDraw| [Part::DepthMemory, Part::PickBuffer].map(|part| p.parts.uses(part));
    mesh.triangles.len() <= FEW_FACES
        && mesh.lines.is_empty()
        && mesh.points.is_empty()
        && prepared.transform().screen.clip == first.transform().screen.clip
        && memories(prepared) == memories(first)
        && prepared.parts.uses(Part::TileRenderer)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::VideoMemory;

    #[test]
    fn what_a_batch_holds_and_may_hold_is_counted_draw_by_draw() {
        let mut batch = DrawBatch::default();
        assert_eq!(batch.held_bytes(), 0);
        batch.slots.resize_with(3, TileWorkspace::default);
        assert_eq!(batch.held_bytes(), 3 * size_of::<TileWorkspace>() as u64);
        let mut list = Vec::new();
        batch.bytes.push(&mut list, 1u64);
        assert_eq!(batch.held_bytes(), (3 * size_of::<TileWorkspace>() + 8 * list.capacity()) as u64);

        let (mut memory, mut depth) = (VideoMemory::new(64, 64).unwrap(), None);
        let depth_format = DepthFormat::F32;
        let target = Target { memory: &mut memory, depth: &mut depth, depth_format, ids: None };
        let worst = |bindings: &[u64]| DrawBatch::worst_bytes(bindings.iter().copied(), 2, &target);
        assert_eq!(worst(&[1000, 500]), worst(&[0, 0]) + 1500);
        assert!(worst(&[0, 0, 0]) >= worst(&[0, 0]) + size_of::<TileWorkspace>() as u64);
        // More draws than a batch takes count no more.
        assert_eq!(worst(&[0; MOST_DRAWS + 9]), worst(&[0; MOST_DRAWS]));
    }
}
