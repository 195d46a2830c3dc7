//! Traversal of a tile's faces in file order: fragments and tiny faces up to the next larger one,
//! and runs of faces that fill the tile.
//!
//! In: a chunk's bin of a tile. Out: fragments tested and passed, and faces skipped. The raster
//! that draws the faces is a type parameter: plain ([`super::raster`]), with hierarchical z
//! ([`super::hierarchical_z`]), in f64 ([`super::depth_f64`]). Each instantiates its own copy of
//! the traversal, so a method that a raster leaves at its default costs nothing.

use super::bins::{Bin, BinEntry, Larger, Small, Tiny};
use super::exact_faces::{ExactFace, MOST_STACKED};
use crate::math::coverage::Filling;
use crate::simd::Simd;

/// Drawing operations of a traversal. Counts are of fragments.
pub(super) trait FaceRaster {
    /// Draws one fragment: position, depth word, face. Returns whether it passed.
    fn fragment(&mut self, fragment: [i32; 3]) -> bool;
    /// Draws a face whose coverage is known; returns how many passed.
    fn tiny<S: Simd>(&mut self, s: S, face: &Tiny) -> u64;
    /// Draws a face with edge functions in i32; returns the fragments tested and passed.
    fn small<S: Simd>(&mut self, s: S, face: &Small) -> (u64, u64);
    /// Draws a face that the plain path has set up; returns the fragments tested and passed.
    fn exact_face<S: Simd>(&mut self, s: S, face: &ExactFace) -> (u64, u64);
    /// Returns how much of the tile the face covers, as far as [`FaceRaster::stack`] can draw it.
    fn filling(&self, face: &ExactFace) -> Filling;
    /// Draws faces that fill the tile, in order; returns how many passed.
    fn stack<S: Simd>(&mut self, s: S, faces: &[&ExactFace]) -> u64;
    /// Returns the number of pixels of the tile.
    fn pixels(&self) -> u64;

    /// Returns whether no fragment of the face would pass, so that it need not be drawn.
    #[inline(always)]
    fn hides_tiny(&self, _: &Tiny) -> bool {
        false
    }
    /// Returns whether no fragment of the face would pass.
    #[inline(always)]
    fn hides_small(&self, _: &Small) -> bool {
        false
    }
    /// Returns whether no fragment of the face would pass.
    #[inline(always)]
    fn hides_exact(&self, _: &ExactFace) -> bool {
        false
    }
    /// Called for a face that fills the tile; it is drawn before the faces of later queries.
    #[inline(always)]
    fn will_fill(&mut self, _: &ExactFace) {}
    /// Called with the number of fragments that have passed so far.
    #[inline(always)]
    fn has_passed<S: Simd>(&mut self, _: S, _: u64) {}
}

/// Counts of a traversal.
#[derive(Clone, Copy, Debug, Default)]
pub struct RasterStats {
    /// Fragments tested; those of tiny faces are counted at set-up.
    pub tested: u64,
    /// Fragments that passed.
    pub passed: u64,
    /// Faces that were skipped as hidden.
    pub hidden: u64,
}

/// Draws the faces of `bin` in order; `exact_faces` are the chunk's.
#[inline(always)]
pub(super) fn traverse<S: Simd, R: FaceRaster>(
    s: S,
    bin: &Bin,
    exact_faces: &[ExactFace],
    raster: &mut R,
) -> RasterStats {
    let mut done = RasterStats::default();
    let mut at = Position { larger: 0, tiny: 0, fragments: 0 };
    while at.larger <= bin.larger.len() {
        let next = bin.larger.get(at.larger);
        at.draw_before(s, bin, next, raster, &mut done);
        match next.map(|l| l.entry) {
            None => break,
            Some(BinEntry::OrderBreak) => {}
            Some(BinEntry::Small(index)) => {
                let face = &bin.small[index as usize];
                if raster.hides_small(face) {
                    done.hidden += 1;
                    continue;
                }
                let (t, p) = raster.small(s, face);
                (done.tested, done.passed) = (done.tested + t, done.passed + p);
            }
            Some(BinEntry::Exact(index)) => {
                let face = &exact_faces[index as usize];
                if raster.hides_exact(face) {
                    done.hidden += 1;
                    continue;
                }
                if raster.filling(face) != Filling::All {
                    let (t, p) = raster.exact_face(s, face);
                    (done.tested, done.passed) = (done.tested + t, done.passed + p);
                    continue;
                }
                at.draw_stack(s, bin, exact_faces, face, raster, &mut done);
            }
        }
    }
    done
}

/// Numbers of a bin's faces that are drawn, of each kind.
struct Position {
    larger: usize,
    tiny: usize,
    fragments: usize,
}

impl Position {
    /// Draws the fragments and tiny faces up to the next larger face, or the last ones, and goes on
    /// to that face.
    #[inline(always)]
    fn draw_before<S: Simd, R: FaceRaster>(
        &mut self,
        s: S,
        bin: &Bin,
        next: Option<&Larger>,
        raster: &mut R,
        done: &mut RasterStats,
    ) {
        let fragments = next.map_or(bin.fragments.len(), |l| l.fragments_before as usize);
        if self.fragments < fragments {
            for fragment in bin.fragments.some(self.fragments..fragments) {
                done.passed += u64::from(raster.fragment(fragment));
            }
            self.fragments = fragments;
        }
        let until = next.map_or(bin.tiny.len(), |l| l.tiny_before as usize);
        for words in &bin.tiny[self.tiny..until] {
            let face = &Tiny::of(*words);
            match raster.hides_tiny(face) {
                true => done.hidden += 1,
                false => done.passed += raster.tiny(s, face),
            }
        }
        (self.larger, self.tiny) = (self.larger + 1, until);
        raster.has_passed(s, done.passed);
    }

    /// Draws a face that fills the tile, together with the faces behind it that also do.
    #[inline(always)]
    fn draw_stack<'f, S: Simd, R: FaceRaster>(
        &mut self,
        s: S,
        bin: &Bin,
        exact_faces: &'f [ExactFace],
        first: &'f ExactFace,
        raster: &mut R,
        done: &mut RasterStats,
    ) {
        let mut stack = [first; MOST_STACKED];
        let mut count = 1;
        raster.will_fill(first);
        while count < stack.len() {
            let Some(&Larger { fragments_before, tiny_before, entry: BinEntry::Exact(index) }) =
                bin.larger.get(self.larger)
            else {
                break;
            };
            if fragments_before as usize != self.fragments || tiny_before as usize != self.tiny {
                break;
            }
            let face = &exact_faces[index as usize];
            if raster.hides_exact(face) {
                done.hidden += 1;
                self.larger += 1;
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
            self.larger += 1;
        }
        done.tested += count as u64 * raster.pixels();
        done.passed += raster.stack(s, &stack[..count]);
    }
}
