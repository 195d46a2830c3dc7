//! One connection's stream: its decoder and its session, run on the engine piece by piece.
//!
//! In: bytes as they come, cut anywhere, or typed commands. Out: replies in order, and beside them what the owner is to
//! know of errors. It can be told to rest: after a time, after so many reply bytes, after one command.

use super::{Audience, Effect, Engine, Session};
use crate::command::{
    Command, Decoder, EndOfInput, Flow, Limits as StreamLimits, Place, Rect, Sink, StreamError, format_fault,
    format_play_error, format_play_fault,
};
use crate::draw2d::Line;
use crate::error::{Code, Fault};
use crate::memory::Rgba;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// A refused command, as its owner is told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Complaint {
    /// Where the command begins.
    pub place: Place,
    /// Its verb.
    pub verb: String,
    /// Why it was refused.
    pub fault: Fault,
    /// The token's bytes as they came, where they are no text.
    pub raw_token: Option<Vec<u8>>,
}

impl Complaint {
    /// `FILE:LINE: CODE VERB: message`, as `play` says it.
    pub fn play_line(&self, file: &str) -> String {
        match &self.raw_token {
            Some(token) => {
                let Fault { code, message, .. } = &self.fault;
                format_play_error(file, self.place, &self.verb, *code, message, Some(token))
            }
            None => format_play_fault(file, self.place, &self.verb, &self.fault),
        }
    }
}

/// What the owner of a stream is told beside the replies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Notice {
    /// A command was refused.
    Refused(Complaint),
    /// A file was read, and something in it skipped or put right.
    Warning(String),
}

/// What a stream answers.
#[derive(Debug, Default)]
pub struct Output {
    /// For the connection, in order.
    pub replies: Vec<u8>,
    /// For the owner.
    pub notices: Vec<Notice>,
}

/// When a stream is to rest.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// At this time at the latest, up to one command more.
    pub until: Option<Instant>,
    /// When this many reply bytes wait.
    pub reply_bytes: usize,
    /// After how much.
    pub pace: Pace,
}

/// How much a stream runs at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// As much as time allows.
    Free,
    /// One command, for stepping.
    OneCommand,
    /// Up to the next `PRESENT`, for stepping.
    OneFrame,
}

impl Budget {
    /// No rest.
    pub const NONE: Budget = Budget { until: None, reply_bytes: usize::MAX, pace: Pace::Free };
}

/// How a stream stands after a piece of it was run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Standing {
    /// It can go on.
    Ready,
    /// It can go on, and has had its share.
    Rests,
    /// It waits for this frame to be on the screen; then it is owed `FRAME n`.
    WaitsFor(u64),
    /// It is over: nothing more of it is run.
    Ended,
}

/// The stream of one connection.
pub struct Stream {
    decoder: Decoder,
    session: Session,
}

impl Stream {
    /// The stream of connection `id`, with the engine's payload limit.
    pub fn new(engine: &Engine, id: u64, audience: Audience) -> Self {
        let limits = StreamLimits { payload_bytes: engine.limits().payload_bytes };
        Stream { decoder: Decoder::with_spare(limits, engine.spare()), session: Session::new(id, audience) }
    }

    /// The session.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// The session, for the end of it.
    pub fn session_mut(&mut self) -> &mut Session {
        &mut self.session
    }

    /// Bytes held for a command that is not whole.
    pub fn pending_bytes(&self) -> usize {
        self.decoder.pending_bytes()
    }

    /// Runs what is whole in `bytes`, until the budget is used up. Answers how many bytes were taken.
    pub fn feed(
        &mut self,
        engine: &mut Engine,
        bytes: &[u8],
        out: &mut Output,
        budget: Budget,
    ) -> (usize, Standing) {
        let (mut used, mut standing) = (0, Standing::Ready);
        // Stepping shall end at the right pixel: those are not commands that can pause the decoder.
        let portion = if budget.pace == Pace::OneCommand { 1 } else { usize::MAX };
        while used < bytes.len() && standing == Standing::Ready {
            let piece = &bytes[used..used.saturating_add(portion).min(bytes.len())];
            let before = self.session.stats.commands;
            let mut runner = Runner::new(engine, &mut self.session, out, budget);
            runner.gathers_lines = budget.pace == Pace::Free;
            let (taken, flow) = self.decoder.feed_some(piece, &mut runner);
            runner.settle();
            standing = match (runner.standing, flow) {
                (Standing::Ready, Flow::Stop) => Standing::Ended,
                (standing, _) => standing,
            };
            used += taken;
            if portion == 1 && standing == Standing::Ready && self.session.stats.commands > before {
                standing = Standing::Rests;
            }
        }
        self.session.stats.bytes = self.decoder.place().byte;
        (used, standing)
    }

