//! Periodic work of the render thread between slices: that of the engine's observers, ending jobs
//! that are over their time limit, closing idle and finished connections, updating metrics.
//!
//! In: the time. Out: the state with all due work done, and the time of the next deadline. Runs on
//! the render thread. Promises that each kind of work costs one comparison while none is due.
//! Tested by `tests/serving/quotas.rs` (idle clients), and `metrics.rs` and `fairness.rs` (jobs)
//! beside it.

use super::Scheduler;
use crate::VerbCounts;
use crate::message::{Finish, Id};
use crate::metrics;
use crate::thread::connection::{ClosingConnection, Connection};
use crate::thread::{CLOSE_WITHIN, HANG_UP_WITHIN, IDLE_SCAN_EVERY};
use std::time::{Duration, Instant};

impl Scheduler {
    /// Does the work between slices: updates the engine's observers, closes connections that have
    /// ended.
    pub(super) fn run_due_work(&mut self) {
        let now = Instant::now();
        self.engine.tick(now);
        self.answer_shown();
        self.end_pauses(now);
        if !self.awaiting_job.is_empty() && self.jobs_until.is_none_or(|until| now >= until) {
            self.check_jobs(now);
        }
        self.close_idle(now);
        self.update_metrics(now);
        self.closing.retain_mut(|l| !is_gone(l, now));
    }

    /// Cancels jobs that are over their time limit.
    fn check_jobs(&mut self, now: Instant) {
        let mut next: Option<Instant> = None;
        for id in std::mem::take(&mut self.awaiting_job) {
            let mut until = None;
            self.with(id, |c| until = c.check_job(now));
            if let Some(until) = until {
                next = Some(next.map_or(until, |n| n.min(until)));
                self.awaiting_job.push(id);
            }
        }
        self.jobs_until = next;
    }

    /// Closes the connections that were idle for longer than the limit. All connections are scanned
    /// once a second, so receiving bytes costs no more than setting a flag.
    fn close_idle(&mut self, now: Instant) {
        let Some(timeout) = self.engine.limits().idle_timeout else { return };
        if now < self.idle_scanned_at + IDLE_SCAN_EVERY {
            return;
        }
        self.idle_scanned_at = now;
        let is_timed_out = |(&id, c): (&Id, &mut Connection)| c.is_timed_out(now, timeout).then_some(id);
        let idle: Vec<Id> = self.connections.iter_mut().filter_map(is_timed_out).collect();
        for id in idle {
            if let Some(connection) = self.connections.get_mut(&id) {
                self.slow -= usize::from(std::mem::take(&mut connection.is_slow));
                let limit = self.engine.limits().reply_bytes;
                let mut farewell = connection.timeout_line(timeout).into_bytes();
                connection.reply(&mut farewell, limit, &self.sender);
            }
            self.engine.counters.idle_closes += 1;
            self.end_connection(id);
        }
    }

    /// Answers the connections whose frame has been shown, and makes them runnable.
    fn answer_shown(&mut self) {
        let limit = self.engine.limits().reply_bytes;
        for id in std::mem::take(&mut self.awaiting_frame) {
            let Some(connection) = self.connections.get_mut(&id) else { continue };
            match connection.waits_for {
                Some(frame) if !self.engine.is_shown(frame) => self.awaiting_frame.push(id),
                Some(_) => {
                    connection.frame_is_shown(&self.engine, &mut self.output);
                    connection.reply(&mut self.output.replies, limit, &self.sender);
                    self.with(id, |_| ());
                }
                None => {}
            }
        }
    }

    /// Makes connections runnable whose pause is over. While half of the places are taken, the pauses
    /// of clients that send nothing more are over at once: they may be gone, and others need the
    /// places.
    fn end_pauses(&mut self, now: Instant) {
        let is_crowded = self.connections.len() > self.engine.limits().connections / 2;
        for id in std::mem::take(&mut self.paused) {
            let Some(connection) = self.connections.get_mut(&id) else { continue };
            match connection.paused_until {
                Some(until)
                    if now < until
                        && self.display.is_some()
                        && !(is_crowded && connection.has_ended_input()) =>
                {
                    self.paused.push(id);
                }
                _ => self.with(id, |c| c.paused_until = None),
            }
        }
    }

    /// Returns the time of the next metrics update: soon if something has happened, and every few
    /// seconds in any case, so that old metrics mean a busy thread.
    fn metrics_due_at(&self) -> Instant {
        let period = if self.metrics_are_stale { metrics::UPDATE_EVERY } else { metrics::REFRESH_EVERY };
        self.metrics_at + period
    }

    /// Updates the metrics if that is due and there is a board to write them to.
    fn update_metrics(&mut self, now: Instant) {
        if now < self.metrics_due_at() {
            return;
        }
        let Some(counts) = self.engine.observer::<VerbCounts>() else { return };
        let connections = || self.connections.values();
        let is_updated = counts.board().update(now, |m| {
            m.engine = self.engine.status();
            counts.copy_to(&mut m.verbs);
            m.queue_bytes = self.queued_bytes;
            m.reply_bytes = connections().map(|c| c.unread() as u64).sum();
            m.private_resource_bytes =
                connections().map(|c| metrics::resource_bytes(c.stream.session())).sum();
        });
        // If a reader held the board, the update is tried again a moment later.
        if is_updated {
            (self.metrics_at, self.metrics_are_stale) = (now, false);
        }
    }

    pub(super) fn next_deadline(&mut self) -> Option<Instant> {
        let mut deadline = self.engine.next_deadline(Instant::now());
        let pool_sweep = self.engine.quotas.sweep_payload_pool(Instant::now());
        let mut at = |time: Instant| deadline = Some(deadline.map_or(time, |d| d.min(time)));
        pool_sweep.into_iter().for_each(&mut at);
        if !self.awaiting_job.is_empty() {
            self.jobs_until.into_iter().for_each(&mut at);
        }
        let paused = self.paused.iter().filter_map(|id| self.connections.get(id)?.paused_until);
        paused.for_each(&mut at);
        if !self.closing.is_empty() {
            at(Instant::now() + Duration::from_millis(100));
        }
        if self.engine.limits().idle_timeout.is_some() && !self.connections.is_empty() {
            at(self.idle_scanned_at + IDLE_SCAN_EVERY);
        }
        if self.engine.observer::<VerbCounts>().is_some() {
            // If an update is due and the board is being read, it is tried again after a
            // millisecond.
            at(self.metrics_due_at().max(Instant::now() + Duration::from_millis(1)));
        }
        if let Some(Finish::By(time)) = self.finish {
            at(time);
        }
        deadline
    }
}

/// Returns whether a closing connection can be dropped. Aborts it if its client takes too long.
fn is_gone(closing: &mut ClosingConnection, now: Instant) -> bool {
    if closing.port.is_gone() {
        return true;
    }
    let pending = closing.reply_queue.pending();
    if pending != closing.pending {
        (closing.pending, closing.since) = (pending, now);
    }
    let patience = if closing.reply_queue.is_done() { HANG_UP_WITHIN } else { CLOSE_WITHIN };
    let is_late = now >= closing.since + patience;
    if is_late {
        closing.port.abort();
    }
    is_late
}
