//! Visible face of a pixel where two faces of one draw are closer than the errors of their depths in
//! f32: decided by the depths of the plain path, so that the picture shows the face that it shows.
//!
//! A stored word is that of the face whose id is stored. Let e be a bound on the difference between a
//! face's f32 depth at a covered pixel and the depth of the plain path there, rounded to f32 as its
//! words are. If the words of two faces differ by more than the sum of their bounds, they are in the
//! right order; otherwise [`CloseDepths::decide`] compares the words of the plain path, the earlier
//! face winning a tie. Each decision then is the plain path's, so the face that is left is the first
//! of those with its least word, in any tiles and on any threads, at every vector width. A looser
//! bound costs time and changes nothing.
//!
//! Bounds, for a face with screen vertices (of depths 0 to 1, set-up in [`super::face_vectors`]):
//! - corners in f32: 3.0e-8 (half a unit of the last place below 1); positions within half of 1/65536
//!   pixel on each axis at a slope of 1/128 a pixel: 8.5e-8
//! - the slopes' roundings over the face: 6e-8
//! - five roundings of sums at set-up and at the pixel, and the plain path's: 3.0e-8 each
//!
//! which is less than `ROUNDINGS` = 5e-7, also with the first two lines times 1 + 2 BESIDE / THIN = 1.18
//! at a centre beside the face. For snapping covers centres beside the unsnapped face: its corners move
//! by at most BESIDE = 1/362 pixel (1/512 on each axis), so such a centre lies less than BESIDE outside
//! of the unsnapped face, and less than BESIDE inside an edge of the snapped one. There the f32 plane is
//! extended, but the plain path drops the negative weights: with barycentrics b_i of the pixel
//! (sum b_i w_i = 1 and z = sum b_i z_i, with z_i and w_i of clip space)
//!
//! ```text
//! z' - z = sum b_i (z w_i - z_i) / (1 - sum b_i w_i)     over the i with b_i < 0, of which there are at most two
//! ```
//!
//! where |b_i| <= BESIDE |grad b_i|. In front of the eye |grad b_i| w_i = 1 / h_i, with the heights
//! h_i >= det / L of the face, L its longest side, and |z - z_i| <= rise, the range of its depths (of
//! the extended plane, to within as little). With h_i >= THIN = 1/32 the denominator is at least 0.82,
//! so the difference is less than `SPREAD` = 2.6 times BESIDE rise L / det, which set-up measures
//! ([`super::face_vectors::DepthPlanes`]). A face that is thinner, or for which it exceeds 2.5e-4, is
//! rough: if a pixel that it covers lies less than BESIDE inside an edge, it is set up in f64, and
//! otherwise the roundings are all.
//!
//! Left out is what multiplying the draw's matrices into one changes in z: 1e-14 times the coordinates'
//! reach over w. With a near plane at 0.01 and coordinates of 10 that is 1e-11.
//!
//! The depth of a face set up in f64 is off by the roundings of one run, less than 2e-7, and beside the
//! face by the sum above, which [`is_rough`] evaluates. If that exceeds 2.4e-4, the pixels beside it take
//! the plain path's words ([`CloseDepths::words_beside`]).

use super::tile_buffers::{EXACT_FACE_BIT, NO_FACE};
use super::vertex::ScreenVertex;
use crate::memory::DepthFormat;
use crate::pipeline::assemble::Face;
use crate::pipeline::plane_equation::PlaneEquation;
use crate::pipeline::viewport::ViewportTransform;
use std::cell::RefCell;

/// Bound on the roundings of a depth in f32, against the plain path's word.
const ROUNDINGS: f32 = 5e-7;

/// Largest distance in pixels of a covered centre from the unsnapped face: half of 1/256 pixel on each
/// axis.
const BESIDE: f64 = 0.002_763;

/// Factor from BESIDE rise L / det to the largest difference beside a face.
const SPREAD: f64 = 2.6;

/// Largest (rise L / det)^2 of faces that are not rough: a difference of 2.5e-4 beside them.
pub(super) const MOST_SPREAD: f32 = 1.2e-3;

/// Largest difference of exact faces that are not rough.
const MOST_ERROR: f64 = 2.4e-4;

/// Smallest thickness in pixels of faces that are not rough.
pub(super) const THIN: f32 = 1.0 / 32.0;

/// Returns the bound on the error of a draw's depths, for faces whose (rise L / det)^2 is at most
/// `spread` unless they are rough.
pub(super) fn error_of_spread(spread: f32) -> f32 {
    ROUNDINGS + (1.001 * SPREAD * BESIDE) as f32 * spread.clamp(0.0, MOST_SPREAD).sqrt()
}

