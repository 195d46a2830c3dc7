//! An emulated video memory that programs draw into by commands.
//!
//! ```
//! let mut fb = fbptr::Framebuffer::new(64, 48)?;
//! fb.clear([0, 0, 64, 255]);
//! fb.line([0, 0], [63, 47], [255, 255, 0, 255]);
//! fb.text([2, 2], "hello", [255, 255, 255, 255]);
//! assert_eq!(fb.get_pixel(0, 0)?, [255, 255, 0, 255]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A [`Framebuffer`] draws on the calling thread, [`run`] shows one in a window, and a
//! [`RenderThread`] draws for many clients at once. `docs/library.md` has golden tests in eight
//! lines, a game in forty, and the features that a small build leaves out.
//!
//! # How a picture is made
//!
//! ## 1 Point
//!
//! The frame is one array of bytes, four a pixel (R, G, B, A), row by row from the upper left
//! corner. A pixel's place in it is `offset = (width * y + x) * 4`. See [`memory::VideoMemory`] and
//! [`memory::FbPtr`].
//!
//! ```
//! use fbptr::memory::{FbPtr, VideoMemory};
//!
//! let mut memory = VideoMemory::new(64, 48)?;
//! memory.put_pixel(3, 2, [255, 128, 0, 255]);
//! let at = FbPtr::of_pixel(64, 3, 2);
//! assert_eq!(at.offset_bytes(), (64 * 2 + 3) * 4);
//! assert_eq!(memory.bytes()[at.offset_bytes() as usize..][..4], [255, 128, 0, 255]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! ## 2 Line
//!
//! Bresenham's integer decision variable chooses one pixel a step, for end points anywhere in 32
//! bits; see [`draw2d::line`].
//!
//! ```
//! # use fbptr::{draw2d, memory::VideoMemory};
//! let mut memory = VideoMemory::new(64, 48)?;
//! let yellow = draw2d::RampColor { from: [255, 255, 0, 255], to: None };
//! draw2d::line(&mut memory, [0, 0], [2_000_000_000, 1_000_000_000], yellow, draw2d::Blend::Replace);
//! assert_eq!(memory.get_pixel(62, 31)?, [255, 255, 0, 255]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! ## 3 Triangle
//!
//! A pixel belongs to a triangle if its centre does; on a shared edge exactly one of the two
//! triangles has it. Corners are snapped to 1/256 pixel and everything else is computed in
//! integers: [`draw2d::fill`].
//!
//! ```
//! # use fbptr::{draw2d::{self, AreaColors, Blend}, memory::VideoMemory};
//! let mut memory = VideoMemory::new(64, 48)?;
//! let half = AreaColors::One([0, 0, 255, 128]);
//! // A square of two triangles, half transparent: the seam is not lit twice.
//! draw2d::fill(&mut memory, [[4.0, 4.0], [40.0, 4.0], [40.0, 40.0]], half, Blend::Over);
//! draw2d::fill(&mut memory, [[4.0, 4.0], [40.0, 40.0], [4.0, 40.0]], half, Blend::Over);
//! assert_eq!(memory.get_pixel(20, 20)?, memory.get_pixel(30, 10)?);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! ## 4 Spaces
//!
//! Object -> world -> view, looking along -z -> clip -> NDC -> screen. A [`scene::Camera`] gives
//! the matrices.
//!
//! ```
//! # use fbptr::scene::{Camera, LookAt, Projection};
//! # use glam::DVec3;
//! let look_at = LookAt { eye: DVec3::new(0.0, 0.0, 8.0), reference: DVec3::ZERO, up: DVec3::Y };
//! let projection = Projection::Perspective { fov_rad: 0.8, near: 5.0, far: 10.0, on_smaller_side: false };
//! let matrices = Camera { look_at, projection }.matrices(4.0 / 3.0)?;
//! let clip = matrices.projection * matrices.view * DVec3::ZERO.extend(1.0);
//! assert_eq!(clip.w, 8.0); // w is the distance from the eye's plane
//! assert_eq!(clip.z / clip.w, 0.75); // notes 003: depth 3/4 at 8 between 5 and 10
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! ## 5 Clipping
//!
//! Polygons and lines are clipped against six planes in homogeneous coordinates, before the
//! division by w: [`pipeline::clip_polygon`], [`pipeline::clip_line`].
//!
//! ```
//! # use fbptr::pipeline::{ClipVertex, clip_polygon};
//! # use glam::DVec4;
//! let corner = |x: f64, y: f64| ClipVertex { pos_clip: DVec4::new(x, y, 0.5, 1.0), varyings: [] };
//! // A corner beyond the right side is cut off: a triangle becomes a quadrilateral.
//! let left = clip_polygon::<0>(&[corner(-0.5, -0.5), corner(2.0, 0.0), corner(-0.5, 0.5)]);
//! assert_eq!(left.len(), 4);
//! ```
//!
//! ## 6 Projection
//!
//! Perspective in four forms, orthographic, oblique and isometric projections, and the viewing
//! transformation: [`scene::Projection`].
//!
//! ## 7 Visibility
//!
//! Faces that are turned away are culled, then the painter's algorithm or the z-buffer decides:
//! [`scene::HiddenSurface`], [`memory::DepthMemory`].
//!
//! ## 8 Light
//!
//! Flat, Gouraud or Phong: light is computed once per face, per vertex or per pixel; see
//! [`scene::ShadeMode`], [`scene::Light`], [`scene::Material`]. With this a whole mesh is one call:
//!
//! ```
//! use fbptr::memory::{DepthFormat, VideoMemory};
//! use fbptr::pipeline::{self, DrawCall, Target, trace};
//! use fbptr::scene::{Camera, Geometry, LookAt, Material, shapes};
//! use glam::DVec3;
//!
//! let geometry = Geometry { mesh: shapes::sphere(1.0)?, ..Default::default() };
//! let material = Material { emissive: DVec3::new(0.2, 0.4, 0.8), ..Default::default() };
//! let look_at = LookAt { eye: DVec3::new(0.0, 0.0, 4.0), reference: DVec3::ZERO, up: DVec3::Y };
//! let camera = Camera { look_at, ..Camera::default() };
//! let call = DrawCall { camera, ..DrawCall::new(&geometry, &material, 64, 48) };
//!
//! let (mut memory, mut depth) = (VideoMemory::new(64, 48)?, None);
//! let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format: DepthFormat::F32, ids: None };
//! pipeline::draw(&mut target, &call)?;
//! assert_eq!(memory.get_pixel(32, 24)?, [51, 102, 204, 255]);
//!
//! // Every number of that pixel, from the mesh's corners to its four bytes:
//! let numbers = trace::trace_draw(&call, [64, 48], DepthFormat::F32, trace::Probe::Pixel(32, 24))?;
//! assert!(numbers.to_string().contains("51 102 204 255 = #3366cc at FBptr[6272]\n"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # A video memory that other programs draw into
//!
//! Clients use all of this through [`command::Command`]s, as text on a socket or as values in the
//! same process:
//!
//! ```
//! # #[cfg(feature = "server")] {
//! use fbptr::{Finish, RenderThread};
//!
//! let thread = RenderThread::new(64, 48)?;
//! let client = thread.client();
//! client.line([0, 0], [63, 47], [255, 255, 0, 255]);
//! assert_eq!(client.snapshot()?.get_pixel(0, 0)?, [255, 255, 0, 255]);
//! thread.finish(Finish::Now);
//! # }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Modules that only the program needs are public, but hidden here and free to change. Cargo keeps
//! the order of the crates, `tests/cli/layers.rs` that of the parts inside them.
#![forbid(unsafe_code)]
#![deny(missing_docs)]
// `unwrap` is for tests: code says why a value cannot be missing.
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

