//! The screen: windows, the viewer of files, and the framebuffer device of foreign programs.
//!
//! | module | contents |
//! |---|---|
//! | [`viewer`] | a file seen from everywhere: a state machine from keys, pointer and time to pictures |
//! | `window` | frames on the screen, of a server, of the viewer or of a program; alone knows minifb |
//! | `fbdev` | the emulated `/dev/fb0` of `fbptr run`: its shared memories, scan-out, input devices |
#![forbid(unsafe_code)]
#![deny(missing_docs)]
// `unwrap` is for tests: code says why a value cannot be missing.
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

#[cfg(fbptr_preload)]
pub mod fbdev;
pub mod viewer;
#[cfg(feature = "window")]
pub mod window;
