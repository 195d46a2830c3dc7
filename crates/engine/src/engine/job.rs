//! A job: the part of a long command that touches neither the video memory nor the session.

use super::dispatch::{defect, guard};
use super::{Engine, FileReader, Progress};
use crate::read_files::ReadFile;
use crate::session::Session;
use fbptr_command::Command;
use fbptr_core::cancel::CancelToken;
use fbptr_core::error::Fault;
use std::fmt;

/// The part of a job's command that is left to do on the render thread.
pub(crate) type Apply =
    Box<dyn FnOnce(&mut Engine, &mut Session, &mut Vec<u8>) -> Result<Progress, Fault> + Send>;

type Work = Box<dyn FnOnce(&CancelToken) -> JobResult + Send>;

/// The work of one command on a worker thread.
pub struct Job {
    is_small: bool,
    work: Work,
}

/// Result of a job.
pub struct JobResult {
    /// The command as observers see it, and the rest of it, unless it was refused.
    pub(super) made: Result<(Command, Apply), Fault>,
    /// The files that it has read, if they were kept.
    pub(super) files: Vec<ReadFile>,
}

impl JobResult {
    /// Creates the result of a refused command.
    pub fn refused(fault: Fault) -> Self {
        JobResult { made: Err(fault), files: Vec::new() }
    }

    /// Creates the result of `command`, which takes effect by `apply` unless the work was refused.
    pub(crate) fn new<A>(command: Command, apply: Result<A, Fault>) -> Self
    where
        A: FnOnce(&mut Engine, &mut Session, &mut Vec<u8>) -> Result<Progress, Fault> + Send + 'static,
    {
        let made = apply.map(|apply| (command, Box::new(apply) as Apply));
        JobResult { made, files: Vec::new() }
    }

    /// Adds the files that the work has read.
    pub(crate) fn with_files(self, reader: Option<FileReader>) -> Self {
        JobResult { files: reader.map(FileReader::into_read).unwrap_or_default(), ..self }
    }
}

impl Job {
    pub(crate) fn new(is_small: bool, work: impl FnOnce(&CancelToken) -> JobResult + Send + 'static) -> Self {
        Job { is_small, work: Box::new(work) }
    }

    /// Returns whether handing it to another thread costs more than running it here.
    pub fn is_small(&self) -> bool {
        self.is_small
    }

    /// Runs the job on the calling thread.
    pub(super) fn run(self, cancel: &CancelToken) -> JobResult {
        (self.work)(cancel)
    }

    /// Runs the job; a panic, which is a defect, refuses the command.
    pub fn run_guarded(self, cancel: &CancelToken) -> JobResult {
        guard(|| self.run(cancel)).unwrap_or_else(|| JobResult::refused(defect()))
    }
}

impl fmt::Debug for Job {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Job({})", if self.is_small { "small" } else { "large" })
    }
}

impl fmt::Debug for JobResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "JobResult({})", if self.made.is_ok() { "made" } else { "refused" })
    }
}
