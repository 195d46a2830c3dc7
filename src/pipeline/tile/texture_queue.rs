//! Queue of lit pixels whose texels are not fetched yet.
//!
//! A textured vector goes through a long chain of operations, each of which needs the one before it: weights, level,
//! addresses, texels, colour. So several are taken through each part of it together; what is left to a vector when its weights
//! and its light are done is kept here. The pixels are the same in whatever order they are drawn.

use super::interpolate::ReflectedLight;
use super::lighting::splat3;
use super::sampler::{SampleCoord, TexelAddresses};
use crate::simd::Simd;

/// Number of vectors processed per batch, to hide latency.
pub const QUEUE_CAPACITY: usize = 4;

/// A vector of lit pixels of one surface.
#[derive(Clone, Copy)]
pub struct QueuedPixels<S: Simd> {
    /// Which of them are to be drawn.
    pub mask: S::M,
    /// The surface's number.
    pub binding: usize,
    /// The block's upper left pixel.
    pub corner: [i32; 2],
    /// Their light.
    pub lit: ReflectedLight<S>,
    /// Where they look into the texture.
    pub sample_coord: SampleCoord<S>,
    /// What they will read there, once that is known.
    pub texel_addresses: TexelAddresses<S>,
}

/// The queued vectors.
pub struct TextureQueue<S: Simd> {
    /// The vectors; those from `count` on mean nothing.
    pub vectors: [QueuedPixels<S>; QUEUE_CAPACITY],
    /// How many.
    pub count: usize,
}

impl<S: Simd> TextureQueue<S> {
    /// None.
    #[inline(always)]
    pub fn new(s: S) -> Self {
        let none = QueuedPixels {
            mask: s.mask(0),
            binding: 0,
            corner: [0; 2],
            lit: ReflectedLight {
                diffuse: splat3(s, [0.0; 3]),
                specular: splat3(s, [0.0; 3]),
                position: splat3(s, [0.0; 3]),
            },
            sample_coord: SampleCoord::origin(s),
            texel_addresses: TexelAddresses::none(s),
        };
        Self { vectors: [none; QUEUE_CAPACITY], count: 0 }
    }
}
