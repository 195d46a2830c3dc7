//! Metrics of a running server, for monitoring systems.
//!
//! In: counters of the render thread, a few times a second; those of commands by verb are kept by an
//! observer of the engine, [`VerbCounts`]. Out: `/metrics` in Prometheus' text format and
//! `/metrics.json`, from a thread of its own ([`MetricsServer`]). Promise: the render thread never
//! blocks here; it updates the values if no reader is copying them, and otherwise at its next slice.
//! An error would show in `fbptr_snapshot_age_seconds`.

mod format;
mod http;

pub use http::MetricsServer;

use super::admission::{Admission, RefusedConnections};
use fbptr_command::Verb;
use fbptr_engine::engine::{Event, FrameView, Observer, Status};
use fbptr_engine::session::Session;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Shortest time between two updates of the values.
pub(super) const UPDATE_EVERY: Duration = Duration::from_millis(250);
/// Longest time between two updates while the thread is not busy.
pub(super) const REFRESH_EVERY: Duration = Duration::from_secs(5);

/// Values of the metrics at one moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metrics {
    /// State of the engine and of its observers.
    pub engine: Status,
    /// Bytes received that have not run.
    pub queue_bytes: u64,
    /// Bytes of replies that clients have not read.
    pub reply_bytes: u64,
    /// Bytes of all connections' own resources.
    pub private_resource_bytes: u64,
    /// Number of commands by verb, in the order of [`Verb::all`]. Decoded commands that were then
    /// refused count, too.
    pub verbs: Vec<u64>,
}

/// The latest values, which the render thread writes and the metrics server reads.
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

/// The latest values, with those that do not come from the render thread.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Time since the board was created, which is when the server started.
    pub uptime: Duration,
    /// Time since the values were updated.
    pub age: Duration,
    /// Numbers of refused connections.
    pub refused: RefusedConnections,
    /// Values of the render thread.
    pub metrics: Metrics,
}

impl MetricsBoard {
    /// Creates a board whose values are zero.
    pub fn new() -> Arc<MetricsBoard> {
        let started = Instant::now();
        let metrics = Metrics { verbs: vec![0; Verb::all().len()], ..Metrics::default() };
        let latest = Mutex::new(Latest { at: started, metrics });
        Arc::new(MetricsBoard { started, latest, admission: OnceLock::new() })
    }

    pub(super) fn set_admission(&self, admission: Arc<Admission>) {
        // A board belongs to one server, so this is the first call.
        let _ = self.admission.set(admission);
    }

    /// Updates the values at `now`, unless they are being read. Returns whether it did.
    pub fn update(&self, now: Instant, fill: impl FnOnce(&mut Metrics)) -> bool {
        let Ok(mut latest) = self.latest.try_lock() else { return false };
        latest.at = now;
        fill(&mut latest.metrics);
        true
    }

    /// Returns a copy of the latest values.
    pub fn read(&self) -> Reading {
        // The counters are valid even if a thread panicked while it held the lock.
        let latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        let (at, metrics) = (latest.at, latest.metrics.clone());
        drop(latest);
        let refused = self.admission.get().map(|admission| admission.refused()).unwrap_or_default();
        Reading { uptime: self.started.elapsed(), age: at.elapsed(), refused, metrics }
    }

    /// Returns the latest values as one line of JSON.
    #[cfg(feature = "web")]
    pub(super) fn json(&self) -> String {
        format::json(&self.read())
    }
}

/// Counts an engine's commands by verb, for a board.
#[derive(Debug)]
pub struct VerbCounts {
    board: Arc<MetricsBoard>,
    counts: Vec<u64>,
}

impl VerbCounts {
    /// Creates the counts, which are zero.
    pub fn new(board: Arc<MetricsBoard>) -> Self {
        VerbCounts { board, counts: vec![0; Verb::all().len()] }
    }

    /// Returns the board.
    pub fn board(&self) -> &Arc<MetricsBoard> {
        &self.board
    }

    pub(super) fn copy_to(&self, verbs: &mut Vec<u64>) {
        verbs.clone_from(&self.counts);
    }
}

impl Observer for VerbCounts {
    fn event(&mut self, event: &Event<'_>, _: FrameView<'_>) {
        if let Event::Received(request) = event
            && let Some(count) = Verb::index_of(request.verb()).and_then(|i| self.counts.get_mut(i))
        {
            *count += request.count() as u64;
        }
    }
}

/// Returns the bytes of a connection's own resources.
pub(super) fn resource_bytes(session: &Session) -> u64 {
    session.names.size_bytes() + session.surfaces.bytes()
}
