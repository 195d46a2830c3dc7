//! Executor of decoded commands: pixels and lines in batches, other commands one by one, and
//! errors.
//!
//! In: calls of the decoder ([`Sink`]). Out: effects on the engine and the session, replies,
//! notices. Runs on the thread that has the engine. Promises that commands take effect in order. A
//! request that meets a defect of the server is refused by the engine, as any other error is.

use super::{CommandError, Notice, Output, Resume, StreamState, Suspended};
use crate::clock::Instant;
use crate::engine::{Drawing, MOST_AREAS, MOST_AREAS_NS, MOST_DRAWS, MOST_NS, Progress, QueuedArea, Request};
use crate::{Audience, Budget, Effect, Engine, Pace, Session};
use fbptr_command::{Command, Figure, Flow, Rect, Sink, StreamError, StreamPosition, format_fault};
use fbptr_core::cancel::CancelToken;
use fbptr_core::draw2d::Line;
use fbptr_core::error::Fault;
use fbptr_core::memory::{MAX_SIDE, Reservation, Rgba};

/// Runs the commands of one stream for one call of the decoder.
pub(super) struct CommandExecutor<'a> {
    engine: &'a mut Engine,
    pub(super) session: &'a mut Session,
    out: &'a mut Output,
    budget: Budget,
    pub(super) state: StreamState,
    /// The command that was suspended, if one was.
    pub(super) suspended: Option<Suspended>,
    /// Consecutive lines that are drawn in one batch, shared among all threads.
    lines: Vec<Line>,
    /// Pixels of these lines, at most.
    line_pixels: usize,
    /// Draws of small meshes that wait for others, with the places of their commands, and their
    /// estimated nanoseconds.
    draws: Vec<(Drawing, StreamPosition)>,
    draws_ns: u64,
    /// Estimated nanoseconds of the areas that wait in the engine.
    areas_ns: u64,
    /// Set if lines and small draws may wait for their neighbours.
    pub(super) batches: bool,
    /// Estimated nanoseconds of figures since the clock was last read.
    unclocked_ns: u64,
}

/// Estimated nanoseconds of figures after which the clock is read: reading it takes as long as a small
/// figure.
const CLOCKED_NS: u64 = 20_000;

/// Estimated nanoseconds to read a figure.
const READ_NS: u64 = 100;

/// Length of a `POINTS` list from which it is copied, so that it can run in pieces, if there is
/// memory for the copy.
const LONG_LIST_BYTES: usize = 1 << 21;

/// Most lines of one batch, and most pixels but for the last line: some hundred microseconds of work,
/// on a large canvas, where each pixel of a steep line is in a page of its own, some milliseconds.
const MAX_BATCHED_LINES: usize = 1024;
const MAX_BATCHED_PIXELS: usize = 1 << 17;

impl<'a> CommandExecutor<'a> {
    pub(super) fn new(
        engine: &'a mut Engine,
        session: &'a mut Session,
        out: &'a mut Output,
        budget: Budget,
    ) -> Self {
        engine.set_may_suspend(budget.suspends);
        CommandExecutor {
            engine,
            session,
            out,
            budget,
            state: StreamState::Ready,
            suspended: None,
            lines: Vec::new(),
            line_pixels: 0,
            draws: Vec::new(),
            draws_ns: 0,
            areas_ns: 0,
            batches: false,
            unclocked_ns: 0,
        }
    }

    /// Queues a line, which has no reply, so that it is drawn in one batch with its neighbours.
    fn enqueue(&mut self, line: Line) -> Flow {
        if self.lines.is_empty() {
            self.flush();
        }
        let axis = |i: usize| line.p0[i].abs_diff(line.p1[i]).min(MAX_SIDE) as usize;
        self.line_pixels += axis(0).max(axis(1));
        self.lines.push(line);
        if self.lines.len() < MAX_BATCHED_LINES && self.line_pixels < MAX_BATCHED_PIXELS {
            return Flow::Continue;
        }
        self.draw_lines();
        self.yield_if_due(false)
    }

