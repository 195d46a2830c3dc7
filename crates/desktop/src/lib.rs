//! The screen: windows, the viewer of files, and the framebuffer device of foreign programs.
//!
//! | module | contents |
//! |---|---|
//! | [`viewer`] | a file seen from everywhere: a state machine from keys, pointer and time to pictures |
//! | `window` | frames on the screen, of a server, of the viewer or of a program; alone knows minifb |
//! | `fbdev` | the emulated `/dev/fb0` of `fbptr run`: its shared memories, scan-out, input devices |
#![forbid(unsafe_code)]
#![warn(missing_docs)]
// `unwrap` is for tests: code says why a value cannot be missing.
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

pub(crate) use fbptr_core::{draw2d, executor, eye, input, memory, pipeline, scene, simd};
pub(crate) use fbptr_formats::{load, save};
pub(crate) use fbptr_command::framebuffer;
pub(crate) use {fbptr_command as command, fbptr_server as server, fbptr_truth as truth};

#[cfg(fbptr_preload)]
pub mod fbdev;
pub mod viewer;
#[cfg(feature = "window")]
pub mod window;
