//! The state of an engine in numbers, for `STATS` and for the metrics.
//!
//! In: the engine's counters and sizes, and what its observers add. Out: plain values.

use super::Engine;
use crate::server::Stats;

/// State of an output of the server.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OutputState {
    /// There is none.
    #[default]
    Off,
    /// Everything has been written so far.
    On,
    /// It has ended early.
    Failed,
}

impl OutputState {
    /// All states and their names in the metrics.
    pub const ALL: [(OutputState, &'static str); 3] =
        [(OutputState::Off, "off"), (OutputState::On, "on"), (OutputState::Failed, "failed")];

    /// Returns the word of `STATS`.
    pub(super) fn word(self) -> &'static str {
        match self {
            OutputState::Off => "off",
            OutputState::On => "ok",
            OutputState::Failed => "failed",
        }
    }
}

/// State of an engine and of its observers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// Counters of all connections, up to the last slice of each.
    pub totals: Stats,
    /// Number of open connections.
    pub connections: usize,
    /// Number of connections closed for being idle.
    pub idle_closes: u64,
    /// Number of connections refused because they spoke HTTP or TLS.
    pub foreign_refused: u64,
    /// Bytes of the frame.
    pub frame_bytes: u64,
    /// Bytes of the depth buffer.
    pub depth_bytes: u64,
    /// Bytes of the pick buffer.
    pub id_bytes: u64,
    /// Limit of the memory budget, in bytes.
    pub memory_limit_bytes: u64,
    /// Bytes in use of the memory budget.
    pub memory_used_bytes: u64,
    /// Bytes of the shared resources.
    pub shared_resource_bytes: u64,
    /// Bytes of the files that `SNAP` wrote.
    pub snap_bytes: u64,
    /// State of the shared file.
    pub shared_file: OutputState,
    /// State of the recording.
    pub recording: OutputState,
    /// Bytes of the recording that have been written.
    pub recorded_bytes: u64,
    /// Bytes of the recording that have not been written.
    pub record_queue_bytes: u64,
}

impl Engine {
    /// Returns the state of the engine and of its observers.
    pub fn status(&self) -> Status {
        let [depth_bytes, id_bytes] = self.framebuffer.depth_and_id_bytes();
        let mut status = Status {
            totals: self.counters.totals,
            connections: self.counters.connections,
            idle_closes: self.counters.idle_closes,
            foreign_refused: self.counters.foreign_refused,
            frame_bytes: self.framebuffer.memory.bytes().len() as u64,
            depth_bytes,
            id_bytes,
            memory_limit_bytes: self.quotas.budget.limit(),
            memory_used_bytes: self.quotas.budget.used(),
            shared_resource_bytes: self.resources.shared.size_bytes(),
            snap_bytes: self.resources.snap_dir.as_ref().map_or(0, |folder| folder.used_bytes()),
            ..Status::default()
        };
        self.observers.iter().for_each(|observer| observer.status(&mut status));
        status
    }
}
