//! The worker threads of jobs: the parts of long commands that do not touch the video memory.
//!
//! In: a [`Job`] that `Engine::begin` has made of a command. Its inputs are captured (payloads
//! moved, names resolved to `Arc`s, the frame copied), so that it needs neither the engine nor the
//! session. Out: a `JobResult`, which is sent to the render thread and applied there: only then
//! do resources, video memory, replies and the recording change.
//!
//! Promises:
//! - The connection is suspended meanwhile, so that its commands take effect in order and its
//!   replies keep that order. Other connections continue.
//! - A command uses the shared resources that its names stand for when it takes effect. If a job
//!   has used one that was redefined meanwhile, it is run again.
//! - A small job (`is_small`: some 100 us, judged by its inputs) runs on the render thread at once.
//! - Jobs run on threads that are started when first needed, up to [`queue::MOST`]; `queue` says which
//!   is next, and how many at a time: connections share the threads by time.
//!   Each connection has at most one in the queue, and its inputs are within the payload limit.
//!   Memory for all of them is reserved from a budget before the inputs are captured.
//! - A job that exceeds the time limit ([`super::Limits::command_time`], counted from when it
//!   begins to run) is cancelled, its command is refused with `EQUOTA`, and its result is dropped.
//!   So are jobs that are unfinished when the server ends.
//!
//! An error here would show as a reply out of order, or as a recording whose replay draws other
//! bytes (`tests/serving/fairness.rs`).

mod queue;

use super::message::{Id, Message};
use crossbeam_channel::Sender;
use fbptr_core::cancel::CancelToken;
use fbptr_core::error::{Code, Fault};
use fbptr_engine::engine::{Job, JobResult};
use fbptr_engine::workers::DRAW_STACK_BYTES;
use queue::Queue;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// A connection's handle on a submitted job.
#[derive(Clone, Debug)]
pub(crate) struct Ticket {
    /// Unique number of the job.
    pub number: u64,
    cancel: CancelToken,
    begun: Arc<OnceLock<Instant>>,
    limit: Option<Duration>,
}

impl Ticket {
    /// Returns the time at which a worker began the job.
    pub fn begun(&self) -> Option<Instant> {
        self.begun.get().copied()
    }

    /// Returns the time at which the job exceeds its limit, if it has begun and has one.
    pub fn until(&self) -> Option<Instant> {
        self.begun()?.checked_add(self.limit?)
    }

    /// Returns whether the job may be given up.
    pub fn has_limit(&self) -> bool {
        self.limit.is_some()
    }

    /// Returns the result of a job that has exceeded its time limit.
    pub fn given_up(&self) -> JobResult {
        let limit = self.limit.unwrap_or_default().as_secs_f64();
        JobResult::refused(Fault::new(Code::Quota, format!("given up after {limit} s, without effect")))
    }

    /// Asks the work to end; its result will be dropped.
    pub fn cancel(&self) {
        self.cancel.cancel();
    }
}

struct Task {
    ticket: Ticket,
    job: Job,
}

/// State that the threads share.
#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    /// Signals the threads that a job was added or has ended, or that the pool was dropped.
    changed: Condvar,
}

#[derive(Default)]
struct State {
    queue: Queue<Task>,
    /// Number of threads that wait for a job.
    idle: usize,
    /// Set once the pool was dropped.
    has_ended: bool,
}

impl Shared {
    /// Returns the state. The threads hold plain lists, so any state of them is valid.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for the job that begins next; `None` once the pool was dropped and no job waits.
    fn next(&self) -> Option<(Id, Task)> {
        let mut state = self.state();
        loop {
            if let Some(next) = state.queue.next(Instant::now()) {
                if state.queue.waiting() > 0 {
                    // Another thread looks after the others.
                    self.changed.notify_one();
                }
                return Some(next);
            }
            if state.has_ended && state.queue.waiting() == 0 {
                return None;
            }
            // A job that may not begin yet may do so once those that run are long ones.
            let time = if state.queue.waiting() > 0 { queue::LONG } else { Duration::from_secs(3600) };
            state.idle += 1;
            let waited = self.changed.wait_timeout(state, time);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
            state.idle -= 1;
        }
    }

    /// Counts the job of a connection as ended.
    fn end(&self, connection: Id) {
        self.state().queue.end(connection, Instant::now());
        self.changed.notify_one();
    }
}

/// The worker threads. When the pool is dropped, they end after the jobs that are queued.
pub(crate) struct JobPool {
    shared: Arc<Shared>,
    messages: Sender<Message>,
    threads: usize,
    next: u64,
}

impl JobPool {
    /// Creates a pool without threads, whose workers will send results to `messages`.
    pub fn new(messages: Sender<Message>) -> Self {
        JobPool { shared: Arc::default(), messages, threads: 0, next: 0 }
    }

    /// Submits a job to the workers. One that takes longer than `limit` is given up, whether or not
    /// it has ended before anyone has looked.
    ///
    /// # Errors
    /// Returns the job if the system has no thread to give.
    pub fn submit(&mut self, connection: Id, job: Job, limit: Option<Duration>) -> Result<Ticket, Job> {
        let needs_thread = {
            let state = self.shared.state();
            state.queue.waiting() >= state.idle
        };
        if needs_thread && self.threads < queue::MOST && self.start_thread().is_ok() {
            self.threads += 1;
        }
        if self.threads == 0 {
            return Err(job);
        }
        self.next += 1;
        let ticket = Ticket { number: self.next, cancel: CancelToken::new(), begun: Arc::default(), limit };
        self.shared.state().queue.push(connection, Task { ticket: ticket.clone(), job });
        self.shared.changed.notify_one();
        Ok(ticket)
    }

    fn start_thread(&self) -> std::io::Result<()> {
        let (shared, messages) = (self.shared.clone(), self.messages.clone());
        let work = move || {
            while let Some((connection, Task { ticket, job })) = shared.next() {
                if ticket.cancel.is_cancelled() {
                    shared.end(connection);
                    continue;
                }
                let _ = ticket.begun.set(Instant::now());
                let mut result = job.run_guarded(&ticket.cancel);
                if ticket.until().is_some_and(|until| Instant::now() > until) {
                    result = ticket.given_up();
                }
                shared.end(connection);
                // The result of a cancelled job is dropped here, since no connection waits for it;
                // that is also the case if the render thread has ended.
                if !ticket.cancel.is_cancelled() {
                    let _ = messages.send(Message::JobDone(connection, ticket.number, Box::new(result)));
                }
            }
        };
        std::thread::Builder::new()
            .name("fbptr-job".into())
            .stack_size(DRAW_STACK_BYTES)
            .spawn(work)
            .map(drop)
    }
}

impl Drop for JobPool {
    fn drop(&mut self) {
        self.shared.state().has_ended = true;
        self.shared.changed.notify_all();
    }
}