/// Returns whether a face set up in f64 is rough: given its plane equation, z and w of its corners in
/// clip space, and the factors of its barycentrics: 1, or w where they are linear on the screen.
pub(crate) fn is_rough(
    plane: &PlaneEquation,
    corners: [[f64; 2]; 3],
    factors: [f64; 3],
    z_range: [f64; 2],
) -> bool {
    // z of the pixels is between 0 and 1, and within the corners' range but for what is bounded here.
    let (low, high) = (z_range[0].max(0.0) - MOST_ERROR, z_range[1].min(1.0) + MOST_ERROR);
    let (mut difference, mut share) = (0.0, 0.0);
    for (([z, w], [_, x, y]), factor) in corners.into_iter().zip(plane.barycentrics).zip(factors) {
        let b = BESIDE * (x.abs() + y.abs()) / factor.abs();
        difference += b * (low * w - z).abs().max((high * w - z).abs());
        share += b * w.abs();
    }
    // A NaN is rough.
    !(share < 0.5 && difference < MOST_ERROR * (1.0 - share))
}

/// Face of the plain path, for its depths.
#[derive(Clone, Debug)]
pub(crate) struct ReferenceFace {
    face: Face,
    crossing: Option<PlaneEquation>,
    screen: ViewportTransform,
}

impl ReferenceFace {
    /// Returns the depths of an assembled face.
    pub fn new(face: Face, screen: ViewportTransform) -> Self {
        ReferenceFace { crossing: face.crossing(&screen), face, screen }
    }

    /// Returns whether it is nearer than another face, if that is the same at all pixels: both have the same
    /// depths, or one each.
    fn is_nearer(&self, other: &ReferenceFace) -> Option<bool> {
        let (own, others) = (&self.face, &other.face);
        if own.plane.has_depths_of(&others.plane) && own.z_range == others.z_range {
            return Some(false);
        }
        let only_word = |face: &ReferenceFace| match face.crossing {
            Some(_) => None,
            None => face.face.plane.only_depth().map(|[z, complement]| {
                DepthFormat::F32.encode(z.clamp(0.0, 1.0), complement.clamp(0.0, 1.0))
            }),
        };
        Some(only_word(self)? < only_word(other)?)
    }

    /// Returns the word of the face's depth at the centre of a pixel; `None` where the plain path
    /// does not draw it.
    fn word(&self, at: [i32; 2]) -> Option<u32> {
        let (_, z, complement) = self.face.point_at(at, &self.screen, self.crossing.as_ref())?;
        Some(DepthFormat::F32.encode(z, complement))
    }
}

/// Assembles a face of the draw, by its index, as the plain path does; `None` if it draws nothing.
pub type ReferenceFaces<'a> = &'a (dyn Fn(u32) -> Option<ReferenceFace> + Sync);

/// A vector of pixels, some of which a face may win.
pub(super) struct Contest<'a> {
    /// First pixel.
    pub at: [i32; 2],
    /// Face id of the face that is drawn, and its words.
    pub id: i32,
    pub words: [i32; 16],
    /// Face ids and words that the pixels have.
    pub ids: &'a [i32],
    pub old: &'a [i32],
    /// Lanes that the face wins by its words, and those where both are close.
    pub passes: u32,
    pub close: u32,
}

/// Decides which of two close faces is visible.
pub(super) struct CloseDepths<'a> {
    /// Faces as the plain path assembles them.
    pub faces: ReferenceFaces<'a>,
    /// Vertex indices of each face, and the screen vertices.
    pub corners: &'a [[f32; 4]],
    pub screen_vertices: &'a [ScreenVertex],
    last: RefCell<LastPair>,
}

/// The last face that was drawn, and the last one that it met.
#[derive(Debug)]
struct LastPair {
    faces: [CachedFace; 2],
    /// True if the first is nearer, if that is the same at all pixels; `None` if it was not asked for.
    is_nearer: Option<Option<bool>>,
}

/// A face with a bound on its error, and as the plain path has it, once that is asked for.
#[derive(Clone, Debug)]
struct CachedFace {
    id: i32,
    error: f32,
    reference: Option<Option<ReferenceFace>>,
}

impl<'a> CloseDepths<'a> {
    /// Returns the decisions of a draw.
    pub fn new(
        faces: ReferenceFaces<'a>,
        corners: &'a [[f32; 4]],
        screen_vertices: &'a [ScreenVertex],
    ) -> Self {
        let none = CachedFace { id: NO_FACE, error: 0.0, reference: None };
        let last = LastPair { faces: [none.clone(), none], is_nearer: None };
        CloseDepths { faces, corners, screen_vertices, last: RefCell::new(last) }
    }

