//! The video memory of `fbptr` and everything that draws into it, without I/O, threads of its own
//! or a clock.
//!
//! By layer, imports going down only:
//!
//! | layer | module | contents |
//! |---|---|---|
//! | 0 | [`error`] | the closed list of refusal codes |
//! | 0 | [`cancel`] | the flag by which long work is ended from outside |
//! | 0 | [`input`] | an event of the user: key, text, pointer, wheel |
//! | 0 | [`executor`] | the calling thread or a pool, by which drawing is shared |
//! | 0 | [`math`] | matrices, exact coverage, polygons, projections: numbers alone |
//! | 0 | [`simd`] | vectors of 16, 8 or 4 lanes; with the shared file the only place with `unsafe` |
//! | 1 | [`memory`] | the video memory: `FbPtr`, `VideoMemory`, depth, the pick buffer, the shared file |
//! | 1 | [`scene`] | what is drawn, as plain data: meshes, materials, lights, cameras, textures |
//! | 2 | [`draw2d`] | pixels, lines, areas, circles, text, blits |
//! | 2 | [`pipeline`] | 3-D: the numbered stages, the fast path, the error budget |
//! | 2 | [`eye`] | the N-dimensional eye |
#![deny(unsafe_code)]
#![deny(missing_docs)]
// `unwrap` is for tests: code says why a value cannot be missing.
#![cfg_attr(not(test), deny(clippy::unwrap_used))]
// The wider vectors' code is then compiled for nothing.
#![cfg_attr(narrow_vectors, allow(dead_code, unused_imports))]

#[doc(hidden)]
pub mod cancel;
pub mod draw2d;
pub mod error;
#[doc(hidden)]
pub mod executor;
pub mod eye;
pub mod input;
#[doc(hidden)]
pub mod math;
pub mod memory;
pub mod pipeline;
pub mod scene;
#[doc(hidden)]
pub mod simd;
#[cfg(test)]
#[path = "truth_scenes.rs"]
mod truth;

#[cfg(test)]
extern crate self as fbptr_core;

pub use cancel::CancelToken;
pub use executor::{Executor, ThreadPool};
/// Vectors and matrices, in the version whose types the functions here take.
pub use glam;
pub use memory::{Rgba, VideoMemory};
pub use pipeline::Renderer;
pub use scene::{Camera, Geometry, Light, Material, Mesh, Scene};
pub use simd::Level;

/// Compiles the example of the crate's page as a doc test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
