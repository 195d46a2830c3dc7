//! An emulated video memory that programs draw into by commands.
//!
//! The way of the source material, and where each step lives:
//!
//! 1. **Point**: four bytes R, G, B, A at `offset = (width * y + x) * 4`: [`memory::VideoMemory`], [`memory::FbPtr`].
//! 2. **Line**: Bresenham's midpoint variable in whole numbers, clipped exactly: [`draw2d::line`].
//! 3. **Triangle**: edges as lines, areas by exact coverage: [`draw2d::fill`], [`math::coverage`].
//! 4. **Spaces**: object, world, view, clip, NDC, screen: [`pipeline`], [`scene::Camera`].
//! 5. **Clipping**: against six planes in homogeneous coordinates: [`pipeline::clip_polygon`].
//! 6. **Projection**: perspective, parallel, oblique, the viewing transformation: [`scene::Projection`].
//! 7. **Visibility**: back faces, painter, z-buffer: [`scene::HiddenSurface`], [`memory::DepthMemory`].
//! 8. **Light**: flat, Gouraud, Phong, textures: [`scene::ShadeMode`], [`scene::Light`], [`scene::Material`].
//!
//! Programs ask for all of it by [`command::Command`]s, as text on a socket or as values from the same process:
//!
//! ```
//! use fbptr::server::{Engine, Finish, RenderThread};
//!
//! let thread = RenderThread::start(Engine::new(64, 48)?)?;
//! let client = thread.client();
//! client.line([0, 0], [63, 47], [255, 255, 0, 255]);
//! assert_eq!(client.snapshot()?.get_pixel(0, 0)?, [255, 255, 0, 255]);
//! thread.finish(Finish::Now);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The rooms below stand in layers; imports go down only (`tests/layers.rs` checks it).
#![deny(unsafe_code)]
#![warn(missing_docs)]

// 0: numbers, kernels, refusal codes
pub mod error;
pub mod math;
pub mod simd;
// 1: what there is
pub mod memory;
pub mod scene;
// 2: drawing
pub mod draw2d;
pub mod eye;
pub mod pipeline;
pub mod truth;
// 3: in and out, without a thread
pub mod command;
pub mod load;
pub mod save;
// 4: the render thread
pub mod server;
// 5: the screen, the measurements
pub mod measure;
#[cfg(feature = "window")]
pub mod window;
// 6: the command line
pub mod cli;
