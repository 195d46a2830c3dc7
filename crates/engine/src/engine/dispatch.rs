//! The door of the engine: what all requests have in common, and the dispatch of commands.
//!
//! In: a request and its session, the result of its job, or its pieces. Out: its effect and its
//! reply, or a fault. Each request is counted here, once; the limit of replies, the counts of errors
//! and the events that let observers keep or undo what began stand here alone, for commands as for
//! batches of pixels.
//!
//! A panic in what a request does is a defect of the server. It refuses that request and no other:
//! observers are told that it is undone, then of the pixels and depths as they are now. A panic of
//! an observer is not caught here.

use super::job::JobResult;
use super::{Call, Effect, Engine, Event, Outcome, Pieces, Progress, Request};
use crate::read_files::ReadFile;
use crate::{Budget, Session};
use fbptr_command::{Command, Figure};
use fbptr_core::cancel::CancelToken;
use fbptr_core::error::{Code, Fault};
use std::panic::{AssertUnwindSafe, catch_unwind};

impl Engine {
    /// Runs one command of `session` to its end. Replies are appended to `replies`, which is left
    /// as it was on an error.
    ///
    /// # Errors
    /// The reason for which the command was refused; it has then changed nothing.
    pub fn run(
        &mut self,
        session: &mut Session,
        command: Command,
        replies: &mut Vec<u8>,
    ) -> Result<Effect, Fault> {
        (self.may_suspend, self.queues_draw) = (false, false);
        let mut progress = self.begin(session, Request::Command(command), replies)?;
        loop {
            match progress {
                Progress::Done(effect) => return Ok(effect),
                Progress::Job(job) => {
                    let result = job.run_guarded(&CancelToken::default());
                    progress = self.apply(session, result, replies)?;
                }
                Progress::Pieces(pieces) => {
                    progress = self.run_pieces(session, *pieces, replies, Budget::NONE)?
                }
                Progress::Queued(drawing) => progress = self.draw_now(session, drawing)?,
            }
        }
    }

    /// Runs one request of `session`, or the part of it that comes before its job or its pieces.
    /// Inlined, so that a batch is dispatched where it is known.
    ///
    /// # Errors
    /// See [`Engine::run`].
    #[inline]
    pub(crate) fn begin(
        &mut self,
        session: &mut Session,
        request: Request<'_>,
        replies: &mut Vec<u8>,
    ) -> Result<Progress, Fault> {
        session.stats.commands += request.count() as u64;
        session.has_used_other_verbs |= !request.is_pixelflut();
        self.send(&Event::Received(&request));
        self.follow_request(session, &request);
        let request = match request {
            Request::Command(command) if self.may_suspend && self.is_long_on_surface(session, &command) => {
                match self.begin_in_pieces(session, command) {
                    Ok(pieces) => return Ok(Progress::Pieces(Box::new(pieces))),
                    Err(command) => Request::Command(command),
                }
            }
            request => request,
        };
        let start = replies.len();
        let has_begun = !request.is_made_by_job();
        if has_begun {
            self.send_begin(session, &request);
        }
        // The verb matters on other surfaces than the frame alone.
        let verb = if cfg!(test) || !session.surfaces.are_plain() { request.verb() } else { "" };
        let result = self.on_surface(session, verb, |engine, session| {
            engine.guarded(|engine| {
                let result = engine.dispatch(session, request, replies);
                #[cfg(debug_assertions)]
                engine.meet_defect(verb);
                result
            })
        });
        self.end_request(session, has_begun, result, &[], replies, start)
    }

    /// Estimates the nanoseconds of a figure that can be drawn at once, without what the door does for
    /// observers and traces: `None` if any of them follows figures, or if it may take so long that it is
    /// suspended.
    #[inline]
    pub(crate) fn quick_figure_ns(&mut self, s: &mut Session, figure: &Figure) -> Option<u64> {
        if self.has_followed_figures || self.follows_requests() {
            return None;
        }
        let ns = self.on_surface_of(s, figure, |engine, s| engine.figure_ns(s, figure));
        (!self.may_suspend || !Engine::is_long_ns(ns)).then_some(ns)
    }