    /// Draws a figure, or queues it if it is a line. Those that may take long, and all where something
    /// follows requests one by one, pass the engine's door as commands.
    fn draw_figure(&mut self, figure: Figure, place: StreamPosition) -> Flow {
        if let Figure::Line { p0, p1, color } = figure
            && self.batches
        {
            return self.enqueue(Line { p0, p1, color });
        }
        let Some(ns) = self.engine.quick_figure_ns(self.session, &figure) else {
            self.flush();
            return self.run_at_door(Command::Figure(figure), place);
        };
        let may_wait = self.batches && self.session.surfaces.are_plain();
        // Once one waits, the others wait with it, which are quicker alone.
        let figure = match may_wait
            && (!self.engine.areas.is_empty() || QueuedArea::gains(&figure, self.session.blend, ns))
        {
            true => match QueuedArea::of(figure, place) {
                Ok(area) => return self.enqueue_area(area, ns),
                Err(figure) => figure,
            },
            false => figure,
        };
        self.flush();
        match self.engine.draw_quick(self.session, &figure) {
            Ok(()) => self.yield_after(ns + READ_NS),
            Err(fault) => self.refuse(place, figure.verb(), fault),
        }
    }

    /// Queues an area, which has no reply, so that it is drawn together with others.
    fn enqueue_area(&mut self, area: QueuedArea, ns: u64) -> Flow {
        if self.engine.areas.is_empty() {
            self.flush();
        }
        self.areas_ns += ns;
        self.engine.areas.push(area);
        if self.areas_ns < MOST_AREAS_NS && self.engine.areas.len() < MOST_AREAS {
            return Flow::Continue;
        }
        match self.draw_areas() {
            Flow::Continue => self.yield_if_due(false),
            flow => flow,
        }
    }

    /// Draws the queued areas. Reports those that met a defect.
    #[inline(never)]
    fn draw_areas(&mut self) -> Flow {
        self.areas_ns = 0;
        let mut areas = std::mem::take(&mut self.engine.areas);
        let refused = self.engine.draw_areas(self.session, &areas);
        areas.clear();
        self.engine.areas = areas;
        let mut flow = Flow::Continue;
        for (place, verb, fault) in refused {
            flow = self.refuse(place, verb, fault);
        }
        flow
    }

    /// Yields if that is due after a figure of so many estimated nanoseconds. It has no reply.
    #[inline]
    fn yield_after(&mut self, ns: u64) -> Flow {
        self.unclocked_ns += ns;
        if self.unclocked_ns < CLOCKED_NS && self.budget.pace == Pace::Free {
            return Flow::Continue;
        }
        self.unclocked_ns = 0;
        self.yield_if_due(false)
    }

    /// Queues a small draw, so that it is drawn together with others. One that is not that small is
    /// drawn by itself.
    fn enqueue_draw(&mut self, drawing: Drawing, place: StreamPosition) -> Flow {
        let ns = self.engine.estimated_ns(&drawing);
        if ns > MOST_NS {
            self.draw_queued();
        }
        self.draws.push((drawing, place));
        self.draws_ns += ns;
        if self.draws_ns > MOST_NS || self.draws.len() >= MOST_DRAWS {
            self.draw_queued();
        }
        match self.suspended {
            Some(_) => Flow::Pause,
            None => self.yield_if_due(false),
        }
    }

    /// Draws the queued lines and draws, of which one kind is empty. Called before everything that
    /// is not one of them, and at the end.
    #[inline]
    pub(super) fn flush(&mut self) {
        if !self.lines.is_empty() {
            self.draw_lines();
        }
        if !self.engine.areas.is_empty() {
            // Like a queued draw that is refused, one that met a defect does not hold up what comes next.
            let _ = self.draw_areas();
        }
        self.draw_queued();
    }