#[doc(inline)]
pub use fbptr_command as command;
#[doc(hidden)]
pub use fbptr_command::framebuffer;
pub use fbptr_command::framebuffer::{DrawReport, DrawState, Drawable, Framebuffer, InvisibleDraw};
pub use fbptr_core::{
    Camera, CancelToken, Executor, Geometry, Level, Light, Material, Mesh, Renderer, Rgba, Scene, ThreadPool,
    VideoMemory, glam,
};
#[doc(hidden)]
pub use fbptr_core::{cancel, executor, input, math, simd};
#[doc(inline)]
pub use fbptr_core::{draw2d, error, eye, memory, pipeline, scene};
#[cfg(fbptr_preload)]
#[doc(hidden)]
pub use fbptr_desktop::fbdev;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub use fbptr_desktop::viewer;
#[cfg(feature = "window")]
#[doc(hidden)]
pub use fbptr_desktop::window;
#[cfg(feature = "window")]
pub use fbptr_desktop::window::{FrameInput, WindowError, program::run};
#[doc(hidden)]
pub use fbptr_formats::animation;
#[doc(inline)]
pub use fbptr_formats::{load, models, save};
#[cfg(feature = "cli")]
#[doc(hidden)]
pub use fbptr_lab as measure;
#[cfg(feature = "server")]
#[doc(hidden)]
pub use fbptr_server as server;
#[cfg(feature = "server")]
pub use fbptr_server::{Client, Finish, RenderThread};
#[cfg(feature = "server")]
#[doc(hidden)]
pub use fbptr_truth as truth;

#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;

/// Compiles the README's examples as doc tests.
#[cfg(all(doctest, feature = "server"))]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;

/// Compiles the examples of the page about the library as doc tests.
#[cfg(all(doctest, feature = "server", feature = "window"))]
#[doc = include_str!("../docs/library.md")]
struct LibraryExamples;