    /// Draws a figure of which [`Engine::quick_figure_ns`] knows the time.
    ///
    /// # Errors
    /// See [`Engine::run`].
    #[inline]
    pub(crate) fn draw_quick(&mut self, s: &mut Session, figure: &Figure) -> Result<(), Fault> {
        s.stats.commands += 1;
        s.has_used_other_verbs = true;
        let result = self.on_surface_of(s, figure, |engine, s| {
            engine.guarded(|engine| {
                let result = engine.figure(s, figure);
                #[cfg(debug_assertions)]
                engine.meet_defect(figure.verb());
                Ok(result?)
            })
        });
        match result {
            Ok(()) => Ok(()),
            Err(fault) => self.end_request(s, false, Err(fault), &[], &mut Vec::new(), 0).map(drop),
        }
    }

    /// Runs a part of a figure on its surface.
    #[inline]
    fn on_surface_of<T>(
        &mut self,
        s: &mut Session,
        figure: &Figure,
        part: impl FnOnce(&mut Engine, &mut Session) -> T,
    ) -> T {
        let verb = if s.surfaces.are_plain() { "" } else { figure.verb() };
        self.on_surface(s, verb, part)
    }

    /// Returns whether a command may take long on the target and within the clip rectangle.
    #[inline]
    fn is_long_on_surface(&mut self, s: &mut Session, command: &Command) -> bool {
        let verb = if s.surfaces.are_plain() { "" } else { command.verb() };
        self.on_surface(s, verb, |engine, s| engine.is_long(s, command))
    }

    /// Counts a command that was refused before it could be a request: the decoder could not read it.
    pub fn count_refused(&mut self, session: &mut Session, is_pixelflut: bool) {
        session.stats.commands += 1;
        session.stats.errors += 1;
        session.has_used_other_verbs |= !is_pixelflut;
    }

    /// Applies the result of a command's job.
    ///
    /// # Errors
    /// See [`Engine::run`].
    pub(crate) fn apply(
        &mut self,
        session: &mut Session,
        result: JobResult,
        replies: &mut Vec<u8>,
    ) -> Result<Progress, Fault> {
        let JobResult { made, files } = result;
        let (start, has_begun) = (replies.len(), made.is_ok());
        let result = made.and_then(|(command, apply)| {
            let verb = command.verb();
            self.send_begin(session, &Request::Command(command));
            self.on_surface(session, verb, |engine, session| {
                engine.guarded(|engine| apply(engine, session, replies))
            })
        });
        self.end_request(session, has_begun, result, &files, replies, start)
    }

    /// Runs at least one piece of a command, and more until the budget's time is used up. Returns
    /// the rest of the command if it is not complete.
    ///
    /// # Errors
    /// The reason for which the command was refused or ended early.
    pub(crate) fn run_pieces(
        &mut self,
        session: &mut Session,
        mut pieces: Pieces,
        replies: &mut Vec<u8>,
        budget: Budget,
    ) -> Result<Progress, Fault> {
        let verb = pieces.verb();
        let is_done = self.on_surface(session, verb, |engine, session| {
            let is_done = engine.guarded(|engine| engine.advance(session, &mut pieces, budget));
            if engine.has_defect {
                engine.stop_pieces(&mut pieces);
            }
            is_done
        });
        if let Ok(false) = is_done {
            return Ok(Progress::Pieces(Box::new(pieces)));
        }
        if pieces.was_given_up() && session.surfaces.has_target() {
            self.reset_canvas(session);
        }
        let (start, has_begun) = (replies.len(), is_done.is_ok());
        let result = is_done.map(|_| {
            let end = |engine: &mut Engine, s: &mut Session| engine.end_pieces(s, pieces, replies);
            let request = self.on_surface(session, verb, end);
            self.send_begin(session, &request);
            Progress::Done(Effect::Done)
        });
        self.end_request(session, has_begun, result, &[], replies, start)
    }

