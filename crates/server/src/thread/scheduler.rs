//! The render thread's loop: receives messages, gives each connection its slice, and does the
//! periodic work between slices.
//!
//! In: messages, input of the display, readable sockets. Out: replies, notices and frames; the
//! engine at the end. Runs on the render thread. Promises that messages are received before each
//! slice, so those of one connection take effect in order, and that a panic ends one connection
//! only. Tested by `tests/serving/fairness.rs`.

mod input;
mod periodic;
mod run_queue;

use super::connection::{ClosingConnection, Connection, UNREAD_BYTES};
use super::{ROUND_TIME, SLICE_BYTES, SLICE_TIME};
use crate::buffer_pool::BufferPool;
use crate::jobs::JobPool;
use crate::message::{Batch, Finish, Id, Message};
use crate::transport::InlineReader;
use crate::{Budget, Display, DisplayObserver, Engine, Input, Output, Pace, StreamState};
use crossbeam_channel::{Receiver, Sender, never};
use fbptr_core::cancel::CancelToken;
use run_queue::Step;
use std::collections::{HashMap, VecDeque};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Capacity of the reply buffer that is kept after a connection has ended.
const KEPT_REPLY_BYTES: usize = 64 << 10;

/// Most bytes of a connection that may always wait, however little memory is left: a new client is
/// answered while others hold all of it. They are a small part of the 64 KiB that each connection
/// takes beside the budget.
const SHORT_REQUEST_BYTES: u64 = 4 << 10;

/// Slice time after which interactive sockets are polled again, and how many are read at once.
const INTERACTIVE_EVERY: Duration = Duration::from_micros(50);
const INTERACTIVE_AT_ONCE: usize = 16;

pub(super) struct Scheduler {
    engine: Engine,
    messages: Receiver<Message>,
    sender: Sender<Message>,
    /// The window's side of the display, if there is one.
    display: Option<Arc<Display>>,
    inputs: Receiver<Input>,
    connections: HashMap<Id, Connection>,
    /// Runnable connections, in the order of their slices.
    run_queue: VecDeque<Id>,
    /// Runnable interactive connections, which have little to run. They get every other slice at
    /// most.
    interactive_queue: VecDeque<Id>,
    was_interactive: bool,
    /// Connections that wait for a frame to be shown.
    awaiting_frame: Vec<Id>,
    /// Connections that pause for a time.
    paused: Vec<Id>,
    /// The unfinished step of a paused display.
    step: Option<Step>,
    closing: Vec<ClosingConnection>,
    /// The pool of read buffers; and the number of connections with queued work in buffers of their
    /// own.
    buffers: Arc<BufferPool>,
    slow: usize,
    /// Reads sockets on this thread.
    inline_reader: InlineReader,
    /// Time of the slices since interactive sockets were last polled.
    ran_since: Duration,
    /// Stream bytes that were received and have not run.
    queued_bytes: u64,
    output: Output,
    jobs: JobPool,
    /// Connections that wait for a job.
    awaiting_job: Vec<Id>,
    /// Time at which the first of their jobs may be over its time limit.
    jobs_until: Option<Instant>,
    /// The connection whose command is in pieces; the others may only run queries.
    in_pieces: Option<Id>,
    idle_scanned_at: Instant,
    metrics_at: Instant,
    /// Set when something has happened since the last update of the metrics.
    metrics_are_stale: bool,
    finish: Option<Finish>,
}

