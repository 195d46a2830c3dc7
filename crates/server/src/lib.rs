//! The render server: render thread, sessions, and the transports that connect clients to it.
//!
//! In: commands as bytes of sockets, pipes and files, or as values from the same process. Out:
//! replies, frames on the display, snapshots, recordings, metrics. [`RenderThread`] alone owns the
//! [`Engine`] and the video memory; all other threads send it messages.
#![forbid(unsafe_code)]
#![deny(missing_docs)]
// `unwrap` is for tests: code says why a value cannot be missing.
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

/// The engine, whose sessions and streams this crate feeds.
pub use fbptr_engine::{
    Audience, Budget, CommandError, Dialect, Effect, Engine, Limits, Notice, Output, OutputState,
    OutputStatus, Pace, Resource, ResourceKind, ResourceTable, Session, Stats, Status, Step, Stream,
    StreamState, figure_numbers, figure_steps, stated_size, worker_pool,
};

mod admission;
mod buffer_pool;
mod client;
mod display;
mod events;
mod http;
mod jobs;
mod machine_memory;
mod message;
mod metrics;
mod on_present;
mod playback;
mod player;
mod record;
mod replay;
mod reply_queue;
mod serve;
mod shared_file;
mod snapshots;
mod sniff;
mod thread;
mod transport;
#[cfg(feature = "web")]
mod web;

pub use admission::RefusedConnections;
pub use client::Client;
pub use display::{Display, DisplayObserver, EventSender, PixelInfo, ShownFrame};
pub use events::Input;
pub use machine_memory::default_memory_bytes;
pub use message::Finish;
pub use metrics::{Metrics, MetricsBoard, MetricsServer, Reading, VerbCounts};
pub use on_present::OnPresent;
pub use playback::Playback;
pub use player::Player;
pub use record::{RECORD_MAGIC, RecordFile, Recorder, recorded_size};
pub use serve::{Server, TooFewDescriptors};
pub use shared_file::FileSharing;
pub use snapshots::utc_fields;
pub use snapshots::{PeriodicSnapshots, SnapshotPlan};
pub use thread::{RenderThread, SLICE_BYTES, SLICE_TIME};
pub use transport::{ListenAddress, ListenError, Listener};
#[cfg(feature = "web")]
pub use web::{WebFeed, WebObserver, WebOptions, WebServer, WebTokens};