    /// Says that no more bytes come.
    pub fn finish(&mut self, engine: &mut Engine, end: EndOfInput, out: &mut Output) -> Standing {
        let mut runner = Runner::new(engine, &mut self.session, out, Budget::NONE);
        let _ = self.decoder.finish(end, &mut runner);
        runner.settle();
        match runner.standing {
            Standing::WaitsFor(frame) => Standing::WaitsFor(frame),
            _ => Standing::Ended,
        }
    }

    /// Runs one typed command, checked as the decoder would.
    pub fn run(
        &mut self,
        engine: &mut Engine,
        command: Command,
        out: &mut Output,
        budget: Budget,
    ) -> Standing {
        let place = Place { line: self.session.stats.commands + 1, byte: 0 };
        let checked = command.check();
        let mut runner = Runner::new(engine, &mut self.session, out, budget);
        let flow = match checked {
            Ok(()) => runner.command(command, place),
            Err(fault) => {
                runner.session.stats.commands += 1;
                runner.session.stats.errors += 1;
                runner.refuse(place, command.verb(), fault)
            }
        };
        match (runner.standing, flow) {
            (Standing::Ready, Flow::Stop) => Standing::Ended,
            (standing, _) => standing,
        }
    }
}

/// Runs what the decoder makes.
struct Runner<'a> {
    engine: &'a mut Engine,
    session: &'a mut Session,
    out: &'a mut Output,
    budget: Budget,
    standing: Standing,
    /// Text pixels whose places are on their way from memory, in order: the first `announced_len`.
    announced: [(usize, Rgba); ANNOUNCED],
    announced_len: usize,
    /// Text pixels that the session has not counted, on the frame and off it.
    uncounted: u64,
    uncounted_clipped: u64,
    /// Lines that follow each other, drawn together: all threads share a batch. None wait while pixels are announced.
    lines: Vec<Line>,
    gathers_lines: bool,
}

/// So many lines wait at most: some hundred microseconds of work.
const GATHERED_LINES: usize = 1024;

/// So many places are fetched at the same time.
const ANNOUNCED: usize = 32;

impl<'a> Runner<'a> {
    fn new(engine: &'a mut Engine, session: &'a mut Session, out: &'a mut Output, budget: Budget) -> Self {
        Runner {
            engine,
            session,
            out,
            budget,
            standing: Standing::Ready,
            announced: [(0, [0; 4]); ANNOUNCED],
            announced_len: 0,
            uncounted: 0,
            uncounted_clipped: 0,
            lines: Vec::new(),
            gathers_lines: false,
        }
    }

    /// Draws the lines that wait. They are counted already.
    #[inline(never)]
    fn draw_lines(&mut self) {
        let (engine, session, lines) = (&mut *self.engine, &*self.session, &self.lines);
        if catch_unwind(AssertUnwindSafe(|| engine.draw_lines(session, lines))).is_err() {
            // A defect of the server; the memory holds plain numbers, so any state of it is sound.
            self.session.stats.errors += 1;
        }
        self.lines.clear();
    }

    /// Takes a line that needs no answer: it is drawn with those around it.
    fn gather(&mut self, line: Line, command: &Command) -> Flow {
        self.store();
        self.engine.note_line(self.session, command);
        self.lines.push(line);
        if self.lines.len() >= GATHERED_LINES {
            self.draw_lines();
        }
        self.rest_if_due(false)
    }

    /// Stores the pixels that wait for their places.
    #[inline]
    fn store(&mut self) {
        let pixels = self.announced.get(..self.announced_len).unwrap_or(&[]);
        self.uncounted += pixels.len() as u64;
        self.engine.put_announced(pixels);
        self.announced_len = 0;
    }

    /// Brings the memory and the session's counters up to date: before anything but a plain text pixel, and at the end.
    fn settle(&mut self) {
        self.store();
        if !self.lines.is_empty() {
            self.draw_lines();
        }
        let (stored, clipped) =
            (std::mem::take(&mut self.uncounted), std::mem::take(&mut self.uncounted_clipped));
        self.session.stats.commands += stored + clipped;
        self.session.stats.pixels += stored;
        self.session.stats.clipped += clipped;
    }

