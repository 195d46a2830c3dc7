//! Depth tests, over which the rasterizer is generic: the depths of faces as words of a format, and
//! the order of words.
//!
//! In: faces as [`super::setup`] made them. Out: a word for each pixel, computed independently of
//! threads, tiles and lanes. Words are compared as signed numbers once [`DepthTest::flip`] has
//! inverted some of their bits; a fragment passes if its word is less than the stored one.
//!
//! [`F32Depth`] is the test of f32 depths. The other formats need more digits than f32 has:
//! [`super::depth_f64`].

use super::close_depths::{CloseDepths, Contest};
use super::exact_faces::{self, ExactFace, STEEP};
use super::tile_buffers::Tile;
use crate::simd::{F32, I32, Mask, Part, Simd};

/// Depth test of a format.
pub(super) trait DepthTest: Sized {
    /// Depth of a face with screen vertices, over the screen.
    type Plane: Copy;
    /// Depth of an exact face along a run of columns.
    type Run: Copy;

    /// True if a vector of words takes longer than a load that waits for two stores.
    const IS_COSTLY: bool;
    /// Largest slope per column with which depth has all its digits along a run.
    const STEEPEST: f64;

    /// Returns the bits to invert so that words become signed numbers, of which the lesser is
    /// nearer.
    fn flip(&self) -> i32;

    /// True if words have errors, so that close ones are compared by [`DepthTest::decide`].
    const HAS_ERRORS: bool = false;

    /// Returns the distance of two depths up to which their words do not tell which is nearer.
    #[inline(always)]
    fn tolerance(&self) -> f32 {
        -1.0
    }

    /// Sets the words of an exact face at the pixels beside it, the lanes from (x, y) on; returns those
    /// lanes in which it is drawn.
    #[inline(always)]
    fn words_beside(&self, _: i32, _: [i32; 2], lanes: u32, _: &mut [i32; 16]) -> u32 {
        lanes
    }

    /// Returns the lanes that a face wins, where some are close.
    #[inline(always)]
    fn decide(&self, contest: &Contest<'_>) -> u32 {
        contest.passes
    }

    /// Returns whether a face's words at `covered` are so close to those that are stored that
    /// [`CloseWrite`] has to decide.
    #[inline(always)]
    fn is_close<S: Simd>(&self, s: S, covered: S::M, word: S::I, old: S::I) -> bool {
        Self::HAS_ERRORS && (covered & self.close(s, word, old)).any()
    }

    /// Returns the lanes where the words do not tell which is nearer.
    #[inline(always)]
    fn close<S: Simd>(&self, s: S, word: S::I, old: S::I) -> S::M {
        (old.as_f32() - word.as_f32()).abs().le(s.splat(self.tolerance()))
    }

    /// Returns the lanes where `word` is nearer than `old`.
    #[inline(always)]
    fn is_nearer<S: Simd>(&self, s: S, word: S::I, old: S::I) -> S::M {
        let flip = s.splat_i(self.flip());
        (old ^ flip).gt(word ^ flip)
    }

    /// Returns whether a face's words at LANES pixels from (x, y) on, where `covered`, are close to those
    /// that are stored.
    #[inline(always)]
    fn is_close_at<S: Simd>(
        &self,
        s: S,
        tile: &Tile<'_>,
        (x, y): (i32, i32),
        covered: S::M,
        word: S::I,
    ) -> bool {
        if !Self::HAS_ERRORS || tile.depth.is_empty() {
            return false;
        }
        let at = tile.depth_at(x, y);
        self.is_close(s, covered, word, s.load_i(&tile.depth[at..at + S::LANES]))
    }

    /// Tests depth at LANES pixels from (x, y) on, where `covered`, by words that are not close; writes
    /// word and face id where it passes. Returns the lanes that passed.
    #[inline(always)]
    fn write_apart<S: Simd>(
        &self,
        s: S,
        tile: &mut Tile<'_>,
        (x, y): (i32, i32),
        covered: S::M,
        word: S::I,
        id: S::I,
    ) -> S::M {
        let mut passes = covered;
        if !tile.depth.is_empty() {
            let at = tile.depth_at(x, y);
            let depth = &mut tile.depth[at..at + S::LANES];
            let old = s.load_i(depth);
            passes = covered & self.is_nearer(s, word, old);
            s.store_i(s.select_i(passes, word, old), depth);
        }
        let at = tile.id_at(x, y);
        let ids = &mut tile.ids[at..at + S::LANES];
        s.store_i(s.select_i(passes, id, s.load_i(ids)), ids);
        passes
    }

