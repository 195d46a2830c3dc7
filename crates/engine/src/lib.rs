//! The engine: runs streams of commands on a video memory, on the calling thread.
//!
//! In: commands as bytes or values, each from the [`Session`] of its connection. Out: changed memory,
//! reply bytes, and events for the engine's observers. It has every verb and the error budget, and
//! needs no thread: it also runs as WebAssembly.
#![forbid(unsafe_code)]
#![deny(missing_docs)]
// `unwrap` is for tests: code says why a value cannot be missing.
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

mod budget;
pub mod clock;
pub mod engine;
pub mod engine_frame;
pub mod limits;
pub mod read_files;
pub mod resources;
pub mod session;
pub mod snapshot_names;
mod stats;
pub mod stream;
pub mod surfaces;
#[cfg(feature = "threads")]
pub mod workers;

pub use budget::{Budget, Pace};
pub use engine::{
    Dialect, Effect, Engine, OutputState, OutputStatus, Status, Step, figure_numbers, figure_steps,
};
pub use limits::Limits;
pub use resources::{Resource, ResourceKind, ResourceTable};
pub use session::{Audience, Session};
pub use stats::Stats;
pub use stream::{CommandError, Notice, Output, Stream, StreamState, stated_size};
#[cfg(feature = "threads")]
pub use workers::worker_pool;
