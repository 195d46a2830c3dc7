//! Traversal of a tile's faces in file order: fragments and tiny faces up to the next larger one,
//! and runs of faces that fill the tile.
//!
//! In: a chunk's bin of a tile. Out: depth words and face ids, fragments tested and passed, and faces
//! skipped. The depth test is a type parameter, and so is the test of whole faces, which is none or
//! that of [`super::hierarchical_z`]: what it leaves at its default costs nothing.

use super::bins::{Bin, BinEntry, Larger, Small, Tiny};
use super::depth_test::DepthTest;
use super::exact_faces::ExactFace;
use super::exact_raster::{self, MOST_STACKED};
use super::raster;
use super::tile_buffers::Tile;
use crate::math::coverage::Filling;
use crate::simd::{Kernel, Simd, prefetch};

/// Rasterizes the faces of one chunk in a tile.
pub(super) struct RasterKernel<'a, 'b, D> {
    /// Bin of the chunk's faces in this tile.
    pub bin: &'a Bin,
    /// The chunk's exact faces.
    pub exact_faces: &'a [ExactFace],
    /// Per-face data to prefetch for the resolve of visible faces.
    pub corners: &'a [[f32; 4]],
    /// Depth test of the tile's format.
    pub test: D,
    /// Tile and its buffers.
    pub tile: &'a mut Tile<'b>,
}

impl<D: DepthTest> Kernel for RasterKernel<'_, '_, D> {
    type Output = RasterStats;

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) -> RasterStats {
        self.traverse(s, &mut NoOcclusion)
    }
}

/// Test of whole faces before they are drawn.
pub(super) trait Occlusion {
    /// Returns whether no fragment of the face would pass, so that it need not be drawn.
    #[inline(always)]
    fn hides_tiny(&self, _: &Tile<'_>, _: &Tiny) -> bool {
        false
    }
    /// Returns whether no fragment of the face would pass.
    #[inline(always)]
    fn hides_small(&self, _: &Tile<'_>, _: &Small) -> bool {
        false
    }
    /// Returns whether no fragment of the face would pass.
    #[inline(always)]
    fn hides_exact(&self, _: &Tile<'_>, _: &ExactFace) -> bool {
        false
    }
    /// Called for a face that fills the tile; it is drawn before the faces of later queries.
    #[inline(always)]
    fn will_fill(&mut self, _: &ExactFace) {}
    /// Called with the number of fragments that have passed so far.
    #[inline(always)]
    fn has_passed<S: Simd>(&mut self, _: S, _: &Tile<'_>, _: u64) {}
}

/// No test: every face is drawn.
struct NoOcclusion;

impl Occlusion for NoOcclusion {}

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

/// Numbers of a bin's faces that are drawn, of each kind.
struct Position {
    larger: usize,
    tiny: usize,
    fragments: usize,
}

impl<D: DepthTest> RasterKernel<'_, '_, D> {
    /// Draws the faces of the bin in order.
    #[inline(always)]
    pub fn traverse<S: Simd>(&mut self, s: S, occlusion: &mut impl Occlusion) -> RasterStats {
        let (bin, exact_faces) = (self.bin, self.exact_faces);
        let mut done = RasterStats::default();
        let mut at = Position { larger: 0, tiny: 0, fragments: 0 };
        while at.larger <= bin.larger.len() {
            let next = bin.larger.get(at.larger);
            self.draw_before(s, &mut at, next, occlusion, &mut done);
            match next.map(|l| l.entry) {
                None => break,
                Some(BinEntry::OrderBreak) => {}
                Some(BinEntry::Small(index)) => {
                    let face = &bin.small[index as usize];
                    if occlusion.hides_small(self.tile, face) {
                        done.hidden += 1;
                        continue;
                    }
                    self.tile.depths = None;
                    let (t, p) = raster::small(s, &self.test, face, self.tile);
                    (done.tested, done.passed) = (done.tested + t, done.passed + p);
                }
                Some(BinEntry::Exact(index)) => {
                    let face = &exact_faces[index as usize];
                    if occlusion.hides_exact(self.tile, face) {
                        done.hidden += 1;
                        continue;
                    }
                    if exact_raster::filling(&self.test, face, self.tile) != Filling::All {
                        let (t, p) = exact_raster::draw(s, &self.test, face, self.tile);
                        if p > 0 {
                            self.tile.add_depths(face.z_range);
                        }
                        (done.tested, done.passed) = (done.tested + t, done.passed + p);
                        continue;
                    }
                    self.draw_stack(s, &mut at, face, occlusion, &mut done);
                }
            }
        }
        done
    }

    /// Draws the fragments and tiny faces up to the next larger face, or the last ones, and goes on
    /// to that face.
    #[inline(always)]
    fn draw_before<S: Simd>(
        &mut self,
        s: S,
        at: &mut Position,
        next: Option<&Larger>,
        occlusion: &mut impl Occlusion,
        done: &mut RasterStats,
    ) {
        let bin = self.bin;
        let fragments = next.map_or(bin.fragments.len(), |l| l.fragments_before as usize);
        if at.fragments < fragments {
            for fragment in bin.fragments.some(at.fragments..fragments) {
                prefetch::for_read(self.corners, fragment[2] as usize);
                done.passed += u64::from(raster::fragment(&self.test, fragment, self.tile));
            }
            at.fragments = fragments;
            self.tile.depths = None;
        }
        let mut passed = s.splat_i(0);
        let until = next.map_or(bin.tiny.len(), |l| l.tiny_before as usize);
        if at.tiny < until {
            self.tile.depths = None;
        }
        for words in &bin.tiny[at.tiny..until] {
            let face = &Tiny::of(*words);
            if occlusion.hides_tiny(self.tile, face) {
                done.hidden += 1;
                continue;
            }
            prefetch::for_read(self.corners, face.face as usize);
            done.passed += raster::tiny(s, &self.test, face, self.tile, &mut passed);
        }
        done.passed += raster::sum(s, passed);
        (at.larger, at.tiny) = (at.larger + 1, until);
        occlusion.has_passed(s, self.tile, done.passed);
    }

    /// Draws a face that fills the tile, together with the faces behind it that also do.
    #[inline(always)]
    fn draw_stack<S: Simd>(
        &mut self,
        s: S,
        at: &mut Position,
        first: &ExactFace,
        occlusion: &mut impl Occlusion,
        done: &mut RasterStats,
    ) {
        let (bin, exact_faces) = (self.bin, self.exact_faces);
        let mut stack = [first; MOST_STACKED];
        let mut count = 1;
        occlusion.will_fill(first);
        while count < stack.len() {
            let Some(&Larger { fragments_before, tiny_before, entry: BinEntry::Exact(index) }) =
                bin.larger.get(at.larger)
            else {
                break;
            };
            if fragments_before as usize != at.fragments || tiny_before as usize != at.tiny {
                break;
            }
            let face = &exact_faces[index as usize];
            if occlusion.hides_exact(self.tile, face) {
                done.hidden += 1;
                at.larger += 1;
                continue;
            }
            match exact_raster::filling(&self.test, face, self.tile) {
                Filling::Part => break,
                Filling::None => {}
                Filling::All => {
                    occlusion.will_fill(face);
                    stack[count] = face;
                    count += 1;
                }
            }
            at.larger += 1;
        }
        done.tested += count as u64 * self.tile.pixels();
        done.passed += exact_raster::stack(s, &self.test, &stack[..count], self.tile);
    }
}