    /// Tells the audience of a refusal, which is counted already.
    fn refuse(&mut self, place: Place, verb: &str, fault: Fault) -> Flow {
        if self.session.reports_errors() {
            match self.session.audience {
                Audience::Connection => {
                    self.out.replies.extend_from_slice(format_fault(place, verb, &fault).as_bytes());
                    self.out.replies.push(b'\n');
                }
                Audience::Owner => {
                    let complaint = Complaint { place, verb: verb.to_owned(), fault, raw_token: None };
                    self.out.notices.push(Notice::Refused(complaint));
                }
            }
        }
        self.after_error()
    }

    /// Runs a command; a panic in it, which is a defect, ends the command and not the server.
    fn run_guarded(&mut self, command: Command) -> Result<Effect, Fault> {
        let replies = self.out.replies.len();
        let run = AssertUnwindSafe(|| self.engine.run(self.session, command, &mut self.out.replies));
        // What the command had drawn stays drawn; memories hold plain numbers, so any state of them is sound.
        catch_unwind(run).unwrap_or_else(|_| {
            self.out.replies.truncate(replies);
            self.session.stats.errors += 1;
            Err(Fault::new(Code::Format, "this command met a defect of the server, and was given up"))
        })
    }

    fn after_error(&mut self) -> Flow {
        match self.session.closes_on_error() {
            true => {
                self.standing = Standing::Ended;
                Flow::Stop
            }
            false => self.rest_if_due(false),
        }
    }

    fn rest_if_due(&mut self, has_presented: bool) -> Flow {
        let is_due = match self.budget.pace {
            Pace::OneCommand => true,
            Pace::OneFrame => has_presented,
            Pace::Free => false,
        };
        let is_late = || self.budget.until.is_some_and(|until| Instant::now() >= until);
        if is_due || self.out.replies.len() >= self.budget.reply_bytes || is_late() {
            self.standing = Standing::Rests;
            return Flow::Pause;
        }
        Flow::Continue
    }

    fn after(&mut self, result: Result<Effect, Fault>, place: Place, verb: &'static str) -> Flow {
        match result {
            Ok(Effect::Done) => self.rest_if_due(verb == "PRESENT"),
            Ok(Effect::Quit) => {
                self.standing = Standing::Ended;
                Flow::Stop
            }
            Ok(Effect::WaitShown(frame)) => {
                self.standing = Standing::WaitsFor(frame);
                Flow::Pause
            }
            Err(fault) => self.refuse(place, verb, fault),
        }
    }
}