    /// Draws the queued draws, and reports what they have to say, each at its place.
    #[inline]
    fn draw_queued(&mut self) {
        if !self.draws.is_empty() {
            self.draw_all_queued();
        }
    }

    #[inline(never)]
    fn draw_all_queued(&mut self) {
        let (drawings, places): (Vec<_>, Vec<_>) = self.draws.drain(..).unzip();
        self.draws_ns = 0;
        // What the running command has to say is reported after these, and it decides how the
        // stream goes on.
        let (remark, state) = (self.session.remark.take(), self.state);
        for ((result, own), place) in self.engine.draw_queued(self.session, drawings).into_iter().zip(places)
        {
            self.session.remark = own;
            let _ = self.after_part(result, place, "DRAW");
        }
        self.session.remark = remark;
        if self.suspended.is_none() {
            self.state = state;
        }
    }

    #[inline(never)]
    fn draw_lines(&mut self) {
        let lines = std::mem::take(&mut self.lines);
        // Lines are never refused; a defect is counted.
        let _ = self.engine.begin(self.session, Request::Lines(&lines), &mut self.out.replies);
        self.lines = lines;
        self.lines.clear();
        self.line_pixels = 0;
    }

    /// Runs a batch whose bytes are the decoder's.
    #[inline]
    fn run_batch(&mut self, request: Request<'_>) -> Result<Progress, Fault> {
        self.flush();
        self.engine.begin(self.session, request, &mut self.out.replies)
    }

    /// Counts a command that is not even a request.
    pub(super) fn count_refused(&mut self, is_pixelflut: bool) {
        self.engine.count_refused(self.session, is_pixelflut);
    }

    /// Reports an error, which has been counted already, to the audience.
    pub(super) fn refuse(&mut self, place: StreamPosition, verb: &str, fault: Fault) -> Flow {
        if self.session.reports_errors() {
            match self.session.audience {
                Audience::Connection => {
                    self.out.replies.extend_from_slice(format_fault(place, verb, &fault).as_bytes());
                    self.out.replies.push(b'\n');
                }
                Audience::Owner => {
                    let refused = CommandError { place, verb: verb.to_owned(), fault, raw_token: None };
                    self.out.notices.push(Notice::Refused(refused));
                }
            }
        }
        self.after_error()
    }

    /// Returns the stream's state after `flow`, which the decoder or a command returned.
    pub(super) fn state_after(&self, flow: Flow) -> StreamState {
        match (self.state, flow) {
            (StreamState::Ready, Flow::Stop) => StreamState::Ended,
            (state, _) => state,
        }
    }

    /// Runs a part of a command, and its job if that is small or must not be suspended.
    fn run_part(
        &mut self,
        part: impl FnOnce(&mut Engine, &mut Session, &mut Vec<u8>) -> Result<Progress, Fault>,
    ) -> Result<Progress, Fault> {
        let suspends = self.budget.suspends;
        let mut progress = part(self.engine, self.session, &mut self.out.replies)?;
        while let Progress::Job(job) = progress {
            if suspends && !job.is_small() {
                return Ok(Progress::Job(job));
            }
            let result = job.run_guarded(&CancelToken::default());
            progress = self.engine.apply(self.session, result, &mut self.out.replies)?;
        }
        Ok(progress)
    }

    /// Continues a command whose job is done, or which is in pieces.
    pub(super) fn resume(&mut self, resume: Resume, suspended: Suspended) -> Flow {
        let Suspended { place, verb, pieces } = suspended;
        let budget = self.budget;
        let progress = self.run_part(|engine, session, replies| match (resume, pieces) {
            (Resume::Job(result), _) => engine.apply(session, result, replies),
            (Resume::Pieces, Some(pieces)) => engine.run_pieces(session, *pieces, replies, budget),
            (Resume::Pieces, None) => Ok(Progress::Done(Effect::Done)),
        });
        self.after_part(progress, place, verb)
    }

