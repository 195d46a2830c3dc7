//! Traverses the faces of one tile: in file order, fragments and tiny ones up to the next larger one, and those
//! that fill the tile together.
//!
//! In: a chunk's list of a tile. Out: how many fragments were tested and passed, and faces left out. What a face does to the
//! tile is its raster's: plain ([`super::raster`]), behind coarse depth ([`super::hierarchical_z`]), in f64 ([`super::depth_f64`]). Each has
//! its own copy of the traversal, so what a raster does not ask for costs nothing.

use super::bins::{Bin, BinEntry, Larger, Small, Tiny};
use super::exact_faces::{ExactFace, MOST_STACKED};
use crate::math::coverage::Filling;
use crate::simd::Simd;

/// The rasterizer's part in a traversal. Counts are of fragments.
pub(super) trait FaceRaster {
    /// Draws a pixel of a face: place, depth word, number. Whether it passed.
    fn fragment(&mut self, fragment: [i32; 3]) -> bool;
    /// Draws a face whose coverage is known; how many passed.
    fn tiny<S: Simd>(&mut self, s: S, face: &Tiny) -> u64;
    /// Draws a face with edge functions in i32; tested and passed.
    fn small<S: Simd>(&mut self, s: S, face: &Small) -> (u64, u64);
    /// Draws a face that the plain path has set up; tested and passed.
    fn exact_face<S: Simd>(&mut self, s: S, face: &ExactFace) -> (u64, u64);
    /// How much of the tile is the face's, as far as [`FaceRaster::stack`] can draw it.
    fn filling(&self, face: &ExactFace) -> Filling;
    /// Draws faces that fill the tile, in their order; how many passed.
    fn stack<S: Simd>(&mut self, s: S, faces: &[&ExactFace]) -> u64;
    /// Pixels of the tile.
    fn pixels(&self) -> u64;

    /// Whether nothing of a face would pass, so that it need not be drawn.
    #[inline(always)]
    fn hides_tiny(&self, _: &Tiny) -> bool {
        false
    }
    /// See [`FaceRaster::hides_tiny`].
    #[inline(always)]
    fn hides_small(&self, _: &Small) -> bool {
        false
    }
    /// See [`FaceRaster::hides_tiny`].
    #[inline(always)]
    fn hides_exact(&self, _: &ExactFace) -> bool {
        false
    }
    /// A face that fills the tile will be drawn before anything else is asked.
    #[inline(always)]
    fn will_fill(&mut self, _: &ExactFace) {}
    /// So many fragments have passed by now.
    #[inline(always)]
    fn has_passed<S: Simd>(&mut self, _: S, _: u64) {}
}

/// Counts of a traversal.
#[derive(Clone, Copy, Debug, Default)]
pub struct RasterStats {
    /// Fragments tested; those of tiny faces were counted when they were set up.
    pub tested: u64,
    /// Fragments that passed.
    pub passed: u64,
    /// Faces that were left out.
    pub hidden: u64,
}

/// Draws the faces of a list in their order; `exact_faces` holds the chunk's.
#[inline(always)]
pub(super) fn traverse<S: Simd, R: FaceRaster>(
    s: S,
    bin: &Bin,
    exact_faces: &[ExactFace],
    raster: &mut R,
) -> RasterStats {
    let mut done = RasterStats::default();
    let (mut from, mut drawn, mut placed) = (0, 0, 0);
    while from <= bin.larger.len() {
        // The fragments and tiny faces up to the next larger one, or the last ones.
        let next = bin.larger.get(from);
        let fragments = next.map_or(bin.fragments.len(), |l| l.fragments_before as usize);
        if placed < fragments {
            for fragment in bin.fragments.some(placed..fragments) {
                done.passed += u64::from(raster.fragment(fragment));
            }
            placed = fragments;
        }
        let until = next.map_or(bin.tiny.len(), |l| l.tiny_before as usize);
        for words in &bin.tiny[drawn..until] {
            let face = &Tiny::of(*words);
            match raster.hides_tiny(face) {
                true => done.hidden += 1,
                false => done.passed += raster.tiny(s, face),
            }
        }
        (from, drawn) = (from + 1, until);
        raster.has_passed(s, done.passed);
        let index = match next.map(|l| l.entry) {
            None => break,
            Some(BinEntry::OrderBreak) => continue,
            Some(BinEntry::Small(index)) => {
                let face = &bin.small[index as usize];
                if raster.hides_small(face) {
                    done.hidden += 1;
                    continue;
                }
                let (t, p) = raster.small(s, face);
                (done.tested, done.passed) = (done.tested + t, done.passed + p);
                continue;
            }
            Some(BinEntry::Exact(index)) => index as usize,
        };
        let face = &exact_faces[index];
        if raster.hides_exact(face) {
            done.hidden += 1;
            continue;
        }
        if raster.filling(face) != Filling::All {
            let (t, p) = raster.exact_face(s, face);
            (done.tested, done.passed) = (done.tested + t, done.passed + p);
            continue;
        }
        // With those behind it that fill the tile as well.
        let mut stack = [face; MOST_STACKED];
        let mut count = 1;
        raster.will_fill(face);
        while count < stack.len() {
            let Some(&Larger { fragments_before, tiny_before, entry: BinEntry::Exact(index) }) =
                bin.larger.get(from)
            else {
                break;
            };
            if fragments_before as usize != placed || tiny_before as usize != drawn {
                break;
            }
            let face = &exact_faces[index as usize];
            if raster.hides_exact(face) {
                done.hidden += 1;
                from += 1;
                continue;
            }
            match raster.filling(face) {
                Filling::Part => break,
                Filling::None => {}
                Filling::All => {
                    raster.will_fill(face);
                    stack[count] = face;
                    count += 1;
                }
            }
            from += 1;
        }
        done.tested += count as u64 * raster.pixels();
        done.passed += raster.stack(s, &stack[..count]);
    }
    done
}