    /// Runs a part of a request. A panic in it refuses the request.
    #[inline]
    pub(super) fn guarded<T>(
        &mut self,
        part: impl FnOnce(&mut Engine) -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        // Pixels that it has drawn stay. The memories hold plain numbers, so any state of them is
        // valid.
        match guard(|| part(self)) {
            Some(result) => result,
            None => Err(self.note_defect()),
        }
    }

    /// Notes that the running request met a defect. Returns its fault.
    #[cold]
    pub(super) fn note_defect(&mut self) -> Fault {
        self.has_defect = true;
        self.end_band();
        defect()
    }

    /// Panics if a test wants this verb to meet a defect.
    #[cfg(debug_assertions)]
    pub(super) fn meet_defect(&self, verb: &'static str) {
        assert_ne!(self.wanted_defect, Some(verb), "a defect for a test");
    }

    /// Sends observers the memories as a request has left them that met a defect: a part of it may
    /// be drawn.
    #[cold]
    fn send_after_defect(&mut self) {
        self.has_defect = false;
        self.send_rows(0..self.framebuffer.height());
        if self.framebuffer.depth.is_some() {
            self.discard_depths();
        }
    }

    /// Ends a request, or a part of it: checks the limit of replies, counts errors, and sends
    /// observers the end of what has begun.
    #[inline]
    pub(super) fn end_request(
        &mut self,
        session: &mut Session,
        has_begun: bool,
        mut result: Result<Progress, Fault>,
        files: &[ReadFile],
        replies: &mut Vec<u8>,
        start: usize,
    ) -> Result<Progress, Fault> {
        let length = replies.len() - start;
        if !matches!(result, Ok(Progress::Pieces(_))) {
            self.quotas.reply.shrink_to(0);
        }
        if let (true, Err(too_long)) = (result.is_ok(), self.quotas.check_reply_length(length as u64)) {
            result = Err(too_long);
        }
        if result.is_err() {
            replies.truncate(start);
            session.stats.errors += 1;
        }
        if has_begun {
            self.send_end(session, matches!(result, Ok(Progress::Done(_))), files);
        }
        if result.is_err() && self.has_defect {
            self.send_after_defect();
        }
        result
    }

    /// Runs a request, or creates its job.
    #[inline]
    #[expect(
        clippy::unit_arg,
        reason = "what a function returns becomes progress in one way, nothing included"
    )]
    fn dispatch(
        &mut self,
        s: &mut Session,
        request: Request<'_>,
        out: &mut Vec<u8>,
    ) -> Result<Progress, Fault> {
        match request {
            Request::Command(command) => {
                self.dispatch_command(&mut Call { session: s, replies: out }, command)
            }
            Request::Pixel { x, y, color } => self.framebuffer.moved_pixel(s, x, y, color).outcome(),
            Request::Pixels(records) => self.framebuffer.pixels(s, records).outcome(),
            Request::BinaryPixels(records) => self.framebuffer.binary_pixels(s, records).outcome(),
            Request::Lines(lines) => self.lines(s, lines).outcome(),
            Request::PixelRun { x, y, rgba } => self.framebuffer.pixel_run(s, x, y, rgba).outcome(),
            Request::Blit { rect, rgba } => self.framebuffer.blit(s, rect, rgba).outcome(),
            Request::Points(packed) => self.points(s, packed).outcome(),
        }
    }
}

/// Runs a part of a request, on whatever thread. Returns `None` if it panics, which is a defect.
#[inline]
pub(super) fn guard<T>(part: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(part)).ok()
}

/// Returns the fault of a request that met a defect.
pub(super) fn defect() -> Fault {
    Fault::new(Code::Format, "this command met a defect of the server, and was given up")
}

#[cfg(test)]
mod tests;
pub(super) mod verbs;

pub(super) use verbs::{is_made_by_job, is_pixelflut};