    /// Runs a command, or the first pieces of a long one.
    fn run_command(&mut self, command: Command) -> Result<Progress, Fault> {
        let budget = self.budget;
        self.run_part(|engine, session, replies| {
            match engine.begin(session, Request::Command(command), replies)? {
                Progress::Pieces(pieces) if pieces.runs_at_once() => {
                    engine.run_pieces(session, *pieces, replies, budget)
                }
                progress => Ok(progress),
            }
        })
    }

    /// Runs a command that is no batch and no quick figure.
    fn run_at_door(&mut self, command: Command, place: StreamPosition) -> Flow {
        if self.session.is_unread && command.only_answers() {
            return self.yield_if_due(false);
        }
        let verb = command.verb();
        let may_wait = self.batches && self.engine.leaves_draws_waiting(self.session, &command);
        if !(may_wait && self.lines.is_empty() && self.engine.areas.is_empty()) {
            self.flush();
        }
        if matches!(command, Command::Stats) {
            // Counts the bytes up to this command; those behind it are not decoded yet.
            self.session.stats.bytes = self.session.stats.bytes.max(place.byte);
        }
        let progress = self.run_command(command);
        if let Ok(Progress::Queued(drawing)) = progress {
            return self.enqueue_draw(drawing, place);
        }
        if progress.is_err() || self.session.remark.is_some() {
            // What the draws before it have to say is said before.
            self.draw_queued();
        }
        // The payload of a refused command has been dropped, and a command without a job does not
        // hold any.
        self.session.payload_held = None;
        self.after_part(progress, place, verb)
    }

    /// Reports the warnings and the result of a command, or suspends the stream if a job or pieces
    /// are left.
    fn after_part(
        &mut self,
        progress: Result<Progress, Fault>,
        place: StreamPosition,
        verb: &'static str,
    ) -> Flow {
        if !self.session.warnings.is_empty() {
            let warnings = self.session.warnings.drain(..).map(Notice::Warning);
            match self.session.audience {
                Audience::Owner => self.out.notices.extend(warnings),
                // A connection is not sent warnings.
                Audience::Connection => drop(warnings),
            }
        }
        if let Some(text) = self.session.remark.take() {
            match self.session.audience {
                Audience::Owner => self.out.notices.push(Notice::Remark { place, verb, text }),
                Audience::Connection => {
                    let line = format!("WARN {} {} {verb}: {text}\n", place.line, place.byte);
                    self.out.replies.extend_from_slice(line.as_bytes());
                }
            }
        }
        match progress {
            Ok(Progress::Done(effect)) => self.after(Ok(effect), place, verb),
            Err(fault) => self.after(Err(fault), place, verb),
            Ok(Progress::Job(job)) => {
                self.out.job = Some(job);
                self.suspended = Some(Suspended { place, verb, pieces: None });
                self.state = StreamState::Works;
                Flow::Pause
            }
            Ok(Progress::Queued(drawing)) => self.enqueue_draw(drawing, place),
            Ok(Progress::Pieces(pieces)) => {
                self.suspended = Some(Suspended { place, verb, pieces: Some(pieces) });
                self.state = StreamState::InPieces;
                Flow::Pause
            }
        }
    }

    fn after_error(&mut self) -> Flow {
        match self.session.closes_on_error() {
            true => {
                self.state = StreamState::Ended;
                Flow::Stop
            }
            false => self.yield_if_due(false),
        }
    }

    fn yield_if_due(&mut self, has_presented: bool) -> Flow {
        let is_due = match self.budget.pace {
            Pace::OneCommand => true,
            Pace::OneFrame => has_presented,
            Pace::Free => false,
        };
        let is_late = || self.budget.until.is_some_and(|until| Instant::now() >= until);
        if is_due || self.out.replies.len() >= self.budget.reply_bytes || is_late() {
            self.state = StreamState::Yields;
            return Flow::Pause;
        }
        Flow::Continue
    }

