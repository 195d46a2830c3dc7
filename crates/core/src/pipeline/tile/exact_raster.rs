//! Rasterization of exact faces in a tile, by exact spans, and of stacks of faces that fill it.

use super::depth_test::{CloseWrite, DepthTest};
use super::edges::count_of;
use super::exact_faces::{self, ExactFace, RUN};
use super::grid::Grid;
use super::raster::sum;
use super::tile_buffers::{EXACT_FACE_BIT, Tile};
use crate::math::coverage::{Filling, PixelRect, SnappedTriangle};
use crate::simd::{I32, Mask, Part, Simd};
use std::ops::Range;

/// Row and columns of a span.
type Span = (i32, Range<i32>);

/// Number of spans listed before they are drawn: a closure would be compiled without the level's
/// instructions.
const SPANS: usize = Grid::TILE_ROWS as usize;

/// Largest number of faces that are drawn together over a whole tile.
pub(super) const MOST_STACKED: usize = 24;

/// Draws a face; returns the fragments tested and passed.
#[inline(always)]
pub(super) fn draw<S: Simd, D: DepthTest>(
    s: S,
    test: &D,
    face: &ExactFace,
    tile: &mut Tile<'_>,
) -> (u64, u64) {
    let (mut tested, mut passed) = (0, 0);
    let mut spans: [Span; SPANS] = [const { (0, 0..0) }; SPANS];
    let b = face.bounds;
    let clip = PixelRect {
        x0: b.x0.max(tile.x0),
        y0: b.y0.max(tile.y0),
        x1: b.x1.min(tile.x1),
        y1: b.y1.min(tile.y1),
    };
    let is_apart = tile.is_apart(face.z_range);
    for outline in face.outlines.iter().flatten() {
        let count = spans_of(outline, clip, &mut spans);
        for (y, span) in &spans[..count] {
            tested += span.len() as u64;
            passed += draw_span(s, test, face, *y, (span.clone(), is_apart), tile);
        }
    }
    (tested, passed)
}

/// Lists the spans of an outline within `clip`; returns their number.
fn spans_of(outline: &SnappedTriangle, clip: PixelRect, spans: &mut [Span; SPANS]) -> usize {
    let mut count = 0;
    match outline.filling(clip) {
        Filling::None => {}
        Filling::All => {
            while (count as i32) < clip.y1 - clip.y0 {
                spans[count] = (clip.y0 + count as i32, clip.x0..clip.x1);
                count += 1;
            }
        }
        Filling::Part => outline.for_each_span(clip, |y, span| {
            spans[count] = (y, span);
            count += 1;
        }),
    }
    count
}

/// Draws one span in vectors aligned to their width, the first and the last in part. Returns the
/// fragments passed.
#[inline(always)]
fn draw_span<S: Simd, D: DepthTest>(
    s: S,
    test: &D,
    face: &ExactFace,
    y: i32,
    (span, is_apart): (Range<i32>, bool),
    tile: &mut Tile<'_>,
) -> u64 {
    let lanes = S::LANES as i32;
    // The last vector of a row that is no multiple of its width starts further left.
    let last_whole = tile.x1 & !(lanes - 1);
    let mut passed = 0;
    let mut x = span.start;
    while x < span.end {
        let start = x & !(lanes - 1);
        let is_whole = start == x && face.is_between && !(D::HAS_ERRORS && face.is_rough);
        let until = span.end.min(last_whole) & !(lanes - 1);
        if is_whole && until > start {
            passed += draw_whole(s, test, face, (start, y), ((until - start) as usize, is_apart), tile);
            x = until;
            continue;
        }
        let start = start.min(tile.x1 - lanes);
        let (from, to) = (x - start, (span.end - start).min(lanes));
        let covered = s.mask((u32::MAX << from) & (((1u64 << to) - 1) as u32));
        let (mut word, mut inside) = match face.is_between {
            true => (test.exact_words(s, face, start, y), covered),
            false => test.clipped_words(s, face, start, y),
        };
        let id = face.face as i32 | EXACT_FACE_BIT;
        if D::HAS_ERRORS && face.is_rough {
            let beside = covered & exact_faces::beside(s, face, start, y);
            if beside.any() {
                let mut words = [0; 16];
                s.store_i(word, &mut words[..S::LANES]);
                let drawn = test.words_beside(id, [start, y], beside.bits(), &mut words);
                word = s.load_i(&words[..S::LANES]);
                inside = (inside & !beside) | s.mask(drawn);
            }
        }
        let id = (s.splat_i(id), id);
        passed += count_of::<S>(test.write(s, tile, (start, y), covered & inside, word, id));
        x = start + lanes;
    }
    passed
}

