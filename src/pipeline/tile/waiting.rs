//! Pixels that wait for their texels.
//!
//! A textured vector goes through a long chain of operations, each of which needs the one before it: weights, level,
//! addresses, texels, colour. So several are taken through each part of it together; what is left to a vector when its weights
//! and its light are done is kept here. The pixels are the same in whatever order they are drawn.

use super::light::splat3;
use super::shares::Reflected;
use super::texture::{Aim, Spot};
use crate::simd::Simd;

/// So many vectors are taken together.
pub const ROOM: usize = 4;

/// A vector of lit pixels of one surface.
#[derive(Clone, Copy)]
pub struct Waiting<S: Simd> {
    /// Which of them are to be drawn.
    pub mask: S::M,
    /// The surface's number.
    pub surface: usize,
    /// The block's upper left pixel.
    pub corner: [i32; 2],
    /// Their light.
    pub lit: Reflected<S>,
    /// Where they look into the texture.
    pub spot: Spot<S>,
    /// What they will read there, once that is known.
    pub aim: Aim<S>,
}

/// The vectors that wait.
pub struct Line<S: Simd> {
    /// The vectors; those from `count` on mean nothing.
    pub vectors: [Waiting<S>; ROOM],
    /// How many.
    pub count: usize,
}

impl<S: Simd> Line<S> {
    /// None.
    #[inline(always)]
    pub fn new(s: S) -> Self {
        let none = Waiting {
            mask: s.mask(0),
            surface: 0,
            corner: [0; 2],
            lit: Reflected {
                matte: splat3(s, [0.0; 3]),
                gloss: splat3(s, [0.0; 3]),
                position: splat3(s, [0.0; 3]),
            },
            spot: Spot::origin(s),
            aim: Aim::none(s),
        };
        Self { vectors: [none; ROOM], count: 0 }
    }
}