    fn after(&mut self, result: Result<Effect, Fault>, place: StreamPosition, verb: &'static str) -> Flow {
        let result = match result {
            Ok(Effect::Pause(_) | Effect::WaitShown(_)) if self.session.is_unread => Ok(Effect::Done),
            result => result,
        };
        match result {
            Ok(Effect::Done) => self.yield_if_due(verb == "PRESENT"),
            Ok(Effect::Quit) => {
                self.state = StreamState::Ended;
                Flow::Stop
            }
            Ok(Effect::Pause(time)) => {
                self.state = StreamState::Pauses(time);
                Flow::Pause
            }
            Ok(Effect::WaitShown(frame)) => {
                self.state = StreamState::WaitsFor(frame);
                Flow::Pause
            }
            Err(fault) => self.refuse(place, verb, fault),
        }
    }
}

impl Sink for CommandExecutor<'_> {
    /// Draws one pixel whose command was not in the plain form. Pixels are never refused; a defect
    /// is counted.
    fn pixel(&mut self, x: i32, y: i32, color: Rgba) {
        let _ = self.run_batch(Request::Pixel { x, y, color });
    }

    /// Draws the batches of pixels, which are most of all commands.
    fn pixels(&mut self, records: &[[u8; 8]]) {
        let _ = self.run_batch(Request::Pixels(records));
    }

    fn binary_pixels(&mut self, records: &[u8]) {
        let _ = self.run_batch(Request::BinaryPixels(records));
    }

    fn payload_held(&mut self, held: Reservation) {
        self.session.payload_held = Some(held);
    }

    fn figure(&mut self, figure: Figure, place: StreamPosition) -> Flow {
        self.draw_figure(figure, place)
    }

    fn command(&mut self, command: Command, place: StreamPosition) -> Flow {
        match command {
            Command::Figure(figure) if self.session.payload_held.is_none() => self.draw_figure(figure, place),
            command => self.run_at_door(command, place),
        }
    }

    fn error(&mut self, error: StreamError) -> Flow {
        self.flush();
        self.count_refused(error.is_pixelflut());
        let flow = match (self.session.reports_errors(), self.session.audience) {
            (true, Audience::Connection) => {
                // The error's own line is used, because its token may not be UTF-8.
                self.out.replies.extend_from_slice(error.wire_line().as_bytes());
                self.out.replies.push(b'\n');
                self.after_error()
            }
            _ => {
                let flow = self.refuse(error.place, &error.subject.name(), Fault::from(&error));
                if std::str::from_utf8(&error.token).is_err()
                    && let Some(Notice::Refused(refused)) = self.out.notices.last_mut()
                    && refused.place == error.place
                {
                    refused.raw_token = Some(error.token);
                }
                flow
            }
        };
        match error.closes {
            true => {
                self.state = StreamState::Ended;
                Flow::Stop
            }
            false => flow,
        }
    }

    fn pixel_run(&mut self, x: u16, y: u16, rgba: &[u8], place: StreamPosition) -> Flow {
        let progress = self.run_batch(Request::PixelRun { x, y, rgba });
        self.after_part(progress, place, "PXMULTI")
    }

    fn blit(&mut self, rect: Rect, rgba: &[u8], place: StreamPosition) -> Flow {
        let progress = self.run_batch(Request::Blit { rect, rgba });
        self.after_part(progress, place, "BLIT")
    }

    fn points(&mut self, packed: &[u8], place: StreamPosition) -> Flow {
        let has_room = || self.engine.memory_budget().available() >= packed.len() as u64;
        if packed.len() > LONG_LIST_BYTES && self.budget.suspends && has_room() {
            return self.command(Command::Points { packed: packed.to_vec() }, place);
        }
        let progress = self.run_batch(Request::Points(packed));
        self.after_part(progress, place, "POINTS")
    }
}