/// Draws `count` columns from (x, y) on, all covered, in whole vectors; `is_apart` of a face that is
/// close to no other. Returns the fragments passed.
#[inline(always)]
fn draw_whole<S: Simd, D: DepthTest>(
    s: S,
    test: &D,
    face: &ExactFace,
    (x, y): (i32, i32),
    (count, is_apart): (usize, bool),
    tile: &mut Tile<'_>,
) -> u64 {
    let number = face.face as i32 | EXACT_FACE_BIT;
    let id = s.splat_i(number);
    let (at, depth_at) = (tile.id_at(x, y), tile.depth_at(x, y));
    let ids = &mut tile.ids[at..at + count];
    if tile.depth.is_empty() {
        for ids in ids.chunks_exact_mut(S::LANES) {
            s.store_i(id, ids);
        }
        return count as u64;
    }
    let (mut passed, all) = (s.splat_i(0), s.mask(u32::MAX));
    let depth = &mut tile.depth[depth_at..depth_at + count];
    let is_level = test.slope(face) == 0.0;
    let is_apart = !D::HAS_ERRORS || is_apart;
    let constant = if is_level { test.exact_words(s, face, x, y) } else { s.splat_i(0) };
    let mut column = x;
    for (depth, ids) in depth.chunks_exact_mut(S::LANES).zip(ids.chunks_exact_mut(S::LANES)) {
        let word = if is_level { constant } else { test.exact_words(s, face, column, y) };
        let old = s.load_i(depth);
        let passes = if !is_apart && test.is_close(s, all, word, old) {
            let at = [column, y];
            s.call(s, CloseWrite { test, at, covered: all, word, id: number, depth, ids })
        } else {
            let passes = test.is_nearer(s, word, old);
            s.store_i(s.select_i(passes, word, old), depth);
            s.store_i(s.select_i(passes, id, s.load_i(ids)), ids);
            passes
        };
        passed = s.increment(passes, passed);
        column += S::LANES as i32;
    }
    sum(s, passed)
}

/// Returns how much of the tile the face covers, as far as [`stack`] can draw it: `All` requires
/// depths between near and far, too, runs that carry them, and whole vectors.
#[inline(always)]
pub(super) fn filling<D: DepthTest>(test: &D, face: &ExactFace, tile: &Tile<'_>) -> Filling {
    let [Some(outline), None] = &face.outlines else { return Filling::Part };
    let b = face.bounds;
    let holds = b.x0 <= tile.x0 && b.x1 >= tile.x1 && b.y0 <= tile.y0 && b.y1 >= tile.y1;
    let is_even = (tile.x0 | tile.x1) & (RUN - 1) == 0;
    let fits = holds && is_even && face.is_between && !tile.depth.is_empty();
    match outline.filling(tile.rect()) {
        Filling::All if !fits || test.slope(face).abs() > D::STEEPEST => Filling::Part,
        Filling::All if D::HAS_ERRORS && face.is_rough && !exact_faces::holds(face, tile.rect()) => {
            Filling::Part
        }
        filling => filling,
    }
}