    /// Returns the lanes that the face wins.
    #[cold]
    #[inline(never)]
    pub fn decide(&self, contest: &Contest<'_>) -> u32 {
        let (mut passes, mut left) = (contest.passes, contest.close);
        let LastPair { faces: last, is_nearer: of_pair } = &mut *self.last.borrow_mut();
        if let (true, Some(Some(is_nearer))) = (last[0].id == contest.id, *of_pair) {
            let met = contest.ids.iter().rev().fold(0, |met, id| met << 1 | u32::from(*id == last[1].id));
            passes = if is_nearer { passes | left & met } else { passes & !(left & met) };
            left &= !met;
        }
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let old = contest.ids[lane];
            // What another draw has left has no face.
            if old == NO_FACE {
                continue;
            }
            for (cached, id) in last.iter_mut().zip([contest.id, old]) {
                if cached.id != id {
                    *cached = CachedFace { id, error: self.error(id), reference: None };
                    *of_pair = None;
                }
            }
            let real = |word: i32| f32::from_bits(word as u32);
            let apart = (real(contest.words[lane]) - real(contest.old[lane])).abs();
            if apart > last[0].error + last[1].error {
                continue;
            }
            let at = [contest.at[0] + lane as i32, contest.at[1]];
            let is_nearer = match *of_pair.get_or_insert_with(|| self.is_nearer(last)) {
                Some(is_nearer) => is_nearer,
                None => match last.each_mut().map(|face| face.word(self.faces, at)) {
                    [Some(word), Some(old)] => word < old,
                    [word, _] => word.is_some(),
                },
            };
            passes = (passes & !(1 << lane)) | u32::from(is_nearer) << lane;
        }
        passes
    }

    /// Sets the words of an exact face at the pixels beside it: of the lanes from (x, y) on. Returns
    /// those lanes in which the plain path draws it.
    #[cold]
    #[inline(never)]
    pub fn words_beside(&self, id: i32, [x, y]: [i32; 2], lanes: u32, words: &mut [i32; 16]) -> u32 {
        let (mut drawn, mut left) = (lanes, lanes);
        let LastPair { faces: [cached, _], is_nearer } = &mut *self.last.borrow_mut();
        if cached.id != id {
            *cached = CachedFace { id, error: self.error(id), reference: None };
            *is_nearer = None;
        }
        while left != 0 {
            let lane = left.trailing_zeros();
            left &= left - 1;
            match cached.word(self.faces, [x + lane as i32, y]) {
                Some(word) => words[lane as usize] = word as i32,
                None => drawn &= !(1 << lane),
            }
        }
        drawn
    }

    /// Returns whether the first of two faces is nearer, if that is the same at all pixels. Meshes have
    /// faces twice, which would be compared at each pixel; and faces in one plane parallel to the screen.
    fn is_nearer(&self, pair: &mut [CachedFace; 2]) -> Option<bool> {
        let [corners, others] = pair.each_ref().map(|face| {
            let corners = self.corners.get((face.id & !EXACT_FACE_BIT) as usize);
            let mut corners = corners.map(|&[a, b, c, _]| [a, b, c].map(f32::to_bits));
            corners.iter_mut().for_each(|corners| corners.sort_unstable());
            corners
        });
        if corners.is_some() && corners == others {
            return Some(false);
        }
        match pair.each_mut().map(|face| face.reference(self.faces)) {
            [Some(face), Some(other)] => face.is_nearer(other),
            _ => None,
        }
    }

    /// Returns a bound on the error of a face's depths.
    fn error(&self, id: i32) -> f32 {
        let most = error_of_spread(MOST_SPREAD);
        if id & EXACT_FACE_BIT != 0 {
            return most;
        }
        let Some(&[a, b, c, _]) = self.corners.get(id as usize) else { return most };
        let corner = |index: f32| {
            let [x, y, z, _] = self.screen_vertices[index.to_bits() as usize];
            [f64::from(x.to_bits() as i32) / 65536.0, f64::from(y.to_bits() as i32) / 65536.0, f64::from(z)]
        };
        let [a, b, c] = [a, b, c].map(corner);
        let [u, v, w] = [(a, b), (b, c), (c, a)].map(|(p, q)| [q[0] - p[0], q[1] - p[1], q[2] - p[2]]);
        let det = u[0] * v[1] - u[1] * v[0];
        if det == 0.0 || !det.is_finite() {
            return most;
        }
        let longest2 = [u, v, w].iter().fold(0.0f64, |most, e| most.max(e[0] * e[0] + e[1] * e[1]));
        let rise = [u, v, w].iter().fold(0.0f64, |most, e| most.max(e[2].abs()));
        error_of_spread((1.001 * (rise * rise * longest2 / (det * det))) as f32)
    }
}

impl CachedFace {
    /// Returns the face of the plain path.
    fn reference(&mut self, faces: ReferenceFaces<'_>) -> Option<&ReferenceFace> {
        let face = (self.id & !EXACT_FACE_BIT) as u32;
        self.reference.get_or_insert_with(|| faces(face)).as_ref()
    }

    /// Returns the word of the plain path at a pixel.
    fn word(&mut self, faces: ReferenceFaces<'_>, at: [i32; 2]) -> Option<u32> {
        self.reference(faces)?.word(at)
    }
}
