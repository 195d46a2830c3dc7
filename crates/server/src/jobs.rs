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
//! - At most [`MAX_THREADS`] jobs run at a time, on threads that are started when first needed.
//!   Each connection has at most one in the queue, and its inputs are within the payload limit.
//!   Memory for all of them is reserved from a budget before the inputs are captured.
//! - A job that exceeds the time limit ([`super::Limits::command_time`], counted from when it
//!   begins to run) is cancelled, its command is refused with `EQUOTA`, and its result is dropped.
//!   So are jobs that are unfinished when the server ends.
//!
//! An error here would show as a reply out of order, or as a recording whose replay draws other
//! bytes (`tests/serving/fairness.rs`).

use super::message::{Id, Message};
use crossbeam_channel::{Receiver, Sender, unbounded};
use fbptr_core::cancel::CancelToken;
use fbptr_core::error::{Code, Fault};
use fbptr_engine::engine::{Job, JobResult};
use fbptr_engine::workers::DRAW_STACK_BYTES;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// Number of jobs that run at a time: more than a small machine has cores, so that long jobs of a
/// few clients leave room for those of others.
const MAX_THREADS: usize = 4;

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
    connection: Id,
    ticket: Ticket,
    job: Job,
}

/// The worker threads. When the pool is dropped, they end after the jobs that are queued.
pub(crate) struct JobPool {
    queue: Sender<Task>,
    tasks: Receiver<Task>,
    messages: Sender<Message>,
    threads: usize,
    /// Number of tasks that are queued or running.
    unfinished: Arc<AtomicUsize>,
    next: u64,
}

impl JobPool {
    /// Creates a pool without threads, whose workers will send results to `messages`.
    pub fn new(messages: Sender<Message>) -> Self {
        let (queue, tasks) = unbounded();
        JobPool { queue, tasks, messages, threads: 0, unfinished: Arc::default(), next: 0 }
    }

    /// Submits a job to the workers. One that takes longer than `limit` is given up, whether or not
    /// it has ended before anyone has looked.
    ///
    /// # Errors
    /// Returns the job if the system has no thread to give.
    pub fn submit(&mut self, connection: Id, job: Job, limit: Option<Duration>) -> Result<Ticket, Job> {
        let busy = self.unfinished.fetch_add(1, Ordering::Relaxed);
        if busy >= self.threads && self.threads < MAX_THREADS && self.start_thread().is_ok() {
            self.threads += 1;
        }
        if self.threads == 0 {
            self.unfinished.fetch_sub(1, Ordering::Relaxed);
            return Err(job);
        }
        self.next += 1;
        let ticket = Ticket { number: self.next, cancel: CancelToken::new(), begun: Arc::default(), limit };
        match self.queue.send(Task { connection, ticket: ticket.clone(), job }) {
            Ok(()) => Ok(ticket),
            // Unreachable: the pool holds a receiver itself.
            Err(refused) => Err(refused.into_inner().job),
        }
    }

    fn start_thread(&self) -> std::io::Result<()> {
        let (tasks, messages, unfinished) =
            (self.tasks.clone(), self.messages.clone(), self.unfinished.clone());
        let work = move || {
            for Task { connection, ticket, job } in tasks {
                if ticket.cancel.is_cancelled() {
                    unfinished.fetch_sub(1, Ordering::Relaxed);
                    continue;
                }
                let _ = ticket.begun.set(Instant::now());
                let mut result = job.run_guarded(&ticket.cancel);
                if ticket.until().is_some_and(|until| Instant::now() > until) {
                    result = ticket.given_up();
                }
                unfinished.fetch_sub(1, Ordering::Relaxed);
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