impl Sink for Runner<'_> {
    /// The hot one. Pixels at random places wait for memory, so many of them wait at the same time.
    #[inline(always)]
    fn pixel(&mut self, x: i32, y: i32, color: Rgba) {
        if !self.lines.is_empty() {
            self.draw_lines();
        }
        if !self.engine.stores_plainly(self.session) {
            return self.engine.put_pixel(self.session, x, y, color);
        }
        let Some(at) = self.engine.announce_pixel(self.session, x, y) else {
            self.uncounted_clipped += 1;
            return;
        };
        if let Some(next) = self.announced.get_mut(self.announced_len) {
            *next = (at, color);
        }
        self.announced_len += 1;
        if self.announced_len == ANNOUNCED {
            self.store();
        }
    }

    fn binary_pixels(&mut self, records: &[u8]) {
        self.settle();
        self.engine.put_binary_pixels(self.session, records);
    }

    fn command(&mut self, command: Command, place: Place) -> Flow {
        if let Command::Line { p0, p1, color } = command
            && self.gathers_lines
        {
            return self.gather(Line { p0, p1, color }, &command);
        }
        let verb = command.verb();
        self.settle();
        if matches!(command, Command::Stats) {
            // Up to this command; the rest of the piece is not decoded yet.
            self.session.stats.bytes = self.session.stats.bytes.max(place.byte);
        }
        let result = self.run_guarded(command);
        if !self.session.warnings.is_empty() {
            let warnings = self.session.warnings.drain(..).map(Notice::Warning);
            match self.session.audience {
                Audience::Owner => self.out.notices.extend(warnings),
                // A connection gets nothing unasked.
                Audience::Connection => drop(warnings),
            }
        }
        self.after(result, place, verb)
    }

    fn error(&mut self, error: StreamError) -> Flow {
        if !error.is_pixelflut() {
            self.session.has_used_other_verbs = true;
        }
        self.session.stats.commands += 1;
        self.session.stats.errors += 1;
        let flow = match (self.session.reports_errors(), self.session.audience) {
            (true, Audience::Connection) => {
                // The error's own line: its token may be no text.
                self.out.replies.extend_from_slice(error.wire_line().as_bytes());
                self.out.replies.push(b'\n');
                self.after_error()
            }
            _ => {
                let flow = self.refuse(error.place, &error.subject.name(), Fault::from(&error));
                if std::str::from_utf8(&error.token).is_err()
                    && let Some(Notice::Refused(complaint)) = self.out.notices.last_mut()
                    && complaint.place == error.place
                {
                    complaint.raw_token = Some(error.token);
                }
                flow
            }
        };
        match error.closes {
            true => {
                self.standing = Standing::Ended;
                Flow::Stop
            }
            false => flow,
        }
    }

    fn pixel_run(&mut self, x: u16, y: u16, rgba: &[u8], place: Place) -> Flow {
        self.settle();
        let result = self.engine.put_pixel_run(self.session, x, y, rgba);
        self.after(result.map(|()| Effect::Done), place, "PXMULTI")
    }

    fn blit(&mut self, rect: Rect, rgba: &[u8], place: Place) -> Flow {
        self.settle();
        let result = self.engine.put_blit(self.session, rect, rgba);
        self.after(result.map(|()| Effect::Done), place, "BLIT")
    }

    fn points(&mut self, packed: &[u8], place: Place) -> Flow {
        self.settle();
        let result = self.engine.put_points(self.session, packed);
        self.after(result.map(|()| Effect::Done), place, "POINTS")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn play(script: &[u8], pieces: usize, audience: Audience) -> (Engine, Output) {
        let mut engine = Engine::new(16, 8).unwrap();
        let mut stream = Stream::new(&engine, 1, audience);
        let mut out = Output::default();
        for piece in script.chunks(pieces) {
            let (used, standing) = stream.feed(&mut engine, piece, &mut out, Budget::NONE);
            if standing == Standing::Ended {
                return (engine, out);
            }
            assert_eq!((used, standing), (piece.len(), Standing::Ready));
        }
        let _ = stream.finish(&mut engine, EndOfInput::Stream, &mut out);
        (engine, out)
    }

    #[test]
    fn any_size_of_pieces_gives_the_same_answers() {
        let mut script = b"PX 1 1 ff0000\nOFFSET 2 2\nPX 1 1 00ff00\nPX 1 1\nLINE 0 0 9 5 0000ff\n".to_vec();
        script
            .extend_from_slice(b"PB\x05\x00\x06\x00abcdPXMULTI\x0e\x00\x00\x00\x03\x00\x00\x00123456789abc");
        script.extend_from_slice(b"BLIT 3 3 2 1 :8\n\nBLIT\n1\nCRC\nWHAT 1\nBLIT 1 1 :5\nPX 1\nSYNC end\n");
        let (_, whole) = play(&script, script.len(), Audience::Connection);
        let text = String::from_utf8_lossy(&whole.replies).into_owned();
        assert!(text.starts_with("PX 1 1 00ff00\nCRC "), "{text}");
        assert!(
            text.ends_with("SYNC end\n") && text.contains("EVERB WHAT") && text.contains("EARGS BLIT"),
            "{text}"
        );
        for pieces in 1..script.len() {
            assert_eq!(
                play(&script, pieces, Audience::Connection).1.replies,
                whole.replies,
                "pieces of {pieces}"
            );
        }
    }

    #[test]
    fn lines_drawn_together_are_drawn_in_their_turn() {
        let mut script = String::new();
        let mut state = 9u32;
        let mut next = |n: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % n
        };
        for i in 0..6000 {
            let [a, b, c, d] = [300, 200, 300, 200].map(&mut next);
            let color = next(1 << 24);
            script += &match i % 997 {
                3 => format!("PX {a} {b} {color:06x}\n"),
                8 => "BLEND over\n".to_owned(),
                500 => "BLEND replace\n".to_owned(),
                600 => format!("FILLRECT {a} {b} 30 20 {color:06x}80\n"),
                700 => "LINE 1 2\n".to_owned(),
                800 => "CRC\n".to_owned(),
                _ => format!("LINE {a} {b} {c} {d} {color:06x}7f\n"),
            };
        }
        script += "CRC\nSTATS\n";
        let run = |threads: usize, pieces: usize, pace: Pace| {
            let mut engine = Engine::new(280, 190).unwrap();
            let pool = crate::server::worker_pool(Some(threads));
            let options = crate::pipeline::RenderOptions { pool, ..Default::default() };
            engine.set_renderer(crate::pipeline::Renderer::new(options));
            let mut stream = Stream::new(&engine, 1, Audience::Connection);
            let mut out = Output::default();
            for piece in script.as_bytes().chunks(pieces) {
                let mut used = 0;
                while used < piece.len() {
                    let budget = Budget { pace, ..Budget::NONE };
                    used += stream.feed(&mut engine, &piece[used..], &mut out, budget).0;
                }
            }
            String::from_utf8(out.replies).unwrap()
        };
        let one_by_one = run(1, 1000, Pace::OneCommand);
        assert!(one_by_one.matches("CRC").count() == 7, "{one_by_one}");
        for (threads, pieces) in [(1, usize::MAX), (2, usize::MAX), (3, 65_536), (2, 999)] {
            assert_eq!(run(threads, pieces, Pace::Free), one_by_one, "{threads} threads, pieces of {pieces}");
        }
    }

    #[test]
    fn a_pixelflut_connection_hears_nothing_unasked_until_it_uses_more() {
        let quiet = b"PX 1 1 zz\nNOPE\nPX 1\nSIZE 3\nPX 99 99\n";
        assert_eq!(play(quiet, 5, Audience::Connection).1.replies, b"");
        let (_, out) = play(b"NOPE\nCRC 1\nNOPE\n", 5, Audience::Connection);
        let text = String::from_utf8(out.replies).unwrap();
        assert_eq!(text.lines().count(), 2, "{text}");
        assert!(text.starts_with("ERR 2 5 EARGS CRC: "), "{text}");
        let (_, out) = play(b"ERRORS count\nLINE 1\nNOPE\n", 5, Audience::Connection);
        assert_eq!(out.replies, b"");
        let (_, out) = play(b"NOPE\nPX 1\n", 5, Audience::Owner);
        assert_eq!(out.notices.len(), 2, "the player always hears");
        let (_, out) = play(b"PX 1 2 \xff\"\n", 5, Audience::Owner);
        let [Notice::Refused(complaint)] = &out.notices[..] else { panic!("{:?}", out.notices) };
        assert!(complaint.play_line("f").ends_with(", got \"\\xff\\x22\""), "{}", complaint.play_line("f"));
    }

    #[test]
    fn errors_close_runs_nothing_after_the_error() {
        let (engine, out) = play(b"ERRORS close\nNOPE\nPX 1 1 ff0000\nSIZE\n", 400, Audience::Connection);
        let text = String::from_utf8(out.replies).unwrap();
        assert_eq!(text, "ERR 2 13 EVERB NOPE: unknown verb, got \"NOPE\"\n");
        assert_eq!(engine.memory().get_pixel(1, 1).unwrap(), [0, 0, 0, 255]);
    }

    #[test]
    fn half_a_command_leaves_no_trace() {
        let script = b"FILLRECT 0 0 4 4 ff0000\nBLIT 0 0 2 2 :16\n0123456789abcdef";
        for cut in 0..script.len() {
            let (engine, _) = play(&script[..cut], 1000, Audience::Connection);
            let first = engine.memory().get_pixel(0, 0).unwrap();
            let want = if cut < 24 { [0, 0, 0, 255] } else { [255, 0, 0, 255] };
            assert_eq!(first, want, "cut at {cut}");
        }
    }

    #[test]
    fn a_stream_rests_when_its_budget_is_used_up() {
        let mut engine = Engine::new(16, 8).unwrap();
        let mut stream = Stream::new(&engine, 1, Audience::Connection);
        let mut out = Output::default();
        let script = b"SYNC a\nSYNC b\nPX 1 1 ff0000\nPX 2 2 ff0000\nPRESENT\nSYNC c\n";
        let few = Budget { reply_bytes: 3, ..Budget::NONE };
        assert_eq!(stream.feed(&mut engine, script, &mut out, few), (7, Standing::Rests));
        let step = Budget { pace: Pace::OneCommand, ..Budget::NONE };
        assert_eq!(stream.feed(&mut engine, &script[7..], &mut out, step), (7, Standing::Rests));
        assert_eq!(stream.feed(&mut engine, &script[14..], &mut out, step), (14, Standing::Rests));
        assert_eq!(engine.memory().get_pixel(2, 2).unwrap(), [0, 0, 0, 255]);
        let frame = Budget { pace: Pace::OneFrame, ..Budget::NONE };
        assert_eq!(stream.feed(&mut engine, &script[28..], &mut out, frame), (22, Standing::Rests));
        assert_eq!(engine.frames(), 1);
    }
}
