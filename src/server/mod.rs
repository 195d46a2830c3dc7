//! THE RENDER THREAD, sessions, transports.

mod client;
mod display;
pub mod engine;
mod events;
mod jobs;
mod limits;
mod machine_memory;
mod names;
mod outbox;
mod player;
mod record;
mod serve;
mod session;
mod stats;
mod stream;
mod thread;
mod transport;
mod workers;

pub use client::Client;
pub use display::{Display, EventSender, PixelInfo, ShownFrame};
pub use engine::{Effect, Engine};
pub use events::{Input, InputEvent};
pub use limits::Limits;
pub use machine_memory::default_memory_bytes;
pub use names::{Kind, Names, Resource};
pub use player::Player;
pub use record::{RECORD_MAGIC, RecordFile, Recorder, recorded_size};
pub use serve::{Server, TooFewDescriptors};
pub use session::{Audience, Session};
pub use stats::Stats;
pub use stream::{Budget, Complaint, Notice, Output, Pace, Standing, Stream};
pub use thread::{Finish, RenderThread, SLICE_BYTES, SLICE_TIME};
pub use transport::{ListenError, ListenPlace, Listener};
pub use workers::worker_pool;
