//! The render server: render thread, sessions, and the transports that connect clients to it.
//!
//! In: commands as bytes of sockets, pipes and files, or as values from the same process. Out:
//! replies, frames on the display, snapshots, recordings, metrics. [`RenderThread`] alone owns the
//! [`Engine`] and the video memory; all other threads send it messages.
#![cfg_attr(not(feature = "server"), allow(dead_code, reason = "threads and transports use the rest"))]

#[cfg(feature = "server")]
mod admission;
mod budget;
#[cfg(feature = "server")]
mod buffer_pool;
#[cfg(feature = "server")]
mod client;
mod clock;
#[cfg(feature = "server")]
mod display;
pub mod engine;
mod engine_frame;
#[cfg(feature = "server")]
mod events;
#[cfg(feature = "server")]
mod http;
#[cfg(feature = "server")]
mod jobs;
mod limits;
#[cfg(feature = "server")]
mod machine_memory;
#[cfg(feature = "server")]
mod message;
#[cfg(feature = "server")]
mod metrics;
#[cfg(feature = "server")]
mod on_present;
#[cfg(feature = "cli")]
mod playback;
#[cfg(feature = "server")]
mod player;
mod read_files;
#[cfg(feature = "server")]
mod record;
#[cfg(feature = "server")]
mod replay;
#[cfg(feature = "server")]
mod reply_queue;
mod resources;
#[cfg(feature = "server")]
mod serve;
mod session;
#[cfg(feature = "server")]
mod shared_file;
mod snapshot_names;
#[cfg(feature = "server")]
mod snapshots;
#[cfg(feature = "server")]
mod sniff;
mod stats;
mod stream;
mod surfaces;
#[cfg(feature = "server")]
mod thread;
#[cfg(feature = "server")]
mod transport;
#[cfg(feature = "web")]
mod web;
#[cfg(feature = "server")]
mod workers;

#[cfg(feature = "server")]
pub use admission::RefusedConnections;
pub use budget::{Budget, Pace};
#[cfg(feature = "server")]
pub use client::Client;
#[cfg(feature = "server")]
pub use display::{Display, DisplayObserver, EventSender, PixelInfo, ShownFrame};
pub use engine::{Dialect, Effect, Engine, OutputState, OutputStatus, Status};
#[cfg(feature = "server")]
pub use events::Input;
pub use limits::Limits;
#[cfg(feature = "server")]
pub use machine_memory::default_memory_bytes;
#[cfg(feature = "server")]
pub use message::Finish;
#[cfg(feature = "server")]
pub use metrics::{Metrics, MetricsBoard, MetricsServer, Reading, VerbCounts};
#[cfg(feature = "server")]
pub use on_present::OnPresent;
#[cfg(feature = "cli")]
pub(crate) use playback::Playback;
#[cfg(feature = "server")]
pub use player::Player;
#[cfg(feature = "server")]
pub use record::{RECORD_MAGIC, RecordFile, Recorder, recorded_size};
pub use resources::{Resource, ResourceKind, ResourceTable};
#[cfg(feature = "server")]
pub use serve::{Server, TooFewDescriptors};
pub use session::{Audience, Session};
#[cfg(feature = "server")]
pub use shared_file::FileSharing;
#[cfg(feature = "cli")]
pub(crate) use snapshots::utc_fields;
#[cfg(feature = "server")]
pub use snapshots::{PeriodicSnapshots, SnapshotPlan};
pub use stats::Stats;
pub use stream::{CommandError, Notice, Output, Stream, StreamState, stated_size};
#[cfg(feature = "server")]
pub use thread::{RenderThread, SLICE_BYTES, SLICE_TIME};
#[cfg(feature = "server")]
pub use transport::{ListenAddress, ListenError, Listener};
#[cfg(feature = "web")]
pub use web::{WebFeed, WebObserver, WebOptions, WebServer, WebTokens};
#[cfg(feature = "server")]
pub use workers::worker_pool;