    /// Does the same where words may be close.
    #[inline(always)]
    fn write<S: Simd>(
        &self,
        s: S,
        tile: &mut Tile<'_>,
        (x, y): (i32, i32),
        covered: S::M,
        word: S::I,
        (id, face): (S::I, i32),
    ) -> S::M {
        if !self.is_close_at(s, tile, (x, y), covered, word) {
            return self.write_apart(s, tile, (x, y), covered, word, id);
        }
        let (at, id_at) = (tile.depth_at(x, y), tile.id_at(x, y));
        let (depth, ids) = (&mut tile.depth[at..at + S::LANES], &mut tile.ids[id_at..id_at + S::LANES]);
        s.call(s, CloseWrite { test: self, at: [x, y], covered, word, id: face, depth, ids })
    }

    /// Returns whether a face wins a pixel with depths that are close.
    #[cold]
    #[inline(never)]
    fn decide_one(&self, at: [i32; 2], (word, id): (i32, i32), old: (i32, i32), passes: bool) -> bool {
        let mut words = [0; 16];
        words[0] = word;
        let (ids, old) = (&[old.1], &[old.0]);
        self.decide(&Contest { at, id, words, ids, old, passes: u32::from(passes), close: 1 }) != 0
    }

    /// Tests depth at one pixel; writes word and face id if it passes, and returns whether it did.
    #[inline(always)]
    fn write_one(&self, tile: &mut Tile<'_>, (x, y): (i32, i32), word: i32, id: i32) -> bool {
        let id_at = tile.id_at(x, y);
        if !tile.depth.is_empty() {
            let at = tile.depth_at(x, y);
            let depth = &mut tile.depth[at];
            let old = *depth;
            let mut passes = old ^ self.flip() > word ^ self.flip();
            if Self::HAS_ERRORS {
                let apart = f32::from_bits(old as u32) - f32::from_bits(word as u32);
                if apart.abs() <= self.tolerance() {
                    passes = self.decide_one([x, y], (word, id), (old, tile.ids[id_at]), passes);
                }
            }
            if !passes {
                return false;
            }
            *depth = word;
        }
        tile.ids[id_at] = id;
        true
    }

    /// Returns the word of a fragment: position, word in f32, face.
    fn fragment(&self, fragment: [i32; 3]) -> i32;
    /// Returns the depth of a face, given its f32 depth at the centre of pixel `at`, and the steps
    /// of that per column and per row.
    fn plane(&self, face: u32, at: [i32; 2], depth: [f32; 3]) -> Self::Plane;
    /// Returns the word at pixel (x, y).
    fn word(&self, plane: &Self::Plane, x: i32, y: i32) -> i32;
    /// Returns the words at LANES pixels from (x, y) on.
    fn words<S: Simd>(&self, s: S, plane: &Self::Plane, x: i32, y: i32) -> S::I;

    /// Returns the words of an exact face at LANES pixels from (x, y) on.
    fn exact_words<S: Simd>(&self, s: S, face: &ExactFace, x: i32, y: i32) -> S::I;
    /// Returns these words, and the lanes that lie between near (included) and far (excluded).
    fn clipped_words<S: Simd>(&self, s: S, face: &ExactFace, x: i32, y: i32) -> (S::I, S::M);
    /// Returns the slope of an exact face's depth per column.
    fn slope(&self, face: &ExactFace) -> f64;
    /// Returns the depth along a run that is to be begun.
    fn run(&self, face: &ExactFace) -> Self::Run;
    /// Begins a run of columns at (x, y).
    fn begin_run(&self, run: &mut Self::Run, face: &ExactFace, x: i32, y: i32);
    /// Returns the words at LANES columns from x on, which are `along` columns from the run's
    /// first.
    fn run_words<S: Simd>(&self, s: S, run: &Self::Run, x: i32, along: S::F) -> S::I;
}

/// Writes a face where some of its words are close to those that are stored: a function of its own, so
/// that the usual case keeps its registers, and its masks stay masks.
pub(super) struct CloseWrite<'k, S: Simd, D> {
    pub test: &'k D,
    /// First pixel, and the covered ones from there on.
    pub at: [i32; 2],
    pub covered: S::M,
    pub word: S::I,
    /// Face id, with the bit of exact faces.
    pub id: i32,
    /// Words and face ids of the pixels.
    pub depth: &'k mut [i32],
    pub ids: &'k mut [i32],
}

impl<S: Simd, D: DepthTest> Part<S> for CloseWrite<'_, S, D> {
    type Output = S::M;

    #[inline(always)]
    fn run(self, s: S) -> S::M {
        let CloseWrite { test, at, covered, word, id, depth, ids } = self;
        let old = s.load_i(depth);
        let passes = (covered & test.is_nearer(s, word, old)).bits();
        let close = (covered & test.close(s, word, old)).bits();
        let mut words = [0; 16];
        s.store_i(word, &mut words[..S::LANES]);
        let passes = s.mask(test.decide(&Contest { at, id, words, ids, old: depth, passes, close }));
        s.store_i(s.select_i(passes, word, old), depth);
        s.store_i(s.select_i(passes, s.splat_i(id), s.load_i(ids)), ids);
        passes
    }
}

