//! Fetches of vertex attributes at the corners of the faces that a vector of pixels shows.

use super::lighting::V3;
use crate::simd::Simd;

/// Vertices of the faces that a vector of pixels shows.
#[derive(Clone, Copy)]
pub enum Corners<'a, S: Simd> {
    /// A face of its own for each pixel.
    Many([S::I; 3]),
    /// A few faces, each of some of the pixels.
    Few(&'a Few<S>),
    /// One face.
    One([usize; 3]),
}

/// Largest number of faces in a vector that are read one by one and spread over their pixels; more
/// are gathered.
pub const fn most_few<S: Simd>() -> usize {
    S::LANES * 3 / 8
}

/// Largest [`most_few`], that of the widest vectors.
pub const MOST_FEW: usize = 6;

/// The few faces that a vector of pixels shows. Never copied: a copy would load at once what was
/// stored in pieces, and would have to wait until all of it has reached the cache.
pub struct Few<S: Simd> {
    /// Number of faces.
    pub count: usize,
    /// Pixels of each face.
    pub pixels: [S::M; MOST_FEW],
    /// Vertices of each face.
    pub vertices: [[usize; 3]; MOST_FEW],
}

impl<S: Simd> Few<S> {
    /// Creates room for faces.
    #[inline(always)]
    pub fn new(s: S) -> Self {
        Few { count: 0, pixels: [s.mask(0); MOST_FEW], vertices: [[0; 3]; MOST_FEW] }
    }
}

// Functions marked for inlining, not closures: a closure would be compiled without the level's
// instructions.

/// Fetches a table's records at the three corners.
#[inline(always)]
pub fn gather3<S: Simd>(s: S, mask: S::M, table: &[[f32; 4]], corners: &Corners<'_, S>) -> [[S::F; 4]; 3] {
    match corners {
        Corners::Many([c0, c1, c2]) => {
            [s.gather4(mask, table, *c0), s.gather4(mask, table, *c1), s.gather4(mask, table, *c2)]
        }
        Corners::Few(few) => {
            let [c0, c1, c2] = few.vertices[0];
            let mut out = [splat4(s, table[c0]), splat4(s, table[c1]), splat4(s, table[c2])];
            let mut face = 1;
            while face < few.count {
                let (pixels, [c0, c1, c2]) = (few.pixels[face], few.vertices[face]);
                out = [
                    spread(s, pixels, table[c0], out[0]),
                    spread(s, pixels, table[c1], out[1]),
                    spread(s, pixels, table[c2], out[2]),
                ];
                face += 1;
            }
            out
        }
        Corners::One([c0, c1, c2]) => [splat4(s, table[*c0]), splat4(s, table[*c1]), splat4(s, table[*c2])],
    }
}

/// Returns a record in these pixels, and `others` in the rest.
#[inline(always)]
fn spread<S: Simd>(s: S, pixels: S::M, [a, b, c, d]: [f32; 4], others: [S::F; 4]) -> [S::F; 4] {
    [
        s.select(pixels, s.splat(a), others[0]),
        s.select(pixels, s.splat(b), others[1]),
        s.select(pixels, s.splat(c), others[2]),
        s.select(pixels, s.splat(d), others[3]),
    ]
}

#[inline(always)]
fn splat4<S: Simd>(s: S, [a, b, c, d]: [f32; 4]) -> [S::F; 4] {
    [s.splat(a), s.splat(b), s.splat(c), s.splat(d)]
}

/// Interpolates the first three numbers of a table's records at the corners.
#[inline(always)]
pub fn blend<S: Simd>(s: S, mask: S::M, table: &[[f32; 4]], corners: &Corners<'_, S>, b: [S::F; 3]) -> V3<S> {
    let [v0, v1, v2] = gather3(s, mask, table, corners);
    [
        (v0[0] * b[0] + v1[0] * b[1]) + v2[0] * b[2],
        (v0[1] * b[0] + v1[1] * b[1]) + v2[1] * b[2],
        (v0[2] * b[0] + v1[2] * b[1]) + v2[2] * b[2],
    ]
}