/// Draws faces that fill the tile, in order, and returns how many fragments passed. A pixel's depth
/// and face stay in registers until all faces are tested.
#[inline(always)]
pub(super) fn stack<S: Simd, D: DepthTest>(s: S, test: &D, faces: &[&ExactFace], tile: &mut Tile<'_>) -> u64 {
    let Some(first) = faces.first() else { return 0 };
    let count = faces.len().min(MOST_STACKED);
    let faces = &faces[..count];
    if D::HAS_ERRORS && !are_apart(test.tolerance(), faces, tile) {
        return s.call(s, OneByOne { test, faces, tile });
    }
    let (mut ids, mut runs) = ([0; MOST_STACKED], [test.run(first); MOST_STACKED]);
    let mut is_level = true;
    for (i, face) in faces.iter().enumerate() {
        (ids[i], runs[i]) = (face.face as i32 | EXACT_FACE_BIT, test.run(face));
        is_level &= test.slope(face) == 0.0;
    }
    let flip = s.splat_i(test.flip());
    let (x0, width) = (tile.x0, (tile.x1 - tile.x0) as usize);
    let mut passed = 0;
    for y in tile.y0..tile.y1 {
        if is_level {
            for (run, face) in runs.iter_mut().zip(faces) {
                test.begin_run(run, face, x0, y);
            }
            let steps = Steps::of(s, test, &runs[..count], &ids, x0);
            passed += steps.draw_row(s, flip, y, tile);
            continue;
        }
        let (at, depth_at) = (tile.id_at(x0, y), tile.depth_at(x0, y));
        let row_ids = &mut tile.ids[at..at + width];
        let row_depth = &mut tile.depth[depth_at..depth_at + width];
        let mut counts = s.splat_i(0);
        let mut column = 0;
        while column < width {
            let (x, in_run) = (x0 + column as i32, column as i32 & (RUN - 1));
            let along = (s.iota() + s.splat_i(in_run)).to_f32();
            if in_run == 0 {
                for (run, face) in runs.iter_mut().zip(faces) {
                    test.begin_run(run, face, x, y);
                }
            }
            let old = &mut row_depth[column..column + S::LANES];
            let own = &mut row_ids[column..column + S::LANES];
            let (mut nearest, mut id) = (s.load_i(old) ^ flip, s.load_i(own));
            let mut i = 0;
            while i < count {
                let word = test.run_words(s, &runs[i], x, along) ^ flip;
                let passes = nearest.gt(word);
                (nearest, id) = (nearest.min(word), s.select_i(passes, s.splat_i(ids[i]), id));
                counts = s.increment(passes, counts);
                i += 1;
            }
            s.store_i(nearest ^ flip, old);
            s.store_i(id, own);
            column += S::LANES;
        }
        passed += sum(s, counts);
    }
    passed
}

/// Faces that fill the tile, drawn one after the other because some are close.
struct OneByOne<'k, 'b, D> {
    test: &'k D,
    faces: &'k [&'k ExactFace],
    tile: &'k mut Tile<'b>,
}

impl<S: Simd, D: DepthTest> Part<S> for OneByOne<'_, '_, D> {
    type Output = u64;

    #[inline(always)]
    fn run(self, s: S) -> u64 {
        let OneByOne { test, faces, tile } = self;
        let mut passed = 0;
        for face in faces {
            passed += draw(s, test, face, tile).1;
        }
        passed
    }
}