impl Scheduler {
    pub fn new(
        engine: Engine,
        messages: Receiver<Message>,
        sender: Sender<Message>,
        buffers: Arc<BufferPool>,
        inline_reader: InlineReader,
    ) -> Self {
        let display = engine.observer::<DisplayObserver>().map(|observer| observer.display().clone());
        let inputs = display.as_ref().map_or_else(never, |display| display.inputs());
        let jobs = JobPool::new(sender.clone());
        Scheduler {
            engine,
            messages,
            sender,
            display,
            inputs,
            connections: HashMap::new(),
            run_queue: VecDeque::new(),
            interactive_queue: VecDeque::new(),
            was_interactive: false,
            awaiting_frame: Vec::new(),
            paused: Vec::new(),
            step: None,
            closing: Vec::new(),
            buffers,
            slow: 0,
            inline_reader,
            ran_since: Duration::ZERO,
            queued_bytes: 0,
            output: Output::default(),
            jobs,
            awaiting_job: Vec::new(),
            jobs_until: None,
            in_pieces: None,
            idle_scanned_at: Instant::now(),
            metrics_at: Instant::now(),
            metrics_are_stale: true,
            finish: None,
        }
    }

    pub fn run(mut self) -> Engine {
        loop {
            // Everything that has arrived must be handled before the thread may sleep.
            self.receive_all();
            self.run_due_work();
            if self.is_over() {
                return self.end();
            }
            self.read_interactive();
            match self.next_slice() {
                Some((id, pace)) => {
                    self.inline_reader.pass_on(Some(id));
                    self.run_slice(id, pace);
                }
                None => self.wait(),
            }
        }
    }

    fn is_over(&self) -> bool {
        match self.finish {
            None => false,
            Some(Finish::Now) => true,
            Some(Finish::WhenAllEnded) => self.connections.is_empty() && self.messages.is_empty(),
            Some(Finish::By(time)) => {
                let is_done = |c: &Connection| c.is_idle() && !c.is_ending();
                Instant::now() >= time || (self.connections.values().all(is_done) && self.messages.is_empty())
            }
        }
    }

    /// Receives all queued messages. Each connection can have only a few in flight, so this ends.
    fn receive_all(&mut self) {
        while let Ok(message) = self.messages.try_recv() {
            self.receive(message);
        }
        while let Ok(input) = self.inputs.try_recv() {
            self.input(input);
        }
    }

    fn receive(&mut self, message: Message) {
        self.metrics_are_stale = true;
        match message {
            Message::Open(id, opening) => {
                self.engine.open(id);
                let mut connection = Connection::new(&self.engine, id, *opening);
                if matches!(self.finish, Some(Finish::By(_))) {
                    connection.stop_reading();
                }
                self.connections.insert(id, connection);
            }
            Message::Bytes(id, batch) => self.receive_bytes(id, batch),
            Message::Payload(id, payload) => self.with(id, |c| c.add_payload(payload)),
            Message::End(id, end) => self.with(id, |c| c.add_end(end)),
            Message::Mail(id) => self.with(id, Connection::add_mail),
            Message::Room(id) => self.with(id, Connection::note_room),
            Message::JobDone(id, number, result) => self.with(id, |c| c.job_done(number, *result)),
            #[cfg(feature = "web")]
            Message::Event(event) => self.input(Input::Event(event)),
            Message::Do(task) => task(&mut self.engine),
            Message::NoDisplay => {
                self.engine.detach::<DisplayObserver>();
                (self.display, self.inputs) = (None, never());
            }
            Message::Finish(how) => {
                self.finish = Some(how);
                if matches!(how, Finish::By(_)) {
                    self.connections.values_mut().for_each(Connection::stop_reading);
                }
            }
        }
    }

    /// Queues bytes of a connection. Does nothing if it has ended.
    fn receive_bytes(&mut self, id: Id, mut batch: Batch) {
        let Some(connection) = self.connections.get(&id) else { return };
        let available = self.engine.memory_budget().available();
        if self.slow > 0 && !has_room(available, batch.filled as u64, connection.queued_bytes) {
            return self.give_up(id);
        }
        self.queued_bytes += batch.filled as u64;
        // The connection's slice may be long in coming: others could use the buffer meanwhile.
        if self.slow > 0 {
            batch.unpool_from(0);
            self.engine.quotas.count_queue(self.queued_bytes);
        }
        self.with(id, |c| {
            c.add_bytes(batch);
            c.release_buffers();
        });
    }

