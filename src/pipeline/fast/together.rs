//! Small draws that follow each other, drawn together: each has too little work for two threads, all of them have enough.
//!
//! First each draw by itself, on any thread: its parts, its tables, its faces in their tiles. Then band by band of tiles, on any
//! thread: the draws that reach a band, in their order. A pixel belongs to one band, so it sees the draws in their order, and each
//! draw does at it what it would do alone: the same bytes.

use super::parts::Parts;
use super::{FEW_FACES, Memories, frame_of, obstacle};
use crate::memory::DepthFormat;
use crate::pipeline::call::{CoarseDepth, DrawStats, Target};
use crate::pipeline::order::emptied;
use crate::pipeline::plan::Part;
use crate::pipeline::prepare::Prepared;
use crate::pipeline::tile::{self, Binned, Binning, Counts, ListBytes, Workers};
use crate::simd::Level;
use rayon::prelude::*;
use std::fmt;

/// Draws that are drawn together at most,
const MOST_DRAWS: usize = 256;

/// and the bytes that their tiles' empty lists may take.
const MOST_BYTES: usize = 8 << 20;

/// Bytes that their tiles' lists have room for before no further draw begins.
const LIST_BYTES: usize = 32 << 20;

/// What draws that are drawn together leave to the next ones.
#[derive(Default)]
pub(crate) struct Together {
    /// Of each draw, its working memories.
    slots: Vec<Memories>,
    /// What all their lists have room for.
    bytes: ListBytes,
    drawn: Vec<Option<Drawn<'static>>>,
    /// Twice as many draws as this are tried at once: few where one was beyond the tile renderer.
    half: usize,
    /// As many were tried last.
    most: usize,
}

/// A draw whose faces wait in their tiles, unless none reaches one.
struct Drawn<'p> {
    parts: Parts<'p>,
    /// Its faces, and the bands that they reach.
    binned: Option<(Binned, (usize, usize))>,
    counts: Counts,
    stats: DrawStats,
}

impl fmt::Debug for Together {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Together of {} bytes", self.size_bytes())
    }
}

impl Together {
    /// Bytes that are kept.
    pub fn size_bytes(&self) -> usize {
        let slots = self.slots.iter().map(|m| size_of::<Memories>() + m.size_bytes());
        slots.sum::<usize>() + self.drawn.capacity() * size_of::<Option<Drawn>>()
    }

    /// Bytes that are held: the tiles' lists, and of each draw its vertices and tables.
    pub fn held_bytes(&self) -> u64 {
        let slots: usize = self.slots.iter().map(|slot| size_of::<Memories>() + slot.table_bytes()).sum();
        (self.bytes.get() + slots + self.drawn.capacity() * size_of::<Option<Drawn>>()) as u64
    }

    /// Bytes that drawing draws together takes at worst, whose materials and lights take so many bytes each.
    pub fn worst_bytes(surfaces: impl Iterator<Item = u64>, threads: u64, target: &Target) -> u64 {
        let (width, height) = (target.memory.width() as usize, target.memory.height() as usize);
        // A vertex on the screen and its depth, and four tables.
        let draw = 3 * FEW_FACES as u64 * (tile::RECORD_BYTES + tile::DEEP_VERTEX_BYTES + 4 * 16)
            + (size_of::<Memories>() + size_of::<Option<Drawn>>()) as u64;
        let (count, surfaces) = surfaces
            .take(MOST_DRAWS)
            .fold((0, 0), |(count, sum): (u64, u64), bytes| (count + 1, sum + bytes));
        let faces = count * FEW_FACES as u64;
        count * draw + surfaces + tile::worst_list_bytes(faces, threads, (width, height), LIST_BYTES as u64)
    }

    /// How many of the first of these draws can be drawn together; 0 where the first one is not for this.
    pub fn count(&mut self, all: &[Prepared], target: &Target) -> usize {
        let grid = tile::grid_bytes((target.memory.width() as usize, target.memory.height() as usize));
        let most = (2 * self.half.max(1)).min(MOST_DRAWS).min(MOST_BYTES / grid.max(1));
        self.most = most;
        let count = all.iter().take(most).take_while(|p| is_for_this(p, &all[0], target)).count();
        if count < 2 {
            self.half = most;
            return 0;
        }
        count
    }