/// Returns whether faces that fill the tile are farther than `tolerance` from each other and from the
/// draw's earlier faces at all pixels, and adds them to the depths of the tile.
#[inline(never)]
fn are_apart(tolerance: f32, faces: &[&ExactFace], tile: &mut Tile<'_>) -> bool {
    // Planes are apart in the tile if they are so at its corners, on the same side. Twice the
    // tolerance: here the planes themselves are compared, from which both renderers may differ.
    let margin = 2.0 * f64::from(tolerance);
    let (mut corners, mut ranges) = ([[0.0; 4]; MOST_STACKED], [[0.0; 2]; MOST_STACKED]);
    let [low, high] = tile.depths.unwrap_or_else(|| tile.range_of_depths());
    let mut range = [low, high];
    let (right, bottom) = (tile.x1 - 1, tile.y1 - 1);
    let mut are_apart = true;
    for (i, face) in faces.iter().enumerate() {
        let at = [(tile.x0, tile.y0), (right, tile.y0), (tile.x0, bottom), (right, bottom)];
        corners[i] = at.map(|(x, y)| face.plane.z_at(x, y));
        let [near, far] =
            corners[i].iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], z| [a.min(*z), b.max(*z)]);
        are_apart &= near - margin > f64::from(high) || far + margin < f64::from(low);
        ranges[i] = [near, far];
        range = [range[0].min((near - margin) as f32), range[1].max((far + margin) as f32)];
        for (other, [low, high]) in corners[..i].iter().zip(ranges) {
            if near - margin > high || far + margin < low {
                continue;
            }
            let [mut is_before, mut is_behind] = [true; 2];
            for (z, other) in corners[i].iter().zip(other) {
                is_before &= z + margin < *other;
                is_behind &= z - margin > *other;
            }
            are_apart &= is_before | is_behind;
        }
    }
    tile.depths = Some(range);
    are_apart
}

/// Faces of a stack whose words are equal along a row, and that are nearer there than all faces
/// before them: no other can pass.
struct Steps {
    /// Words from the farthest to the nearest, as signed numbers.
    words: [i32; MOST_STACKED],
    count: usize,
    /// Face id of the nearest.
    id: i32,
}

impl Steps {
    /// Finds the steps in the row in which `runs` were begun.
    #[inline(always)]
    fn of<S: Simd, D: DepthTest>(s: S, test: &D, runs: &[D::Run], ids: &[i32; MOST_STACKED], x: i32) -> Self {
        let mut steps = Steps { words: [0; MOST_STACKED], count: 0, id: 0 };
        let along = s.iota().to_f32();
        let mut lanes = [0; 16];
        for (run, id) in runs.iter().zip(ids) {
            s.store_i(test.run_words(s, run, x, along), &mut lanes[..S::LANES]);
            let word = lanes[0] ^ test.flip();
            if steps.count == 0 || word < steps.words[steps.count - 1] {
                steps.words[steps.count] = word;
                (steps.count, steps.id) = (steps.count + 1, *id);
            }
        }
        steps
    }

    /// Draws the row and returns how many fragments passed: those of every step that is nearer than
    /// the stored depth, of which the last one stays.
    #[inline(always)]
    fn draw_row<S: Simd>(&self, s: S, flip: S::I, y: i32, tile: &mut Tile<'_>) -> u64 {
        let words = &self.words[..self.count];
        let (Some(&farthest), Some(&nearest)) = (words.first(), words.last()) else { return 0 };
        let (farthest, nearest, id) = (s.splat_i(farthest), s.splat_i(nearest), s.splat_i(self.id));
        let (at, depth_at) = (tile.id_at(tile.x0, y), tile.depth_at(tile.x0, y));
        let width = (tile.x1 - tile.x0) as usize;
        let row_depth = tile.depth[depth_at..depth_at + width].chunks_exact_mut(S::LANES);
        let row_ids = tile.ids[at..at + width].chunks_exact_mut(S::LANES);
        let (mut whole, mut counts) = (0, s.splat_i(0));
        for (depth, ids) in row_depth.zip(row_ids) {
            let old = s.load_i(depth) ^ flip;
            if (!old.gt(farthest)).any() {
                for &word in words {
                    counts = s.increment(old.gt(s.splat_i(word)), counts);
                }
            } else {
                whole += S::LANES * self.count;
            }
            s.store_i(old.min(nearest) ^ flip, depth);
            s.store_i(s.select_i(old.gt(nearest), id, s.load_i(ids)), ids);
        }
        whole as u64 + sum(s, counts)
    }
}
