//! The face that was set up in f64 and is being shaded, looked up once for all its neighbouring vectors.

use super::exact_faces::ExactFace;
use super::face_tables::Faces;
use super::light_grid::LightGrids;
use super::matte_face::MatteFace;
use super::tile_buffers::{EXACT_FACE_BIT, NO_FACE, Tile};
use crate::math::coverage::PixelRect;
use crate::simd::{Part, Simd};

/// Last face that was looked up.
pub(super) struct CachedFace<'a, S: Simd> {
    pub face: i32,
    /// Its set-up.
    pub exact_face: Option<&'a ExactFace>,
    /// Packed colour; `None` if the face has more than one.
    pub color: Option<S::I>,
    /// The matte face that it is.
    pub matte: Option<MatteFace<'a>>,
    /// True if faces of the draw may have grids of light, and if this one may.
    may_have_grids: bool,
    pub has_grid: bool,
    /// Index of its grid in `grids`, once it is open.
    pub grid: Option<usize>,
    pub grids: LightGrids,
}

impl<'a, S: Simd> CachedFace<'a, S> {
    /// Creates it before any face was looked up.
    #[inline(always)]
    pub fn new(faces: &Faces<'a>) -> Self {
        CachedFace {
            face: NO_FACE,
            exact_face: None,
            color: None,
            matte: None,
            may_have_grids: faces.may_have_grids(),
            has_grid: false,
            grid: None,
            grids: LightGrids::none(),
        }
    }

    /// Makes it the face of an id.
    #[inline(always)]
    pub fn look_up(&mut self, s: S, faces: &Faces<'a>, tile: &Tile<'_>, id: i32) {
        let face = id & !EXACT_FACE_BIT;
        if self.face != face {
            s.call(s, LookUp { cached: self, faces, tile: tile.rect(), face });
        }
    }
}

/// Looking up a face that was set up in f64.
struct LookUp<'k, 'a, S: Simd> {
    cached: &'k mut CachedFace<'a, S>,
    faces: &'k Faces<'a>,
    tile: PixelRect,
    face: i32,
}

impl<S: Simd> Part<S> for LookUp<'_, '_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self, s: S) {
        let LookUp { cached, faces, tile, face } = self;
        cached.face = face;
        cached.exact_face = (faces.exact_face)(face as u32);
        cached.color = faces.only_color(s, face as usize, cached.exact_face);
        (cached.matte, cached.has_grid, cached.grid) = (None, false, None);
        if let (None, Some(exact_face)) = (cached.color, cached.exact_face) {
            cached.matte = MatteFace::new(faces, exact_face);
            cached.has_grid = cached.may_have_grids && faces.may_have_grid(exact_face, tile);
        }
    }
}