    /// Draws the opaque faces of the first of these draws, which [`Together::count`] has found, and says how many were drawn.
    pub fn draw(
        &mut self,
        (level, crew, coarse): (Level, &Workers, CoarseDepth),
        all: &[Prepared],
        target: &mut Target,
        stats: &mut DrawStats,
    ) -> usize {
        let (Some(pool), count) = (crew.pool(), all.len()) else { return 0 };
        let alone = &crew.alone();
        if self.bytes.get() > LIST_BYTES {
            self.slots.iter_mut().for_each(|slot| slot.scratch.give_lists_back());
        }
        let mut drawn: Vec<Option<Drawn>> = std::mem::take(&mut self.drawn);
        if self.slots.len() < count {
            let bytes = &self.bytes;
            self.slots.resize_with(count, || {
                let mut slot = Memories::default();
                slot.scratch.share_lists(bytes, LIST_BYTES);
                slot
            });
        }
        let slots = &mut self.slots[..count];
        let (width, format) = (target.memory.width() as usize, target.depth_format);
        let whole = pool.install(|| {
            let pairs = slots.par_iter_mut().zip(all).with_min_len(4);
            pairs
                .map(|(slot, p)| Drawn::new(p, slot, (level, alone, coarse), (width, format)))
                .collect_into_vec(&mut drawn);
            let whole = drawn.iter().take_while(|d| d.is_some()).count();
            let each = || drawn[..whole].iter().flatten().zip(&*slots).zip(all);
            let reached = || each().filter_map(|((d, _), _)| d.binned.as_ref()).map(|b| b.1);
            let (first, last) = (reached().map(|b| b.0).min(), reached().map(|b| b.1).max());
            let (Some(first), Some(last), Some(((any, _), _))) = (first, last, each().next()) else {
                return whole;
            };
            let frame = frame_of(target, all[0].plan.uses(Part::DepthMemory));
            let work = |band: usize, far, memories: &mut tile::BandMemories<'_>| {
                for ((d, slot), prepared) in each() {
                    let reaches = |b: &&(Binned, (usize, usize))| b.1.0 <= band && band <= b.1.1;
                    let Some((binned, _)) = d.binned.as_ref().filter(reaches) else { continue };
                    prepared.with_job(&d.parts, &slot.tables, format, |job| {
                        let waiting = (&slot.scratch, binned);
                        tile::draw_band(level, waiting, job, (width, far), band, memories, &d.counts);
                    });
                }
            };
            let rows = tile::bands(crew, (first, last), &any.parts.view, frame, &work);
            target.memory.mark_rows(rows.0..rows.1);
            whole
        });
        self.half = if whole < count { whole.max(1) } else { self.most };
        for (i, ((drawn, slot), prepared)) in drawn.drain(..).zip(slots).zip(all).enumerate() {
            let Some(Drawn { parts, counts, stats: mut own, .. }) = drawn else { continue };
            slot.spare.take_back(parts.surfaces);
            if i < whole {
                let (tested, passed) = counts.fragments();
                (own.pixels_tested, own.pixels_written) = (own.pixels_tested + tested, passed);
                own.faces_hidden = counts.hidden();
                *stats += prepared.counted(own);
            }
        }
        self.drawn = emptied(drawn);
        whole
    }
}

impl<'p> Drawn<'p> {
    /// Everything up to the faces in their tiles; `None` when the draw is beyond the tile renderer.
    fn new(
        prepared: &'p Prepared,
        slot: &mut Memories,
        (level, crew, coarse): (Level, &Workers, CoarseDepth),
        (width, format): (usize, DepthFormat),
    ) -> Option<Self> {
        let Memories { scratch, tables, spare } = slot;
        let mut parts = prepared.parts(spare)?;
        parts.coarse = coarse;
        prepared.make_tables(&mut parts, level, crew, tables);
        let mut stats = DrawStats::default();
        let binned = prepared.with_job(&parts, tables, format, |job| {
            Binning::new(level, crew, scratch, job, width).next(level, crew, scratch, job, &mut stats)
        });
        // One that would be drawn in pieces is drawn by itself.
        let faces = prepared.call.geometry.mesh.triangles.len();
        if binned.is_some_and(|b| b.until < faces) {
            return None;
        }
        let binned = binned.and_then(|b| Some((b, b.bands?)));
        Some(Drawn { parts, binned, counts: Counts::default(), stats })
    }
}

/// Whether a draw can be drawn together with `first`: by the tile renderer, over the same pixels and memories.
fn is_for_this(prepared: &Prepared, first: &Prepared, target: &Target) -> bool {
    let mesh = &prepared.call.geometry.mesh;
    let has_depth = |p: &Prepared| p.plan.uses(Part::DepthMemory);
    mesh.triangles.len() <= FEW_FACES
        && mesh.lines.is_empty()
        && mesh.points.is_empty()
        && prepared.transform().screen.clip == first.transform().screen.clip
        && has_depth(prepared) == has_depth(first)
        && obstacle(prepared.call, target, &prepared.plan).is_none()
}
