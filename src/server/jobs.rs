//! JOBS: the parts of long commands that need nothing of the video memory, done on worker threads.
//!
//! In: a [`Job`] that `Engine::begin` has made of a command: its inputs are captured (payloads moved, names resolved to
//! `Arc`s, the frame copied), so that it needs neither the engine nor the session. Out: a [`JobResult`], which goes back
//! to the render thread as a message and is applied there: only then do names, memory, replies and the recording change.
//!
//! Promises:
//! - The connection is suspended meanwhile: its later commands wait, so that its commands take effect in order and its
//!   replies keep that order. Other connections go on.
//! - A command takes effect with what its shared names stand for when it takes effect. Where a job has used one that was
//!   redefined meanwhile, it is done again.
//! - A small job (`is_small`: some 100 us by its inputs) is done on the render thread at once.
//! - At most [`MAX_THREADS`] jobs run at a time, started when first needed; each connection has at most one in the
//!   queue, whose inputs are bounded by the limit of payloads. A budget of memory for all of them is asked where the job
//!   is made, before its inputs are captured.
//! - A job past the limit of time ([`super::Limits::command_time`], counted from when it begins to run) is cancelled, its
//!   command refused with `EQUOTA` and its result dropped when it comes. The same happens when the server ends.
//!
//! One would know an error by a reply out of order, or by a recording whose replay gives other bytes
//! (`tests/serving/fairness.rs`).

use super::engine::{FileReader, Progress};
use super::record::ReadFile;
use super::thread::message::{Id, Message};
use super::workers::DRAW_STACK_BYTES;
use super::{Engine, Session};
use crate::cancel::CancelToken;
use crate::command::Command;
use crate::error::{Code, Fault};
use crossbeam_channel::{Receiver, Sender, unbounded};
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

/// Jobs that run at one time. More than the machine has cores, so that long ones of a few clients leave room for others'.
const MAX_THREADS: usize = 4;

/// What a job leaves to do on the render thread.
pub(crate) type Apply =
    Box<dyn FnOnce(&mut Engine, &mut Session, &mut Vec<u8>) -> Result<Progress, Fault> + Send>;

type Work = Box<dyn FnOnce(&CancelToken) -> JobResult + Send>;

/// The work of one command.
pub(crate) struct Job {
    is_small: bool,
    work: Work,
}

/// What came of a job.
pub(crate) struct JobResult {
    /// The command as it is recorded; `None` where it was refused.
    pub(super) command: Option<Command>,
    pub(super) apply: Result<Apply, Fault>,
    /// The files that it has read, for the recording.
    pub(super) files: Vec<ReadFile>,
}

impl JobResult {
    /// A command that is refused.
    pub fn refused(fault: Fault) -> Self {
        JobResult { command: None, apply: Err(fault), files: Vec::new() }
    }

    /// `command` takes effect by `apply`, unless the work was refused.
    pub(super) fn new<A>(command: Command, apply: Result<A, Fault>) -> Self
    where
        A: FnOnce(&mut Engine, &mut Session, &mut Vec<u8>) -> Result<Progress, Fault> + Send + 'static,
    {
        match apply {
            Ok(apply) => JobResult { command: Some(command), apply: Ok(Box::new(apply)), files: Vec::new() },
            Err(fault) => JobResult::refused(fault),
        }
    }

    /// The same with the files that the work has read.
    pub(super) fn with_files(self, reader: Option<FileReader>) -> Self {
        JobResult { files: reader.map(FileReader::into_read).unwrap_or_default(), ..self }
    }
}

impl Job {
    pub(super) fn new(is_small: bool, work: impl FnOnce(&CancelToken) -> JobResult + Send + 'static) -> Self {
        Job { is_small, work: Box::new(work) }
    }

    /// Whether handing it to another thread costs more than doing it.
    pub fn is_small(&self) -> bool {
        self.is_small
    }

    /// Does the work on the calling thread.
    pub fn run(self, cancel: &CancelToken) -> JobResult {
        (self.work)(cancel)
    }

    /// The same; a panic, which is a defect, refuses the command.
    fn run_guarded(self, cancel: &CancelToken) -> JobResult {
        let refused = |_| {
            let message = "this command met a defect of the server, and was given up";
            JobResult::refused(Fault::new(Code::Format, message))
        };
        catch_unwind(AssertUnwindSafe(|| self.run(cancel))).unwrap_or_else(refused)
    }
}

impl fmt::Debug for Job {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Job({})", if self.is_small { "small" } else { "large" })
    }
}

impl fmt::Debug for JobResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "JobResult({})", if self.apply.is_ok() { "made" } else { "refused" })
    }
}

/// A job that was handed to the workers, as its connection sees it.
#[derive(Clone, Debug)]
pub(crate) struct Ticket {
    /// No other job has it.
    pub number: u64,
    cancel: CancelToken,
    begun: Arc<OnceLock<Instant>>,
}

impl Ticket {
    /// When a worker took it up.
    pub fn begun(&self) -> Option<Instant> {
        self.begun.get().copied()
    }

    /// Asks the work to end; its result is of no use any more.
    pub fn cancel(&self) {
        self.cancel.cancel();
    }
}

struct Task {
    connection: Id,
    ticket: Ticket,
    job: Job,
}

/// The worker threads. Dropping it lets them end when they have done what they are at.
pub(crate) struct JobPool {
    queue: Sender<Task>,
    tasks: Receiver<Task>,
    messages: Sender<Message>,
    threads: usize,
    /// Tasks in the queue or at work.
    unfinished: Arc<AtomicUsize>,
    next: u64,
}

impl JobPool {
    /// Workers, none started yet, that send results to `messages`.
    pub fn new(messages: Sender<Message>) -> Self {
        let (queue, tasks) = unbounded();
        JobPool { queue, tasks, messages, threads: 0, unfinished: Arc::default(), next: 0 }
    }

    /// Hands a job to the workers.
    ///
    /// # Errors
    /// The job itself, where the system has no thread to give.
    pub fn submit(&mut self, connection: Id, job: Job) -> Result<Ticket, Job> {
        let busy = self.unfinished.fetch_add(1, Ordering::Relaxed);
        if busy >= self.threads && self.threads < MAX_THREADS && self.start_thread().is_ok() {
            self.threads += 1;
        }
        if self.threads == 0 {
            self.unfinished.fetch_sub(1, Ordering::Relaxed);
            return Err(job);
        }
        self.next += 1;
        let ticket = Ticket { number: self.next, cancel: CancelToken::new(), begun: Arc::default() };
        match self.queue.send(Task { connection, ticket: ticket.clone(), job }) {
            Ok(()) => Ok(ticket),
            // Never: this holds a receiver itself.
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
                let result = job.run_guarded(&ticket.cancel);
                unfinished.fetch_sub(1, Ordering::Relaxed);
                // Nobody waits for a result that was given up: what it holds is dropped here. Nor does a render thread
                // that is gone.
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
