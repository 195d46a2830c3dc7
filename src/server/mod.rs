//! The render server: render thread, sessions, and the transports that connect clients to it.
//!
//! In: commands as bytes of sockets, pipes and files, or as values from the same process. Out:
//! replies, frames on the display, snapshots, recordings, metrics. [`RenderThread`] alone owns the
//! [`Engine`] and the video memory; all other threads send it messages.

mod admission;
mod budget;
mod buffer_pool;
mod client;
mod display;
pub mod engine;
mod engine_frame;
mod events;
mod jobs;
mod limits;
mod machine_memory;
mod message;
mod metrics;
mod on_present;
mod player;
mod read_files;
mod record;
mod replay;
mod reply_queue;
mod resources;
mod serve;
mod session;
mod shared_file;
mod snapshot_names;
mod snapshots;
mod sniff;
mod stats;
mod stream;
mod surfaces;
mod thread;
mod transport;
mod workers;

pub use admission::RefusedConnections;
pub use budget::{Budget, Pace};
pub use client::Client;
pub use display::{Display, DisplayObserver, EventSender, PixelInfo, ShownFrame};
pub use engine::{Dialect, Effect, Engine, OutputState, OutputStatus, Status};
pub use events::Input;
pub use limits::Limits;
pub use machine_memory::default_memory_bytes;
pub use message::Finish;
pub use metrics::{Metrics, MetricsBoard, MetricsServer, Reading, VerbCounts};
pub use on_present::OnPresent;
pub use player::Player;
pub use record::{RECORD_MAGIC, RecordFile, Recorder, recorded_size};
pub use resources::{Resource, ResourceKind, ResourceTable};
pub use serve::{Server, TooFewDescriptors};
pub use session::{Audience, Session};
pub use shared_file::FileSharing;
pub use snapshots::{PeriodicSnapshots, SnapshotPlan};
pub use stats::Stats;
pub use stream::{CommandError, Notice, Output, Stream, StreamState};
pub use thread::{RenderThread, SLICE_BYTES, SLICE_TIME};
pub use transport::{ListenAddress, ListenError, Listener};
pub use workers::worker_pool;