/// Depths in f32, whose bits are ordered like the numbers.
#[derive(Clone, Copy)]
pub(super) struct F32Depth<'a> {
    /// Decides between close faces; `None` where their words do.
    pub close: Option<&'a CloseDepths<'a>>,
    /// Largest distance of close depths: twice the largest error of the faces that are drawn.
    pub tolerance: f32,
}

/// Pixel, f32 depth at its centre, and the depth's steps per column and per row.
#[derive(Clone, Copy, Debug)]
pub(super) struct F32Plane {
    at: [i32; 2],
    depth: [f32; 3],
}

/// Depth at a run's first column, its step per column, and the range that it is clamped to.
#[derive(Clone, Copy, Debug)]
pub(super) struct F32Run {
    base: f32,
    slope: f32,
    low: f32,
    high: f32,
}

impl DepthTest for F32Depth<'_> {
    type Plane = F32Plane;
    type Run = F32Run;

    const IS_COSTLY: bool = false;
    const STEEPEST: f64 = STEEP;
    const HAS_ERRORS: bool = true;

    #[inline(always)]
    fn tolerance(&self) -> f32 {
        self.tolerance
    }

    #[inline(always)]
    fn words_beside(&self, id: i32, at: [i32; 2], lanes: u32, words: &mut [i32; 16]) -> u32 {
        self.close.map_or(lanes, |close| close.words_beside(id, at, lanes, words))
    }

    #[inline(always)]
    fn decide(&self, contest: &Contest<'_>) -> u32 {
        self.close.map_or(contest.passes, |close| close.decide(contest))
    }

    #[inline(always)]
    fn flip(&self) -> i32 {
        0
    }

    #[inline(always)]
    fn fragment(&self, [_, word, _]: [i32; 3]) -> i32 {
        word
    }

    #[inline(always)]
    fn plane(&self, _: u32, at: [i32; 2], depth: [f32; 3]) -> F32Plane {
        F32Plane { at, depth }
    }

    #[inline(always)]
    fn word(&self, plane: &F32Plane, x: i32, y: i32) -> i32 {
        let [z0, zx, zy] = plane.depth;
        let z = (z0 + zy * (y - plane.at[1]) as f32) + zx * (x - plane.at[0]) as f32;
        (z.to_bits() as i32).max(0)
    }

    #[inline(always)]
    fn words<S: Simd>(&self, s: S, plane: &F32Plane, x: i32, y: i32) -> S::I {
        let [z0, zx, zy] = plane.depth;
        let along = s.splat(zx) * (s.iota() + s.splat_i(x - plane.at[0])).to_f32();
        (s.splat(z0 + zy * (y - plane.at[1]) as f32) + along).bits().max(s.splat_i(0))
    }

    #[inline(always)]
    fn exact_words<S: Simd>(&self, s: S, face: &ExactFace, x: i32, y: i32) -> S::I {
        exact_faces::depths(s, face, x, y).max(s.splat(0.0)).bits()
    }

    #[inline(always)]
    fn clipped_words<S: Simd>(&self, s: S, face: &ExactFace, x: i32, y: i32) -> (S::I, S::M) {
        let z = exact_faces::depths(s, face, x, y);
        (z.max(s.splat(0.0)).bits(), exact_faces::between_near_and_far(s, face, z, x, y))
    }

    #[inline(always)]
    fn slope(&self, face: &ExactFace) -> f64 {
        face.plane.z[1]
    }

    #[inline(always)]
    fn run(&self, face: &ExactFace) -> F32Run {
        // Bounds as `exact_words` applies them; + 0.0 makes a zero positive, as its bits have to be.
        F32Run {
            base: 0.0,
            slope: face.plane.z[1] as f32,
            low: face.z_range[0].max(0.0) + 0.0,
            high: face.z_range[1].max(0.0) + 0.0,
        }
    }

    #[inline(always)]
    fn begin_run(&self, run: &mut F32Run, face: &ExactFace, x: i32, y: i32) {
        run.base = face.plane.z_at(x, y) as f32;
    }

    #[inline(always)]
    fn run_words<S: Simd>(&self, s: S, run: &F32Run, _: i32, along: S::F) -> S::I {
        let z = s.splat(run.base) + s.splat(run.slope) * along;
        z.max(s.splat(run.low)).min(s.splat(run.high)).bits()
    }
}