    /// Ends a connection for whose bytes no memory is left, with an error line.
    fn give_up(&mut self, id: Id) {
        let Some(mut connection) = self.connections.remove(&id) else { return };
        let limit = self.engine.memory_budget().limit();
        let message = format!("ERR 0 0 EQUOTA CONNECT: all of the {limit} bytes of memory are in use\n");
        connection.reply(&mut message.into_bytes(), usize::MAX, &self.sender);
        self.slow -= usize::from(connection.is_slow);
        self.in_pieces = self.in_pieces.filter(|other| *other != id);
        self.engine.set_in_pieces(self.in_pieces.is_some());
        self.queued_bytes -= connection.queued_bytes;
        self.engine.quotas.count_queue(self.queued_bytes);
        self.closing.extend(connection.close(&mut self.engine));
    }

    /// Applies `action` to a connection and queues it if it is runnable. Does nothing if the
    /// connection has ended.
    fn with(&mut self, id: Id, action: impl FnOnce(&mut Connection)) {
        if let Some(connection) = self.connections.get_mut(&id) {
            action(connection);
            if connection.is_runnable() && !connection.is_queued {
                connection.is_queued = true;
                let queue = if connection.is_interactive() {
                    &mut self.interactive_queue
                } else {
                    &mut self.run_queue
                };
                queue.push_back(id);
            }
        }
    }

    fn input(&mut self, input: Input) {
        match input {
            Input::Look => self.display.iter().for_each(|d| d.answer_probe(self.engine.depth())),
            Input::Event(event) => {
                let limit = self.engine.limits().reply_bytes;
                for connection in self.connections.values_mut() {
                    let limit = limit.min(self.engine.quotas.reply_room(connection.unread()));
                    if connection.stream.session().events {
                        connection.push_event(&event, limit, &self.sender);
                    }
                }
            }
        }
    }

    fn run_slice(&mut self, id: Id, pace: Pace) {
        self.engine.counters.queue_bytes = self.queued_bytes;
        self.metrics_are_stale = true;
        let Some(connection) = self.connections.get_mut(&id) else { return };
        connection.is_queued = false;
        let queued_before = connection.queued_bytes;
        let limit = self.engine.limits().reply_bytes;
        let unread = connection.unread();
        let most = limit.min(UNREAD_BYTES).saturating_sub(unread);
        let reply_bytes = most.min(self.engine.quotas.reply_room(unread)).max(1);
        let now = Instant::now();
        let others =
            u32::try_from(self.run_queue.len() + self.interactive_queue.len() + self.buffers.ready())
                .unwrap_or(u32::MAX);
        let time = (ROUND_TIME / others.saturating_add(1)).clamp(SLICE_TIME / 10, SLICE_TIME);
        let suspends = pace == Pace::Free;
        let only_asks = self.in_pieces.is_some_and(|other| other != id);
        let command_time = Some(self.engine.limits().command_time);
        let budget = Budget { until: Some(now + time), reply_bytes, pace, suspends, only_asks, command_time };
        self.engine.begin_slice(now);
        let mut state = StreamState::Yields;
        if connection.is_runnable() {
            // A panic outside of what the engine guards is a defect, too; it ends this connection,
            // not the server.
            let run = || connection.run(&mut self.engine, SLICE_BYTES, budget, &mut self.output);
            state = catch_unwind(AssertUnwindSafe(run)).unwrap_or(StreamState::Ended);
        }
        if !only_asks {
            self.in_pieces = Some(id).filter(|_| connection.is_in_pieces && state != StreamState::Ended);
            self.engine.set_in_pieces(self.in_pieces.is_some());
        }
        if let Some(job) = self.output.job.take() {
            let limit = connection.job_limit(self.engine.limits().command_time);
            match self.jobs.submit(id, job, limit) {
                Ok(ticket) => {
                    connection.wait_for_job(ticket);
                    if !self.awaiting_job.contains(&id) {
                        self.awaiting_job.push(id);
                    }
                    self.jobs_until = Some(now);
                }
                // The system has no thread to give: the job runs here, and all connections wait.
                Err(job) => connection.add_result(job.run_guarded(&CancelToken::default())),
            }
        }
        let run_bytes = queued_before - connection.queued_bytes;
        self.queued_bytes -= run_bytes;
        self.engine.quotas.count_queue(self.queued_bytes);
        let took = now.elapsed();
        connection.last_slice = took;
        self.ran_since += took;
        self.engine.count(connection.stream.session_mut());
        if !self.output.replies.is_empty() {
            self.engine.before_replies();
        }
        connection.reply(&mut self.output.replies, limit, &self.sender);
        self.slow -= usize::from(connection.is_slow);
        connection.is_slow = state != StreamState::Ended && connection.release_buffers();
        self.slow += usize::from(connection.is_slow);
        if state == StreamState::Ended {
            self.end_connection(id);
        } else {
            if matches!(state, StreamState::WaitsFor(_)) {
                self.awaiting_frame.push(id);
            }
            self.begin_pause(id, state, pace);
            self.with(id, |_| ());
        }
        if pace != Pace::Free {
            self.engine.show();
        }
        // A step takes as many slices and batches as it needs; it is over, too, when its connection
        // ends.
        let is_over =
            |step: &Step| !self.connections.contains_key(&step.id) || self.shown_version() > step.before;
        if self.step.as_ref().is_some_and(is_over) {
            self.step = None;
        }
    }

