//! Queue of lit pixels whose texels are not fetched yet.
//!
//! A textured vector goes through a long chain of dependent operations: barycentrics, level,
//! addresses, texels, colour. So several vectors go through each part together; the queue holds the
//! state of a vector once its barycentrics and its light are computed. The pixels do not depend on
//! the order in which they are drawn.

use super::interpolate::ReflectedLight;
use super::lighting::splat3;
use super::sampler::{SampleCoord, TexelAddresses};
use crate::simd::Simd;

/// Number of vectors processed per batch, to hide latency.
pub const QUEUE_CAPACITY: usize = 4;

/// Vector of lit pixels of one material.
#[derive(Clone, Copy)]
pub struct QueuedPixels<S: Simd> {
    /// Lanes to be drawn.
    pub mask: S::M,
    /// Index of the material.
    pub binding: usize,
    /// Upper left pixel of the block.
    pub corner: [i32; 2],
    /// Light of the pixels.
    pub lit: ReflectedLight<S>,
    /// Texture coordinates.
    pub sample_coord: SampleCoord<S>,
    /// Texels to read, computed when the queue is drained.
    pub texel_addresses: TexelAddresses<S>,
}

/// The queued vectors.
pub struct TextureQueue<S: Simd> {
    /// Queued vectors; those from `count` on are unused.
    pub vectors: [QueuedPixels<S>; QUEUE_CAPACITY],
    /// Number of queued vectors.
    pub count: usize,
}

impl<S: Simd> TextureQueue<S> {
    /// Creates an empty queue.
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
