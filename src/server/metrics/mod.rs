//! Metrics: what a running server says of itself to a monitoring system.
//!
//! In: counters of the render thread, a few times a second. Out: `/metrics` in Prometheus' text format and `/metrics.json`,
//! from a thread of its own ([`MetricsServer`]). Promise: the render thread never waits here; it fills in the latest
//! values when nobody is copying them, and otherwise at its next turn. How one would know: `fbptr_snapshot_age_seconds`.

mod format;
mod http;

pub use http::MetricsServer;

use super::transport::{Admission, RefusedConnections};
use super::{Session, Stats};
use crate::command::{Command, Verb};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Between two updates of the latest values.
pub(super) const UPDATE_EVERY: Duration = Duration::from_millis(250);
/// The same where nothing happens.
pub(super) const REFRESH_EVERY: Duration = Duration::from_secs(5);

/// Whether the server records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RecordingState {
    /// It was not asked to.
    #[default]
    Off,
    /// All is written so far.
    On,
    /// The recording has ended early.
    Failed,
}

impl RecordingState {
    /// All states with their names.
    pub const ALL: [(RecordingState, &'static str); 3] =
        [(RecordingState::Off, "off"), (RecordingState::On, "on"), (RecordingState::Failed, "failed")];
}

/// Values at one moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metrics {
    /// What all connections did, as far as their turns have ended.
    pub totals: Stats,
    /// Open connections.
    pub connections: usize,
    /// Connections closed for being idle.
    pub idle_closes: u64,
    /// Connections that spoke HTTP or TLS.
    pub foreign_refused: u64,
    /// Bytes received and not run.
    pub queue_bytes: u64,
    /// Bytes of replies that clients have not read.
    pub reply_bytes: u64,
    /// Bytes of the frame.
    pub frame_bytes: u64,
    /// Bytes of the depth buffer.
    pub depth_bytes: u64,
    /// Bytes of the face numbers for `PICK`.
    pub id_bytes: u64,
    /// The memory budget.
    pub memory_limit_bytes: u64,
    /// Bytes charged to it.
    pub memory_used_bytes: u64,
    /// Bytes of the shared resources.
    pub shared_resource_bytes: u64,
    /// Bytes of all connections' own resources.
    pub private_resource_bytes: u64,
    /// Whether the server records.
    pub recording: RecordingState,
    /// Bytes of the recording in its file.
    pub recorded_bytes: u64,
    /// Bytes of the recording that wait to be written.
    pub record_queue_bytes: u64,
    /// Bytes of the files that `SNAP` wrote.
    pub snap_bytes: u64,
    /// Commands by verb, in the order of [`Verb::all`]; refused ones that the decoder understood included.
    pub verbs: Vec<u64>,
}

/// The latest values, and where they go.
#[derive(Debug)]
pub struct MetricsBoard {
    started: Instant,
    latest: Mutex<Latest>,
    admission: OnceLock<Arc<Admission>>,
}

#[derive(Debug)]
struct Latest {
    at: Instant,
    metrics: Metrics,
}

/// The latest values with what is known without the render thread.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Since the board was made, which is when the server started.
    pub uptime: Duration,
    /// How old the values are.
    pub age: Duration,
    /// Connections that were refused.
    pub refused: RefusedConnections,
    /// The values.
    pub metrics: Metrics,
}

impl MetricsBoard {
    /// A board without values.
    pub fn new() -> Arc<MetricsBoard> {
        let started = Instant::now();
        let metrics = Metrics { verbs: vec![0; Verb::all().len()], ..Metrics::default() };
        let latest = Mutex::new(Latest { at: started, metrics });
        Arc::new(MetricsBoard { started, latest, admission: OnceLock::new() })
    }

    pub(super) fn set_admission(&self, admission: Arc<Admission>) {
        // A board belongs to one server.
        let _ = self.admission.set(admission);
    }

    /// Fills in the values at `now`, unless they are being read. Whether it did.
    pub fn update(&self, now: Instant, fill: impl FnOnce(&mut Metrics)) -> bool {
        let Ok(mut latest) = self.latest.try_lock() else { return false };
        latest.at = now;
        fill(&mut latest.metrics);
        true
    }

    /// A copy of the latest values.
    pub fn read(&self) -> Reading {
        // Counters are whole at any time.
        let latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        let (at, metrics) = (latest.at, latest.metrics.clone());
        drop(latest);
        let refused = self.admission.get().map(|admission| admission.refused()).unwrap_or_default();
        Reading { uptime: self.started.elapsed(), age: at.elapsed(), refused, metrics }
    }
}

/// Commands by verb; nothing is counted before [`VerbCounts::enable`].
#[derive(Debug, Default)]
pub(super) struct VerbCounts {
    counts: Vec<u64>,
}

impl VerbCounts {
    pub fn enable(&mut self) {
        self.counts.resize(Verb::all().len(), 0);
    }

    /// Counts a command.
    #[inline]
    pub fn command(&mut self, command: &Command) {
        if !self.counts.is_empty() {
            self.add(command.verb(), 1);
        }
    }

    /// Counts `count` commands of a verb, for those that come without a [`Command`].
    #[inline]
    pub fn many(&mut self, verb: &'static str, count: usize) {
        if !self.counts.is_empty() {
            self.add(verb, count as u64);
        }
    }

    #[inline(never)]
    fn add(&mut self, verb: &'static str, count: u64) {
        if let Some(slot) = Verb::index_of(verb).and_then(|index| self.counts.get_mut(index)) {
            *slot += count;
        }
    }

    pub fn copy_to(&self, verbs: &mut Vec<u64>) {
        verbs.clone_from(&self.counts);
    }
}

/// Bytes of a connection's own resources.
pub(super) fn resource_bytes(session: &Session) -> u64 {
    session.names.size_bytes()
}