    /// Makes a connection wait for the time that it has asked for. Without a window nobody sees the
    /// pause, and a step is no place for one.
    fn begin_pause(&mut self, id: Id, state: StreamState, pace: Pace) {
        if let (StreamState::Pauses(time), Pace::Free, true) = (state, pace, self.display.is_some())
            && let Some(connection) = self.connections.get_mut(&id)
        {
            connection.paused_until = Some(Instant::now() + time);
            self.paused.push(id);
        }
    }

    fn end_connection(&mut self, id: Id) {
        if let Some(connection) = self.connections.remove(&id) {
            self.queued_bytes -= connection.queued_bytes;
            self.closing.extend(connection.close(&mut self.engine));
            // The capacity that one client's replies needed is not kept for the others.
            self.output.replies.shrink_to(KEPT_REPLY_BYTES);
        }
    }

    /// Closes all connections, waits for the last replies while there is time, and ends the engine.
    fn end(mut self) -> Engine {
        let until = match self.finish {
            Some(Finish::By(time)) => time + Duration::from_millis(300),
            Some(Finish::Now) => Instant::now() + Duration::from_millis(300),
            // Without a deadline the last replies may take as long as their readers do.
            _ => Instant::now() + Duration::from_secs(1 << 32),
        };
        for (_, connection) in self.connections.drain() {
            self.closing.extend(connection.close(&mut self.engine));
        }
        for mut closing in self.closing.drain(..) {
            closing.reply_queue.wait_done(until);
            closing.port.abort();
        }
        self.engine.set_cancel(CancelToken::default());
        self.engine.end();
        self.engine
    }
}

/// Returns whether there is memory for a batch of a connection with `queued` bytes of earlier ones.
fn has_room(available: u64, batch: u64, queued: u64) -> bool {
    batch <= available || queued + batch <= SHORT_REQUEST_BYTES
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_requests_have_room_though_no_memory_is_left() {
        assert!(has_room(1 << 20, 1 << 20, 1 << 30) && !has_room((1 << 20) - 1, 1 << 20, 0));
        assert!(has_room(0, 6, 0) && has_room(0, 6, SHORT_REQUEST_BYTES - 6));
        assert!(!has_room(0, SHORT_REQUEST_BYTES + 1, 0) && !has_room(0, 6, SHORT_REQUEST_BYTES - 5));
    }
}
